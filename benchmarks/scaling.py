"""Sizes, poses out of reach, cores."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import clocks
import grids
import numpy as np
from page import Page, mebibytes, micro, report, table

import kinetostatics as ks

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
    values = [dropped["cpu"] for dropped, _ in found]
    spread = max(values) / min(values)
    span = f"from {found[0][0]['poses']:,} to {found[-1][0]['poses']:,} poses"
    said = f"{micro(min(values))} … {micro(max(values))} µs, {spread:.2f} times"
    page.require(f"cost per pose of a batch {span}", "the same (≤ 1.2 times)", said, spread <= 1.2)
    peak = found[-1][1]["memory"] / GIB
    page.require(f"memory of a map of {found[-1][0]['poses']:,} poses, stored", "< 2 GiB", f"{peak:.2f} GiB", peak < 2)
    dropped, stored = found[0]
    once = (stored["cpu"] - dropped["cpu"]) * dropped["poses"]
    head = ("poses", "dropped", "by the clock", "stored", "by the clock", "memory", "file")
    page.add("sizes", table(head, rows), f"Making and opening a file takes {once:.2f} s in any case.")


def _alone(function: Callable[..., dict[str, float]], *arguments: object) -> dict[str, float]:
    """Call a function in a process of its own, so that its memory can be told."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


# ---- poses out of reach ----------------------------------------------------------------------------------------------------


