"""Joints in formats of other tools as pairs of frames on two links, and the one way from them to joints and loops.

Each format has a small reader that returns :class:`ForeignJoint`: of XML elements within a URDF in :mod:`foreign_xml`, of YAML
files beside it in :mod:`foreign_yaml`, of whole files in :mod:`sdf` and :mod:`mjcf`.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import AT_LINK, JointStiffness, Link, Origin
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.description.joints import Joint, Loop, Mimic, X, Y
from kinetostatics.exceptions import near_names
from kinetostatics.files.element_tables import write_joint, write_link, write_loop, write_stiffness
from kinetostatics.files.xml import XmlElement

#: Largest entry of the difference of two frames [m, 1] that is a rounding error.
ROUNDING = 1e-14


@dataclass(frozen=True)
class ForeignJoint:
    """A joint in the format of another tool; a type or axis that the format does not give is None.

    The two origins are the joint's frame on the two links that it joins; they coincide when the joint's coordinates are zero. The
    axis is a unit vector in the predecessor's origin frame, the second axis of a universal joint in the successor's. ``name``:
    empty if the format has none; ``limits``: lower, upper, effort and velocity; ``closes``: whether it closes a loop in any case;
    ``stiffness``: of an elastic joint, along and about x, y and z of its frame [N/m, N·m/rad].
    """

    name: str
    type: str | None
    predecessor: str
    predecessor_origin: Origin
    successor: str
    successor_origin: Origin
    axis: Vector | None
    place: Place
    axis2: Vector = Y
    limits: Mapping[str, Keyword] = field(default_factory=dict)
    mimic: Mimic | None = None
    closes: bool = True
    stiffness: tuple[float, ...] = ()

    def swapped(self) -> ForeignJoint:
        """Return the same joint, with the same coordinates, from the successor to the predecessor."""
        first, second = (self.axis2, self.axis or X) if JOINT_TYPES[str(self.type)].turns is Axes.BOTH else (self.axis or X,) * 2
        values: dict[str, Keyword] = {"axis": tuple(-x for x in first), "axis2": tuple(-x for x in second)}
        values |= {"predecessor": self.successor, "predecessor_origin": self.successor_origin}
        return replace(self, **values, successor=self.predecessor, successor_origin=self.predecessor_origin)

    def elements(self) -> list[XmlElement]:
        """Return the ``<loop>`` of a joint with known type and axis, and its ``<joint_stiffness>``."""
        kind = JOINT_TYPES[str(self.type)]
        more: dict[str, Keyword] = {**self.limits, "axis2": self.axis2 if kind.turns is Axes.BOTH else Y}
        more |= {"predecessor_origin": self.predecessor_origin, "successor_origin": self.successor_origin}
        axis = self.axis or X
        loop = Loop(self.name, kind.name, self.predecessor, self.successor, axis=axis, **more, place=self.place)
        return [write_loop(loop), *self.springs()]

    def springs(self) -> list[XmlElement]:
        """Return the ``<joint_stiffness>`` of an elastic joint."""
        linear, angular = self.stiffness[:3], self.stiffness[3:]
        return [write_stiffness(JointStiffness(self.name, linear, angular))] if self.stiffness else []  # type: ignore[arg-type]


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

    def above(self, link: str) -> list[Joint]:
        """Return the joints between a link and the root link, in this order."""
        joints: list[Joint] = []
        while link in self.parent_joints:
            joints.append(self.parent_joints[link])
            link = joints[-1].parent
        return joints

    @cached_property
    def zero_frames(self) -> dict[str, NDArray[np.float64]]:
        """The frames (4, 4) of all links, relative to the root link, with all joints at zero."""
        frames: dict[str, NDArray[np.float64]] = {}
        for link in self.links:
            frames[link] = np.eye(4)
            for joint in reversed(self.above(link)):
                frames[link] = frames[link] @ joint.origin.matrix
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


def free_name(name: str, taken: Iterable[str]) -> str:
    """Return a name that is not taken: ``name``, or ``name`` and a number."""
    numbered = (f"{name}_{number}" for number in itertools.count(2))
    return next(text for text in (name, *itertools.islice(numbered, 1000)) if text not in set(taken))


def spring(kind: JointType, axis: Vector, stiffness: float) -> tuple[float, ...]:
    """Return the stiffness of a joint with a spring along its only freedom; empty without, or if it is oblique to the frame."""
    along = np.repeat([kind.is_slide, kind.is_hinge], 3) & np.isclose(np.abs([*axis, *axis]), 1, rtol=0, atol=ROUNDING)
    return tuple(np.where(along, stiffness, np.inf).tolist()) if stiffness > 0 and along.any() else ()


#: The warning about springs, with their number.
RELAXED = "springs of joints count as relaxed at each analysed pose ({} of them)."


def with_names(joints: Sequence[ForeignJoint], taken: Iterable[str]) -> list[ForeignJoint]:
    """Return the joints; those without a name are called by their two links, with a number if that name is taken."""
    names, named = {*taken, *(joint.name for joint in joints)}, list[ForeignJoint]()
    for joint in joints:
        name = joint.name or free_name(f"{joint.predecessor}_{joint.successor}", names)
        names.add(name)
        named.append(replace(joint, name=name))
    return named


# ---- joints of the tree ---------------------------------------------------------------------------------------------------


def graph_elements(links: Sequence[Link], joints: Sequence[ForeignJoint], root: str) -> list[XmlElement]:
    """Return links, joints and loops of a graph: a joint is in the tree if it reaches a new link, else it closes a loop.

    Where there is a choice, joints with several freedoms close the loops, because a ``<loop>`` may have any type.
    """
    waiting, reached = with_names(joints, ()), {root}
    names = {link.name for link in links} | {joint.name for joint in waiting}
    content = [write_link(link, ()) for link in links]
    while ready := [
        joint for joint in waiting if not joint.closes and (joint.predecessor in reached) != (joint.successor in reached)
    ]:
        joint = min(ready, key=lambda joint: JOINT_TYPES[str(joint.type)].freedoms > 1)
        waiting.remove(joint)
        joint = joint if joint.predecessor in reached else joint.swapped()
        reached.add(joint.successor)
        content += tree_elements(joint, names)
    return [*content, *(element for joint in waiting for element in joint.elements())]


def tree_elements(joint: ForeignJoint, taken: Iterable[str]) -> list[XmlElement]:
    """Return the joints of the tree, with massless links between them, that have the freedoms of ``joint``.

    A joint whose type trees do not have becomes several, each with the name of the joint and ``_X``, ``_Y``, ``_Z`` or a number
    appended; where the frame on the successor is not the link's own, a fixed joint follows.

    Raises:
        RobotFileError: a new joint or link has a name that is ``taken``.
    """
    kind, place, end = JOINT_TYPES[str(joint.type)], joint.place, joint.successor
    moves = [(joint.name, kind.name, joint.axis or X)] if kind.in_tree else list(_single_freedoms(joint))
    offset = np.linalg.inv(joint.successor_origin.matrix)
    if kind.is_fixed:
        origin = Origin.of(joint.predecessor_origin.matrix @ offset)
        return [write_joint(Joint(joint.name, "fixed", joint.predecessor, end, origin, place=place), ())]
    if np.abs(offset - np.eye(4)).max() > ROUNDING:
        end = f"{joint.name}_frame"
    links = [f"{name}_link" for name, _, _ in moves[:-1]] + [end]
    new = [name for name in (*(name for name, _, _ in moves), *links) if name not in (joint.name, joint.successor)]
    if clash := next((name for name in new if name in taken), None):
        raise place.error(f"the joint {joint.name!r} becomes {', '.join(new)}, but there is a {clash!r} already; rename it")
    content = [write_link(Link(name, place=place), ()) for name in links if name != joint.successor]
    parent, origin = joint.predecessor, joint.predecessor_origin
    for (name, type_name, axis), child in zip(moves, links, strict=True):
        more: dict[str, Keyword] = {"axis": axis} if JOINT_TYPES[type_name].has_axis else {}
        more |= {**joint.limits, "mimic": joint.mimic} if kind.in_tree and kind.is_single else {}
        content.append(write_joint(Joint(name, type_name, parent, child, origin, **more, place=place), ()))
        parent, origin = child, AT_LINK
    if end != joint.successor:
        mount = Joint(f"{joint.name}_mount", "fixed", end, joint.successor, Origin.of(offset), place=place)
        content.append(write_joint(mount, ()))
    return [*content, *joint.springs()]


def _single_freedoms(joint: ForeignJoint) -> Iterator[tuple[str, str, Vector]]:
    """Yield name, type and axis of the joints with one freedom each that together move like ``joint``."""
    kind = JOINT_TYPES[str(joint.type)]
    slides, turns = kind.axes(np.array(joint.axis or X))
    moves = [("prismatic", axis) for axis in slides.T.tolist()] + [("continuous", axis) for axis in turns.T.tolist()]
    moves += [("continuous", list(joint.axis2))] if kind.turns is Axes.BOTH else []
    for number, (type_name, (x, y, z)) in enumerate(moves):
        letters = [letter for letter, unit in zip("XYZ", np.eye(3).tolist(), strict=True) if [x, y, z] == unit]
        yield f"{joint.name}_{letters[0] if letters else number + 1}", type_name, (x, y, z)
