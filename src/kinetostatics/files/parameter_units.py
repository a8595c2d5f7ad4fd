"""Units of the parameters of a robot file, from derivatives of the robot's numbers.

A parameter has the unit of the numbers whose derivative with respect to the parameter is 1 or −1. For example, it is a length if
the diameter of a rod increases by as much as the parameter. Without such numbers, or if their units differ, the unit is
unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from numbers import Real

from kinetostatics.description.elements import Beam, Inertia, JointStiffness, Link, Material, Origin, Spring
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Cone, Joint, Loop
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.reader import parameter_values, read_robot_file
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube, sizes_of
from kinetostatics.unit_hints import LONG, length_hint

#: Units of the numbers of a robot, by class and field. Limits of joints follow their type, actuators' stiffnesses their joint.
UNITS: dict[type, dict[str, str]] = {
    Origin: {"xyz": "m", "rpy": "rad"},
    Link: {"mass": "kg", "center_of_mass": "m"},
    Inertia: {"rpy": "rad"},
    Cone: {"angle": "rad"},
    JointStiffness: {"linear": "N/m", "angular": "N·m/rad"},
    Spring: {"stiffness": "N/m", "free_length": "m", "preload": "N"},
    Material: {
        "youngs_modulus": "Pa",
        "shear_modulus": "Pa",
        "poisson_ratio": "1",
        "density": "kg/m³",
        "thermal_expansion": "1/K",
        "yield_strength": "Pa",
    },
    Beam: {"shear_coefficient": "1"},
    Section: {"area": "m²", "I_y": "m⁴", "I_z": "m⁴", "J": "m⁴", "shear_area_y": "m²", "shear_area_z": "m²"},
    **{kind: dict.fromkeys(sizes_of(kind), "m") for kind in (Tube, Rectangle, RectangularTube)},
}
#: Changes of a parameter, relative to its value (absolute if it is zero), and tolerance of a derivative of ±1.
STEPS, SLOPE = (1e-3, 2e-3), 1e-7


def parameter_unit(value: object, read: Callable[[float], RobotDescription]) -> str:
    """Return the SI unit of a parameter, empty if unknown; ``read`` returns the description for another value."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return ""
    for sign in (1, -1):  # one of the two may be invalid in the file
        steps = [sign * step * (abs(float(value)) or 1.0) for step in STEPS]
        try:
            before, *after = (dict(_walk(read(float(value) + step), (), "")) for step in (0.0, *steps))
        except RobotFileError:
            continue
        units = {
            unit
            for key, (number, unit) in before.items()
            if all(
                key in numbers and abs(abs((numbers[key][0] - number) / step) - 1) < SLOPE
                for numbers, step in zip(after, steps, strict=True)
            )
        }
        return units.pop() if len(units) == 1 else ""
    return ""


def parameter_hints(path: str, parameters: Mapping[str, object], links: Mapping[str, str | None]) -> list[str]:
    """Return hints at given lengths of 1 m or more that far exceed the parameters' own values in the file."""
    numbers = {name: _number(value) for name, value in parameters.items()}
    given = {name: number for name, number in numbers.items() if number is not None and number >= 1}
    file_values = {name: _number(text) for name, text in parameter_values(path, {}).items()} if given else {}
    hints = []
    for name, value in given.items():
        hint = length_hint(f"{name} = {value:.6g} m is", value, file_values.get(name) or 0.0, "the file's own", LONG)
        if hint and parameter_unit(file_values[name], partial(_with_value, path, name, links)) == "m":
            hints += hint
    return hints


def _with_value(path: str, name: str, links: Mapping[str, str | None], value: float) -> RobotDescription:
    return read_robot_file(path, {name: value}, **links)


def _number(value: object) -> float | None:
    try:
        return None if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def _walk(value: object, place: tuple[object, ...], unit: str) -> Iterator[tuple[tuple[object, ...], tuple[float, str]]]:
    if is_dataclass(value):
        units = UNITS.get(type(value), {})
        if isinstance(value, Joint | Loop):
            units = dict.fromkeys(("lower", "upper"), JOINT_TYPES[value.type].unit)
        for field in fields(value):
            yield from _walk(getattr(value, field.name), (*place, field.name), units.get(field.name, ""))
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield from _walk(part, (*place, name), "")
    elif isinstance(value, tuple):
        for number, part in enumerate(value):
            yield from _walk(part, (*place, number), unit)
    elif unit and isinstance(value, Real):
        yield place, (float(value), unit)
