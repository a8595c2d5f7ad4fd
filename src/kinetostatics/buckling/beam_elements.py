"""Stiffness and geometric stiffness of a straight beam across its axis, by polynomials.

A deflection v(s) is a cubic polynomial of the deflections and slopes of both ends, and five polynomials that vanish there with
their slopes. Of its strain energy ∫ EI v″² ds / 2 and of the work of an axial force that varies linearly, ∫ N v′² ds / 2
(S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability, chapter 2), these are the matrices. No shear deformation.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array

#: Polynomials that vanish at both ends with their slopes: Euler's loads come out to better than 2e-6.
INNER = 5


def _matrices() -> tuple[Array, Array]:
    """Return ∫ f″f″ (4, 4) of the cubic polynomials on 0 … 1, and ∫ f′f′ and ∫ s f′f′ (2, 9, 9) of all.

    The inner ones are orthonormal in ∫ f″f″; those of the cubic ones with them vanish.
    """
    P = np.polynomial.Polynomial
    s = P([0, 1])
    hermite = [P([1, 0, -3, 2]), P([0, 1, -2, 1]), P([0, 0, 3, -2]), P([0, 0, -1, 1])]
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=P) for k in range(INNER)]
    functions = [*hermite, *(16 * s**2 * (1 - s) ** 2 * item for item in legendre)]
    points, weights = np.polynomial.legendre.leggauss(12)
    points, weights = (points + 1) / 2, weights / 2
    bend = np.array([f.deriv(2)(points) for f in functions])
    slope = np.array([f.deriv()(points) for f in functions])
    K = np.einsum("q,iq,jq->ij", weights, bend, bend)
    basis = np.eye(4 + INNER)
    basis[4:, 4:] = np.linalg.inv(np.linalg.cholesky(K[4:, 4:])).T
    powers = np.array([weights, weights * points])
    return K[:4, :4], basis.T @ np.einsum("kq,iq,jq->kij", powers, slope, slope) @ basis


_BENDING, _TENSION = _matrices()


def bending(EI: float, length: Array) -> Array:
    """Return the stiffness (N, 4, 4) [N/m] on deflections, and slopes times the length, at both ends.

    Args:
        EI: bending stiffness [N·m²].
        length: (N,) [m].
    """
    return np.asarray(EI / length[:, None, None] ** 3 * _BENDING)


def tension(forces: Array, EI: float, length: Array) -> Array:
    """Return the geometric stiffness (N, 9, 9) of axial forces (2, N) [N] at start and end, tension positive.

    The first four coordinates are those of :func:`bending`; the stiffness on the others is 1.
    """
    first, last = (forces / length)[:, :, None, None]
    scale = np.ones((len(length), 4 + INNER))
    scale[:, 4:] = np.sqrt(length**3 / EI)[:, None]
    return np.asarray((first * _TENSION[0] + (last - first) * _TENSION[1]) * scale[:, :, None] * scale[:, None])
