"""Euler's buckling load of straight members made of beams in a row, by polynomials along each beam.

The deflections v along y and w along z of a beam are cubic polynomials of its end values and slopes, and six polynomials that
vanish there with their slopes. The critical factor λ of the axial forces N (tension positive) solves ∫ (v″² EI_z + w″² EI_y) ds
+ λ ∫ N (v′² + w′²) ds = 0 (S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability, chapter 2). No shear deformation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array

_BUBBLES = 6
#: Parts of stiffnesses and projectors that are rounding.
_LEVEL = 1e-12
#: Members of so many poses at a time.
_CHUNK = 1000


def _matrices() -> tuple[Array, Array]:
    """Return ∫ f″f″ (10, 10), and ∫ f′f′ and ∫ s f′f′ (2, 10, 10) of the polynomials on 0 … 1."""
    P = np.polynomial.Polynomial
    s = P([0, 1])
    hermite = [P([1, 0, -3, 2]), P([0, 1, -2, 1]), P([0, 0, 3, -2]), P([0, 0, -1, 1])]
    bubble = s**2 * (1 - s) ** 2
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=P) for k in range(_BUBBLES)]
    functions = [*hermite, *(16 * bubble * item for item in legendre)]
    points, weights = np.polynomial.legendre.leggauss(12)
    points, weights = (points + 1) / 2, weights / 2
    bend = np.array([f.deriv(2)(points) for f in functions])
    slope = np.array([f.deriv()(points) for f in functions])
    powers = np.array([weights, weights * points])
    return np.einsum("q,iq,jq->ij", weights, bend, bend), np.einsum("kq,iq,jq->kij", powers, slope, slope)


_BENDING, _TENSION = _matrices()


@dataclass(frozen=True)
class Ends:
    """How the two ends of a member are held across it, at M poses: first the base end, then the platform end.

    Attributes:
        shifts: (2, M, 2, 2) projectors on the directions (y, z) in which the ends may move.
        turns: (2, M, 2, 2) projectors on the axes (y, z) about which they may turn.
    """

    shifts: Array
    turns: Array


def buckling_ratio(lengths: Array, stiffness: Array, forces: Array, ends: Ends) -> Array:
    """Return by how much the axial forces are those at which a member buckles (M,): 1 at buckling, 0 under tension alone.

    Args:
        lengths: (M, n) of its beams [m].
        stiffness: (n, 2, 2) bending stiffness of the deflections along y and z [N·m²].
        forces: (M, n, 2) axial forces at both ends of the beams, tension positive [N].
        ends: how it is held.
    """
    swap = np.array([[0.0, 1.0], [-1.0, 0.0]])  # turning (θ_y, θ_z) makes the slopes (θ_z, −θ_y)
    held = np.stack([ends.shifts, swap @ ends.turns @ swap.T])
    ranks = np.rint(np.trace(held, axis1=3, axis2=4)).astype(int)  # (2, 2, M)
    alike = np.ravel_multi_index(tuple(ranks.reshape(4, -1)), (3, 3, 3, 3))
    result = np.zeros(len(lengths))
    for kind in np.unique(alike):
        poses = np.flatnonzero(alike == kind)
        for start in range(0, len(poses), _CHUNK):
            which = poses[start : start + _CHUNK]
            mine = held[:, :, which]
            ratios = [
                _ratio(lengths[which], stiffness[:, p, p], forces[which], mine[..., p, p]) for p in _planes(stiffness, mine)
            ]
            result[which] = np.max(ratios, axis=0)
    return result


def _planes(stiffness: Array, held: Array) -> list[slice]:
    """Return the planes that are to be looked at: both at once, each by itself, or one where both are alike."""
    if any(np.any(np.abs(item[..., 0, 1]) > _LEVEL * np.abs(item).max()) for item in (stiffness, held)):
        return [slice(0, 2)]
    alike = all(np.allclose(item[..., 0, 0], item[..., 1, 1], rtol=_LEVEL, atol=_LEVEL) for item in (stiffness, held))
    return [slice(0, 1)] if alike else [slice(0, 1), slice(1, 2)]


def _ratio(lengths: Array, stiffness: Array, forces: Array, held: Array) -> Array:
    (M, n), D = lengths.shape, stiffness.shape[1]
    whole, bend = lengths.sum(axis=1), float(np.max(np.trace(stiffness, axis1=1, axis2=2)))
    parts = lengths / whole[:, None]
    pushes = forces * (whole**2 / bend)[:, None, None]
    nodes, size = 2 * D * (n + 1), 2 * D * (n + 1) + D * n * _BUBBLES
    K, G = np.zeros((2, M, size, size))
    every = np.arange(M)
    for k in range(n):
        # deflections and slopes (over the whole length) at both nodes, then what is inside, for each direction
        ends = 2 * D * k + D * np.arange(4) + np.arange(D)[:, None]
        inside = nodes + D * _BUBBLES * k + np.arange(D * _BUBBLES).reshape(D, -1)
        at = np.concatenate([ends, inside], axis=1)
        L = parts[:, k, None]
        scale = np.concatenate([np.ones_like(L), L, np.ones_like(L), L, np.ones((M, _BUBBLES))], axis=1)
        both = scale[:, :, None] * scale[:, None]
        bending = _BENDING * both / L[:, :, None] ** 3
        first, last = pushes[:, k, 0, None, None], pushes[:, k, 1, None, None]
        tension = (first * _TENSION[0] + (last - first) * _TENSION[1]) * both / L[:, :, None]
        for i in range(D):
            G[np.ix_(every, at[i], at[i])] += tension
            for j in range(D):
                K[np.ix_(every, at[i], at[j])] += stiffness[k, i, j] / bend * bending
    free = np.ones(size, dtype=bool)
    for end, first_place in ((0, 0), (1, 2 * D * n)):
        for kind in (0, 1):
            place = slice(first_place + D * kind, first_place + D * (kind + 1))
            allowed = held[kind, end]
            rank = round(float(np.trace(allowed[0])))
            if rank == 1 and D == 2:  # its own axes: along what is allowed, and across
                best = np.argmax(np.diagonal(allowed, axis1=1, axis2=2), axis=1)
                along = allowed[every, :, best]
                along = along / np.linalg.norm(along, axis=1, keepdims=True)
                turn = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)
                for matrix in (K, G):
                    matrix[:, place] = turn @ matrix[:, place]
                    matrix[:, :, place] = matrix[:, :, place] @ np.swapaxes(turn, 1, 2)
            free[place.start + rank : place.stop] = False
    K, G = K[:, free][:, :, free], G[:, free][:, :, free]
    factor = np.linalg.cholesky(K)
    half = np.linalg.solve(factor, -G)
    values = np.linalg.eigvalsh(np.linalg.solve(factor, np.swapaxes(half, 1, 2)))
    return np.maximum(values[:, -1], 0.0)
