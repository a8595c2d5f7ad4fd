"""The URDF part of a robot file: links, joints, their tree, and defaults for files without elements of this package.

Pinocchio ignores many errors of a URDF (an incomplete ``<inertial>`` loses its mass, a link with two parents gives another robot)
and rejects others without a reason. Therefore all elements are checked here.
"""

from __future__ import annotations

import difflib
import itertools
import os
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Protocol

from kinetostatics.description.elements import Inertia, Link
from kinetostatics.description.fields import NUMBER, Place
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Joint
from kinetostatics.description.robot_description import by_name
from kinetostatics.description.validation import usual_joint
from kinetostatics.exceptions import ArgumentError, PlatformMissingError, near_names
from kinetostatics.files.attributes import new_name, text, value_of
from kinetostatics.files.element_tables import INERTIAL, JOINT, MOMENTS, SHAPE, limits
from kinetostatics.files.rules import axis_warning, lacks_axis
from kinetostatics.files.xml import XmlElement, to_text

#: Elements of this package, valid only as children of ``<robot>``.
ROBOT_LEVEL = ("base", "platform", "loop", "beam", "flexible", "joint_stiffness", "spring", "counterweight")

#: Child elements of links and joints that fields of the description have; others are kept as XML.
LINK_FIELDS, JOINT_FIELDS = ("inertial",), ("parent", "child", "origin", "axis", "limit", "mimic")
#: Elements that only Pinocchio's parser reads, which rejects wrong ones without a reason: required and optional numbers.
_DYNAMICS = {
    "dynamics": ((), ("damping", "friction")),
    "safety_controller": (("k_velocity",), ("k_position", "soft_lower_limit", "soft_upper_limit")),
    "calibration": ((), ("rising", "falling")),
}


def read_links(root: XmlElement, warnings: list[str], inertia_warnings: list[str]) -> dict[str, Link]:
    links = [_link(element, warnings, inertia_warnings) for element in root.named("link")]
    if not links:
        raise root.error("the robot has no links")
    return by_name("link", links)


def read_joints(root: XmlElement, warnings: list[str]) -> dict[str, Joint]:
    return by_name("joint", [_joint(element, warnings) for element in root.named("joint")])


def other_children(element: XmlElement, *children: str) -> str:
    """Return, as XML, the child elements whose tags are not among ``children``."""
    return "".join(to_text(child, header=False) for child in element.children if child.tag not in children)


def plain_transmission(joint: str, place: Place) -> XmlElement:
    """Return a transmission without further elements, which only marks a joint as actuated."""
    entry = XmlElement("joint", {"name": joint}, (), place)
    return XmlElement("transmission", {"name": f"drive_{joint}"}, (entry,), place)


def extra_of_robot(root: XmlElement, read_tags: Iterable[str]) -> str:
    """Return, as XML, the child elements of ``<robot>`` except ``read_tags`` and plain transmissions; transmissions last."""
    kept = [child for child in root.children if child.tag not in (*read_tags, "transmission")]
    for child in root.named("transmission"):
        names = [entry.attributes.get("name", "") for entry in child.named("joint")]
        if len(names) != 1 or to_text(child, header=False) != to_text(plain_transmission(names[0], child.place), header=False):
            kept.append(child)
    return "".join(to_text(child, header=False) for child in kept)


def _check_children(element: XmlElement, known_tags: tuple[str, ...], warnings: list[str]) -> None:
    """Raise an error for elements of this package in a wrong place, and warn of probable misspellings."""
    for child in element.children:
        if child.tag in known_tags:
            continue
        if child.tag in ROBOT_LEVEL:
            raise child.error(f"<{child.tag}> belongs directly inside <robot>, not inside {element.label}")
        near = difflib.get_close_matches(child.tag.lower(), known_tags, n=1, cutoff=0.75)
        if near:
            warnings.append(f"{child.place}: <{child.tag}> in {element.label} is ignored; did you mean <{near[0]}>?")


def _link(element: XmlElement, warnings: list[str], inertia_warnings: list[str]) -> Link:
    name = new_name(element)
    check_in_link(element, warnings)
    inertial = element.child("inertial")
    extra = other_children(element, *LINK_FIELDS)
    if inertial is None:
        return Link(name, extra=extra, place=element.place)
    values = INERTIAL.read(inertial)
    inertia = Inertia(_moments(element, inertial, inertia_warnings), values.pop("rpy"))
    return Link(name, **values, inertia=inertia, has_inertial=True, extra=extra, place=element.place)


def check_in_link(link: XmlElement, warnings: list[str]) -> None:
    """Check the child elements of a link that are kept for other programs."""
    _check_children(link, (*LINK_FIELDS, "visual", "collision"), warnings)
    for shape in link.named("visual") + link.named("collision"):
        SHAPE.read(shape)


