"""``sweep``: reads what is asked for, has it computed, and returns or stores the Dataset."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.argument_checks import path_name
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting
from kinetostatics.robot import Robot
from kinetostatics.workspace import provenance
from kinetostatics.workspace.arguments import need, read_plan, try_plan, try_robots
from kinetostatics.workspace.assembly_modes.repair import Finished
from kinetostatics.workspace.capacity import check_disk, check_memory
from kinetostatics.workspace.grid import Block, block_sizes, cut, shape_of
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.process_pool import Crew
from kinetostatics.workspace.progress import Bar, wants_bar
from kinetostatics.workspace.schema import ZERO_MODE, Labels, check_names, labels_of, template
from kinetostatics.workspace.storage import Storage, open_map, store_of
from kinetostatics.workspace.targets import Memory, NetCDF, Target, Zarr, joint_state, patch, write_block
from kinetostatics.workspace.tasks import BlockTask, FinishTask, Task, perform, read_part

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.description.robot import RobotDescription

#: Poses of a block, at most; with beams or ways, whose numbers are many, fewer.
BLOCK, BLOCK_OF_MORE = 32_000, 2000
#: Blocks that every worker should have, so that none waits long for the last.
SHARE = 4
#: A smaller sweep is done before other processes have started.
ALONE = 50_000
#: Joint coordinates of one robot that are looked at together a second time: numbers that must be in memory, 130 MB.
REGION = 2**24
#: What is done, in the words of the progress bar.
COMPUTING, COMPARING = "computing", "comparing neighbours"


def sweep(
    robot: Robot | RobotDescription | str | os.PathLike[str],
    platform: Mapping[str, ArrayLike] | None = None,
    actuators: Mapping[str, ArrayLike] | None = None,
    *,
    orientation: str | None = None,
    load: Any = (0, 0, 0, 0, 0, 0),
    gravity: Any = (0, 0, -9.81),
    point: Any = None,
    frame: str = "world",
    misfits: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    parameter_units: Mapping[str, str] | None = None,
    beams: bool = False,
    ways: bool = False,
    tolerance: float = 1e-10,
    out: str | os.PathLike[str] | None = None,
    restart: bool = False,
    chunks: Mapping[str, int] | str | None = None,
    workers: int | None = None,
    progress: bool | None = None,
    command_line: Sequence[str] | None = None,
) -> xr.Dataset:
    """Analyze a robot on a grid of poses: the outer product of one-dimensional arrays.

    Args:
        robot: a robot; or its file, or the name of one that comes with the package, which ``parameters`` need.
        platform: platform coordinates by name, as :meth:`Robot.assemble` takes them [m, rad]: an array is a dimension of the
            grid, a number is the same at all poses.
        actuators: instead, coordinates of all drives.
        orientation: what the orientation coordinates mean, see :meth:`Robot.assemble`.
        load, gravity, point, frame, misfits: see :func:`kinetostatics.analyze`. Load, gravity and point may be an
            ``xarray.DataArray`` whose last dimension is ``component``: its other dimensions become dimensions of the grid, unless
            they are that already.
        parameters: values of the file's xacro arguments: an array is a dimension of the grid, a number or string is the same
            everywhere.
        parameter_units: SI units of parameters, such as ``{"rod_diameter": "m"}``, where the file does not tell them: it does if
            lengths, angles, masses, densities, moduli or stiffnesses change one for one with the parameter.
        beams: whether to add ``beam_stress``, ``beam_euler_ratio`` and ``beam_deflection``, which take most of the time then.
        ways: whether to add ``gravity_way`` and ``actuator_gravity_way``, how gravity acts (by the platform's weight, the limbs'
            attached wrenches, their deformation), and ``actuator_contribution``; it takes about twice as long.
        tolerance: how far loops may stay open [m, rad].
        out: a file ``….nc`` or ``….zarr`` to write to while it is computed, in bounded memory. If the sweep is interrupted, the
            same call goes on with it.
        restart: begin anew, whatever ``out`` holds.
        chunks: sizes along dimensions, ``{"z": 10}`` (others whole), or "auto": return a Dataset of dask arrays at once, whose
            chunks are computed when they are needed, by whatever scheduler dask has.
        workers: how many processes compute; None: as many as cores, or none but this one for a small sweep.
        progress: whether to show a bar on standard error; None: if that is a terminal, or in a notebook.
        command_line: what to say of the command in the attributes.

    Returns:
        The Dataset; ``docs/workspace.md`` says what is in it. With ``out`` it is read from there when needed.

    Raises:
        ArgumentError: an argument makes no sense, or ``out`` holds something else.
        CoordinatesError: coordinates are missing, unknown, or do not determine the pose.
        RobotFileError: the robot's file is wrong.
        KinetostaticsError: a package is missing; the message says how to install it.
    """
    need("xarray")
    if chunks is not None:
        need("dask", extra="dask")
        if out is not None:
            raise ArgumentError("give out= or chunks=: a Dataset of dask arrays is saved by its own to_netcdf and to_zarr")
    if out is not None:
        out = path_name("out", out)
        need(*store_of(os.fspath(out)).needs)
    with waiting("planning the sweep", wanted=wants_bar(progress)):
        plan, first = read_plan(
            robot,
            platform,
            actuators,
            orientation,
            load,
            gravity,
            point,
            frame,
            misfits,
            parameters,
            beams,
            tolerance,
            ways,
            parameter_units,
        )
        labels = labels_of(plan, first)
        try_plan(plan, first)
        check_names(plan, labels)
        attributes = provenance.attributes(plan, labels, first, command_line)
        if chunks is not None:
            from kinetostatics.workspace.dask_map import lazy_dataset

            return lazy_dataset(plan, labels, chunks).assign_attrs(attributes)
        number = _workers(workers, plan.size)
        try_robots(plan)
    if progress:
        need("tqdm")
    poses = max(1, min(BLOCK_OF_MORE if beams or ways else BLOCK, -(-plan.size // (SHARE * number if number > 1 else 1))))
    run = _Run(plan, labels, block_sizes(plan.axes, poses), number, attributes)
    if out is None:
        check_memory(plan, labels)
        return run.in_memory(progress)
    path = os.fspath(out)
    storage = Storage(path, plan, run.sizes, attributes, restart)
    if not storage.done:
        check_disk(plan, labels, storage.path, storage.folder)
        storage.begin()
        run.sizes = storage.sizes
        run.on_disk(storage, progress)
    return open_map(path)


def _workers(workers: int | None, size: int) -> int:
    if workers is None:
        return _cores() if size >= ALONE else 1
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise ArgumentError(f"workers is {workers!r}; it must be a number of processes, at least 1, or None")
    return int(workers)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# ---- computing -------------------------------------------------------------------------------------------------------


class _Run:
    """A sweep that is being computed."""

    def __init__(self, plan: Plan, labels: Labels, sizes: tuple[int, ...], workers: int, attributes: Mapping[str, Any]) -> None:
        self.plan, self.labels, self.sizes, self.workers = plan, labels, sizes, workers
        self.attributes = dict(attributes)

    @cached_property
    def template(self) -> xr.Dataset:
        """Everything but the numbers."""
        return template(self.plan, self.labels)

    def in_memory(self, progress: bool | None) -> xr.Dataset:
        """Return the whole Dataset."""
        target = Memory(self.plan, self.labels)
        blocks = list(cut(self.plan.shape, self.sizes))
        with ExitStack() as stack:
            crew = self._crew(stack, len(blocks))
            bar = stack.enter_context(Bar(progress, self.plan.size))
            bar.say(COMPUTING)
            for number, numbers in self._perform(crew, [BlockTask(block) for block in blocks]):
                write_block(target, self.plan, self.labels, blocks[number], numbers)
                bar.advance(_count(blocks[number]))
            self._finish(crew, target, bar)
        return target.dataset(self.template).assign_attrs(self.attributes)

    def on_disk(self, storage: Storage, progress: bool | None) -> None:
        """Compute what is not there yet, and store the whole."""
        with ExitStack() as stack:
            bar = stack.enter_context(Bar(progress, self.plan.size))
            bar.say("reading what is there")
            target = storage.open(self.template)
            missing = []
            for path, block, finished in storage.blocks():
                numbers = read_part(path) if finished else None
                if numbers is None:
                    missing.append((path, block))
                    continue
                write_block(target, self.plan, self.labels, block, numbers)
                bar.advance(_count(block), before=True)
            crew = self._crew(stack, len(missing))
            bar.say(COMPUTING)
            for number, numbers in self._perform(crew, [BlockTask(block, path) for path, block in missing]):
                path, block = missing[number]
                write_block(target, self.plan, self.labels, block, numbers or read_part(path) or {})
                bar.advance(_count(block))
            self._finish(crew, target, bar)
            bar.say("storing")
            target.close(self.attributes)
            storage.publish()

    def _crew(self, stack: ExitStack, pieces: int) -> Crew | None:
        workers = min(self.workers, pieces)
        return stack.enter_context(Crew(self.plan, self.labels, workers)) if workers > 1 else None

    def _perform(self, crew: Crew | None, tasks: Iterable[Task]) -> Iterator[tuple[int, Any]]:
        if crew is not None:
            yield from crew.perform(tasks)
            return
        for number, task in enumerate(tasks):
            yield number, perform(self.plan, self.labels, task)

    # ---- the second look --------------------------------------------------------------------------------------------

    def _finish(self, crew: Crew | None, target: Memory | NetCDF | Zarr, bar: Bar) -> None:
        """Look at the grid of every robot once more, and say in the attributes what came of it."""
        cases = tuple(slice(0, axis.size) for axis in self.plan.axes_of("case"))
        jobs = [(combination, region) for combination in self.plan.combinations() for region in self._regions()]
        found = {"mode_jumps": 0, "poses_of_other_modes": 0, "poses_by_neighbours": 0}
        sizes = tuple(size for size, axis in zip(self.sizes, self.plan.axes, strict=True) if axis.kind == "coordinate")
        bar.say(COMPARING)
        for count, (number, finished) in enumerate(self._look(crew, target, cases, jobs), 1):
            combination, region = jobs[number]
            patch(target, self.plan, self.labels, combination, cases, region, finished, sizes)
            found["mode_jumps"] += finished.jumps
            found["poses_of_other_modes"] += finished.retracted
            found["poses_by_neighbours"] += finished.gained
            if len(jobs) > 1:
                bar.add(f"{count} of {len(jobs)}")
        self.attributes.update(found)
        if found["mode_jumps"]:
            jumps = found["mode_jumps"]
            pairs = "1 pair of neighbours on the grid is" if jumps == 1 else f"{jumps} pairs of neighbours on the grid are"
            warnings.warn(
                f"{pairs} in different assembly modes; a finer grid tells them apart",
                UserWarning,
                stacklevel=4,
            )

    def _look(
        self, crew: Crew | None, target: Target, cases: Block, jobs: Sequence[tuple[Combination, Block]]
    ) -> Iterator[tuple[int, Finished]]:
        """Yield the number and the outcome of each look; one after the other where regions of a robot overlap."""

        def task(combination: Combination, region: Block) -> FinishTask:
            block = (*(slice(k, k + 1) for k in combination), *region)
            q, mode = joint_state(target, self.labels, block), target.read("mode", block)
            one = (0,) * len(combination)
            length = float(target.read("characteristic_length", block[: len(one)])[one])
            return FinishTask(combination, cases, region, q[one], mode[one] == ZERO_MODE, length)

        several = len(list(self._regions())) == 1 and len(jobs) > 1
        if crew is not None and several:
            yield from crew.perform(task(*job) for job in jobs)
            return
        for number, job in enumerate(jobs):
            yield number, perform(self.plan, self.labels, task(*job))  # type: ignore[misc]

    def _regions(self) -> Iterator[Block]:
        """Yield regions of the coordinate axes; each begins with the last layer of the one before."""
        axes = self.plan.axes_of("coordinate")
        shape = shape_of(axes)
        if not axes:
            yield ()
            return
        layer = max(1, int(np.prod(shape[1:])))
        thick = max(2, REGION // (layer * max(1, len(self.labels.q))))
        for start in range(0, shape[0], thick):
            yield (slice(max(0, start - 1), min(start + thick, shape[0])), *(slice(0, n) for n in shape[1:]))


def _count(block: Block) -> int:
    return int(np.prod([piece.stop - piece.start for piece in block]))
