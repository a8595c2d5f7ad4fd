"""What keeps the two ends of a member from moving against each other, if the member itself is a rod with hinged ends.

Everything else is rigid and the drives are locked: what still moves is held by nothing but the member's own stiffness against
bending, as the tip of a driven crank is.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics import Frames
from kinetostatics.mechanism import Connection
from kinetostatics.rigid_pieces import Piece, PieceEdge, PieceGraph

Array = NDArray[np.float64]

_TOLERANCE = 1e-7


def free_motions(
    graph: PieceGraph,
    frames: Frames,
    without: Collection[int],
    ends: tuple[Piece, Piece],
    rod: Array,
    twists: bool,
    held: dict[int, Array],
) -> Array:
    """Return how the second end can still move against the first (6, k): rotation, and shift of the member's outer end.

    Args:
        graph: pieces and edges of the robot.
        frames: of one pose.
        without: ids of the edges that are taken out: the member's beams.
        ends: what holds the member at its inner and outer end.
        rod: (2, 3) the member's ends, in units of the robot's size.
        twists: whether the member also passes a torque on.
        held: what edges hold at these frames, by their ids, as far as it is known; the rest is added.
    """
    pieces = [piece for piece in graph.pieces() if piece is not graph.base]
    place = {piece: 6 * k for k, piece in enumerate(pieces)}
    rows: list[Array] = []

    def difference(outer: Piece, inner: Piece, some: Array) -> None:
        """Add rows (m, 6) of the twist (rotation, shift at the origin) of one piece against another."""
        row = np.zeros((len(some), 6 * len(pieces)))
        for piece, sign in ((outer, 1.0), (inner, -1.0)):
            if piece in place:
                row[:, place[piece] : place[piece] + 6] += sign * some
        rows.append(row)

    size = float(np.linalg.norm(rod[1] - rod[0]))
    scale = size if size > 0 else 1.0
    for edge in graph.edges:
        if id(edge) in without:
            continue
        if id(edge) not in held:
            held[id(edge)] = _held(_twists(edge, frames))
        difference(edge.outer.find(), edge.inner.find(), held[id(edge)])
    x = (rod[1] - rod[0]) / scale
    inner, outer = ends
    row = np.zeros((2, 6 * len(pieces)))
    for piece, point, sign in ((outer, rod[1], 1.0), (inner, rod[0], -1.0)):
        if piece in place:
            row[0, place[piece] : place[piece] + 6] += sign * np.concatenate([np.cross(point, x), x])
            row[1, place[piece] : place[piece] + 3] += sign * x
    rows.append(row if twists else row[:1])
    _, values, axes = np.linalg.svd(np.asarray(np.linalg.qr(np.concatenate(rows), mode="r")))
    moving = axes[int(np.sum(values > _TOLERANCE * values[0])) :].T

    def twist(piece: Piece) -> Array:
        at = place.get(piece)
        return np.zeros((6, moving.shape[1])) if at is None else moving[at : at + 6]

    found = twist(outer) - twist(inner)
    found[3:] += np.cross(found[:3], rod[1], axis=0)
    return found


def _held(free: Array) -> Array:
    """Return wrenches (m, 6) that span what does no work on twists (6, k)."""
    if free.shape[1] == 0:
        return np.eye(6)
    axes, values, _ = np.linalg.svd(free)
    return np.asarray(axes[:, int(np.sum(values > 6 * np.finfo(float).eps * values[0])) :].T)


def _twists(edge: PieceEdge, frames: Frames) -> Array:
    """Return the twists (6, k) that an edge leaves free: rotation, and shift at the origin."""
    joint = edge.connection
    if joint is None or joint.driven:
        return np.zeros((6, 0))
    point = frames.points(np.array([joint.predecessor_body]), joint.predecessor_frame[:3, 3:])[:, 0, 0]
    turns, slides = turning_axes(joint), sliding_axes(joint)
    about = list(np.eye(3)) if turns is None else [_world(frames, *item) for item in turns]
    along = list(np.eye(3)) if joint.kind == "floating" else [_world(frames, *item) for item in slides]
    columns = [np.concatenate([axis, np.cross(point, axis)]) for axis in about]
    columns += [np.concatenate([np.zeros(3), axis]) for axis in along]
    return np.array(columns).reshape(-1, 6).T


def _world(frames: Frames, body: int, direction: Array) -> Array:
    return frames.directions(np.array([body]), direction[:, None])[:, 0, 0]


def turning_axes(joint: Connection) -> list[tuple[int, Array]] | None:
    """Return the axes about which a passive joint turns, each in a body; None: all."""
    if joint.kind in ("spherical", "floating"):
        return None
    first = (joint.predecessor_body, joint.axis_on(True))
    if joint.kind == "universal":
        return [first, (joint.successor_body, joint.successor_frame[:3, :3] @ joint.axis2)]
    return [first] if joint.kind in ("revolute", "continuous", "cylindrical", "planar") else []


def sliding_axes(joint: Connection) -> list[tuple[int, Array]]:
    """Return the directions in which a passive joint slides, each in a body."""
    axis = joint.axis_on(True)
    if joint.kind in ("prismatic", "cylindrical"):
        return [(joint.predecessor_body, axis)]
    if joint.kind == "planar":
        _, _, basis = np.linalg.svd(axis[None])
        return [(joint.predecessor_body, basis[1]), (joint.predecessor_body, basis[2])]
    return []
