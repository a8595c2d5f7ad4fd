"""How the Dataset of a sweep is laid out: dimensions, variables, units, labels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.analysis import analyze
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.orientation import orientation_named
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS
from kinetostatics.reports.json import drive_unit, wrench_units
from kinetostatics.results.gravity_ways import WAYS
from kinetostatics.status import FACTS, Status
from kinetostatics.workspace.loose_joints import loose_coordinates
from kinetostatics.workspace.sweep_spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

WRENCH_UNITS = ("N", "N", "N", "N m", "N m", "N m")

#: Kinds of axes along which variables vary: all, those that change the pose, or those that change the robot.
EVERYTHING, POSES, ROBOTS = ("parameter", "case", "coordinate"), ("parameter", "coordinate"), ("parameter",)

#: ``mode``: which assembly mode reaches a pose.
ZERO_MODE, OTHER_MODE, NO_MODE = 0, 1, -1


@dataclass(frozen=True)
class Labels:
    """What the entries of the Dataset's further dimensions are called; the same for all robots of a sweep.

    Attributes:
        robot: the robot's name.
        sources: contributions to the twist.
        ways: in which gravity acts, if they are wanted.
        actuators: drives, and ``turning``: which of them turn.
        wrenches: (limb, label, units) of every constraint wrench, and ``attached`` of every attached one.
        beams: names of the beams whose numbers are wanted.
        q: (label, units) of Pinocchio's coordinates.
        loose: which of them local freedoms change, so that they say nothing of the assembly mode.
        pose: names of the six coordinates of the platform.
        compensated: whether corrections of the drives are wanted.
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


