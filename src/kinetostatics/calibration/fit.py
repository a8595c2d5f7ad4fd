"""Nonlinear least squares with covariance, unidentifiable directions, outliers and leave-one-out errors of readings.

Residuals are weighted and the columns of the Jacobian scaled. A direction in the space of the unknowns is unidentifiable if it
changes no reading. The covariance is that of the linearized problem, σ² (JᵀJ)⁻¹, in the identifiable directions. Outliers are
found one after the other by externally studentized residuals with Bonferroni's bound (R. D. Cook, S. Weisberg, Residuals and
Influence in Regression, 1982). Leave-one-out errors of the readings in a row of the table are (I − H)⁻¹ r, with the row's block
H of the hat matrix and its residuals r (D. M. Allen, Technometrics 16, 1974).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import canonical_basis

#: Norms of columns of the Jacobian, relative to the largest column, and singular values of the normalized columns up to this
#: bound count as zero.
UNSEEN = 1e-6
#: Residuals, relative to the readings, that count as rounding.
ROUNDING = 1e-9
#: Probability that any reading is flagged as an outlier although the errors of all readings are normally distributed.
FALSE_ALARM = 0.05
#: Largest number of searches, each in the directions identifiable at the end of the previous one.
SEARCHES = 3

Function = Callable[[Array], Array]


class NoDerivativeError(Exception):
    """The search reached a point at which readings have no derivative with respect to an unknown.

    Attributes:
        x: (p,) the point, in units of the unknowns' scales.
        k: index of the unknown.
    """

    def __init__(self, x: Array, k: int) -> None:
        super().__init__(f"no derivative by unknown {k}")
        self.x, self.k = x, k


@dataclass(frozen=True)
class Fit:
    """Solution of a fit of p unknowns, in units of their scales, with n residuals.

    Attributes:
        x: (p,) unknowns.
        residuals: (n,) measured less computed readings, divided by sigma.
        jacobian: (n, p) derivatives of the computed readings, divided by sigma.
        seen: (p, r) orthonormal basis of identifiable directions.
        null: (p, p − r) basis of unidentifiable directions.
        variance: variance of a residual: 1 if sigma is known, else estimated, or NaN without degrees of freedom.
        degrees_of_freedom: number of readings minus number of identifiable directions.
        sigma_known: whether sigma is known; if not, only ratios of sigma are known.
        converged: whether the search converged.
    """

    x: Array
    residuals: Array
    jacobian: Array
    seen: Array
    null: Array
    variance: float
    degrees_of_freedom: int
    sigma_known: bool
    converged: bool

    @property
    def hat(self) -> Array:
        """(n, n) the hat matrix of the linearized problem, which maps measured to computed readings, both divided by sigma."""
        Q, _ = np.linalg.qr(self.jacobian @ self.seen)
        return np.asarray(Q @ Q.T)

    @property
    def covariance(self) -> Array:
        """(p, p) covariance of the unknowns, in the space of identifiable directions."""
        small = self.jacobian @ self.seen
        return np.asarray(self.variance * self.seen @ np.linalg.inv(small.T @ small) @ self.seen.T)


def fit(predict: Function, jacobian: Function, start: Array, measured: Array, sigma: Array, sigma_known: bool) -> Fit:
    """Fit the unknowns by weighted least squares.

    Args:
        predict: computes readings (n,) from unknowns (p,); NaN for invalid unknowns.
        jacobian: computes the derivatives (n, p) of the readings.
        start: (p,) initial values.
        measured, sigma: (n,) measured readings and standard deviations.
        sigma_known: whether ``sigma`` is known; if not, only its ratios are used.

    Raises:
        NoDerivativeError: the search reached a point without derivatives.
    """
    from scipy.optimize import least_squares

    x, converged = np.array(start, dtype=float), True
    size = float(np.sqrt(np.mean((measured / sigma) ** 2))) or 1.0

    def weighted(x: Array) -> Array:
        return np.asarray((predict(x) - measured) / sigma)

    def derived(x: Array) -> Array:
        derivatives = jacobian(x)
        lost = np.flatnonzero(~np.all(np.isfinite(derivatives), axis=0))
        if lost.size:
            raise NoDerivativeError(x, int(lost[0]))
        return derivatives / sigma[:, None]

    for _ in range(SEARCHES):
        scale, seen, _ = determined(derived(x))
        if not seen.shape[1]:
            break
        basis, origin = size * scale[:, None] * seen, x  # residuals relative to the readings
        search = least_squares(
            lambda z, origin=origin, basis=basis: weighted(origin + basis @ z) / size,
            np.zeros(seen.shape[1]),
            lambda z, origin=origin, basis=basis: (derived(origin + basis @ z) / size) @ basis,
            xtol=1e-9,
            ftol=1e-12,
            gtol=1e-13,
            max_nfev=60,
        )
        x, converged = origin + basis @ search.x, search.status > 0
        if determined(derived(x))[1].shape[1] <= seen.shape[1]:
            break
    return solution(x, derived(x), -weighted(x), sigma_known, converged)


def solution(x: Array, J: Array, residuals: Array, sigma_known: bool, converged: bool = True) -> Fit:
    """Return the fit for unknowns x (p,) with the weighted Jacobian J (n, p) and the weighted residuals (n,)."""
    scale, seen, null = determined(J)
    basis, _ = np.linalg.qr(scale[:, None] * seen)
    degrees_of_freedom = len(residuals) - basis.shape[1]
    variance = 1.0
    if not sigma_known:
        variance = float(residuals @ residuals / degrees_of_freedom) if degrees_of_freedom > 0 else np.nan
    return Fit(x, residuals, J, basis, scale[:, None] * null, variance, degrees_of_freedom, sigma_known, converged)


def determined(J: Array) -> tuple[Array, Array, Array]:
    """Return (scale, seen, null) of a Jacobian J (n, p); J · scale has normalized columns.

    seen (p, r) and null (p, p − r) are orthonormal bases of the row space and of the null space of J · scale.
    """
    sizes = np.linalg.norm(J, axis=0)
    blind = sizes <= UNSEEN * sizes.max(initial=0.0)
    scale = 1 / np.where(blind, sizes.max(initial=0.0) or 1.0, sizes)
    _, values, rows = np.linalg.svd(np.where(blind, 0.0, J * scale), full_matrices=True)
    rank = int(np.sum(values > UNSEEN))
    return scale, rows[:rank].T, canonical_basis(rows[rank:].T)


def outliers(fitted: Fit, size: float) -> tuple[Array, Mask]:
    """Return (externally studentized residuals (n,), mask (n,): True at outliers).

    Each outlier is sought in a fit without the previous outliers. ``size``: root mean square of the weighted readings, to which
    rounding errors are proportional.
    """
    from scipy import stats

    J = fitted.jacobian @ fitted.seen
    n, r = J.shape
    kept = np.ones(n, dtype=bool)
    studentized = np.zeros(n)
    while np.sum(kept) - r > 1:
        Q, _ = np.linalg.qr(J[kept])
        residuals = fitted.residuals[kept] - Q @ (Q.T @ fitted.residuals[kept])
        free = 1 - np.sum(Q**2, axis=1)
        usable = free > ROUNDING
        internal = np.where(usable, residuals, 0.0) ** 2 / np.where(usable, free, 1.0)
        if np.sqrt(np.mean(residuals**2)) <= ROUNDING * size:
            break
        if fitted.sigma_known:
            t, bound = np.sqrt(internal), stats.norm.isf(FALSE_ALARM / (2 * len(residuals)))
        else:
            freedom = len(residuals) - r - 1  # of a fit without the reading
            without = np.maximum((residuals @ residuals - internal) / freedom, (ROUNDING * size) ** 2)
            t, bound = np.sqrt(internal / without), stats.t.isf(FALSE_ALARM / (2 * len(residuals)), freedom)
        studentized[kept] = t * np.sign(residuals)
        worst = int(np.argmax(t))
        if t[worst] <= bound:
            break
        kept[np.flatnonzero(kept)[worst]] = False
    return studentized, ~kept


def leave_one_out(fitted: Fit, groups: Array) -> Array:
    """Return the errors (n,), divided by sigma, of readings predicted from the readings of all other groups.

    ``groups`` (n,): group of each reading. The error is NaN if the other groups do not determine the reading.
    """
    H, errors = fitted.hat, np.full(len(groups), np.nan)
    for group in np.unique(groups):
        in_group = np.flatnonzero(groups == group)
        residual_map = np.eye(in_group.size) - H[np.ix_(in_group, in_group)]
        if np.linalg.svd(residual_map, compute_uv=False)[-1] > UNSEEN:
            errors[in_group] = np.linalg.solve(residual_map, fitted.residuals[in_group])
    return errors
