"""Writing of robot files, with all digits of the numbers, and of CSV tables; validation of descriptions.

To validate a description, it is converted to an element ``<robot>``, which is read. Errors name file and line of parts that were
read from a file.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Protocol, TypeVar

import numpy as np

from kinetostatics.arguments import path_name
from kinetostatics.description.elements import Place
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.attributes import new_name
from kinetostatics.files.element_tables import (
    BASE,
    PLATFORM,
    write_beam,
    write_joint,
    write_link,
    write_loop,
    write_spring,
    write_stiffness,
)
from kinetostatics.files.reader import describe, known_valid
from kinetostatics.files.urdf import plain_transmission
from kinetostatics.files.xml import XmlElement, parse, to_elements, to_text
from kinetostatics.math.arrays import Array
from kinetostatics.output_files import write_text

_COMMENT = "written by kinetostatics; docs/reference/robot_format.md describes the elements that are not URDF"
#: Attributes with names of files, relative to the robot file.
_FILE = re.compile(r'(<(?:mesh|texture)\b[^<>]*\bfilename=")([^"]+)(")')


class Described(Protocol):
    """An object with a description: a robot."""

    @property
    def description(self) -> RobotDescription: ...


def validate(description: RobotDescription) -> RobotDescription:
    """Validate a description created or changed in Python by the rules of robot files.

    The description is converted to the elements of a robot file, which are then read.

    Args:
        description: the description; returned unchanged if valid already.

    Returns:
        The description as if read from a file: with defaults, unit axes, and numbers as floats.

    Raises:
        RobotFileError: the description is invalid; with file and line for parts of a file.
        ArgumentError: the argument is no description.
    """
    if not isinstance(description, RobotDescription):
        raise ArgumentError(f"{description!r} is no description of a robot; load_robot and read_robot_file read files")
    if description.is_valid:
        return description
    root = robot_element(description)
    new_name(root)  # in files it is optional
    found = describe(root, description.path, [])
    known = {warning.partition(": ")[2] for warning in description.file_warnings}
    new = [warning for warning in found.file_warnings if warning.partition(": ")[2] not in known]
    warnings = (*description.file_warnings, *new)
    kept = {name: getattr(description, name) for name in ("inertia_warnings", "default_axes", "flexible")}
    return known_valid(replace(found, file_warnings=warnings, **kept))


def save_robot(robot: Described | RobotDescription, path: str | os.PathLike[str]) -> None:
    """Write a robot to a plain URDF file, whose numbers have all digits, so that the same robot is read from it.

    Elements that the package does not use are written too: visuals and collisions, inertias, materials, dynamics, transmissions.
    Comments, xacro macros and unknown attributes are not. Relative names of meshes are adapted to the new file.

    Args:
        robot: the robot, or its description.
        path: path of the new file; an existing file is replaced.

    Raises:
        RobotFileError: the description is invalid.
        ArgumentError: the file cannot be written, or is a xacro whose macros would be lost.
    """
    description = validate(robot.description if hasattr(robot, "description") else robot)
    name = path_name("path", path)
    for part in description.flexible.values():
        raise part.place.error(f"the elastic link {part.name!r} is no beam, and files have no element for it")
    text = robot_text(_with_meshes_from(description, os.path.dirname(os.path.abspath(name))), _COMMENT)
    if _uses_xacro(name):
        raise ArgumentError(f"{name} uses xacro, and its macros would be lost; write to another file")
    write_text(name, text)


def write_table(path: str | os.PathLike[str], columns: Mapping[str, Sequence[str]]) -> None:
    """Write columns, given by title, as a CSV file; an existing file is replaced."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    write_text(path, text.getvalue())


def cells(values: Array) -> list[str]:
    """Return numbers as cells of a CSV table; a cell is empty if the number is not finite."""
    return [f"{value:.15g}" if np.isfinite(value) else "" for value in np.ravel(values)]


def _uses_xacro(name: str) -> bool:
    try:
        with open(name, "rb") as file:
            return b"xmlns:xacro" in file.read()
    except (OSError, ValueError):  # it does not exist yet, or writing will raise the error
        return False


