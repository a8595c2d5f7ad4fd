"""Rotations with the batch axes last: matrices, rotation vectors, quaternions (x, y, z, w), and orientation coordinates.

Conventions of the three orientation coordinates: a rotation vector ``rx ry rz`` (default); the angles ``rx ry rz`` about the axes
of an Euler sequence in SciPy's notation (three distinct letters; "XYZ": moving axes, "xyz": fixed axes); or ``azimuth tilt
torsion`` with R = R_z(azimuth) R_y(tilt) R_z(torsion − azimuth) (I. A. Bonev, D. Zlatanov, C. M. Gosselin, Advantages of the
modified Euler angles in the design and control of PKMs, 2002).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from kinetostatics.exceptions import CoordinatesError
from kinetostatics.math.arrays import Array, Mask, copy_for, empty_for, everywhere, zeros_for
from kinetostatics.math.linalg import cross, dot, matmul

#: Angle [rad] that counts as zero in solved poses: between the first and the last axis, or between a rotation and half a turn.
NEARLY_LOCKED = 1e-9


def skew(v: Array) -> Array:
    """Return the matrices (3, 3, …) whose product with a vector is ``v`` (3, …) × the vector."""
    matrix = zeros_for((3, 3, *v.shape[1:]), v)
    matrix[2, 1], matrix[0, 2], matrix[1, 0] = v
    matrix[1, 2], matrix[2, 0], matrix[0, 1] = -v
    return matrix


def identity(batch: tuple[int, ...]) -> Array:
    return np.array(np.broadcast_to(np.eye(3).reshape((3, 3) + (1,) * len(batch)), (3, 3, *batch)))


def exponential(v: Array) -> Array:
    """Return the rotation matrices 1 + sin θ/θ v× + (1 − cos θ)/θ² v×² (3, 3, …) of rotation vectors v (3, …), θ = |v| [rad]."""
    angle = np.sqrt(dot(v, v))
    safe = np.where(angle < 1e-8, 1.0, angle)
    sine = np.where(angle < 1e-8, 1.0, np.sin(safe) / safe)
    cosine = np.where(angle < 1e-8, 0.5, (1 - np.cos(safe)) / safe**2)
    matrix = skew(v)
    return identity(v.shape[1:]) + sine * matrix + cosine * np.einsum("ij...,jk...->ik...", matrix, matrix)


def left_jacobian(v: Array) -> Array:
    """Return J (3, 3, …) of ω = J v̇, world axes: J = 1 + (1 − cos θ)/θ² v× + (θ − sin θ)/θ³ v×², θ = |v|."""
    angle = np.sqrt(dot(v, v))
    safe = np.where(angle < 1e-4, 1.0, angle)
    first = np.where(angle < 1e-4, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(angle < 1e-4, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    matrix = skew(v)
    return identity(v.shape[1:]) + first * matrix + second * np.einsum("ij...,jk...->ik...", matrix, matrix)


def quaternion_of_matrix(R: Array) -> Array:
    """Return unit quaternions (4, …) with w ≥ 0, by Shepperd's method, which loses no digits at any angle."""
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
    """Return the rotation vectors (3, …) [rad], of length at most π, of rotation matrices ``R`` (3, 3, …).

    2 sin θ n = (R_32 − R_23, R_13 − R_31, R_21 − R_12), 2 cos θ = tr R − 1; near half a turn 2 atan2(|q|, q_w) q/|q|.

    In compiled code, they are accurate near half a turn only with ``at_half_turns``, which takes more operations.
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
    vector: Array = q[:3] * (2 * np.arctan2(sine, q[3]) / sine)
    return vector


def matrix_of_quaternion(q: Array) -> Array:
    x, y, z, w = q
    R = empty_for((3, 3, *x.shape), x)
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    return R


def quaternion_product(a: Array, b: Array) -> Array:
    """Return [a_w b + b_w a + a × b; a_w b_w − a · b] (4, …), with the scalar part last."""
    vector = a[3] * b[:3] + b[3] * a[:3] + cross(a[:3], b[:3])
    return np.concatenate([vector, (a[3] * b[3] - dot(a[:3], b[:3]))[None]])


def quaternion_exponential(v: Array) -> Array:
    """Return the unit quaternions [sin(θ/2) v/θ; cos(θ/2)] (4, …) of rotation vectors v (3, …) [rad], θ = |v|."""
    half = np.sqrt(dot(v, v)) / 2
    factor = np.where(half < 1e-8, 0.5, np.sin(half) / np.where(half < 1e-8, 1.0, 2 * half))
    return np.concatenate([v * factor, np.cos(half)[None]])


def rotation_between(a: Array, b: Array) -> Array:
    """Return the shortest rotation vectors atan2(|a × b|, a · b) a × b/|a × b| (3, …) of unit vectors a to b; any if opposite."""
    normal = cross(a, b)
    sine, cosine = np.sqrt(dot(normal, normal)), dot(a, b)
    tiny = sine < 1e-12
    vector = normal * np.where(tiny, 1.0, np.arctan2(sine, cosine) / np.where(tiny, 1.0, sine))
    flipped = tiny & (cosine < 0)
    if np.any(flipped):
        x, y = (unit.reshape(3, *(1,) * (a.ndim - 1)) for unit in np.eye(3)[:2])
        perpendicular = cross(a, np.where(np.abs(a[0]) < 0.7, x, y))
        perpendicular = perpendicular / np.sqrt(dot(perpendicular, perpendicular)) * np.pi
        vector = np.where(flipped, perpendicular, vector)
    return vector


def three_angles(axes: Array, R: Array, near: Array, locked: float = 1e-13) -> Array:
    """Return the angles q (3, N) with exp(a q₀) exp(b q₁) exp(c q₂) = R.

    Of the two solutions, the one with q₁ nearer to ``near[1]`` is taken, and full turns bring its angles nearest to ``near``.
    Where a and R c are parallel, only q₀ + q₂ or q₀ − q₂ is determined, and q₀ is ``near[0]``.

    Args:
        axes: (3, 3) the unit vectors a, b, c as columns, b at right angles to a and c.
        R: (3, 3, N) rotation matrices.
        near: (3, N) angles.
        locked: sine of the angle between a and R c up to which they are treated as parallel.
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


