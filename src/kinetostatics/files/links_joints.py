"""The ordinary URDF part of a robot file: links, joints, and whether they form a tree.

Pinocchio ignores much of what is wrong with a URDF in silence (an incomplete ``<inertial>`` loses its mass, a link with
two parents gives another robot) and refuses the rest without saying why, so everything is checked here.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping

from kinetostatics.description.elements import Inertia, Joint, Link, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.robot import by_name
from kinetostatics.exceptions import near_names
from kinetostatics.files.element_writer import other_children
from kinetostatics.files.joint_attributes import axis_warning, lacks_axis, read_mimic
from kinetostatics.files.xml import Element
from kinetostatics.files.xml_values import direction, limits, new_name, not_negative, number, origin, reference, text

#: Elements of this package, which mean something only directly inside ``<robot>``.
ROBOT_LEVEL = ("base", "platform", "loop", "beam", "joint_stiffness", "spring", "counterweight")

#: Larger robots are refused: most links, most joints in a row, which Pinocchio's parser follows by recursion, and most
#: freedoms of all joints, with whose cube the time grows to find the poses.
MAX_LINKS, MAX_ROW, MAX_FREEDOMS = 1000, 400, 500

_LINK_CHILDREN = ("inertial", "visual", "collision")
_JOINT_CHILDREN = ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller")


def read_links(root: Element, warnings: list[str]) -> dict[str, Link]:
    """Read all ``<link>``."""
    links: list[Link] = []
    for element in root.named("link"):
        links.append(_link(element, warnings))
        if len(links) > MAX_LINKS:
            raise element.error(f"the robot has more than {MAX_LINKS} links")
    if not links:
        raise root.error("the robot has no links")
    return by_name("link", links)


def read_joints(root: Element, links: Mapping[str, Link], warnings: list[str]) -> dict[str, Joint]:
    """Read all ``<joint>``, the joints of the spanning tree."""
    joints: list[Joint] = []
    freedoms = 0
    for element in root.named("joint"):
        joints.append(_joint(element, links, warnings))
        freedoms += JOINT_TYPES[joints[-1].type].freedoms
        if freedoms > MAX_FREEDOMS:
            raise element.error(f"the joints have more than {MAX_FREEDOMS} freedoms together")
    return by_name("joint", joints)


def tree_root(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> str:
    """Return the root of the tree; raise an error if links and joints do not form one."""
    to_parent: dict[str, Joint] = {}
    for joint in joints.values():
        other = to_parent.setdefault(joint.child, joint)
        if other is not joint:
            raise joint.place.error(
                f"link {joint.child!r} has two parents, by the joints {other.name!r} and {joint.name!r}; "
                "make one of them a <loop>",
            )
    roots = [name for name in links if name not in to_parent]
    if len(roots) > 1:
        listed = ", ".join(map(repr, roots[:6])) + (", …" if len(roots) > 6 else "")
        raise links[roots[1]].place.error(
            f"the links do not hang together: {len(roots)} of them have no parent joint ({listed}); only one may"
        )
    cycle, longest = _cycle(links, to_parent)
    if cycle:
        listed = ", ".join(map(repr, cycle))
        raise links[cycle[0]].place.error(f"the joints form a cycle through the links {listed}; make one of them a <loop>")
    if longest > MAX_ROW:
        raise links[roots[0]].place.error(f"the tree has more than {MAX_ROW} joints in a row")
    return roots[0]


def _cycle(links: Mapping[str, Link], to_parent: Mapping[str, Joint]) -> tuple[list[str], int]:
    """Return the links of a cycle, or nothing if every link hangs on a root; and the most joints in a row."""
    depth: dict[str, int] = {}
    for start in links:
        path: dict[str, None] = {}  # an ordered set
        link = start
        while link in to_parent and link not in depth:
            if link in path:
                names = list(path)
                return names[names.index(link) :], 0
            path[link] = None
            link = to_parent[link].parent
        below = depth.setdefault(link, 0)
        for level, name in enumerate(reversed(path), below + 1):
            depth[name] = level
    return [], max(depth.values())


def _check_children(element: Element, known: tuple[str, ...], warnings: list[str]) -> None:
    """Refuse our elements in the wrong place, and warn of what looks like a slip of the pen."""
    for child in element.children:
        if child.tag in ROBOT_LEVEL:
            raise child.error(f"<{child.tag}> belongs directly inside <robot>, not inside {element.label}")
        if child.tag in known:
            continue
        near = difflib.get_close_matches(child.tag.lower(), known, n=1, cutoff=0.75)
        if near:
            warnings.append(f"{child.place}: <{child.tag}> in {element.label} is ignored; did you mean <{near[0]}>?")


def _link(element: Element, warnings: list[str]) -> Link:
    name = new_name(element)
    _check_children(element, _LINK_CHILDREN, warnings)
    for shape in element.named("visual") + element.named("collision"):
        origin(shape)
    inertial = element.child("inertial")
    extra = other_children(element, "inertial")
    if inertial is None:
        return Link(name, extra=extra, place=element.place)
    mass = not_negative(inertial.required_child("mass"), "value")
    frame = origin(inertial)
    inertia = Inertia(_moments(element, inertial, warnings), frame.rpy)
    return Link(name, mass, frame.xyz, inertia, has_inertial=True, extra=extra, place=element.place)


def _moments(link: Element, inertial: Element, warnings: list[str]) -> tuple[float, float, float, float, float, float]:
    """Return ixx, ixy, ixz, iyy, iyz, izz, which the statics do not need: what is missing or impossible is zero."""
    tensor = inertial.child("inertia")
    if tensor is None:
        warnings.append(
            f"{inertial.place}: <inertial> of {link.label} has no <inertia>; it counts as zero, and the statics are the same."
        )
        return (0.0,) * 6
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    found = {name: number(tensor, name) for name in names if name in tensor.attributes}
    odd = [name for name in names if name not in found or (name[1] == name[2] and found[name] < 0)]
    if odd:
        warnings.append(
            f"{tensor.place}: {', '.join(odd)} of <inertia> in {link.label} {'is' if len(odd) == 1 else 'are'} missing or "
            f"negative and count{'s' if len(odd) == 1 else ''} as zero; the statics are the same."
        )
    xx, xy, xz, yy, yz, zz = (0.0 if name in odd else found[name] for name in names)
    return xx, xy, xz, yy, yz, zz


def _joint(element: Element, links: Mapping[str, Link], warnings: list[str]) -> Joint:
    name = new_name(element)
    kind = text(element, "type")
    if kind not in (known := names_of("in_tree")):
        raise element.error(
            f"{element.label} has the type {kind!r}; {near_names(kind, known)} "
            "(joints of other types are a <loop>, or several joints in a row)"
        )
    _check_children(element, _JOINT_CHILDREN, warnings)
    parent = reference(element.required_child("parent"), "link", links, "link")
    child = reference(element.required_child("child"), "link", links, "link")
    if parent == child:
        raise element.error(f"{element.label} joins the link {parent!r} to itself")
    lower, upper, effort, velocity = _tree_limits(element, kind, warnings)
    _check_rest(element)
    frame, axis, mimic = origin(element), _axis(element, kind, warnings), read_mimic(element, warnings)
    extra = other_children(element, "parent", "child", "origin", "axis", "limit", "mimic")
    what = name, kind, parent, child, frame, axis, lower, upper, mimic, effort, velocity
    return Joint(*what, extra=extra, place=element.place)


def _axis(element: Element, kind: str, warnings: list[str]) -> Vector:
    """Return the joint's axis as a unit vector."""
    axis, default = element.child("axis"), (1.0, 0.0, 0.0)
    if not JOINT_TYPES[kind].has_axis:  # they have none, but exporters write one, often zero
        return default
    result = default if axis is None else direction(axis, "xyz")
    if JOINT_TYPES[kind].slides is Axes.ACROSS and math.hypot(*result[:2]) > 1e-9:
        stated = "its axis is not z" if axis is not None else "it has no <axis>, which in URDF means x"
        raise (axis or element).error(
            f"{element.label} is {kind} and {stated}, but Pinocchio moves planar joints in the xy plane of the "
            'joint\'s frame whatever the axis says: write <axis xyz="0 0 1"/> and turn the frame with <origin rpy>, '
            "or use a planar <loop>"
        )
    if lacks_axis(element):
        warnings.append(axis_warning(element))
    return result


