"""Closing the loops: equations of all loop joints, and Newton's method on thousands of poses at once.

The unknowns are the freedoms of a spanning tree that is Pinocchio's but for spherical joints written as three revolutes, which
are one joint here. Every equation is a constraint wrench of a joint or of the requested coordinates, so that its gradient is
the product of that wrench with the tree's twists. Overconstrained loops are closed in the least-squares sense.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinetostatics import rotations
from kinetostatics.kinematics import Frames, Tree, TreeJoint
from kinetostatics.linalg import Cholesky, cross, dot
from kinetostatics.mechanism import Connection, Mechanism
from kinetostatics.orientation import Orientation

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_FULL = np.eye(3)


def across(axis: Array) -> tuple[Array, Array]:
    """Return two unit vectors that form a right-handed frame with the unit vector ``axis`` (3,)."""
    helper = _FULL[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


@dataclass
class _Rows:
    """A table of equations under construction; each entry belongs to the loop of the same position."""

    loop: list[int] = field(default_factory=list)
    predecessor: list[int] = field(default_factory=list)
    successor: list[int] = field(default_factory=list)
    vectors: list[list[Array]] = field(default_factory=list)

    def add(self, loop: int, connection: Connection, *vectors: Array) -> None:
        self.loop.append(loop)
        self.predecessor.append(connection.predecessor_body)
        self.successor.append(connection.successor_body)
        self.vectors.append(list(vectors))

    def __len__(self) -> int:
        return len(self.loop)

    def stacked(self, k: int) -> Array:
        """Return the k-th vectors of all entries as (3, n)."""
        return np.array([entry[k] for entry in self.vectors]).T.reshape(3, -1)

    def bodies(self) -> tuple[Index, Index]:
        return np.array(self.predecessor, dtype=np.intp), np.array(self.successor, dtype=np.intp)


class LoopEquations:
    """The equations of all loops of a mechanism.

    Attributes:
        tree: the spanning tree with spherical joints in one piece.
        loops: the loop connections.
        count: number of equations.
        loop_of: (count,) the loop to which an equation belongs.
        is_length: (count,) whether an equation is in metres (else radians).
        signs: (count, nv) how each freedom enters each equation: 1 beyond the loop's successor, −1 its predecessor.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._make_tree()
        self.loops = [item for item in mechanism.connections.values() if item.is_loop]
        distance, alignment, right_angle, turn = _Rows(), _Rows(), _Rows(), _Rows()
        for number, loop in enumerate(self.loops):
            frame, other = loop.predecessor_frame, loop.successor_frame
            axis = loop.axis
            for direction in _blocked_translations(loop.kind, axis):
                distance.add(number, loop, frame[:3, :3] @ direction, frame[:3, 3], other[:3, 3])
            if loop.kind in ("revolute", "continuous", "cylindrical", "planar"):
                for direction in across(axis):
                    alignment.add(
                        number, loop, frame[:3, :3] @ direction, frame[:3, :3] @ axis, other[:3, :3] @ axis
                    )
            elif loop.kind == "universal":
                right_angle.add(
                    number, loop, frame[:3, :3] @ axis, other[:3, :3] @ loop.axis2,
                    np.full(3, float(axis @ loop.axis2)),
                )  # fmt: skip
            elif loop.kind in ("fixed", "prismatic"):
                turn.add(number, loop, *frame[:3, :3].T, *other[:3, :3].T)
        self._distance, self._alignment, self._right_angle, self._turn = distance, alignment, right_angle, turn
        tables = [distance, alignment, right_angle, turn, turn, turn]
        self.loop_of = np.array([loop for table in tables for loop in table.loop], dtype=np.intp)
        self.count = len(self.loop_of)
        self.is_length = np.arange(self.count) < len(distance)
        moves = self.tree.moves.astype(float)
        self.signs = np.concatenate(
            [np.zeros((0, self.tree.nv))] + [moves[table.bodies()[1]] - moves[table.bodies()[0]] for table in tables]
        )
        for table in (distance, alignment, right_angle):
            if len(table):
                table.vectors = [[table.stacked(k) for k in range(3)]]  # (3, n) each, stacked once

    def _make_tree(self) -> None:
        """Build the solver's tree and remember how its coordinates correspond to Pinocchio's."""
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
                mine = TreeJoint("spherical", run.parent, joint.body, placement, (0.0, 0.0, 1.0), nq, nv)
                theirs = [next(j for j in full.joints if j.body == body) for body in run.bodies]
                self.runs.append((run, mine, theirs))
            else:
                mine = TreeJoint(joint.kind, joint.parent, joint.body, joint.placement, joint.axis, nq, nv)
                same_here.extend(range(nq, nq + joint.nq))
                same_there.extend(range(joint.first_q, joint.first_q + joint.nq))
            joints.append(mine)
            nq, nv = nq + mine.nq, nv + mine.nv
        self._same_here, self._same_there = np.array(same_here, dtype=np.intp), np.array(same_there, dtype=np.intp)
        self.tree = Tree(joints, full.bodies, nq, nv)
        self.joint_of_body = {joint.body: joint for joint in joints}

    # ---- coordinates ------------------------------------------------------------------------------------------------

    def from_model(self, q: Array) -> Array:
        """Return the solver's coordinates (nq', N) of Pinocchio's ``q`` (nq, N)."""
        x = np.empty((self.tree.nq, q.shape[1]))
        x[self._same_here] = q[self._same_there]
        for run, mine, theirs in self.runs:
            turned = rotations.identity((q.shape[1],))
            for axis, joint in zip(run.axes.T, theirs, strict=True):
                turned = np.einsum("ijn,jkn->ikn", turned, rotations.exponential(axis[:, None] * _angle(joint, q)))
            R = np.einsum("ji,jkn,kl->iln", run.orientation, turned, run.orientation)
            x[mine.first_q : mine.first_q + 4] = rotations.quaternion_of_matrix(R)
        return x

    def to_model(self, x: Array, near: Array) -> Array:
        """Return Pinocchio's coordinates (nq, N) of ``x``; of a spherical run's two solutions the one near ``near``."""
        q = np.empty((self.mechanism.tree.nq, x.shape[1]))
        q[self._same_there] = x[self._same_here]
        for run, mine, theirs in self.runs:
            quaternion = x[mine.first_q : mine.first_q + 4]
            R = np.einsum("ij,jkn,lk->iln", run.orientation, rotations.matrix_of_quaternion(quaternion), run.orientation)
            angles = _three_angles(run.axes, R, np.stack([_angle(joint, near) for joint in theirs]))
            for angle, joint in zip(angles, theirs, strict=True):
                if joint.kind == "continuous":
                    q[joint.first_q], q[joint.first_q + 1] = np.cos(angle), np.sin(angle)
                else:
                    q[joint.first_q] = angle
        return q

    def forward(self, x: Array) -> Frames:
        """Return the frames of all bodies in world axes."""
        frames = self.tree.forward(x)
        return world_frames(self.mechanism, frames)

    # ---- residuals --------------------------------------------------------------------------------------------------

    def evaluate(self, frames: Frames) -> tuple[Array, Array]:
        """Return residuals (count, N) [m, rad] and the wrenches (6, count, N), about the world's origin, that they meet."""
        N = frames.position.shape[2]
        residual, wrench = np.empty((self.count, N)), np.zeros((6, self.count, N))
        at = 0
        n = len(self._distance)
        if n:
            p, s = self._distance.bodies()
            local, here, there = self._distance.vectors[0]
            direction, point = frames.directions(p, local), frames.points(s, there)
            residual[:n] = dot(direction, point - frames.points(p, here))
            wrench[:3, :n], wrench[3:, :n] = direction, cross(point, direction)
            at = n
        n = len(self._alignment)
        if n:
            p, s = self._alignment.bodies()
            local, mine, theirs = self._alignment.vectors[0]
            direction = frames.directions(p, local)
            error = rotations.rotation_between(frames.directions(p, mine), frames.directions(s, theirs))
            residual[at : at + n] = dot(direction, error)
            wrench[3:, at : at + n] = direction
            at += n
        n = len(self._right_angle)
        if n:
            p, s = self._right_angle.bodies()
            mine, theirs, cosine = self._right_angle.vectors[0]
            a, b = frames.directions(p, mine), frames.directions(s, theirs)
            sine = np.sqrt(1 - cosine[0] ** 2)[:, None]
            residual[at : at + n] = (cosine[0][:, None] - dot(a, b)) / sine
            wrench[3:, at : at + n] = cross(a, b) / sine
            at += n
        n = len(self._turn)
        if n:
            p, s = self._turn.bodies()
            vectors = np.array(self._turn.vectors)  # (n, 6, 3)
            A = frames.orientations(p, np.moveaxis(vectors[:, :3], 0, -1).swapaxes(0, 1))
            B = frames.orientations(s, np.moveaxis(vectors[:, 3:], 0, -1).swapaxes(0, 1))
            error = rotations.logarithm(np.einsum("ijmn,kjmn->ikmn", B, A).reshape(3, 3, -1)).reshape(3, n, N)
            for k in range(3):
                residual[at : at + n], wrench[3 + k, at : at + n] = error[k], 1.0
                at += n
        return residual, wrench

    def openings(self, residual: Array) -> dict[str, tuple[Array, Array]]:
        """Return how far each loop is open, ``{name: (metres (N,), radians (N,))}``."""
        result = {}
        for number, loop in enumerate(self.loops):
            mine = self.loop_of == number
            parts = [residual[mine & self.is_length], residual[mine & ~self.is_length]]
            result[loop.name] = (np.sqrt(dot(parts[0], parts[0])), np.sqrt(dot(parts[1], parts[1])))
        return result

    def jacobian(self, frames: Frames, wrench: Array) -> Array:
        """Return the gradients (count, nv, N) of the residuals with respect to the tree's freedoms."""
        return products(self.signs, wrench, self.tree.twists(frames))


