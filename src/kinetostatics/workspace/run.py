"""``sweep``: reads what is asked for, has it computed, and returns or stores the Dataset."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import cached_property, partial
from typing import TYPE_CHECKING, TypeVar

from numpy.typing import ArrayLike

from kinetostatics.argument_checks import path_name, warn, whole_number
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting
from kinetostatics.robot import Robot
from kinetostatics.workspace import provenance
from kinetostatics.workspace.arguments import need, read_sweep_spec, try_robots, try_sweep_spec
from kinetostatics.workspace.block import block_numbers, read_part
from kinetostatics.workspace.grid import Block, block_sizes, cut, sizes_of
from kinetostatics.workspace.process_pool import ProcessPool
from kinetostatics.workspace.progress import Bar, wants_bar
from kinetostatics.workspace.schema import Labels, check_names, labels_of, template
from kinetostatics.workspace.storage import Storage, check_disk, check_memory, open_map, store_of
from kinetostatics.workspace.sweep_spec import SweepSpec
from kinetostatics.workspace.targets import Target, in_memory

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.description.robot import RobotDescription

T = TypeVar("T")

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
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    point: ArrayLike | None = None,
    frame: str = "world",
    assembly_errors: Mapping[str, object] | None = None,
    loads: Mapping[str, object] | None = None,
    payload: Payload | None = None,
    parameters: Mapping[str, object] | None = None,
    parameter_units: Mapping[str, str] | None = None,
    platform_link: str | None = None,
    base_link: str | None = None,
    beams: bool = False,
    ways: bool = False,
    compensate: bool = False,
    outputs: Sequence[str] | None = None,
    closure_tolerance: float = 1e-10,
    engine: str = "auto",
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
        actuators: instead, coordinates of all actuators.
        orientation: what the orientation coordinates mean, see :meth:`Robot.assemble`.
        load: as :func:`kinetostatics.analyze` takes it. Load, gravity and point may be an ``xarray.DataArray`` whose last
            dimension is ``component``: its other dimensions become dimensions of the grid, unless they are that already.
        gravity: likewise.
        point: likewise.
        frame: as there.
        assembly_errors: as there.
        loads: on links, as there; the same at all poses.
        payload: as there; the same at all poses.
        parameters: values of the file's xacro arguments: an array is a dimension of the grid, a number or string is the same
            everywhere.
        parameter_units: SI units of parameters, such as ``{"rod_diameter": "m"}``, where the file does not tell them: it does if
            lengths, angles, masses, densities, moduli or stiffnesses change one for one with the parameter.
        platform_link, base_link: links of the file that are platform and base, as ``platform`` and ``base`` of
            :func:`kinetostatics.load_robot`.
        beams: whether to add ``beam_stress``, ``beam_euler_ratio`` and ``beam_deflection``, which take most of the time then.
        ways: whether to add ``gravity_way`` and ``actuator_gravity_way``, how gravity acts (by the platform's weight, the limbs'
            attached wrenches, their deformation), and ``actuator_contribution``; it takes about twice as long.
        compensate: whether to add ``actuator_correction`` and ``residual_error``: by how much to correct the actuators so that
            the loaded platform is where the grid wants it, and what is left then, see :func:`kinetostatics.compensate`; it takes
            several times as long. Of a grid of actuators those coordinates come out as wanted that tell best how the platform
            moves.
        outputs: names of the variables that are wanted, ``["twist", "beam_stress"]``: no other is computed and stored, not even
            ``buckles``, but for status, the facts that it tells, and the pose itself (``platform_pose``, ``q``). None: all.
            What ``beams``, ``ways`` and ``compensate`` add is there either way if they are true.
        closure_tolerance: how far loops may stay open [m, rad].
        engine: as :func:`kinetostatics.analyze` takes it; numbers differ by rounding only.
        out: a file ``….nc`` or ``….zarr`` to write to while it is computed, in bounded memory. If the sweep is interrupted, the
            same call goes on with it.
        restart: begin anew, whatever ``out`` holds.
        chunks: sizes along dimensions, ``{"z": 10}`` (others whole), or "auto": return a Dataset of dask arrays at once, whose
            chunks are computed when they are needed, by whatever scheduler dask has.
        workers: how many processes compute; None: as many as cores, or none but this one for a small sweep.
        progress: whether to show a bar on standard error; None: if that is a terminal, or in a notebook.
        command_line: what to say of the command in the attributes.

    Returns:
        The Dataset; the page on workspace maps says what is in it. With ``out`` it is read from there when needed.

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
        given = (
            platform,
            actuators,
            orientation,
            load,
            gravity,
            point,
            frame,
            assembly_errors,
            parameters,
            beams,
            closure_tolerance,
            ways,
        )
        links = {"platform": platform_link, "base": base_link}
        spec, first = read_sweep_spec(robot, *given, parameter_units, links, engine, compensate, loads, payload, outputs)
        labels = labels_of(spec, first)
        try_sweep_spec(spec, first)
        check_names(spec, labels)
        attributes = provenance.attributes(spec, labels, first, command_line)
        if chunks is not None:
            from kinetostatics.workspace.dask_map import lazy_dataset

            return lazy_dataset(spec, labels, chunks).assign_attrs(attributes)
        number = _workers(workers, spec.size)
        if number > 1:
            need("loky")
        try_robots(spec)
    if progress:
        need("tqdm")
    most = BLOCK_OF_MORE if spec.beams or spec.ways or spec.compensated else BLOCK
    poses = max(1, min(most, -(-spec.size // (SHARE * number if number > 1 else 1))))
    run = _Run(spec, labels, block_sizes(spec.axes, poses), number, attributes)
    if out is None:
        check_memory(spec, labels)
        return run.in_memory(progress)
    path = os.fspath(out)
    storage = Storage(path, spec, run.sizes, attributes, restart)
    if not storage.done:
        check_disk(spec, labels, storage.path, storage.folder)
        storage.begin()
        run.sizes = storage.sizes
        run.on_disk(storage, progress)
    return open_map(path)


def _workers(workers: int | None, size: int) -> int:
    if workers is None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return cores if size >= ALONE else 1
    return whole_number("workers", workers, 1)


# ---- computing -------------------------------------------------------------------------------------------------------


class _Run:
    """A sweep that is being computed."""

    def __init__(
        self, spec: SweepSpec, labels: Labels, sizes: tuple[int, ...], workers: int, attributes: Mapping[str, object]
    ) -> None:
        self.spec, self.labels, self.sizes, self.workers = spec, labels, sizes, workers
        self.attributes = dict(attributes)

    @cached_property
    def template(self) -> xr.Dataset:
        """Everything but the numbers."""
        return template(self.spec, self.labels)

    def in_memory(self, progress: bool | None) -> xr.Dataset:
        """Return the whole Dataset."""
        target = Target(self.spec, self.labels, in_memory(self.template))
        with Bar(progress, self.spec.size) as bar:
            self._compute(target, [(None, block) for block in cut(self.spec.shape, self.sizes)], bar)
        data = {name: (self.template[name].dims, array, self.template[name].attrs) for name, array in target.arrays.items()}
        return self.template.assign(data).assign_attrs(self.attributes)

    def on_disk(self, storage: Storage, progress: bool | None) -> None:
        """Compute what is not there yet, and store the whole."""
        with Bar(progress, self.spec.size) as bar:
            bar.say("reading what is there")
            arrays, close = storage.create(self.template)
            target = Target(self.spec, self.labels, arrays)
            missing = []
            for path, block, finished in storage.blocks():
                numbers = read_part(path) if finished else None
                if numbers is None:
                    missing.append((path, block))
                    continue
                target.write_block(block, numbers)
                bar.advance(math.prod(sizes_of(block)), before=True)
            self._compute(target, missing, bar)
            bar.say("storing")
            close(self.attributes)
            storage.publish()

    def _compute(self, target: Target, blocks: Sequence[tuple[str | None, Block]], bar: Bar) -> None:
        """Compute blocks, write those that have a path to files too, and look at the whole once more."""
        with ExitStack() as stack:
            workers = min(self.workers, len(blocks))
            pool = stack.enter_context(ProcessPool(self.spec, self.labels, workers)) if workers > 1 else None
            bar.say(COMPUTING)
            for number, numbers in self._perform(
                pool, (partial(block_numbers, block=block, path=path) for path, block in blocks)
            ):
                path, block = blocks[number]
                target.write_block(block, numbers or read_part(str(path)) or {})
                bar.advance(math.prod(sizes_of(block)))
            self._finish(pool, target, bar)

    def _perform(self, pool: ProcessPool | None, tasks: Iterable[partial[T]]) -> Iterator[tuple[int, T]]:
        if pool is not None:
            yield from pool.perform(tasks)
            return
        for number, task in enumerate(tasks):
            yield number, task(self.spec, self.labels)

    # ---- the second look --------------------------------------------------------------------------------------------

    def _finish(self, pool: ProcessPool | None, target: Target, bar: Bar) -> None:
        """Look at the grid of every robot once more, and say in the attributes what came of it."""
        cases = tuple(slice(0, axis.size) for axis in self.spec.axes_of("case"))
        regions = self._regions()
        jobs = [(combination, cases, region) for combination in self.spec.combinations() for region in regions]
        found = {"mode_jumps": 0, "poses_of_other_modes": 0, "poses_by_neighbours": 0}
        sizes = tuple(size for size, axis in zip(self.sizes, self.spec.axes, strict=True) if axis.kind == "coordinate")
        bar.say(COMPARING)
        # regions of one robot overlap, and so one waits for the other
        looks = self._perform(pool if len(regions) == 1 < len(jobs) else None, (target.to_finish(*job) for job in jobs))
        for count, (number, finished) in enumerate(looks, 1):
            target.patch(*jobs[number], finished, sizes)
            found["mode_jumps"] += finished.jumps
            found["poses_of_other_modes"] += finished.retracted
            found["poses_by_neighbours"] += finished.gained
            if len(jobs) > 1:
                bar.add(f"{count} of {len(jobs)}")
        self.attributes.update(found)
        if jumps := found["mode_jumps"]:
            pairs = "1 pair of neighbours on the grid is" if jumps == 1 else f"{jumps} pairs of neighbours on the grid are"
            warn(f"{pairs} in different assembly modes; a finer grid tells them apart")

    def _regions(self) -> list[Block]:
        """Return regions of the coordinate axes; each begins with the last layer of the one before."""
        axes = self.spec.axes_of("coordinate")
        shape = tuple(axis.size for axis in axes)
        if not axes:
            return [()]
        layer = math.prod(shape[1:])
        thick = max(2, REGION // (layer * max(1, len(self.labels.loose))))
        whole = tuple(slice(0, n) for n in shape[1:])
        return [(slice(max(0, start - 1), min(start + thick, shape[0])), *whole) for start in range(0, shape[0], thick)]
