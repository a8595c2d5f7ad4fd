"""A loop in the format of another tool, and the URDF that it belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.elements import Joint, Link, Origin, Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import near_names
from kinetostatics.files.xml import XmlElement


@dataclass(frozen=True)
class ForeignLoop:
    """A loop in the format of another tool; None stands for missing information.

    Attributes:
        name: name of the loop.
        type: one of the types of ``<loop>``, or None.
        predecessor, successor: the two links that the loop joins.
        predecessor_origin, successor_origin: the joint's frame in each of them; the two coincide at the joint's zero.
        axis: unit vector of the joint's axis in the predecessor's origin frame, or None.
        place: file and line.
        note: remark for the message on missing information; may be empty.
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
    """A URDF with loops in the format of another tool.

    Attributes:
        path: path of the file.
        root: its ``<robot>`` element.
        links, joints: its links and joints, by name.
        made: names of the links that were added on import.
    """

    path: str
    root: XmlElement
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    made: frozenset[str] = frozenset()

    @cached_property
    def parent_joints(self) -> dict[str, Joint]:
        """The parent joint of each link except the root, by the link's name."""
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
        """Return the link, and the origin in it, of a frame of Pinocchio: a link or a joint, by its name.

        For a link fixed to its parent, by which exporters mark a frame, the result is the parent and the origin of the fixed
        joint.

        Raises:
            RobotFileError: nothing has that name, or a link and a joint elsewhere both have it.
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
