"""Joints: their elasticity, their freedoms, compound joints, and the elements of limbs.

A joint's compliances refer to its centre and its frame on the predecessor's side. Along a constrained direction of a joint, a
missing or infinite stiffness means rigid. Along a freedom, a finite positive stiffness is a spring; with any other value the
freedom is passive. A *compound joint* is one joint, or two or three consecutive revolutes with a common point, which form a
universal or spherical joint. An *element* is a beam, a compound joint or a fixed joint. *Inboard* means towards the base.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.elements import JointStiffness
from kinetostatics.description.fields import Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.description.stiffness_matrix import full_matrix, inverse_of_elastic
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import unit_twist
from kinetostatics.mechanism.limbs import Edge, Limb
from kinetostatics.mechanism.mechanism import Connection, Mechanism, meeting_points
from kinetostatics.mechanism.tree import Frames


@dataclass(frozen=True)
class ElasticJoint:
    """The elasticity of one joint.

    Attributes:
        body, frame: the body on the predecessor's side, and the joint frame (4, 4) in this body.
        compliance: (6, 6) twist of the successor relative to the predecessor per unit wrench about the frame's origin, in the
            joint frame [m/N, rad/(N·m)].
    """

    joint: str
    body: int
    frame: Array
    compliance: Array


@dataclass(frozen=True)
class ElasticActuator:
    """An elastic actuator. Its force is the sum, over the joints in ``moves``, of the joint's force times the joint's motion.

    Attributes:
        compliance: compliance along the joint's coordinate [m/N, rad/(N·m)].
        moves: names of the actuated joint and of joints that mimic it, each with its motion per unit of the actuated coordinate.
    """

    joint: str
    compliance: float
    moves: tuple[tuple[str, float], ...]


def springs_of(mechanism: Mechanism, joint: str) -> tuple[ElasticJoint, ...]:
    """Return the elasticity of a joint's bearings and springs; empty if there is none."""
    stiffness = mechanism.description.joint_stiffness.get(joint)
    if stiffness is None:
        return ()
    connection = mechanism.connections[joint]
    compliance = compliance_of(stiffness)
    if not np.any(compliance):
        return ()
    return (ElasticJoint(joint, connection.predecessor_body, connection.predecessor_frame, compliance),)


def elastic_actuators(mechanism: Mechanism) -> dict[str, ElasticActuator]:
    """Return all elastic actuators, by the name of the actuated joint."""
    given = {name: stiffness.drive for name, stiffness in mechanism.description.joint_stiffness.items()}
    return {name: elastic_actuator(mechanism, name, 1 / k) for name, k in given.items() if k is not None and k < np.inf}


def elastic_actuator(mechanism: Mechanism, name: str, compliance: float) -> ElasticActuator:
    """Return a joint's actuator with the given compliance [m/N, rad/(N·m)]; infinite for an actuator without force."""
    followers = [(joint.name, joint.mimic) for joint in mechanism.connections.values() if joint.mimic is not None]
    moves = ((follower, mimic.multiplier) for follower, mimic in followers if mimic.joint == name)
    return ElasticActuator(name, compliance, ((name, 1.0), *moves))


def is_sprung(stiffness: JointStiffness | None, rotates: bool, axis: Array | None) -> bool:
    """Whether a freedom of a joint, rotational if ``rotates``, has a spring.

    ``axis`` (3,) is the axis of the freedom in the joint frame on the predecessor's side; None if the axis moves in this frame.
    """
    if stiffness is None:
        return False
    compliances = np.diag(compliance_of(stiffness))[3 if rotates else 0 :][:3]
    if np.all(compliances > 0):
        return True
    if axis is None:
        return False
    along = int(np.argmax(np.abs(axis)))
    return bool(abs(axis[along]) > 1 - 1e-9 and compliances[along] > 0)


def compliance_of(stiffness: JointStiffness) -> Array:
    """Return the compliance (6, 6) of a joint's bearings and springs in its frame, 0 along and about rigid or free directions."""
    if stiffness.matrix is None:
        return np.diag([*_compliances(stiffness.linear), *_compliances(stiffness.angular)])
    return inverse_of_elastic(full_matrix(stiffness.matrix))


def _compliances(stiffness: Vector | None) -> Array:
    """Return the inverses (3,) of three stiffnesses, 0 for rigid or free directions."""
    if stiffness is None:
        return np.zeros(3)
    return np.array([1 / k if 0 < k < np.inf else 0.0 for k in stiffness])


