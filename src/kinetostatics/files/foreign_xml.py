"""Readers of joints that close loops, from XML elements of other tools within a URDF.

- ``<constraint>``: the proposal in https://github.com/ros/urdfdom/pull/264; axes are in the frames of the origins, as in a joint.
- ``<gazebo><joint>``: a joint of SDFormat, http://sdformat.org/spec.
- ``<loop_joint>``: Isaac Sim's urdf-importer-extension, UrdfParser.cpp parseLoopJoints, UrdfImporter.cpp addLoopJoints. It has no
  axis, and its documentation calls both sides <link1>, which the importer does not read.
- Drake's elements: see :func:`kinetostatics.files.sdf.read_drake`.
- ``<coupling>``: URDF+, ClusterTreeParsing.cpp (explicitRollingConstraint) of https://github.com/ROAM-Lab-ND/generalized_rbda.
- links ``closing_NAME_1``, ``closing_NAME_2``: see :func:`_closing`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

import numpy as np

from kinetostatics.description.fields import NAME, NUMBER, POINT, TEXT, VECTOR
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.joints import Joint, Loop, Y
from kinetostatics.exceptions import near_names
from kinetostatics.files import sdf
from kinetostatics.files.attributes import ElementTable, Row, reference, row
from kinetostatics.files.element_tables import LIMITS_OF_LOOP, limits, unlimited
from kinetostatics.files.foreign_loops import ForeignJoint, SourceRobot, Z
from kinetostatics.files.urdf import joints_above
from kinetostatics.files.xml import XmlElement


def _origin(field: str) -> tuple[Row, Row]:
    zero = (0.0, 0.0, 0.0)
    return Row("xyz", POINT, zero, f"{field}.xyz"), Row("rpy", VECTOR, zero, f"{field}.rpy")


#: The elements with two links, and the types that they may have.
ELEMENTS = {
    tag: ElementTable(tag, rows)
    for tag, rows in {
        "constraint": {
            "": (row(Loop, "name"), row(Loop, "type")),
            "parent": (row(Loop, "link", "predecessor"),),
            "parent_origin": _origin("predecessor_origin"),
            "parent_axis": (row(Loop, "xyz", "axis", default=None, must=True),),
            "child": (row(Loop, "link", "successor"),),
            "child_origin": _origin("successor_origin"),
            "child_axis": (row(Loop, "xyz", "axis2", default=None, must=True),),
            "limit": LIMITS_OF_LOOP,
        },
        "loop_joint": {
            "": (Row("name", NAME), Row("type", TEXT, None)),
            "link1": (Row("link", TEXT, name="predecessor"), *_origin("predecessor_origin")),
            "link2": (Row("link", TEXT, name="successor"), *_origin("successor_origin")),
            "axis": (Row("xyz", TEXT, None),),
        },
    }.items()
}
COUPLING = ElementTable(
    "coupling",
    {
        "": (Row("name", NAME, None), Row("type", TEXT, None)),
        "predecessor": (Row("link", TEXT, name="predecessor"),),
        "successor": (Row("link", TEXT, name="successor"),),
        "ratio": (Row("value", NUMBER),),
    },
)
FRAME_ELEMENT = ElementTable("frame", {"": (Row("name", NAME), Row("link", TEXT), *_origin("origin"))})
TYPES = {
    "constraint": names_of("in_loop"),
    "loop_joint": ("fixed", "revolute", "continuous", "prismatic", "planar", "spherical"),
}


def read_elements(source: SourceRobot, taken: Collection[str] = ()) -> Iterator[ForeignJoint]:
    """Yield the joints of all formats above, except those of closing frames ``taken`` for the loops of a YAML file."""
    yield from _closing_frames(source, taken)
    frames = {name: (name, frame) for name, frame in source.zero_frames.items()}
    for element in source.root.children:
        if element.tag in ELEMENTS:
            yield _two_ends(source, element)
        elif element.tag == "gazebo":
            yield from (sdf.read_joint(joint, frames, "1.6") for joint in element.named("joint"))
    for element in source.root.named("frame") if source.root.named("drake:linear_bushing_rpy") else ():
        values = FRAME_ELEMENT.read(element)
        frame = source.zero_frames[reference(element, "link", source.links, "link")] @ values["origin"].matrix
        frames[values["name"]] = values["link"], frame
    yield from sdf.read_drake(source.root, frames)


def couplings(source: SourceRobot) -> dict[str, XmlElement]:
    """Return the ``<mimic>`` of each joint that a ``<coupling>`` of URDF+ makes dependent on another one."""
    written = [element.attributes for element in source.root.named("joint")]
    dependent = {joint.get("name"): joint.get("independent", "").lower() == "false" for joint in written}
    mimics: dict[str, XmlElement] = {}
    for element in source.root.named("coupling"):
        ratio = COUPLING.read(element)["value"]
        links = [reference(element.required_child(side), "link", source.links, "link") for side in ("predecessor", "successor")]
        paths = [joints_above(link, source.parent_joints) for link in links]
        moving = [[joint.name for joint in path if not JOINT_TYPES[joint.type].is_fixed] for path in paths]
        coupled = [[name for name in names if name not in {*moving[0]} & {*moving[1]}] for names in moving]
        if [len(names) for names in coupled] != [1, 1] or not ratio:
            joints = ", ".join(name for names in coupled for name in names) or "no joint"
            raise element.error(f"{element.label} couples {joints}; only the ratio of two joints can be read, as a <mimic>")
        (leader,), (follower,) = coupled
        if dependent[leader] and not dependent[follower]:
            leader, follower, ratio = follower, leader, 1 / ratio
        mimics[follower] = XmlElement("mimic", {"joint": leader, "multiplier": repr(ratio)}, (), element.place)
    return mimics


def _two_ends(source: SourceRobot, element: XmlElement) -> ForeignJoint:
    sides = [child for child in element.children if "link" in child.attributes]
    values, place = ELEMENTS[element.tag].read(element), element.part_place
    for side in sides:
        reference(side, "link", source.links, "link")
    kind, types = values["type"], TYPES[element.tag]
    if kind is not None and kind not in types:
        raise element.error(f"{element.label} has the type {kind!r}; {near_names(kind, types)}")
    if element.tag == "loop_joint":
        del values["xyz"]  # an axis, which Isaac Sim's format does not have: in which frame is unknown
        return ForeignJoint(**values, axis=None, place=place)
    limits(values)
    values["limits"] = {name: values.pop(name) for name in ("lower", "upper", "effort", "velocity")}
    axis, other = values["axis"], values.pop("axis2")
    if JOINT_TYPES[kind].turns is Axes.BOTH:
        values["axis2"] = other or Y
    elif None not in (axis, other) and np.abs(np.subtract(axis, other)).max() > 1e-9:
        reason = f"is {kind}, and its axis differs in its two frames; turn <child_origin rpy> so that both are equal"
        raise element.error(f"{element.label} {reason}")
    return ForeignJoint(**values, place=place)


def write_constraint(loop: Loop) -> XmlElement:
    """Return the ``<constraint>`` that is read as an equal loop; the proposal has no cone."""
    axis, axis2 = loop.axis if loop.of_type.has_axis else None, loop.axis2 if loop.of_type.turns is Axes.BOTH else None
    return ELEMENTS["constraint"].write(loop, given={"axis": axis, "axis2": axis2, **unlimited(loop)})


# ---- closing frames of onshape-to-robot ------------------------------------------------------------------------------------

FRAME = re.compile(r"(closing_.+)_([12])")
#: Names of links that only mark frames.
MARK = re.compile(r"closing_.+_[12](_z)?")
#: Distance along z of the additional frames of revolute mates [m], and its tolerance for files with six digits.
Z_OFFSET, Z_TOLERANCE = 0.1, 1e-5


def _closing_frames(source: SourceRobot, taken: Collection[str]) -> Iterator[ForeignJoint]:
    pairs: dict[str, dict[str, Joint]] = {}
    for name in source.links:
        match, joint = FRAME.fullmatch(name), source.parent_joints.get(name)
        if match and name not in taken and joint is not None and JOINT_TYPES[joint.type].is_fixed:
            pairs.setdefault(match[1], {})[match[2]] = joint
    return (_closing(source, name, sides) for name, sides in pairs.items())


def _closing(source: SourceRobot, name: str, sides: Mapping[str, Joint]) -> ForeignJoint:
    """Return the joint of a mate ``closing_NAME`` of onshape-to-robot.

    Its frames on the mated parts are links fixed to them (https://onshape-to-robot.readthedocs.io, "Handling kinematic loops";
    exporter_urdf.py add_frame and assembly.py "Processing loop closing frames" of https://github.com/Rhoban/onshape-to-robot).
    Mates turn about, and slide along, z. Some versions add frames closing_NAME_1_z and closing_NAME_2_z, 0.1 m along z, to
    revolute mates and no others; otherwise the type is unknown.
    """
    if len(sides) < 2:
        ((there, joint),) = sides.items()
        missing = f"there is no link '{name}_{'2' if there == '1' else '1'}' fixed to another one"
        raise joint.place.error(f"the loop's frame {joint.child!r} has no partner: {missing}; rename it if it closes no loop")
    first, second = sides["1"], sides["2"]
    kind = "revolute" if all(_has_z_frame(source, joint) for joint in (first, second)) else None
    ends = (first.parent, first.origin, second.parent, second.origin)
    return ForeignJoint(name, kind, *ends, Z, source.links[first.child].place)


def _has_z_frame(source: SourceRobot, joint: Joint) -> bool:
    beside = source.parent_joints.get(f"{joint.child}_z")
    if beside is None or not JOINT_TYPES[beside.type].is_fixed or beside.parent != joint.parent:
        return False
    between = np.linalg.inv(joint.origin.matrix) @ beside.origin.matrix
    return bool(np.abs(between[:3, 3] - (0, 0, Z_OFFSET)).max() < Z_TOLERANCE)
