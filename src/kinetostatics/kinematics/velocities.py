"""Velocities of freedoms with closed loops, by the implicit function theorem."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver
from kinetostatics.math.arrays import Array, zeros_for

#: Part of a change that the loops cannot follow above which they stay open.
_OPEN = 1e-6


def freedom_rates(solver: Solver, prescribed: PrescribedCoordinates, gradient: Array, rates: Array, step: Array) -> Array:
    """Return how fast the freedoms move (nv, k, N) that are not given; NaN where residuals do not stay zero.

    Args:
        solver: of the loops.
        prescribed: what is given.
        gradient: (m, n, N) of the scaled residuals by scaled steps of what is free.
        rates: (m, k, N) how fast the residuals change by themselves.
        step: (n, k, N) the steps that undo that as well as possible.
    """
    left = np.max(np.abs(rates + np.einsum("mnN,nkN->mkN", gradient, step)), axis=0, initial=0.0)
    stays_open = left > _OPEN * np.max(np.abs(rates), axis=0, initial=0.0) + 1e-12
    free = solver.free_columns(prescribed)
    v = zeros_for((solver.tree.nv, *step.shape[1:]), step)
    v[free] = step[: free.size] * solver.column_scale[free, None, None]
    return np.where(stays_open, np.nan, v)


def with_given(solver: Solver, prescribed: PrescribedCoordinates, v: Array) -> Array:
    """Return the rates (nv, n, N) by each given coordinate, those of the freedoms that are given and of their followers too."""
    found = np.array(v, subok=True)
    for k, column in enumerate(prescribed.columns):
        for moved, by in solver.equations.couplings.moving_with(column):
            found[moved, k] += by
    return found
