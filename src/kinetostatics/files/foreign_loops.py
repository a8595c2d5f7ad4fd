"""Joints in formats of other tools as pairs of frames on two links, and the one way from them to joints and loops.

Each format has a small reader that returns :class:`ForeignJoint`: of XML elements within a URDF in :mod:`foreign_xml`, of YAML
files beside it in :mod:`foreign_yaml`, of whole files in :mod:`sdf` and :mod:`mjcf`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import AT_LINK, JointStiffness, Link, Origin
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.description.joints import Joint, Loop, Mimic, X, Y
from kinetostatics.exceptions import near_names
from kinetostatics.files.element_tables import write_joint, write_link, write_loop, write_stiffness
from kinetostatics.files.urdf import joints_above, plain_transmission
from kinetostatics.files.xml import XmlElement
from kinetostatics.math.arrays import Array

Z: Vector = (0.0, 0.0, 1.0)
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
        second = self.axis2 if JOINT_TYPES[str(self.type)].turns is Axes.BOTH else Y
        ends = (self.predecessor, self.successor, self.predecessor_origin, self.successor_origin)
        loop = Loop(self.name, str(self.type), *ends, self.axis or X, second, **self.limits, place=self.place)
        return [write_loop(loop), *self.springs()]

    def springs(self) -> list[XmlElement]:
        """Return the ``<joint_stiffness>`` of an elastic joint."""
        kinds: dict[str, Keyword] = {"linear": self.stiffness[:3], "angular": self.stiffness[3:]}
        return [write_stiffness(JointStiffness(self.name, **kinds))] if self.stiffness else []


@dataclass(frozen=True)
class SourceRobot:
    """A URDF with loops in the format of another tool."""

    path: str
    root: XmlElement
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]

    @cached_property
    def parent_joints(self) -> dict[str, Joint]:
        """The joint between a link and its parent, by the link's name, for all links except the root."""
        return {joint.child: joint for joint in self.joints.values()}

    @cached_property
    def zero_frames(self) -> dict[str, Array]:
        """The frames (4, 4) of all links, relative to the root link, with all joints at zero."""
        frames: dict[str, Array] = {}
        for link in self.links:
            frames[link] = np.eye(4)
            for joint in reversed(joints_above(link, self.parent_joints)):
                frames[link] = frames[link] @ joint.origin.matrix
        return frames

    def frame(self, name: str, place: Place) -> tuple[str, Origin]:
        """Return the link and the origin on it of one of Pinocchio's frames, which has the name of a link or joint.

        For a link fixed to its parent, by which exporters mark a frame, it is the parent, and the fixed joint's origin.
        """
        if name not in {**self.links, **self.joints}:
            raise place.error(f"there is no link or joint {name!r}; {near_names(name, [*self.links, *self.joints])}")
        joint = self.joints.get(name) or self.parent_joints.get(name)
        if joint is not None and JOINT_TYPES[joint.type].is_fixed:
            return joint.parent, joint.origin
        return name if joint is None else joint.child, Origin()


def unit(vector: Array) -> Vector:
    """Return a vector divided by its length."""
    x, y, z = (vector / np.linalg.norm(vector)).tolist()
    return x, y, z


def between(
    name: str, kind: str, ends: Iterable[tuple[str, Array, Array]], axis: Vector | None, place: Place, **more: Keyword
) -> ForeignJoint:
    """Return a joint from the link, the link's frame and the joint's frame (4, 4) of its two ends, all in one frame."""
    (first, first_end), (second, second_end) = ((link, Origin.of(np.linalg.solve(frame, at))) for link, frame, at in ends)
    return ForeignJoint(name, kind, first, first_end, second, second_end, axis, place, **more)


def spring(kind: JointType, axis: Vector, stiffness: float) -> tuple[float, ...]:
    """Return the stiffness of a joint with a spring along its only freedom; empty without, or if it is oblique to the frame."""
    along = np.repeat([kind.is_slide, kind.is_hinge], 3) & np.isclose(np.abs([*axis, *axis]), 1, rtol=0, atol=ROUNDING)
    return tuple(np.where(along, stiffness, np.inf).tolist()) if stiffness > 0 and along.any() else ()


def with_names(joints: Sequence[ForeignJoint], taken: Iterable[str]) -> list[ForeignJoint]:
    """Return the joints; those without a name are called by their two links, with a number if that name is taken."""
    names, named = {*taken, *(joint.name for joint in joints)}, list[ForeignJoint]()
    for joint in joints:
        links = f"{joint.predecessor}_{joint.successor}"
        numbered = (links, *(f"{links}_{number}" for number in range(2, len(joints) + 2)))
        name = joint.name or next(name for name in numbered if name not in names)
        names.add(name)
        named.append(replace(joint, name=name))
    return named


# ---- whole files ----------------------------------------------------------------------------------------------------------


def graph(
    name: str, links: Sequence[Link], joints: Sequence[ForeignJoint], driven: Iterable[str], place: Place, warnings: list[str]
) -> XmlElement:
    """Return the element ``<robot>`` of a graph: a joint is in the tree if it reaches a new link, else it closes a loop.

    The root is the first link. Where there is a choice, joints with several freedoms close the loops, because a ``<loop>`` may
    have any type. Springs of ``driven`` joints, which are parallel to their actuators, are ignored.
    """
    driven = dict.fromkeys(driven)
    waiting = [replace(joint, stiffness=()) if joint.name in driven else joint for joint in with_names(joints, ())]
    if springs := sum(bool(joint.stiffness) and not joint.closes for joint in waiting):
        warnings.append(f"{place}: springs of joints count as relaxed at each analysed pose ({springs} of them).")
    reached = {links[0].name}
    content = [write_link(link, ()) for link in links]
    while ready := [
        joint for joint in waiting if not joint.closes and (joint.predecessor in reached) != (joint.successor in reached)
    ]:
        joint = min(ready, key=lambda joint: JOINT_TYPES[str(joint.type)].freedoms > 1)
        waiting.remove(joint)
        joint = joint if joint.predecessor in reached else joint.swapped()
        reached.add(joint.successor)
        content += tree_elements(joint)
    content += [element for joint in waiting for element in joint.elements()]
    return XmlElement("robot", {"name": name}, (*content, *(plain_transmission(joint, place) for joint in driven)), place)


def tree_elements(joint: ForeignJoint) -> list[XmlElement]:
    """Return the joints of the tree, with massless links between them, that have the freedoms of ``joint``.

    A joint whose type trees do not have becomes several, each with the name of the joint and ``_X``, ``_Y``, ``_Z`` or a number
    appended; where the frame on the successor is not the link's own, a fixed joint follows.
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