@dataclass(frozen=True)
class Variable:
    """One variable: its dimensions beyond the grid's, attributes, kinds of axes along which it varies, type."""

    labels: tuple[str, ...]
    attributes: dict[str, Any]
    kinds: tuple[str, ...] = EVERYTHING
    dtype: Any = field(default=np.float64)

    @property
    def nothing(self) -> object:
        """Return what stands where nothing has been written."""
        return NO_MODE if self.dtype == np.int8 else False if self.dtype == np.bool_ else np.nan

    def dims(self, spec: SweepSpec) -> tuple[str, ...]:
        """Return the names of all its dimensions."""
        return (*self.grid(spec), *self.labels)

    def grid(self, spec: SweepSpec) -> tuple[str, ...]:
        """Return the names of the dimensions that it shares with the grid."""
        return tuple(axis.name for axis in spec.axes if axis.kind in self.kinds)


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
    drives = robot.description.driven
    return Labels(
        robot.name,
        tuple(result.contributions),
        WAYS if spec.ways else (),
        drives,
        tuple(drive_unit(robot, name) != "N" for name in drives),
        tuple(wrenches),
        tuple(attached),
        tuple(result.beams) if spec.beams else (),
        tuple(_q_labels(robot)),
        loose_coordinates(spec, robot),
        orientation_named(spec.orientation).pose_names,
        bool(spec.compensated),
    )


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
    """Return the variables over the grid, in the Dataset's order."""
    units = {"unit_coordinate": "component_unit"}
    statuses = {
        "long_name": "what became of the pose, the worst of it",
        "flag_values": np.array([int(item) for item in Status], dtype=np.int8),
        "flag_meanings": " ".join(item.name.lower() for item in Status),
    }
    modes = {
        "long_name": "assembly mode that reaches the pose",
        "flag_values": np.array([NO_MODE, ZERO_MODE, OTHER_MODE], dtype=np.int8),
        "flag_meanings": "none_found mode_of_the_zero_pose only_another_mode",
    }
    force = "unit_coordinate"
    found = {
        "status": Variable((), statuses, dtype=np.int8),
        **{name: Variable((), {"long_name": fact.words}, dtype=np.bool_) for name, fact in FACTS.items()},
        "mode": Variable((), modes, kinds=POSES, dtype=np.int8),
        "twist": Variable(("component",), {"long_name": "displacement of o and rotation of the platform, world axes", **units}),
        "contribution": Variable(
            ("source", "component"), {"long_name": "what load, platform weight and each limb's weight add to the twist", **units}
        ),
        "gravity_way": Variable(
            ("way", "component"), {"long_name": "what gravity adds to the twist in each of its ways, all limbs together", **units}
        ),
        "actuator_force": Variable(
            ("actuator",), {"long_name": "force or torque of the drive, positive along its joint", force: "actuator_force_unit"}
        ),
        "actuator_gravity_way": Variable(
            ("actuator", "way"),
            {"long_name": "what gravity adds to the drive's force in each of its ways", force: "actuator_force_unit"},
        ),
        "actuator_contribution": Variable(
            ("actuator", "source"),
            {"long_name": "what each contribution to the twist adds to the drive's force", force: "actuator_force_unit"},
        ),
        "intensity": Variable(("wrench",), {"long_name": "intensity of the constraint wrench", force: "wrench_unit"}),
        "attached_intensity": Variable(
            ("attached_wrench",),
            {"long_name": "intensity of the gravity-attached constraint wrench", force: "attached_wrench_unit"},
        ),
        "stiffness": Variable(
            ("component", "component_2"),
            {"long_name": "tangent stiffness at o, drives locked, world axes", force: "stiffness_unit"},
            kinds=POSES,
        ),
        "compliance": Variable(
            ("component", "component_2"),
            {"long_name": "compliance at o, drives locked, world axes", force: "compliance_unit"},
            kinds=POSES,
        ),
        "actuator_position": Variable(
            ("actuator",), {"long_name": "coordinate of the driven joint", force: "actuator_position_unit"}, kinds=POSES
        ),
        "actuator_correction": Variable(
            ("actuator",),
            {"long_name": "correction of the drive, which brings the loaded platform in place", force: "actuator_position_unit"},
        ),
        "remaining": Variable(
            ("component",), {"long_name": "how the loaded platform misses its place at the corrected drives", **units}
        ),
        "platform_pose": Variable(
            ("platform_coordinate",),
            {"long_name": "coordinates of the platform before it deforms", force: "platform_coordinate_unit"},
            kinds=POSES,
        ),
        "q": Variable(
            ("joint_coordinate",),
            {"long_name": "coordinates of the model, as Robot.configuration takes them", force: "joint_coordinate_unit"},
            kinds=POSES,
        ),
        "characteristic_length": Variable(
            (), {"long_name": "mean distance of the limbs' outer joints from o", "units": "m"}, kinds=ROBOTS
        ),
        "beam_stress": Variable(("beam",), {"long_name": "largest von Mises stress of the beam", "units": "Pa"}),
        "beam_euler_ratio": Variable(
            ("beam",), {"long_name": "axial forces over those at which the member buckles by Euler", "units": "1"}
        ),
        "beam_deflection": Variable(("beam",), {"long_name": "largest displacement of the beam's centre line", "units": "m"}),
    }
    sizes = {name: len(values) for name, (values, _) in _label_coordinates(labels).items()}
    unwanted: tuple[str, ...] = () if labels.ways else ("actuator_contribution",)
    unwanted += () if labels.compensated else ("actuator_correction", "remaining")
    return {name: item for name, item in found.items() if name not in unwanted and all(sizes[label] for label in item.labels)}


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
            [f"{limb}: {label}" for limb, label, _ in labels.attached],
            "gravity-attached constraint wrench of a limb",
        ),
        "platform_coordinate": (list(labels.pose), "coordinate of the platform"),
        "joint_coordinate": ([name for name, _ in labels.q], "coordinate of the model"),
        "beam": (list(labels.beams), "beam"),
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
        "platform_coordinate_unit": (
            ("platform_coordinate",),
            ["m" if name in ("x", "y", "z") else "rad" for name in labels.pose],
        ),
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
        units = {"units": _held_units(spec, labels, name)}
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


def _held_units(spec: SweepSpec, labels: Labels, name: str) -> str:
    if spec.kind == "platform":
        return "m" if name in ("x", "y", "z") else "rad"
    return "rad" if labels.turning[labels.actuators.index(name)] else "m"


def _stored(values: NDArray[np.generic]) -> NDArray[np.generic]:
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
        data[name] = xr.Variable(dims, np.broadcast_to(nothing, tuple(sizes[dim] for dim in dims)), dict(item.attributes))
    return xr.Dataset(data, coords=coords)
