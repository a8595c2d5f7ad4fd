"""Arithmetic that carries first and second derivatives along, with vectors and finite rotations, for the tests."""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.polynomial import Polynomial


@dataclass(frozen=True, eq=False)
class Jet:
    """Values (…), with first (…, n) and second derivatives (…, n, n) by n variables."""

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray

    __array_ufunc__ = None

    def __getitem__(self, key):
        return Jet(self.value[key], self.first[key], self.second[key])

    def __add__(self, other):
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.first + other.first, self.second + other.second)
        return Jet(self.value + other, self.first, self.second)

    __radd__ = __add__

    def __neg__(self):
        return Jet(-self.value, -self.first, -self.second)

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if not isinstance(other, Jet):
            other = np.asarray(other)
            return Jet(self.value * other, self.first * other[..., None], self.second * other[..., None, None])
        a, b = self.value[..., None], other.value[..., None]
        mixed = self.first[..., :, None] * other.first[..., None, :]
        second = a[..., None] * other.second + b[..., None] * self.second + mixed + np.swapaxes(mixed, -1, -2)
        return Jet(self.value * other.value, a * other.first + b * self.first, second)

    __rmul__ = __mul__

    def function(self, of):
        """Return a polynomial of the values."""
        f, df, ddf = of(self.value), of.deriv()(self.value)[..., None], of.deriv(2)(self.value)[..., None, None]
        return Jet(f, df * self.first, df[..., None] * self.second + ddf * self.first[..., :, None] * self.first[..., None, :])

    def root(self):
        value = np.sqrt(self.value)
        first = self.first / (2 * value[..., None])
        return Jet(value, first, (self.second / 2 - first[..., :, None] * first[..., None, :]) / value[..., None, None])


def variables(values):
    """Return (m, n) variables as m times n jets."""
    m, n = values.shape
    return Jet(values, np.broadcast_to(np.eye(n), (m, n, n)), np.zeros((m, n, n, n)))


def cross(a, b):
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]


def dot(a, b):
    product = a * b
    return Jet(product.value.sum(1, keepdims=True), product.first.sum(1, keepdims=True), product.second.sum(1, keepdims=True))


def stacked(*jets):
    return Jet(*(np.concatenate([getattr(jet, name) for jet in jets], axis=1) for name in ("value", "first", "second")))


def _series(coefficient, terms=30):
    return Polynomial([coefficient(k) for k in range(terms)])


#: By the squared angle q = θ²: sin θ/θ, (1 − cos θ)/θ², (θ − sin θ)/θ³, cos ½θ, sin ½θ/θ; by r = sin² ½θ: θ/sin ½θ.
SINE = _series(lambda k: (-1) ** k / factorial(2 * k + 1))
VERSINE = _series(lambda k: (-1) ** k / factorial(2 * k + 2))
REST = _series(lambda k: (-1) ** k / factorial(2 * k + 3))
HALF_COSINE = _series(lambda k: (-0.25) ** k / factorial(2 * k))
HALF_SINE = _series(lambda k: 0.5 * (-0.25) ** k / factorial(2 * k + 1))
ANGLE = _series(lambda k: 2 * factorial(2 * k) / (4**k * factorial(k) ** 2 * (2 * k + 1)), 60)


def turned(psi, vector):
    """Return exp(ψ) vector, with a jet ψ (m, 3)."""
    q, once = dot(psi, psi), cross(psi, vector)
    return vector + q.function(SINE) * once + q.function(VERSINE) * cross(psi, once)


def half_quaternion(psi):
    q = dot(psi, psi)
    return q.function(HALF_COSINE), q.function(HALF_SINE) * psi


def relative_rotation(one, two):
    """Return the rotation vector of exp(−ψ₁) exp(ψ₂), which is below a right angle."""
    (c, v), (d, w) = half_quaternion(one), half_quaternion(two)
    vector = c * w - d * v - cross(v, w)
    square = dot(vector, vector)
    if np.any(square.value > 0.5):
        raise ValueError("a joint turns by more than a right angle")
    return square.function(ANGLE) * vector


def spin_of(psi):
    """Return the (3, 3) map from rates of a rotation vector to the angular velocity."""
    q, S = float(psi @ psi), np.array([[0, -psi[2], psi[1]], [psi[2], 0, -psi[0]], [-psi[1], psi[0], 0]])
    return np.eye(3) + VERSINE(q) * S + REST(q) * S @ S
