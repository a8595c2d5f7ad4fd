"""Robots and results as plain numbers, strings, lists and dicts, fit for JSON.

Everything is in SI units; what is not a number, infinite or not determined is None.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.checks.chains import Body, JointStep, Network, Ways
from kinetostatics.checks.collect import robot_facts
from kinetostatics.checks.facts import RobotFacts
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, Values
from kinetostatics.printing.dispatch import dict_of
from kinetostatics.quantities import QUANTITIES, told_of
from kinetostatics.results.beam import BeamResult
from kinetostatics.results.limb import LimbResult
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.status import Status

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: What a result tells of its beams: not again what the file says.
BEAM_NAMES = [item.name for item in dataclasses.fields(BeamResult) if item.name not in ("name", "description")]
#: What the numbers of a result mean; batch axes come first.
RESULT_UNITS = {
    "general": "SI: m, rad, kg, s, N, N·m, Pa; world axes; null: not a number, infinite or not determined",
    "batch": "arrays have the axes of `shape` first, those of `configuration` the axes of `configuration.shape`",
    "payload": "mass kg at center m of the frame of link, null: of o-xyz; coefficients: what it does per kg and per kg·m of its "
    "first moment: twist, actuator_forces and joint_wrenches per unit of `parameters`, the last axis",
    "limbs": "wrenches acting on the limb: unit wrenches [force; moment] about o, intensities in `units`; where "
    "`is_network`, intensities are coordinates in a basis: the forces are `joint_wrenches` of its `platform_joints` and "
    "`section_wrenches` of its `beams`",
    "stations": "0 at the base end, 1 at the platform end of a beam; deflections in m, rotations in rad, stress in Pa",
    **{name: QUANTITIES[name].said for name in told_of("")},
    **{name: QUANTITIES[f"beams.{name}"].said for name in told_of("beams") if name in BEAM_NAMES},
}

ROBOT_UNITS = {
    "general": "SI: m, rad, kg, Pa; null: infinite, not known or not given",
    "mobility": "numbers of freedoms and constraints at generic poses; redundancies: where the redundant constraints are",
    "zero": "loop_gaps where all joints are at zero; drives [m, rad] and closing_error [scaled m or rad] at the closed zero pose",
    "mass": "kg at the zero pose",
    "graph": "chain from base to platform: bodies, joints, parallel ways, networks; hanging: what hangs on a body",
    "depth": "m, the section's larger side or diameter",
    "shear_areas": "m², null: no shear deformation",
    "thermal_expansion": "1/K",
    "elastic_joints": "linear [N/m] along, angular [N·m/rad] about axes of the joint's frame; drive: its actuator; null: rigid",
    "springs": "between links: stiffness N/m, free_length m, preload N: the tension at the free length",
    "followers": "multiplier times the leader's coordinate plus offset [m, rad]",
}

#: What is told of springs between links: not where their ends are.
SPRING_NAMES = ("name", "predecessor", "successor", "stiffness", "free_length", "preload")


def plain(value: object) -> object:
    """Return a value as what JSON knows; numbers that are not finite become None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _plain_fields(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic, float)) and not isinstance(value, np.str_):
        array = np.asarray(value)
        if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
            missing = ~np.isfinite(array)
            array = array.astype(object)
            array[missing] = None
        return array.tolist()
    return value


def robot_to_dict(robot: Robot) -> dict[str, object]:
    """Return what there is to know about a robot as plain values: what ``check --json`` prints."""
    return facts_to_dict(robot_facts(robot))


def _plain_fields(value: DataclassInstance) -> dict[str, object]:
    return {item.name: plain(getattr(value, item.name)) for item in dataclasses.fields(value)}


def facts_to_dict(facts: RobotFacts) -> dict[str, object]:
    """Return the facts about a robot as plain values."""
    found = _plain_fields(facts)
    found["springs"] = [named(item, SPRING_NAMES) for item in facts.springs]
    found["limbs"] = [{**_plain_fields(limb), "graph": _graph(limb.graph)} for limb in facts.limbs]
    for role, weight in (("on_base", facts.on_base), ("on_platform", facts.on_platform)):
        if weight is not None:
            found[role] = {**_plain_fields(weight), "graph": _graph(weight.graph)}
    return {**found, "units": dict(ROBOT_UNITS)}


