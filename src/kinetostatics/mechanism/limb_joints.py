"""Compound joints and elements of a limb: revolutes with a common point form one universal or spherical joint."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.joint_freedoms import Freedom, freedoms_of
from kinetostatics.mechanism.limbs import Edge, Limb
from kinetostatics.mechanism.mechanism import Connection, Mechanism, meeting_points


@dataclass(frozen=True)
class CompoundJoint:
    """A joint of a limb; consecutive revolutes with a common point form one universal or spherical joint.

    Attributes:
        type: its type; for two or three revolutes with a common point ``universal`` or ``spherical``.
        label: its name in reports.
        joints: names of its joints.
        passive: whether at least one of its freedoms is passive (neither driven nor elastic).
        dofs: its freedoms, base to platform.
        edge: index of its last joint among the limb's edges.
        has_centre: whether its centre is a point of the machine; otherwise it is an arbitrary point of the axis in the file.
        shift: distance of its centre from the origin of its last joint, along this joint's axis [m].
    """

    type: JointType
    label: str
    joints: tuple[str, ...]
    passive: bool
    dofs: tuple[Freedom, ...]
    edge: int
    has_centre: bool
    shift: float = 0.0

    @property
    def has_point(self) -> bool:
        """Whether a force through its centre is a feature of the limb: a beam ends there, or axes pass through it."""
        return self.has_centre or any(dof.rotates for dof in self.dofs)

    def has_axis(self, rotates: bool) -> bool:
        """Whether the axes of its rotations or translations are lines of the machine, not arbitrary axes of the file."""
        return (self.type.turns if rotates else self.type.slides) in (Axes.AXIS, Axes.BOTH)


def has_centre(mechanism: Mechanism, connection: Connection) -> bool:
    """Whether a joint's origin is a geometric feature of the robot, not an arbitrary point of its axis.

    Beams end at origins, and the axes of a universal or spherical joint meet there.
    """
    if not connection.type.is_on_axis:
        return True
    beams = mechanism.description.beams.values()
    ends = {end.joint for beam in beams for end in (beam.start, beam.end) if end is not None}
    return connection.name in ends or any(beam.link in (connection.predecessor, connection.successor) for beam in beams)


def compound_joints(
    mechanism: Mechanism, limb: Limb, together: Collection[tuple[str, ...]] | None = None
) -> tuple[CompoundJoint, ...]:
    """Return the compound joints of a limb, inboard ones first, without fixed joints.

    Args:
        mechanism: the mechanism.
        limb: the limb.
        together: names of the joints of each compound joint, if these are known from another pose; None: found here.
    """
    steps: list[tuple[int, Edge, Connection]] = []
    compounds: list[CompoundJoint] = []

    def flush() -> None:
        while steps:
            for count in (3, 2, 1):
                centres, names = None, tuple(item.name for _, _, item in steps[:count])
                if len(names) == count and (together is None or names in together):
                    centres = _common_centre([(edge, item) for _, edge, item in steps[:count]])
                if count == 1 or centres is not None:
                    compounds.append(_compound_of_run(mechanism, steps[:count], centres))
                    del steps[:count]
                    break

    stiffness = mechanism.description.joint_stiffness
    for position, edge in enumerate(limb.edges):
        connection = mechanism.connections[edge.joint] if edge.joint else None
        elastic = connection is not None and connection.name in stiffness
        if connection is not None and connection.type.is_hinge and not connection.driven and not elastic:
            steps.append((position, edge, connection))
        elif connection is None or not connection.type.is_fixed or elastic:
            flush()
            if connection is not None and not connection.type.is_fixed:
                dofs, name = freedoms_of(mechanism, connection, edge.sign), connection.name
                passive, fixed = any(dof.passive for dof in dofs), has_centre(mechanism, connection)
                compounds.append(CompoundJoint(connection.type, name, (name,), passive, dofs, position, fixed))
        if limb.ends[position]:
            flush()
    flush()
    return tuple(compounds)


@dataclass(frozen=True)
class Element:
    """A beam or a compound joint of a limb; equal limbs have equal elements.

    Attributes:
        edges: indices of its edges in the limb; the last is its outboard end.
        parent: index of the element on its inboard side, −1 for none.
        cut_joints: signs of the cut-joint wrenches in it, by index.
        compound: index of the compound joint, None for a beam or a fixed joint.
        is_beam: whether it is a beam.
        turned: whether paths from base to platform pass it in both directions, and its direction is opposite to the file's.
    """

    edges: tuple[int, ...]
    parent: int
    cut_joints: tuple[tuple[int, int], ...]
    compound: int | None
    is_beam: bool
    turned: bool

    @property
    def signature(self) -> tuple[object, ...]:
        """Key that equal elements of limbs built alike share."""
        return self.parent, self.cut_joints, self.compound, self.is_beam, self.turned and self.is_beam


def limb_elements(limb: Limb, compounds: Sequence[CompoundJoint]) -> tuple[Element, ...]:
    """Return a limb's elements, inboard ones first."""
    compound_of = {joint: number for number, compound in enumerate(compounds) for joint in compound.joints}
    found: list[Element] = []
    ends: dict[str, int] = {}
    pending: list[int] = []
    for k, edge in enumerate(limb.edges):
        pending.append(k)
        number = compound_of.get(edge.joint) if edge.joint is not None else None
        if number is not None and k != compounds[number].edge:
            continue
        inner = limb.edges[pending[0]].parent
        parent = -1 if inner is None else ends[inner]
        turned = edge.both_ways and edge.sign < 0
        found.append(Element(tuple(pending), parent, edge.cut_joints, number, edge.beam is not None, turned))
        ends.update((limb.edges[j].key, len(found) - 1) for j in pending)
        pending = []
    return tuple(found)


