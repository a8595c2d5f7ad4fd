"""Loops of one pose closed from far away: damped least squares."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.solver import PrescribedCoordinates, Solver, SolverState
from kinetostatics.math.arrays import Array


def close(
    solver: Solver,
    poses: SolverState,
    prescribed: PrescribedCoordinates,
    target: Array,
    weight: float = 1.0,
    cutoff: float = 1e-9,
) -> tuple[SolverState, float]:
    """Close the loops of one pose from far away by damped least squares (Levenberg–Marquardt).

    Args:
        solver: whose equations they are.
        poses: one pose to start from.
        prescribed: what is given, and ``target`` (n, 1) its values.
        target: see ``prescribed``.
        weight: of the prescribed coordinates' equations against those of the loops.
        cutoff: directions with a smaller relative singular value are left alone. Rounding in a file makes every motion of an
            overconstrained robot open its loops a little; they are not to be closed by undoing the motion.

    Returns:
        The pose with the smallest residual found, and that scaled residual (largest entry).
    """
    here = SolverState(np.array(poses.x), np.array(poses.c))
    solver.impose(prescribed, here, target)
    damping = 1e-6

    def system(poses: SolverState) -> tuple[Array, Array]:
        residual, gradient = solver.system(prescribed, poses, target)
        residual[solver.equations.count :] *= weight
        gradient[solver.equations.count :] *= weight
        return residual, gradient

    residual, gradient = system(here)
    for _ in range(200):
        if not residual.size or float(np.abs(residual).max()) < 1e-15:
            break
        r = residual[:, 0]
        U, values, V = np.linalg.svd(gradient[:, :, 0], full_matrices=False)
        gain = np.where(values > cutoff * values.max(initial=0.0), values / (values**2 + damping), 0.0)
        step = np.asarray(-(V.T @ (gain * (U.T @ r))), dtype=np.float64)
        largest = float(np.abs(step).max(initial=0.0))
        if largest > 0.5:
            step *= 0.5 / largest
        trial = solver.advance(prescribed, here, step[:, None])
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
