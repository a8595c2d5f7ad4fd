"""One straight elastic beam, clamped at both ends, under a load that varies linearly along it.

In beam axes as :mod:`kinetostatics.limbs.beam_formulas`. A load (12, …) is the force and moment per length at the base end, then
at the platform end [N/m, N]; wrenches are about the point at which they act.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.limbs.beam_formulas import end_displacement, section_wrench
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import solve_by_elimination

_GAUSS = np.polynomial.legendre.leggauss(4)


def outboard_wrench(length: Array, load: Array, s: Array) -> Array:
    """Return the wrench (6, …) about the section at ``s`` [m] of the load between it and the platform end."""
    first, last, left = load[:6], load[6:], length - s
    here = first + (last - first) * (s / length)
    found = np.array((here + last) * left / 2)
    moment = (here[:3] / 6 + last[:3] / 3) * left**2  # e_x × ∫ (σ − s) q dσ
    found[4] -= moment[2]
    found[5] += moment[1]
    return found


def clamped_reaction(c: Array, length: Array, load: Array) -> Array:
    """Return the wrench (6, …) of the clamp on the platform end.

    Args:
        c: (6, …) section compliances.
        length: (…) length [m].
        load: (12, …) force and moment per length at both ends [N/m, N].
    """
    free = _displacement(c, length, load, np.zeros_like(load[:6]), length)
    units = np.broadcast_to(np.eye(6).reshape(6, 6, *(1,) * (load.ndim - 1)), (6, *free.shape))
    compliance = end_displacement(c[:, None], length, units).reshape(6, 6, -1)
    return -solve_by_elimination(compliance, free.reshape(6, 1, -1)).reshape(free.shape)


def clamped_line(c: Array, length: Array, load: Array, s: Array) -> Array:
    """Return displacement and rotation (6, …) of the section at ``s`` [m]."""
    return _displacement(c, length, load, clamped_reaction(c, length, load), s)


def clamped_section_wrench(c: Array, length: Array, load: Array, s: Array) -> Array:
    """Return the section wrenches (6, …) at ``s``, of the outboard on the inboard part, about the section's centre."""
    return _section(length, load, clamped_reaction(c, length, load), s)


def _section(length: Array, load: Array, reaction: Array, s: Array) -> Array:
    none = np.zeros((6, *(1,) * (load.ndim - 1)))
    return section_wrench(length, reaction, none, s) + outboard_wrench(length, load, s)


def _displacement(c: Array, length: Array, load: Array, reaction: Array, s: Array) -> Array:
    """Return the twists (6, …) of the section at ``s`` of a beam clamped at its base end, by quadrature (exact: degree 4)."""
    found = np.zeros(np.broadcast_shapes(load[:6].shape, s.shape))
    for point, weight in zip(*_GAUSS, strict=True):
        place = s * (1 + point) / 2
        strain = c * _section(length, load, reaction, place) * (weight * s / 2)
        found += strain
        found[1] += (s - place) * strain[5]
        found[2] -= (s - place) * strain[4]
    return found
