"""Bending stiffness and geometric stiffness of a straight beam by polynomial shape functions.

The deflection v(s) relative to the start is the cubic polynomial of the end's deflection and both slopes, plus five polynomials
that vanish with their slopes at both ends. The matrices are those of the strain energy ∫ EI v″² ds / 2 and of the work of a
linearly varying axial force, ∫ N v′² ds / 2 (S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability, chapter 2). Shear
deformation is neglected.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array

#: Polynomials that vanish at both ends with their slopes: Euler's loads come out to better than 2e-6.
INNER = 5


def _matrices() -> tuple[Array, Array]:
    """Return ∫ f″f″ (3, 3) of the cubic polynomials on 0 … 1, and ∫ f′f′ and ∫ s f′f′ (2, 8, 8) of all.

    The inner ones are orthonormal in ∫ f″f″; those of the cubic ones with them vanish.
    """
    P = np.polynomial.Polynomial
    s = P([0, 1])
    hermite = [P([0, 0, 3, -2]), P([0, 1, -2, 1]), P([0, 0, -1, 1])]
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=P) for k in range(INNER)]
    functions = [*hermite, *(16 * s**2 * (1 - s) ** 2 * item for item in legendre)]
    points, weights = np.polynomial.legendre.leggauss(12)
    points, weights = (points + 1) / 2, weights / 2
    bend = np.array([f.deriv(2)(points) for f in functions])
    slope = np.array([f.deriv()(points) for f in functions])
    K = np.einsum("q,iq,jq->ij", weights, bend, bend)
    basis = np.eye(3 + INNER)
    basis[3:, 3:] = np.linalg.inv(np.linalg.cholesky(K[3:, 3:])).T
    powers = np.array([weights, weights * points])
    return K[:3, :3], basis.T @ np.einsum("kq,iq,jq->kij", powers, slope, slope) @ basis


_BENDING, _TENSION = _matrices()
#: Largest eigenvalue of the inner part of ∫ f′f′: 1 / 4π².
_CLAMPED = float(np.linalg.eigvalsh(_TENSION[0, 3:, 3:])[-1])
_A, _B = _TENSION[:, :3, 3:]
#: Matrices of :func:`condensed_tension` for the force at the start, its change along the beam, their squares and product.
_CONDENSED = np.array([*_TENSION[:, :3, :3], -_A @ _A.T, -_A @ _B.T - _B @ _A.T, -_B @ _B.T])


def bending(EI: float, length: Array) -> Array:
    """Return the stiffness (3, 3, N) [N/m] on the deflection of the end, and the slopes of start and end times the length.

    Args:
        EI: bending stiffness [N·m²].
        length: (N,) [m].
    """
    return np.asarray(_BENDING[:, :, None] * (EI / length**3))


def tension(forces: Array, EI: float, length: Array) -> Array:
    """Return the geometric stiffness (8, 8, N) of axial forces (2, N) [N] at start and end, tension positive.

    The first three coordinates are those of :func:`bending`; the stiffness on the others is 1.
    """
    first, last = forces / length
    scale = np.ones((3 + INNER, len(length)))
    scale[3:] = np.sqrt(length**3 / EI)
    return np.asarray((first * _TENSION[0, :, :, None] + (last - first) * _TENSION[1, :, :, None]) * scale[:, None] * scale)


def condensed_tension(forces: Array, EI: float, length: Array) -> Array:
    """Return a lower bound (3, 3, N) of :func:`tension` plus the inner stiffness 1, for any inner coordinates.

    The inner stiffness is bounded by 1 − β, with β the ratio of the larger pressure to the critical one of a clamped beam; NaN
    for β ≥ 1.
    """
    first, last = forces / length
    held = 1 - np.maximum(-forces.min(axis=0), 0.0) * length**2 / EI * _CLAMPED
    held = length**3 / EI / np.where(held > 0, held, np.nan)
    change = last - first
    factors = np.stack([first, change, held * first**2, held * first * change, held * change**2])
    return np.asarray((_CONDENSED.reshape(5, 9).T @ factors).reshape(3, 3, -1))
