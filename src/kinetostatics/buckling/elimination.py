"""Positive definiteness of sparse symmetric matrices, by frontal elimination.

Coordinates that are coupled with the same others are eliminated together, those with fewest others first (A. George and J. W.
Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981). The batch axis is last.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from kinetostatics.math.arrays import Array, Mask

#: Indices of coordinates that are eliminated together, and of the remaining coordinates coupled with them.
Front = tuple[list[int], list[int]]


@lru_cache(maxsize=64)
def fronts(n: int, coupled: frozenset[tuple[int, ...]]) -> list[Front]:
    """Return the elimination order of n coordinates; ``coupled`` are the sets of coordinates with common matrix entries."""
    alike: dict[frozenset[tuple[int, ...]], list[int]] = {}
    for k in range(n):
        alike.setdefault(frozenset(some for some in coupled if k in some), []).append(k)
    groups = list(alike.values())
    near = {k: {j for j, theirs in enumerate(alike) if j != k and mine & theirs} for k, mine in enumerate(alike)}
    found = []
    while near:
        k = min(near, key=lambda k: (sum(len(groups[j]) for j in near[k]), k))
        others = near.pop(k)
        for j in others:
            near[j] = (near[j] | others) - {j, k}
        found.append((groups[k], [column for j in sorted(others) for column in groups[j]]))
    return found


def definite_in_order(matrix: Array, order: list[Front]) -> Mask:
    """Return the mask (N,) of positive definite matrices (n, n, N), which are overwritten."""
    found: Mask = np.ones(matrix.shape[2], dtype=bool)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for own, others in order:
            front, p = matrix[np.ix_(own + others, own + others)], len(own)
            for k in range(p):
                if k:
                    front[k:, k] -= np.einsum("ikn,kn->in", front[k:, :k], front[k, :k])
                found &= front[k, k] > 0
                front[k:, k] /= np.sqrt(front[k, k])
            if others:
                rest = front[p:, :p]
                matrix[np.ix_(others, others)] = front[p:, p:] - np.einsum("ikn,jkn->ijn", rest, rest)
    return found
