"""Defaults of a URDF without elements of this package: its name, the platform, the base and the driven joints."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Collection, Mapping

from kinetostatics.description.elements import Joint
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import ArgumentError, PlatformMissingError, near_names
from kinetostatics.files.xml import XmlElement

#: Largest numbers of names in a message, and of platforms suggested.
LISTED, OFFERED = 8, 3


def listed(names: Collection[str]) -> str:
    """Return names as text, separated by commas; of many, only the first."""
    return ", ".join(map(repr, list(names)[:LISTED])) + (", …" if len(names) > LISTED else "")


def file_name(root: XmlElement, path: str, warnings: list[str]) -> str:
    """Return the name of the file without its ending, as a name for a robot without one."""
    stem = re.sub(r"\W+", "_", os.path.basename(path).partition(".")[0]).strip("_")[:100] or "robot"
    warnings.append(f"{root.place}: <robot> has no name; it is called {stem!r}, like its file.")
    return stem


def known_link(argument: str, name: str, links: Collection[str], path: str) -> str:
    """Return the name of a link given as an argument.

    Raises:
        ArgumentError: there is no such link.
    """
    if not isinstance(name, str) or name not in links:
        raise ArgumentError(f"{argument}={name!r}: {path} has no such link; {near_names(str(name), links)}")
    return name


def likely_platforms(links: Collection[str], joints: Mapping[str, Joint]) -> list[str]:
    """Return the links of a tree that may be its platform, the most probable first: moving end links, and hands.

    A hand is a link with several moving branches that have fewer joints than the path from the root to it, such as the fingers of
    a gripper. Links fixed to a hand precede its fingers. Of several links fixed to one another, the last one comes first; in arms
    it is the frame of the tool.
    """
    above = {joint.child: joint for joint in joints.values()}

    def upwards(link: str) -> list[str]:
        path = [link]
        while path[-1] in above:
            path.append(above[path[-1]].parent)
        return path

    moved = {link for link, joint in above.items() if not JOINT_TYPES[joint.type].is_fixed}
    depth = {link: sum(other in moved for other in upwards(link)) for link in links}
    branches: dict[str, set[str]] = {}
    for link in moved:
        for lower, upper in itertools.pairwise(upwards(link)):
            branches.setdefault(upper, set()).add(lower)
    hands = {link for link, below in branches.items() if len(below) > 1}
    parents = {joint.parent for joint in joints.values()}
    ends = [link for link in reversed(list(links)) if link not in parents and depth[link]]
    found: dict[str, tuple[int, int]] = {}
    for end in ends:
        hand = next((link for link in upwards(end) if link in hands), end)
        if hand != end and depth[end] < 2 * depth[hand]:
            found[end] = -depth[hand], depth[end] - depth[hand]
            if not any(depth[other] == depth[hand] and hand in upwards(other) for other in ends):
                found[hand] = -depth[hand], 0
        else:
            found[end] = -depth[end], 0
    return sorted(found, key=found.__getitem__)


def chosen_platform(root: XmlElement, links: Collection[str], joints: Mapping[str, Joint], warnings: list[str]) -> str:
    """Return the platform of a robot without loops whose file names none: the only moving end link of its tree.

    Args:
        root: the robot's element.
        links: names of all links.
        joints: all joints, by name.
        warnings: list to which a warning that names the platform is added.

    Raises:
        PlatformMissingError: there are several, or nothing moves.
    """
    found = likely_platforms(links, joints)
    if len(found) == 1:
        warnings.append(f"{root.place}: the file names no platform; it is {found[0]!r}, the only link at an end of its tree.")
        return found[0]
    if not found:
        raise root.error('the robot has no platform, and no joint moves a link that <platform link="…"/> could name')
    raise PlatformMissingError(root.place.file, root.place.line, found[:OFFERED])


def first_base(tree: str, joints: Mapping[str, Joint]) -> str:
    """Return the default base: the root of the tree, or its child if the joint between them is floating or planar.

    Files for simulators connect the robot to a world link by such a joint.
    """
    below = [joint for joint in joints.values() if joint.parent == tree]
    if len(below) == 1 and JOINT_TYPES[below[0].type].freedoms > 1:
        return first_base(below[0].child, joints)
    return tree


def drivable(joints: Mapping[str, Joint]) -> list[str]:
    """Return the joints that could be driven: those with one freedom that mimic no other."""
    return [joint.name for joint in joints.values() if JOINT_TYPES[joint.type].is_single and joint.mimic is None]


def all_driven(joints: Mapping[str, Joint], driven: tuple[str, ...], path: str, warnings: list[str]) -> tuple[str, ...]:
    """Return the driven joints of a robot without loops: all moving joints, because passive ones could carry no load.

    Args:
        joints: joints of the robot.
        driven: joints with a ``<transmission>``.
        path: path of the file.
        warnings: list to which warnings are added.
    """
    others = [name for name in drivable(joints) if name not in driven]
    if others and not driven:
        moving = f"all {len(others)} joints that move count" if others[1:] else f"the joint that moves, {others[0]!r}, counts"
        warnings.append(f"{path}: the file has no <transmission>; {moving} as driven.")
    elif others:
        warnings.append(f"{path}: joints without a <transmission> count as driven like the others: {listed(others)}.")
    return (*driven, *others)