def sides(edge: Edge, connection: Connection) -> tuple[tuple[int, Array], tuple[int, Array]]:
    """Return body and joint frame on the inboard and outboard side."""
    first, second = connection.predecessor_body, connection.successor_body
    sides = (first, connection.predecessor_frame), (second, connection.successor_frame)
    return sides if edge.sign > 0 else (sides[1], sides[0])


def _common_centre(run: Sequence[tuple[Edge, Connection]]) -> tuple[float, float] | None:
    """Return the positions on the first and last axis [m, from the origins] of the common point of 2 or 3 revolutes, or None."""
    if len(run) < 2:
        return None
    meetings = []
    places = [frame[:3, 3] for edge, connection in run for _, frame in sides(edge, connection)]
    size = 1 + float(np.max(np.abs(places)))
    for (edge, connection), (next_edge, following) in itertools.pairwise(run):
        body, frame = sides(edge, connection)[1]
        next_body, next_frame = sides(next_edge, following)[0]
        if body != next_body:
            return None
        axis, next_axis = frame[:3, :3] @ connection.axis, next_frame[:3, :3] @ following.axis
        meeting = meeting_points(axis, frame[:3, 3], next_axis, next_frame[:3, 3])
        if meeting is None:
            return None
        meetings.append(meeting)
    if len(meetings) == 2 and abs(meetings[0][1] - meetings[1][0]) > 1e-9 * size:
        return None
    return meetings[0][0], meetings[-1][1]


def _compound_of_run(
    mechanism: Mechanism, run: Sequence[tuple[int, Edge, Connection]], meeting: tuple[float, float] | None
) -> CompoundJoint:
    names = tuple(connection.name for _, _, connection in run)
    same = itertools.takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
    label = names[0] if len(names) == 1 else "".join(letter for letter, *_ in same).rstrip("_-. ") or "+".join(names)
    first_edge, first = run[0][1], run[0][2]
    body, frame = sides(first_edge, first)[0]
    shift, last_shift = meeting if meeting is not None else (0.0, 0.0)
    centre = frame[:3, 3] + shift * (frame[:3, :3] @ first.axis)
    kind = JOINT_TYPES[("revolute", "universal", "spherical")[len(run) - 1]]
    dofs = [
        Freedom(True, connection.predecessor_body, connection.axis_on(True), body, centre, edge.sign, connection.name)
        for _, edge, connection in run
    ]
    if len(run) == 3:
        dofs = [Freedom(True, body, axis, body, centre, 1, label) for axis in np.eye(3)]
    fixed = len(run) > 1 or has_centre(mechanism, first)
    return CompoundJoint(kind, label, names, True, tuple(dofs), run[-1][0], fixed, last_shift)
