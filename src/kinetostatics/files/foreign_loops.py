"""Loops in formats of other tools within a URDF: closing frames of onshape-to-robot, ``<loop_joint>`` of Isaac Sim."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.elements import Link, Origin
from kinetostatics.description.fields import NAME, POINT, TEXT, VECTOR, Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Joint
from kinetostatics.exceptions import near_names
from kinetostatics.files.attributes import ElementTable, Row, reference
from kinetostatics.files.xml import XmlElement


@dataclass(frozen=True)
class ForeignLoop:
    """A loop in the format of another tool; a type or axis that the format does not give is None.

    The two origins are the joint's frame on the two links that it joins; they coincide when the joint's coordinates are zero. The
    axis is a unit vector in the predecessor's origin frame. ``note`` is a remark for the message on missing information.
    """

    name: str
    type: str | None
    predecessor: str
    predecessor_origin: Origin
    successor: str
    successor_origin: Origin
    axis: Vector | None
    place: Place
    note: str = ""


@dataclass(frozen=True)
class SourceRobot:
    """A URDF with loops in the format of another tool; ``made``: names of links that were added to the URDF."""

    path: str
    root: XmlElement
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    made: frozenset[str] = frozenset()

    @cached_property
    def parent_joints(self) -> dict[str, Joint]:
        """The joint between a link and its parent, by the link's name, for all links except the root."""
        return {joint.child: joint for joint in self.joints.values()}

    @cached_property
    def zero_frames(self) -> dict[str, NDArray[np.float64]]:
        """The frames (4, 4) of all links, relative to the root link, with all joints at zero."""
        frames: dict[str, NDArray[np.float64]] = {}
        for link in self.links:
            path = []
            while link not in frames and link in self.parent_joints:
                path.append(link)
                link = self.parent_joints[link].parent
            frames.setdefault(link, np.eye(4))
            for below in reversed(path):
                joint = self.parent_joints[below]
                frames[below] = frames[joint.parent] @ joint.origin.matrix
        return frames

    def frame(self, name: str, place: Place) -> tuple[str, Origin]:
        """Return the link and the origin on it of one of Pinocchio's frames, which has the name of a link or joint.

        Exporters mark a frame by a link fixed to its parent. For such a link, the parent and the fixed joint's origin are
        returned.

        Raises:
            RobotFileError: nothing has that name; or a link and a joint have it, and the link is not the joint's child.
        """
        joint = self.joints.get(name)
        link = name if name in self.links else None
        if joint is None and link is None:
            near = near_names(name, [*self.links, *self.joints])
            raise place.error(f"there is no link or joint {name!r} in {self.path}; {near}")
        if joint is not None and link is not None and joint.child != link:
            raise place.error(f"{name!r} is the name of a link and of a joint elsewhere in {self.path}; rename one of them")
        if joint is None:
            joint = self.parent_joints.get(name)
        elif not JOINT_TYPES[joint.type].is_fixed:
            return joint.child, Origin()
        if joint is not None and JOINT_TYPES[joint.type].is_fixed:
            return joint.parent, joint.origin
        return name, Origin()


# ---- closing frames of onshape-to-robot ----------------------------------------------------------------------------------
#
# A mate called closing_NAME gives two links without a body, closing_NAME_1 and closing_NAME_2, each fixed to one of the mated
# parts by a joint …_frame whose origin is the mate's coordinate system on that part (https://onshape-to-robot.readthedocs.io,
# "Handling kinematic loops"; onshape_to_robot/exporter_urdf.py add_frame and assembly.py "Processing loop closing frames" of
# https://github.com/Rhoban/onshape-to-robot). Mates turn about, and slide along, their z axis (its "Design-time considerations",
# "Joint frames"), and both z axes have the same direction. The type of the mate is written only to MuJoCo files. Some
# versions add frames closing_NAME_1_z and closing_NAME_2_z, 0.1 m along z, to revolute mates and no others: with both, the
# mate is revolute. Actuators are not written.

FRAME = re.compile(r"(closing_.+)_([12])")
#: Names of links that only mark frames.
MARK = re.compile(r"closing_.+_[12](_z)?")
#: Distance along z of the additional frames of revolute mates [m], and its tolerance for files with six digits.
Z_OFFSET, Z_TOLERANCE = 0.1, 1e-5


def read_closing_frames(source: SourceRobot, taken: Collection[str] = ()) -> list[ForeignLoop]:
    """Return the loops of all pairs of closing frames, except frames ``taken`` for the loops of a YAML file."""
    pairs: dict[str, dict[str, Joint]] = {}
    for name, link in source.links.items():
        match = FRAME.fullmatch(name)
        if match is None or name in taken:
            continue
        joint = source.parent_joints.get(name)
        if joint is None or not JOINT_TYPES[joint.type].is_fixed:
            reason = f"the link {name!r} has the name of a loop's frame, but is not fixed to a link; rename it if it is none"
            raise link.place.error(reason)
        pairs.setdefault(match[1], {})[match[2]] = joint
    return [_closing(source, name, sides) for name, sides in pairs.items()]


