"""The URDF part of a robot file: links, joints, and whether they form a tree.

Pinocchio ignores many errors of a URDF (an incomplete ``<inertial>`` loses its mass, a link with two parents gives another robot)
and rejects others without a reason. Therefore all elements are checked here.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping

from kinetostatics.description.elements import Inertia, Joint, Link
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.robot_description import by_name
from kinetostatics.exceptions import near_names
from kinetostatics.files.attribute_values import LONGEST, new_name, number, reference, text
from kinetostatics.files.element_tables import INERTIAL, JOINT, MOMENTS, SHAPE, limits
from kinetostatics.files.rules import SINGLE, axis_warning, lacks_axis
from kinetostatics.files.xml import XmlElement, to_text

#: Elements of this package, valid only as children of ``<robot>``.
ROBOT_LEVEL = ("base", "platform", "loop", "beam", "joint_stiffness", "spring", "counterweight")

_LINK_CHILDREN = ("inertial", "visual", "collision")
_JOINT_CHILDREN = ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller")
#: Elements read by Pinocchio's parser only, which rejects files without a reason: required numbers, and others.
_DYNAMICS = {
    "dynamics": ((), ("damping", "friction")),
    "safety_controller": (("k_velocity",), ("k_position", "soft_lower_limit", "soft_upper_limit")),
    "calibration": ((), ("rising", "falling")),
}


def read_links(root: XmlElement, warnings: list[str]) -> dict[str, Link]:
    """Read all ``<link>``."""
    links = [_link(element, warnings) for element in root.named("link")]
    if not links:
        raise root.error("the robot has no links")
    return by_name("link", links)


def read_joints(root: XmlElement, links: Mapping[str, Link], warnings: list[str]) -> dict[str, Joint]:
    """Read all ``<joint>``, the joints of the spanning tree."""
    return by_name("joint", [_joint(element, links, warnings) for element in root.named("joint")])


def tree_root(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> str:
    """Return the root of the tree.

    Raises:
        RobotFileError: links and joints do not form a tree.
    """
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
            f"{len(roots)} links have no parent joint ({listed}), and only one may: make every other link the child of one "
            "<joint>, with <loop> for the joints that are left"
        )
    on_tree = set(roots)
    for start in links:
        path: dict[str, None] = {}  # used as an ordered set
        link = start
        while link not in on_tree and link not in path:
            path[link] = None
            link = to_parent[link].parent
        if link in path:
            cycle = list(path)[list(path).index(link) :]
            listed = ", ".join(map(repr, cycle))
            raise links[cycle[0]].place.error(f"the joints form a cycle through the links {listed}; make one of them a <loop>")
        on_tree.update(path)
    return roots[0]


def other_children(element: XmlElement, *children: str) -> str:
    """Return the text of the child elements of ``element`` whose tags are not among ``children``."""
    return "".join(to_text(child, header=False) for child in element.children if child.tag not in children)


def _check_children(element: XmlElement, known: tuple[str, ...], warnings: list[str]) -> None:
    """Raise an error for elements of this package in a wrong place, and warn of probable misspellings."""
    for child in element.children:
        if child.tag in known:
            continue
        if child.tag in ROBOT_LEVEL:
            raise child.error(f"<{child.tag}> belongs directly inside <robot>, not inside {element.label}")
        near = difflib.get_close_matches(child.tag.lower(), known, n=1, cutoff=0.75)
        if near:
            warnings.append(f"{child.place}: <{child.tag}> in {element.label} is ignored; did you mean <{near[0]}>?")


def _link(element: XmlElement, warnings: list[str]) -> Link:
    name = new_name(element)
    _check_children(element, _LINK_CHILDREN, warnings)
    for shape in element.named("visual") + element.named("collision"):
        SHAPE.read(shape)
    inertial = element.child("inertial")
    extra = other_children(element, "inertial")
    if inertial is None:
        return Link(name, extra=extra, place=element.place)
    found = INERTIAL.read(inertial)
    inertia = Inertia(_moments(element, inertial, warnings), found.pop("rpy"))
    return Link(name, **found, inertia=inertia, has_inertial=True, extra=extra, place=element.place)


def _moments(link: XmlElement, inertial: XmlElement, warnings: list[str]) -> tuple[float, float, float, float, float, float]:
    """Return ixx, ixy, ixz, iyy, iyz, izz, with zero for missing or impossible values; the statics does not use them."""
    tensor = inertial.child("inertia")
    if tensor is None:
        warnings.append(
            f"{inertial.place}: <inertial> of {link.label} has no <inertia>; it counts as zero, and the statics are the same."
        )
        return (0.0,) * 6
    found = {name: number(tensor, name) for name in MOMENTS if name in tensor.attributes}
    odd = [name for name in MOMENTS if name not in found or (name[1] == name[2] and found[name] < 0)]
    if odd:
        warnings.append(
            f"{tensor.place}: {', '.join(odd)} of <inertia> in {link.label} {'is' if len(odd) == 1 else 'are'} missing or "
            f"negative and count{'s' if len(odd) == 1 else ''} as zero; the statics are the same."
        )
    xx, xy, xz, yy, yz, zz = (0.0 if name in odd else found[name] for name in MOMENTS)
    return xx, xy, xz, yy, yz, zz


def _joint(element: XmlElement, links: Mapping[str, Link], warnings: list[str]) -> Joint:
    kind = text(element, "type")
    if kind not in (known := names_of("in_tree")):
        raise element.error(
            f"{element.label} has the type {kind!r}; {near_names(kind, known)} "
            "(joints of other types are a <loop>, or several joints in a row)"
        )
    of_kind = JOINT_TYPES[kind]
    _check_children(element, _JOINT_CHILDREN, warnings)
    without = [] if of_kind.has_axis else ["axis"]  # exporters write one nevertheless, often zero
    mimic = element.child("mimic")
    if mimic is not None and of_kind.is_fixed:
        warnings.append(f"{mimic.place}: <mimic> of {element.label} is ignored, because this joint is fixed.")
        without.append("mimic")
    found = JOINT.read(element, without)
    for tag in ("parent", "child"):
        reference(element.required_child(tag), "link", links, "link")
    if found["parent"] == found["child"]:
        raise element.error(f"{element.label} joins the link {found['parent']!r} to itself")
    limits(found, element)
    if not of_kind.has_limits:
        if of_kind.is_single and math.isfinite(found["lower"]):
            warnings.append(
                f"{element.required_child('limit').place}: lower and upper of {element.label} are ignored, because it is "
                f"{kind}; make it revolute if it is limited."
            )
        found["lower"], found["upper"] = -math.inf, math.inf
    extra = other_children(element, "parent", "child", "origin", "axis", "limit", "mimic")
    joint = Joint(**found, extra=extra, place=element.place)
    _check_joint(element, joint, warnings)
    return joint


def _check_joint(element: XmlElement, joint: Joint, warnings: list[str]) -> None:
    """Check a joint independently of other joints and links."""
    kind, axis = JOINT_TYPES[joint.type], element.child("axis")
    if kind.has_limits and element.child("limit") is None:
        raise element.error(
            f"{element.label} is {kind.name} and has no <limit>, which URDF wants: write <limit effort=… velocity=…>, "
            "with lower and upper if its range is limited"
        )
    for tag, (needed, others) in _DYNAMICS.items():
        found = element.child(tag)
        if found is None:
            continue
        if tag == "dynamics" and not set(others) & set(found.attributes):
            raise found.error(f"<dynamics> of {element.label} has neither damping nor friction")
        for name in (*needed, *(name for name in others if name in found.attributes)):
            number(found, name)
    if kind.slides is Axes.ACROSS and math.hypot(*joint.axis[:2]) > 1e-9:
        stated = "its axis is not z" if axis is not None else "it has no <axis>, which in URDF means x"
        raise (axis or element).error(
            f"{element.label} is {kind.name} and {stated}, but Pinocchio moves planar joints in the xy plane of the "
            'joint\'s frame whatever the axis says: write <axis xyz="0 0 1"/> and turn the frame with <origin rpy>, '
            "or use a planar <loop>"
        )
    if lacks_axis(element):
        warnings.append(axis_warning(element))
    mimic = element.child("mimic")
    if joint.mimic is None or mimic is None:
        return
    if not kind.is_single:
        raise mimic.error(f"{element.label} is {kind.name} and cannot mimic; only joints with one freedom can: {SINGLE}")
    multiplier, offset = joint.mimic.multiplier, joint.mimic.offset
    if not 1 / LONGEST <= abs(multiplier) <= LONGEST:
        raise mimic.error(
            f"multiplier={multiplier:g} of <mimic> in {element.label} must be of a size between {1 / LONGEST:g} and "
            f"{LONGEST:g}: the joint's coordinate is multiplier times the other's, in m and rad, plus offset"
        )
    if abs(offset) > LONGEST:
        raise mimic.error(f"offset={offset:g} of <mimic> in {element.label} is too large; it is in m or rad, at most {LONGEST:g}")