def _moments(link: XmlElement, inertial: XmlElement, warnings: list[str]) -> tuple[float, float, float, float, float, float]:
    """Return ixx, ixy, ixz, iyy, iyz, izz; missing ones are zero."""
    tensor = inertial.child("inertia")
    if tensor is None:
        warnings.append(f"{inertial.place}: <inertial> of {link.label} has no <inertia>, which modes and motions take as zero.")
        return (0.0,) * 6
    missing = [name for name in MOMENTS if name not in tensor.attributes]
    if missing:
        listed = ", ".join(missing)
        warnings.append(f"{tensor.place}: <inertia> of {link.label} lacks {listed}, which modes and motions take as zero.")
    xx, xy, xz, yy, yz, zz = (0.0 if name in missing else value_of(tensor, name, NUMBER) for name in MOMENTS)
    return xx, xy, xz, yy, yz, zz


def _joint(element: XmlElement, warnings: list[str]) -> Joint:
    kind = JOINT_TYPES.get(text(element, "type"))
    without = [] if kind is None or kind.has_axis else ["axis"]  # exporters write one nevertheless, often zero
    values = JOINT.read(element, without)
    limits(values)
    joint = Joint(**values, extra=other_children(element, *JOINT_FIELDS), place=element.part_place)
    if joint.of_type.has_limits and element.child("limit") is None:
        raise element.error(
            f"{element.label} is {joint.type} and has no <limit>, which URDF requires: write <limit effort=… velocity=…>, "
            "with lower and upper if its range is limited"
        )
    check_in_joint(element, warnings)
    joint = usual_joint(joint, warnings)
    if lacks_axis(element):
        warnings.append(axis_warning(element))
    return joint


def check_in_joint(joint: XmlElement, warnings: list[str]) -> None:
    """Check the child elements of a joint that are kept for other programs."""
    _check_children(joint, (*JOINT_FIELDS, *_DYNAMICS), warnings)
    for tag, (needed, others) in _DYNAMICS.items():
        child = joint.child(tag)
        if child is None:
            continue
        if tag == "dynamics" and not set(others) & set(child.attributes):
            raise child.error(f"<dynamics> of {joint.label} has neither damping nor friction")
        for name in (*needed, *(name for name in others if name in child.attributes)):
            value_of(child, name, NUMBER)


def check_in_robot(root: XmlElement, _warnings: list[str]) -> None:
    """Raise an error for misspelled child elements, which would otherwise be ignored, and for materials defined twice."""
    known_tags = (*ROBOT_LEVEL, "transmission", "link", "joint")
    materials: set[str] = set()
    for child in root.children:
        near = [] if child.tag in known_tags else difflib.get_close_matches(child.tag.lower(), known_tags, n=1, cutoff=0.75)
        if near and ":" not in child.tag:
            raise child.error(f"<{child.tag}> is not an element of robot files; did you mean <{near[0]}>?")
        if child.tag == "material":
            material = child.attributes.get("name", "")
            if material in materials:
                raise child.error(f"the material {material!r} is defined twice")
            materials.add(material)


# ---- defaults of a URDF without elements of this package -------------------------------------------------------------------


class Joins(Protocol):
    """A loop, or a joint in the format of another tool."""

    @property
    def predecessor(self) -> str: ...
    @property
    def successor(self) -> str: ...


#: Largest numbers of names in a message, and of platforms suggested.
LISTED, OFFERED = 8, 3


def file_name(root: XmlElement, path: str, warnings: list[str]) -> str:
    """Return the file's name without its ending, for a robot whose file gives no name."""
    stem = re.sub(r"\W+", "_", os.path.basename(path).partition(".")[0]).strip("_")[:100] or "robot"
    warnings.append(f"{root.place}: <robot> has no name; it is called {stem!r}, like its file.")
    return stem


def known_link(argument: str, name: str, links: Collection[str], path: str) -> str:
    """Return ``name``, after a check that such a link exists."""
    if not isinstance(name, str) or name not in links:
        raise ArgumentError(f"{argument}={name!r}: {path} has no such link; {near_names(str(name), links)}")
    return name


def joints_above(link: str, parent_joints: Mapping[str, Joint]) -> list[Joint]:
    """Return the joints between a link and the root link, in this order, from the joint between each link and its parent."""
    joints: list[Joint] = []
    while link in parent_joints:
        joints.append(parent_joints[link])
        link = joints[-1].parent
    return joints


