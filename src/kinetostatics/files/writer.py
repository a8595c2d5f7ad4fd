"""Writing of robot files, with all digits of the numbers, and of CSV tables.

XML in a description, for other programs, is checked when it is written.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from kinetostatics.arguments import path_name
from kinetostatics.description.fields import Place
from kinetostatics.description.flexible import Flexible
from kinetostatics.description.joints import Loop
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.description.validation import validate
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.element_tables import (
    BASE,
    PLATFORM,
    SPRING,
    write_beam,
    write_flexible,
    write_joint,
    write_link,
    write_loop,
    write_stiffness,
)
from kinetostatics.files.foreign_xml import write_constraint
from kinetostatics.files.link_files import read_link, save_link
from kinetostatics.files.urdf import (
    JOINT_FIELDS,
    LINK_FIELDS,
    ROBOT_LEVEL,
    check_in_joint,
    check_in_link,
    check_in_robot,
    plain_transmission,
)
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


#: Function that writes a loop, by dialect of :func:`save_robot`.
DIALECTS: dict[str | None, Callable[[Loop], XmlElement]] = {None: write_loop, "urdf-constraint": write_constraint}


def save_robot(robot: Described | RobotDescription, path: str | os.PathLike[str], dialect: str | None = None) -> None:
    """Write a robot to a plain URDF file, whose numbers have all digits, so that the same robot is read from it.

    Elements that the package does not use are written too: visuals and collisions, inertias, materials, dynamics, transmissions.
    Comments, xacro macros and unknown attributes are not. Relative names of meshes are adapted to the new file. Matrices of
    flexible links that are in no file are written beside it, as ``ROBOT_LINK.npz``.

    Args:
        robot: the robot, or its description.
        path: path of the new file; an existing file is replaced.
        dialect: None: loops are written as ``<loop>``; "urdf-constraint": as ``<constraint>`` of the proposal for URDF in
            https://github.com/ros/urdfdom/pull/264, which has no ``<cone>``.

    Raises:
        RobotFileError: the description is invalid.
        ArgumentError: the dialect is unknown, the file cannot be written, or is a xacro whose macros would be lost.
    """
    if dialect not in DIALECTS:
        raise ArgumentError(f"dialect is {dialect!r}; it is None or 'urdf-constraint'")
    description = validate(robot.description if hasattr(robot, "description") else robot)
    name = path_name("path", path)
    parts, made = _with_files(description, name)
    moved = replace(_with_meshes_from(description, os.path.dirname(os.path.abspath(name))), flexible=parts, path=name)
    text = robot_text(moved, _COMMENT, DIALECTS[dialect])
    if _uses_xacro(name):
        raise ArgumentError(f"{name} uses xacro, and its macros would be lost; write to another file")
    for part in made:
        save_link(part.matrices, part.file)
    write_text(name, text)


def _with_files(description: RobotDescription, name: str) -> tuple[dict[str, Flexible], list[Flexible]]:
    """Return the flexible links for a robot file, and those among them whose matrices are in no file yet."""
    parts: dict[str, Flexible] = {}
    for key, part in description.flexible.items():
        if not isinstance(part, Flexible):
            raise part.place.error(f"the elastic link {part.name!r} is no beam, and files have no element for it")
        parts[key] = part if _in_file(part) else replace(part, file=f"{os.path.splitext(name)[0]}_{part.name}.npz")
    return parts, [part for part in parts.values() if not _in_file(part)]


def _in_file(part: Flexible) -> bool:
    try:
        return bool(part.file) and read_link(part.file) == part.matrices
    except RobotFileError:
        return False


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

#: Elements that the description has fields for, which ``extra`` must not have, and checks of the others, by tag of the parent.
_KEPT: dict[str, tuple[Collection[str], Callable[[XmlElement, list[str]], None]]] = {
    "robot": (("link", "joint", *ROBOT_LEVEL), check_in_robot),
    "link": (LINK_FIELDS, check_in_link),
    "joint": (JOINT_FIELDS, check_in_joint),
}


def robot_text(description: RobotDescription, comment: str = "", loop_of: Callable[[Loop], XmlElement] = write_loop) -> str:
    """Return a description as the indented text of a plain URDF file with the elements of this package."""
    place, connection_names = Place(description.path), {*description.joints, *description.loops}
    folder = os.path.dirname(description.path)
    extra, _ = _kept("robot", "", description.extra, place)
    root = XmlElement(
        "robot",
        {"name": description.name, **dict(description.attributes)},
        (
            *(write_link(link, _kept("link", link.name, link.extra, link.place)[0]) for link in description.links.values()),
            *(
                write_joint(joint, _kept("joint", joint.name, joint.extra, joint.place)[0])
                for joint in description.joints.values()
            ),
            *([BASE.write(description)] if description.base else []),
            PLATFORM.write(description),
            *map(loop_of, description.loops.values()),
            *(write_beam(beam, connection_names) for beam in description.beams.values()),
            *(write_flexible(part, folder) for part in description.flexible.values() if isinstance(part, Flexible)),
            *map(write_stiffness, description.joint_stiffness.values()),
            *map(SPRING.write, description.springs.values()),
            *(element for element in extra if element.tag != "transmission"),
            *_transmissions(description.actuated, [element for element in extra if element.tag == "transmission"], place),
        ),
        place,
    )
    return to_text(root, comment, indented=True)


def kept_warnings(description: RobotDescription) -> list[str]:
    """Return the warnings about XML in the description that are not among those about its file."""
    file_texts = {warning.partition(": ")[2] for warning in description.file_warnings}
    parts = (("link", description.links), ("joint", description.joints))
    warning_lists = [_kept(tag, part.name, part.extra, part.place)[1] for tag, table in parts for part in table.values()]
    return [warning for warnings in warning_lists for warning in warnings if warning.partition(": ")[2] not in file_texts]


@lru_cache(maxsize=1000)
def _kept(tag: str, name: str, extra: str, place: Place) -> tuple[tuple[XmlElement, ...], tuple[str, ...]]:
    """Return the elements in the XML text ``extra`` of a part, and warnings about them."""
    if not extra:
        return (), ()
    owner, (fields, check), warnings = f"{tag} {name!r}" if name else "the description", _KEPT[tag], list[str]()
    try:
        root = to_elements(parse(f"<extra>{extra}</extra>", "", plain=True)[0], place, owner)
    except RobotFileError as error:
        raise place.error(f"extra of {owner} cannot be read: {error.reason}") from None
    wrong = next((f"a <{child.tag}>, for which the description has fields" for child in root.children if child.tag in fields), "")
    if wrong or len(root.children) < len(root.content):
        raise place.error(f"extra of {owner} has {wrong or 'text outside of elements'}")
    check(replace(root, tag=tag, attributes={"name": name}), warnings)
    return root.children, tuple(warnings)


def _transmissions(actuated: tuple[str, ...], originals: list[XmlElement], place: Place) -> list[XmlElement]:
    """Return the transmissions of the ``actuated`` joints in their order: ``originals`` where they fit, otherwise plain ones."""
    joints = [[entry.attributes.get("name", "") for entry in transmission.named("joint")] for transmission in originals]
    of_joint = {name: number for number, names in enumerate(joints) for name in names}
    result: list[XmlElement] = []
    position = 0
    while position < len(actuated):
        number = of_joint.get(actuated[position])
        names = joints[number] if number is not None else []
        if number is not None and tuple(names) == tuple(actuated[position : position + len(names)]):
            result.append(originals[number])
            position += len(names)
        else:
            result.append(plain_transmission(actuated[position], place))
            position += 1
    return result
