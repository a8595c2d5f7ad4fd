"""How the Dataset of a sweep is laid out: dimensions, variables, units, labels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.math.arrays import Values
from kinetostatics.math.orientation import orientation_named
from kinetostatics.quantities import UNITS, VARIABLES, Entry, axes_of, units_along
from kinetostatics.reports.json import wrench_units
from kinetostatics.results.gravity_ways import WAYS
from kinetostatics.status import Status
from kinetostatics.workspace.grid import LENGTHS
from kinetostatics.workspace.sweep_spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

#: Coordinates that change by more than the second when all are moved by the first and the loops closed again are loose.
MOVED, CHANGED = 0.05, 1e-5
#: ``mode``: which assembly mode reaches a pose.
ZERO_MODE, OTHER_MODE, NO_MODE = 0, 1, -1


@dataclass(frozen=True)
class Labels:
    """What the entries of the Dataset's further dimensions are called; the same for all robots of a sweep.

    Attributes:
        robot: the robot's name.
        axes: labels by dimension, also of dimensions that no variable has.
        said: dimensions and entries of coordinates that say units, limbs and labels of these.
        loose: which of Pinocchio's coordinates local freedoms change, so that they say nothing of the assembly mode.
        outputs: names of the variables.
    """

    robot: str
    axes: Mapping[str, tuple[str, ...]]
    said: Mapping[str, tuple[tuple[str, ...], Sequence[object]]]
    loose: tuple[bool, ...]
    outputs: tuple[str, ...]


def _flags(words: Mapping[int, str]) -> dict[str, object]:
    return {"flag_values": np.array(list(words), dtype=np.int8), "flag_meanings": " ".join(words.values())}


#: What the dimensions are that the grid does not have.
_AXES = {
    "component": "component of twists and wrenches about o, world axes",
    "component_2": "component of twists and wrenches about o, world axes",
    "source": "what contributes to the twist",
    "way": "how gravity acts",
    "actuator": "driven joint",
    "wrench": "constraint wrench of a limb",
    "attached_wrench": "gravity-attached constraint wrench of a limb",
    "platform_coordinate": "coordinate of the platform",
    "joint_coordinate": "coordinate of the model",
    "beam": "beam",
    "spring": "spring",
}
#: Variables along whose axes the coordinates of units are that all robots have.
_UNITS_OF = ("twist", "stiffness", "compliance", "actuator_force", "actuator_position")
#: Attributes of variables whose numbers stand for words.
FLAGS: Mapping[str, Mapping[str, object]] = {
    "status": _flags({int(item): item.name.lower() for item in Status}),
    "mode": _flags({NO_MODE: "none_found", ZERO_MODE: "mode_of_the_zero_pose", OTHER_MODE: "only_another_mode"}),
}


def attributes_of(name: str) -> dict[str, object]:
    """Return the attributes of a variable: where units differ along a dimension, the name of the coordinate that tells them."""
    entry = VARIABLES[name]
    units = {"unit_coordinate" if entry.unit in UNITS else "units": entry.unit} if entry.unit else {}
    return {"long_name": entry.words, **units, **FLAGS.get(name, {})}


def _nothing(entry: Entry) -> object:
    """Return what stands where nothing has been written."""
    return NO_MODE if entry.dtype == np.int8 else False if entry.dtype == np.bool_ else np.nan


def numbered(labels: Iterable[str]) -> list[str]:
    """Return labels, a second one of the same name called "… (2)"."""
    seen: dict[str, int] = {}
    found = []
    for label in labels:
        seen[label] = seen.get(label, 0) + 1
        found.append(label if seen[label] == 1 else f"{label} ({seen[label]})")
    return found


def labels_of(spec: SweepSpec, robot: Robot) -> Labels:
    """Return the labels of a robot."""
    generic = robot.configuration(robot.model_q(robot.generic_poses).T, closure_tolerance=np.inf, on_failure="nan")
    result = analyze(generic, **spec.extras, on_failure="nan")
    q, pose = _q_labels(robot), orientation_named(spec.orientation).pose_names
    axes: dict[str, tuple[str, ...]] = {
        **axes_of(robot.statics),
        "source": tuple(result.contributions),
        "way": WAYS,
        "beam": tuple(robot.description.beams),
        "platform_coordinate": pose,
        "joint_coordinate": tuple(name for name, _ in q),
    }
    units = units_along(robot.statics)
    said: dict[str, tuple[tuple[str, ...], Sequence[object]]] = {
        VARIABLES[name].unit: (VARIABLES[name].dims, units[VARIABLES[name].unit]) for name in _UNITS_OF
    }
    for kind, names, columns in (("", "labels", "constraint_wrenches"), ("attached_", "attached_labels", "attached_wrenches")):
        found = [(limb.name, numbered(getattr(limb, names)), getattr(limb, columns)) for limb in result.limbs.values()]
        axes[f"{kind}wrench"] = tuple(f"{limb}: {label}" for limb, labels, _ in found for label in labels)
        said[f"{kind}limb"] = (f"{kind}wrench",), [limb for limb, labels, _ in found for _ in labels]
        said[f"{kind}label"] = (f"{kind}wrench",), [label for _, labels, _ in found for label in labels]
        units_of = [unit for _, labels, wrenches in found for unit in wrench_units(labels, wrenches)]
        said[f"{kind}wrench_unit"] = (f"{kind}wrench",), units_of
    said["platform_coordinate_unit"] = ("platform_coordinate",), ["m" if name in LENGTHS else "rad" for name in pose]
    said["joint_coordinate_unit"] = ("joint_coordinate",), [unit for _, unit in q]
    extras = {"": True, "beams": spec.beams, "ways": spec.ways, "compensate": bool(spec.compensated)}
    chosen = [name for name, item in VARIABLES.items() if extras.get(item.extra)] if spec.outputs is None else spec.outputs
    outputs = [name for name, item in VARIABLES.items() if item.extra == "always" or name in chosen]
    there = tuple(name for name in outputs if all(axes[dim] for dim in VARIABLES[name].dims))
    return Labels(robot.name, axes, said, loose_coordinates(spec, robot), there)


def loose_coordinates(spec: SweepSpec, robot: Robot) -> tuple[bool, ...]:
    """Return which model coordinates local freedoms change: a rod that spins between two spherical joints.

    They are what a pose's coordinates leave open, at a generic pose that is left a little and closed again.
    """
    if not robot.mobility.local:
        return (False,) * robot.mechanism.tree.nq
    q = robot.model_q(robot.generic_poses)[:, 0]
    pose = robot.configuration(q, closure_tolerance=np.inf, on_failure="nan")
    known = pose.platform_coordinates(spec.orientation) if spec.kind == "platform" else pose.actuators
    names = [*spec.held, *(axis.name for axis in spec.axes_of("coordinate"))]
    random = np.random.default_rng(6)
    starts = q + random.uniform(-MOVED, MOVED, (32, len(q)))
    near = robot.configuration(starts, closure_tolerance=np.inf, on_failure="nan")
    try:
        found = spec.assemble(robot, {name: np.full(len(starts), float(known[name])) for name in names}, near)
    except (KinetostaticsError, KeyError):  # somebody else will complain
        return (False,) * robot.mechanism.tree.nq
    ends = found.q[found.status != Status.UNREACHABLE]
    if len(ends) < 2:
        model = robot.mechanism.model
        return tuple(
            n not in robot.description.driven for n, count in zip(model.names, model.nqs, strict=True) for _ in range(count)
        )
    return tuple((np.ptp(ends, axis=0) > CHANGED).tolist())


def _q_labels(robot: Robot) -> list[tuple[str, str]]:
    model, connections = robot.mechanism.model, robot.mechanism.connections
    found: list[tuple[str, str]] = [("", "1")] * model.nq
    for name, first, count in zip(list(model.names), list(model.idx_qs), list(model.nqs), strict=True):
        if count == 1:
            found[first] = name, connections[name].type.unit if name in connections else "rad"
        for k in range(count if count > 1 else 0):
            part = ("cos", "sin")[k] if count == 2 else str(k)
            found[first + k] = f"{name}:{part}", "1"
    return found


def variables(labels: Labels) -> dict[str, Entry]:
    """Return the variables that a Dataset with these labels has."""
    return {name: VARIABLES[name] for name in labels.outputs}


def _said(labels: Labels) -> dict[str, xr.Variable]:
    """Return the coordinates that say units, limbs and labels of what some variable has."""
    import xarray as xr

    dims, told, found = _dims(labels), {item.unit for item in variables(labels).values()}, {}
    for name, (mine, values) in labels.said.items():
        if {*mine} <= dims and (name in told or not name.endswith("_unit")):
            texts = np.array(values, dtype=str)
            found[name] = xr.Variable(mine, (np.char.replace(texts, "·", " ") if name in UNITS else texts).astype(object))
    return found


def _dims(labels: Labels) -> set[str]:
    """Return the dimensions that the grid does not have and some variable has."""
    return {dim for item in variables(labels).values() for dim in item.dims}


def check_names(spec: SweepSpec, labels: Labels) -> None:
    """See to it that no dimension or held value is called like something else in the Dataset.

    Raises:
        ArgumentError: one is, or two are called alike.
    """
    for name in spec.outputs or ():
        for dim in VARIABLES[name].dims:
            if not labels.axes[dim]:
                raise ArgumentError(f"{labels.robot!r} has no {_AXES[dim]}: there is no output {name!r}")
    taken = {*variables(labels), *_dims(labels), *_said(labels)}
    for name in (*(axis.name for axis in spec.axes), *spec.held, *spec.constants):
        if name in taken:
            raise ArgumentError(
                f"{name!r} cannot be the name of a dimension or coordinate here: the Dataset has that name already, "
                "or it is given twice"
            )
        taken.add(name)


def coordinates(spec: SweepSpec, labels: Labels) -> dict[str, xr.Variable]:
    """Return all coordinates of the Dataset."""
    import xarray as xr

    found: dict[str, xr.Variable] = {}
    for axis in spec.axes:
        units = {"units": axis.units} if axis.units else {}
        found[axis.name] = xr.Variable((axis.name,), _stored(axis.values), {"long_name": axis.long_name, **units})
    dim, unit = ("platform_coordinate",) * 2 if spec.kind == "platform" else ("actuator", "actuator_position")
    units_of_coordinates = dict(zip(labels.axes[dim], labels.said[f"{unit}_unit"][1], strict=True))
    for name, value in spec.held.items():
        held = {"long_name": f"{name}, the same at all poses", "units": units_of_coordinates[name]}
        found[name] = xr.Variable((), value, held)
    for name, constant in spec.constants.items():
        attributes = {"long_name": f"parameter {name} of the robot file, the same at all poses"}
        found[name] = xr.Variable((), _stored(np.asarray(constant)), attributes)
    for name in (name for name in _AXES if name in _dims(labels)):
        found[name] = xr.Variable((name,), np.array(labels.axes[name], dtype=object), {"long_name": _AXES[name]})
    return {**found, **_said(labels)}


def _stored(values: Values) -> Values:
    """Return an array as files can hold it: strings as objects, truth values as integers."""
    if values.dtype.kind == "U":
        return values.astype(object)
    return values.astype(np.int8) if values.dtype.kind == "b" else values


def template(spec: SweepSpec, labels: Labels) -> xr.Dataset:
    """Return a Dataset with all coordinates and variables, whose arrays over the grid take no memory and mean nothing."""
    import xarray as xr

    coords = coordinates(spec, labels)
    sizes = {name: coordinate.shape[0] for name, coordinate in coords.items() if coordinate.dims == (name,)}
    data: dict[str, xr.Variable] = {}
    for name, item in variables(labels).items():
        dims = (*(axis.name for axis in spec.axes if axis.kind in item.varies), *item.dims)
        nothing = np.array(_nothing(item), dtype=item.dtype)
        data[name] = xr.Variable(dims, np.broadcast_to(nothing, tuple(sizes[dim] for dim in dims)), attributes_of(name))
    return xr.Dataset(data, coords=coords)