def _tree_limits(element: Element, kind: str, warnings: list[str]) -> tuple[float, float, float, float]:
    """Return lower, upper, effort and velocity."""
    limit, limited = element.child("limit"), JOINT_TYPES[kind].has_limits
    if limit is None:
        if limited:
            raise element.error(
                f"{element.label} is {kind} and has no <limit>, which URDF wants: write <limit effort=… velocity=…>, "
                "with lower and upper if its range is limited"
            )
        return -math.inf, math.inf, 0.0, 0.0
    effort, velocity = not_negative(limit, "effort"), not_negative(limit, "velocity")
    lower, upper = limits(limit)
    if limited:
        return lower, upper, effort, velocity
    if JOINT_TYPES[kind].is_single and math.isfinite(lower):
        warnings.append(
            f"{limit.place}: lower and upper of {element.label} are ignored, because it is "
            f"{kind}; make it revolute if it is limited."
        )
    return -math.inf, math.inf, effort, velocity


def _check_rest(element: Element) -> None:
    """Check what only Pinocchio's parser reads, which would refuse the whole file without saying why."""
    dynamics, safety, calibration = (element.child(tag) for tag in ("dynamics", "safety_controller", "calibration"))
    if dynamics is not None:
        if not {"damping", "friction"} & set(dynamics.attributes):
            raise dynamics.error(f"<dynamics> of {element.label} has neither damping nor friction")
        for name in ("damping", "friction"):
            number(dynamics, name, 0.0)
    if safety is not None:
        number(safety, "k_velocity")
        for name in ("k_position", "soft_lower_limit", "soft_upper_limit"):
            number(safety, name, 0.0)
    if calibration is not None:
        for name in ("rising", "falling"):
            number(calibration, name, 0.0)
