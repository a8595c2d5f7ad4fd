"""The numbers of one block of the grid, and the file in which they are kept until the map is whole."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.analysis import analyze
from kinetostatics.argument_checks import Keyword
from kinetostatics.compensation import compensate
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Index, Values
from kinetostatics.quantities import POSES, QUANTITIES, ROBOTS, Entry, stacked, value_at
from kinetostatics.results.gravity_ways import force_ways, twist_ways
from kinetostatics.status import TOLD, WITHOUT_NUMBERS, Status, status_of
from kinetostatics.workspace.grid import Block, sizes_of
from kinetostatics.workspace.schema import NO_MODE, ZERO_MODE, Labels, numbered, variables
from kinetostatics.workspace.sweep_spec import Combination, SweepSpec

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.results.result import Result


def compute_block(spec: SweepSpec, labels: Labels, block: Block) -> dict[str, Values]:
    """Return the variables of a block, each over the block's part of its dimensions.

    Every pose is reached on the straight line from the zero pose; what grid neighbours say is another matter, see
    :mod:`kinetostatics.workspace.assembly_modes.repair`.

    Raises:
        RobotFileError: the file is wrong for a combination of parameters.
        ArgumentError: parameters change what the robot is made of.
    """
    cases, coordinates = spec.part(block, "case"), spec.part(block, "coordinate")
    combinations = list(spec.combinations(block))
    parts = []
    for combination in combinations:
        configuration = spec.assemble(spec.robot(combination), spec.coordinates(coordinates))
        parts.append(pose_numbers(spec, labels, combination, configuration, cases, coordinates))
    found = {}
    for name, item in variables(labels).items():
        lengths = [b.stop - b.start for b, axis in zip(block, spec.axes, strict=True) if axis.kind in item.varies]
        values = parts[0][name] if len(parts) == 1 else np.stack([part[name] for part in parts])
        found[name] = values.reshape((*lengths, *values.shape[values.ndim - len(item.dims) :]))
    return found


def pose_numbers(
    spec: SweepSpec,
    labels: Labels,
    combination: Combination,
    configuration: Configuration,
    cases: Block,
    coordinates: Block,
    which: Index | None = None,
) -> dict[str, Values]:
    """Return the variables of poses (N,) of one robot, each (cases…, N, …) or (N, …).

    Args:
        spec: of the sweep.
        labels: of the Dataset.
        combination: the robot.
        configuration: the poses.
        cases: which cases of loads.
        coordinates: the block of the coordinate axes in which the poses lie.
        which: numbers of the poses in that block; None: all.
    """
    at = (*(slice(k, k + 1) for k in combination), *cases, *coordinates)
    counts, count = sizes_of(cases), math.prod(sizes_of(coordinates))

    def spread(values: Array) -> Array:
        values = values.reshape(*values.shape[len(combination) :])  # one robot
        if any(size > 1 for size in values.shape[len(cases) : -1]):
            full = np.broadcast_to(values, (*values.shape[: len(cases)], *sizes_of(coordinates), values.shape[-1]))
            values = full.reshape(*values.shape[: len(cases)], count, values.shape[-1])
            return values if which is None else values[..., which, :]
        return values.reshape(*values.shape[: len(cases)], 1, values.shape[-1])

    given: dict[str, Keyword] = {
        "load": spread(spec.load.of(spec.axes, at)),
        "gravity": spread(spec.gravity.of(spec.axes, at)),
        "point": None if spec.point is None else spread(spec.point.of(spec.axes, at)),
        "frame": spec.frame,
        **spec.extras,
        "on_failure": "nan",
        "engine": spec.engine,
    }
    result = analyze(configuration, **given)
    found = _extract(spec, labels, combination, result, (*counts, configuration.shape[0]))
    if spec.compensated:
        wanted: dict[str, Keyword] = {
            "controlled": spec.compensated,
            "orientation": spec.orientation,
            "closure_tolerance": spec.closure_tolerance,
        }
        corrected = compensate(configuration, **given, **wanted)
        shifts = np.stack(list(corrected.corrections.values()), axis=-1)
        more = {"actuator_correction": shifts, "residual_error": corrected.residual_error}
        found |= {name: np.broadcast_to(more[name], (*counts, *more[name].shape[-2:])) for name in more if name in labels.outputs}
    return found


def _extract(
    spec: SweepSpec, labels: Labels, combination: Combination, result: Result, shape: tuple[int, ...]
) -> dict[str, Values]:
    """Return the variables (cases…, N, …) that an analysis has; what no variable tells is not computed."""
    configuration, robot = result.configuration, result.robot
    if result.sources != labels.axes["source"] or robot.description.driven != labels.axes["actuator"]:
        raise ArgumentError(
            f"with {_say(spec.parameters(combination))} the robot has other limbs or actuators than with the first values of the "
            "parameters; sweep such robots one by one"
        )
    reached = configuration.status != Status.UNREACHABLE
    own: dict[str, Callable[[], object]] = {
        "mode": lambda: np.where(reached, ZERO_MODE, NO_MODE).astype(np.int8),
        "platform_pose": lambda: configuration.platform_coordinates(spec.orientation),
        "actuator_position": lambda: {name: np.where(reached, x, np.nan) for name, x in configuration.actuators.items()},
        "gravity_way": lambda: twist_ways(result),
        "actuator_gravity_way": lambda: force_ways(result),
        "intensity": lambda: _intensities(result, labels, "", shape),
        "attached_intensity": lambda: _intensities(result, labels, "attached_", shape),
    }
    if any({*_wrenches(result, kind)} != {*labels.axes[f"{kind}wrench"]} for kind in ("", "attached_")):
        # the canonical wrenches are others than those of the first robot
        told = {name: getattr(result, name) for name in TOLD}
        facts = {**told, "basis_degenerate": ~np.isin(result.status, WITHOUT_NUMBERS)}
        own |= {"basis_degenerate": lambda: facts["basis_degenerate"], "status": lambda: status_of(result.status, facts)}
    entries = variables(labels)
    paths = {entry.variable: path for path, entry in QUANTITIES.items() if entry.extra != "compensate"}
    found = {}
    for name in (name for name in entries if name in paths):
        value = own[name]() if name in own else value_at(result, paths[name])
        found[name] = _full(stacked(value, entries[name].dims, labels.axes), entries[name], shape)
    return found


def _wrenches(result: Result, kind: str) -> list[str]:
    """Return limb and label of each of a robot's constraint wrenches, or of its "attached_" ones."""
    return [f"{name}: {label}" for name, limb in result.limbs.items() for label in numbered(getattr(limb, f"{kind}labels"))]


