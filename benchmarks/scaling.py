"""Maps of few and of many poses."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import clocks
import grids
import numpy as np
from page import Page, mebibytes, micro, report, table

HERE = Path(__file__).resolve().parent
GIB = 2**30
#: Poses that are computed at once when their numbers are dropped.
AT_ONCE = 110_000


def count_of(axes: dict[str, Any]) -> int:
    """Return the number of poses of a grid."""
    return int(np.prod([len(values) for values in axes.values()]))


def slabs(axes: dict[str, Any], step: int) -> list[dict[str, Any]]:
    """Return a grid in parts of so many values along its first axis."""
    first = next(iter(axes))
    return [{**axes, first: axes[first][start : start + step]} for start in range(0, len(axes[first]), step)]


# ---- sizes and memory ------------------------------------------------------------------------------------------------------


def one_map(name: str, poses: int, repeats: int, folder: str | None) -> dict[str, float]:
    """Return what a map takes per pose [s], with the memory of this process and the size of the file [bytes].

    Args:
        name: of the robot.
        poses: of the grid.
        repeats: how often it is measured.
        folder: for the file; None: the numbers are dropped.
    """
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes, small = workspace.axes(poses), workspace.axes(300)
    size = count_of(axes)
    path = Path(folder) / "map.nc" if folder else None

    def run(axes: dict[str, Any]) -> None:
        if path is not None:
            path.unlink(missing_ok=True)  # a map that is there already is looked at first
            grids.sweep(robot, workspace, axes, out=path).close()
            return
        for slab in slabs(axes, max(1, AT_ONCE * len(next(iter(axes.values()))) // size)):
            grids.whole(robot, workspace, grids.mesh(slab))

    run(small)
    found = {"poses": size, "cpu": float("inf"), "wall": float("inf")}
    for _ in range(repeats):
        cpu, wall = clocks.cpu(), time.perf_counter()
        run(axes)
        found["cpu"] = min(found["cpu"], (clocks.cpu() - cpu) / size)
        found["wall"] = min(found["wall"], (time.perf_counter() - wall) / size)
    return {**found, "memory": clocks.peak_memory(), "file": path.stat().st_size if path else 0}


def sizes(page: Page, sizes: tuple[tuple[int, int], ...]) -> None:
    """From few poses to many: maps of the 3RPS in processes of their own, each with so many poses and repeats."""
    rows, found = [], []
    for poses, repeats in sizes:
        with tempfile.TemporaryDirectory(dir=HERE.parent) as folder:
            dropped, stored = (_alone(one_map, "3rps", poses, repeats, place) for place in (None, folder))
        found.append((dropped, stored))
        costs = [micro(item[clock]) for item in (dropped, stored) for clock in ("cpu", "wall")]
        rows.append((f"{dropped['poses']:,}", *costs, mebibytes(stored["memory"]), mebibytes(stored["file"])))
        report(f"3rps, {dropped['poses']:,} poses: {costs[0]} µs dropped, {costs[2]} µs stored")
    dropped, stored = found[0]
    once = (stored["cpu"] - dropped["cpu"]) * dropped["poses"]
    head = ("poses", "dropped", "by the clock", "stored", "by the clock", "memory", "file")
    page.add("sizes", table(head, rows), f"Creating and opening a file takes {once:.2f} s at any size.")


def _alone(function: Callable[..., dict[str, float]], *arguments: object) -> dict[str, float]:
    """Call a function in a process of its own, so that its memory can be told."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()
