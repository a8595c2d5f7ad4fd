"""Coordinates of the platform: the position of o and three orientation coordinates, in fourteen conventions.

Conventions: a rotation vector ``rx ry rz`` (default); the angles ``rx ry rz`` about the axes of an Euler sequence in SciPy's
notation ("XYZ" turns about moving, "xyz" about fixed axes; three distinct letters); or ``azimuth tilt torsion``
(I. A. Bonev, D. Zlatanov, C. M. Gosselin, Advantages of the modified Euler angles in the design and control of PKMs,
2002: R = R_z(azimuth) R_y(tilt) R_z(torsion − azimuth)).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import CoordinatesError
from kinetostatics.math import rotations
from kinetostatics.math.arrays import Array, Mask, copy_for, everywhere, zeros_for
from kinetostatics.math.linalg import dot, matmul

#: Angle between the first and last axes, or difference from half a turn [rad], that counts as zero in solved poses.
NEARLY_LOCKED = 1e-9


@dataclass(frozen=True)
class Orientation:
    """A convention for three orientation coordinates.

    ``sequence``: axes of three rotations about moving axes: those of an Euler sequence, or z, y, z by azimuth, tilt and torsion −
    azimuth; None for rotation vectors.
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
        """Magnitude [rad] of coordinates below which they are unique for their rotation; 0 if never."""
        return 1.5 if self.sequence is None or sorted(self.sequence) == [0, 1, 2] else 0.0

    def matrix(self, c: Array) -> Array:
        """Return rotation matrices (3, 3, N) of coordinates ``c`` (3, N) [rad]."""
        if self.sequence is None:
            return rotations.exponential(c)
        first, second, third = (_about(axis, turn) for axis, turn in zip(self.sequence, self._turns(c), strict=True))
        return matmul(matmul(first, second), third)

    def rates(self, c: Array) -> Array:
        """Return (3, 3, N) matrices whose k-th column is the angular velocity, in world axes, per unit rate of c[k]."""
        if self.sequence is None:
            return rotations.left_jacobian(c)
        columns: list[Array] = []
        turned = rotations.identity(c.shape[1:])
        for axis, turn in zip(self.sequence, self._turns(c), strict=True):
            columns.append(turned[:, axis])
            turned = matmul(turned, _about(axis, turn))
        if self.name == "tilt_torsion":
            columns[0] = columns[0] - columns[2]
            return np.stack(columns, axis=1)
        return np.stack([columns[self.sequence.index(axis)] for axis in range(3)], axis=1)

    def coordinates(self, R: Array, near: Array | None = None, locked: float = 1e-13) -> Array:
        """Return coordinates (3, N) [rad] of rotation matrices (3, 3, N), from which :meth:`matrix` rebuilds them.

        Args:
            R: rotation matrices.
            near: (3, N) coordinates that select one of the two solutions for three angles, and full turns. By default all are at
                most π, and tilts are positive. If the first and last axes coincide, so that the first angle is undetermined, it
                is taken from here (default: 0).
            locked: sine of the angle between these axes up to which they count as coincident; also the accuracy of R.
        """
        if self.sequence is None:
            c = rotations.logarithm(R, at_half_turns=True)
            return c if near is None else _nearest_vector(c, near)
        usual = np.zeros(R.shape[1:])
        if near is not None:
            usual = self._turns(near)
        elif self.name == "tilt_torsion":
            usual[1] = np.pi / 2
        turns = rotations.three_angles(np.eye(3)[:, list(self.sequence)], R, usual, locked)
        if self.name != "tilt_torsion":
            return turns[np.argsort(self.sequence)]
        torsion = turns[0] + turns[2]
        return np.stack([turns[0], turns[1], torsion if near is not None else torsion - _full_turns(torsion)])

    def same(self, c: Array, near: Array, always: bool | Mask) -> Array:
        """Return coordinates (3, N) of the same rotations as ``c`` that are nearer to ``near``.

        They differ from ``c`` by full turns, if ``always`` or if rounding decides the sign of a half turn in ``c``; and in the
        first and last angles if their axes coincide, so that only their sum is determined.
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
        """Whether coordinates (3, N) [rad] are certainly unique for their rotations, except for full turns, see :meth:`same`."""
        return bool(np.abs(c).max(initial=0.0) < self.unique_below)

    def _turns(self, c: Array) -> Array:
        """Return the angles (3, N) of the three turns, in their order."""
        if self.name == "tilt_torsion":
            return np.stack([c[0], c[1], c[2] - c[0]])
        return c[list(self.sequence or (0, 1, 2))]


def _full_turns(angle: Array) -> Array:
    """Return the multiples of 2π that are nearest to angles."""
    return np.asarray(2 * np.pi * np.round(angle / (2 * np.pi)))


def _half_turn(angle: Array) -> NDArray[np.bool_]:
    return np.asarray(np.abs(np.abs(angle) - np.pi) < NEARLY_LOCKED)


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
    """Return the convention of a name: None or "rotation_vector", an Euler sequence, or "tilt_torsion".

    Raises:
        CoordinatesError: there is no such convention.
    """
    if name is None:
        return _convention("rotation_vector")
    if not isinstance(name, str):
        raise CoordinatesError(f"orientation is {name!r}; it must be a name: 'rotation_vector', 'XYZ', 'xyz' or 'tilt_torsion'")
    return _convention(name)


@cache
def _convention(name: str) -> Orientation:
    if name == "rotation_vector":
        return Orientation("rotation_vector", ("rx", "ry", "rz"))
    if name == "tilt_torsion":
        return Orientation(name, ("azimuth", "tilt", "torsion"), (2, 1, 2))
    letters = name.lower()
    if name not in (letters, name.upper()) or sorted(letters) != ["x", "y", "z"]:
        raise CoordinatesError(
            f"unknown orientation {name!r}: use 'rotation_vector', 'tilt_torsion', or three distinct letters, "
            "'XYZ' for angles about moving axes or 'xyz' about fixed axes"
        )
    axes = ["xyz".index(letter) for letter in letters]
    if name == letters:  # rotations about fixed axes are rotations about moving axes in reverse order
        axes.reverse()
    return Orientation(name, ("rx", "ry", "rz"), (axes[0], axes[1], axes[2]))


def orientations_with(coordinate: str) -> str:
    """Return the conventions that have a coordinate as text; empty if none has."""
    if coordinate in orientation_named("tilt_torsion").names:
        return "'tilt_torsion'"
    return "'rotation_vector' or three letters such as 'XYZ'" if coordinate in orientation_named(None).names else ""
