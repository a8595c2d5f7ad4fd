"""Motions through waypoints: splines of minimum jerk, and trapezoidal velocity profiles; both start and end at rest."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from kinetostatics.math.arrays import Array

#: Values, velocities and accelerations (c, N) of c coordinates.
Profile: TypeAlias = tuple[Array, Array, Array]


def _powers(tau: Array, order: int) -> Array:
    """Return the derivative (6, N) of this order of 1, τ, …, τ⁵ with respect to τ."""
    return np.array([math.perm(j, order) * tau ** max(j - order, 0) for j in range(6)])


#: Coefficients (6, 6) of the quintic with given values and first two derivatives at τ = 0 and 1.
_QUINTIC = np.linalg.inv([_powers(np.array(end), order) for end in (0.0, 1.0) for order in range(3)])


def minimum_jerk(times: Array, points: Array, at: Array) -> Profile:
    """Return the motion through ``points`` (c, n) at ``times`` (n,) [s], with zero velocity and acceleration at the ends.

    The motion is the quintic spline with continuous fourth derivatives. It minimizes the integral of the squared jerk (T. Flash
    and N. Hogan, The coordination of arm movements, Journal of Neuroscience 5, 1985, for two and three points).

    Args:
        times: times of the points [s].
        points: points of c coordinates.
        at: (N,) times of the returned values [s].
    """
    steps, n = np.diff(times), len(times)
    sizes = np.tile(np.stack([np.ones(n - 1), steps, steps**2], axis=1), 2)
    jumps = np.zeros((2 * (n - 2), 3 * n))  # of the third and fourth derivative at inner points, per state of all points
    for k in range(n - 2):
        for row, order in enumerate((3, 4)):
            for side, start, sign in ((1.0, k, 1.0), (0.0, k + 1, -1.0)):
                part = _powers(np.array(side), order) @ _QUINTIC * sizes[start] * (steps[k] / steps[start]) ** order
                jumps[2 * k + row, 3 * start : 3 * start + 6] += sign * part
    unknown = [3 * k + order for k in range(1, n - 1) for order in (1, 2)]
    states = np.zeros((3 * n, len(points)))
    states[::3] = points.T
    states[unknown] = -np.linalg.solve(jumps[:, unknown], jumps[:, ::3] @ points.T)
    part = _part(times, at)
    ends = np.stack([states[3 * part + k] * sizes[part, k, None] for k in range(6)])
    tau, step = (at - times[part]) / steps[part], steps[part]
    value, velocity, acceleration = (
        np.einsum("pN,pk,kNc->cN", _powers(tau, order), _QUINTIC, ends) / step**order for order in range(3)
    )
    return value, velocity, acceleration


def trapezoid_times(points: Array, speed: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return the times (n,) [s] of the points, and the largest velocities [1/s] and accelerations [1/s²] (n − 1,) on each line.

    These are time derivatives of the travelled fraction of the line, 0 to 1. All coordinates reach a point at the same time, and
    at least one of them reaches a limit.

    Args:
        points: (c, n) points at which the motion stops; successive points differ.
        speed, acceleration: (c,) limits of velocity and acceleration of each coordinate.
    """
    travel = np.abs(np.diff(points, axis=1))
    with np.errstate(divide="ignore"):
        fastest = np.min(speed[:, None] / travel, axis=0)
        steepest = np.min(acceleration[:, None] / travel, axis=0)
    fastest = np.minimum(fastest, np.sqrt(steepest))  # a triangle, where the speed is not reached
    return np.concatenate([[0.0], np.cumsum(1 / fastest + fastest / steepest)]), fastest, steepest


def trapezoids(points: Array, speed: Array, acceleration: Array, at: Array) -> Profile:
    """Return the motion along straight lines with trapezoidal velocity profiles; see :func:`trapezoid_times`."""
    times, fastest, steepest = trapezoid_times(points, speed, acceleration)
    part = _part(times, at)
    rate, rise, since, left = fastest[part], steepest[part], at - times[part], times[part + 1] - at
    ramp = rate / rise
    where = [since < ramp, left <= ramp]
    s = np.select(where, [rise * since**2 / 2, 1 - rise * left**2 / 2], rate * (since - ramp / 2))
    v, a = np.select(where, [rise * since, rise * left], rate), np.select(where, [rise, -rise], 0.0)
    start, travel = points[:, part], np.diff(points, axis=1)[:, part]
    return start + travel * s, travel * v, travel * a


def _part(times: Array, at: Array) -> Array:
    """Return the index of the interval of ``times`` (n,) that contains each instant of ``at`` (N,)."""
    return np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
