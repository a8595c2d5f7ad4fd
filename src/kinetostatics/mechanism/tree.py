"""Forward kinematics of a spanning tree for a whole batch of poses, batch axis last.

Pinocchio for Python computes one pose per call. :class:`Tree` computes thousands of poses at once, with the joint placements and
the coordinates ``q`` of the Pinocchio model. Bodies are numbered as joints in Pinocchio; body 0 is the root link.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.description.joint_types import Axes, JointType
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math import rotations
from kinetostatics.math.arrays import Array, Index, Mask, is_filled, zeros_for
from kinetostatics.math.linalg import apply, matmul
from kinetostatics.math.screws import unit_twist


@dataclass(frozen=True)
class TreeJoint:
    """One moving joint between the bodies ``parent`` and ``body``.

    ``placement`` (4, 4) is the joint's frame in the parent body, ``axis`` (3,) the axis in this frame. ``first_q`` and
    ``first_v`` are the indices of its first coordinate in q and of its first velocity in v. Coordinates are Pinocchio's:
    (cos, sin) of a continuous joint, (x, y, cos, sin) of a planar joint with the axis z, a quaternion (x, y, z, w) of a spherical
    joint, (x, y, z, quaternion) of a floating joint.
    """

    type: JointType
    parent: int
    body: int
    placement: Array
    axis: tuple[float, float, float]
    first_q: int
    first_v: int

    @property
    def nq(self) -> int:
        """Number of coordinates."""
        return self.type.coordinates

    @property
    def nv(self) -> int:
        """Number of freedoms."""
        return self.type.freedoms

    def coordinate(self, q: Array) -> Array:
        """Coordinate (N,) [m, rad] of a one-freedom joint at ``q`` (nq, N)."""
        if self.type.endless:
            angle: Array = np.arctan2(q[self.first_q + 1], q[self.first_q])
            return angle
        return q[self.first_q]

    def write(self, value: Array | float, q: Array) -> None:
        """Write the coordinate (N,) [m, rad] of a one-freedom joint into ``q`` (nq, N), in place."""
        if self.type.endless:
            q[self.first_q], q[self.first_q + 1] = np.cos(value), np.sin(value)
        else:
            q[self.first_q] = value


@dataclass(frozen=True, repr=False)
class Frames(ShortRepr):
    """Orientations ``rotation`` (3, 3, B, N) and positions ``position`` (3, B, N) [m] of B bodies at N poses."""

    rotation: Array
    position: Array

    def points(self, bodies: Index | slice, local: Array) -> Array:
        """World positions (3, M, N) of points ``local`` (3, M) fixed in ``bodies`` (M,)."""
        return self.position[:, bodies] + self.directions(bodies, local)

    def directions(self, bodies: Index | slice, local: Array) -> Array:
        """World components (3, M, N) of vectors ``local`` (3, M) fixed in ``bodies`` (M,)."""
        filled = is_filled(local) if local.dtype == object else local  # recorded values may be 0 at the example pose only
        used = [j for j, row in enumerate(filled.tolist()) if any(row)] or [0]  # faster than NumPy for few numbers
        result = self.rotation[:, used[0], bodies] * local[used[0]][:, None]
        for j in used[1:]:
            result += self.rotation[:, j, bodies] * local[j][:, None]
        return result

    def point(self, body: int, local: Array) -> Array:
        """World position (3, N) of a point ``local`` (3,) fixed in a body."""
        return self.points(slice(body, body + 1), local[:, None])[:, 0]

    def direction(self, body: int, local: Array) -> Array:
        """World components (3, N) of a vector ``local`` (3,) fixed in a body."""
        return self.directions(slice(body, body + 1), local[:, None])[:, 0]

    def orientations(self, bodies: Index, local: Array) -> Array:
        """World orientations (3, 3, M, N) of frames with orientations ``local`` (3, 3, M) in ``bodies`` (M,)."""
        return np.einsum("ijmn,jkm->ikmn", self.rotation[:, :, bodies], local)

    def matrices(self, body: int, placement: Array) -> Array:
        """Homogeneous matrices (4, 4, N) of a frame fixed in a body at ``placement`` (4, 4)."""
        R, p = self.rotation[:, :, body], self.position[:, body]
        result = zeros_for((4, 4, R.shape[2]), R)
        result[:3, :3] = np.einsum("ijn,jk->ikn", R, placement[:3, :3])
        result[:3, 3] = p + np.einsum("ijn,j->in", R, placement[:3, 3])
        result[3, 3] = 1
        return result

    def take(self, poses: Index | slice) -> Frames:
        return Frames(self.rotation[..., poses], self.position[..., poses])

    def are_finite(self) -> Mask:
        """(N,) True where the frames of all bodies are finite."""
        return np.all(np.isfinite(self.position), axis=(0, 1)) & np.all(np.isfinite(self.rotation), axis=(0, 1, 2))

    def put(self, poses: Index, others: Frames) -> None:
        """Replace the frames at ``poses`` by ``others``, in place."""
        self.rotation[..., poses], self.position[..., poses] = others.rotation, others.position


def joined_frames(parts: Sequence[Frames]) -> Frames:
    """Concatenate several batches of poses."""
    rotation = np.concatenate([part.rotation for part in parts], axis=-1)
    return Frames(rotation, np.concatenate([part.position for part in parts], axis=-1))


class _Group:
    """Joints of one type at one depth of the tree, computed together."""

    def __init__(self, joints: Sequence[TreeJoint]) -> None:
        self.type = joints[0].type
        self.shifts = self.type.slides.count
        self.parents = np.array([joint.parent for joint in joints])
        self.bodies = np.array([joint.body for joint in joints])
        self.on_root = not np.any(self.parents)
        placements = np.stack([joint.placement for joint in joints], axis=-1)
        self.R0, self.p0 = placements[:3, :3, :, None], placements[:3, 3, :, None]
        self.q = np.stack([np.arange(j.first_q, j.first_q + j.nq) for j in joints], axis=-1)
        self.v = np.stack([np.arange(j.first_v, j.first_v + j.nv) for j in joints], axis=-1)
        axis = np.array([joint.axis for joint in joints]).T
        along = np.einsum("ijm,jm->im", self.R0[..., 0], axis)[None, :, :, None]
        self.slides = tuple(along if self.type.slides is Axes.AXIS else self.R0.swapaxes(0, 1)[: self.shifts])
        # R0 exp(q K) = R0 a aᵀ + sin q R0 K − cos q R0 K², with K the cross product with the unit axis a.
        K = rotations.skew(axis)[..., None]
        self.R_sin = matmul(self.R0, K)
        self.R_cos = -matmul(self.R_sin, K)
        self.R_fixed = np.einsum("im,jm->ijm", np.einsum("ijm,jm->im", self.R0[..., 0], axis), axis)[..., None]

    def local(self, q: Array) -> tuple[Array, Array]:
        """Return rotations (3, 3, k, N) and positions (3, k, N) of the k bodies relative to their parents."""
        c = q[self.q]
        R, p, first, turns = self.R0, self.p0, self.shifts, self.type.turns
        if turns is Axes.ALL:
            R = matmul(R, rotations.matrix_of_quaternion(c[first:]))
        elif turns is Axes.AXIS:
            R = self._turned(c[first + 1], c[first]) if self.type.endless else self._turned(np.sin(c[first]), np.cos(c[first]))
        for k, direction in enumerate(self.slides):
            p = p + direction * c[k]
        return R, p

    def _turned(self, sine: Array, cosine: Array) -> Array:
        result = self.R_sin * sine
        result += self.R_cos * cosine
        result += self.R_fixed
        return result

    def integrate(self, q: Array, v: Array) -> None:
        """Move the coordinates ``q`` (nq, N) in place by the displacement ``v`` (nv, N)."""
        c, d, first = q[self.q], v[self.v], self.shifts
        turn, by = c[first:], d[first:]
        if first:
            q[self.q[:first]] = c[:first] + self._shift(turn, d[:first])
        if self.type.turns is Axes.ALL:
            q[self.q[first:]] = _unit(rotations.quaternion_product(turn, rotations.quaternion_exponential(by)))
        elif self.type.turns is Axes.AXIS:
            q[self.q[first:]] = _turn(turn, by[0]) if self.type.endless else turn + by

    def rates(self, q: Array, v: Array, rates: Array) -> None:
        """Write the time derivatives of ``q`` (nq, N) at velocities ``v`` (nv, N) into ``rates`` (nq, N)."""
        c, d, first = q[self.q], v[self.v], self.shifts
        turn, by = c[first:], d[first:]
        if first:
            rates[self.q[:first]] = self._shift(turn, d[:first])
        if self.type.turns is Axes.ALL:
            rates[self.q[first:]] = rotations.quaternion_product(turn, np.concatenate([by / 2, 0 * by[:1]]))
        elif self.type.turns is Axes.AXIS:
            rates[self.q[first:]] = np.stack([-turn[1], turn[0]]) * by if self.type.endless else by

    def _shift(self, turn: Array, shift: Array) -> Array:
        """Return a displacement in the axes of the joint's placement; ``shift`` is in the axes of the rotated body."""
        if self.type.slides is Axes.ACROSS:
            shift = np.stack([turn[0] * shift[0] - turn[1] * shift[1], turn[1] * shift[0] + turn[0] * shift[1]])
        elif self.type.slides is Axes.ALL:
            shift = apply(rotations.matrix_of_quaternion(turn), shift)
        return shift


