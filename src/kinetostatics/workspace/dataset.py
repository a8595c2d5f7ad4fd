"""The Dataset of a sweep: dimensions, variables, units and labels, from the table of quantities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.analysis import analyzed
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.math.arrays import Values
from kinetostatics.math.rotations import orientation_named
from kinetostatics.quantities import UNITS, VARIABLES, Entry, axes_of, units_along
from kinetostatics.results.contributions import MECHANISMS
from kinetostatics.results.parts import wrench_units
from kinetostatics.status import Status
from kinetostatics.units import PLATFORM_UNITS
from kinetostatics.workspace.sweep_plan import SweepPlan

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

#: A coordinate has a local freedom if a random shift by at most MOVED, followed by closure of the loops, changes it by more
#: than CHANGED [m, rad].
MOVED, CHANGED = 0.05, 1e-5
#: Values of ``mode``: a pose is reached in the assembly mode of the zero pose, or not reached.
REACHED, NOT_REACHED = 0, -1


@dataclass(frozen=True)
class Labels:
    """Labels of the Dataset's dimensions besides those of the grid; the same for all robots of a sweep.

    Attributes:
        axes: labels by dimension, including unused dimensions.
        auxiliary: dimensions and values, by name, of coordinates that are no dimensions (units, limbs, labels of wrenches).
        undetermined: for each model coordinate, whether local freedoms change it; comparisons of assembly modes ignore it then.
        limits: names of the limits of :class:`.Margins`, if the smallest safety factor is among the outputs.
    """

    robot: str
    axes: Mapping[str, tuple[str, ...]]
    auxiliary: Mapping[str, tuple[tuple[str, ...], Sequence[object]]]
    undetermined: tuple[bool, ...]
    outputs: tuple[str, ...]
    limits: tuple[str, ...] = ()

    @property
    def variables(self) -> dict[str, Entry]:
        return {name: VARIABLES[name] for name in self.outputs}

    @property
    def dims(self) -> set[str]:
        """Dimensions of the variables besides the dimensions of the grid."""
        return {dim for variable in self.variables.values() for dim in variable.dims}


def _flags(words: Mapping[int, str], dtype: type[np.generic] = np.int8) -> dict[str, object]:
    meanings = " ".join(word.replace(" ", "_") for word in words.values())
    return {"flag_values": np.array(list(words), dtype=dtype), "flag_meanings": meanings}


#: Descriptions of the dimensions besides those of the grid.
_AXES = {
    "component": "component of twists and wrenches about o, world axes",
    "component_2": "component of twists and wrenches about o, world axes",
    "source": "contribution to the twist",
    "mechanism": "mechanism by which gravity acts",
    "actuator": "actuated joint",
    "wrench": "constraint wrench of a limb",
    "attached_wrench": "gravity-attached constraint wrench of a limb",
    "platform_coordinate": "coordinate of the platform",
    "joint_coordinate": "coordinate of the model",
    "beam": "beam",
    "spring": "spring",
    "natural_mode": "natural mode, by ascending frequency",
}
#: Attributes of variables with coded values.
FLAGS: Mapping[str, Mapping[str, object]] = {
    "status": _flags({int(status): status.name.lower() for status in Status}),
    "mode": _flags({NOT_REACHED: "none_found", REACHED: "mode_of_the_zero_pose"}),
}


def attributes_of(name: str, labels: Labels) -> dict[str, object]:
    """Return the attributes of a variable. Without a common unit, ``unit_coordinate`` names the Dataset's coordinate of units."""
    entry = VARIABLES[name]
    units = {"unit_coordinate" if entry.unit in UNITS else "units": entry.unit} if entry.unit else {}
    flags = FLAGS.get(name, {})
    if name == "limited_by":
        flags = _flags({-1: "none", **dict(enumerate(labels.limits))}, np.int16)
    return {"long_name": entry.words, **units, **flags}


def numbered(labels: Iterable[str]) -> list[str]:
    """Return labels, with " (2)", " (3)", … appended to repeated labels."""
    seen: dict[str, int] = {}
    distinct = []
    for label in labels:
        seen[label] = seen.get(label, 0) + 1
        distinct.append(label if seen[label] == 1 else f"{label} ({seen[label]})")
    return distinct


