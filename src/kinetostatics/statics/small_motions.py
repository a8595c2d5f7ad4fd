"""Small motions of a robot as a graph of rigid bodies, joints and beams, and the coordinates of these motions.

Passive freedoms of joints are free, actuated joints are locked, elastic joints are springs. Coordinates are the passive and the
elastic freedoms along a spanning tree of joints. A body that only beams connect to the base has six coordinates. A joint outside
the tree closes a loop: its freedoms are coordinates too, with equations that keep the loop closed.

Vibration uses these coordinates, because every mass moves. The displacements u of the geometric stiffness, see
:mod:`kinetostatics.statics.rotation_groups`, are linear functions of them (:meth:`PlacedMotions.at_attachment`). Second order and
buckling use u without these coordinates: the force method knows the flexibility of u also where limbs or all parts are rigid.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.stiffness_matrix import elastic_rows, inverse_of_elastic, is_coupled
from kinetostatics.elements.spring import PlacedSpring
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.screws import move_twist
from kinetostatics.mechanism.body_graph import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.joints import (
    ElasticActuator,
    Freedom,
    Freedoms,
    elastic_actuators,
    freedoms_of,
    small_freedoms,
    springs_of,
)
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import find_rotation_groups


@dataclass(frozen=True)
class MovedJoint:
    """A joint between two bodies, with the indices ``columns`` of the coordinates of its freedoms.

    ``closes``: whether the joint closes a loop; ``sign``: 1 if its coordinates move the outer body relative to the inner body, −1
    if they move the inner body relative to the outer body.
    """

    connection: Connection
    inner: RigidBody
    outer: RigidBody
    columns: tuple[int, ...]
    closes: bool
    sign: int


@dataclass(frozen=True)
class Follower:
    """A coordinate ``column`` of a joint that mimics an elastic actuator: ``times`` the coordinate ``master`` of the actuator."""

    column: int
    master: int
    times: float


@dataclass(frozen=True)
class BeamEnds:
    """A beam, with the body at its start (``inner``) and the body at its end (``outer``)."""

    name: str
    inner: RigidBody
    outer: RigidBody


class SmallMotions:
    """Bodies, joints and beams of a robot, and the coordinates of its small motions.

    The file defines the elastic actuators, unless ``actuators`` is given; an actuator of infinite compliance is free.

    Attributes:
        platform: the body of the platform.
        weights: pairs of a body and the index of the weight of one of its rigid links.
        joints: all joints that transmit a force or moment.
        freedoms: for each coordinate its freedom; None for the six coordinates of a body that no joint connects.
        columns: for each body, the indices of the coordinates that move it.
        rotations: indices of the coordinates that are rotations.
        followers: the coordinates of joints that mimic elastic actuators.
        rotation_groups: the groups that rotate relative to one another with these actuators.
    """

    NOT_RECORDED = ("graph",)

    def __init__(self, model: RobotStatics, actuators: Mapping[str, ElasticActuator] | None = None) -> None:
        self.model, self.graph = model, BodyGraph(model.mechanism)
        self.body_at = {attachment: body for body in self.graph.bodies for attachment in body.attachments}
        self.platform, number = self.graph.platform, {name: k for k, name in enumerate(model.weights.names)}
        self.weights = [(body, number[name]) for body in self.graph.bodies for name in body.weights]
        self._actuators = elastic_actuators(model.mechanism) if actuators is None else actuators
        self.rotation_groups = find_rotation_groups(model, self._actuators)
        edges = [edge for edge in self.graph.edges if edge.connection is not None]
        own = {id(edge): self._freedoms(edge.connection) for edge in edges if edge.connection is not None}
        edges = [edge for edge in edges if sum(not item.stiffness for item in own[id(edge)]) < 6]
        self.joints: list[MovedJoint] = []
        self.freedoms: list[Freedom | None] = []
        self.columns: dict[RigidBody, tuple[int, ...]] = {}
        at: dict[RigidBody, list[BodyEdge]] = {}
        for edge in edges:
            for body in edge.ends:
                at.setdefault(body, []).append(edge)
        done: set[int] = set()
        for root in (self.graph.base, self.graph.platform, *self.graph.bodies):
            if root in self.columns:
                continue
            self.columns[root] = () if root is self.graph.base else self._more([None] * 6)
            queue = [root]
            for here in queue:
                for edge in at.get(here, []):
                    if id(edge) in done or edge.connection is None:
                        continue
                    done.add(id(edge))
                    inner, outer = edge.ends
                    other, mine = edge.other(here), self._more(own[id(edge)])
                    closes = other in self.columns
                    self.joints.append(
                        MovedJoint(edge.connection, inner, outer, mine, closes, 1 if closes or other is outer else -1)
                    )
                    if not closes:
                        self.columns[other] = self.columns[here] + mine
                        queue.append(other)
        self.elastic_links = [self._beam(name) for name in model.elastic_links]
        self.beams = [link for link in self.elastic_links if link.name in model.beams]
        for beam in self.elastic_links:
            self.body_at.update(zip(model.topology.span_ends[beam.name], (beam.inner, beam.outer), strict=True))
        self.followers = tuple(self._followers())
        given = [(k, freedom) for k, freedom in enumerate(self.freedoms) if freedom is not None]
        self._given, self._twists = [k for k, _ in given], Freedoms([freedom for _, freedom in given])
        # of each free body three rotations, then three translations
        self._of_free_bodies = [k for k, freedom in enumerate(self.freedoms) if freedom is None]
        self.rotations = {k for k, freedom in enumerate(self.freedoms) if freedom is not None and freedom.rotates}
        self.rotations.update(column for k, column in enumerate(self._of_free_bodies) if k % 6 < 3)

    def _beam(self, name: str) -> BeamEnds:
        """Return a beam; joints in its span, which make it telescopic, add bodies at its ends."""
        span, (start, end) = self.model.topology.spans[name], (self.body_at[at] for at in self.model.topology.span_ends[name])
        inner = self._in_span(start, span.start_link, span.inward[::-1])
        return BeamEnds(name, inner, self._in_span(end, span.end_link, span.outward[::-1]))

    def _in_span(self, body: RigidBody, link: str, joints: Iterable[Connection]) -> RigidBody:
        """Add the ``joints`` in series between ``body`` and the end of a beam; return the body at this end, fixed to the beam."""
        for joint in joints:
            mine, behind = self._more(self._freedoms(joint)), RigidBody()
            self.columns[behind] = self.columns[body] + mine
            inner, outer = (body, behind) if joint.predecessor == link else (behind, body)
            self.joints.append(MovedJoint(joint, inner, outer, mine, False, 1 if outer is behind else -1))
            body, link = behind, joint.other(link)
        return body

    def _more(self, freedoms: Iterable[Freedom | None]) -> tuple[int, ...]:
        first = len(self.freedoms)
        self.freedoms.extend(freedoms)
        return tuple(range(first, len(self.freedoms)))

    def _followers(self) -> Iterator[Follower]:
        joints = {joint.connection.name: joint for joint in self.joints}
        for name, actuator in self._actuators.items():
            for follower, times in actuator.moves[1:]:
                mine, master = joints[follower], joints[name]
                sizes = [self.model.length if item.connection.type.is_hinge else 1.0 for item in (mine, master)]
                yield Follower(mine.columns[0], master.columns[0], times * mine.sign * master.sign * sizes[0] / sizes[1])

    def _freedoms(self, joint: Connection) -> list[Freedom]:
        mechanism = self.model.mechanism
        return small_freedoms(mechanism, joint.name, freedoms_of(mechanism, joint), self._actuators)

    def stiffness_of(self, joint: MovedJoint) -> Array:
        """Return the stiffness (k, k) [N/m, N·m/rad] with respect to the displacements and rotations of a joint's coordinates."""
        freedoms = [self.freedoms[k] for k in joint.columns]
        matrix = np.diag([0.0 if freedom is None else freedom.stiffness for freedom in freedoms])
        for spring in springs_of(self.model.mechanism, joint.connection.name):
            if is_coupled(spring.compliance):
                rows = elastic_rows(spring.compliance)
                matrix[-len(rows) :, -len(rows) :] = inverse_of_elastic(spring.compliance)[np.ix_(rows, rows)]
        return matrix

    def columns_of(self, *bodies: RigidBody) -> tuple[int, ...]:
        return tuple(sorted({column for body in bodies for column in self.columns[body]}))

    def unit_twists(self, frames: Frames, o: Array) -> Array:
        """Return the twists (6, n, N) about o (3, N) per unit of each coordinate.

        Coordinates that are rotations are multiplied by the characteristic length, so that all coordinates are lengths [m].
        """
        size = self.model.length
        found = zeros_for((6, len(self.freedoms), o.shape[1]), o)
        for k, column in enumerate(self._of_free_bodies):
            found[(k + 3) % 6, column] = 1.0 if k % 6 > 2 else 1 / size
        if self._given:
            found[:, self._given] = self._twists.twists(frames, o) / np.where(self._twists.rotates, size, 1.0)[:, None]
        return found


