"""Readers of joints that close loops, from XML elements of other tools within a URDF.

- ``<constraint>``: the proposal in https://github.com/ros/urdfdom/pull/264; axes are in the frames of the origins, as in a joint.
- ``<gazebo><joint>``: a joint of SDFormat, http://sdformat.org/spec.
- ``<loop_joint>``: Isaac Sim's urdf-importer-extension, UrdfParser.cpp parseLoopJoints, UrdfImporter.cpp addLoopJoints. It has no
  axis, and its documentation calls both sides <link1>, which the importer does not read.
- ``<drake:ball_constraint>``: Drake's multibody/parsing/detail_common.h.
- links ``closing_NAME_1``, ``closing_NAME_2``: see :func:`_closing`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

import numpy as np

from kinetostatics.description.elements import Origin
from kinetostatics.description.fields import NAME, POINT, TEXT, VECTOR
from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.description.joints import Joint, Loop
from kinetostatics.exceptions import near_names
from kinetostatics.files import sdf
from kinetostatics.files.attributes import ElementTable, Row, reference, row
from kinetostatics.files.element_tables import LIMITS_OF_LOOP, limits, unlimited
from kinetostatics.files.foreign_loops import ForeignJoint, SourceRobot
from kinetostatics.files.xml import XmlElement


def _origin(end: str) -> tuple[Row, Row]:
    zero = (0.0, 0.0, 0.0)
    return Row("xyz", POINT, zero, f"{end}_origin.xyz"), Row("rpy", VECTOR, zero, f"{end}_origin.rpy")


#: The elements with two links, and the types that they may have.
TABLES = {
    "constraint": {
        "": (row(Loop, "name"), row(Loop, "type")),
        "parent": (row(Loop, "link", "predecessor"),),
        "parent_origin": _origin("predecessor"),
        "parent_axis": (row(Loop, "xyz", "axis", default=None, must=True),),
        "child": (row(Loop, "link", "successor"),),
        "child_origin": _origin("successor"),
        "child_axis": (row(Loop, "xyz", "axis2", default=None, must=True),),
        "limit": LIMITS_OF_LOOP,
    },
    "loop_joint": {
        "": (Row("name", NAME), Row("type", TEXT, None)),
        "link1": (Row("link", TEXT, name="predecessor"), *_origin("predecessor")),
        "link2": (Row("link", TEXT, name="successor"), *_origin("successor")),
        "axis": (Row("xyz", TEXT, None, "note"),),
    },
    "drake:ball_constraint": {
        "": (),
        "drake:ball_constraint_body_A": (Row("name", TEXT, name="predecessor"),),
        "drake:ball_constraint_body_B": (Row("name", TEXT, name="successor"),),
        "drake:ball_constraint_p_AP": (Row("value", POINT, name="predecessor_origin.xyz"),),
        "drake:ball_constraint_p_BQ": (Row("value", POINT, None, "successor_origin.xyz"),),
    },
}
ELEMENTS = {tag: ElementTable(tag, rows) for tag, rows in TABLES.items()}
TYPES = {
    "constraint": tuple(name for name, kind in JOINT_TYPES.items() if kind.in_loop),
    "loop_joint": ("fixed", "revolute", "continuous", "prismatic", "planar", "spherical"),
}
UNKNOWN = {"constraint": "which is unknown", "loop_joint": "unknown to Isaac Sim"}


def read_elements(source: SourceRobot, taken: Collection[str] = ()) -> Iterator[ForeignJoint]:
    """Yield the joints of all formats above, except those of closing frames ``taken`` for the loops of a YAML file."""
    yield from _closing_frames(source, taken)
    for element in source.root.children:
        if element.tag in ELEMENTS:
            yield _two_ends(source, element)
        elif element.tag == "gazebo":
            frames = {name: (name, frame) for name, frame in source.zero_frames.items()}
            yield from (sdf.read_joint(joint, frames, "1.6") for joint in element.named("joint"))


def _two_ends(source: SourceRobot, element: XmlElement) -> ForeignJoint:
    sides = [child for child in element.children if {"link", "name"} & set(child.attributes)]
    if [child.tag for child in sides] == ["link1", "link1"]:
        raise sides[1].error(f"{element.label} has two <link1>; call the second one <link2>, as Isaac Sim's importer requires")
    values, place = ELEMENTS[element.tag].read(element), element.part_place
    for side in sides:
        reference(side, "link" if "link" in side.attributes else "name", source.links, "link")
    first, second = values["predecessor"], values["successor"]
    if first == second:
        raise element.error(f"{element.label} joins the link {first!r} to itself")
    if element.tag not in TYPES:  # Drake's, which coincide at its default configuration if one point is not given
        point = source.zero_frames[first] @ values["predecessor_origin"].matrix
        values["successor_origin"] = values["successor_origin"] or Origin(source.origin_on(second, point).xyz)
        return ForeignJoint(f"{first}_{second}", "spherical", **values, axis=None, place=place)
    kind, types = values["type"], TYPES[element.tag]
    if kind in JOINT_TYPES and JOINT_TYPES[kind].is_free:
        raise element.error(f"{element.label} is {kind}, which joins nothing; take it out")
    if kind is not None and kind not in types:
        raise element.error(f"{element.label} has the type {kind!r}, {UNKNOWN[element.tag]}; {near_names(kind, types)}")
    if element.tag == "loop_joint":
        axis = values["note"]
        values["note"] = "" if axis is None else f"its <axis xyz={axis!r}> is not an element of Isaac Sim's format"
        return ForeignJoint(**values, axis=None, place=place)
    limits(values)
    values["limits"] = {name: values.pop(name) for name in ("lower", "upper", "effort", "velocity")}
    axis, other = values["axis"], values.pop("axis2")
    if JOINT_TYPES[kind].turns is Axes.BOTH:
        values["axis2"] = other or (0.0, 1.0, 0.0)
    elif None not in (axis, other) and np.abs(np.subtract(axis, other)).max() > 1e-9:
        reason = f"is {kind}, and its axis differs in its two frames; turn <child_origin rpy> so that both are equal"
        raise element.error(f"{element.label} {reason}")
    return ForeignJoint(**values, place=place)


def write_constraint(loop: Loop) -> XmlElement:
    """Return the ``<constraint>`` that is read as an equal loop; the proposal has no cone."""
    axes = {
        "axis": loop.axis if loop.of_type.has_axis else None,
        "axis2": loop.axis2 if loop.of_type.turns is Axes.BOTH else None,
    }
    return ELEMENTS["constraint"].write(loop, given={**axes, **unlimited(loop)})


# ---- closing frames of onshape-to-robot ------------------------------------------------------------------------------------

FRAME = re.compile(r"(closing_.+)_([12])")
#: Names of links that only mark frames.
MARK = re.compile(r"closing_.+_[12](_z)?")
#: Distance along z of the additional frames of revolute mates [m], and its tolerance for files with six digits.
Z_OFFSET, Z_TOLERANCE = 0.1, 1e-5


def _closing_frames(source: SourceRobot, taken: Collection[str]) -> Iterator[ForeignJoint]:
    pairs: dict[str, dict[str, Joint]] = {}
    for name, link in source.links.items():
        match = FRAME.fullmatch(name)
        if match is None or name in taken:
            continue
        joint = source.parent_joints.get(name)
        if joint is None or not JOINT_TYPES[joint.type].is_fixed:
            if source.root.child("platform") is not None:  # a file of this package, where it is a link like any other
                continue
            reason = f"the link {name!r} has the name of a loop's frame, but is not fixed to a link; rename it if it is none"
            raise link.place.error(reason)
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
        (there, joint), *_ = sides.items()
        missing = f"{name}_{'2' if there == '1' else '1'}"
        reason = f"the loop's frame {joint.child!r} has no partner: there is no link {missing!r}; rename it if it closes no loop"
        raise joint.place.error(reason)
    first, second = sides["1"], sides["2"]
    kind = "revolute" if all(_has_z_frame(source, joint) for joint in (first, second)) else None
    place = source.links[first.child].place
    return ForeignJoint(name, kind, first.parent, first.origin, second.parent, second.origin, (0.0, 0.0, 1.0), place)


def _has_z_frame(source: SourceRobot, joint: Joint) -> bool:
    beside = source.parent_joints.get(f"{joint.child}_z")
    if beside is None or not JOINT_TYPES[beside.type].is_fixed or beside.parent != joint.parent:
        return False
    between = np.linalg.inv(joint.origin.matrix) @ beside.origin.matrix
    return bool(np.abs(between[:3, 3] - (0, 0, Z_OFFSET)).max() < Z_TOLERANCE)
