"""Sizes, memory, unreachable poses, cores, and single poses."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import clocks
import grids
import numpy as np

import kinetostatics as ks

HERE = Path(__file__).resolve().parent
GIB = 2**30
DASK = "`ks.sweep(chunks=…)`, largest twist by Dask's processes"


# ---- sizes and memory ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Size:
    """A map of so many poses in a process of its own.

    Attributes:
        poses: of the grid.
        cpu, wall: per pose [s], of one process, in blocks of at most 100,000 poses, whose numbers are dropped.
        stored_cpu, stored_wall: of ``ks.sweep(…, out="map.nc")`` with one process, stored on disk.
        memory: largest resident memory of that process [bytes].
        file: size of the file [bytes].
    """

    poses: int
    cpu: float
    wall: float
    stored_cpu: float
    stored_wall: float
    memory: int
    file: int


def measure_size(name: str, poses: int, repeats: int) -> Size:
    """Measure one size."""
    dropped = _other_process("dropped", name, poses, repeats)
    with tempfile.TemporaryDirectory(dir=HERE.parent) as folder:
        stored = _other_process("stored", name, poses, repeats, folder)
    return Size(stored["poses"], dropped["cpu"], dropped["wall"], stored["cpu"], stored["wall"], stored["memory"], stored["file"])


def _other_process(*arguments: object) -> dict[str, Any]:
    command = [sys.executable, str(HERE / "one_map.py"), *map(str, arguments)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


# ---- poses out of reach ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reach:
    """Times per pose [s] with and without poses that are out of reach; ``corner`` and ``scattered``: which part of them is.

    ``outside_without`` is that of the grid of ``outside`` without the poses that are out of reach, in one row.
    ``…_swept`` are those of ``ks.sweep``, which tries unreachable poses from their neighbours and in other modes.
    """

    corner: float
    scattered: float
    inside: float
    outside: float
    outside_without: float
    all_reached: float
    some_missing: float
    inside_swept: float
    outside_swept: float


def measure_reach(name: str, poses: int, repeats: int) -> Reach:
    """Measure a grid that ends inside the reach of a robot, and one of as many poses that ends outside, with and without those
    that are; and poses in random order, all reached, and 1 % of them somewhere far outside.
    """
    robot, edge = grids.load(name), grids.EDGES[name]
    near = grids.WORKSPACES[name].within(**edge.inside)
    beyond = grids.WORKSPACES[name].within(**edge.outside)
    axes, further = near.axes(poses), beyond.axes(poses)
    inside, outside = grids.mesh(axes), grids.mesh(further)
    size = next(iter(inside.values())).size
    random = np.random.default_rng(0)
    order = random.permutation(size)
    reached = grids.assemble(robot, beyond, outside).reached
    without = {key: value.ravel()[reached.ravel()] for key, value in outside.items()}
    scattered = {key: value.ravel()[order] for key, value in inside.items()}
    missing = {key: value.copy() for key, value in scattered.items()}
    gone = random.choice(size, size // 100, replace=False)
    for key, value in edge.far.items():
        missing[key][gone] = value
    best = clocks.interleaved(
        {
            "inside": lambda: grids.whole(robot, near, inside),
            "outside": lambda: grids.whole(robot, beyond, outside),
            "outside_without": lambda: grids.whole(robot, beyond, without),
            "all_reached": lambda: grids.whole(robot, near, scattered),
            "some_missing": lambda: grids.whole(robot, near, missing),
            "inside_swept": lambda: grids.sweep(robot, near, axes),
            "outside_swept": lambda: grids.sweep(robot, beyond, further),
        },
        repeats,
    )

    def part(coordinates: dict[str, Any]) -> float:
        status = grids.assemble(robot, near, coordinates).status
        return float(np.mean(status == ks.Status.UNREACHABLE))

    if part(inside) or part(scattered):
        raise RuntimeError(f"{name}: some poses of the grid inside are out of reach")
    return Reach(part(outside), part(missing), **{key: value / size for key, value in best.items()})


# ---- cores -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cores:
    """How long so many poses take [s], by way of working and number of workers; and bytes that a pose has in a map."""

    poses: int
    wall: dict[str, tuple[float, float]]
    bytes_per_pose: float


_mine = threading.local()


def _slab(name: str, axes: dict[str, Any]) -> int:
    """Compute a part of a grid with a robot of this thread's own, and drop the numbers."""
    if not hasattr(_mine, "robot"):
        _mine.robot = grids.load(name)
    coordinates = grids.mesh(axes)
    return int(grids.whole(_mine.robot, grids.WORKSPACES[name], coordinates).status.size)


