"""``<loop>``: joints that close loops."""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import mul

from kinetostatics.description.elements import Cone, Joint, Link, Loop, Origin, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.robot import by_name
from kinetostatics.exceptions import near_names
from kinetostatics.files.joint_attributes import axis_warning, lacks_axis
from kinetostatics.files.xml import Element
from kinetostatics.files.xml_values import allow, direction, limits, new_name, not_negative, origin, positive, reference, text

#: Larger robots are refused.
MAX_LOOPS = 250

_PARALLEL = 1e-9  # 1 − cos of the smallest angle between the two axes of a universal joint


def read_loops(root: Element, links: Mapping[str, Link], joints: Mapping[str, Joint], warnings: list[str]) -> dict[str, Loop]:
    """Read all ``<loop>``."""
    loops: list[Loop] = []
    for element in root.named("loop"):
        loops.append(_loop(element, links, warnings))
        if len(loops) > MAX_LOOPS:
            raise element.error(f"the robot has more than {MAX_LOOPS} loops")
    return by_name("joint or loop", loops, joints)


def _loop(element: Element, links: Mapping[str, Link], warnings: list[str]) -> Loop:
    name = new_name(element)
    allow(element, ("name", "type"), ("predecessor", "successor", "axis", "axis2", "limit", "cone"))
    kind = text(element, "type")
    if kind not in (known := names_of("in_loop")):
        raise element.error(f"{element.label} has the type {kind!r}; {near_names(kind, known)}")
    predecessor, first = _side(element, "predecessor", links)
    successor, second = _side(element, "successor", links)
    if predecessor == successor:
        raise element.error(f"{element.label} joins the link {predecessor!r} to itself")
    axes = _axes(element, kind, warnings)
    lower, upper, *actuator = _limits(element, kind)
    cone = _cone(element, kind)
    return Loop(name, kind, predecessor, successor, first, second, *axes, lower, upper, cone, *actuator, place=element.place)


def _side(element: Element, tag: str, links: Mapping[str, Link]) -> tuple[str, Origin]:
    side = element.required_child(tag)
    allow(side, ("link",), ("origin",))
    return reference(side, "link", links, "link"), origin(side)


def _axes(element: Element, kind: str, warnings: list[str]) -> tuple[Vector, Vector]:
    """Return ``axis`` and ``axis2``; those of a universal joint may well be left out."""
    two = JOINT_TYPES[kind].turns is Axes.BOTH
    without = {"axis": not JOINT_TYPES[kind].has_axis, "axis2": not two}
    result = {"axis": (1.0, 0.0, 0.0), "axis2": (0.0, 1.0, 0.0)}
    for tag in result:
        found = element.child(tag)
        if found is None:
            if tag == "axis" and lacks_axis(element):
                warnings.append(axis_warning(element))
            continue
        if without[tag]:
            hint = "; turn its frames with <origin rpy>" if tag == "axis" else "; only universal has"
            raise found.error(f"{element.label} is {kind} and has no <{tag}>{hint}")
        allow(found, ("xyz",))
        result[tag] = direction(found, "xyz")
    if two and 1 - abs(sum(map(mul, result["axis"], result["axis2"]))) < _PARALLEL:
        raise (element.child("axis2") or element.child("axis") or element).error(
            f"the two axes of {element.label} are parallel where its frames coincide; left out, <axis> is x and <axis2> is y"
        )
    return result["axis"], result["axis2"]


def _limits(element: Element, kind: str) -> tuple[float, float, float, float]:
    """Return lower, upper, effort and velocity."""
    limit = element.child("limit")
    if limit is None:
        return -math.inf, math.inf, 0.0, 0.0
    if not JOINT_TYPES[kind].is_single:
        right = "; a <cone> limits it" if JOINT_TYPES[kind].has_cone else ""
        raise limit.error(f"{element.label} is {kind}, and <limit> is for {', '.join(names_of('is_single'))}{right}")
    allow(limit, ("lower", "upper", "effort", "velocity"))
    effort, velocity = not_negative(limit, "effort", 0.0), not_negative(limit, "velocity", 0.0)
    lower, upper = limits(limit)
    if JOINT_TYPES[kind].endless and math.isfinite(lower):
        raise limit.error(f"{element.label} is {kind}, which means unlimited; make it revolute if it is limited")
    return lower, upper, effort, velocity


def _cone(element: Element, kind: str) -> Cone | None:
    cone = element.child("cone")
    if cone is None:
        return None
    if not JOINT_TYPES[kind].has_cone:
        raise cone.error(f"{element.label} is {kind}, and <cone> is for {' and '.join(names_of('has_cone'))}")
    allow(cone, ("angle", "predecessor_axis", "successor_axis"))
    angle = positive(cone, "angle")
    if angle > math.pi + 1e-9:  # π that was written with a few digits less may be a little larger
        raise cone.error(f"angle={angle:g} of <cone> is above π; it is an angle between two axes, in radians")
    z = (0.0, 0.0, 1.0)
    return Cone(min(angle, math.pi), direction(cone, "predecessor_axis", z), direction(cone, "successor_axis", z))
