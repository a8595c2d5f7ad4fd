"""Velocities of all freedoms of a mechanism whose loops remain closed, by the implicit function theorem."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver
from kinetostatics.math.arrays import Array, zeros_for

#: Relative residual of the rates above which the loops cannot remain closed.
_OPEN = 1e-6


def freedom_rates(solver: Solver, prescribed: PrescribedCoordinates, gradient: Array, rates: Array, step: Array) -> Array:
    """Return the rates (nv, k, N) of the free freedoms; NaN where the residuals cannot remain zero.

    Args:
        solver: solver of the loops.
        prescribed: prescribed coordinates.
        gradient: (m, n, N) derivatives of scaled residuals with respect to scaled free steps.
        rates: (m, k, N) partial rates of the residuals.
        step: (n, k, N) steps that compensate them in the least-squares sense.
    """
    left = np.max(np.abs(rates + np.einsum("mnN,nkN->mkN", gradient, step)), axis=0, initial=0.0)
    stays_open = left > _OPEN * np.max(np.abs(rates), axis=0, initial=0.0) + 1e-12
    free = solver.free_columns(prescribed)
    v = zeros_for((solver.tree.nv, *step.shape[1:]), step)
    v[free] = step[: free.size] * solver.column_scale[free, None, None]
    return np.where(stays_open, np.nan, v)


def with_given(solver: Solver, prescribed: PrescribedCoordinates, v: Array) -> Array:
    """Return the rates (nv, n, N) per prescribed coordinate, including prescribed freedoms and their followers."""
    found = np.array(v, subok=True)
    for k, column in enumerate(prescribed.columns):
        for moved, by in solver.equations.couplings.moving_with(column):
            found[moved, k] += by
    return found
