"""The numbers of one block of the grid, and the file in which they are kept until the map is whole."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.analysis import analyze
from kinetostatics.argument_checks import Keyword
from kinetostatics.compensation import compensate
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Index, Values
from kinetostatics.results.gravity_ways import force_ways, twist_ways
from kinetostatics.status import WITHOUT_NUMBERS, Status, status_of
from kinetostatics.workspace.grid import Block, sizes_of
from kinetostatics.workspace.schema import NO_MODE, POSES, ROBOTS, ZERO_MODE, Labels, numbered, variables
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
        lengths = [b.stop - b.start for b, axis in zip(block, spec.axes, strict=True) if axis.kind in item.kinds]
        stacked = parts[0][name] if len(parts) == 1 else np.stack([part[name] for part in parts])
        tail = stacked.shape[stacked.ndim - len(item.labels) :]
        found[name] = stacked.reshape((*lengths, *tail))
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
            "coordinates": spec.compensated,
            "orientation": spec.orientation,
            "tolerance": spec.tolerance,
        }
        corrected = compensate(configuration, **given, **wanted)
        shifts = np.stack(list(corrected.corrections.values()), axis=-1)
        more = {"actuator_correction": shifts, "remaining": corrected.remaining}
        found |= {name: np.broadcast_to(value, (*counts, *value.shape[-2:])) for name, value in more.items()}
    return found


def _extract(
    spec: SweepSpec, labels: Labels, combination: Combination, result: Result, shape: tuple[int, ...]
) -> dict[str, Values]:
    configuration, robot = result.configuration, result.robot
    if tuple(result.contributions) != labels.sources or robot.description.driven != labels.actuators:
        raise ArgumentError(
            f"with {_say(spec.parameters(combination))} the robot has other limbs or actuators than with the first values of the "
            "parameters; sweep such robots one by one"
        )
    first = (0,) * (len(shape) - 1)
    pose = configuration.platform_coordinates(spec.orientation)
    reached = configuration.status != Status.UNREACHABLE
    facts = dict(result.facts)
    found: dict[str, Values] = {
        "status": result.status,
        "mode": np.where(reached, ZERO_MODE, NO_MODE).astype(np.int8),
        "twist": result.twist,
        "contribution": np.stack([result.contributions[name] for name in labels.sources], axis=-2),
        "stiffness": result.stiffness[first],
        "compliance": result.compliance[first],
        "platform_pose": np.stack([pose[name] for name in labels.pose], axis=-1),
        "q": configuration.q,
        "characteristic_length": np.array(robot.length),
    }
    if labels.actuators:
        found["actuator_force"] = np.stack([result.actuator_forces[name] for name in labels.actuators], axis=-1)
        position = np.stack([configuration.actuators[name] for name in labels.actuators], axis=-1)
        found["actuator_position"] = np.where(reached[:, None], position, np.nan)
    if labels.springs:
        found["spring_force"] = np.stack([result.spring_forces[name][first] for name in labels.springs], axis=-1)
    if labels.ways:
        found["gravity_way"] = np.stack([twist_ways(result)[way] for way in labels.ways], axis=-2)
    if labels.ways and labels.actuators:
        forces, parts = force_ways(result), result.actuator_contributions
        ways = [np.stack([forces[name][way] for way in labels.ways], axis=-1) for name in labels.actuators]
        found["actuator_gravity_way"] = np.stack(ways, axis=-2)
        split = [np.stack([parts[name][source] for source in labels.sources], axis=-1) for name in labels.actuators]
        found["actuator_contribution"] = np.stack(split, axis=-2)
    matches = True
    for name, wanted, attribute in (
        ("intensity", labels.wrenches, ("labels", "intensities")),
        ("attached_intensity", labels.attached, ("attached_labels", "attached_intensities")),
    ):
        columns = {
            (limb.name, label): getattr(limb, attribute[1])[..., k]
            for limb in result.limbs.values()
            for k, label in enumerate(numbered(getattr(limb, attribute[0])))
        }
        matches &= set(columns) == {(limb, label) for limb, label, _ in wanted}
        if wanted:
            nothing = np.full(shape, np.nan)
            found[name] = np.stack([columns.get((limb, label), nothing) for limb, label, _ in wanted], axis=-1)
    if not matches:  # the canonical wrenches are others than those of the first robot
        facts["basis_degenerate"] = ~np.isin(result.status, WITHOUT_NUMBERS)
        found["status"] = status_of(result.status, facts)
    if labels.beams:
        beams = [result.beams[name] for name in labels.beams]
        found["beam_stress"] = np.stack([beam.stress for beam in beams], axis=-1)
        found["beam_euler_ratio"] = np.stack([beam.euler_ratio for beam in beams], axis=-1)
        lengths = [np.sqrt((beam.deflections**2).sum(axis=-1)).max(axis=-1) for beam in beams]
        found["beam_deflection"] = np.stack(lengths, axis=-1)
    found |= facts
    known = {name: item for name, item in variables(labels).items() if name in found}
    return {name: _full(found[name], item.kinds, shape) for name, item in known.items()}


def _full(array: Values, kinds: Sequence[str], shape: tuple[int, ...]) -> Values:
    """Return an array over all cases and poses that its variable varies with, where it came out the same for all."""
    wanted = () if kinds == ROBOTS else shape[-1:] if kinds == POSES else shape
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
