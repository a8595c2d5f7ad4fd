"""The largest von Mises stress of a section under section wrenches.

The square of the von Mises stress at a point is a quadratic form of the section wrench with 21 coefficients, one for each product
of two components, so that stresses for many points and wrenches are one matrix product.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

_FIRST, _SECOND = np.triu_indices(6)
#: Number of wrenches computed at a time, for the processor's cache.
_CHUNK = 1024
#: Initial angles on rings; the maximum is within half a step, where the square is at most 3.5 % larger.
_STEP = 2 * np.pi / 24
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_NEAR = 0.965
#: Differences of squares, relative to the largest, that count as rounding errors.
_LEVEL = 1e-11


def von_mises_forms(rows: Array) -> Array:
    """Return σ² + 3 (τ_1² + τ_2²) as quadratic forms (…, 21) of the wrench.

    Args:
        rows: (…, 3, 6) normal stress and both shear stresses under unit wrenches.
    """
    square = np.einsum("k,...ki,...kj->...ij", np.array([1.0, 3.0, 3.0]), rows, rows)
    return np.asarray(square[..., _FIRST, _SECOND] * np.where(_FIRST == _SECOND, 1, 2))


def largest_at_points(forms: Array, wrench: Array) -> Array:
    """Return the largest stress (…) at points with forms (P, 21) under wrenches (6, …)."""
    return _by_chunks(lambda products: (forms @ products).max(axis=0), wrench)


def largest_on_rings(forms: Array, wrench: Array) -> Array:
    """Return the largest stress (…) on rings, given at eight even angles (R, 8, 21) on each, under wrenches (6, …).

    Around a ring the square is a + b cos θ + c sin θ + d cos 2θ + e sin 2θ; its largest value is found by Newton's method.
    """
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    to_waves = _waves(angle) * np.array([1, 2, 2, 2, 2])[:, None] / 8
    coefficients = np.einsum("wa,rap->rwp", to_waves, forms)
    at_angles = _waves(_ANGLES)

    def largest(products: Array) -> Array:
        waves = coefficients @ products  # (R, 5, N)
        values = np.einsum("wa,rwn->arn", at_angles, waves)
        result = values.max(axis=(0, 1))
        above = values - np.roll(values, 1, axis=0) > _LEVEL * result
        peaks = above & ~np.roll(above, -1, axis=0) & (values > _NEAR * result)
        start, ring, which = np.nonzero(peaks)
        a, b, c, d, e = waves[ring, :, which].T
        best = _ANGLES[start]
        for _ in range(4):
            _, cos, sin, cos2, sin2 = _waves(best)
            slope = -b * sin + c * cos - 2 * d * sin2 + 2 * e * cos2
            bend = -b * cos - c * sin - 4 * d * cos2 - 4 * e * sin2
            best = best - np.clip(slope / np.where(bend < 0, bend, -np.inf), -_STEP, _STEP)
        np.maximum.at(result, which, np.sum(_waves(best) * np.array([a, b, c, d, e]), axis=0))
        return np.asarray(result)

    return _by_chunks(largest, wrench)


def unit_stresses(forms: Array) -> Array:
    """Return the largest stress (6,) of each component of a unit wrench alone, from the forms (…, 21) of all points."""
    return np.sqrt(forms[..., _FIRST == _SECOND].reshape(-1, 6).max(axis=0))


def may_be_largest(units: Array, wrench: Array) -> NDArray[np.bool_]:
    """Return the mask (n, …) of the sections of a beam that may be the most stressed one.

    Args:
        units: (6,) largest stresses under unit wrenches; those of axial force and bending occur at one point and add up.
        wrench: (6, n, …) section wrenches.
    """
    alone = units.reshape(6, *[1] * (wrench.ndim - 1)) * np.abs(wrench)
    normal, shear = (alone[0] + alone[4] + alone[5]) ** 2, alone[1:4]
    at_least = np.maximum(normal, (shear**2).max(axis=0)).max(axis=0)
    return np.asarray(normal + shear.sum(axis=0) ** 2 >= (1 - 1e-9) * at_least)


def _waves(angle: Array) -> Array:
    return np.array([np.ones_like(angle), np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)])


def _by_chunks(largest: Callable[[Array], Array], wrench: Array) -> Array:
    flat = np.asarray(wrench, dtype=float).reshape(6, -1)
    found = np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], _CHUNK):
        part = flat[:, start : start + _CHUNK]
        found[start : start + _CHUNK] = largest(part[_FIRST] * part[_SECOND])
    return np.sqrt(np.maximum(found, 0)).reshape(np.shape(wrench)[1:])