@dataclass(frozen=True)
class Orientation:
    """A convention for three orientation coordinates, called ``names``.

    ``sequence``: axes (0, 1, 2 for x, y, z) of three rotations about moving axes, or None for rotation vectors. For
    ``tilt_torsion`` the rotations are azimuth, tilt, and torsion − azimuth, about z, y, z.
    """

    name: str
    names: tuple[str, str, str]
    sequence: tuple[int, int, int] | None = None

    @property
    def pose_names(self) -> tuple[str, ...]:
        """Names of all coordinates of a pose: x, y, z of o, then the orientation coordinates."""
        return ("x", "y", "z", *self.names)

    @property
    def unique_below(self) -> float:
        """If all magnitudes are below this value [rad], the coordinates of a rotation are unique; 0: they never are."""
        return 1.5 if self.sequence is None or sorted(self.sequence) == [0, 1, 2] else 0.0

    def matrix(self, c: Array) -> Array:
        """Return the rotation matrices (3, 3, N) of coordinates ``c`` (3, N) [rad]."""
        if self.sequence is None:
            return exponential(c)
        first, second, third = (_about(axis, turn) for axis, turn in zip(self.sequence, self._turns(c), strict=True))
        return matmul(matmul(first, second), third)

    def rates(self, c: Array) -> Array:
        """Return the matrices (3, 3, N) whose column k is the angular velocity, in world axes, per unit rate of ``c[k]``."""
        if self.sequence is None:
            return left_jacobian(c)
        columns: list[Array] = []
        turned = identity(c.shape[1:])
        for axis, turn in zip(self.sequence, self._turns(c), strict=True):
            columns.append(turned[:, axis])
            turned = matmul(turned, _about(axis, turn))
        if self.name == "tilt_torsion":
            columns[0] = columns[0] - columns[2]
            return np.stack(columns, axis=1)
        return np.stack([columns[self.sequence.index(axis)] for axis in range(3)], axis=1)

    def coordinates(self, R: Array, near: Array | None = None, locked: float = 1e-13) -> Array:
        """Return coordinates (3, N) [rad] of rotation matrices ``R`` (3, 3, N); :meth:`matrix` is the inverse.

        Args:
            R: rotation matrices.
            near: (3, N) coordinates; of all solutions, including full turns, one near them is returned. If the first and last
                axes are parallel, the first angle is that of ``near``. None: all magnitudes are at most π, tilts are not
                negative, and an undetermined first angle is 0.
            locked: the first and last axes count as parallel if the sine of the angle between them is at most this number.
        """
        if self.sequence is None:
            c = logarithm(R, at_half_turns=True)
            return c if near is None else _nearest_vector(c, near)
        usual = np.zeros(R.shape[1:])
        if near is not None:
            usual = self._turns(near)
        elif self.name == "tilt_torsion":
            usual[1] = np.pi / 2
        turns = three_angles(np.eye(3)[:, list(self.sequence)], R, usual, locked)
        if self.name != "tilt_torsion":
            return turns[np.argsort(self.sequence)]
        torsion = turns[0] + turns[2]
        return np.stack([turns[0], turns[1], torsion if near is not None else torsion - _full_turns(torsion)])

    def same(self, c: Array, near: Array, always: bool | Mask) -> Array:
        """Return ``c`` (3, N) with each ambiguous rotation described by coordinates near ``near``.

        Ambiguous are half turns, whose sign depends on rounding, and rotations with parallel first and last axes, which determine
        only the sum or difference of two angles. Where ``always`` is true, full turns are added to unambiguous rotations too.
        """
        changed = always | _half_turn(np.sqrt(dot(c, c)) if self.sequence is None else c)
        if self.sequence is None:
            return c if everywhere(~changed) else np.where(changed, _nearest_vector(c, near), c)
        if not everywhere(~changed):
            c = np.where(changed, c + _full_turns(near - c), c)
        second = self._turns(c)[1]
        locked = np.abs(np.sin(second) if self.name == "tilt_torsion" else np.cos(second)) < NEARLY_LOCKED
        if not everywhere(~locked):
            near = copy_for(near, c)
            near[1 if self.name == "tilt_torsion" else self.sequence[1]] = second
            c = np.where(locked, self.coordinates(self.matrix(c), near, NEARLY_LOCKED), c)
        return c

    def is_unique(self, c: Array) -> bool:
        """Whether ``c`` (3, N) [rad] is below :attr:`unique_below`, so that :meth:`same` changes it by full turns only."""
        return bool(np.abs(c).max(initial=0.0) < self.unique_below)

    def _turns(self, c: Array) -> Array:
        """Return the angles (3, N) of the three rotations of ``sequence``."""
        if self.name == "tilt_torsion":
            return np.stack([c[0], c[1], c[2] - c[0]])
        return c[list(self.sequence or (0, 1, 2))]