def _blocked_translations(kind: str, axis: Array) -> list[Array]:
    if kind == "planar":
        return [axis]
    if kind in ("prismatic", "cylindrical"):
        return list(across(axis))
    return list(_FULL)


def world_frames(mechanism: Mechanism, frames: Frames) -> Frames:
    """Return frames as seen from the base link, when it moves relative to the root of the tree."""
    if mechanism.base_frame is None:
        return frames
    body, placement = mechanism.base_frame
    seen = frames.relative_to(body)
    back = placement[:3, :3].T
    shifted = seen.position - placement[:3, 3][:, None, None]
    return Frames(np.einsum("ij,jkbn->ikbn", back, seen.rotation), np.einsum("ij,jbn->ibn", back, shifted))


def products(signs: Array, wrench: Array, twists: Array) -> Array:
    """Return the powers (m, nv, N) of wrenches (6, m, N) on twists (6, nv, N), each with its sign (m, nv)."""
    return signs[:, :, None] * np.einsum("krn,kvn->rvn", wrench, twists)


def _angle(joint: TreeJoint, q: Array) -> Array:
    if joint.kind == "continuous":
        return np.asarray(np.arctan2(q[joint.first_q + 1], q[joint.first_q]))
    return q[joint.first_q]


def _three_angles(axes: Array, R: Array, near: Array) -> Array:
    """Return angles (3, N) with exp(a q₀) exp(b q₁) exp(c q₂) = R for unit axes a ⟂ b ⟂ c, the solution near ``near``."""
    a, b, c = axes.T
    end = np.einsum("ijn,j->in", R, c)
    # a·R c = a·exp(b q₁) c = cosine part + sine part, as b is at right angles to both a and c.
    height = np.clip(np.einsum("i,in->n", a, end), -1, 1)
    zero = float(np.arctan2(a @ np.cross(b, c), a @ c))
    spread = np.arccos(height)
    options = np.stack([zero + spread, zero - spread])
    options += 2 * np.pi * np.round((near[1] - options) / (2 * np.pi))
    second = np.where(np.abs(options[0] - near[1]) <= np.abs(options[1] - near[1]), options[0], options[1])
    middle = rotations.exponential(b[:, None] * second)
    start = np.einsum("ijn,j->in", middle, c)

    def angle_about(axis: Array, u: Array, v: Array, default: Array) -> Array:
        sine = np.einsum("i,in->n", axis, cross(u, v))
        cosine = dot(u, v) - np.einsum("i,in->n", axis, u) * np.einsum("i,in->n", axis, v)
        angle = np.where(np.hypot(sine, cosine) < 1e-12, default, np.arctan2(sine, cosine))
        return np.asarray(angle + 2 * np.pi * np.round((default - angle) / (2 * np.pi)))

    first = angle_about(a, start, end, near[0])
    rest = np.einsum("jin,jkn->ikn", np.einsum("ijn,jkn->ikn", rotations.exponential(a[:, None] * first), middle), R)
    third = np.einsum("i,in->n", c, rotations.logarithm(rest))
    third = third + 2 * np.pi * np.round((near[2] - third) / (2 * np.pi))
    return np.stack([first, second, third])


