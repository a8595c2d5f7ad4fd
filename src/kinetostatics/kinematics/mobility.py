"""Generic poses, and the freedoms of a robot at these poses: mobility, local freedoms, overconstraint, platform coordinates.

Generic poses are closed poses near the zero pose without its symmetry. A local freedom does not move the platform. In *scaled*
twists and rates, lengths are divided by the characteristic length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_gaps import close
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import canonical_basis, null_space
from kinetostatics.math.screws import move_twist

#: Relative singular value below which a direction counts as dependent. Angles rounded to 1.5708 leave 4e-6.
RANK_TOLERANCE = 1e-5
#: Largest scaled gradient that counts as rounding; a freedom with such a gradient affects no equation.
IDLE = 1e-13


def rank_tolerance(closing_error: float) -> float:
    """Return the relative singular value below which a direction is taken as dependent, above the rounding errors of the file."""
    return max(RANK_TOLERANCE, 30 * closing_error)


def generic_poses(solver: Solver, zero: SolverState, closing_error: float) -> tuple[SolverState, float]:
    """Return three generic poses, and the largest scaled residual at these poses and at the pose ``zero``.

    ``closing_error`` is the scaled residual at ``zero``.
    """
    random, tree, worst = np.random.default_rng(7), solver.tree, closing_error
    nothing = PrescribedCoordinates(), np.zeros((0, 1))
    tolerance = rank_tolerance(worst)
    poses = []
    for size in (0.12, 0.1, 0.08):
        pose, direction = zero, random.standard_normal(tree.nv)
        for _ in range(2):  # twice, because the free motions are not generic if the zero pose is singular
            _, gradient = solver.system(nothing[0], pose, nothing[1])
            free = null_space(gradient[:, :, 0], tolerance)[0]
            v = free @ (free.T @ direction)
            v = v * solver.column_scale * (size / max(float(np.abs(v).max(initial=0.0)), 1e-9))
            pose, left = close(solver, SolverState(tree.integrate(pose.x, v[:, None]), pose.c), *nothing, cutoff=tolerance)
            worst = max(worst, float(left[0]))
        poses.append(pose)
    return SolverState(np.hstack([pose.x for pose in poses]), np.hstack([pose.c for pose in poses])), worst


@dataclass(frozen=True)
class Mobility:
    """Mobility at generic assembled poses.

    Attributes:
        platform: freedoms of the platform.
        local: freedoms that do not move the platform (a strut that spins about its axis, a loose link).
        redundant_constraints: number of dependent loop equations, which is the degree of overconstraint.
        gap: ratio of the smallest nonzero singular value to the largest taken as zero; if small, the mobility is doubtful.
    """

    platform: int
    local: int
    redundant_constraints: int
    gap: float

    def __str__(self) -> str:
        return f"{self.platform}" + (f" (+{self.local} local)" if self.local else "")


class MobilityAnalysis:
    """The freedoms of a robot at its generic poses, by the null spaces of its loop equations.

    ``rank_tolerance`` is the relative singular value below which a direction is taken as dependent.
    """

    def __init__(self, solver: Solver, generic: SolverState, rank_tolerance: float) -> None:
        self.solver, self.rank_tolerance = solver, rank_tolerance
        self.poses = [generic.take(np.array([number])) for number in range(generic.x.shape[1])]
        self._fixes: dict[PrescribedCoordinates, bool] = {}
        self._with_dofs: dict[PrescribedCoordinates, PrescribedCoordinates] = {}

    @cached_property
    def mobility(self) -> Mobility:
        """With the gradient A of the loops, of rank r, and its null space Z: nv − r freedoms, rank(J Z) of the platform."""
        candidates = []
        for pose in self.poses:
            _, gradient = self.solver.system(PrescribedCoordinates(), pose, np.zeros((0, 1)))
            free, rank, gap = null_space(gradient[:, :, 0], self.rank_tolerance)
            values = np.linalg.svd(self._platform_map(pose) @ free, compute_uv=False)
            candidates.append((rank, gap, int(np.sum(values > self.rank_tolerance))))
        rank, gap, platform = max(candidates, key=lambda candidate: candidate[0])
        return Mobility(platform, self.solver.tree.nv - rank - platform, self.solver.equations.count - rank, gap)

    def fixes_platform(self, prescribed: PrescribedCoordinates) -> bool:
        """Whether the prescribed coordinates determine the platform's pose, at generic poses."""
        if prescribed not in self._fixes:
            self._fixes[prescribed] = any(self.fixes_platform_at(prescribed, pose) for pose in self.poses)
        return self._fixes[prescribed]

    def fixes_platform_at(self, prescribed: PrescribedCoordinates, pose: SolverState) -> bool:
        """Whether the prescribed coordinates determine the platform's pose, at one pose."""
        columns = self.solver.free_columns(prescribed)
        moving = self._platform_map(pose)[:, columns] @ self._free_motions(prescribed, pose)[: len(columns)]
        return float(np.abs(moving).max(initial=0.0)) < 1e-6

    def with_dofs(self, prescribed: PrescribedCoordinates) -> PrescribedCoordinates:
        """Return ``prescribed``, which determine the platform's pose, with ``fixed_dofs`` and ``local_dofs`` at generic poses.

        ``fixed_dofs`` are freedoms of single joints that change neither loops nor prescribed coordinates, such as spins of rods;
        ``local_dofs`` is the number of the other remaining freedoms.
        """
        if prescribed not in self._with_dofs:
            gradients = [np.abs(self._gradient(prescribed, pose)) for pose in self.poses]
            columns = self.solver.free_columns(prescribed)
            idle = columns[np.max(gradients, axis=(0, 1), initial=0.0)[: columns.size] < IDLE]
            completed = replace(prescribed, fixed_dofs=tuple(idle.tolist()))
            local = min(self._free_motions(completed, pose).shape[1] for pose in self.poses)
            self._with_dofs[prescribed] = replace(completed, local_dofs=local)
        return self._with_dofs[prescribed]

    def platform_motions(self, pose: SolverState) -> Array:
        """Return an orthonormal basis (6, n) of the scaled twists of the platform at o that the loops permit at one pose."""
        U, values, _ = np.linalg.svd(self._platform_map(pose) @ self._free_motions(PrescribedCoordinates(), pose))
        return np.asarray(U[:, : int(np.sum(values > self.rank_tolerance))])

    def free_motions(self, prescribed: PrescribedCoordinates, pose: SolverState) -> tuple[Array, Array]:
        """Return (a, b), the motions of the platform at one pose with fixed prescribed coordinates.

        a (6, k) is a basis of its twists at o [m, rad]; b (nv, k) are the smallest rates of the tree's freedoms that cause them.
        """
        solver, columns = self.solver, self.solver.free_columns(prescribed)
        basis = self._free_motions(prescribed, pose)[: len(columns)]
        by_basis = self._platform_map(pose)[:, columns] @ basis
        U, values, _ = np.linalg.svd(by_basis)
        twists = canonical_basis(U[:, : int(np.sum(values > 1e-6))])
        rates = np.zeros((solver.tree.nv, twists.shape[1]))
        rates[columns] = solver.column_scale[columns, None] * (basis @ np.linalg.lstsq(by_basis, twists, rcond=1e-6)[0])
        return twists * np.repeat([solver.length, 1.0], 3)[:, None], rates

    def motions_at(self, poses: SolverState) -> Array:
        """Return the bases of :meth:`platform_motions` (N, 6, n) at N poses; n is the mobility at generic poses.

        The bases are NaN at poses with another mobility or another rank of the loop equations.
        """
        N, none = poses.x.shape[1], PrescribedCoordinates()
        gradient = np.moveaxis(self.solver.system(none, poses, np.zeros((0, N)))[1], 2, 0)
        first = self.solver.tree.nv - self.mobility.platform - self.mobility.local
        rows, rank = np.broadcast_to(np.eye(gradient.shape[2]), (N, gradient.shape[2], gradient.shape[2])), np.zeros(N, dtype=int)
        if gradient.shape[1]:
            _, values, rows = np.linalg.svd(gradient)
            rank = np.sum(values > self.rank_tolerance * np.maximum(values[:, :1], 1.0), axis=1)
        moved = np.moveaxis(self._platform_maps(poses), 2, 0) @ np.swapaxes(rows[:, first:], 1, 2)
        U, values, _ = np.linalg.svd(moved)
        regular = (rank == first) & (np.sum(values > self.rank_tolerance, axis=1) == self.mobility.platform)
        return np.where(regular[:, None, None], U[:, :, : self.mobility.platform], np.nan)

    def _platform_map(self, pose: SolverState) -> Array:
        return self._platform_maps(pose)[:, :, 0]

    def _platform_maps(self, poses: SolverState) -> Array:
        """Return the maps (6, nv, N) from scaled rates of the tree's freedoms to the platform's scaled twist at o."""
        solver, frames = self.solver, self.solver.equations.forward(poses.x)
        twists = solver.tree.twists(frames) * solver.platform_signs[:, None]
        _, position = solver.mechanism.platform_pose(frames)
        return move_twist(twists, position) / np.repeat([solver.length, 1.0], 3)[:, None, None] * solver.column_scale[:, None]

    def _free_motions(self, prescribed: PrescribedCoordinates, pose: SolverState) -> Array:
        """Return a basis (f, k) of the free motions at one pose, as scaled changes of the f unknown freedoms and angles."""
        return null_space(self._gradient(prescribed, pose), self.rank_tolerance)[0]

    def _gradient(self, prescribed: PrescribedCoordinates, pose: SolverState) -> Array:
        """Return the gradient (m, f) of loops and prescribed coordinates at one pose."""
        if prescribed.orientation is not None:
            R, _ = self.solver.mechanism.platform_pose(self.solver.equations.forward(pose.x))
            pose = SolverState(pose.x, prescribed.orientation.coordinates(R))
        return self.solver.system(prescribed, pose, self.solver.values(prescribed, pose))[1][:, :, 0]