def labels_of(plan: SweepPlan, robot: Robot) -> Labels:
    generic = robot.configuration(robot.model_q(robot.generic_poses).T, closure_tolerance=np.inf, on_failure="nan")
    result = analyzed(generic, replace(plan.case, frame="world", engine="auto"), "nan")
    q, pose = _q_labels(robot), orientation_named(plan.orientation).pose_names
    axes: dict[str, tuple[str, ...]] = {
        **axes_of(robot.statics),
        "source": tuple(result.contributions),
        "mechanism": MECHANISMS,
        "beam": tuple(robot.description.beams),
        "platform_coordinate": pose,
        "joint_coordinate": tuple(name for name, _ in q),
        "natural_mode": tuple(str(k + 1) for k in range(plan.modes)),
    }
    units = units_along(robot.statics)
    auxiliary: dict[str, tuple[tuple[str, ...], Sequence[object]]] = {}
    for variable in VARIABLES.values():  # the first variable with a unit has no other dimension
        if variable.unit in units:
            auxiliary.setdefault(variable.unit, (variable.dims, units[variable.unit]))
    for kind, names, columns in (("", "labels", "constraint_wrenches"), ("attached_", "attached_labels", "attached_wrenches")):
        limbs = [(limb.name, numbered(getattr(limb, names)), getattr(limb, columns)) for limb in result.limbs.values()]
        axes[f"{kind}wrench"] = tuple(f"{limb}: {label}" for limb, labels, _ in limbs for label in labels)
        auxiliary[f"{kind}limb"] = (f"{kind}wrench",), [limb for limb, labels, _ in limbs for _ in labels]
        auxiliary[f"{kind}label"] = (f"{kind}wrench",), [label for _, labels, _ in limbs for label in labels]
        units_of = [unit for _, labels, wrenches in limbs for unit in wrench_units(labels, wrenches)]
        auxiliary[f"{kind}wrench_unit"] = (f"{kind}wrench",), units_of
    auxiliary["platform_coordinate_unit"] = ("platform_coordinate",), [PLATFORM_UNITS[name] for name in pose]
    auxiliary["joint_coordinate_unit"] = ("joint_coordinate",), [unit for _, unit in q]
    outputs = [name for name, variable in VARIABLES.items() if variable.group == "always" or name in plan.outputs]
    there = tuple(name for name in outputs if all(axes[dim] for dim in VARIABLES[name].dims))
    limits = result.margins.limits if "limited_by" in there else ()
    return Labels(robot.name, axes, auxiliary, undetermined_coordinates(plan, robot), there, limits)


def undetermined_coordinates(plan: SweepPlan, robot: Robot) -> tuple[bool, ...]:
    """Return for each model coordinate whether local freedoms change it, such as the spin of a rod between two spherical joints.

    A generic pose is disturbed at random, and its loops are closed again at constant prescribed coordinates.
    """
    if not robot.mobility.local:
        return (False,) * robot.mechanism.tree.nq
    q = robot.model_q(robot.generic_poses)[:, 0]
    pose = robot.configuration(q, closure_tolerance=np.inf, on_failure="nan")
    values = pose.platform_coordinates(plan.orientation) if plan.kind == "platform" else pose.actuators
    names = [*plan.held, *(axis.name for axis in plan.axes_of("coordinate"))]
    random = np.random.default_rng(6)
    starts = q + random.uniform(-MOVED, MOVED, (32, len(q)))
    near = robot.configuration(starts, closure_tolerance=np.inf, on_failure="nan")
    try:
        closed = plan.assemble(robot, {name: np.full(len(starts), float(values[name])) for name in names}, near)
    except (KinetostaticsError, KeyError):  # reported by the checks of the plan
        return (False,) * robot.mechanism.tree.nq
    ends = closed.q[closed.status != Status.UNREACHABLE]
    if len(ends) < 2:
        model = robot.mechanism.model
        return tuple(
            n not in robot.description.actuated for n, count in zip(model.names, model.nqs, strict=True) for _ in range(count)
        )
    return tuple((np.ptp(ends, axis=0) > CHANGED).tolist())