_TYPES = {Body: "body", JointStep: "joint", Ways: "ways", Network: "network"}


def _graph(part: object) -> object:
    """Return a graph, or a part of one, as plain values; what stands in a chain says its ``type``."""
    if isinstance(part, tuple):
        return [_graph(item) for item in part]
    if not dataclasses.is_dataclass(part):
        return part
    kind = {"type": _TYPES[type(part)]} if type(part) in _TYPES else {}
    return {**kind, **{item.name: _graph(getattr(part, item.name)) for item in dataclasses.fields(part)}}


@dict_of.register(Result)
def result_to_dict(result: Result) -> dict[str, object]:
    """Return everything that an analysis found as plain values: what ``analyze --json`` prints.

    Arrays keep the shapes that they have in the result, batch axes first.
    """
    robot = result.robot
    found: dict[str, object] = {
        "robot": robot.name,
        "file": robot.description.path,
        "units": dict(RESULT_UNITS),
        "shape": list(result.shape),
        "status": status_names(result.status),
        **{name: plain(where) for name, where in result.facts.items()},
        "warnings": list(result.warnings),
        "configuration": _configuration(result.configuration),
        "payload": _payload(result),
    }
    found |= named(result, told_of(""))
    found["actuator_units"] = {name: actuator_unit(robot, name) for name in result.actuator_forces}
    found["limbs"] = {name: _limb(limb) for name, limb in result.limbs.items()}
    found["beams"] = {name: named(beam, BEAM_NAMES) for name, beam in result.beams.items()}
    return found


def named(item: object, names: Iterable[str]) -> dict[str, object]:
    """Return some attributes as plain values."""
    return {name: plain(getattr(item, name)) for name in names}


def _payload(result: Result) -> dict[str, object] | None:
    if result.payload is None:
        return None
    payload, coefficients = result.payload, plain(result.payload_coefficients)
    return {**named(payload, ("mass", "center", "link")), "coefficients": coefficients}


def _configuration(configuration: Configuration) -> dict[str, object]:
    shape = configuration.shape
    return {
        "shape": list(shape),
        "status": status_names(configuration.status),
        "limit_exceeded": plain(configuration.limit_exceeded),
        "orientation": configuration.orientation.name,
        **named(configuration, ("platform", "platform_frame", "actuators", "q", "residual")),
        "loop_gaps": {
            name: {"m": plain(metres.reshape(shape)), "rad": plain(radians.reshape(shape))}
            for name, (metres, radians) in configuration.loop_gaps.items()
        },
        "limits_exceeded": plain(configuration.limits_exceeded),
    }


def _limb(limb: LimbResult) -> dict[str, object]:
    return {
        "is_network": limb.is_network,
        "beams": list(limb.beams),
        "platform_joints": list(limb.platform_joints),
        "labels": list(limb.labels),
        "units": wrench_units(limb.labels, limb.constraint_wrenches),
        "attached_labels": list(limb.attached_labels),
        "attached_units": wrench_units(limb.attached_labels, limb.attached_wrenches),
        **named(limb, told_of("limbs")),
    }


def status_names(status: Values) -> object:
    """Return statuses as their names, in nested lists for a batch."""
    names = np.array([item.name for item in Status], dtype=object)
    return names[np.asarray(status, dtype=int)].tolist() if np.ndim(status) else Status(int(status)).name


def wrench_units(labels: Sequence[str], wrenches: Array) -> list[str]:
    """Return the unit of each intensity: N·m of a couple, by its label or without a force part, else N."""
    units = []
    for k, label in enumerate(labels):
        forces = np.abs(wrenches[..., :3, k])
        known = forces[np.isfinite(forces)]
        couple = label.startswith("couple") or (known.size > 0 and bool(np.all(known < 1e-12)))
        units.append("N·m" if couple else "N")
    return units


def actuator_unit(robot: Robot, name: str) -> str:
    """Return the unit of an actuator's force."""
    return robot.mechanism.connections[name].type.force_unit
