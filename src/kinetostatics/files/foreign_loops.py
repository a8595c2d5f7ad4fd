"""Joints in formats of other tools as pairs of frames on two links, and the one way from them to joints and loops.

Each format has a small reader that returns :class:`ForeignJoint`: of XML elements within a URDF in :mod:`foreign_xml`, of YAML
files beside it in :mod:`foreign_yaml`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import AT_LINK, Link, Origin
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.description.joints import Joint, Loop, X, Y
from kinetostatics.exceptions import near_names
from kinetostatics.files.element_tables import write_joint, write_link, write_loop
from kinetostatics.files.xml import XmlElement


@dataclass(frozen=True)
class ForeignJoint:
    """A joint in the format of another tool; a type or axis that the format does not give is None.

    The two origins are the joint's frame on the two links that it joins; they coincide when the joint's coordinates are zero. The
    axis is a unit vector in the predecessor's origin frame, the second axis of a universal joint in the successor's. ``limits``:
    lower, upper, effort and velocity. ``note`` is a remark for the message on missing information.
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
    axis2: Vector = Y
    limits: Mapping[str, Keyword] = field(default_factory=dict)

    def element(self) -> XmlElement:
        """Return the ``<loop>`` of a joint with known type and axis."""
        kind = JOINT_TYPES[str(self.type)]
        more: dict[str, Keyword] = {**self.limits, "axis2": self.axis2 if kind.turns is Axes.BOTH else Y}
        more |= {"predecessor_origin": self.predecessor_origin, "successor_origin": self.successor_origin}
        axis = self.axis or X
        return write_loop(Loop(self.name, kind.name, self.predecessor, self.successor, axis=axis, **more, place=self.place))


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

    def origin_on(self, link: str, frame: NDArray[np.float64]) -> Origin:
        """Return the origin on a link of a frame (4, 4) that is given relative to the root link, with all joints at zero."""
        return Origin.of(np.linalg.solve(self.zero_frames[link], frame))

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
        joint = self.parent_joints.get(name) if joint is None else joint
        if joint is not None and JOINT_TYPES[joint.type].is_fixed:
            return joint.parent, joint.origin
        return name if joint is None else joint.child, Origin()


# ---- joints of the tree ---------------------------------------------------------------------------------------------------


def tree_elements(joint: ForeignJoint, taken: Iterable[str]) -> list[XmlElement]:
    """Return the joints of the tree, with massless links between them, that have the freedoms of ``joint``.

    Each has the name of the joint and ``_X``, ``_Y`` or ``_Z`` appended.

    Raises:
        RobotFileError: a new joint or link has a name that is ``taken``.
    """
    kind, place, parent, origin = JOINT_TYPES[str(joint.type)], joint.place, joint.predecessor, joint.predecessor_origin
    if kind.is_fixed:
        return [write_joint(Joint(joint.name, kind.name, parent, joint.successor, origin, place=place), ())]
    turns = np.eye(3).tolist() if joint.axis is None else [list(joint.axis), list(joint.axis2)]
    names = [f"{joint.name}_{'XYZ'[axis.index(1.0)]}" for axis in turns]
    links = [*(f"{name}_link" for name in names[:-1]), joint.successor]
    if clash := next((name for name in (*names, *links[:-1]) if name in taken), None):
        what = f"a link {clash!r}" if clash in links else f"a joint {clash!r}"
        raise place.error(f"the joint {joint.name!r} becomes {', '.join(names)}, but there is {what} already; rename it")
    content = [write_link(Link(name, place=place), ()) for name in links[:-1]]
    for name, child, (x, y, z) in zip(names, links, turns, strict=True):
        content.append(write_joint(Joint(name, "continuous", parent, child, origin, (x, y, z), place=place), ()))
        parent, origin = child, AT_LINK
    return content
