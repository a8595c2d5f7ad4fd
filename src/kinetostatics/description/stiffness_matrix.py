"""Symmetric stiffness matrices (6, 6) of joints, in the order Fx Fy Fz Mx My Mz [N/m, N/rad, N·m/rad].

Infinity on the diagonal means a rigid direction, a row of zeros a free one; the other rows are elastic.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.description.fields import LARGEST, SMALLEST, Kind
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Index

_NAMES, _UPPER = ("Fx", "Fy", "Fz", "Mx", "My", "Mz"), np.triu_indices(6)
#: For a diagonal of ones: largest difference of symmetric entries, as of six digits, and smallest eigenvalue; factors of units.
_SYMMETRIC, _LEAST, _FACTORS = 1e-5, 1e-10, (1e3, 1e6, 1e9)


def full_matrix(upper: tuple[float, ...]) -> Array:
    """Return the matrix (6, 6) of the 21 numbers of its upper triangle, row by row."""
    matrix = np.zeros((6, 6))
    matrix[_UPPER] = matrix.T[_UPPER] = upper
    return matrix


def elastic_rows(matrix: Array) -> Index:
    return np.flatnonzero((np.diag(matrix) > 0) & (np.diag(matrix) < np.inf))


def is_coupled(matrix: Array) -> bool:
    return bool(np.any(matrix[~np.eye(len(matrix), dtype=bool)]))


def inverse_of_elastic(matrix: Array) -> Array:
    """Return the inverse (6, 6) of the elastic rows and columns of a matrix, 0 in the others."""
    rows = elastic_rows(matrix)
    scales = np.outer(*[np.sqrt(np.diag(matrix)[rows])] * 2)
    inverse, result = np.linalg.inv(matrix[np.ix_(rows, rows)] / scales), np.zeros((6, 6))
    result[np.ix_(rows, rows)] = (inverse + inverse.T) / 2 / scales
    return result


def _check(value: Keyword) -> tuple[float, ...]:
    try:
        given = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError("is no matrix of numbers") from None
    if given.shape not in ((21,), (36,), (6, 6)):
        raise ArgumentError(f"must be the 36 numbers of a matrix, or the 21 of its upper triangle, not {given.size}")
    K = full_matrix(tuple(given.tolist())) if given.size == 21 else given.reshape(6, 6)
    rows = elastic_rows(K)
    for i, j in np.ndindex(6, 6):
        right, entry = "", K[i, j]
        if not abs(entry) <= LARGEST and not (i == j and entry == np.inf):
            right = f"a number of at most {LARGEST:g}" + " or inf" * (i == j)
        elif i == j and (entry < 0 or 0 < entry < SMALLEST):
            right = f"zero or a number of at least {SMALLEST:g}"
        elif i != j and entry and not {i, j} <= set(rows):
            still = i if j in rows else j
            right = f"zero, because {_NAMES[still]} is {'rigid (inf)' if K[still, still] else 'free (zero)'},"
        if right:
            raise ArgumentError(f"has the entry {_named(K, i, j)}; {right} would be right")
    scaled = K[np.ix_(rows, rows)] / np.outer(*[np.sqrt(np.diag(K)[rows])] * 2)
    gaps = np.abs(scaled - scaled.T)
    if gaps.max(initial=0.0) > _SYMMETRIC:
        i, j = rows[list(np.unravel_index(gaps.argmax(), gaps.shape))]
        low, high = sorted((abs(K[i, j]), abs(K[j, i])))
        factor = next((f" (a factor of {f:g}, as between units)" for f in _FACTORS if abs(f * low - high) < 1e-3 * high), "")
        raise ArgumentError(f"is not symmetric: {_named(K, i, j)} and {_named(K, j, i)}{factor}; equal ones would be right")
    values, vectors = np.linalg.eigh(scaled)
    if values.min(initial=1.0) < _LEAST:
        coupling = np.abs(np.triu(scaled, 1))
        i, j = rows[list(np.unravel_index(coupling.argmax(), coupling.shape))]
        if (times := coupling.max()) < 1:
            most = _NAMES[rows[np.abs(vectors[:, 0]).argmax()]]
            raise ArgumentError(f"has no positive stiffness against a motion, most along {most} (eigenvalue {values[0]:.2g})")
        factor = next((f" (in other units, by a factor of {f:g}?)" for f in _FACTORS if f / 100 < times < f), "")
        right = f"less than {abs(K[i, j]) / times:.6g}, the root of the product of {_named(K, i, i)} and {_named(K, j, j)},"
        raise ArgumentError(f"is not positive: it has {_named(K, i, j)}{factor}; {right} would be right")
    return tuple(((K + K.T) / 2)[_UPPER].tolist())


def _named(matrix: Array, i: int, j: int) -> str:
    return f"{_NAMES[i]} {_NAMES[j]} = {matrix[i, j]:g}"


MATRIX = Kind("numbers", _check)
#: The 21 numbers of the upper triangle, row by row.
StiffnessMatrix = Annotated[tuple[float, ...], MATRIX]
