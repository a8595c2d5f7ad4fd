"""Reading of robot files: URDF or xacro with the elements of this package."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

from kinetostatics.description.elements import Link, Origin
from kinetostatics.description.fields import Place
from kinetostatics.description.flexible import Flexible
from kinetostatics.description.robot_description import RobotDescription, by_name, known_valid
from kinetostatics.description.validation import check_attributes, check_loops, tree_root, validate, with_valid_mimics
from kinetostatics.exceptions import PlatformMissingError, RobotFileError
from kinetostatics.files.attributes import ElementTable, new_name, reference
from kinetostatics.files.bundled import read_robot
from kinetostatics.files.element_tables import BASE, FLEXIBLE, PLATFORM
from kinetostatics.files.foreign_robot import completed
from kinetostatics.files.link_files import read_link
from kinetostatics.files.rules import (
    lacks_axis,
    read_actuated,
    read_beams,
    read_joint_stiffness,
    read_loops,
    read_springs,
    with_counterweights,
)
from kinetostatics.files.urdf import (
    OFFERED,
    ROBOT_LEVEL,
    all_actuated,
    check_in_robot,
    chosen_platform,
    connected_links,
    extra_of_robot,
    file_name,
    first_base,
    known_link,
    read_joints,
    read_links,
)
from kinetostatics.files.xacro import read_document
from kinetostatics.files.xml import XmlElement
from kinetostatics.layout.mapping import ResultMapping


def read_robot_file(
    path: str | os.PathLike[str],
    parameters: Mapping[str, object] | None = None,
    *,
    platform_link: str | None = None,
    base_link: str | None = None,
) -> RobotDescription:
    """Read a robot file.

    Args:
        path: a URDF or xacro file, recognized by its content; or the name of a robot that comes with the package, see
            :func:`kinetostatics.robots`.
        parameters: values of the file's ``<xacro:arg>``, numbers or strings.
        platform_link: link that is the platform, with its frame as o-xyz; default: the one named in the file. All moving joints
            are actuated if the file has neither a platform nor loops.
        base_link: link fixed to the ground; default: the one named in the file, or the root of its tree. In a file without
            platform, a floating or planar joint at the root is skipped.

    Returns:
        The description.

    Raises:
        RobotFileError: the file cannot be read or is invalid; with file and line.
        ArgumentError: ``path`` is no path, a parameter is neither a number nor a string, or there is no such link.
    """
    data, name = read_robot(path)
    return _read(data, name, {} if parameters is None else parameters, platform_link, base_link)


def parameter_values(path: str | os.PathLike[str], parameters: Mapping[str, object]) -> dict[str, str]:
    """Return the values of all xacro arguments of a file, in its order: given ``parameters``, else the file's defaults."""
    data, name = read_robot(path)
    values: dict[str, str] = {}
    read_document(data, name, parameters, values)
    return values


def parse_robot_text(text: str, path: str = "<text>", parameters: Mapping[str, object] | None = None) -> RobotDescription:
    """Read a robot from XML text, URDF or xacro.

    Args:
        path: name of the text in messages; xacro searches included files in its folder.
        parameters: see :func:`read_robot_file`.

    Raises:
        RobotFileError, ArgumentError: see :func:`read_robot_file`.
    """
    return _read(text, path, {} if parameters is None else parameters)


def _read(
    data: bytes | str, path: str, parameters: Mapping[str, object], platform: str | None = None, base: str | None = None
) -> RobotDescription:
    root, _, warnings = read_document(data, path, parameters)
    robot = completed(path, root, platform)
    description = describe(robot.root, path, [*warnings, *robot.warnings], platform, base)
    return known_valid(replace(description, parameters=ResultMapping(parameters))) if parameters else description


def describe(
    root: XmlElement, path: str, warnings: list[str], platform: str | None = None, base: str | None = None
) -> RobotDescription:
    """Return the robot of an expanded element ``<robot>``; for arguments and errors see :func:`read_robot_file`."""
    name = new_name(root) if root.attributes.get("name", "").strip() else file_name(root, path, warnings)
    check_attributes(root.attributes, root)
    check_in_robot(root, warnings)
    inertia_warnings: list[str] = []
    links = read_links(root, warnings, inertia_warnings)
    links, joints = with_counterweights(root, links, read_joints(root, warnings))
    tree = tree_root(links, joints)
    loops = read_loops(root, joints, warnings)
    check_loops(loops, links, joints)
    platform_element, base_element = _only(root, PLATFORM, links), _only(root, BASE, links)
    joints = with_valid_mimics(joints, loops, warnings)
    actuated = read_actuated(root, joints, loops, warnings)
    if platform is None and platform_element is None and not loops:
        platform = chosen_platform(root, links, joints, warnings)
    if platform is not None:
        platform, place, frame = known_link("platform_link", platform, links, path), Place(path), Origin()
        if platform_element is None and not loops:
            actuated = all_actuated(joints, actuated, path, warnings)
    elif platform_element is None:
        raise PlatformMissingError(path, root.place.line, connected_links(joints, loops.values())[:OFFERED])
    else:
        platform, place, frame = (
            platform_element.attributes["link"],
            platform_element.place,
            PLATFORM.read(platform_element)["platform_origin"],
        )
    if base is not None:
        base = known_link("base_link", base, links, path)
    elif base_element is not None:
        base = base_element.attributes["link"]
    else:
        base = tree if platform_element is not None else first_base(tree, joints)
    return validate(
        RobotDescription(
            name,
            links,
            joints,
            platform,
            frame,
            base,
            loops,
            read_beams(root, {**joints, **loops}),
            read_joint_stiffness(root, os.path.dirname(path)),
            actuated,
            tuple(root.attributes.items()),
            extra_of_robot(root, ("link", "joint", *ROBOT_LEVEL)),
            path,
            platform_place=place,
            file_warnings=tuple(warnings),
            inertia_warnings=tuple(inertia_warnings),
            springs=read_springs(root),
            flexible=_read_flexible(root, path),
            default_axes=tuple(
                element.attributes["name"] for tag in ("joint", "loop") for element in root.named(tag) if lacks_axis(element)
            ),
        )
    )


def _read_flexible(root: XmlElement, path: str) -> dict[str, Flexible]:
    return by_name("flexible link", [_flexible(element, path) for element in root.named("flexible")])


def _flexible(element: XmlElement, path: str) -> Flexible:
    values = FLEXIBLE.read(element)
    file = os.path.join(os.path.dirname(path), values["file"])
    try:
        matrices = read_link(file)
    except RobotFileError as error:
        raise element.error(f"{element.label}: {error}") from None
    return Flexible(**{**values, "file": file, "name": values["name"] or values["link"]}, matrices=matrices, place=element.place)


def _only(root: XmlElement, table: ElementTable, links: Mapping[str, Link]) -> XmlElement | None:
    """Return the only element with the tag of a table, after a check that its link exists; None without an element."""
    elements = root.named(table.tag)
    if len(elements) > 1:
        raise elements[1].error(f"there are two <{table.tag}>; a robot has one")
    for element in elements:
        table.read(element)
        reference(element, "link", links, "link")
    return elements[0] if elements else None