def _intensities(result: Result, labels: Labels, kind: str, shape: tuple[int, ...]) -> Array:
    """Return intensities (…, wrenches) of the wrenches that the first robot has; NaN where this one has none such."""
    arrays = [array for limb in result.limbs.values() for array in np.moveaxis(getattr(limb, f"{kind}intensities"), -1, 0)]
    columns, nothing = dict(zip(_wrenches(result, kind), arrays, strict=True)), np.full(shape, np.nan)
    return np.stack([columns.get(wrench, nothing) for wrench in labels.axes[f"{kind}wrench"]], axis=-1)


def _full(array: Values, entry: Entry, shape: tuple[int, ...]) -> Values:
    """Return an array over all cases and poses that its variable varies with, where it came out the same for all or for more."""
    if entry.varies == POSES:
        return array[(0,) * (array.ndim - 1 - len(entry.dims))]
    wanted = () if entry.varies == ROBOTS else shape
    return array if array.shape[: len(wanted)] == wanted else np.broadcast_to(array, wanted + array.shape[len(wanted) :])


def _say(parameters: Mapping[str, object]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in parameters.items()) or "these values"


def block_numbers(spec: SweepSpec, labels: Labels, block: Block, path: str | None = None) -> dict[str, Values]:
    """Return the variables of a block, having written them to a file if a ``path`` is given."""
    numbers = compute_block(spec, labels, block)
    if path is not None:
        write_part(path, numbers)
    return numbers


def write_part(path: str, numbers: Mapping[str, Values]) -> None:
    """Write a block to a file that is there as a whole or not at all, whatever happens to this process."""
    unfinished = f"{path}.{os.getpid()}.tmp"
    arrays = [np.asarray(array, order="C") for array in numbers.values()]
    with open(unfinished, "wb") as file:
        for array in (np.array(list(numbers)), *arrays, _checksum(arrays)):
            np.save(file, array, allow_pickle=False)
    os.replace(unfinished, path)


def read_part(path: str) -> dict[str, Values] | None:
    """Return the block of a file, None if it is not whole: after a power failure, say."""
    try:
        with open(path, "rb") as file:
            names = np.load(file, allow_pickle=False)
            arrays = [np.load(file, allow_pickle=False) for _ in names]
            if np.load(file, allow_pickle=False) != _checksum(arrays):
                return None
    except (OSError, ValueError, EOFError):
        return None
    return dict(zip(names.tolist(), arrays, strict=True))


def _checksum(arrays: Sequence[Values]) -> NDArray[np.uint64]:
    """Return the sum of all numbers, taken as integers."""
    total = np.zeros((), dtype=np.uint64)
    for array in arrays:
        total += array.reshape(-1).view(f"u{array.itemsize}").sum(dtype=np.uint64)
    return total