def _unit(q: Array) -> Array:
    unit: Array = q / np.sqrt(np.sum(q * q, axis=0))
    return unit


def _turn(c: Array, angle: Array) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return _unit(np.stack([c[0] * cosine - c[1] * sine, c[1] * cosine + c[0] * sine]))


class Tree:
    """A kinematic tree.

    Attributes:
        joints: the moving joints.
        bodies: number of bodies, the root included.
        nq, nv: numbers of coordinates and of freedoms.
        column_body: (nv,) body in which the axis of each freedom is fixed.
        column_axis: (3, nv) the axis of each freedom in this body.
        column_rotates: (nv,) True for a rotation (about an axis through the body's origin), False for a translation.
        moves: (B, nv) True where a freedom moves a body.
    """

    def __init__(self, joints: Sequence[TreeJoint], bodies: int, nq: int, nv: int) -> None:
        self.joints, self.bodies, self.nq, self.nv = tuple(joints), bodies, nq, nv
        depth = np.zeros(bodies, dtype=int)
        levels: dict[tuple[int, str], list[TreeJoint]] = {}
        self.moves = np.zeros((bodies, nv), dtype=bool)
        self.column_body = np.zeros(nv, dtype=np.intp)
        self.column_axis = np.zeros((3, nv))
        self.column_rotates = np.zeros(nv, dtype=bool)
        for joint in joints:
            depth[joint.body] = depth[joint.parent] + 1
            levels.setdefault((int(depth[joint.body]), joint.type.name), []).append(joint)
            columns = slice(joint.first_v, joint.first_v + joint.nv)
            self.moves[joint.body] = self.moves[joint.parent]
            self.moves[joint.body, columns] = True
            self.column_body[columns] = joint.body
            slides, turns = joint.type.axes(np.array(joint.axis))
            self.column_axis[:, columns] = np.hstack([slides, turns])
            self.column_rotates[columns] = np.arange(joint.nv) >= slides.shape[1]
        self._groups = [_Group(levels[key]) for key in sorted(levels)]

    @cached_property
    def neutral(self) -> Array:
        """The coordinates (nq,) at which every joint is at its zero."""
        q = np.zeros(self.nq)
        for joint in self.joints:
            if joint.type.endless:
                q[joint.first_q + joint.type.slides.count] = 1
            elif joint.type.turns is Axes.ALL:
                q[joint.first_q + joint.nq - 1] = 1
        return q

    def forward(self, q: Array) -> Frames:
        """Return the frames of all bodies at coordinates ``q`` (nq, N)."""
        N = q.shape[1]
        R, p = zeros_for((3, 3, self.bodies, N), q), zeros_for((3, self.bodies, N), q)
        R[:, :, 0], p[:, 0] = np.eye(3)[:, :, None], 0.0
        for group in self._groups:
            R_local, p_local = group.local(q)
            if group.on_root:
                R[:, :, group.bodies], p[:, group.bodies] = R_local, p_local
            else:
                parent = R[:, :, group.parents]
                if R_local.shape[-1] == 1:
                    R_local = np.broadcast_to(R_local, (*R_local.shape[:-1], N))
                R[:, :, group.bodies] = matmul(parent, R_local)
                p[:, group.bodies] = p[:, group.parents] + apply(parent, np.broadcast_to(p_local, parent.shape[1:]))
        return Frames(R, p)

    def integrate(self, q: Array, v: Array) -> Array:
        """Return the coordinates (nq, N) reached from ``q`` by the displacement ``v`` (nv, N) [m, rad]."""
        moved = np.array(q, subok=True)
        for group in self._groups:
            group.integrate(moved, v)
        return moved

    def rates(self, q: Array, v: Array) -> Array:
        """Return the time derivatives of ``q`` (nq, N) at velocities ``v`` (nv, N) [m/s, rad/s]."""
        rates = zeros_for(q.shape, q, v)
        for group in self._groups:
            group.rates(q, v, rates)
        return rates

    def twists(self, frames: Frames) -> Array:
        """Unit twists (6, nv, N) of all freedoms, about the world's origin."""
        axis = frames.directions(self.column_body, self.column_axis)
        centre = frames.position[:, self.column_body]
        return unit_twist(axis, centre, self.column_rotates[:, None])