def _with_meshes_from(description: RobotDescription, folder: str) -> RobotDescription:
    """Return a description in which names of mesh files are relative to another folder."""
    source = os.path.dirname(os.path.abspath(description.path))
    if source == folder:
        return description

    def moved(match: re.Match[str]) -> str:
        before, name, after = match.groups()
        if "://" in name or os.path.isabs(name):
            return match[0]
        return f"{before}{os.path.relpath(os.path.join(source, name), folder)}{after}"

    links = {name: replace(link, extra=_FILE.sub(moved, link.extra)) for name, link in description.links.items()}
    return replace(description, links=links, extra=_FILE.sub(moved, description.extra))


# ---- the element <robot> ---------------------------------------------------------------------------------------------------

Item = TypeVar("Item")

_ATTRIBUTE = re.compile(r"[A-Za-z_][\w:.-]*")


def robot_text(description: RobotDescription, comment: str = "") -> str:
    """Return a description as the indented text of a plain URDF file with the elements of this package."""
    return to_text(robot_element(description), comment, indented=True)


def robot_element(description: RobotDescription) -> XmlElement:
    place = Place(description.path)
    extra = _elements_of(description.extra, place, "the description")
    transmissions = [item for item in extra if item.tag == "transmission"]
    links, joints = _values(description.links), _values(description.joints)
    known = {*description.joints, *description.loops}
    if not isinstance(description.name, (str, type(None))):
        raise place.error(f"name of robot is {description.name!r}; it must be a text")
    attributes = {name: value for name, value in description.attributes if name != "name"}
    for name, value in attributes.items():
        if not _ATTRIBUTE.fullmatch(name) or not isinstance(value, str) or not value.isprintable():
            raise place.error(f"{name!r} = {value!r} is no attribute for <robot>")
    return XmlElement(
        "robot",
        attributes if description.name is None else {"name": description.name, **attributes},
        (
            *(write_link(link, _elements_of(link.extra, link.place, f"link {link.name!r}")) for link in links),
            *(write_joint(joint, _elements_of(joint.extra, joint.place, f"joint {joint.name!r}")) for joint in joints),
            *([BASE.write(description, place, "robot")] if description.base else []),
            PLATFORM.write(description, description.platform_place, "robot"),
            *map(write_loop, _values(description.loops)),
            *(write_beam(beam, known) for beam in _values(description.beams)),
            *map(write_stiffness, _values(description.joint_stiffness, "joint")),
            *map(write_spring, _values(description.springs)),
            *(item for item in extra if item.tag != "transmission"),
            *_transmissions(description.driven, transmissions, place),
        ),
        place,
    )


def _values(table: Mapping[str, Item], key: str = "name") -> list[Item]:
    for name, item in table.items():
        own = getattr(item, key, None)
        if own != name:
            place = getattr(item, "place", Place())
            raise place.error(f"the entry {name!r} has the {key} {own!r}; the two must agree")
    return list(table.values())


@lru_cache(maxsize=1000)
def _elements_of(extra: str, place: Place, owner: str) -> tuple[XmlElement, ...]:
    """Return the elements of an XML text; ``place`` and ``owner`` of the part with this text are used in errors."""
    if not extra:
        return ()
    try:
        root = to_elements(parse(f"<extra>{extra}</extra>", "", plain=True)[0], place, owner)
    except RobotFileError as error:
        raise place.error(f"extra of {owner} cannot be read: {error.reason}") from None
    if len(root.children) < len(root.content):
        raise place.error(f"extra of {owner} has text outside of elements")
    return root.children


def _transmissions(driven: tuple[str, ...], known: list[XmlElement], place: Place) -> list[XmlElement]:
    """Return the transmissions of the ``driven`` joints in their order: ``known`` ones where they fit, otherwise plain ones."""
    joints = [[entry.attributes.get("name", "") for entry in item.named("joint")] for item in known]
    of_joint = {name: number for number, names in enumerate(joints) for name in names}
    result: list[XmlElement] = []
    position = 0
    while position < len(driven):
        number = of_joint.get(driven[position])
        names = joints[number] if number is not None else []
        if number is not None and tuple(names) == tuple(driven[position : position + len(names)]):
            result.append(known[number])
            position += len(names)
        else:
            result.append(plain_transmission(driven[position], place))
            position += 1
    return result
