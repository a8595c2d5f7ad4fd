"""Statics of a limb with several cut joints by the force method.

The unknowns are the wrenches X of all cut joints (:mod:`kinetostatics.mechanism.limbs`). Every passive freedom gives one row of
A X = −d, with the power d of the weights on it. The solutions are X = X_0 + N y. The platform's wrench w on the limb is P X, the
sum over the cut joints at the platform. The limb transmits the wrenches in the range of P N; solutions of P N y = 0 are
self-stress (method page, section 9; S. P. Timoshenko and D. H. Young, *Theory of Structures*, chapter on the force method).

The pivots of the elimination are chosen once, at generic poses. Arrays are ``(…, limb, pose)``; the caller scales lengths so that
forces and moments are comparable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.linalg import canonical_basis, first_largest, numerical_rank

#: Smallest accepted pivot; otherwise the pose is solved by singular values.
_SMALL_PIVOT = 1e-6
#: Smallest pivot for which an elimination order of one limb is used for another.
_GOOD_PIVOT = 1e-3


@dataclass(frozen=True)
class EliminationOrder:
    """Pivots (row, column) of the elimination, chosen once per limb.

    Attributes:
        joints: pivots in the equilibrium equations of the passive joints.
        platform: pivots in the six sums of the cut-joint wrenches at the platform.
        free: columns without a pivot, whose values are the amounts of self-stress.
    """

    joints: tuple[tuple[int, int], ...]
    platform: tuple[tuple[int, int], ...]
    free: tuple[int, ...]


@dataclass(frozen=True)
class Distribution:
    """Solutions X (n, …) in equilibrium with a limb's passive joints.

    Attributes:
        particular: (n, …) X_0, in equilibrium with the weights.
        spread: (n, 6, …) cut-joint wrenches per unit of the platform's wrench on the limb, for wrenches that it can transmit.
        self_stress: (n, s, …) cut-joint wrenches without resultant on the platform.
        allowed: (6, 6 − n_c, …) twists of the platform that the limb permits: reciprocal to all wrenches that it transmits.
        doubtful: (…) True where a pivot is too small, so that ranks may differ from the ranks at generic poses.
    """

    particular: Array
    spread: Array
    self_stress: Array
    allowed: Array
    doubtful: Mask


def elimination_order(A: Array, P: Array, tolerance: float) -> EliminationOrder:
    """Choose pivots at generic poses, for the joints' equations A (k, n, poses) and the platform's sums P (6, n)."""
    k = A.shape[0]
    rank, platform_rank = ranks(A, P, tolerance)
    M = _stacked(A, P)
    joints = _pivots(M, range(k), rank, [])
    platform = _pivots(M, range(k, k + 6), platform_rank, [column for _, column in joints])
    used = {column for _, column in (*joints, *platform)}
    return EliminationOrder(tuple(joints), tuple(platform), tuple(column for column in range(A.shape[1]) if column not in used))


def suits(elimination: EliminationOrder, A: Array, P: Array, tolerance: float) -> bool:
    """Whether the elimination order of one limb can be used for another limb with A (k, n, poses) at the same generic poses."""
    if ranks(A, P, tolerance) != (len(elimination.joints), len(elimination.platform)):
        return False
    M = _stacked(A, P)
    return float(np.min(_eliminate(M, (*elimination.joints, *elimination.platform)), initial=1.0)) > _GOOD_PIVOT


def distribute(elimination: EliminationOrder, A: Array, nonzero: Mask, P: Array, demand: Array) -> Distribution:
    """Solve A X = −demand, P X = w for every wrench w that the limb can transmit.

    Args:
        A: (k, n, g, N) the joints' equations.
        nonzero: (k, n) True for coefficients of A that may differ from zero.
        P: (6, n) sums over the platform's cut joints.
        demand: (k, g, N) power of the weights on the passive freedoms.
    """
    (k, n), batch = A.shape[:2], A.shape[2:]
    M = zeros_for((k + 6, n + 7, *batch), A, demand)
    M[:k, :n], M[:k, n] = A, -demand
    M[k:, :n] = P.reshape(6, n, *(1,) * len(batch))
    M[range(k, k + 6), range(n + 1, n + 7)] = 1
    pattern = np.zeros((k + 6, n + 7), dtype=bool)
    pattern[:k, :n], pattern[:k, n], pattern[k:, :n] = nonzero, True, P != 0
    pattern[range(k, k + 6), range(n + 1, n + 7)] = True
    smallest = _eliminate(M, elimination.joints, pattern)
    M[k:, n], pattern[k:, n] = 0, False  # the free columns of the particular solution are zero
    smallest = np.minimum(smallest, _eliminate(M, elimination.platform, pattern))
    pivots = (*elimination.joints, *elimination.platform)
    rows, columns = [row for row, _ in pivots], [column for _, column in pivots]
    solved = zeros_for((n, 7, *batch), M)
    solved[columns] = M[rows, n:]
    self_stress = zeros_for((n, len(elimination.free), *batch), M)
    self_stress[columns] = -M[np.ix_(rows, elimination.free)]
    self_stress[list(elimination.free), range(len(elimination.free))] = 1
    taken = {row for row, _ in elimination.platform}
    allowed = M[[row for row in range(k, k + 6) if row not in taken], n + 1 :].swapaxes(0, 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        allowed = allowed / np.sqrt(np.sum(allowed * allowed, axis=0))
    bad = ~(smallest > _SMALL_PIVOT)
    result = Distribution(solved[:, 0], solved[:, 1:], self_stress, allowed, bad)
    for limb, pose in np.argwhere(bad).tolist():
        _by_singular_values(elimination, limb, pose, A, P, demand, result)
    return result


def remainder(elimination: EliminationOrder, A: Array, demand: Array, particular: Array) -> Array:
    """Return the part of the demand (k, g, N) that no cut-joint wrenches balance; it is orthogonal to the columns of A.

    For inconsistent equations, the residual of the ``particular`` solution (n, g, N) depends on the pivots; this part does not.
    """
    left = demand + np.einsum("kn...,n...->k...", A, particular)
    where = np.max(np.abs(left), axis=0, initial=0.0) > 1e-10 * np.max(np.abs(demand), axis=0, initial=0.0)
    where &= np.all(np.isfinite(A), axis=(0, 1))
    if np.any(where):
        images = np.linalg.svd(np.moveaxis(A[..., where], 2, 0), full_matrices=False)[0][:, :, : len(elimination.joints)]
        target = demand[:, where].T[..., None]
        left[:, where] = (target - images @ (np.swapaxes(images, 1, 2) @ target))[..., 0].T
    return left


def _eliminate(M: Array, pivots: tuple[tuple[int, int], ...], nonzero: Mask | None = None) -> Array:
    """Eliminate columns of M in place (Gauss–Jordan) and return the smallest absolute pivot (…); pivot columns are not cleared.

    ``nonzero`` is True for entries of M that may differ from zero, and is updated in place; None: all entries.
    """
    nonzero = np.ones(M.shape[:2], dtype=bool) if nonzero is None else nonzero
    smallest = np.full(M.shape[2:], np.inf)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for row, column in pivots:
            pivot = M[row, column]
            smallest = np.minimum(smallest, np.abs(pivot))
            others = [int(other) for other in np.flatnonzero(nonzero[:, column]) if other != row]
            nonzero[:, column] = False
            runs = _runs(nonzero[row])
            for run in runs:
                M[row, run] /= pivot
            for other in others:
                for run in runs:
                    M[other, run] -= M[other, column] * M[row, run]
            nonzero[others] |= nonzero[row]
    return smallest


def _runs(mask: Mask) -> list[slice]:
    """Return slices of the consecutive true entries of a mask."""
    ends = np.flatnonzero(np.diff(mask, prepend=False, append=False))
    return [slice(first, last) for first, last in ends.reshape(-1, 2).tolist()]


def _pivots(M: Array, rows: range, count: int, used: list[int]) -> list[tuple[int, int]]:
    """Choose pivots one by one, the largest over all generic poses, and eliminate their columns from M (rows, n, poses)."""
    chosen: list[tuple[int, int]] = []
    for _ in range(count):
        free_rows = [row for row in rows if row not in {r for r, _ in chosen}]
        free = [column for column in range(M.shape[1]) if column not in {*used, *(c for _, c in chosen)}]
        sizes = np.min(np.abs(M[np.ix_(free_rows, free)]), axis=2)
        row, column = np.unravel_index(first_largest(sizes.ravel()), sizes.shape)
        pivot = (free_rows[int(row)], free[int(column)])
        _eliminate(M, (pivot,))
        chosen.append(pivot)
    return chosen


def _by_singular_values(
    elimination: EliminationOrder, limb: int, pose: int, A: Array, P: Array, demand: Array, result: Distribution
) -> None:
    """Write the solution by singular values, for one limb at a pose with failed pivots, into ``result``.

    X_0 = −A⁺ d, N spans the null space of A, the spread is N (P N)⁺, and self-stress is N times the null space of P N.
    """
    one = A[..., limb, pose]
    if not np.all(np.isfinite(one)):
        return
    rank, platform_rank = len(elimination.joints), len(elimination.platform)
    U, values, V = np.linalg.svd(one, full_matrices=True)
    inverse = np.where(values[:rank] > 0, 1 / np.maximum(values[:rank], 1e-300), 0.0)
    N = canonical_basis(V[rank:].T)
    left, platform_values, right = np.linalg.svd(P @ N, full_matrices=True)
    back = np.where(platform_values[:platform_rank] > 0, 1 / np.maximum(platform_values[:platform_rank], 1e-300), 0.0)
    result.particular[..., limb, pose] = -V[:rank].T @ (inverse * (U[:, :rank].T @ demand[..., limb, pose]))
    result.spread[..., limb, pose] = N @ (right[:platform_rank].T * back) @ left[:, :platform_rank].T
    result.self_stress[..., limb, pose] = N @ canonical_basis(right[platform_rank:].T)
    result.allowed[..., limb, pose] = canonical_basis(left[:, platform_rank:])


def ranks(A: Array, P: Array, tolerance: float) -> tuple[int, int]:
    """Return the rank of the joints' equations, and the number of independent wrenches transmitted to the platform."""
    poses = range(A.shape[2])
    rank = max((numerical_rank(A[:, :, p], tolerance)[0] for p in poses), default=0)
    return rank, max((numerical_rank(P @ _null(A[:, :, p], rank), tolerance)[0] for p in poses), default=0)


def _stacked(A: Array, P: Array) -> Array:
    return np.concatenate([A, np.broadcast_to(P[:, :, None], (6, *A.shape[1:]))])


def _null(matrix: Array, rank: int) -> Array:
    """Return an orthonormal basis of the null space (n, n − rank)."""
    if not matrix.shape[0]:
        return np.eye(matrix.shape[1])
    return canonical_basis(np.linalg.svd(matrix, full_matrices=True)[2][rank:].T)