@dataclass(frozen=True)
class Request:
    """Which coordinates are given, besides the closed loops.

    Attributes:
        columns: freedoms of the tree that are given (driven joints of the tree).
        coordinates: where in ``x`` these coordinates start, one per column, and whether they are (cos, sin).
        loops: driven loops that are given, as numbers in ``LoopEquations.loops``.
        positions: which of x, y, z are given.
        angles: which orientation coordinates are given.
        orientation: their convention.
    The targets are (n, N): columns, loops, positions, angles in that order.
    """

    columns: tuple[int, ...] = ()
    coordinates: tuple[tuple[int, bool], ...] = ()
    loops: tuple[int, ...] = ()
    positions: tuple[int, ...] = ()
    angles: tuple[int, ...] = ()
    orientation: Orientation | None = None

    @property
    def size(self) -> int:
        """Number of given coordinates."""
        return len(self.columns) + len(self.loops) + len(self.positions) + len(self.angles)

    @property
    def unknown_angles(self) -> tuple[int, ...]:
        """The orientation coordinates that the solver has to find, if any are given."""
        return tuple(k for k in range(3) if k not in self.angles) if self.angles else ()


@dataclass
class Poses:
    """Solver state: tree coordinates ``x`` (nq', N) and the orientation coordinates ``c`` (3, N) of the platform."""

    x: Array
    c: Array

    def take(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> Poses:
        """Return a copy of some poses."""
        return Poses(self.x[:, which], self.c[:, which])


class Solver:
    """Newton's method for the loops and a request.

    ``length`` [m] makes lengths and angles comparable; ``slack`` is the scaled residual that the file's own rounding may leave.
    """

    def __init__(self, equations: LoopEquations, length: float, slack: float = 1e-7) -> None:
        self.equations, self.length, self.slack = equations, length, slack
        self.tree = equations.tree
        self.mechanism = equations.mechanism
        self.platform_body, self.platform_placement = self.mechanism.platform_frame
        moves = self.tree.moves.astype(float)
        base = self.mechanism.base_frame
        self.platform_signs = moves[self.platform_body] - (moves[base[0]] if base is not None else 0.0)
        self.column_scale = np.where(self.tree.column_rotates, 1.0, length)

    # ---- coordinates of a pose --------------------------------------------------------------------------------------

    def platform_pose(self, frames: Frames) -> tuple[Array, Array]:
        """Return the platform's orientation (3, 3, N) and the position of o (3, N)."""
        R = frames.rotation[:, :, self.platform_body]
        position = frames.position[:, self.platform_body] + np.einsum("ijn,j->in", R, self.platform_placement[:3, 3])
        return np.einsum("ijn,jk->ikn", R, self.platform_placement[:3, :3]), position

    def loop_coordinate(self, number: int, frames: Frames) -> Array:
        """Return the coordinate (N,) of a one-freedom loop: successor relative to predecessor [m, rad]."""
        loop = self.equations.loops[number]
        one = np.array([loop.predecessor_body]), np.array([loop.successor_body])
        axis = frames.directions(one[0], (loop.predecessor_frame[:3, :3] @ loop.axis)[:, None])[:, 0]
        if loop.kind == "prismatic":
            gap = frames.points(one[1], loop.successor_frame[:3, 3:])[:, 0]
            return dot(axis, gap - frames.points(one[0], loop.predecessor_frame[:3, 3:])[:, 0])
        side, third = across(loop.axis)
        u = frames.directions(one[0], (loop.predecessor_frame[:3, :3] @ side)[:, None])[:, 0]
        v = frames.directions(one[0], (loop.predecessor_frame[:3, :3] @ third)[:, None])[:, 0]
        w = frames.directions(one[1], (loop.successor_frame[:3, :3] @ side)[:, None])[:, 0]
        return np.asarray(np.arctan2(dot(v, w), dot(u, w)))

    def values(self, request: Request, poses: Poses) -> Array:
        """Return the requested coordinates (n, N) of given poses."""
        frames = self.equations.forward(poses.x)
        rows = [
            np.arctan2(poses.x[start + 1], poses.x[start]) if circular else poses.x[start]
            for start, circular in request.coordinates
        ]
        rows += [self.loop_coordinate(number, frames) for number in request.loops]
        R, position = self.platform_pose(frames)
        rows += [position[k] for k in request.positions]
        if request.angles and request.orientation is not None:
            angles = request.orientation.coordinates(R)
            rows += [angles[k] for k in request.angles]
        return np.array(rows).reshape(request.size, poses.x.shape[1])

    # ---- equations --------------------------------------------------------------------------------------------------

    def system(self, request: Request, poses: Poses, target: Array) -> tuple[Array, Array]:
        """Return scaled residuals (m, N) and gradients (m, n, N) of loops and request, n: free tree columns, unknown angles."""
        equations, tree = self.equations, self.tree
        frames = equations.forward(poses.x)
        twists = tree.twists(frames)
        residual, wrench = equations.evaluate(frames)
        residuals = [residual / np.where(equations.is_length, self.length, 1.0)[:, None]]
        gradient = products(equations.signs, wrench, twists)
        scale = self.column_scale[None, :, None]
        gradients = [gradient * scale / np.where(equations.is_length, self.length, 1.0)[:, None, None]]
        N, extra = poses.x.shape[1], len(request.unknown_angles)
        at = len(request.columns)
        for number in request.loops:
            loop = equations.loops[number]
            body = np.array([loop.predecessor_body])
            axis = frames.directions(body, (loop.predecessor_frame[:3, :3] @ loop.axis)[:, None])[:, 0]
            error = self.loop_coordinate(number, frames) - target[at]
            row = np.zeros((6, 1, N))
            if loop.kind == "prismatic":
                point = frames.points(np.array([loop.successor_body]), loop.successor_frame[:3, 3:])[:, 0]
                row[:3, 0], row[3:, 0], unit = axis, cross(point, axis), self.length
            else:
                error, unit = error - 2 * np.pi * np.round(error / (2 * np.pi)), 1.0
                row[3:, 0] = axis
            signs = (tree.moves[loop.successor_body].astype(float) - tree.moves[loop.predecessor_body])[None]
            residuals.append(error[None] / unit)
            gradients.append(products(signs, row, twists) * scale / unit)
            at += 1
        extra_rows = 0
        if request.positions or request.angles:
            R, position = self.platform_pose(frames)
            moving = twists * self.platform_signs[None, :, None]
        if request.positions:
            which = list(request.positions)
            at_o = moving[:3] + cross(moving[3:], position[:, None])
            residuals.append((position[which] - target[at : at + len(which)]) / self.length)
            gradients.append(at_o[which] * scale / self.length)
            at += len(which)
        if request.angles and request.orientation is not None:
            wanted = request.orientation.matrix(poses.c)
            residuals.append(rotations.logarithm(np.einsum("ijn,kjn->ikn", R, wanted)))
            gradients.append(moving[3:] * scale)
            extra_rows = 3
        gradient = np.concatenate(gradients)
        free = np.setdiff1d(np.arange(tree.nv), request.columns)
        gradient = gradient[:, free]
        if extra:
            assert request.orientation is not None
            columns = np.zeros((gradient.shape[0], extra, N))
            columns[-extra_rows:] = -request.orientation.rates(poses.c)[:, list(request.unknown_angles)]
            gradient = np.concatenate([gradient, columns], axis=1)
        return np.concatenate(residuals), gradient

    def impose(self, request: Request, poses: Poses, target: Array) -> None:
        """Write the given tree coordinates and angles into the poses, in place."""
        for row, (start, circular) in enumerate(request.coordinates):
            if circular:
                poses.x[start], poses.x[start + 1] = np.cos(target[row]), np.sin(target[row])
            else:
                poses.x[start] = target[row]
        first = request.size - len(request.angles)
        for row, k in enumerate(request.angles):
            poses.c[k] = target[first + row]

    def advance(self, request: Request, poses: Poses, step: Array) -> Poses:
        """Return the poses moved by a scaled step (n, N)."""
        free = np.setdiff1d(np.arange(self.tree.nv), request.columns)
        v = np.zeros((self.tree.nv, poses.x.shape[1]))
        v[free] = step[: len(free)] * self.column_scale[free, None]
        c = np.array(poses.c)
        unknown = list(request.unknown_angles)
        c[unknown] += step[len(free) :]
        return Poses(self.tree.integrate(poses.x, v), c)

    def newton(self, request: Request, poses: Poses, target: Array) -> tuple[Poses, NDArray[np.bool_]]:
        """Solve for ``target`` from nearby ``poses``; also return which poses converged steadily.

        A pose counts as converged only if the corrections shrink at once and keep shrinking (P. Deuflhard, Newton Methods for
        Nonlinear Problems, section 5.1): then the solution belongs to the branch of the starting pose.
        """
        N = poses.x.shape[1]
        result = Poses(np.array(poses.x), np.array(poses.c))
        self.impose(request, result, target)
        good = np.zeros(N, dtype=bool)
        active = np.arange(N)
        before = np.full(N, np.inf)
        for iteration in range(12):
            here = result.take(active)
            residual, gradient = self.system(request, here, target[:, active])
            step = least_squares_step(gradient, residual)
            size = np.sqrt(np.max(step * step, axis=0, initial=0.0))
            ok = np.isfinite(size) & (size < 1.2)
            if iteration:
                ok &= (size < 0.4 * before[active]) | (size < 1e-10)
            step = np.where(ok, step, 0.0)
            moved = self.advance(request, here, step)
            result.x[:, active], result.c[:, active] = moved.x, moved.c
            before[active] = size
            done = ok & (size < 1e-8) & (np.max(np.abs(residual), axis=0, initial=0.0) < self.slack)
            ok &= done | (size >= 1e-8)
            good[active[done]] = True
            active = active[ok & ~done]
            if not active.size:
                break
        return result, good

    def follow(self, request: Request, start: Poses, target: Array) -> tuple[Poses, NDArray[np.bool_], Array]:
        """Follow the straight line of requested coordinates from ``start`` to ``target`` (n, N).

        Returns:
            The poses, whether each arrived, and how much of its way (0 … 1) each has gone.
        """
        N = target.shape[1]
        state = Poses(np.array(np.broadcast_to(start.x, (start.x.shape[0], N))), np.array(np.broadcast_to(start.c, (3, N))))
        origin = self.values(request, state)
        if request.angles and request.orientation is not None:
            self._unwind(request, state, origin, target)
        gone, stride = np.zeros(N), np.ones(N)
        active = np.arange(N)
        while active.size:
            trial = np.minimum(gone[active] + stride[active], 1.0)
            goal = origin[:, active] + trial * (target[:, active] - origin[:, active])
            moved, good = self.newton(request, state.take(active), goal)
            arrived = active[good]
            state.x[:, arrived], state.c[:, arrived] = moved.x[:, good], moved.c[:, good]
            gone[arrived] = trial[good]
            stride[arrived] *= 2
            stride[active[~good]] /= 2
            active = active[(gone[active] < 1) & (stride[active] > 1e-3)]
        return state, gone >= 1, gone

    def _unwind(self, request: Request, state: Poses, origin: Array, target: Array) -> None:
        """Choose the azimuth of an untilted start, which has none of its own, and fill in its other angles."""
        orientation = request.orientation
        assert orientation is not None
        R, _ = self.platform_pose(self.equations.forward(state.x))
        state.c[:] = orientation.coordinates(R)
        if orientation.name == "tilt_torsion" and 0 in request.angles:
            first = request.size - len(request.angles)
            row = first + request.angles.index(0)
            untilted = state.c[1] < 1e-9
            state.c[0] = np.where(untilted, target[row], state.c[0])
            origin[row] = state.c[0]

    def close(self, poses: Poses, request: Request, target: Array, weight: float = 1.0) -> tuple[Poses, float]:
        """Close the loops of one pose from far away by damped least squares (Levenberg–Marquardt).

        Args:
            poses: one pose to start from.
            request: what is given, and ``target`` (n, 1) its values.
            target: see ``request``.
            weight: of the request's equations against those of the loops.

        Returns:
            The pose with the smallest residual found, and that scaled residual (largest entry).
        """
        here = Poses(np.array(poses.x), np.array(poses.c))
        self.impose(request, here, target)
        damping = 1e-6

        def system(poses: Poses) -> tuple[Array, Array]:
            residual, gradient = self.system(request, poses, target)
            residual[self.equations.count :] *= weight
            gradient[self.equations.count :] *= weight
            return residual, gradient

        residual, gradient = system(here)
        for _ in range(200):
            if not residual.size or float(np.abs(residual).max()) < 1e-15:
                break
            J, r = gradient[:, :, 0], residual[:, 0]
            step = -np.linalg.solve(J.T @ J + damping * np.eye(J.shape[1]), J.T @ r)
            largest = float(np.abs(step).max(initial=0.0))
            if largest > 0.5:
                step *= 0.5 / largest
            trial = self.advance(request, here, step[:, None])
            new_residual, new_gradient = system(trial)
            if float(np.sum(new_residual**2)) <= float(np.sum(r**2)):
                here, residual, gradient = trial, new_residual, new_gradient
                damping = max(damping / 10, 1e-15)
                if largest < 1e-15:
                    break
            else:
                damping *= 10
                if damping > 1e6 or largest < 1e-14:
                    break
        return here, float(np.abs(residual).max(initial=0.0))


def least_squares_step(gradient: Array, residual: Array) -> Array:
    """Return the Newton or Gauss–Newton steps (n, N); freedoms that do not matter stay where they are."""
    if gradient.shape[1] == 0:
        return np.zeros((0, gradient.shape[2]))
    normal = np.einsum("rin,rjn->ijn", gradient, gradient)
    diagonal = np.arange(normal.shape[0])
    normal[diagonal, diagonal] += 1e-12 * (normal[diagonal, diagonal] + 1e-3)
    right = -np.einsum("rin,rn->in", gradient, residual)
    return Cholesky(normal).solve(right[:, None])[:, 0]
