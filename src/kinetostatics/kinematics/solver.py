"""Newton's method on thousands of poses at once: closed loops and prescribed coordinates.

The f *unknowns* are the freedoms of the tree that are neither prescribed nor fixed, followed by the unknown orientation
coordinates of the platform; n is the number of prescribed coordinates. In *scaled* residuals and steps, lengths are divided by a
characteristic length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.kinematics.coordinates import PrescribedCoordinates, line_start
from kinetostatics.kinematics.loop_constraints import LoopEquations, Placed, joined, signed_powers
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math import rotations
from kinetostatics.math.arrays import Array, Index, Mask, chunks, empty_for, everywhere, zeros_for
from kinetostatics.math.linalg import dot, have_one_sign, least_squares, surely_have_one_sign
from kinetostatics.math.screws import wrench_of_couple, wrench_of_force
from kinetostatics.mechanism.tree import Frames

#: Largest ratio of successive corrections; the ratio must decrease at every iteration unless it is below the second value.
SHRINKING, _QUADRATIC = 0.4, 0.25
#: Largest number of corrections of a pose.
MOST_CORRECTIONS = 12
#: Largest error of scaled coordinates at intermediate poses.
ROUGHLY = 1e-7


@dataclass(repr=False)
class SolverState(ShortRepr):
    """Coordinates ``x`` (nq', N) of the solver's tree, and orientation coordinates ``c`` (3, N) of the platform, at N poses."""

    x: Array
    c: Array

    def take(self, which: Index | Mask) -> SolverState:
        return SolverState(self.x[:, which], self.c[:, which])


@dataclass(frozen=True, repr=False)
class Correction(ShortRepr):
    """Result of one Newton correction of N poses.

    ``poses`` are unchanged where corrections do not decrease. ``size`` (N,) is the size of each scaled step, ``shrunk`` (N,) its
    ratio to the size of the previous step. ``done`` (N,) is True for converged poses, ``going`` for poses to be corrected again.
    """

    poses: SolverState
    size: Array
    shrunk: Array
    done: Mask
    going: Mask


class Solver:
    """Newton's method for loops, mimic joints and prescribed coordinates.

    ``length`` [m] is the scale of lengths relative to angles in residuals and unknowns, ``reach`` [m] the scale in the sizes of
    steps. Scaled residuals up to ``slack`` are taken as rounding of the file. ``joint_of_column`` has the joints of the tree,
    each by the index of its first freedom. If ``is_compiled``, chunks of poses are solved in threads.
    """

    is_compiled = False

    def __init__(self, equations: LoopEquations, length: float, reach: float, slack: float = 1e-7) -> None:
        self.equations, self.length, self.reach, self.slack = equations, length, reach, slack
        self.tree = equations.tree
        self.mechanism = equations.mechanism
        moves = self.tree.moves.astype(float)
        base = self.mechanism.base_frame
        self.platform_signs = moves[self.mechanism.platform_frame[0]] - (moves[base[0]] if base is not None else 0.0)
        self.joint_of_column = {joint.first_v: joint for joint in self.tree.joints}
        self.column_scale = np.where(self.tree.column_rotates, 1.0, length)
        self._row_scale = np.where(equations.is_length, length, 1.0)[:, None]

    # caches (cached properties are not part of recorded code)
    @cached_property
    def _free(self) -> dict[tuple[tuple[int, ...], ...], Index]:
        """Results of :meth:`free_columns` by prescribed and fixed freedoms."""
        return {}

    @cached_property
    def _scales(self) -> dict[tuple[tuple[int, ...], ...], tuple[Array, Array]]:
        """Results of :meth:`_factors` by prescribed and fixed freedoms."""
        return {}

    # ---- coordinates of a pose --------------------------------------------------------------------------------------

    def loop_coordinate(self, number: int, frames: Frames) -> Array:
        """Return the coordinate (N,) of a one-freedom loop: travel [m] or angle [rad] of the successor from the predecessor."""
        loop = self.equations.loops[number]
        here, there = loop.predecessor_body, loop.successor_body
        axes = self.equations.loop_axes[number]
        if loop.type.is_slide:
            gap = frames.point(there, loop.successor_frame[:3, 3]) - frames.point(here, loop.predecessor_frame[:3, 3])
            return dot(frames.direction(here, axes.axis), gap)
        u, v, w = frames.direction(here, axes.side), frames.direction(here, axes.third), frames.direction(there, axes.turned_side)
        angle: Array = np.arctan2(dot(v, w), dot(u, w))
        if axes.middle is not None:  # of the angles that differ by full turns, the one nearest to the middle of the limits
            angle = angle + 2 * np.pi * np.round((axes.middle - angle) / (2 * np.pi))
        return angle

    def values(self, prescribed: PrescribedCoordinates, poses: SolverState, near: Array | None = None) -> Array:
        """Return the prescribed coordinates (n, N) at given poses.

        Of angles of actuators that differ by full turns, those nearest to ``near`` (n, N) are chosen.
        """
        frames = self.equations.forward(poses.x)
        given = np.zeros((prescribed.size, 1)) if near is None else np.where(np.isfinite(near), near, 0.0)
        rows = []
        for row, column in enumerate(prescribed.columns):
            rows.append(self.equations.couplings.coordinate(self.joint_of_column[column], poses.x, given[row]))
        for row, number in enumerate(prescribed.loops, len(rows)):
            value = self.loop_coordinate(number, frames)
            if near is not None and not self.equations.loops[number].type.is_slide:
                value = value + 2 * np.pi * np.round((given[row] - value) / (2 * np.pi))
            rows.append(value)
        R, position = self.mechanism.platform_pose(frames)
        rows += [position[k] for k in prescribed.positions]
        if prescribed.angles and prescribed.orientation is not None:
            angles = prescribed.orientation.coordinates(R)
            rows += [angles[k] for k in prescribed.angles]
        return np.array(np.broadcast_arrays(*rows)).reshape(prescribed.size, -1) if rows else np.zeros((0, poses.x.shape[1]))

    def place(self, x: Array) -> Placed:
        parts = [self.equations.place(x[:, part]) for part in chunks(x.shape[1]) or [slice(0, 0)]]
        return parts[0] if len(parts) == 1 else joined(parts)

    # ---- equations --------------------------------------------------------------------------------------------------

    def system(self, prescribed: PrescribedCoordinates, poses: SolverState, target: Array) -> tuple[Array, Array]:
        """Return the scaled residuals (m, N) of all equations, and their gradients (m, f, N) with respect to the unknowns."""
        equations, tree = self.equations, self.tree
        free, (loop_factors, platform_factors) = self.free_columns(prescribed), self._factors(prescribed)
        N, f, extra = poses.x.shape[1], len(free), len(prescribed.unknown_angles)
        rows = equations.count + len(prescribed.loops) + len(prescribed.positions)
        residuals = empty_for((rows + (3 if prescribed.angles else 0), N), poses.x)
        gradient = empty_for((residuals.shape[0], f + extra, N), poses.x)
        gradient[:, f:] = 0
        frames = equations.forward(poses.x)
        twists = tree.twists(frames)
        if f < tree.nv:
            twists = twists[:, free]
        residual, wrench = equations.evaluate(frames)
        at = equations.closures
        np.divide(residual, self._row_scale, out=residuals[:at])
        np.einsum("krn,kvn->rvn", wrench, twists, out=gradient[:at, :f])
        gradient[:at, :f] *= loop_factors
        if equations.couplings.count:
            residual, coupled = equations.couplings.equations(poses.x, self.column_scale, prescribed.columns)
            residuals[at : at + len(residual)] = residual
            gradient[at : at + len(residual), :f] = coupled[:, free, None]
            at += len(residual)
        given = len(prescribed.columns)
        for number in prescribed.loops:
            loop = equations.loops[number]
            axis = frames.direction(loop.predecessor_body, equations.loop_axes[number].axis)
            error = self.loop_coordinate(number, frames) - target[given]
            if loop.type.is_slide:
                point = frames.point(loop.successor_body, loop.successor_frame[:3, 3])
                wrench, unit = wrench_of_force(axis, point), self.length
            else:
                error, wrench, unit = error - 2 * np.pi * np.round(error / (2 * np.pi)), wrench_of_couple(axis), 1.0
            signs = (tree.moves[loop.successor_body].astype(float) - tree.moves[loop.predecessor_body])[None, free]
            residuals[at] = error / unit
            gradient[at, :f] = signed_powers(signs * self.column_scale[free] / unit, wrench[:, None], twists)[0]
            at, given = at + 1, given + 1
        if prescribed.positions or prescribed.angles:
            R, position = self.mechanism.platform_pose(frames)
        for k in prescribed.positions:
            y, z = (k + 1) % 3, (k + 2) % 3
            residuals[at] = (position[k] - target[given]) / self.length
            at_o = twists[k] + twists[3 + y] * position[z] - twists[3 + z] * position[y]
            np.multiply(at_o, platform_factors / self.length, out=gradient[at, :f])
            at, given = at + 1, given + 1
        if prescribed.angles and prescribed.orientation is not None:
            target = prescribed.orientation.matrix(poses.c)
            residuals[at:] = rotations.logarithm(np.einsum("ijn,kjn->ikn", R, target))
            np.multiply(twists[3:], platform_factors, out=gradient[at:, :f])
            if extra:
                gradient[at:, f:] = -prescribed.orientation.rates(poses.c)[:, list(prescribed.unknown_angles)]
        return residuals, gradient

    def predictors(self, prescribed: PrescribedCoordinates, poses: SolverState, target: Array) -> Array:
        """Return the scaled steps −A⁺ B (f, n, N) of the unknowns per change of each prescribed coordinate, at solved poses."""
        gradient, rates = self.rates(prescribed, poses, target)
        return np.nan_to_num(-least_squares(gradient, rates, prescribed.local_dofs))

    def rates(self, prescribed: PrescribedCoordinates, poses: SolverState, target: Array) -> tuple[Array, Array]:
        """Return (A, B), the derivatives of m scaled residuals.

        A (m, f, N) is with respect to scaled steps of the unknowns, B (m, n, N) with respect to the prescribed coordinates.
        """
        given, free = len(prescribed.columns), self.free_columns(prescribed)
        everything = replace(prescribed, columns=())
        columns = self.free_columns(everything)
        _, gradient = self.system(everything, poses, target[given:])
        rates = zeros_for((gradient.shape[0], *target.shape), gradient)
        for row, column in enumerate(prescribed.columns):
            for moved, by in self.equations.couplings.rates_with(column):
                rates[:, row] += gradient[:, np.searchsorted(columns, moved)] * (by / self.column_scale[moved])
        at = self.equations.count
        are_lengths = [self.equations.loops[number].type.is_slide for number in prescribed.loops]
        are_lengths += [True] * len(prescribed.positions)
        for row, is_length in enumerate(are_lengths, given):
            rates[at, row] = -1 / self.length if is_length else -1.0
            at += 1
        if prescribed.angles and prescribed.orientation is not None:
            rates[at:, prescribed.first_angle :] = -prescribed.orientation.rates(poses.c)[:, list(prescribed.angles)]
        unknown = np.append(np.searchsorted(columns, free), np.arange(columns.size, gradient.shape[1]))
        return gradient[:, unknown.astype(np.intp)], rates

    def _factors(self, prescribed: PrescribedCoordinates) -> tuple[Array, Array]:
        """Return signed scales of the k free freedoms: (closures, k, 1) in the loop equations, (k, 1) in the platform's twist."""
        if (key := (prescribed.columns, prescribed.fixed_dofs)) not in self._scales:
            free = self.free_columns(prescribed)
            loops = self.equations.signs[:, free] * self.column_scale[free] / self._row_scale
            self._scales[key] = loops[:, :, None], (self.platform_signs * self.column_scale)[free, None]
        return self._scales[key]

    def free_columns(self, prescribed: PrescribedCoordinates) -> Index:
        """Return the unknown freedoms of the tree: neither fixed, nor prescribed, nor followers of prescribed freedoms."""
        if (key := (prescribed.columns, prescribed.fixed_dofs)) not in self._free:
            followers = self.equations.couplings.followers_of(prescribed.columns)
            self._free[key] = np.setdiff1d(np.arange(self.tree.nv), [*prescribed.columns, *followers, *prescribed.fixed_dofs])
        return self._free[key]

    def impose(self, prescribed: PrescribedCoordinates, poses: SolverState, target: Array) -> None:
        """Write the prescribed freedoms, their followers and the prescribed angles into the poses, in place."""
        for row, column in enumerate(prescribed.columns):
            self.joint_of_column[column].write(target[row], poses.x)
        self.equations.couplings.impose(prescribed.columns, target, poses.x)
        for row, k in enumerate(prescribed.angles, prescribed.first_angle):
            poses.c[k] = target[row]

    def advance(self, prescribed: PrescribedCoordinates, poses: SolverState, step: Array) -> SolverState:
        """Return the poses moved by a scaled ``step`` (f, N) of the unknowns."""
        free = self.free_columns(prescribed)
        v = zeros_for((self.tree.nv, poses.x.shape[1]), step)
        v[free] = step[: len(free)] * self.column_scale[free, None]
        c = np.array(poses.c, subok=True)
        c[list(prescribed.unknown_angles)] += step[len(free) :]
        return SolverState(self.tree.integrate(poses.x, v), c)

    def size(self, prescribed: PrescribedCoordinates, step: Array) -> Array:
        """Return the sizes (N,) of scaled steps (f, N): the largest rotation [rad] or displacement relative to the reach."""
        squares = step * step
        slides = np.flatnonzero(~self.tree.column_rotates[self.free_columns(prescribed)])
        if slides.size:
            squares[slides] *= (self.length / self.reach) ** 2
        largest: Array = np.sqrt(np.max(squares, axis=0, initial=0.0))
        return largest

    def newton(
        self,
        prescribed: PrescribedCoordinates,
        poses: SolverState,
        target: Array,
        before: Array | None = None,
        passing: Mask | None = None,
    ) -> tuple[SolverState, Mask]:
        """Solve for ``target`` from nearby ``poses``; also return (N,) True for poses that converged steadily.

        A pose has converged steadily only if the corrections decrease from the first one on, at ratios that do not grow, as
        happens when Newton's method converges quadratically (P. Deuflhard, Newton Methods for Nonlinear Problems, section 5.1):
        then the solution belongs to the branch of the starting pose.

        Args:
            target: (n, N) values of the prescribed coordinates [m, rad].
            before: (N,) sizes of the scaled steps by which the starting poses were predicted; None or infinite: not predicted.
            passing: (N,) True for intermediate poses on a path, which are solved only to :data:`ROUGHLY`; None: all False.
        """
        N = poses.x.shape[1]
        result = SolverState(np.array(poses.x), np.array(poses.c))
        self.impose(prescribed, result, target)
        good = np.zeros(N, dtype=bool)
        active = np.arange(N)
        before = np.full(N, np.inf) if before is None else before
        shrunk = np.full(N, SHRINKING)
        for _ in range(MOST_CORRECTIONS):
            everyone = active.size == N
            here = result if everyone else result.take(active)
            passing_here = None if passing is None else passing[active]
            correction = self.correct(prescribed, here, target if everyone else target[:, active], before, shrunk, passing_here)
            if everyone:
                result = correction.poses
            else:
                result.x[:, active], result.c[:, active] = correction.poses.x, correction.poses.c
            good[active[correction.done]] = True
            going = correction.going
            active, before, shrunk = active[going], correction.size[going], correction.shrunk[going]
            if not active.size:
                break
        return result, good

    def in_one_go(self, prescribed: PrescribedCoordinates, start: SolverState, target: Array) -> SolverState | None:
        """Return the pose at ``target`` (n, 1) near one pose, by :meth:`newton` and :meth:`on_one_side` in one compiled call.

        None if they fail, or if the solver is not compiled.
        """
        return None

    def correct(
        self,
        prescribed: PrescribedCoordinates,
        poses: SolverState,
        target: Array,
        before: Array,
        shrunk: Array,
        passing: Mask | None,
    ) -> Correction:
        """Correct poses with imposed coordinates once by the step −A⁺ r of Newton and Gauss, see :meth:`newton`.

        ``before`` (N,) are the sizes of the previous steps, ``shrunk`` (N,) their ratios to the sizes one step earlier.
        """
        residual, gradient = self.system(prescribed, poses, target)
        step = -least_squares(gradient, residual[:, None], prescribed.local_dofs)[:, 0]
        size = self.size(prescribed, step)
        with np.errstate(invalid="ignore", over="ignore"):
            ratio = size / before
            following = size * ratio**2  # quadratic convergence
        ok = np.isfinite(size) & (size < 1.2)
        ok &= (ratio < np.minimum(SHRINKING, np.maximum(shrunk, _QUADRATIC))) | (size < 1e-10)
        step = np.where(ok, step, 0.0)
        last = (size < 1e-8) | ((following < 1e-13) & (size < 1e-5))
        if passing is not None:
            last |= passing & (np.where(np.isfinite(before), following, size) < ROUGHLY)
        done = ok & last
        if not everywhere(~done):  # the loops must close, not only reach a least-squares minimum
            left = residual + np.einsum("ij...,j...->i...", gradient, step)
            done = done & (np.max(np.abs(left), axis=0, initial=0.0) < self.slack)
        shrunk = np.where(np.isfinite(before), ratio, SHRINKING)
        return Correction(self.advance(prescribed, poses, step), size, shrunk, done, ok & ~last)

    def on_one_side(self, prescribed: PrescribedCoordinates, first: SolverState, second: SolverState, target: Array) -> Mask:
        """(N,) True for pairs of poses with no singular pose between: the determinants of their gradients have one sign."""
        gradients = (self.system(prescribed, poses, target)[1] for poses in (first, second))
        return have_one_sign(*gradients)

    def surely_on_one_side(self, prescribed: PrescribedCoordinates, first: SolverState, second: SolverState) -> Mask:
        """(N,) True where :meth:`on_one_side` holds with a margin for rounding; False decides nothing."""
        nothing = np.zeros((prescribed.size, 1))
        gradients = (self.system(prescribed, poses, nothing)[1] for poses in (first, second))
        return surely_have_one_sign(*gradients)

    def origin(self, prescribed: PrescribedCoordinates, start: SolverState, near: Array | None = None) -> tuple[Array, Array]:
        """Return (a, c) at poses where straight lines start: a (n, N) prescribed coordinates, c (3, N) orientation coordinates.

        ``near`` is as in :meth:`values`.
        """
        values = self.values(prescribed, start, near)
        if not prescribed.angles or prescribed.orientation is None:
            return values, start.c
        R, _ = self.mechanism.platform_pose(self.equations.forward(start.x))
        return values, prescribed.orientation.coordinates(R)

    def line(
        self, prescribed: PrescribedCoordinates, start: SolverState, target: Array, shorter: bool = True
    ) -> tuple[Array, Array]:
        """Return the coordinates at the starts of straight lines to targets (n, N), see :func:`.coordinates.line_start`."""
        return line_start(prescribed, self.origin(prescribed, start, target if shorter else None), target, shorter)