class FixedVectors:
    """Points or directions (3,), or axes (3, 3), fixed in bodies, for the k members of each of g limbs."""

    def __init__(self, rows: Sequence[Sequence[tuple[int, Array]]], shape: tuple[int, ...] = (3,)) -> None:
        g, k = len(rows), len(rows[0])
        self._shape = (*shape, k, g)
        self._bodies = np.array([body for row in rows for body, _ in row], dtype=np.intp).reshape(g, k).T.ravel()
        vectors = np.array([vector for row in rows for _, vector in row], dtype=float).reshape(g, k, *shape)
        self._vectors = np.moveaxis(vectors, (0, 1), (-1, -2)).reshape(*shape, k * g)

    def points(self, frames: Frames) -> Array:
        """Return points in the world (3, k, g, N) [m]."""
        return self._shaped(frames.points, frames)

    def at(self, frames: Frames) -> Array:
        """Return directions (3, k, g, N) or axes (3, 3, k, g, N) in the world."""
        return self._shaped(frames.directions if self._vectors.ndim == 2 else frames.orientations, frames)

    def _shaped(self, evaluate: Callable[[Index, Array], Array], frames: Frames) -> Array:
        N = frames.position.shape[2]
        if not self._bodies.size:  # avoid indexing
            return zeros_for((*self._shape, N), frames.position)
        return evaluate(self._bodies, self._vectors).reshape(*self._shape, N)
