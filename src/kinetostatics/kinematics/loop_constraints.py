"""Constraint equations of loops and of joints that mimic others.

The unknowns are the freedoms of Pinocchio's spanning tree, except that three revolutes of a spherical joint are one joint here.
Every equation corresponds to a constraint wrench of a joint; the equation's gradient consists of the powers of this wrench on the
unit twists of the tree. Overconstrained loops are closed in the least-squares sense.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.kinematics.coordinates import Couplings
from kinetostatics.math import rotations
from kinetostatics.math.arrays import Array, Index, empty_for, zeros_for
from kinetostatics.math.linalg import across, cross, dot
from kinetostatics.math.screws import wrench_of_force
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.tree import Frames, Tree, TreeJoint, joined_frames

_FULL = np.eye(3)

#: An equation: number of its loop, the loop, and the vectors in its bodies that define the equation.
_Row: TypeAlias = tuple[int, Connection, tuple[Array, ...]]


@dataclass(frozen=True)
class _Table:
    """n equations of one kind: for each, the two bodies that the loop connects, and k vectors (k, 3, n) fixed in the bodies."""

    count: int
    predecessor: Index
    successor: Index
    vectors: Array

    @classmethod
    def of(cls, rows: Sequence[_Row]) -> _Table:
        before, behind = ([getattr(loop, f"{side}_body") for _, loop, _ in rows] for side in ("predecessor", "successor"))
        vectors = np.array([vectors for *_, vectors in rows]).transpose(1, 2, 0) if rows else np.zeros((6, 3, 0))
        return cls(len(rows), np.array(before, dtype=np.intp), np.array(behind, dtype=np.intp), vectors)


@dataclass(frozen=True)
class LoopAxes:
    """Directions that define the coordinate of a one-freedom loop.

    Attributes:
        axis, side, third: (3,) in the predecessor's body: the loop's axis, and two directions across it.
        turned_side: (3,) in the successor's body: the direction that coincides with ``side`` at coordinate zero.
        middle: middle of the limits [m, rad]; None without limits.
    """

    axis: Array
    side: Array
    third: Array
    turned_side: Array
    middle: float | None

    @classmethod
    def of(cls, loop: Connection) -> LoopAxes:
        side, third = across(loop.axis)
        here, there = loop.predecessor_frame[:3, :3], loop.successor_frame[:3, :3]
        middle = (loop.lower + loop.upper) / 2
        return cls(loop.axis_on(True), here @ side, here @ third, there @ side, middle if np.isfinite(middle) else None)


class Closures:
    """The equations of some loops between bodies.

    Attributes:
        closures: number of equations.
        loop_of: (closures,) index of the loop to which an equation belongs.
        is_length: (closures,) True for equations in metres, False for equations in radians.
    """

    def __init__(self, loops: Sequence[Connection]) -> None:
        self.loops = loops
        distance: list[_Row] = []
        alignment: list[_Row] = []
        right_angle: list[_Row] = []
        turn: list[_Row] = []
        for number, loop in enumerate(self.loops):
            axis, R, other_R = loop.axis, loop.predecessor_frame[:3, :3], loop.successor_frame[:3, :3]
            points = loop.predecessor_frame[:3, 3], loop.successor_frame[:3, 3]
            blocked = {Axes.NONE: list(_FULL), Axes.AXIS: list(across(axis)), Axes.ACROSS: [axis], Axes.ALL: []}[loop.type.slides]
            distance += [(number, loop, (R @ direction, *points)) for direction in blocked]
            if loop.type.turns is Axes.AXIS:
                alignment += [(number, loop, (R @ direction, R @ axis, other_R @ axis)) for direction in across(axis)]
            elif loop.type.turns is Axes.BOTH:
                angle = np.full(3, np.arccos(float(axis @ loop.axis2)))
                right_angle.append((number, loop, (R @ axis, other_R @ loop.axis2, angle)))
            elif loop.type.turns is Axes.NONE:
                turn.append((number, loop, (*R.T, *other_R.T)))
        rows = [distance, alignment, right_angle, turn, turn, turn]
        self.loop_of = np.array([number for part in rows for number, *_ in part], dtype=np.intp)
        self.closures = len(self.loop_of)
        self.is_length = np.arange(self.closures) < len(distance)
        self._tables = [_Table.of(part) for part in rows]
        self._distance, self._alignment, self._right_angle, self._turn = self._tables[:4]

    def evaluate(self, frames: Frames) -> tuple[Array, Array]:
        """Return the residuals (closures, N) [m, rad] and the constraint wrenches (6, closures, N) about the world's origin.

        With points p, q, directions n and axes a, b of both sides: n · (q − p); n · (rotation vector from a to b); the angle of a
        and b minus its value; log(R_q R_pᵀ). Each wrench does the work that is the change of its residual.
        """
        N = frames.position.shape[2]
        residual = empty_for((self.closures, N), frames.position)
        wrench = zeros_for((6, self.closures, N), frames.position)
        at = 0
        n, p, s = self._distance.count, self._distance.predecessor, self._distance.successor
        if n:
            local, here, there = self._distance.vectors
            direction, point = frames.directions(p, local), frames.points(s, there)
            residual[:n] = dot(direction, point - frames.points(p, here))
            wrench[:, :n] = wrench_of_force(direction, point)
            at = n
        n, p, s = self._alignment.count, self._alignment.predecessor, self._alignment.successor
        if n:
            local, here, there = self._alignment.vectors
            direction = frames.directions(p, local)
            error = rotations.rotation_between(frames.directions(p, here), frames.directions(s, there))
            residual[at : at + n] = dot(direction, error)
            wrench[3:, at : at + n] = direction
            at += n
        n, p, s = self._right_angle.count, self._right_angle.predecessor, self._right_angle.successor
        if n:
            here, there, angle = self._right_angle.vectors
            a, b = frames.directions(p, here), frames.directions(s, there)
            normal = cross(a, b)
            sine = np.sqrt(dot(normal, normal))
            residual[at : at + n] = np.arctan2(sine, dot(a, b)) - angle[0][:, None]
            wrench[3:, at : at + n] = normal / np.maximum(sine, 1e-12)
            at += n
        n, p, s = self._turn.count, self._turn.predecessor, self._turn.successor
        if n:
            A = frames.orientations(p, self._turn.vectors[:3].swapaxes(0, 1))
            B = frames.orientations(s, self._turn.vectors[3:].swapaxes(0, 1))
            error = rotations.logarithm(np.einsum("ijmn,kjmn->ikmn", B, A).reshape(3, 3, -1)).reshape(3, n, N)
            for k in range(3):
                residual[at : at + n], wrench[3 + k, at : at + n] = error[k], 1.0
                at += n
        return residual, wrench

    def gaps(self, residual: Array) -> dict[str, tuple[Array, Array]]:
        """Return the gap of each loop, ``{name: (metres (N,), radians (N,))}``."""
        result = {}
        for number, loop in enumerate(self.loops):
            of_loop = self.loop_of == number
            parts = [residual[of_loop & self.is_length], residual[of_loop & ~self.is_length]]
            result[loop.name] = (np.sqrt(dot(parts[0], parts[0])), np.sqrt(dot(parts[1], parts[1])))
        return result


class Placed(NamedTuple):
    """Pinocchio's coordinates (nq, N) of poses, frames of all bodies in world axes, residuals (closures, N) of loops [m, rad]."""

    q: Array
    frames: Frames
    residual: Array


