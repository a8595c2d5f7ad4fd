"""Results of the blocks of the grid: poses of one robot, assembled and analysed, as arrays of the Dataset; blocks in threads.

A block is a range of indices along each axis of the grid: parameters, then dimensions of load cases, then coordinates. It has one
combination of parameters, that is, one robot.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import warn
from kinetostatics.capacity import capacity
from kinetostatics.compensation import compensated
from kinetostatics.description.loads import Payload
from kinetostatics.dynamics.vibrations import modes
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Values, in_threads
from kinetostatics.quantities import POSES, QUANTITIES, ROBOTS, Entry, stacked, value_at
from kinetostatics.results.contributions import by_mechanism_of_gravity
from kinetostatics.status import REPORTED, WITHOUT_NUMBERS, status_of
from kinetostatics.workspace.continuity import continued
from kinetostatics.workspace.dataset import NOT_REACHED, REACHED, Labels, dataset, numbered
from kinetostatics.workspace.grid import Block, sizes_of
from kinetostatics.workspace.store import Arrays
from kinetostatics.workspace.sweep_plan import Combination, SweepPlan

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.results.result import Result
    from kinetostatics.robot import Robot

#: Largest number of joint coordinates in a region that is checked for continuity (130 MB).
REGION = 2**24


def compute_block(plan: SweepPlan, labels: Labels, block: Block, q: Array | None = None) -> dict[str, Values]:
    """Return the variables of the Dataset on one block.

    If the model coordinates ``q`` (N, nq) of the block's poses are None, the poses are assembled from the zero pose; NaN in ``q``
    marks a pose that is not reached.
    """
    cases, coordinates = plan.part(block, "case"), plan.part(block, "coordinate")
    combination = tuple(piece.start for piece in plan.part(block, "parameter"))
    robot = plan.robot(combination)
    if q is None:
        configuration = plan.assemble(robot, plan.coordinates(coordinates))
    else:
        configuration = robot.configuration(q, closure_tolerance=plan.closure_tolerance, on_failure="nan")
    parts = _arrays(plan, labels, combination, configuration, cases, coordinates)
    arrays = {}
    for name, variable in labels.variables.items():
        lengths = [piece.stop - piece.start for piece, axis in zip(block, plan.axes, strict=True) if axis.kind in variable.varies]
        arrays[name] = parts[name].reshape((*lengths, *parts[name].shape[parts[name].ndim - len(variable.dims) :]))
    return arrays


def make_ready(plan: SweepPlan, labels: Labels, combination: Combination) -> Robot:
    """Return a robot with all pose-independent data computed, so that threads may share it."""
    robot = plan.robot(combination)
    compute_block(plan, labels, (*(slice(k, k + 1) for k in combination), *(slice(0, 1) for _ in plan.axes[len(combination) :])))
    return robot


def _arrays(
    plan: SweepPlan, labels: Labels, combination: Combination, configuration: Configuration, cases: Block, coordinates: Block
) -> dict[str, Values]:
    """Return the variables in a block of N poses: arrays (cases…, N, …), without the axes on which a variable does not depend."""
    at = (*(slice(k, k + 1) for k in combination), *cases, *coordinates)
    counts, count = sizes_of(cases), math.prod(sizes_of(coordinates))

    def spread(values: Array) -> Array:
        values = values.reshape(*values.shape[len(combination) :])  # one robot
        if any(size > 1 for size in values.shape[len(cases) : -1]):
            full = np.broadcast_to(values, (*values.shape[: len(cases)], *sizes_of(coordinates), values.shape[-1]))
            return full.reshape(*values.shape[: len(cases)], count, values.shape[-1])
        return values.reshape(*values.shape[: len(cases)], 1, values.shape[-1])

    gravity = spread(plan.gravity.of(plan.axes, at))
    point = None if plan.point is None else spread(plan.point.of(plan.axes, at))
    case = replace(plan.case, load=spread(plan.load.of(plan.axes, at)), gravity=gravity, point=point)
    result = analyzed(configuration, case, "nan")
    arrays = _analysis_arrays(plan, labels, combination, result, (*counts, configuration.shape[0]))
    if plan.compensated:
        corrected = compensated(configuration, case, plan.compensated, plan.orientation, "nan", plan.closure_tolerance)
        shifts = np.stack(list(corrected.corrections.values()), axis=-1)
        more = {"actuator_correction": shifts, "residual_error": corrected.residual_error}
        names = [name for name in more if name in labels.outputs]
        arrays |= {name: np.broadcast_to(more[name], (*counts, *more[name].shape[-2:])) for name in names}
    if "payload_capacity" in labels.outputs:
        payload = plan.case.payload or Payload(1.0)
        further = {name: getattr(case, name) for name in ("load", "gravity", "loads", "assembly_errors", "engine")}
        arrays["payload_capacity"] = capacity(configuration, payload=payload, **further).load
    if plan.modes:
        here = gravity[(0,) * len(cases)]  # frequencies do not vary with loads
        vibrations = modes(configuration, plan.modes, payload=case.payload, gravity=here)
        more = {"frequency": vibrations.frequencies, "zero_frequencies": vibrations.zero_frequencies}
        arrays |= {name: more[name] for name in more if name in labels.outputs}
    return arrays


def _analysis_arrays(
    plan: SweepPlan, labels: Labels, combination: Combination, result: Result, shape: tuple[int, ...]
) -> dict[str, Values]:
    """Return the requested variables that follow from an analysis; ``shape``: (cases…, N)."""
    configuration, robot = result.configuration, result.robot
    if result.contribution_names != labels.axes["source"] or robot.description.actuated != labels.axes["actuator"]:
        values = ", ".join(f"{name} = {value}" for name, value in plan.parameters(combination).items()) or "these values"
        raise ArgumentError(
            f"with {values} the robot has other limbs or actuators than with the first values of the parameters; sweep these "
            "robots separately"
        )
    reached = configuration.reached
    functions: dict[str, Callable[[], object]] = {
        "mode": lambda: np.where(reached, REACHED, NOT_REACHED).astype(np.int8),
        "platform_pose": lambda: configuration.platform_coordinates(plan.orientation),
        "actuator_position": lambda: {name: np.where(reached, x, np.nan) for name, x in configuration.actuators.items()},
        "gravity_mechanism": lambda: by_mechanism_of_gravity(
            result.contributions["platform_weight"], result.mechanism_contributions
        ),
        "actuator_gravity_mechanism": lambda: {
            name: by_mechanism_of_gravity(result.actuator_contributions[name]["platform_weight"], limbs)
            for name, limbs in result.actuator_mechanism_contributions.items()
        },
        "intensity": lambda: _intensities(result, labels, "", shape),
        "attached_intensity": lambda: _intensities(result, labels, "attached_", shape),
    }
    if combination and any({*_wrenches(result, kind)} != {*labels.axes[f"{kind}wrench"]} for kind in ("", "attached_")):
        # the canonical wrenches differ from those of the first robot
        reported = {name: getattr(result, name) for name in REPORTED}
        facts = {**reported, "basis_degenerate": ~np.isin(result.status, WITHOUT_NUMBERS)}
        functions |= {"basis_degenerate": lambda: facts["basis_degenerate"], "status": lambda: status_of(result.status, facts)}
    paths = {
        entry.variable: path for path, entry in QUANTITIES.items() if entry.group not in ("capacity", "compensation", "modes")
    }
    arrays = {}
    for name, entry in labels.variables.items():
        if name in paths:
            value = functions[name]() if name in functions else value_at(result, paths[name])
            arrays[name] = _full(stacked(value, entry.dims, labels.axes), entry, shape)
    return arrays


def _wrenches(result: Result, kind: str) -> list[str]:
    """Return "limb: label" of each constraint wrench (``kind`` "") or attached wrench (``kind`` "attached_") of a robot."""
    return [f"{name}: {label}" for name, limb in result.limbs.items() for label in numbered(getattr(limb, f"{kind}labels"))]


def _intensities(result: Result, labels: Labels, kind: str, shape: tuple[int, ...]) -> Array:
    """Return intensities (…, wrenches) in the order of the wrenches of ``labels``; NaN for wrenches that ``result`` lacks."""
    arrays = [array for limb in result.limbs.values() for array in np.moveaxis(getattr(limb, f"{kind}intensities"), -1, 0)]
    columns, nothing = dict(zip(_wrenches(result, kind), arrays, strict=True)), np.full(shape, np.nan)
    return np.stack([columns.get(wrench, nothing) for wrench in labels.axes[f"{kind}wrench"]], axis=-1)


def _full(array: Values, entry: Entry, shape: tuple[int, ...]) -> Values:
    """Return an array with the leading axes on which its variable depends: (cases…, N), (N,) or none."""
    if entry.varies == POSES:
        return array[(0,) * (array.ndim - 1 - len(entry.dims))]
    sizes = () if entry.varies == ROBOTS else shape
    return array if array.shape[: len(sizes)] == sizes else np.broadcast_to(array, sizes + array.shape[len(sizes) :])


# ---- all blocks -------------------------------------------------------------------------------------------------------


class Progress:
    """Counter of the computed poses of a sweep, shared by its threads."""

    def __init__(self, size: int) -> None:
        self.size, self.done, self.doing, self._lock = size, 0, "sweeping", threading.Lock()

    def text(self) -> str:
        return f"{self.doing}, {self.done:,} of {self.size:,} poses done"

    def add(self, block: Block) -> None:
        with self._lock:
            self.done += math.prod(sizes_of(block))


def dataset_in_memory(
    plan: SweepPlan,
    labels: Labels,
    sizes: tuple[int, ...],
    attributes: Mapping[str, object],
    number: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the whole Dataset of a sweep, in memory."""
    arrays = Arrays(plan, labels, sizes)
    counts = compute(arrays, number, progress or Progress(plan.size))
    warn_of_jumps(counts)
    return dataset(plan, labels, arrays.arrays, {**attributes, **counts})