def _spin(_: str, axes: dict[str, Any]) -> int:
    """Keep a core busy for as long as a slab would, without needing memory."""
    total = 0
    for k in range(150 * int(np.prod([len(values) for values in axes.values()]))):
        total += k & 7
    return total


#: How many times more poses the larger maps of ``ks.sweep`` have, beside which starting processes is little.
MORE = 10


def measure_cores(name: str, poses: int, repeats: int) -> Cores:
    """Measure one and two threads, processes, workers of ``ks.sweep`` and of Dask, and a loop that only counts.

    Times of larger maps are for as many poses as the others have.
    """
    workspace = grids.WORKSPACES[name]
    axes = workspace.axes(poses)
    first = next(iter(axes))
    layers = len(axes[first])
    step = max(1, -(-layers // 12))
    slabs = [{**axes, first: axes[first][start : start + step]} for start in range(0, layers, step)]
    size = int(np.prod([len(values) for values in axes.values()]))
    spawn = get_context("spawn")
    wall: dict[str, tuple[float, float]] = {}

    def pair(one: Callable[[], object], two: Callable[[], object]) -> tuple[float, float]:
        found = clocks.interleaved({"one": one, "two": two}, repeats, time.perf_counter)
        return found["one"], found["two"]

    def spread(pool: Executor, work: Callable[[str, dict[str, Any]], int]) -> Callable[[], object]:
        return lambda: sum(pool.map(work, [name] * len(slabs), slabs))

    with ProcessPoolExecutor(1, mp_context=spawn) as one, ProcessPoolExecutor(2, mp_context=spawn) as two:
        wall["a loop that only counts, in processes"] = pair(spread(one, _spin), spread(two, _spin))
        wall["processes, numbers dropped"] = pair(spread(one, _slab), spread(two, _slab))
    with ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:
        wall["threads, numbers dropped"] = pair(spread(single, _slab), spread(double, _slab))
    robot = grids.load(name)
    with tempfile.TemporaryDirectory(dir=HERE.parent) as folder:
        for grid in (axes, workspace.axes(MORE * poses)):
            count = int(np.prod([len(values) for values in grid.values()]))

            def swept(workers: int, grid: dict[str, Any] = grid, **out: Any) -> None:
                grids.sweep(robot, workspace, grid, workers=workers, **out).close()

            def stored(workers: int, swept: Callable[..., None] = swept) -> None:
                swept(workers, out=f"{folder}/{workers}.nc", restart=True)

            for way, run in (("`ks.sweep(workers=…)`, in memory", swept), ("`ks.sweep(workers=…, out=…)`, on disk", stored)):
                one_worker, two_workers = pair(lambda run=run: run(1), lambda run=run: run(2))  # type: ignore[misc]
                wall[f"{way}, {count:,} poses"] = one_worker * size / count, two_workers * size / count
    with _dask(1) as alone, _dask(2) as both:
        lazy = grids.sweep(robot, workspace, axes, workers=None, chunks={first: step})
        largest = abs(lazy["twist"]).max()
        wall[DASK] = pair(lambda: alone.compute(largest, sync=True), lambda: both.compute(largest, sync=True))
    return Cores(size, wall, lazy.nbytes / size)


@contextmanager
def _dask(workers: int) -> Iterator[Any]:
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0", silence_logs=40) as cluster:
        with Client(cluster, set_as_default=False) as client:
            yield client


# ---- single poses ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Single:
    """Times [s] of one pose: its twist, all numbers of a map, all numbers of a result; and of the command, by the clock."""

    twist: float
    numbers: float
    everything: float
    command: float


def measure_single(name: str, repeats: int) -> Single:
    """Measure one pose of a robot, loops closed."""
    from speed import everything

    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    at = {key: low + 0.7 * (high - low) for key, (low, high) in workspace.box.items()}
    many = range(20)

    def twist() -> Any:
        return ks.analyze(grids.assemble(robot, workspace, at), grids.LOAD).twist

    best = clocks.interleaved(
        {
            "twist": lambda: [twist() for _ in many],
            "numbers": lambda: [grids.whole(robot, workspace, at) for _ in many],
            "everything": lambda: [everything(ks.analyze(grids.assemble(robot, workspace, at), grids.LOAD)) for _ in many],
        },
        repeats,
    )
    command = [sys.executable, "-m", "kinetostatics", "analyze", str(grids.ROBOTS / f"{name}.urdf.xacro")]
    whole = clocks.interleaved(
        {"command": lambda: subprocess.run(command, check=True, capture_output=True)}, repeats, time.perf_counter
    )
    return Single(*(best[key] / len(many) for key in ("twist", "numbers", "everything")), whole["command"])
