"""Generic poses, at which ranks and bases are decided: assembled, near the zero pose and without symmetry."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.loop_gaps import close
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.linalg import null_space

#: Relative singular value below which a direction counts as dependent. Angles rounded to 1.5708 leave 4e-6.
RANK_TOLERANCE = 1e-5


def rank_tolerance(closing_error: float) -> float:
    """Return the relative singular value below which a direction counts as dependent; it exceeds rounding errors of the file."""
    return max(RANK_TOLERANCE, 30 * closing_error)


def generic_poses(solver: Solver, zero: SolverState, closing_error: float) -> tuple[SolverState, float]:
    """Return three generic poses, and the largest scaled residual with which they and the zero pose close.

    Args:
        solver: closes the loops.
        zero: the closed zero pose.
        closing_error: the scaled residual of the zero pose.
    """
    random, tree, worst = np.random.default_rng(7), solver.tree, closing_error
    nothing = PrescribedCoordinates(), np.zeros((0, 1))
    tolerance = rank_tolerance(worst)
    found = []
    for size in (0.12, 0.1, 0.08):
        pose, direction = zero, random.standard_normal(tree.nv)
        for _ in range(2):  # twice, because free motions at a singular zero pose are not generic
            _, gradient = solver.system(nothing[0], pose, nothing[1])
            free = null_space(gradient[:, :, 0], tolerance)[0]
            v = free @ (free.T @ direction)
            v = v * solver.column_scale * (size / max(float(np.abs(v).max(initial=0.0)), 1e-9))
            pose, left = close(solver, SolverState(tree.integrate(pose.x, v[:, None]), pose.c), *nothing, cutoff=tolerance)
            worst = max(worst, float(left[0]))
        found.append(pose)
    return SolverState(np.hstack([pose.x for pose in found]), np.hstack([pose.c for pose in found])), worst
