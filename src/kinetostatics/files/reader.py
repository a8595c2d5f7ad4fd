"""Reading of robot files: URDF or xacro with the elements of this package."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import replace

from kinetostatics.description.elements import Link, Origin, Place
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.files.attributes import ElementTable, new_name, reference
from kinetostatics.files.bundled import read_robot
from kinetostatics.files.element_tables import BASE, PLATFORM
from kinetostatics.files.foreign_robot import unread_loops
from kinetostatics.files.rules import (
    check_leaders,
    lacks_axis,
    read_beams,
    read_driven,
    read_joint_stiffness,
    read_loops,
    read_springs,
    with_counterweights,
    with_valid_mimics,
)
from kinetostatics.files.urdf import (
    ROBOT_LEVEL,
    all_driven,
    chosen_platform,
    extra_of_robot,
    file_name,
    first_base,
    known_link,
    read_joints,
    read_links,
    tree_root,
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
            are driven if the file has neither a platform nor loops.
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
    found = describe(root, path, warnings, platform, base)
    return known_valid(replace(found, parameters=ResultMapping(parameters))) if parameters else found


def known_valid(description: RobotDescription) -> RobotDescription:
    """Mark a description as valid, after changes that preserve validity."""
    object.__setattr__(description, "is_valid", True)
    return description


def describe(
    root: XmlElement, path: str, warnings: list[str], platform: str | None = None, base: str | None = None
) -> RobotDescription:
    """Return the robot of an expanded element ``<robot>``; for arguments and errors see :func:`read_robot_file`."""
    name = new_name(root) if root.attributes.get("name", "").strip() else file_name(root, path, warnings)
    _check_robot_level(root)
    inertia_warnings: list[str] = []
    links = read_links(root, warnings, inertia_warnings)
    joints = read_joints(root, links, warnings)
    links, joints = with_counterweights(root, links, joints)
    tree = tree_root(links, joints)
    loops = read_loops(root, links, joints, warnings)
    platform_element, base_element = _only(root, PLATFORM, links), _only(root, BASE, links)
    joints = with_valid_mimics(root, joints, loops, warnings)
    driven = read_driven(root, joints, loops, warnings)
    if platform_element is None and not loops and (where := unread_loops(path, root, links)):
        raise root.error(
            f"the robot has loops of another tool ({where}); make a robot file with them: kinetostatics new --from {path}"
        )
    if platform is None and platform_element is None and not loops:
        platform = chosen_platform(root, links, joints, warnings)
    if platform is not None:
        platform, place, frame = known_link("platform_link", platform, links, path), Place(path), Origin()
        if platform_element is None and not loops:
            driven = all_driven(joints, driven, path, warnings)
    elif platform_element is None:
        raise root.error('the robot has no platform; name the moving platform with <platform link="…"/>, or by platform_link')
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
    if base == platform:
        raise place.error(f"the link {base!r} is both base and platform")
    check_leaders(root, joints, driven)
    return known_valid(
        RobotDescription(
            name,
            links,
            joints,
            platform,
            frame,
            base,
            loops,
            read_beams(root, links, {**joints, **loops}, {base: "base", platform: "platform"}),
            read_joint_stiffness(root, joints, loops, driven),
            driven,
            tuple((key, value) for key, value in root.attributes.items() if key != "name"),
            extra_of_robot(root, ("link", "joint", *ROBOT_LEVEL)),
            path,
            platform_place=place,
            file_warnings=tuple(warnings),
            inertia_warnings=tuple(inertia_warnings),
            springs=read_springs(root, links),
            default_axes=tuple(
                item.attributes["name"] for tag in ("joint", "loop") for item in root.named(tag) if lacks_axis(item)
            ),
        )
    )


def _check_robot_level(root: XmlElement) -> None:
    """Raise an error for misspelled child elements, which would otherwise be ignored, and for materials defined twice."""
    version = root.attributes.get("version", "1.0")
    if version.strip() not in ("1.0", "1"):
        raise root.error(f"version={version!r} of <robot> is unknown; URDF has version 1.0")
    known = (*ROBOT_LEVEL, "transmission", "link", "joint")
    materials: set[str] = set()
    for child in root.children:
        near = [] if child.tag in known else difflib.get_close_matches(child.tag.lower(), known, n=1, cutoff=0.75)
        if near and ":" not in child.tag:
            raise child.error(f"<{child.tag}> is not an element of robot files; did you mean <{near[0]}>?")
        if child.tag == "material":
            material = child.attributes.get("name", "")
            if material in materials:
                raise child.error(f"the material {material!r} is defined twice")
            materials.add(material)


def _only(root: XmlElement, table: ElementTable, links: Mapping[str, Link]) -> XmlElement | None:
    """Return the only element with the tag of a table, after a check that its link exists; None without an element."""
    found = root.named(table.tag)
    if len(found) > 1:
        raise found[1].error(f"there are two <{table.tag}>; a robot has one")
    for element in found:
        table.read(element)
        reference(element, "link", links, "link")
    return found[0] if found else None
