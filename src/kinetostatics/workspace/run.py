"""Sweeps: analyses of a robot, and of its variants, on a grid of poses."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from kinetostatics.arguments import names_in, need, path_name, whole_number
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import threads
from kinetostatics.progress import in_notebook, waiting
from kinetostatics.quantities import VARIABLES
from kinetostatics.robot import Robot
from kinetostatics.workspace.block import Progress, compute, compute_part, dataset_in_memory, warn_of_jumps
from kinetostatics.workspace.dataset import Labels, check_names, dataset, labels_of, shapes
from kinetostatics.workspace.grid import block_sizes, chunk_sizes
from kinetostatics.workspace.reduced import read_groups, reduced_map
from kinetostatics.workspace.store import Store, check_memory, locked, map_exists, open_map, packages_of, save
from kinetostatics.workspace.sweep_arguments import read_plan, try_plan, try_robots
from kinetostatics.workspace.sweep_plan import SweepPlan, attributes_of_map

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.description.robot_description import RobotDescription

#: Smallest and largest number of poses in a block, and largest number if there are costly variables.
LEAST, MOST, MOST_COSTLY = 10_000, 32_000, 2000
#: Smallest number of blocks per thread, for load balance.
SHARE = 4
#: Number of poses in a chunk with chunks="auto".
AUTO = 20_000


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
    outputs: Sequence[str] = ("default",),
    reduce: Mapping[str, str] | None = None,
    modes: int = 0,
    closure_tolerance: float = 1e-10,
    engine: str = "auto",
    out: str | os.PathLike[str] | None = None,
    restart: bool = False,
    part: str | None = None,
    chunks: Mapping[str, int] | str | None = None,
    workers: int | None = None,
    progress: bool | None = None,
    command_line: Sequence[str] | None = None,
) -> xr.Dataset:
    """Analyze a robot on a grid of poses: the outer product of one-dimensional arrays.

    Args:
        robot: a robot, its file, or the name of a robot of the package; ``parameters`` require a file or a name.
        platform: platform coordinates by name, see :meth:`Robot.assemble` [m, rad]; an array is a dimension of the grid, a number
            is constant.
        actuators: coordinates of all actuators, instead of ``platform``.
        orientation: convention of the orientation coordinates, see :meth:`Robot.assemble`.
        load: see :func:`kinetostatics.analyze`. Load, gravity and point may be an ``xarray.DataArray`` with the last dimension
            ``component``; its other dimensions become dimensions of the grid.
        gravity, point: see :func:`kinetostatics.analyze`, and ``load``.
        frame: see :func:`kinetostatics.analyze`.
        assembly_errors: see :func:`kinetostatics.analyze`.
        loads: loads on links, see :func:`kinetostatics.analyze`; the same at all poses.
        payload: see :func:`kinetostatics.analyze`; the same at all poses.
        parameters: values of the file's xacro arguments; an array is a dimension of the grid, a number or string is constant.
        parameter_units: SI units of parameters, such as ``{"rod_diameter": "m"}``. Default: the unit of a length, angle, mass,
            density, modulus or stiffness of the robot that changes by as much as the parameter.
        platform_link, base_link: see :func:`kinetostatics.load_robot`.
        outputs: variables, or groups of them: "default"; "beams" (stress, Euler ratio and deflection of each beam);
            "capacity" (largest mass at o, or with the centre and on the link of ``payload``, see :func:`kinetostatics.capacity`);
            "limits" (utilization of each actuator, smallest safety factor, and its limit, see :attr:`Result.margins`);
            "gravity_mechanisms" (the effect of gravity on twist and actuator forces in three parts: by the platform's weight, by
            the limbs' weights that the platform carries (attached wrenches), and by the limbs' deformation); "compensation"
            (actuator corrections that bring the loaded platform to its target, and the residual error, see
            :func:`kinetostatics.compensate`; on a grid of actuators, the target is given in the platform coordinates that best
            determine the zero pose). Status, mode, ``platform_pose``, ``q`` and ``characteristic_length`` are always included.
        reduce: operations by dimension of the grid, such as ``{"rx": "max", "ry": "max"}``: "max", "min", "mean",
            "quantile 0.95", "argmax" or "argmin" (the value, and the coordinates of its pose), "count > 5e-5" or "count > 50 µm"
            (number of poses). Dimensions that follow one another with the same operation are reduced together, others in the
            order given. Only valid poses within the joint limits count. The map itself is not stored. ``outputs`` are then
            quantities, see :func:`kinetostatics.indices.quantity`, default "linear_sag".
        modes: number of natural frequencies, with locked actuators and the payload, see :func:`kinetostatics.modes`; unless it is
            0, ``frequency`` and ``zero_frequencies`` are among the variables.
        closure_tolerance: largest gap of a closed loop [m, rad].
        engine: see :func:`kinetostatics.analyze`; numbers differ by rounding only.
        out: a file ``….nc`` or ``….zarr``, written during the computation in bounded memory. After an interruption, the same call
            resumes the sweep.
        restart: overwrite ``out``.
        part: "3/20" computes only the third of 20 parts of the blocks of ``out``; other jobs, also on other machines with the
            same folder, compute the others, in any order. The job after which no block is missing completes the map. Other jobs
            return a Dataset without variables, whose attribute ``missing_parts`` lists the incomplete parts.
        chunks: chunk sizes of a lazy Dataset of dask arrays, computed by dask's scheduler: ``{"z": 10}`` (other dimensions are
            undivided), or "auto".
        workers: number of threads; None: ``OMP_NUM_THREADS``, or the number of cores.
        progress: whether to show the number of computed poses on standard error; None: on a terminal, or in a notebook.
        command_line: command stored in the attributes.

    Returns:
        The Dataset (contents: see the page on workspace maps). With ``out`` it is read lazily from the file.

    Raises:
        ArgumentError: an argument has an invalid value or shape, or ``out`` is not the map of this sweep.
        CoordinatesError: coordinates are missing, unknown, or do not determine the pose.
        RobotFileError: the robot's file is invalid.
        KinetostaticsError: a package is missing.
    """
    need("a sweep", "sweep", "xarray")
    if chunks is not None:
        need("chunks=", "dask", "dask")
        if out is not None:
            raise ArgumentError("give out= or chunks=, not both: save a Dataset of dask arrays with to_netcdf or to_zarr")
    if out is not None:
        out = path_name("out", out).rstrip("/")
        need(out, "sweep", *packages_of(out))
    if reduce and chunks is not None:
        raise ArgumentError("give reduce= or chunks=, not both")
    share = None if part is None else _read_part(part)
    if share and (out is None or reduce or restart):
        raise ArgumentError("part= needs out=, and is possible neither with reduce= nor with restart=")
    number = threads() if workers is None else whole_number("workers", workers, 1)
    shown = in_notebook() if progress is None else progress
    quantities: Sequence[str] = ()
    if reduce:
        from kinetostatics.indices.named import variable_of

        quantities = names_in("outputs", ["linear_sag"] if outputs == ("default",) else outputs, '["linear_sag"]')
        outputs = [name for name in map(variable_of, quantities) if name in VARIABLES]
    with waiting("planning the sweep", progress is not False, shown):
        links = {"platform_link": platform_link, "base_link": base_link}
        coordinates = {"platform": platform, "actuators": actuators}
        vectors = {"load": (load, 6), "gravity": (gravity, 3), "point": (point, 3)}
        plan, first = read_plan(
            robot, coordinates, parameters, parameter_units, links, outputs, vectors,
            LoadCase(frame=frame, assembly_errors=assembly_errors, loads=loads, payload=payload, engine=engine),
            orientation=orientation, modes=modes, closure_tolerance=closure_tolerance,
        )  # fmt: skip
        groups = read_groups(reduce, plan.axes) if reduce else []
        if reduce:
            plan = replace(plan, reduced={"outputs": list(quantities), "reduce": dict(reduce)})
        labels = labels_of(plan, first)
        try_plan(plan, first)
        check_names(plan, labels, outputs)
        attributes = attributes_of_map(plan, first, command_line)
        if chunks is not None:
            return _lazy_dataset(plan, labels, chunks, attributes)
        try_robots(plan)
    most = MOST if all(variable.group in ("default", "always") for variable in labels.variables.values()) else MOST_COSTLY
    sizes = block_sizes(plan.axes, min(most, max(LEAST, math.ceil(plan.size / (SHARE * (share[1] if share else number))))))
    run = Progress(plan.size)
    if groups:
        if out is not None and map_exists(out, plan.identity, attributes, restart):
            return open_map(out)
        with waiting(run.text, progress is not False, shown):
            ds = reduced_map(plan, labels, groups, quantities, attributes, number, run)
        return ds if out is None else save(ds, out)
    if out is None:
        check_memory(plan, labels)
        with waiting(run.text, progress is not False, shown):
            return dataset_in_memory(plan, labels, sizes, attributes, number, run)
    if map_exists(out, plan.identity, attributes, restart):
        return open_map(out)
    with waiting(run.text, progress is not False, shown):
        if share:
            with locked(out, shared=True):
                if map_exists(out, plan.identity, attributes, restart):
                    return open_map(out)
                store = Store(plan, labels, sizes, out, restart)
                compute_part(store, share, number, run)
                if missing := store.missing_parts(share[1]):
                    return dataset(plan, labels, {}, {**attributes, "missing_parts": missing})
            run.done = 0
        with locked(out, shared=False):
            if not map_exists(out, plan.identity, attributes, restart):
                store = Store(plan, labels, sizes, out, restart)
                attributes |= (counts := compute(store, number, run))
                warn_of_jumps(counts)
                run.doing = "storing"
                store.publish(attributes)
    return open_map(out)


def _read_part(part: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)/(\d+)", part) if isinstance(part, str) else None
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise ArgumentError(f"part is {part!r}; it must be a number and a count such as '3/20', from '1/20' to '20/20'")
    return int(match[1]), int(match[2])


def _lazy_dataset(
    plan: SweepPlan, labels: Labels, chunks: Mapping[str, int] | str, attributes: Mapping[str, object]
) -> xr.Dataset:
    """Return a Dataset of dask arrays: each chunk is a separate sweep, computed by dask's scheduler.

    ``chunks``: sizes by dimension, or "auto".
    """
    import dask.array as da
    import xarray as xr

    if isinstance(chunks, str):
        if chunks != "auto":
            raise ArgumentError(f"chunks is {chunks!r}; it must be sizes by dimension, or 'auto'")
        sizes = block_sizes(plan.axes, AUTO)
    else:
        sizes = chunk_sizes(plan.axes, chunks)
    pieces = dict(zip((axis.name for axis in plan.axes), sizes, strict=True))
    empty = {
        name: da.empty(shape, dtype=variable.dtype, chunks=_pieces(plan, pieces, variable.varies, shape))  # type: ignore[no-untyped-call]
        for (name, shape), variable in zip(shapes(plan, labels).items(), labels.variables.values(), strict=True)
    }
    whole = dataset(plan, labels, empty, attributes)
    numbers = {
        f"number of {axis.name}": (axis.name, da.arange(axis.size, chunks=size))  # type: ignore[no-untyped-call]
        for axis, size in zip(plan.axes, sizes, strict=True)
    }
    lazy = xr.map_blocks(_chunk, xr.Dataset(numbers, whole.coords), (plan, labels), template=whole)
    return lazy.assign_coords(whole.coords)  # labels and units are known already


def _pieces(plan: SweepPlan, sizes: Mapping[str, int], varies: tuple[str, ...], shape: tuple[int, ...]) -> tuple[int, ...]:
    lengths = [sizes[axis.name] for axis in plan.axes if axis.kind in varies]
    return (*lengths, *shape[len(lengths) :])


def _chunk(numbers: xr.Dataset, plan: SweepPlan, labels: Labels) -> xr.Dataset:
    ends = (numbers[f"number of {axis.name}"].values for axis in plan.axes)
    part = plan.within(tuple(slice(int(indices[0]), int(indices[-1]) + 1) for indices in ends))
    return dataset_in_memory(part, labels, block_sizes(part.axes, AUTO), {}, 1)