class PlacedMotions:
    """The small motions of a robot at N poses: ``units`` (6, n, N) are the twists of its coordinates about o (3, N)."""

    def __init__(self, structure: SmallMotions, frames: Frames, o: Array) -> None:
        self.structure, self.frames, self.o = structure, frames, o
        self.units = structure.unit_twists(frames, o)
        self._places = {name: k for k, name in enumerate(structure.model.joint_table.names)}

    def moved(self, body: RigidBody, point: Array, columns: Sequence[int] | None = None) -> Array:
        """Return the twists (6, k, N) of a body at a point (3, N) per unit of each of k coordinates, by default of all n."""
        own = list(self.structure.columns[body])
        columns = range(self.units.shape[1]) if columns is None else columns
        found, where = zeros_for((6, len(columns), self.o.shape[1]), self.o), [columns.index(column) for column in own]
        found[:, where] = move_twist(self.units[:, own], (point - self.o)[:, None])
        return found

    def stretched(self, spring: PlacedSpring) -> tuple[tuple[int, ...], Array]:
        """Return the k coordinates that move the ends of a spring, and the ends' relative displacement (3, k, N) per unit."""
        bodies = [self.structure.body_at[attachment] for attachment in spring.attachments]
        columns = self.structure.columns_of(*bodies)
        start, end = (self.moved(body, point, columns)[:3] for body, point in zip(bodies, spring.points, strict=True))
        return columns, end - start

    def closure(self) -> Array:
        """Return the equations (c, n, N) [m] of closed loops, and of joints that mimic actuators, per unit of each coordinate.

        Six equations of a loop are its gap t_outer − t_inner − S q at the joint that closes it, with the motions q of the joint:
        rotation times the characteristic length, then displacement.
        """
        structure, table, N = self.structure, self.structure.model.joint_table, self.o.shape[1]
        equations = [np.zeros((0, len(structure.freedoms), N))]
        for joint in structure.joints:
            if joint.closes:
                k, own = self._places.get(joint.connection.name), list(joint.columns)
                point = self.o if k is None else self.frames.points(table.centre_body, table.centre)[:, k]
                gap = self.moved(joint.outer, point) - self.moved(joint.inner, point)
                gap[:, own] -= move_twist(self.units[:, own], (point - self.o)[:, None])
                equations.append(np.concatenate([gap[3:] * structure.model.length, gap[:3]]))
        for follower in structure.followers:
            equation = np.zeros((1, len(structure.freedoms), N))
            equation[0, follower.column], equation[0, follower.master] = 1.0, -follower.times
            equations.append(equation)
        return np.concatenate(equations)

    def at_attachment(self, attachment: str) -> Array:
        """Return the twists (6, n, N) about o of the body at an attachment per unit of each coordinate."""
        return self.moved(self.structure.body_at[attachment], self.o)

    def of_body(self, shapes: Array, body: RigidBody, point: Array) -> Array:
        """Return the twist (N, m, 6) [m, rad] of a body at a point (3, N), world axes, in the modes ``shapes`` (N, m, n)."""
        columns = self.structure.columns[body]
        return np.einsum("ikn,nmk->nmi", self.moved(body, point, columns), shapes[..., list(columns)])

    def carried(self, point: Array) -> Array:
        """Return the twists (6, 6, N) at a point (3, N) when the whole robot moves as one body, per unit of its twist about o."""
        return move_twist(np.eye(6)[:, :, None], (point - self.o)[:, None])


def signs_of_modes(shapes: Array, twists: Array, tolerance: float) -> Array:
    """Return signs (N, m, 1) of modes that make the largest component of the platform's twist positive.

    If the platform does not move in a mode, the largest coordinate is made positive.

    Args:
        shapes: (N, m, n) modes in coordinates.
        twists: (N, m, 6) twists of the platform.
        tolerance: ratio of twist and mode below which the platform does not move, and relative difference below which components
            are equal; the first of equal components decides the sign.
    """
    still = np.linalg.norm(twists, axis=-1) < tolerance * np.linalg.norm(shapes, axis=-1)
    width = max(6, shapes.shape[2])
    coordinates, platform = (np.pad(item, [(0, 0), (0, 0), (0, width - item.shape[2])]) for item in (shapes, twists))
    rows = np.where(still[..., None], coordinates, platform)
    first = np.argmax(np.abs(rows) > (1 - tolerance) * np.abs(rows).max(axis=-1, keepdims=True), axis=-1)
    return np.where(np.take_along_axis(rows, first[..., None], axis=-1) < 0, -1.0, 1.0)
