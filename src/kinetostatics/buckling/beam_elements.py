"""Bending stiffness and geometric stiffness of a straight beam by polynomial shape functions.

The deflection v(s) relative to the start is a cubic polynomial, given by the deflection of the end and both slopes, plus five
polynomials whose values and slopes vanish at both ends. The strain energy ∫ EI v″² ds / 2 gives the first matrix, the energy ∫ N
v′² ds / 2 of a linearly varying axial force N the second (S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability, chapter
2). Shear deformation is neglected.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array

#: Number of polynomials whose values and slopes vanish at both ends; relative error of Euler's loads below 2e-6.
INNER = 5


def _functions() -> list[np.polynomial.Polynomial]:
    """Return the three cubic polynomials on 0 … 1, and the inner polynomials, which vanish with their slopes at both ends.

    The inner polynomials are orthonormal in ∫ f″g″, and orthogonal to the cubic polynomials.
    """
    P = np.polynomial.Polynomial
    s = P([0, 1])
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=P) for k in range(INNER)]
    inner = [16 * s**2 * (1 - s) ** 2 * item for item in legendre]
    bend = np.array([f.deriv(2)(POINTS) for f in inner])
    basis = np.linalg.inv(np.linalg.cholesky(np.einsum("q,iq,jq->ij", WEIGHTS, bend, bend)))
    orthonormal = [sum((factor * f for factor, f in zip(row, inner, strict=True)), P([0])) for row in basis]
    return [P([0, 0, 3, -2]), P([0, 1, -2, 1]), P([0, 0, -1, 1]), *orthonormal]


#: Points and weights of Gauss's quadrature on 0 … 1.
POINTS, WEIGHTS = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2
_FUNCTIONS = _functions()
_BEND = np.array([f.deriv(2)(POINTS) for f in _FUNCTIONS[:3]])
_SLOPE = np.array([f.deriv()(POINTS) for f in _FUNCTIONS])
#: ∫ f″f″ (3, 3) of the cubic polynomials, and ∫ f′f′ and ∫ s f′f′ (2, 8, 8) of all.
_BENDING = np.einsum("q,iq,jq->ij", WEIGHTS, _BEND, _BEND)
_TENSION = np.einsum("kq,iq,jq->kij", [WEIGHTS, WEIGHTS * POINTS], _SLOPE, _SLOPE)
#: Largest eigenvalue of the inner part of ∫ f′f′: 1 / 4π².
_CLAMPED = float(np.linalg.eigvalsh(_TENSION[0, 3:, 3:])[-1])
_A, _B = _TENSION[:, :3, 3:]
#: Matrices of :func:`condensed_tension`: factors of the force at the start, its change, and the squares and product of both.
_CONDENSED = np.array([*_TENSION[:, :3, :3], -_A @ _A.T, -_A @ _B.T - _B @ _A.T, -_B @ _B.T])


def bending(EI: float, length: Array) -> Array:
    """Return the bending stiffness (3, 3, N) [N/m] of beams with bending stiffness EI [N·m²] and length (N,) [m].

    The coordinates are the deflection of the end, and the slopes of start and end multiplied by the length [m].
    """
    return np.asarray(_BENDING[:, :, None] * (EI / length**3))


def tension(forces: Array, EI: float, length: Array) -> Array:
    """Return the geometric stiffness (8, 8, N) of axial forces (2, N) [N] at start and end, tension positive.

    The first three coordinates are the coordinates of :func:`bending`. The others are inner coordinates, the amplitudes of the
    inner polynomials, scaled to a bending stiffness of 1.
    """
    first, last = forces / length
    scale = np.ones((3 + INNER, len(length)))
    scale[3:] = np.sqrt(length**3 / EI)
    return np.asarray((first * _TENSION[0, :, :, None] + (last - first) * _TENSION[1, :, :, None]) * scale[:, None] * scale)


def condensed_tension(forces: Array, EI: float, length: Array) -> Array:
    """Return a lower bound (3, 3, N) of the matrix of :func:`tension` with the inner coordinates eliminated.

    The sum of bending and geometric stiffness of the inner coordinates is at least 1 − β, with the ratio β of the larger
    compressive end force to the critical force of a beam clamped at both ends. The bound is NaN for β ≥ 1.
    """
    first, last = forces / length
    least = 1 - np.maximum(-forces.min(axis=0), 0.0) * length**2 / EI * _CLAMPED  # 1 − β
    flexibility = length**3 / EI / np.where(least > 0, least, np.nan)
    change = last - first
    factors = np.stack([first, change, flexibility * first**2, flexibility * first * change, flexibility * change**2])
    return np.asarray((_CONDENSED.reshape(5, 9).T @ factors).reshape(3, 3, -1))


def deflection(s: Array, moved: Array, inner: Array, EI: float, length: Array) -> tuple[Array, Array]:
    """Return the deflections relative to the start [m], and the slopes, at fractions s (S,) of the length: (S, N, …) each.

    Args:
        s: from 0 at the start to 1 at the end.
        moved: (3, N, …) coordinates of :func:`bending`.
        inner: (INNER, N, …) inner coordinates of :func:`tension`.
        EI, length: see :func:`bending`.
    """
    L = length.reshape(-1, *(1,) * (moved.ndim - 2))
    coordinates = np.concatenate([moved, inner * np.sqrt(L**3 / EI)])
    values, slopes = (np.array([f(s) for f in given]) for given in (_FUNCTIONS, [f.deriv() for f in _FUNCTIONS]))
    return np.tensordot(values, coordinates, (0, 0)), np.tensordot(slopes, coordinates, (0, 0)) / L
