"""Defaults of a URDF without elements of this package: its name, the platform, the base and the driven joints."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping

from kinetostatics.description.elements import Joint
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.xml import XmlElement

#: How many names a message lists.
LISTED = 8


def listed(names: Collection[str]) -> str:
    """Return names in a row, the first of them if there are many."""
    return ", ".join(map(repr, list(names)[:LISTED])) + (", …" if len(names) > LISTED else "")


def file_name(root: XmlElement, path: str, warnings: list[str]) -> str:
    """Return a name for a robot without one: its file's, without its ending."""
    stem = re.sub(r"\W+", "_", os.path.basename(path).partition(".")[0]).strip("_")[:100] or "robot"
    warnings.append(f"{root.place}: <robot> has no name; it is called {stem!r}, like its file.")
    return stem


def known_link(argument: str, name: str, links: Collection[str], path: str) -> str:
    """Return the name of a link that was given as an argument.

    Raises:
        ArgumentError: there is no such link.
    """
    if not isinstance(name, str) or name not in links:
        raise ArgumentError(f"{argument}={name!r}: {path} has no such link; {near_names(str(name), links)}")
    return name


def missing_platform(root: XmlElement, links: Collection[str], joints: Mapping[str, Joint]) -> RobotFileError:
    """Return the error of a file that does not say which link is the platform.

    It lists the links at the ends of the tree to which moving joints lead, most joints first; of several that are fixed to each
    other the last one, which in arms is the tool's frame.
    """
    above = {joint.child: joint for joint in joints.values()}
    parents = {joint.parent for joint in joints.values()}
    moving: dict[str, int] = {}
    for name in links:
        link, count = name, 0
        while link in above:
            joint = above[link]
            count += not JOINT_TYPES[joint.type].is_fixed
            link = joint.parent
        if name not in parents and count:
            moving[name] = count
    found = sorted(reversed(moving), key=lambda name: -moving[name])
    reason = 'the robot has no platform; name the moving platform with <platform link="…"/>'
    if not found:
        return root.error(f"{reason}, and the joint that moves it: no joint of this file moves")
    return root.error(
        f"{reason}, or leave the file as it is and say load_robot(…, platform_link={found[0]!r}), on the command line "
        f"--platform-link {found[0]}; links at the ends of its branches: {listed(found)}"
    )


def first_base(tree: str, joints: Mapping[str, Joint]) -> str:
    """Return the base of a file that does not name it: the root of the tree, or its child by a joint without constraints.

    Files for simulators hang the whole robot on a world by a floating or planar joint.
    """
    below = [joint for joint in joints.values() if joint.parent == tree]
    if len(below) == 1 and JOINT_TYPES[below[0].type].freedoms > 1:
        return first_base(below[0].child, joints)
    return tree


def drivable(joints: Mapping[str, Joint]) -> list[str]:
    """Return the joints that could be driven: those of one freedom that follow no other."""
    return [joint.name for joint in joints.values() if JOINT_TYPES[joint.type].is_single and joint.mimic is None]


def all_driven(joints: Mapping[str, Joint], driven: tuple[str, ...], path: str, warnings: list[str]) -> tuple[str, ...]:
    """Return the driven joints of a robot without loops: all that move, because nothing else could hold them.

    Args:
        joints: of the robot.
        driven: those with a ``<transmission>``.
        path: of the file.
        warnings: what is said is added to them.
    """
    others = [name for name in drivable(joints) if name not in driven]
    if others and not driven:
        warnings.append(f"{path}: the file has no <transmission>; its joints that move count as driven, all {len(others)}.")
    elif others:
        warnings.append(f"{path}: joints without a <transmission> count as driven like the others: {listed(others)}.")
    return (*driven, *others)