@dataclass(frozen=True)
class Freedom:
    """One freedom of a joint: a rotation about an axis (3,) fixed in a body, or a translation along it.

    ``centre`` is a point (3,) of ``centre_body`` on the axis; ``sign`` is −1 if the joint's successor is its inboard side.
    ``passive``: whether the freedom is neither actuated nor elastic; ``stiffness``: 1 / (compliance of its spring), or 0.
    """

    rotates: bool
    body: int
    axis: Array
    centre_body: int
    centre: Array
    sign: int = 1
    label: str = ""
    passive: bool = True
    stiffness: float = 0.0


class Freedoms:
    """Freedoms as arrays; ``rotates`` (k,): True for rotations, False for translations."""

    def __init__(self, freedoms: Sequence[Freedom]) -> None:
        self.rotates = np.array([freedom.rotates for freedom in freedoms], dtype=bool)
        self._bodies = np.array([freedom.body for freedom in freedoms], dtype=np.intp)
        self._axes = np.array([freedom.axis * freedom.sign for freedom in freedoms], dtype=float).reshape(-1, 3).T
        self._centre_bodies = np.array([freedom.centre_body for freedom in freedoms], dtype=np.intp)
        self._centres = np.array([freedom.centre for freedom in freedoms], dtype=float).reshape(-1, 3).T

    def twists(self, frames: Frames, o: Array) -> Array:
        """Unit twists (6, k, N) of the freedoms about ``o`` (3, N)."""
        arms = frames.points(self._centre_bodies, self._centres) - o[:, None]
        return unit_twist(frames.directions(self._bodies, self._axes), arms, self.rotates[:, None])


def freedoms_of(mechanism: Mechanism, connection: Connection, sign: int = 1) -> tuple[Freedom, ...]:
    """Return the freedoms of a joint or loop, from predecessor to successor; in the opposite order if ``sign`` is −1."""
    kind, stiffness = connection.type, mechanism.description.joint_stiffness.get(connection.name)
    here, frame, there, other = (
        *(connection.predecessor_body, connection.predecessor_frame),
        *(connection.successor_body, connection.successor_frame),
    )
    moved = there, other[:3, 3]
    centre = moved if kind.slides is not Axes.NONE and not kind.is_on_axis else (here, frame[:3, 3])

    def freedom(rotates: bool, body: int, axis: Array, centre: tuple[int, Array], which: str = "") -> Freedom:
        local_axis = frame[:3, :3].T @ axis if body == here else None  # None: the axis moves in the predecessor's frame
        passive = not connection.actuated and not is_sprung(stiffness, rotates, local_axis)
        return Freedom(rotates, body, axis, *centre, sign, connection.name + which, passive)

    slides, turns = (frame[:3, :3] @ axes for axes in kind.axes(connection.axis))
    freedoms = [freedom(False, here, axis, moved) for axis in slides.T]
    freedoms += [freedom(True, here, axis, centre, " (first axis)" if kind.turns is Axes.BOTH else "") for axis in turns.T]
    if kind.turns is Axes.BOTH:
        freedoms.append(freedom(True, there, other[:3, :3] @ connection.axis2, centre, " (second axis)"))
    return tuple(freedoms if sign > 0 else freedoms[::-1])


def small_freedoms(
    mechanism: Mechanism, joint: str, freedoms: Sequence[Freedom], actuators: Mapping[str, ElasticActuator]
) -> list[Freedom]:
    """Return the freedoms of small motions of a joint with given ``freedoms`` under elastic or free ``actuators``.

    They are its passive freedoms, that of an actuator or of a joint that mimics one, and its elastic directions.
    """
    moving = [freedom for freedom in freedoms if freedom.passive]
    if any(joint == name for actuator in actuators.values() for name, _ in actuator.moves):
        actuator = actuators.get(joint)
        moving.append(replace(freedoms[0], stiffness=0.0 if actuator is None else 1 / actuator.compliance))
    for spring in springs_of(mechanism, joint):
        body, R, centre, compliances = spring.body, spring.frame[:3, :3], spring.frame[:3, 3], np.diag(spring.compliance)
        for k in np.flatnonzero(compliances):
            stiffness = 1 / float(compliances[k])
            moving.append(Freedom(bool(k > 2), body, R[:, k % 3], body, centre, passive=False, stiffness=stiffness))
    return moving


@dataclass(frozen=True)
class CompoundJoint:
    """A joint of a limb, or two or three consecutive revolutes with a common point.

    Attributes:
        type: type of the joint; for two or three revolutes ``universal`` or ``spherical``.
        label: name in reports.
        joints: names of the joints that form it.
        passive: whether at least one freedom is neither actuated nor elastic.
        dofs: its freedoms, from base to platform.
        edge: index of its outermost joint among the limb's edges.
        has_centre: whether its centre is a geometric feature of the robot, not an arbitrary point of its axis; see
            :func:`has_centre`.
        shift: distance [m] of the centre from the origin of its outermost joint, along this joint's axis.
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
        """Whether the basis of a limb's wrenches may contain forces through the centre."""
        return self.has_centre or any(dof.rotates for dof in self.dofs)

    def has_axis(self, rotates: bool) -> bool:
        """Whether the axes of the joint's rotations or (not ``rotates``) translations are features of the robot."""
        return (self.type.turns if rotates else self.type.slides) in (Axes.AXIS, Axes.BOTH)


