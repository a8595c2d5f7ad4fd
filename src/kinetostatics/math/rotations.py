"""Rotations with the batch axes last: exponential, logarithm, quaternions (x, y, z, w as in Pinocchio)."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array, empty_for, zeros_for
from kinetostatics.math.linalg import cross, dot


def skew(v: Array) -> Array:
    """Return the (3, 3, …) matrices of the cross product with ``v``."""
    matrix = zeros_for((3, 3, *v.shape[1:]), v)
    matrix[2, 1], matrix[0, 2], matrix[1, 0] = v
    matrix[1, 2], matrix[2, 0], matrix[0, 1] = -v
    return matrix


def identity(batch: tuple[int, ...]) -> Array:
    """Return (3, 3, …) identity matrices."""
    return np.array(np.broadcast_to(np.eye(3).reshape((3, 3) + (1,) * len(batch)), (3, 3, *batch)))


def exponential(v: Array) -> Array:
    """Return the (3, 3, …) rotation matrices of rotation vectors ``v`` (3, …) [rad]."""
    angle = np.sqrt(dot(v, v))
    safe = np.where(angle < 1e-8, 1.0, angle)
    sine = np.where(angle < 1e-8, 1.0, np.sin(safe) / safe)
    cosine = np.where(angle < 1e-8, 0.5, (1 - np.cos(safe)) / safe**2)
    matrix = skew(v)
    return identity(v.shape[1:]) + sine * matrix + cosine * np.einsum("ij...,jk...->ik...", matrix, matrix)


def left_jacobian(v: Array) -> Array:
    """Return the (3, 3, …) matrices that take d(rotation vector)/dt to the angular velocity in world axes."""
    angle = np.sqrt(dot(v, v))
    safe = np.where(angle < 1e-4, 1.0, angle)
    first = np.where(angle < 1e-4, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(angle < 1e-4, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    matrix = skew(v)
    return identity(v.shape[1:]) + first * matrix + second * np.einsum("ij...,jk...->ik...", matrix, matrix)


def quaternion_of_matrix(R: Array) -> Array:
    """Return unit quaternions (4, …) with a non-negative w, by Shepperd's method (no loss of digits at any angle)."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    q = np.stack([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1 + trace])
    best = trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        column = empty_for(q.shape, R)
        column[i] = 1 + R[i, i] - R[j, j] - R[k, k]
        column[j] = R[j, i] + R[i, j]
        column[k] = R[k, i] + R[i, k]
        column[3] = R[k, j] - R[j, k]
        better = R[i, i] > best
        q, best = np.where(better, column, q), np.where(better, R[i, i], best)
    q = q / np.sqrt(dot(q, q))
    return np.where(q[3] < 0, -q, q)


def logarithm(R: Array, at_half_turns: bool = False) -> Array:
    """Return the rotation vectors (3, …) [rad] of rotation matrices; their length is at most π.

    Recorded code is valid near half a turn only if recorded with ``at_half_turns``, which takes more operations.
    """
    v = empty_for((3, *R.shape[2:]), R)
    v[0], v[1], v[2] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    double_sine, double_cosine = np.sqrt(dot(v, v)), R[0, 0] + R[1, 1] + R[2, 2] - 1
    tiny = double_sine < 1e-10
    v *= np.where(tiny, 0.5, np.arctan2(double_sine, double_cosine) / np.where(tiny, 1.0, double_sine))
    wide = double_cosine < -1.8  # near half a turn the sine loses its digits
    if R.dtype == object and at_half_turns:
        v = np.where(wide, _logarithm_of_quaternion(R), v)
    elif np.any(wide):
        v[:, wide] = _logarithm_of_quaternion(R[:, :, wide])
    return v


def _logarithm_of_quaternion(R: Array) -> Array:
    q = quaternion_of_matrix(R)
    sine = np.sqrt(dot(q[:3], q[:3]))
    found: Array = q[:3] * (2 * np.arctan2(sine, q[3]) / sine)
    return found


