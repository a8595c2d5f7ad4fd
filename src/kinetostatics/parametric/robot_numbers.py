"""Numbers of a robot's parts and its assembly errors, by name, and descriptions with other values of these numbers.

Assembly errors are ``JOINT.error.x`` … ``rz`` along and about the axes of the joint frame, ``BEAM.error.length`` and
``BEAM.error.temperature``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, JointStiffness, Link, Material, Origin, Spring
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.files.parameter_units import UNITS
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import exponential, orientation_named
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Section, sizes_of
from kinetostatics.sections.tapered import Tapered

#: Step of finite differences: a fraction of the number, a fraction of the robot's length for points, or a rotation [rad].
STEP = 1e-3
_MATERIAL = ("youngs_modulus", "shear_modulus", "poisson_ratio", "density")

#: Path of a number in a description: names of attributes, keys and indices.
Path = tuple[str | int, ...]
Part: TypeAlias = Any  # parts of a robot and their fields, mappings, tuples and numbers


@dataclass(frozen=True)
class RobotNumber:
    """A number of a robot: an argument of its file, or a number of a part.

    Attributes:
        name: name of the argument, or names of the part and its number: ``rod_1.outer_diameter``, ``revolute_1.placement.x``.
        unit: SI unit; "1" for a ratio; empty if unknown.
        value: value [SI]; for a component of a placement 0, because changes of a placement are displacements and rotations.
        step: step of finite differences; None if the number cannot be changed.
        description: description of the robot.
        path: for a number of a part, its path in the description.
        read: for an argument, function that returns the description with another value.
    """

    name: str
    unit: str
    value: float
    step: float | None
    description: RobotDescription
    path: Path = ()
    read: Callable[[float], RobotDescription] | None = None

    def changed(self, by: float) -> RobotDescription:
        """Return the robot's description with this number increased by ``by``; expressions of the file are evaluated again.

        Raises:
            RobotFileError: the file is invalid with this value.
            ArgumentError: the part cannot have this value.
        """
        return self.changed_in(self.description, by) if self.read is None else self.read(self.value + by)

    def changed_in(self, there: RobotDescription, by: float) -> RobotDescription:
        """Return another description with this number of a part increased by ``by``.

        Raises:
            ArgumentError: the part cannot have this value.
        """
        changed: RobotDescription = _changed(there, self.path, by)
        return changed

    def of(self, there: RobotDescription) -> float:
        """Return the value of this number of a part in another description; 0 for a component of a placement."""
        return _value(there, self.path)


def numbers_of_parts(robot: Robot) -> dict[str, tuple[RobotNumber, ...]]:
    """Return all numbers of parts by name; a vector or placement has all its components, even those that cannot be changed."""
    numbers: dict[str, tuple[RobotNumber, ...]] = {}
    for name, path, unit in _places(robot):
        quantity = _part_at(robot.description, path)
        if isinstance(quantity, Origin):
            steps: Sequence[float | None] = (STEP * robot.length,) * 3 + (STEP,) * 3
            values: Sequence[float] = (0.0,) * 6
        elif isinstance(quantity, Sequence):
            values, steps = quantity, [STEP * value if 0 < value < np.inf else None for value in quantity]
            steps = (STEP * robot.length,) * 3 if unit == "m" else steps
        elif quantity and math.isfinite(quantity):
            numbers[name] = (RobotNumber(name, unit, quantity, STEP * abs(quantity), robot.description, path),)
            continue
        else:
            continue
        rows = zip(COMPONENTS, values, steps, strict=False)
        numbers[name] = tuple(
            RobotNumber(f"{name}.{axis}", "rad" if k > 2 else unit, value, step, robot.description, (*path, k))
            for k, (axis, value, step) in enumerate(rows)
        )
    return numbers


def _places(robot: Robot) -> Iterator[tuple[str, Path, str]]:
    """Yield name, path and unit of every number, vector or frame of the parts."""
    there = robot.description
    for name, link in there.links.items():
        if link.mass > 0:
            for number, unit in UNITS[Link].items():
                yield f"{name}.{number}", ("links", name, number), unit
    for name, beam in there.beams.items():
        for within, numbers in (
            (("material",), {number: UNITS[Material][number] for number in _MATERIAL}),
            ((), UNITS[Beam]),
            (("section",), UNITS.get(type(beam.section), {})),
        ):
            for number, unit in numbers.items():
                yield f"{name}.{number}", ("beams", name, *within, number), unit
        for k, station in enumerate(beam.section.stations if isinstance(beam.section, Tapered) else ()):
            for number, unit in UNITS[type(station.section)].items():
                yield f"{name}.station_{k + 1}.{number}", ("beams", name, "section", "stations", k, "section", number), unit
    for name, part in there.flexible.items():
        for number, unit in part.numbers.items():
            yield f"{name}.{number}", ("flexible", name, number), unit
    for name in there.joints:
        yield f"{name}.placement", ("joints", name, "origin"), "m"
    for name in there.loops:
        for side in ("predecessor", "successor"):
            yield f"{name}.{side}_placement", ("loops", name, f"{side}_origin"), "m"
    for name in there.joint_stiffness:
        along = UNITS[JointStiffness]["linear" if robot.mechanism.connections[name].type.is_slide else "angular"]
        for number, unit in {**UNITS[JointStiffness], "drive": along}.items():
            kind = "actuator" if number == "drive" else number
            yield f"{name}.{kind}_stiffness", ("joint_stiffness", name, number), unit
    for name in there.springs:
        for number, unit in UNITS[Spring].items():
            yield f"{name}.{number}", ("springs", name, number), unit


# ---- places in descriptions ------------------------------------------------------------------------------------------------


def _inside(part: Part, key: Part) -> Part:
    return part[key] if isinstance(part, (Mapping, tuple)) else getattr(part, key)


def _part_at(part: Part, path: Path) -> Part:
    for key in path:
        part = _inside(part, key)
    return part


def _value(part: Part, path: Path) -> float:
    owner = _part_at(part, path[:-1])
    return 0.0 if isinstance(owner, Origin) else float(_inside(owner, path[-1]) or 0.0)


def _changed(part: Part, path: Path, by: float) -> Part:
    if not path:
        return (part or 0.0) + by
    key: Part = path[0]
    if isinstance(part, Origin):
        return _displaced(part, key, by)
    new = _changed(_inside(part, key), path[1:], by)
    if isinstance(part, Mapping):
        return {**part, key: new}
    if isinstance(part, tuple):
        return tuple(new if k == key else value for k, value in enumerate(part))
    if isinstance(part, Section) and type(part) is not Section:
        made: Part = type(part)
        return made.of(**{**{name: getattr(part, name) for name in sizes_of(made)}, key: new})
    return replace(part, **{key: new})


def _displaced(origin: Origin, k: int, by: float) -> Origin:
    """Return a frame shifted along (k = 0, 1, 2) or turned about (k = 3, 4, 5) an axis of the frame."""
    matrix = origin.matrix
    if k < 3:
        return Origin(tuple((matrix[:3, 3] + by * matrix[:3, k]).tolist()), origin.rpy)
    turn: Array = np.zeros((3, 1))
    turn[k - 3] = by
    rotation = matrix[:3, :3] @ exponential(turn)[..., 0]
    return Origin(origin.xyz, tuple(orientation_named("xyz").coordinates(rotation[..., None])[:, 0].tolist()))


# ---- assembly errors ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ErrorParameter:
    """An assembly error of a joint or beam of the unloaded robot.

    Attributes:
        name: ``PART.error.KIND``.
        part: name of the joint or beam.
        kind: "x" … "rz" of a joint, along and about the axes of its frame; "length" or "temperature" of a beam.
        unit: SI unit.
    """

    name: str
    part: str
    kind: str
    unit: str

    @property
    def value(self) -> float:
        """Value in the nominal robot."""
        return 0.0


def errors_of(robot: Robot) -> dict[str, ErrorParameter]:
    """Return the errors of all joints and elastic links of the limbs, and of an elastic base and platform, by name."""
    part_errors = []
    for edges in (*(limb.edges for limb in robot.topology.limbs), *robot.topology.plates.values()):
        for edge in edges:
            if edge.joint is not None:
                part_errors += [(edge.joint, kind, "rad" if k > 2 else "m") for k, kind in enumerate(COMPONENTS)]
            elif edge.span is not None:
                link = robot.topology.spans[edge.span].part
                part_errors += [(link.name, kind, unit) for kind, unit in link.errors.items()]
    every = (ErrorParameter(f"{part}.error.{kind}", part, kind, unit) for part, kind, unit in part_errors)
    return {error.name: error for error in every}


def as_assembly_errors(errors: Sequence[ErrorParameter], amounts: Array) -> dict[str, Keyword]:
    """Return the argument ``assembly_errors`` of :func:`kinetostatics.analyze` for values ``amounts`` (errors, N)."""
    assembly_errors: dict[str, Keyword] = {}
    for error, row in zip(errors, amounts, strict=True):
        if error.kind in COMPONENTS:
            joint_errors = assembly_errors.setdefault(error.part, {"twist": np.zeros((amounts.shape[1], 6)), "frame": "joint"})
            joint_errors["twist"][:, COMPONENTS.index(error.kind)] = row
        else:
            assembly_errors.setdefault(error.part, {})[error.kind] = row
    return assembly_errors