def _q_labels(robot: Robot) -> list[tuple[str, str]]:
    model, connections = robot.mechanism.model, robot.mechanism.connections
    labels: list[tuple[str, str]] = [("", "1")] * model.nq
    for name, first, count in zip(list(model.names), list(model.idx_qs), list(model.nqs), strict=True):
        if count == 1:
            labels[first] = name, connections[name].type.unit if name in connections else "rad"
        for k in range(count if count > 1 else 0):
            part = ("cos", "sin")[k] if count == 2 else str(k)
            labels[first + k] = f"{name}:{part}", "1"
    return labels


def _reported_names(labels: Labels) -> list[str]:
    """Return the names of the auxiliary coordinates (units, limbs, labels) along dimensions of the variables."""
    dims, units = labels.dims, {variable.unit for variable in labels.variables.values()}
    return [
        name for name, (axes, _) in labels.auxiliary.items() if {*axes} <= dims and (name in units or not name.endswith("_unit"))
    ]


def check_names(plan: SweepPlan, labels: Labels, named: Iterable[str] = ()) -> None:
    """Check that the names of dimensions and constants are unique in the Dataset, and that the outputs ``named`` exist."""
    for name in named:
        for dim in VARIABLES[name].dims if name in VARIABLES else ():
            if not labels.axes[dim]:
                raise ArgumentError(f"{labels.robot!r} has no {_AXES[dim]}: there is no output {name!r}")
    taken = {*labels.outputs, *labels.dims, *_reported_names(labels)}
    for name in (*(axis.name for axis in plan.axes), *plan.held, *plan.constants):
        if name in taken:
            raise ArgumentError(
                f"{name!r} cannot be the name of a dimension or coordinate: the name is used in the Dataset, or given twice"
            )
        taken.add(name)


def coordinates(plan: SweepPlan, labels: Labels) -> dict[str, xr.Variable]:
    import xarray as xr

    coords: dict[str, xr.Variable] = {}
    for axis in plan.axes:
        units = {"units": axis.units} if axis.units else {}
        coords[axis.name] = xr.Variable((axis.name,), _stored(axis.values), {"long_name": axis.long_name, **units})
    dim, unit = ("platform_coordinate",) * 2 if plan.kind == "platform" else ("actuator", "actuator_position")
    units_of_coordinates = dict(zip(labels.axes[dim], labels.auxiliary[f"{unit}_unit"][1], strict=True))
    for name, value in plan.held.items():
        held = {"long_name": f"{name}, the same at all poses", "units": units_of_coordinates[name]}
        coords[name] = xr.Variable((), value, held)
    for name, constant in plan.constants.items():
        attributes = {"long_name": f"parameter {name} of the robot file, the same at all poses"}
        coords[name] = xr.Variable((), _stored(np.asarray(constant)), attributes)
    for name in (name for name in _AXES if name in labels.dims):
        coords[name] = xr.Variable((name,), np.array(labels.axes[name], dtype=object), {"long_name": _AXES[name]}, fastpath=True)
    for name in _reported_names(labels):
        dims, values = labels.auxiliary[name]
        texts = np.array(values, dtype=str)
        texts = np.char.replace(texts, "·", " ") if name in UNITS else texts
        coords[name] = xr.Variable(dims, texts.astype(object), fastpath=True)  # fastpath: no search for dates
    return coords


def _stored(values: Values) -> Values:
    """Return an array in a type that files support: strings as objects, truth values as integers."""
    if values.dtype.kind == "U":
        return values.astype(object)
    return values.astype(np.int8) if values.dtype.kind == "b" else values


def shapes(plan: SweepPlan, labels: Labels) -> dict[str, tuple[int, ...]]:
    return {
        name: (
            *(axis.size for axis in plan.axes if axis.kind in variable.varies),
            *(len(labels.axes[dim]) for dim in variable.dims),
        )
        for name, variable in labels.variables.items()
    }


def dataset(plan: SweepPlan, labels: Labels, arrays: Mapping[str, object], attributes: Mapping[str, object]) -> xr.Dataset:
    import xarray as xr

    data = {}
    for name, array in arrays.items():
        variable = labels.variables[name]
        dims = (*(axis.name for axis in plan.axes if axis.kind in variable.varies), *variable.dims)
        data[name] = xr.Variable(dims, array, attributes_of(name, labels))
    return xr.Dataset(data, coordinates(plan, labels), attributes)