def measure_reach(name: str, poses: int, repeats: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return times per pose [s], and which part of a grid whose corners are out of reach and of scattered poses is missing.

    Measured are a grid that ends inside the reach of a robot, and one of as many poses that ends outside, with and without those
    that are; and poses in random order, all reached, and 1 % of them somewhere far outside.
    """
    robot, edge = grids.load(name), grids.EDGES[name]
    near, beyond = (grids.WORKSPACES[name].within(**ends) for ends in (edge.inside, edge.outside))
    axes, further = near.axes(poses), beyond.axes(poses)
    inside, outside = grids.mesh(axes), grids.mesh(further)
    size = count_of(axes)
    random = np.random.default_rng(0)
    order = random.permutation(size)
    reached = grids.assemble(robot, beyond, outside).reached
    without = {key: value.ravel()[reached.ravel()] for key, value in outside.items()}
    scattered = {key: value.ravel()[order] for key, value in inside.items()}
    missing = {key: value.copy() for key, value in scattered.items()}
    gone = random.choice(size, size // 100, replace=False)
    for key, value in edge.far.items():
        missing[key][gone] = value
    batches = {"inside": inside, "outside": outside, "without": without, "scattered": scattered, "missing": missing}
    runs: dict[str, Callable[[], object]] = {
        key: partial(grids.whole, robot, near, coordinates) for key, coordinates in batches.items()
    }
    runs["inside_swept"] = partial(grids.sweep, robot, near, axes)
    runs["outside_swept"] = partial(grids.sweep, robot, beyond, further)
    best = clocks.interleaved(runs, repeats)
    parts = {
        key: float(np.mean(grids.assemble(robot, near, coordinates).status == ks.Status.UNREACHABLE))
        for key, coordinates in batches.items()
    }
    if parts["inside"] or parts["scattered"]:
        raise RuntimeError(f"{name}: some poses of the grid inside are out of reach")
    return {key: value / size for key, value in best.items()}, parts


def reach(page: Page, edges: tuple[str, ...], poses: int, repeats: int) -> None:
    """Poses out of reach."""
    found = {name: measure_reach(name, poses, repeats) for name in edges}
    rows = []
    for what, before, after in (
        ("corners of the grid", "without", "outside"),
        ("corners, beside a smaller grid", "inside", "outside"),
        ("corners, beside a smaller grid, `ks.sweep`", "inside_swept", "outside_swept"),
        ("scattered", "scattered", "missing"),
    ):
        more = {name: best[after] / best[before] - 1 for name, (best, _) in found.items()}
        for name, (best, parts) in found.items():
            share = f"{100 * parts[after.removesuffix('_swept')]:.1f} %"
            rows.append((f"`{name}`, {what}", share, micro(best[before]), micro(best[after]), f"{100 * more[name]:+.0f} %"))
        if what != "corners, beside a smaller grid":
            said = ", ".join(f"{100 * value:+.0f} % (`{name}`)" for name, value in more.items())
            page.require(f"1 % of the poses out of reach, {what}", "< +10 % of time", said, max(more.values()) < 0.1)
    page.add("reach", table(("", "out of reach", "none", "some", "more"), rows))


# ---- cores -----------------------------------------------------------------------------------------------------------------


_mine = threading.local()


def compute(name: str, axes: dict[str, Any]) -> int:
    """Compute a part of a grid with a robot of this thread's own, and drop the numbers."""
    if not hasattr(_mine, "robot"):
        _mine.robot = grids.load(name)
    return int(grids.whole(_mine.robot, grids.WORKSPACES[name], grids.mesh(axes)).status.size)


def spin(_: str, axes: dict[str, Any]) -> int:
    """Keep a core busy for as long as that would, without needing memory."""
    return sum(k & 7 for k in range(150 * count_of(axes)))


def cores(page: Page, name: str, poses: int, repeats: int) -> None:
    """One and two threads, processes, workers of ``ks.sweep`` and of Dask, and a loop that only counts.

    Times of larger maps, beside which starting processes is little, are for as many poses as the others have.
    """
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes = workspace.axes(poses)
    first, size = next(iter(axes)), count_of(axes)
    step = max(1, -(-len(axes[first]) // 12))
    parts = slabs(axes, step)
    rows = []

    def pair(what: str, run: Callable[[Any], object], one: Any, two: Any, scale: float = 1.0) -> float:
        found = clocks.interleaved({"one": partial(run, one), "two": partial(run, two)}, repeats, time.perf_counter)
        costs = [found[key] * scale / size for key in ("one", "two")]
        rows.append((what, *map(micro, costs), f"{costs[0] / costs[1]:.2f}"))
        return costs[0]

    def spread(work: Callable[[str, dict[str, Any]], int], pool: Executor) -> object:
        return sum(pool.map(work, [name] * len(parts), parts))

    spawn = get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as one, ProcessPoolExecutor(2, mp_context=spawn) as two:
        pair("a loop that only counts, in processes", partial(spread, spin), one, two)
        pair("processes, numbers dropped", partial(spread, compute), one, two)
    with ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:
        pair("threads, numbers dropped", partial(spread, compute), single, double)
    with tempfile.TemporaryDirectory(dir=HERE.parent) as folder:
        for grid in (axes, workspace.axes(10 * poses)):
            count = count_of(grid)

            def swept(workers: int, grid: dict[str, Any] = grid) -> None:
                grids.sweep(robot, workspace, grid, workers=workers).close()

            def stored(workers: int, grid: dict[str, Any] = grid) -> None:
                grids.sweep(robot, workspace, grid, workers=workers, out=f"{folder}/{workers}.nc", restart=True).close()

            pair(f"`ks.sweep(workers=…)`, in memory, {count:,} poses", swept, 1, 2, size / count)
            pair(f"`ks.sweep(workers=…, out=…)`, on disk, {count:,} poses", stored, 1, 2, size / count)
    with _dask(1) as alone, _dask(2) as both:
        lazy = grids.sweep(robot, workspace, axes, workers=None, chunks={first: step})
        largest = abs(lazy["twist"]).max()
        what = "`ks.sweep(chunks=…)`, largest twist by Dask's processes"
        each = pair(what, lambda client: client.compute(largest, sync=True), alone, both)
    bytes_each = lazy.nbytes / size
    hours, tasks = each * 1e9 / 3600, 2 * 1e9 / 20_000
    scheduling = tasks * 1e-3
    paper = f"""\
**1e9 poses, on paper.** A pose has {bytes_each:,.0f} bytes in a map, all of them {bytes_each / 1e3:.1f} TB: not to be
stored, but to be reduced to indices where they are computed, as in the last row. With its {micro(each)} µs a pose and worker,
chunks of 20,000 poses, and nothing to be exchanged between them, 1e9 poses take {hours:.1f} hours of one core,
{60 * hours / 64:.0f} minutes of 64, and {3.6 * hours:.0f} seconds of 1,000 if the rest keeps up. It would not: Dask's scheduler
needs something like a millisecond a task, which for {tasks:,.0f} tasks are {scheduling:.0f} seconds. With more than some
{3600 * hours / scheduling:.0f} cores, chunks should be larger, or several sweeps be made side by side."""
    page.add("cores", table((f"{size:,} poses of `{name}`", "1 worker", "2 workers", "gain"), rows), paper)


@contextmanager
def _dask(workers: int) -> Iterator[Any]:
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0", silence_logs=40) as cluster:
        with Client(cluster, set_as_default=False) as client:
            yield client