class LoopEquations(Closures):
    """The equations of all loops of a mechanism. Coordinates ``x`` (nq', N) are those of the solver's tree.

    Attributes:
        tree: the solver's spanning tree; three revolutes of a spherical joint are one joint.
        couplings: the mimic joints, with one equation each.
        loop_axes: directions of each one-freedom loop, by the index of the loop.
        count: number of all equations, including the couplings.
        signs: (closures, nv) sign of each freedom in each equation: 1 if it moves only the successor, −1 if it moves only the
            predecessor, else 0.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._make_tree()
        super().__init__([loop for loop in mechanism.connections.values() if loop.is_loop])
        self.couplings = Couplings(mechanism, self.tree)
        self.neutral = mechanism.tree.neutral[:, None]
        self.loop_axes = {k: LoopAxes.of(loop) for k, loop in enumerate(self.loops) if loop.type.is_single}
        self.count = self.closures + self.couplings.count
        moves = self.tree.moves.astype(float)
        self.signs = np.concatenate(
            [np.zeros((0, self.tree.nv))] + [moves[table.successor] - moves[table.predecessor] for table in self._tables]
        )

    def _make_tree(self) -> None:
        """Build the solver's tree and the map between its coordinates and Pinocchio's."""
        full = self.mechanism.tree
        runs = {run.bodies[2]: run for run in self.mechanism.spherical_runs}
        inside = {body for run in runs.values() for body in run.bodies}
        joints: list[TreeJoint] = []
        same_here: list[int] = []
        same_there: list[int] = []
        self.runs = []
        nq = nv = 0
        for joint in full.joints:
            if joint.body in inside and joint.body not in runs:
                continue
            if joint.body in runs:
                run = runs[joint.body]
                placement = np.eye(4)
                placement[:3, :3], placement[:3, 3] = run.orientation, run.centre
                tree_joint = TreeJoint(JOINT_TYPES["spherical"], run.parent, joint.body, placement, (0.0, 0.0, 1.0), nq, nv)
                revolutes = [next(j for j in full.joints if j.body == body) for body in run.bodies]
                self.runs.append((run, tree_joint, revolutes))
            else:
                tree_joint = TreeJoint(joint.type, joint.parent, joint.body, joint.placement, joint.axis, nq, nv)
                same_here.extend(range(nq, nq + joint.nq))
                same_there.extend(range(joint.first_q, joint.first_q + joint.nq))
            joints.append(tree_joint)
            nq, nv = nq + tree_joint.nq, nv + tree_joint.nv
        self._same_here, self._same_there = np.array(same_here, dtype=np.intp), np.array(same_there, dtype=np.intp)
        self.tree = Tree(joints, full.bodies, nq, nv)
        self.joint_of_body = {joint.body: joint for joint in joints}

    # ---- coordinates ------------------------------------------------------------------------------------------------

    def from_model(self, q: Array) -> Array:
        """Return ``x`` (nq', N) for Pinocchio's ``q`` (nq, N)."""
        x = np.empty((self.tree.nq, q.shape[1]))
        x[self._same_here] = q[self._same_there]
        for run, spherical, revolutes in self.runs:
            turned = rotations.identity((q.shape[1],))
            for axis, joint in zip(run.axes.T, revolutes, strict=True):
                turned = np.einsum("ijn,jkn->ikn", turned, rotations.exponential(axis[:, None] * joint.coordinate(q)))
            R = np.einsum("ji,jkn,kl->iln", run.orientation, turned, run.orientation)
            x[spherical.first_q : spherical.first_q + 4] = rotations.quaternion_of_matrix(R)
        return x

    def to_model(self, x: Array) -> Array:
        """Return Pinocchio's coordinates (nq, N) for ``x``; of two solutions for three revolutes, the one nearer to zero."""
        q = empty_for((self.mechanism.tree.nq, x.shape[1]), x)
        q[self._same_there] = x[self._same_here]
        for run, spherical, revolutes in self.runs:
            quaternion = x[spherical.first_q : spherical.first_q + 4]
            R = np.einsum("ij,jkn,lk->iln", run.orientation, rotations.matrix_of_quaternion(quaternion), run.orientation)
            angles = rotations.three_angles(run.axes, R, np.stack([joint.coordinate(self.neutral) for joint in revolutes]))
            for angle, joint in zip(angles, revolutes, strict=True):
                joint.write(angle, q)
        return q

    def forward(self, x: Array) -> Frames:
        return world_frames(self.mechanism, self.tree.forward(x))

    def placed(self, q: Array) -> Placed:
        """Return frames and residuals at Pinocchio's coordinates ``q`` (nq, N)."""
        frames = world_frames(self.mechanism, self.mechanism.forward(q))
        return Placed(q, frames, self.evaluate(frames)[0])

    def place(self, x: Array) -> Placed:
        return self.placed(self.to_model(x))

    # ---- residuals --------------------------------------------------------------------------------------------------

    def loop_gaps(self, residual: Array, x: Array) -> dict[str, tuple[Array, Array]]:
        """Return the gap of each loop and the error of each mimic joint, ``{name: (metres (N,), radians (N,))}``."""
        result = self.gaps(residual)
        none = np.zeros(x.shape[1])
        for name, slides, error in zip(
            self.couplings.names, self.couplings.is_length, np.abs(self.couplings.residual(x, turns=500)), strict=True
        ):
            result[name] = (error, none) if slides else (none, error)
        return result


def world_frames(mechanism: Mechanism, frames: Frames) -> Frames:
    """Return frames relative to the base link; equal to ``frames`` if the base link is fixed to the root of the tree."""
    if mechanism.base_frame is None:
        return frames
    body, placement = mechanism.base_frame
    back = np.einsum("ijn,jk->kin", frames.rotation[:, :, body], placement[:3, :3])
    shifted = frames.position - frames.point(body, placement[:3, 3])[:, None]
    return Frames(np.einsum("ijn,jkbn->ikbn", back, frames.rotation), np.einsum("ijn,jbn->ibn", back, shifted))


def joined(parts: Sequence[Placed]) -> Placed:
    q, frames, residual = zip(*parts, strict=True)
    return Placed(np.concatenate(q, axis=-1), joined_frames(frames), np.concatenate(residual, axis=-1))


def signed_powers(signs: Array, wrench: Array, twists: Array) -> Array:
    """Return the powers (m, nv, N) of wrenches (6, m, N) on twists (6, nv, N), times signs (m, nv)."""
    return signs[:, :, None] * np.einsum("krn,kvn->rvn", wrench, twists)