def matrix_of_quaternion(q: Array) -> Array:
    """Return the (3, 3, …) rotation matrices of unit quaternions (4, …)."""
    x, y, z, w = q
    R = empty_for((3, 3, *x.shape), x)
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    return R


def quaternion_product(a: Array, b: Array) -> Array:
    """Return the products of quaternions (4, …)."""
    vector = a[3] * b[:3] + b[3] * a[:3] + cross(a[:3], b[:3])
    return np.concatenate([vector, (a[3] * b[3] - dot(a[:3], b[:3]))[None]])


def quaternion_exponential(v: Array) -> Array:
    """Return the unit quaternions of rotation vectors (3, …)."""
    half = np.sqrt(dot(v, v)) / 2
    factor = np.where(half < 1e-8, 0.5, np.sin(half) / np.where(half < 1e-8, 1.0, 2 * half))
    return np.concatenate([v * factor, np.cos(half)[None]])


def rotation_between(a: Array, b: Array) -> Array:
    """Return the shortest rotation vectors that take unit vectors ``a`` to ``b`` (π about some normal if opposite)."""
    normal = cross(a, b)
    sine, cosine = np.sqrt(dot(normal, normal)), dot(a, b)
    tiny = sine < 1e-12
    vector = normal * np.where(tiny, 1.0, np.arctan2(sine, cosine) / np.where(tiny, 1.0, sine))
    flipped = tiny & (cosine < 0)
    if np.any(flipped):
        helper = np.where(
            np.abs(a[0]) < 0.7,
            np.array([1.0, 0, 0]).reshape((3,) + (1,) * (a.ndim - 1)),
            np.array([0, 1.0, 0]).reshape((3,) + (1,) * (a.ndim - 1)),
        )
        perpendicular = cross(a, helper)
        perpendicular = perpendicular / np.sqrt(dot(perpendicular, perpendicular)) * np.pi
        vector = np.where(flipped, perpendicular, vector)
    return vector


def three_angles(axes: Array, R: Array, near: Array, locked: float = 1e-13) -> Array:
    """Return angles (3, N) with exp(a q₀) exp(b q₁) exp(c q₂) = R, of the two solutions the one near ``near``.

    The first angle follows from the image of the last axis under R, the last angle from the remaining rotation. The product is R
    also if the first and last axes coincide, where only the sum or difference of their angles is determined.

    Args:
        axes: (3, 3) the unit vectors a, b, c as columns, b at right angles to a and c.
        R: (3, 3, N) rotation matrices.
        near: (3, N) angles that select the solution, an undetermined first angle, and full turns.
        locked: sine of the angle between the first and the last axis up to which they count as coincident.
    """
    a, b, c = axes.T[:, :, None]
    end = np.einsum("ijn,j->in", R, c[:, 0])
    height = dot(a, end)
    beside = end - a * height  # across a
    sine = np.sqrt(dot(beside, beside))
    spread = np.arctan2(sine, height)
    zero = np.arctan2(dot(a, cross(b, c)), dot(a, c))  # the second angle at which c lies along a
    options = np.stack([zero + spread, zero - spread])
    options += 2 * np.pi * np.round((near[1] - options) / (2 * np.pi))
    other = np.abs(options[1] - near[1]) < np.abs(options[0] - near[1])
    second = np.where(other, options[1], options[0])
    # ``beside`` after the second rotation alone, except for its length
    start = cross(b, a) * np.where(other, -1.0, 1.0)
    first = np.where(sine > locked, np.arctan2(dot(a, cross(start, beside)), dot(start, beside)), near[0])
    turned = np.einsum("ijn,jkn->ikn", exponential(a * first), exponential(b * second))
    across = np.einsum("ijn,j->in", R, b[:, 0])
    third = np.arctan2(
        dot(np.einsum("ijn,j->in", turned, cross(c, b)[:, 0]), across), dot(np.einsum("ijn,j->in", turned, b[:, 0]), across)
    )
    outer = np.stack([first, third])
    outer += 2 * np.pi * np.round((near[[0, 2]] - outer) / (2 * np.pi))
    return np.stack([outer[0], second, outer[1]])
