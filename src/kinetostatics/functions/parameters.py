"""The numbers of a robot's description that a derivative may be taken by, and descriptions in which one is a little different."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np

from kinetostatics.argument_checks import Keyword
from kinetostatics.description.elements import Beam, Joint, Link, Loop, Origin, Spring
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
        values: of each component; of a placement, which is told by how it is displaced, zeros.
        change: returns a description in which component ``k`` is larger by an amount than in the one that it is given.
        description: of the robot.
    """

    name: str
    units: tuple[str, ...]
    shape: tuple[int, ...]
    steps: tuple[float | None, ...]
    values: tuple[float, ...]
    change: Callable[[RobotDescription, int, float], RobotDescription]
    description: RobotDescription

    def changed(self, k: int, by: float) -> RobotDescription:
        """Return the robot's description in which component ``k`` is larger by an amount."""
        return self.change(self.description, k, by)


def parameters_of(robot: Robot) -> dict[str, Parameter]:
    """Return all parameters of a robot by name."""
    found = [
        *(item for link in robot.description.links.values() for item in _of_link(robot, link)),
        *(item for beam in robot.description.beams.values() for item in _of_beam(robot, beam)),
        *(item for joint in robot.description.joints.values() for item in _of_joint(robot, joint)),
        *(item for loop in robot.description.loops.values() for item in _of_loop(robot, loop)),
        *_of_stiffnesses(robot),
        *(item for spring in robot.description.springs.values() for item in _of_spring(robot, spring)),
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


def _single(
    robot: Robot, name: str, unit: str, value: float, change: Callable[[RobotDescription, float], RobotDescription]
) -> Parameter:
    step = _STEP * abs(value)
    return Parameter(name, (unit,), (), (step or None,), (value,), lambda there, k, by: change(there, by), robot.description)


def _of_link(robot: Robot, link: Link) -> Iterator[Parameter]:
    if link.mass <= 0:
        return

    def with_mass(there: RobotDescription, by: float) -> RobotDescription:
        own = there.links[link.name]
        return there.with_link(replace(own, **_larger(own, "mass", by)))

    def with_centre(there: RobotDescription, k: int, by: float) -> RobotDescription:
        own = there.links[link.name]
        return there.with_link(replace(own, center_of_mass=_moved(own.center_of_mass, k, by)))

    yield _single(robot, f"{link.name}.mass", "kg", link.mass, with_mass)
    steps, values = (_STEP * robot.length,) * 3, tuple(link.center_of_mass)
    yield Parameter(f"{link.name}.center_of_mass", ("m",) * 3, (3,), steps, values, with_centre, robot.description)


def _of_beam(robot: Robot, beam: Beam) -> Iterator[Parameter]:
    material, section = beam.material, beam.section

    def with_material(name: str, there: RobotDescription, by: float) -> RobotDescription:
        own = there.beams[beam.name]
        return there.with_beam(replace(own, material=replace(own.material, **_larger(own.material, name, by))))

    def with_coefficient(there: RobotDescription, by: float) -> RobotDescription:
        own = there.beams[beam.name]
        return there.with_beam(replace(own, **_larger(own, "shear_coefficient", by)))

    def with_section(name: str, there: RobotDescription, by: float) -> RobotDescription:
        own = there.beams[beam.name]
        return there.with_beam(replace(own, section=_section_with(own.section, name, by)))

    for name, unit in _MATERIAL.items():
        value = getattr(material, name)
        if value:
            yield _single(robot, f"{beam.name}.{name}", unit, value, partial(with_material, name))
    if beam.shear_coefficient is not None and np.isfinite(beam.shear_coefficient):
        yield _single(robot, f"{beam.name}.shear_coefficient", "1", beam.shear_coefficient, with_coefficient)
    for name, value in _sizes(section).items():
        if value:
            yield _single(robot, f"{beam.name}.{name}", "m", value, partial(with_section, name))
    for name, unit in _AREAS.items() if type(section) is Section else ():
        value = getattr(section, name)
        if value is not None and np.isfinite(value):
            yield _single(robot, f"{beam.name}.{name}", unit, value, partial(with_section, name))


def _sizes(section: Section) -> dict[str, float]:
    """Return the sizes of a section of some shape, from which all else follows."""
    plain = {item.name for item in fields(Section)}
    sizes = {item.name: getattr(section, item.name) for item in fields(section) if item.name not in plain}
    sizes.pop("torsion_modulus", None)  # which follows from the others
    return sizes


def _section_with(section: Section, name: str, by: float) -> Section:
    """Return a section one of whose numbers is larger."""
    made: Callable[..., Section] | None = getattr(type(section), "of", None)
    if made is None or type(section) is Section:
        return replace(section, **_larger(section, name, by))
    return made(**_sizes(section) | _larger(section, name, by))


def _of_joint(robot: Robot, joint: Joint) -> Iterator[Parameter]:
    def change(there: RobotDescription, k: int, by: float) -> RobotDescription:
        own = there.joints[joint.name]
        return there.with_joint(replace(own, origin=_displaced(own.origin, k, by)))

    yield _placement(robot, f"{joint.name}.placement", change)


def _of_loop(robot: Robot, loop: Loop) -> Iterator[Parameter]:
    for side in ("predecessor", "successor"):
        origin = f"{side}_origin"

        def change(there: RobotDescription, k: int, by: float, origin: str = origin) -> RobotDescription:
            return there.changed(loop.name, **{origin: _displaced(getattr(there.loops[loop.name], origin), k, by)})

        yield _placement(robot, f"{loop.name}.{side}_placement", change)


def _placement(robot: Robot, name: str, change: Callable[[RobotDescription, int, float], RobotDescription]) -> Parameter:
    steps = (_STEP * robot.length,) * 3 + (_STEP,) * 3
    return Parameter(name, _PLACEMENT, (6,), steps, (0.0,) * 6, change, robot.description)


def _of_stiffnesses(robot: Robot) -> Iterator[Parameter]:
    for item in robot.description.joint_stiffness.values():
        for name, unit in (("linear", "N/m"), ("angular", "N·m/rad")):
            values = getattr(item, name)
            if values is None:
                continue

            def change(there: RobotDescription, k: int, by: float, joint: str = item.joint, name: str = name) -> RobotDescription:
                own = there.joint_stiffness[joint]
                moved: dict[str, Keyword] = {name: _moved(getattr(own, name), k, by)}
                return there.with_joint_stiffness(replace(own, **moved))

            steps = tuple(_STEP * value if 0 < value < np.inf else None for value in values)
            title = f"{item.joint}.{name}_stiffness"
            yield Parameter(title, (unit,) * 3, (3,), steps, tuple(values), change, robot.description)
        if item.drive is not None and np.isfinite(item.drive):
            unit = "N/m" if robot.mechanism.connections[item.joint].type.is_slide else "N·m/rad"

            def with_actuator(there: RobotDescription, by: float, joint: str = item.joint) -> RobotDescription:
                own = there.joint_stiffness[joint]
                return there.with_joint_stiffness(replace(own, **_larger(own, "drive", by)))

            yield _single(robot, f"{item.joint}.drive_stiffness", unit, item.drive, with_actuator)


def _of_spring(robot: Robot, spring: Spring) -> Iterator[Parameter]:
    def with_number(name: str, there: RobotDescription, by: float) -> RobotDescription:
        return there.changed(spring.name, **_larger(there.springs[spring.name], name, by))

    for name, unit in (("stiffness", "N/m"), ("free_length", "m"), ("preload", "N")):
        value = getattr(spring, name)
        if value:
            yield _single(robot, f"{spring.name}.{name}", unit, value, partial(with_number, name))


def _larger(own: object, name: str, by: float) -> dict[str, Any]:
    """Return a number of something, larger by an amount, as a keyword."""
    return {name: getattr(own, name) + by}


def _moved(vector: Sequence[float], k: int, by: float) -> tuple[float, float, float]:
    x, y, z = (value + by * (j == k) for j, value in enumerate(vector))
    return x, y, z


def _displaced(origin: Origin, k: int, by: float) -> Origin:
    """Return a frame shifted along (k = 0, 1, 2) or turned about one of its own axes."""
    matrix = origin.matrix
    if k < 3:
        return Origin(tuple((matrix[:3, 3] + by * matrix[:3, k]).tolist()), origin.rpy)
    turn: Array = np.zeros((3, 1))
    turn[k - 3] = by
    rotation = matrix[:3, :3] @ exponential(turn)[..., 0]
    return Origin(origin.xyz, tuple(orientation_named("xyz").coordinates(rotation[..., None])[:, 0].tolist()))