def has_centre(mechanism: Mechanism, connection: Connection) -> bool:
    """Whether a joint's origin is a geometric feature of the robot, not an arbitrary point of its axis.

    It is a feature if a beam ends there, or if axes of a universal or spherical joint meet there.
    """
    if not connection.type.is_on_axis:
        return True
    beams = mechanism.description.elastic_links.values()
    ends = {end.joint for beam in beams for end in (beam.start, beam.end) if end is not None}
    return connection.name in ends or any(beam.link in (connection.predecessor, connection.successor) for beam in beams)


def compound_joints(
    mechanism: Mechanism, limb: Limb, joint_names: Collection[tuple[str, ...]] | None = None
) -> tuple[CompoundJoint, ...]:
    """Return the compound joints of a limb, inboard ones first, without fixed joints.

    ``joint_names``: joints of each compound joint, as found at another pose; None: any revolutes with a common point.
    """
    steps: list[tuple[int, Edge, Connection]] = []
    compounds: list[CompoundJoint] = []

    def flush() -> None:
        while steps:
            for count in (3, 2, 1):
                centres, names = None, tuple(connection.name for _, _, connection in steps[:count])
                if len(names) == count and (joint_names is None or names in joint_names):
                    centres = _common_centre([(edge, connection) for _, edge, connection in steps[:count]])
                if count == 1 or centres is not None:
                    compounds.append(_compound_of_run(mechanism, steps[:count], centres))
                    del steps[:count]
                    break

    stiffness = mechanism.description.joint_stiffness
    for position, edge in enumerate(limb.edges):
        connection = mechanism.connections[edge.joint] if edge.joint else None
        elastic = connection is not None and connection.name in stiffness
        if connection is not None and connection.type.is_hinge and not connection.actuated and not elastic:
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
    """A beam, a compound joint or a fixed joint of a limb; limbs of equal structure have corresponding elements.

    Attributes:
        edges: indices of the element's edges in the limb, the outermost edge last.
        parent: index of the element on the inboard side, −1 for none.
        cut_joints: (k, sign): the element's wrench contains the wrench of the limb's cut joint k with this sign.
        compound: index of the compound joint, None for a beam or a fixed joint.
        turned: whether paths from base to platform pass the element in both directions, and its direction is opposite to that
            in the file.
    """

    edges: tuple[int, ...]
    parent: int
    cut_joints: tuple[tuple[int, int], ...]
    compound: int | None
    is_link: bool
    turned: bool

    @property
    def signature(self) -> tuple[object, ...]:
        """Key that is equal for corresponding elements of limbs of equal structure."""
        return self.parent, self.cut_joints, self.compound, self.is_link, self.turned and self.is_link


def limb_elements(limb: Limb, compounds: Sequence[CompoundJoint]) -> tuple[Element, ...]:
    compound_of = {joint: number for number, compound in enumerate(compounds) for joint in compound.joints}
    elements: list[Element] = []
    ends: dict[str, int] = {}
    pending: list[int] = []
    for k, edge in enumerate(limb.edges):
        pending.append(k)
        number = compound_of.get(edge.joint) if edge.joint is not None else None
        if number is not None and k != compounds[number].edge:
            continue
        inner = limb.edges[pending[0]].parent
        parent = -1 if inner is None else ends.get(inner, -1)  # of the first elements it may be an elastic base
        turned = edge.both_ways and edge.sign < 0
        elements.append(Element(tuple(pending), parent, edge.cut_joints, number, edge.span is not None, turned))
        ends.update((limb.edges[j].key, len(elements) - 1) for j in pending)
        pending = []
    return tuple(elements)


def sides(edge: Edge, connection: Connection) -> tuple[tuple[int, Array], tuple[int, Array]]:
    """Return (body, joint frame (4, 4)) on the inboard side of a joint, and on its outboard side."""
    first, second = connection.predecessor_body, connection.successor_body
    sides = (first, connection.predecessor_frame), (second, connection.successor_frame)
    return sides if edge.sign > 0 else (sides[1], sides[0])


def _common_centre(run: Sequence[tuple[Edge, Connection]]) -> tuple[float, float] | None:
    """Return (a, b) [m], positions of the common point of 2 or 3 revolutes on the innermost and outermost axis; None without one.

    A position is the distance along the axis from the joint's origin.
    """
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
