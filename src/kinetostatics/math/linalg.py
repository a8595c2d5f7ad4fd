"""Linear algebra of many small matrices (n, m, …): the batch axes … are the last ones; NumPy's routines need them first.

Factorizations work on one column of all matrices at a time, in a few passes over contiguous memory instead of thousands of LAPACK
calls. Where the largest number is chosen, it is the first of those equal except for rounding, which symmetric robots have.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.math.arrays import Array, Mask, copy_for, empty_for, settles

#: Determinant of GᵀG, relative to the product of the squared column norms, up to which it counts as rounding.
SINGULAR = 1e-14
#: Pivot, relative to the column norms, above which the sign of a determinant is certain.
_SURE = 1e-8
#: Smallest pivot of an elimination without LAPACK, relative to the largest entry of its row.
NO_PIVOT = 1e-5
#: Relative difference up to which values count as equal; it exceeds the rounding errors of files.
EQUAL = 1e-6
#: Fraction of the largest value up to which a value is a rounding error.
NOTHING = 1e-9


def matmul(a: Array, b: Array) -> Array:
    return np.einsum("ij...,jk...->ik...", a, b)


def apply(a: Array, v: Array) -> Array:
    """Return the products (n, …) of matrices ``a`` (n, k, …) and vectors ``v`` (k, …)."""
    return np.einsum("ij...,j...->i...", a, v)


def transpose(a: Array) -> Array:
    return np.swapaxes(a, 0, 1)


def cross(a: Array, b: Array) -> Array:
    """Return the cross products (3, …) of vectors (3, …); their batch axes are broadcast."""
    first = a[1] * b[2] - a[2] * b[1]
    result = empty_for((3, *first.shape), first)
    result[0] = first
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]
    return result


def dot(a: Array, b: Array) -> Array:
    return np.einsum("i...,i...->...", a, b)


def semidefinite(a: Array) -> Array:
    """Return a symmetric matrix (n, n) with zero instead of negative eigenvalues."""
    values, vectors = np.linalg.eigh(a)
    return a if values[0] >= 0 else np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def normalize(a: Array) -> Array:
    """Return unit vectors along vectors (n, …); NaN for a zero vector."""
    with np.errstate(invalid="ignore", divide="ignore"):
        unit: Array = a / np.sqrt(dot(a, a))
    return unit


def correlation(matrix: Array) -> tuple[Array, Array]:
    """Return symmetric positive semidefinite matrices (…, n, n) scaled to a_ij / √(a_ii a_jj), and scale factors 1/√a_ii (…, n).

    A row whose diagonal entry is a rounding error relative to the largest one has the scale factor of the largest one.
    """
    diagonal = np.sqrt(np.maximum(np.einsum("...ii->...i", np.nan_to_num(matrix)), 0.0))
    largest = np.max(diagonal, axis=-1, keepdims=True, initial=0.0)
    unit = 1 / np.where(diagonal > 1e-11 * largest, diagonal, np.where(largest > 0, largest, 1.0))
    return np.nan_to_num(matrix) * unit[..., :, None] * unit[..., None, :], unit


def canonical_basis(basis: Array) -> Array:
    """Return an orthonormal basis (n, k) that depends only on the subspace that the orthonormal ``basis`` (n, k) spans.

    The unit vectors of the n coordinates are projected on the subspace. Each step takes the longest projection (the first of
    equal ones) as direction of the next basis vector, and subtracts the components along it from all projections.
    """
    projections, canonical = np.array(basis), np.empty_like(basis)
    for k in range(basis.shape[1]):
        unit = projections[first_largest(dot(projections.T, projections.T))]
        unit = unit / np.sqrt(unit @ unit)
        canonical[:, k] = basis @ unit
        projections = projections - np.outer(projections @ unit, unit)
    return canonical


def null_space(matrix: Array, tolerance: float) -> tuple[Array, int, float]:
    """Return a canonical orthonormal basis (n, n − r) of the null space, the rank r, and singular value r divided by the next.

    Singular values up to ``tolerance`` · max(1, largest singular value) are taken as zero. Entries of ``matrix`` (m, n) are of
    order 1; thus a matrix of rounding errors has rank 0.
    """
    if matrix.size == 0:
        return np.eye(matrix.shape[1]), 0, np.inf
    _, values, rows = np.linalg.svd(matrix, full_matrices=True)
    number, gap = _rank_of(values, tolerance)
    return canonical_basis(rows[number:].T), number, gap


def numerical_rank(matrix: Array, tolerance: float) -> tuple[int, float]:
    """Return the rank r of ``matrix`` (m, n), and singular value r divided by the next, as in :func:`null_space`."""
    return _rank_of(np.asarray(np.linalg.svd(matrix, compute_uv=False)), tolerance) if matrix.size else (0, np.inf)


def _rank_of(values: Array, tolerance: float) -> tuple[int, float]:
    number = int(np.sum(values > tolerance * max(values[0], 1.0)))
    dropped = float(values[number]) if number < len(values) else 0.0
    return number, float(values[number - 1]) / dropped if number and dropped > 0 else np.inf


def pivot_rows(basis: Array) -> list[int]:
    """Return the indices, in ascending order, of k independent rows of a matrix (n, k) of rank k.

    Each step of an elimination takes the row farthest from the span of the rows before, the first of nearly equal rows.
    """
    left, rows = np.array(basis), list[int]()
    for _ in range(basis.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        rows.append(int(np.argmax(sizes > sizes.max() - 1e-6)))
        along = left[rows[-1]] / sizes[rows[-1]]
        left = left - np.outer(left @ along, along)
    return sorted(rows)


class Cholesky:
    """Cholesky factor L of symmetric positive (semi)definite matrices A (n, n, …), of which only the lower triangles are read."""

    def __init__(self, a: Array) -> None:
        n = a.shape[0]
        factor = np.array(a, subok=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            for j in range(n):
                if j:
                    factor[j:, j] -= np.einsum("ik...,k...->i...", factor[j:, :j], factor[j, :j])
                factor[j:, j] /= np.sqrt(factor[j, j])
        self.factor, self._diagonal = factor, np.einsum("ii...->i...", a)

    @property
    def smallest_pivot(self) -> Array:
        """Smallest ratio (…) of a pivot to its diagonal entry of A: 1 if A is diagonal, tiny if A is singular; −∞ on failure."""
        with np.errstate(invalid="ignore", divide="ignore"):
            smallest = np.min(np.einsum("ii...->i...", self.factor) ** 2 / self._diagonal, axis=0, initial=1.0)
        return np.where(np.isnan(smallest), -np.inf, smallest)

    def forward(self, b: Array) -> Array:
        """Return L⁻¹ b (n, m, …) for ``b`` (n, m, …)."""
        n, batch = len(self.factor), self.factor.shape[2:]
        if b.shape[2:] != batch:
            b = np.broadcast_to(b, b.shape[:2] + np.broadcast_shapes(batch, b.shape[2:]))
        x = copy_for(b, self.factor)
        for j in range(n):
            x[j] /= self.factor[j, j]
            if j + 1 < n:
                x[j + 1 :] -= self.factor[j + 1 :, j, None] * x[j]
        return x

    def backward(self, y: Array) -> Array:
        """Return L⁻ᵀ y (n, m, …) for ``y`` (n, m, …)."""
        x = np.array(y, subok=True)
        for j in range(self.factor.shape[0] - 1, -1, -1):
            x[j] /= self.factor[j, j]
            if j:
                x[:j] -= self.factor[j, :j, None] * x[j]
        return x

    def smallest_eigenvalue(self) -> Array:
        """Return the lower bound 1 / trace A⁻¹ (…) of the smallest eigenvalue of A; 0 if the factorization fails.

        The bound is at most n times too small. Unlike the smallest pivot, it does not depend on the order of the columns.
        """
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            half = self._half_inverse()
            bound = 1 / np.einsum("ij...,ij...->...", half, half)
        return np.where(np.isfinite(bound), bound, 0.0)

    def solve(self, b: Array) -> Array:
        """Return A⁻¹ b = L⁻ᵀ L⁻¹ b."""
        return self.backward(self.forward(b))

    def inverse(self) -> Array:
        """Return A⁻¹ = L⁻ᵀ L⁻¹."""
        half = self._half_inverse()
        return np.einsum("ki...,kj...->ij...", half, half)

    def _half_inverse(self) -> Array:
        """Return L⁻¹ (n, n, …)."""
        n = len(self.factor)
        return self.forward(np.eye(n).reshape(n, n, *(1,) * (self.factor.ndim - 2)))


def definite(a: Array, limit: float) -> Mask:
    """True (…) where a sufficient condition shows that the smallest eigenvalue of a symmetric matrix (n, n, …) exceeds ``limit``.

    A large determinant suffices, since the product of the other eigenvalues is at most (trace / (n − 1))ⁿ⁻¹. Otherwise the bound
    :meth:`Cholesky.smallest_eigenvalue` decides. Pivots cannot decide, because pivots after a small one are rounding errors.
    """
    n = a.shape[0]
    if n == 0:
        return np.ones(a.shape[2:], dtype=bool)
    determinant = np.prod(np.einsum("ii...->i...", Cholesky(a).factor) ** 2, axis=0)
    others = (np.einsum("ii...->...", a) / max(n - 1, 1)) ** (n - 1)
    exceeds: Mask = determinant > 10 * limit * others
    if not settles(exceeds):
        if a.dtype == object:
            return exceeds | (Cholesky(a).smallest_eigenvalue() > limit)
        exceeds[~exceeds] = Cholesky(a[:, :, ~exceeds]).smallest_eigenvalue() > limit
    return exceeds


def least_squares(a: Array, b: Array, nullity: int = 0) -> Array:
    """Return the x (n, k, …) of least norm that minimize |a x − b|, for ``a`` (m, n, …) and ``b`` (m, k, …).

    The columns of ``a`` have comparable sizes. ``nullity`` is the dimension of the null space of ``a``; components of x in this
    space are removed, because they are amplified rounding errors.
    """
    n = a.shape[1]
    if n == 0:
        return np.zeros((0, *b.shape[1:]))
    a = a[:, ::-1]  # the first freedoms of a tree move nearly all bodies: eliminated last, they cause fewer fill-ins
    normal = empty_for((n, n, *a.shape[2:]), a)
    for i in range(n):  # the lower triangle
        normal[i, : i + 1] = np.einsum("r...,rj...->j...", a[:, i], a[:, : i + 1])
    diagonal = np.arange(n)
    sizes = normal[diagonal, diagonal]
    normal[diagonal, diagonal] += 1e-12 * (sizes + 1e-3)
    if nullity:  # larger than rounding errors of the largest columns
        normal[diagonal, diagonal] += 1e-14 * np.sum(sizes, axis=0)
    factor = Cholesky(normal)
    x = factor.solve(np.einsum("ri...,rk...->ik...", a, b))
    if nullity:
        # Inverse iteration: the inverse amplifies directions without stiffness in arbitrary vectors.
        arbitrary = np.random.default_rng(0).standard_normal((n, nullity))
        free = factor.solve(np.broadcast_to(arbitrary.reshape(n, nullity, *(1,) * (a.ndim - 2)), (n, nullity, *a.shape[2:])))
        free = free / np.sqrt(np.sum(free * free, axis=0))
        gram = Cholesky(np.einsum("ia...,ib...->ab...", free, free))
        for _ in range(2):
            x = x - np.einsum("ia...,ak...->ik...", free, gram.solve(np.einsum("ia...,ik...->ak...", free, x)))
    return x[::-1]


def step_across(a: Array, b: Array) -> Array:
    """Return the step (n, m, …) to subtract from m unit columns ``b``, so that they become orthogonal to ``a`` (n, k, …).

    ``a`` has rank n − m except for rounding, and ``b`` is almost orthogonal to it; small components of ``a`` in the span of ``b``
    are ignored. With an orthonormal basis Q of this span and P = 1 − Q Qᵀ, the step is (P a aᵀ P + Q Qᵀ)⁻¹ P a aᵀ b. It belongs
    to an iteration for the invariant subspace of a aᵀ with the smallest eigenvalues, and leaves an error of third order (G. W.
    Stewart, Error and perturbation bounds for subspaces associated with certain eigenvalue problems, SIAM Review 15, 1973).
    """
    half = Cholesky(np.einsum("ki...,kj...->ij...", b, b)).forward(transpose(b))
    along = np.einsum("ki...,kj...->ij...", half, half)
    unit = np.eye(len(a)).reshape(len(a), len(a), *(1,) * (a.ndim - 2))
    across = matmul(unit - along, a)
    right = matmul(across, np.einsum("ki...,kj...->ij...", a, b))
    return Cholesky(np.einsum("ik...,jk...->ij...", across, across) + along + 1e-14 * unit).solve(right)


def solve_by_elimination(a: Array, b: Array) -> Array:
    """Return A⁻¹ b (n, m, …) for ``a`` (n, n, …) and ``b`` (n, m, …); NaN where A is singular.

    Rows are eliminated in their order, without exchanges. LAPACK solves the systems in which a pivot is small.
    """
    n = a.shape[0]
    reduced, solution = np.array(a, subok=True), copy_for(b, a)
    sizes = np.max(np.abs(a), axis=1)
    sure: Mask = np.ones(a.shape[2:], dtype=bool)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for k in range(n):
            pivot, others = reduced[k, k], [row for row in range(n) if row != k]
            sure = sure & (np.abs(pivot) > NO_PIVOT * sizes[k])
            right, x = reduced[k, k + 1 :] / pivot, solution[k] / pivot
            below = reduced[others, k]
            solution[others] -= below[:, None] * x
            reduced[others, k + 1 :] -= below[:, None] * right
            reduced[k, k + 1 :], solution[k] = right, x
        if not settles(sure):
            matrix, right = np.moveaxis(a[..., ~sure], 2, 0), np.moveaxis(b[..., ~sure], 2, 0)
            regular = (np.linalg.slogdet(matrix)[0] != 0)[:, None, None]
            solved = np.linalg.solve(np.where(regular, matrix, np.eye(n)), right)
            solution[..., ~sure] = np.moveaxis(np.where(regular, solved, np.nan), 0, 2)
    return solution


def have_one_sign(first: Array, second: Array) -> Mask:
    """True (N,) where det G₁ᵀ G₂ > 0, or G₁ or G₂ is singular within rounding; both are (m, n, N) with m ≥ n."""
    first, second = np.moveaxis(first, 2, 0), np.moveaxis(second, 2, 0)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        sign, _ = np.linalg.slogdet(np.swapaxes(first, 1, 2) @ second)
        regular = []
        for g in (first, second):
            _, determinant = np.linalg.slogdet(np.swapaxes(g, 1, 2) @ g)
            regular.append(determinant - np.sum(np.log(np.sum(g * g, axis=1)), axis=1))
    same: Mask = (sign > 0) | ~(np.minimum(*regular) > np.log(SINGULAR))
    return same


def surely_have_one_sign(first: Array, second: Array) -> Mask:
    """True (N,) where all pivots of G₁ᵀ G₂ are positive and not small, so that :func:`have_one_sign` is true."""
    first, second = first[:, ::-1], second[:, ::-1]  # as in least_squares
    reduced = np.einsum("ia...,ib...->ab...", first, second)
    least = _SURE * np.sqrt(np.sum(first * first, axis=0) * np.sum(second * second, axis=0))
    sure: Mask = np.ones(first.shape[2], dtype=bool)
    with np.errstate(invalid="ignore", divide="ignore"):
        for k in range(least.shape[0]):
            sure = sure & (reduced[0, 0] > least[k])
            reduced = reduced[1:, 1:] - reduced[1:, :1] / reduced[0, 0] * reduced[:1, 1:]
    return sure


def first_largest(values: ArrayLike, margin: float = EQUAL) -> int:
    """Return the index of the largest of n ≥ 1 non-negative values, the first of those equal up to the relative ``margin``."""
    values = np.asarray(values, dtype=np.float64)
    return int(np.argmax(values >= np.max(values) * (1 - margin)))


def ranked(values: ArrayLike, margin: float = EQUAL) -> list[int]:
    """Return the indices of non-negative values (n,), the largest value first; values equal up to ``margin`` keep their order.

    Rounding errors relative to the largest value count as equal.
    """
    values = np.asarray(values, dtype=np.float64)
    values = np.where(values > NOTHING * np.max(values, initial=0.0), values, 0.0)
    order = np.argsort(-values, kind="stable").tolist()
    result: list[int] = []
    while order:
        alike = [k for k in order if values[k] >= values[order[0]] * (1 - margin)]
        result += sorted(alike)
        order = order[len(alike) :]
    return result


def axis_across(directions: ArrayLike) -> NDArray[np.float64]:
    """Return the axis x, y or z (3, …) with the largest angle to each unit vector (3, …); of equal angles, the first."""
    sizes = np.abs(np.asarray(directions, dtype=np.float64))
    with np.errstate(invalid="ignore"):
        farthest = np.argmax(sizes <= np.min(sizes, axis=0) + EQUAL, axis=0)
    return np.moveaxis(np.eye(3)[farthest], -1, 0)


def across(axis: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the unit vectors x, y (3,) of a right-handed frame whose z is the unit vector ``axis`` (3,)."""
    second = np.cross(axis, axis_across(axis))
    second /= np.linalg.norm(second)
    return np.cross(second, axis), second
