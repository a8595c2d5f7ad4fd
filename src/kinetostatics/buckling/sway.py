"""What keeps the two ends of a member from moving against each other, if the member itself is a rod with hinged ends.

Everything else is rigid and the actuators are locked: what still moves is held by nothing but the member's own stiffness against
bending, as the tip of a driven crank is.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.mechanism.rigid_bodies import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.tree import Frames

_TOLERANCE = 1e-7


class EdgeMotions:
    """What the edges of a robot leave free and hold at one pose, each worked out once for all members.

    Attributes:
        frames: of the pose.
        size: of the robot [m], by which shifts are divided.
    """

    def __init__(self, frames: Frames, size: float) -> None:
        self.frames, self.size = frames, size
        self._twists: dict[int, Array] = {}
        self._held: dict[int, Array] = {}

    def twists(self, edge: BodyEdge) -> Array:
        """Return the twists (6, k) that an edge leaves free: rotation, and shift at the origin over the robot's size [m]."""
        if id(edge) not in self._twists:
            self._twists[id(edge)] = _twists(edge, self.frames, self.size)
        return self._twists[id(edge)]

    def held(self, edge: BodyEdge) -> Array:
        """Return wrenches (m, 6) that span what does no work on these twists."""
        if id(edge) not in self._held:
            self._held[id(edge)] = _held(self.twists(edge))
        return self._held[id(edge)]


def free_motions(
    graph: BodyGraph, motions: EdgeMotions, without: Collection[int], ends: tuple[RigidBody, RigidBody], rod: Array, twists: bool
) -> Array:
    """Return how the second end can still move against the first (6, k): rotation, and shift of the member's platform end.

    The motions that the edges of a spanning tree allow are the unknowns; the other edges and the rod are their equations.

    Args:
        graph: pieces and edges of the robot.
        motions: of the edges, at one pose.
        without: ids of the edges that are taken out: the member's beams.
        ends: what holds the member at its base and platform end.
        rod: (2, 3) the member's ends [m].
        twists: whether the member also passes a torque on.
    """
    edges = [edge for edge in graph.edges if id(edge) not in without]
    at: dict[RigidBody, list[BodyEdge]] = {}
    for edge in edges:
        for body in edge.ends:
            at.setdefault(body, []).append(edge)
    columns: list[Array] = []  # (6,) each: twists at the origin of what lies beyond an edge of the tree
    way: dict[RigidBody, list[int]] = {}  # the columns that move a piece
    tree: set[int] = set()
    for root in (graph.base, *graph.bodies()):
        if root in way:
            continue
        way[root] = [] if root is graph.base else list(range(len(columns), len(columns) + 6))
        columns += [] if root is graph.base else list(np.eye(6))  # nothing joins it to the base
        queue = [root]
        while queue:
            here = queue.pop()
            for edge in at.get(here, []):
                other = edge.other(here)
                if other not in way:
                    free = motions.twists(edge)
                    way[other] = [*way[here], *range(len(columns), len(columns) + free.shape[1])]
                    columns += list(free.T)
                    tree.add(id(edge))
                    queue.append(other)
    basis = np.array(columns).reshape(-1, 6).T

    def twist(body: RigidBody) -> Array:
        found = np.zeros_like(basis)
        found[:, way[body]] = basis[:, way[body]]
        return found

    rows = [motions.held(edge) @ (twist(edge.outer.find()) - twist(edge.inner.find())) for edge in edges if id(edge) not in tree]
    points = rod / motions.size
    x = (rod[1] - rod[0]) / np.linalg.norm(rod[1] - rod[0])
    inner, outer = ends
    longer = [np.concatenate([cross(point, x), x]) @ twist(body) for body, point in ((outer, points[1]), (inner, points[0]))]
    rows.append((longer[0] - longer[1])[None])
    if twists:
        rows.append((x @ (twist(outer) - twist(inner))[:3])[None])
    _, values, axes = np.linalg.svd(np.concatenate(rows))
    moving = axes[int(np.sum(values > _TOLERANCE * max(values[0], 1.0) if values.size else 0)) :].T
    found = (twist(outer) - twist(inner)) @ moving
    found[3:] += cross(found[:3], points[1][:, None])
    return np.asarray(found)


def _held(free: Array) -> Array:
    if free.shape[1] == 0:
        return np.eye(6)
    axes, values, _ = np.linalg.svd(free)
    return np.asarray(axes[:, int(np.sum(values > 6 * np.finfo(float).eps * values[0])) :].T)


def _twists(edge: BodyEdge, frames: Frames, size: float) -> Array:
    joint = edge.connection
    if joint is None or joint.driven:
        return np.zeros((6, 0))
    point = frames.point(joint.predecessor_body, joint.predecessor_frame[:3, 3])[:, 0] / size
    turns, slides = turning_axes(joint), sliding_axes(joint)
    about = list(np.eye(3)) if turns is None else [_world(frames, *item) for item in turns]
    along = list(np.eye(3)) if joint.type.slides is Axes.ALL else [_world(frames, *item) for item in slides]
    columns = [np.concatenate([axis, cross(point, axis)]) for axis in about]
    columns += [np.concatenate([np.zeros(3), axis]) for axis in along]
    return np.array(columns).reshape(-1, 6).T


def _world(frames: Frames, body: int, direction: Array) -> Array:
    return frames.direction(body, direction)[:, 0]


def turning_axes(joint: Connection) -> list[tuple[int, Array]] | None:
    """Return the axes about which a passive joint turns, each in a body; None: all."""
    if joint.type.turns is Axes.ALL:
        return None
    first = (joint.predecessor_body, joint.axis_on(True))
    if joint.type.turns is Axes.BOTH:
        return [first, (joint.successor_body, joint.successor_frame[:3, :3] @ joint.axis2)]
    return [first] if joint.type.turns is Axes.AXIS else []


def sliding_axes(joint: Connection) -> list[tuple[int, Array]]:
    """Return the directions in which a passive joint slides, each in a body."""
    axis = joint.axis_on(True)
    if joint.type.slides is Axes.AXIS:
        return [(joint.predecessor_body, axis)]
    if joint.type.slides is Axes.ACROSS:
        _, _, basis = np.linalg.svd(axis[None])
        return [(joint.predecessor_body, basis[1]), (joint.predecessor_body, basis[2])]
    return []