def likely_platforms(links: Collection[str], joints: Mapping[str, Joint]) -> list[str]:
    """Return the links of a tree that may be its platform, the most probable first: moving end links, and hands.

    A hand is a link with several moving branches (the fingers of a gripper), each with fewer joints than the path from the root
    to the hand. Hands and links fixed to them precede the fingers. Of several end links fixed to one another, the last one in the
    file comes first, because in files of arms it is the frame of the tool.
    """
    above = {joint.child: joint for joint in joints.values()}

    def upwards(link: str) -> list[str]:
        return [link, *(joint.parent for joint in joints_above(link, above))]

    moved = {link for link, joint in above.items() if not JOINT_TYPES[joint.type].is_fixed}
    depth = {link: sum(other in moved for other in upwards(link)) for link in links}
    branches: dict[str, set[str]] = {}
    for link in moved:
        for lower, upper in itertools.pairwise(upwards(link)):
            branches.setdefault(upper, set()).add(lower)
    hands = {link for link, below in branches.items() if len(below) > 1}
    parents = {joint.parent for joint in joints.values()}
    ends = [link for link in reversed(list(links)) if link not in parents and depth[link]]
    ranks: dict[str, tuple[int, int]] = {}
    for end in ends:
        hand = next((link for link in upwards(end) if link in hands), end)
        if hand != end and depth[end] < 2 * depth[hand]:
            ranks[end] = -depth[hand], depth[end] - depth[hand]
            if not any(depth[other] == depth[hand] and hand in upwards(other) for other in ends):
                ranks[hand] = -depth[hand], 0
        else:
            ranks[end] = -depth[end], 0
    return sorted(ranks, key=ranks.__getitem__)


def chosen_platform(root: XmlElement, links: Collection[str], joints: Mapping[str, Joint], warnings: list[str]) -> str:
    """Return the platform of a robot without loops, if its file names no platform: the only moving end link of the tree.

    Raises:
        PlatformMissingError: there are several moving end links.
        RobotFileError: nothing moves.
    """
    likely = likely_platforms(links, joints)
    if len(likely) == 1:
        warnings.append(f"{root.place}: the file names no platform; it is {likely[0]!r}, the only link at an end of its tree.")
        return likely[0]
    if not likely:
        raise root.error('the robot has no platform, and no joint moves a link that <platform link="…"/> could name')
    raise PlatformMissingError(root.place.file, root.place.line, likely[:OFFERED])


def connected_links(joints: Mapping[str, Joint], loops: Iterable[Joins]) -> list[str]:
    """Return the links of a robot with loops that may be its platform, those with the most moving joints and loops first.

    Links that only fixed joints connect to the root are none. Of equal ones, those farther from the base come first.
    """
    ends = [(joint.parent, joint.child) for joint in joints.values() if not JOINT_TYPES[joint.type].is_fixed]
    ends += [(loop.predecessor, loop.successor) for loop in loops]
    counts = Counter(link for pair in ends for link in pair)
    above = {joint.child: joint for joint in joints.values()}
    paths = {link: joints_above(link, above) for link in above}
    moved = [link for link, path in paths.items() if any(not JOINT_TYPES[joint.type].is_fixed for joint in path)]
    return sorted((link for link in counts if link in (moved or above)), key=lambda link: (-counts[link], -len(paths[link])))


def first_base(tree: str, joints: Mapping[str, Joint]) -> str:
    """Return the default base: the root of the tree, or its child if the joint between them is floating or planar.

    By such a joint, files for simulators connect the robot to a world link.
    """
    below = [joint for joint in joints.values() if joint.parent == tree]
    if len(below) == 1 and JOINT_TYPES[below[0].type].freedoms > 1:
        return first_base(below[0].child, joints)
    return tree


def drivable(joints: Mapping[str, Joint]) -> list[str]:
    """Return the names of the joints with one freedom and without ``<mimic>``."""
    return [joint.name for joint in joints.values() if JOINT_TYPES[joint.type].is_single and joint.mimic is None]


def all_actuated(joints: Mapping[str, Joint], actuated: tuple[str, ...], path: str, warnings: list[str]) -> tuple[str, ...]:
    """Return the names of all joints that can be actuated, for a robot without loops: passive joints could carry no load."""
    others = [name for name in drivable(joints) if name not in actuated]
    if others and not actuated:
        moving = f"all {len(others)} joints that move count" if others[1:] else f"the joint that moves, {others[0]!r}, counts"
        warnings.append(f"{path}: the file has no <transmission>; {moving} as actuated.")
    elif others:
        listed = ", ".join(map(repr, others[:LISTED])) + (", …" if len(others) > LISTED else "")
        warnings.append(f"{path}: joints without a <transmission> count as actuated like the others: {listed}.")
    return (*actuated, *others)
