"""Whether the determinants of two matrices have one sign, also of matrices with more rows than columns."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array, Mask

#: Determinants of GᵀG below this part of the product of the squared columns tell nothing.
SINGULAR = 1e-14
#: Pivots above this part of the columns' sizes leave no doubt.
_SURE = 1e-8


def have_one_sign(one: Array, two: Array) -> Mask:
    """Return where (N,) the determinants of matrices G (n, n, N) have one sign, or one tells nothing.

    Of matrices (m, n, N) with more rows, it is where that of G₁ᵀ G₂ is positive.
    """
    first, second = np.moveaxis(one, 2, 0), np.moveaxis(two, 2, 0)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        sign, _ = np.linalg.slogdet(np.swapaxes(first, 1, 2) @ second)
        regular = [
            np.linalg.slogdet(np.swapaxes(g, 1, 2) @ g)[1] - np.sum(np.log(np.sum(g * g, axis=1)), axis=1)
            for g in (first, second)
        ]
    found: Mask = (sign > 0) | ~(np.minimum(*regular) > np.log(SINGULAR))
    return found


def surely_have_one_sign(one: Array, two: Array) -> Mask:
    """Return where (N,) :func:`have_one_sign` holds beyond doubt: G₁ᵀ G₂ is eliminated without a small or negative pivot."""
    rest = np.einsum("ia...,ib...->ab...", one, two)
    least = _SURE * np.sqrt(np.sum(one * one, axis=0) * np.sum(two * two, axis=0))
    sure: Mask = np.ones(one.shape[2], dtype=bool)
    for k in range(least.shape[0]):
        sure = sure & (rest[0, 0] > least[k])
        rest = rest[1:, 1:] - rest[1:, :1] / rest[0, 0] * rest[:1, 1:]
    return sure
