"""How the Dataset of a sweep is laid out: dimensions, variables, units, labels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.math.arrays import Values
from kinetostatics.math.orientation import orientation_named
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS
from kinetostatics.reports.json import actuator_unit, wrench_units
from kinetostatics.results.gravity_ways import WAYS
from kinetostatics.status import FACTS, Status
from kinetostatics.workspace.grid import LENGTHS
from kinetostatics.workspace.sweep_spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

WRENCH_UNITS = ("N", "N", "N", "N m", "N m", "N m")

#: Kinds of axes along which variables vary: all, those that change the pose, or those that change the robot.
EVERYTHING, POSES, ROBOTS = ("parameter", "case", "coordinate"), ("parameter", "coordinate"), ("parameter",)

#: Coordinates that change by more than the second when all are moved by the first and the loops closed again are loose.
MOVED, CHANGED = 0.05, 1e-5
#: ``mode``: which assembly mode reaches a pose.
ZERO_MODE, OTHER_MODE, NO_MODE = 0, 1, -1


@dataclass(frozen=True)
class Labels:
    """What the entries of the Dataset's further dimensions are called; the same for all robots of a sweep.

    Attributes:
        robot: the robot's name.
        sources: contributions to the twist.
        ways: in which gravity acts, if they are wanted.
        actuators: their names, and ``turning``: which of them turn.
        wrenches: (limb, label, units) of every constraint wrench, and ``attached`` of every attached one.
        beams: names of the beams whose numbers are wanted.
        q: (label, units) of Pinocchio's coordinates.
        loose: which of them local freedoms change, so that they say nothing of the assembly mode.
        pose: names of the six coordinates of the platform.
        compensated: whether corrections of the actuators are wanted.
        springs: names of the springs.
    """

    robot: str
    sources: tuple[str, ...]
    ways: tuple[str, ...]
    actuators: tuple[str, ...]
    turning: tuple[bool, ...]
    wrenches: tuple[tuple[str, str, str], ...]
    attached: tuple[tuple[str, str, str], ...]
    beams: tuple[str, ...]
    q: tuple[tuple[str, str], ...]
    loose: tuple[bool, ...]
    pose: tuple[str, ...]
    compensated: bool
    springs: tuple[str, ...]


@dataclass(frozen=True)
class Variable:
    """One variable.

    Attributes:
        labels: its dimensions beyond the grid's.
        long_name: what it is.
        unit: of its numbers, or the coordinate that tells the units, whose name ends in ``_unit``; empty: it has none.
        kinds: of axes along which it varies.
        dtype: of its numbers.
        flags: attributes of variables whose numbers stand for words.
    """

    labels: tuple[str, ...]
    long_name: str
    unit: str = ""
    kinds: tuple[str, ...] = EVERYTHING
    dtype: type[np.generic] = np.float64
    flags: Mapping[str, object] = field(default_factory=dict)

    @property
    def attributes(self) -> dict[str, object]:
        """Return its attributes in the Dataset."""
        units = {"unit_coordinate" if self.unit.endswith("_unit") else "units": self.unit} if self.unit else {}
        return {"long_name": self.long_name, **units, **self.flags}

    @property
    def nothing(self) -> object:
        """Return what stands where nothing has been written."""
        return NO_MODE if self.dtype == np.int8 else False if self.dtype == np.bool_ else np.nan

    def dims(self, spec: SweepSpec) -> tuple[str, ...]:
        """Return the names of all its dimensions."""
        return (*(axis.name for axis in spec.axes if axis.kind in self.kinds), *self.labels)


def _flags(words: Mapping[int, str]) -> dict[str, object]:
    return {"flag_values": np.array(list(words), dtype=np.int8), "flag_meanings": " ".join(words.values())}


_STATUSES = _flags({int(item): item.name.lower() for item in Status})
_MODES = _flags({NO_MODE: "none_found", ZERO_MODE: "mode_of_the_zero_pose", OTHER_MODE: "only_another_mode"})
_MATRIX = ("component", "component_2")

#: The variables over the grid, in the Dataset's order.
VARIABLES: Mapping[str, Variable] = {
    "status": Variable((), "what became of the pose, the worst of it", dtype=np.int8, flags=_STATUSES),
    **{name: Variable((), fact.words, dtype=np.bool_) for name, fact in FACTS.items()},
    "mode": Variable((), "assembly mode that reaches the pose", kinds=POSES, dtype=np.int8, flags=_MODES),
    "twist": Variable(("component",), "displacement of o and rotation of the platform, world axes", "component_unit"),
    "contribution": Variable(
        ("source", "component"), "what load, platform weight and each limb's weight add to the twist", "component_unit"
    ),
    "gravity_way": Variable(
        ("way", "component"), "what gravity adds to the twist in each of its ways, all limbs together", "component_unit"
    ),
    "actuator_force": Variable(("actuator",), "force or torque of the actuator, positive along its joint", "actuator_force_unit"),
    "actuator_gravity_way": Variable(
        ("actuator", "way"), "what gravity adds to the actuator's force in each of its ways", "actuator_force_unit"
    ),
    "actuator_contribution": Variable(
        ("actuator", "source"), "what each contribution to the twist adds to the actuator's force", "actuator_force_unit"
    ),
    "intensity": Variable(("wrench",), "intensity of the constraint wrench", "wrench_unit"),
    "attached_intensity": Variable(
        ("attached_wrench",), "intensity of the gravity-attached constraint wrench", "attached_wrench_unit"
    ),
    "stiffness": Variable(_MATRIX, "tangent stiffness at o, actuators locked, world axes", "stiffness_unit", POSES),
    "compliance": Variable(_MATRIX, "compliance at o, actuators locked, world axes", "compliance_unit", POSES),
    "actuator_position": Variable(("actuator",), "coordinate of the driven joint", "actuator_position_unit", POSES),
    "actuator_correction": Variable(
        ("actuator",), "correction of the actuator, which brings the loaded platform in place", "actuator_position_unit"
    ),
    "remaining": Variable(
        ("component",), "how the loaded platform misses its place at the corrected actuators", "component_unit"
    ),
    "spring_force": Variable(("spring",), "tension of the spring, negative where it pushes", "N", POSES),
    "platform_pose": Variable(
        ("platform_coordinate",), "coordinates of the platform before it deforms", "platform_coordinate_unit", POSES
    ),
    "q": Variable(
        ("joint_coordinate",), "coordinates of the model, as Robot.configuration takes them", "joint_coordinate_unit", POSES
    ),
    "characteristic_length": Variable((), "mean distance of the limbs' outer joints from o", "m", ROBOTS),
    "beam_stress": Variable(("beam",), "largest von Mises stress of the beam", "Pa"),
    "beam_euler_ratio": Variable(("beam",), "forces over those at which the member buckles", "1"),
    "beam_deflection": Variable(("beam",), "largest displacement of the beam's centre line", "m"),
}


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
    generic = robot.configuration(robot.model_q(robot.generic_poses).T, tolerance=np.inf, on_failure="nan")
    result = analyze(generic, **spec.extras, on_failure="nan")
    wrenches: list[tuple[str, str, str]] = []
    attached: list[tuple[str, str, str]] = []
    for limb in result.limbs.values():
        for found, names, columns in (
            (wrenches, limb.labels, limb.constraint_wrenches),
            (attached, limb.attached_labels, limb.attached_wrenches),
        ):
            units = [unit.replace("·", " ") for unit in wrench_units(names, columns)]
            found += [(limb.name, name, unit) for name, unit in zip(numbered(names), units, strict=True)]
    actuators = robot.description.driven
    return Labels(
        robot.name,
        tuple(result.contributions),
        WAYS if spec.ways else (),
        actuators,
        tuple(actuator_unit(robot, name) != "N" for name in actuators),
        tuple(wrenches),
        tuple(attached),
        tuple(result.beams) if spec.beams else (),
        tuple(_q_labels(robot)),
        loose_coordinates(spec, robot),
        orientation_named(spec.orientation).pose_names,
        bool(spec.compensated),
        tuple(robot.description.springs),
    )


def loose_coordinates(spec: SweepSpec, robot: Robot) -> tuple[bool, ...]:
    """Return which model coordinates local freedoms change: a rod that spins between two spherical joints.

    They are what a pose's coordinates leave open, at a generic pose that is left a little and closed again.
    """
    if not robot.mobility.local:
        return (False,) * robot.mechanism.tree.nq
    q = robot.model_q(robot.generic_poses)[:, 0]
    pose = robot.configuration(q, tolerance=np.inf, on_failure="nan")
    known = pose.platform_coordinates(spec.orientation) if spec.kind == "platform" else pose.actuators
    names = [*spec.held, *(axis.name for axis in spec.axes_of("coordinate"))]
    random = np.random.default_rng(6)
    starts = q + random.uniform(-MOVED, MOVED, (32, len(q)))
    near = robot.configuration(starts, tolerance=np.inf, on_failure="nan")
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


def variables(labels: Labels) -> dict[str, Variable]:
    """Return the variables that a Dataset with these labels has."""
    sizes = {name: len(values) for name, (values, _) in _label_coordinates(labels).items()}
    unwanted: tuple[str, ...] = () if labels.ways else ("actuator_contribution",)
    unwanted += () if labels.compensated else ("actuator_correction", "remaining")
    return {name: item for name, item in VARIABLES.items() if name not in unwanted and all(sizes[label] for label in item.labels)}


def _label_coordinates(labels: Labels) -> dict[str, tuple[list[str], str]]:
    """Return the entries of the dimensions that the grid does not have, and what they are."""
    return {
        "component": (list(COMPONENTS), "component of twists and wrenches about o, world axes"),
        "component_2": (list(COMPONENTS), "component of twists and wrenches about o, world axes"),
        "source": (list(labels.sources), "what contributes to the twist"),
        "way": (list(labels.ways), "how gravity acts"),
        "actuator": (list(labels.actuators), "driven joint"),
        "wrench": ([f"{limb}: {label}" for limb, label, _ in labels.wrenches], "constraint wrench of a limb"),
        "attached_wrench": (
            [f"{limb}: {name}" for limb, name, _ in labels.attached],
            "gravity-attached constraint wrench of a limb",
        ),
        "platform_coordinate": (list(labels.pose), "coordinate of the platform"),
        "joint_coordinate": ([name for name, _ in labels.q], "coordinate of the model"),
        "beam": (list(labels.beams), "beam"),
        "spring": (list(labels.springs), "spring"),
    }


def _unit_coordinates(labels: Labels) -> dict[str, tuple[tuple[str, ...], object]]:
    """Return names, dimensions and values of coordinates that say units, limbs and labels."""
    degrees = tuple("rad" if turning else "m" for turning in labels.turning)
    stiffness = [[f"{force}/{move}" for move in TWIST_UNITS] for force in WRENCH_UNITS]
    compliance = [[f"{move}/({force})" if " " in force else f"{move}/{force}" for force in WRENCH_UNITS] for move in TWIST_UNITS]
    found: dict[str, tuple[tuple[str, ...], object]] = {
        "component_unit": (("component",), TWIST_UNITS),
        "stiffness_unit": (("component", "component_2"), stiffness),
        "compliance_unit": (("component", "component_2"), compliance),
        "actuator_force_unit": (("actuator",), ["N m" if turning else "N" for turning in labels.turning]),
        "actuator_position_unit": (("actuator",), degrees),
        "limb": (("wrench",), [limb for limb, _, _ in labels.wrenches]),
        "label": (("wrench",), [label for _, label, _ in labels.wrenches]),
        "wrench_unit": (("wrench",), [unit for _, _, unit in labels.wrenches]),
        "attached_limb": (("attached_wrench",), [limb for limb, _, _ in labels.attached]),
        "attached_label": (("attached_wrench",), [label for _, label, _ in labels.attached]),
        "attached_wrench_unit": (("attached_wrench",), [unit for _, _, unit in labels.attached]),
        "platform_coordinate_unit": (("platform_coordinate",), ["m" if name in LENGTHS else "rad" for name in labels.pose]),
        "joint_coordinate_unit": (("joint_coordinate",), [unit for _, unit in labels.q]),
    }
    sizes = {name: len(values) for name, (values, _) in _label_coordinates(labels).items()}
    return {name: item for name, item in found.items() if all(sizes[dim] for dim in item[0])}


def check_names(spec: SweepSpec, labels: Labels) -> None:
    """See to it that no dimension or held value is called like something else in the Dataset.

    Raises:
        ArgumentError: one is, or two are called alike.
    """
    dimensions = (name for name, (values, _) in _label_coordinates(labels).items() if values)
    taken = {*variables(labels), *dimensions, *_unit_coordinates(labels)}
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
    for name, value in spec.held.items():
        slides = name in LENGTHS if spec.kind == "platform" else not labels.turning[labels.actuators.index(name)]
        units = {"units": "m" if slides else "rad"}
        found[name] = xr.Variable((), value, {"long_name": f"{name}, the same at all poses", **units})
    for name, constant in spec.constants.items():
        attributes = {"long_name": f"parameter {name} of the robot file, the same at all poses"}
        found[name] = xr.Variable((), _stored(np.asarray(constant)), attributes)
    for name, (values, long_name) in _label_coordinates(labels).items():
        if values:
            found[name] = xr.Variable((name,), np.array(values, dtype=object), {"long_name": long_name})
    for name, (dims, items) in _unit_coordinates(labels).items():
        found[name] = xr.Variable(dims, np.array(items, dtype=object))
    return found


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
        dims = item.dims(spec)
        nothing = np.array(item.nothing, dtype=item.dtype)
        data[name] = xr.Variable(dims, np.broadcast_to(nothing, tuple(sizes[dim] for dim in dims)), item.attributes)
    return xr.Dataset(data, coords=coords)