def compute(arrays: Arrays, number: int | None, progress: Progress) -> dict[str, int]:
    """Compute the missing blocks and correct their assembly modes.

    Returns:
        Attributes of the Dataset: how many poses were corrected because they were in another assembly mode than their neighbours.
    """
    plan, labels = arrays.plan, arrays.labels
    counts = {"mode_jumps": 0, "poses_of_other_modes": 0, "poses_by_neighbours": 0}

    def fill(block: Block) -> None:
        if not arrays.is_done(block):
            arrays.write(block, compute_block(plan, labels, block))
        progress.add(block)

    for combination in plan.combinations():
        make_ready(plan, labels, combination)
        in_threads(fill, plan.blocks(combination, arrays.sizes), most=number)
        for region in _regions(plan, labels):
            for name, count in _correct_modes(arrays, combination, region, number).items():
                counts[name] += count
    return dict(counts)


def compute_part(arrays: Arrays, part: tuple[int, int], number: int | None, progress: Progress) -> None:
    """Compute the missing blocks of part k of n, ``part``: the k-th block of all robots, and every n-th after it."""
    plan, (k, n) = arrays.plan, part

    def fill(block: Block) -> None:
        arrays.write(block, compute_block(plan, arrays.labels, block))
        progress.add(block)

    blocks = (block for block in itertools.islice(plan.every_block(arrays.sizes), k - 1, None, n) if not arrays.is_done(block))
    for robots, missing in itertools.groupby(blocks, lambda block: plan.part(block, "parameter")):
        make_ready(plan, arrays.labels, tuple(piece.start for piece in robots))
        in_threads(fill, missing, most=number)


