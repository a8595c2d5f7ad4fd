"""The numbers of a robot's description that a derivative may be taken by, and descriptions in which one is a little different."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np

from kinetostatics.description.elements import Beam, Joint, Link, Loop, Origin
from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.math.orientation import orientation_named
from kinetostatics.math.rotations import exponential
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Section

#: Part of a number, or of the robot's length, by which it is changed where it is differenced; and such a turn [rad].
_STEP = 1e-3
_AREAS = {"area": "m²", "I_y": "m⁴", "I_z": "m⁴", "J": "m⁴", "shear_area_y": "m²", "shear_area_z": "m²"}
_MATERIAL = {"youngs_modulus": "Pa", "shear_modulus": "Pa", "poisson_ratio": "1", "density": "kg/m³"}
_PLACEMENT = ("m", "m", "m", "rad", "rad", "rad")


@dataclass(frozen=True)
class Parameter:
    """A number of the robot's description, or a few that belong together.

    Attributes:
        name: of link, joint, loop or beam, a dot, and of the number.
        units: of each component.
        shape: () for one number.
        steps: by how much each is changed where it is differenced; None where it cannot be changed.
        changed: the description in which component ``k`` is larger by an amount.
    """

    name: str
    units: tuple[str, ...]
    shape: tuple[int, ...]
    steps: tuple[float | None, ...]
    changed: Callable[[int, float], RobotDescription]


def parameters_of(robot: Robot) -> dict[str, Parameter]:
    """Return all parameters of a robot by name."""
    found = [
        *(item for link in robot.description.links.values() for item in _of_link(robot, link)),
        *(item for beam in robot.description.beams.values() for item in _of_beam(robot, beam)),
        *(item for joint in robot.description.joints.values() for item in _of_joint(robot, joint)),
        *(item for loop in robot.description.loops.values() for item in _of_loop(robot, loop)),
        *_of_stiffnesses(robot),
    ]
    return {item.name: item for item in found}


def parameter_named(robot: Robot, name: str) -> Parameter:
    """Return a parameter.

    Raises:
        ArgumentError: there is none of that name.
    """
    known = parameters_of(robot)
    if name not in known:
        raise ArgumentError(f"{robot.name!r} has no parameter {name!r}: {near_names(name, known)}")
    return known[name]


def _single(name: str, unit: str, value: float, changed: Callable[[float], RobotDescription]) -> Parameter:
    step = _STEP * abs(value)
    return Parameter(name, (unit,), (), (step or None,), lambda k, by: changed(value + by))


def _of_link(robot: Robot, link: Link) -> Iterator[Parameter]:
    description = robot.description
    if link.mass <= 0:
        return

    def with_mass(mass: float) -> RobotDescription:
        return description.with_link(replace(link, mass=mass))

    def with_centre(k: int, by: float) -> RobotDescription:
        return description.with_link(replace(link, center_of_mass=_moved(link.center_of_mass, k, by)))

    yield _single(f"{link.name}.mass", "kg", link.mass, with_mass)
    yield Parameter(f"{link.name}.center_of_mass", ("m",) * 3, (3,), (_STEP * robot.length,) * 3, with_centre)


def _of_beam(robot: Robot, beam: Beam) -> Iterator[Parameter]:
    description, material, section = robot.description, beam.material, beam.section

    def with_material(name: str, value: float) -> RobotDescription:
        return description.with_beam(replace(beam, material=replace(material, **{name: value})))

    def with_coefficient(value: float) -> RobotDescription:
        return description.with_beam(replace(beam, shear_coefficient=value))

    def with_section(made: Callable[..., Section], sizes: dict[str, float], name: str, value: float) -> RobotDescription:
        return description.with_beam(replace(beam, section=made(**{**sizes, name: value})))

    for name, unit in _MATERIAL.items():
        value = getattr(material, name)
        if value:
            yield _single(f"{beam.name}.{name}", unit, value, partial(with_material, name))
    if beam.shear_coefficient is not None and np.isfinite(beam.shear_coefficient):
        yield _single(f"{beam.name}.shear_coefficient", "1", beam.shear_coefficient, with_coefficient)
    plain = {item.name for item in fields(Section)}
    made = getattr(type(section), "of", Section)
    sizes = {item.name: getattr(section, item.name) for item in fields(section) if item.name not in plain}
    sizes.pop("torsion_modulus", None)  # which follows from the others
    for name, value in sizes.items():
        if value:
            yield _single(f"{beam.name}.{name}", "m", value, partial(with_section, made, sizes, name))
    for name, unit in _AREAS.items() if type(section) is Section else ():
        value = getattr(section, name)
        if value is not None and np.isfinite(value):
            yield _single(f"{beam.name}.{name}", unit, value, partial(with_section, partial(replace, section), {}, name))


def _of_joint(robot: Robot, joint: Joint) -> Iterator[Parameter]:
    def changed(k: int, by: float) -> RobotDescription:
        return robot.description.with_joint(replace(joint, origin=_displaced(joint.origin, k, by)))

    yield Parameter(f"{joint.name}.placement", _PLACEMENT, (6,), _displacements(robot), changed)


def _of_loop(robot: Robot, loop: Loop) -> Iterator[Parameter]:
    for side in ("predecessor", "successor"):
        origin = f"{side}_origin"

        def changed(k: int, by: float, origin: str = origin) -> RobotDescription:
            return robot.description.changed(loop.name, **{origin: _displaced(getattr(loop, origin), k, by)})

        yield Parameter(f"{loop.name}.{side}_placement", _PLACEMENT, (6,), _displacements(robot), changed)


def _of_stiffnesses(robot: Robot) -> Iterator[Parameter]:
    description = robot.description
    for item in description.joint_stiffness.values():
        for name, unit in (("linear", "N/m"), ("angular", "N·m/rad")):
            values = getattr(item, name)
            if values is None:
                continue

            def changed(k: int, by: float, item: Any = item, name: str = name) -> RobotDescription:
                return description.with_joint_stiffness(replace(item, **{name: _moved(getattr(item, name), k, by)}))

            steps = tuple(_STEP * value if 0 < value < np.inf else None for value in values)
            yield Parameter(f"{item.joint}.{name}_stiffness", (unit,) * 3, (3,), steps, changed)
        if item.drive is not None and np.isfinite(item.drive):
            unit = "N/m" if robot.mechanism.connections[item.joint].type.is_slide else "N·m/rad"

            def with_drive(value: float, item: Any = item) -> RobotDescription:
                return description.with_joint_stiffness(replace(item, drive=value))

            yield _single(f"{item.joint}.drive_stiffness", unit, item.drive, with_drive)


def _moved(vector: Any, k: int, by: float) -> Any:
    return tuple(value + by * (j == k) for j, value in enumerate(vector))


def _displacements(robot: Robot) -> tuple[float, ...]:
    return (_STEP * robot.length,) * 3 + (_STEP,) * 3


def _displaced(origin: Origin, k: int, by: float) -> Origin:
    """Return a frame shifted along (k = 0, 1, 2) or turned about one of its own axes."""
    matrix = origin.matrix
    if k < 3:
        return Origin(tuple((matrix[:3, 3] + by * matrix[:3, k]).tolist()), origin.rpy)
    turn: Array = np.zeros((3, 1))
    turn[k - 3] = by
    rotation = matrix[:3, :3] @ exponential(turn)[..., 0]
    return Origin(origin.xyz, tuple(orientation_named("xyz").coordinates(rotation[..., None])[:, 0].tolist()))