def _half_turn(angle: Array) -> Mask:
    """True where an angle is half a turn, except for rounding."""
    return np.asarray(np.abs(np.abs(angle) - np.pi) < NEARLY_LOCKED)


def _full_turns(angle: Array) -> Array:
    """Return the multiples of 2π that are nearest to angles."""
    return np.asarray(2 * np.pi * np.round(angle / (2 * np.pi)))


def _nearest_vector(c: Array, near: Array) -> Array:
    """Return the rotation vectors (3, N) nearest to ``near`` that differ from ``c`` by full turns."""
    angle = np.sqrt(dot(c, c))
    axis = c / np.where(angle > 0, angle, 1.0)
    return c + axis * _full_turns(dot(axis, near) - angle)


def _about(axis: int, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    R = zeros_for((3, 3, *angle.shape), angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R[axis, axis] = 1
    R[j, j], R[j, k], R[k, j], R[k, k] = c, -s, s, c
    return R


def orientation_named(name: str | None) -> Orientation:
    """Return the convention "rotation_vector" (also for None), "tilt_torsion", or an Euler sequence such as "XYZ".

    Raises:
        CoordinatesError: there is no such convention.
    """
    name = "rotation_vector" if name is None else name
    if not isinstance(name, str):
        raise CoordinatesError(f"orientation is {name!r}; it must be a name: 'rotation_vector', 'XYZ', 'xyz' or 'tilt_torsion'")
    return _convention(name)


@cache
def _convention(name: str) -> Orientation:
    if name == "rotation_vector":
        return Orientation(name, ("rx", "ry", "rz"))
    if name == "tilt_torsion":
        return Orientation(name, ("azimuth", "tilt", "torsion"), (2, 1, 2))
    letters = name.lower()
    if name not in (letters, name.upper()) or sorted(letters) != ["x", "y", "z"]:
        raise CoordinatesError(
            f"unknown orientation {name!r}: use 'rotation_vector', 'tilt_torsion', or three distinct letters, "
            "'XYZ' for angles about moving axes or 'xyz' about fixed axes"
        )
    # rotations about fixed axes are rotations about moving axes in reverse order
    first, second, third = ("xyz".index(letter) for letter in (letters[::-1] if name == letters else letters))
    return Orientation(name, ("rx", "ry", "rz"), (first, second, third))


def orientations_with(coordinate: str) -> str:
    """Return, for a message, the conventions that have a coordinate of this name; empty if none has."""
    if coordinate in orientation_named("tilt_torsion").names:
        return "'tilt_torsion'"
    return "'rotation_vector' or three letters such as 'XYZ'" if coordinate in orientation_named(None).names else ""