def warn_of_jumps(counts: Mapping[str, object]) -> None:
    if jumps := counts["mode_jumps"]:
        pairs = "1 pair of neighbours on the grid is" if jumps == 1 else f"{jumps} pairs of neighbours on the grid are"
        warn(f"{pairs} in different assembly modes; a finer grid separates them")


def _correct_modes(arrays: Arrays, combination: Combination, region: Block, number: int | None) -> dict[str, int]:
    """Correct the poses in a region of the grid of coordinates by continuity; return the numbers of changes by attribute."""
    plan, labels = arrays.plan, arrays.labels
    robot_slices = tuple(slice(k, k + 1) for k in combination)
    cases = tuple(slice(0, 1) for _ in plan.axes_of("case"))
    shape = sizes_of(region)

    def stored(name: str, where: Block) -> np.ndarray:
        values = arrays.read(name, (*robot_slices, *cases, *where))
        return values.reshape(values.shape[len(combination) :])

    label = "_".join(str(k) for k in (*combination, *(piece.start for piece in region)))
    changes = arrays.changes(label)
    if changes is None:
        o = stored("platform_pose", region)[..., :3]
        reached = stored("mode", region) == REACHED
        changes = vars(continued(plan, labels, plan.robot(combination), region, stored("q", region), o, reached))
        if changes["which"].size:
            arrays.keep(label, changes)
    which, q = changes["which"], changes["q"]
    row = np.full(math.prod(shape), -1)
    row[which] = np.arange(len(which))

    def correct(block: Block) -> None:
        part = plan.part(block, "coordinate")
        rows = np.full(sizes_of(part), -1)
        here = tuple(slice(max(p.start, r.start), min(p.stop, r.stop)) for p, r in zip(part, region, strict=True))
        inside = tuple(slice(h.start - p.start, h.stop - p.start) for h, p in zip(here, part, strict=True))
        there = tuple(slice(h.start - r.start, h.stop - r.start) for h, r in zip(here, region, strict=True))
        rows[inside] = row.reshape(shape)[there]
        if np.any(changed := rows.ravel() >= 0):
            poses = stored("q", part).reshape(changed.size, -1).copy()
            poses[changed] = q[rows.ravel()[changed]]
            arrays.write(block, compute_block(plan, labels, block, poses))

    if which.size:
        in_threads(correct, plan.blocks(combination, arrays.sizes, region), most=number)
    names = {"mode_jumps": "jumps", "poses_of_other_modes": "retracted", "poses_by_neighbours": "gained"}
    return {attribute: int(changes[name]) for attribute, name in names.items()}


def _regions(plan: SweepPlan, labels: Labels) -> list[Block]:
    """Divide the grid of coordinates into regions of about ``REGION`` joint coordinates; adjacent regions share a layer."""
    shape = tuple(axis.size for axis in plan.axes_of("coordinate"))
    if not shape:
        return [()]
    layer = math.prod(shape[1:])
    thick = max(2, REGION // (layer * max(1, len(labels.undetermined))))
    whole = tuple(slice(0, n) for n in shape[1:])
    return [(slice(max(0, start - 1), min(start + thick, shape[0])), *whole) for start in range(0, shape[0], thick)]


# ---- dask ----------------------------------------------------------------------------------------------------------------
