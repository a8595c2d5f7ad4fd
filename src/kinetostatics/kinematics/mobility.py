"""What the loops leave free: the mobility of the platform, local freedoms, and which coordinates fix the platform."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.kinematics.solver import Poses, Request, Solver
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import null_space

#: Scaled motions of freedoms below this are rounding.
IDLE = 1e-13


@dataclass(frozen=True)
class Mobility:
    """What the loops leave free, found at generic assembled poses.

    Attributes:
        platform: freedoms of the platform.
        local: freedoms that do not move the platform (a strut spinning about itself, a loose link).
        redundant_constraints: loop equations that say nothing new: the degree of overconstraint.
        gap: ratio of the smallest kept to the largest dropped singular value; small means that the count is doubtful.
    """

    platform: int
    local: int
    redundant_constraints: int
    gap: float

    def __str__(self) -> str:
        return f"{self.platform}" + (f" (+{self.local} local)" if self.local else "")


class Freedoms:
    """The freedoms of a robot at its generic poses, by the null spaces of its loop equations.

    Args:
        solver: whose equations they are.
        generic: the generic poses.
        rank_tolerance: relative singular value below which a direction counts as dependent.
    """

    def __init__(self, solver: Solver, generic: Poses, rank_tolerance: float) -> None:
        self.solver, self.rank_tolerance = solver, rank_tolerance
        self.poses = [generic.take(np.array([number])) for number in range(generic.x.shape[1])]
        self._fixes: dict[Request, bool] = {}
        self._local: dict[Request, int] = {}
        self._without_idle: dict[Request, Request] = {}

    @cached_property
    def mobility(self) -> Mobility:
        """Mobility of the platform, local freedoms and redundant constraints."""
        ranks, gaps, platforms = [], [], []
        for pose in self.poses:
            _, gradient = self.solver.system(Request(), pose, np.zeros((0, 1)))
            free, rank, gap = null_space(gradient[:, :, 0], self.rank_tolerance)
            values = np.linalg.svd(self._platform_map(pose) @ free, compute_uv=False)
            platforms.append(int(np.sum(values > self.rank_tolerance)))
            ranks.append(rank)
            gaps.append(gap)
        best = int(np.argmax(ranks))
        freedoms, platform = self.solver.tree.nv - ranks[best], platforms[best]
        return Mobility(platform, freedoms - platform, self.solver.equations.count - ranks[best], gaps[best])

    def fixes_platform(self, request: Request) -> bool:
        """Whether the requested coordinates leave the platform no freedom, at generic poses."""
        if request not in self._fixes:
            self._fixes[request] = any(self.fixes_platform_at(request, pose) for pose in self.poses)
        return self._fixes[request]

    def fixes_platform_at(self, request: Request, pose: Poses) -> bool:
        """Whether the requested coordinates leave the platform no freedom at one pose."""
        columns = self.solver.free_columns(request)
        moving = self._platform_map(pose)[:, columns] @ self._free_motions(request, pose)[: len(columns)]
        return float(np.abs(moving).max(initial=0.0)) < 1e-6

    def local_freedoms(self, request: Request) -> int:
        """How many freedoms the requested coordinates leave, at generic poses: local ones, if they fix the platform."""
        if request not in self._local:
            self._local[request] = min(self._free_motions(request, pose).shape[1] for pose in self.poses)
        return self._local[request]

    def without_idle(self, request: Request) -> Request:
        """Return a request that fixes the freedoms that change neither loops nor what is requested: the spins of most rods."""
        if request not in self._without_idle:
            gradients = [np.abs(self._gradient(request, pose)) for pose in self.poses]
            columns = self.solver.free_columns(request)
            idle = columns[np.max(gradients, axis=(0, 1), initial=0.0)[: columns.size] < IDLE]
            self._without_idle[request] = replace(request, held=tuple(idle.tolist()))
        return self._without_idle[request]

    def _platform_map(self, pose: Poses) -> Array:
        """Return the scaled (6, nv) map from scaled tree freedoms to the platform's twist at o."""
        solver = self.solver
        frames = solver.equations.forward(pose.x)
        twists = (solver.tree.twists(frames) * solver.platform_signs[:, None])[:, :, 0]
        _, position = solver.mechanism.platform_pose(frames)
        linear = twists[:3] + np.cross(twists[3:], position, axis=0)
        return np.concatenate([linear / solver.length, twists[3:]]) * solver.column_scale

    def _free_motions(self, request: Request, pose: Poses) -> Array:
        """Return a basis (n, k) of the scaled motions of free columns and unknown angles that a request allows at one pose."""
        return null_space(self._gradient(request, pose), self.rank_tolerance)[0]

    def _gradient(self, request: Request, pose: Poses) -> Array:
        """Return the gradient (m, n) of loops and request at one pose."""
        if request.orientation is not None:
            R, _ = self.solver.mechanism.platform_pose(self.solver.equations.forward(pose.x))
            pose = Poses(pose.x, request.orientation.coordinates(R))
        return self.solver.system(request, pose, self.solver.values(request, pose))[1][:, :, 0]