def _closing(source: SourceRobot, name: str, sides: dict[str, Joint]) -> ForeignLoop:
    if len(sides) < 2:
        (there, joint), *_ = sides.items()
        missing = f"{name}_{'2' if there == '1' else '1'}"
        reason = f"the loop's frame {joint.child!r} has no partner: there is no link {missing!r}; rename it if it closes no loop"
        raise joint.place.error(reason)
    first, second = sides["1"], sides["2"]
    kind = "revolute" if all(_has_z_frame(source, joint) for joint in (first, second)) else None
    place = source.links[first.child].place
    return ForeignLoop(name, kind, first.parent, first.origin, second.parent, second.origin, (0.0, 0.0, 1.0), place)


def _has_z_frame(source: SourceRobot, joint: Joint) -> bool:
    """Whether the additional frame of a revolute mate exists, at :data:`Z_OFFSET` along z of the frame below ``joint``."""
    beside = source.parent_joints.get(f"{joint.child}_z")
    if beside is None or not JOINT_TYPES[beside.type].is_fixed or beside.parent != joint.parent:
        return False
    between = np.linalg.inv(joint.origin.matrix) @ beside.origin.matrix
    return bool(np.abs(between[:3, 3] - (0, 0, Z_OFFSET)).max() < Z_TOLERANCE)


# ---- <loop_joint> of Isaac Sim --------------------------------------------------------------------------------------------
#
# <loop_joint name="loop" type="spherical">
#   <link1 link="rod" xyz="0 0 0.3" rpy="0 0 0"/>
#   <link2 link="platform" xyz="0.1 0 0" rpy="0 0 0"/>
# </loop_joint>
#
# The importer (https://github.com/isaac-sim/urdf-importer-extension, UrdfParser.cpp parseLoopJoints and UrdfImporter.cpp
# addLoopJoints) takes the joint's pose in each link from xyz and rpy, and makes a joint of it only if its type is spherical. The
# exporter (isaacsim.asset.exporter.urdf) also writes revolute, prismatic and fixed. Neither reads or writes an axis. The
# documentation of the importer calls both sides <link1> (https://docs.isaacsim.omniverse.nvidia.com, "URDF Importer Extension"),
# which the importer itself does not read.

#: The importer's types that a loop can have.
ISAAC_TYPES = ("fixed", "revolute", "continuous", "prismatic", "planar", "spherical")
_ZERO = (0.0, 0.0, 0.0)
LOOP_JOINT = ElementTable(
    "loop_joint",
    {
        "": (Row("name", NAME), Row("type", TEXT, None)),
        **{
            side: (
                Row("link", TEXT, name=end),
                Row("xyz", POINT, _ZERO, f"{end}_origin.xyz"),
                Row("rpy", VECTOR, _ZERO, f"{end}_origin.rpy"),
            )
            for side, end in (("link1", "predecessor"), ("link2", "successor"))
        },
        "axis": (Row("xyz", TEXT, None),),
    },
)


def read_loop_joints(source: SourceRobot) -> list[ForeignLoop]:
    return [_loop_joint(source, element) for element in source.root.named("loop_joint")]


def _loop_joint(source: SourceRobot, element: XmlElement) -> ForeignLoop:
    sides = [child for child in element.children if child.tag in ("link1", "link2")]
    if [child.tag for child in sides] == ["link1", "link1"]:
        raise sides[1].error(f"{element.label} has two <link1>; call the second one <link2>, as Isaac Sim's importer requires")
    values = LOOP_JOINT.read(element)
    kind, axis = values["type"], values.pop("xyz")
    if kind in JOINT_TYPES and JOINT_TYPES[kind].is_free:
        raise element.error(f"{element.label} is {kind}, which joins nothing; take it out")
    if kind is not None and kind not in ISAAC_TYPES:
        raise element.error(f"{element.label} has the type {kind!r}, unknown to Isaac Sim; {near_names(kind, ISAAC_TYPES)}")
    for side in sides:
        reference(side, "link", source.links, "link")
    if values["predecessor"] == values["successor"]:
        raise element.error(f"{element.label} joins the link {values['predecessor']!r} to itself")
    note = "" if axis is None else f"its <axis xyz={axis!r}> is not an element of Isaac Sim's format"
    return ForeignLoop(**values, axis=None, place=element.place, note=note)
