"""Coordinates of the platform: x, y, z of o and three numbers for its orientation.

Conventions: a rotation vector ``rx ry rz`` (default); the angles ``rx ry rz`` about the axes of an Euler sequence in SciPy's
notation ("XYZ" turns about moving, "xyz" about fixed axes; three distinct letters); or ``azimuth tilt torsion``
(I. A. Bonev, D. Zlatanov, C. M. Gosselin, Advantages of the modified Euler angles in the design and control of PKMs,
2002: R = R_z(azimuth) R_y(tilt) R_z(torsion − azimuth)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics import rotations
from kinetostatics.exceptions import CoordinatesError
from kinetostatics.linalg import matmul

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Orientation:
    """A way to write a rotation as three numbers; ``sequence`` holds the axes of an Euler sequence about moving axes."""

    name: str
    names: tuple[str, str, str]
    sequence: tuple[int, int, int] | None = None

    def matrix(self, c: Array) -> Array:
        """Return rotation matrices (3, 3, N) of coordinates ``c`` (3, N) [rad]."""
        if self.sequence is not None:
            first, second, third = (_about(axis, c[axis]) for axis in self.sequence)
            return matmul(matmul(first, second), third)
        if self.name == "tilt_torsion":
            return matmul(matmul(_about(2, c[0]), _about(1, c[1])), _about(2, c[2] - c[0]))
        return rotations.exponential(c)

    def rates(self, c: Array) -> Array:
        """Return (3, 3, N) matrices whose k-th column is the angular velocity, in world axes, per unit rate of c[k]."""
        if self.sequence is not None:
            columns: list[Array] = [np.zeros_like(c)] * 3
            turned = rotations.identity(c.shape[1:])
            for axis in self.sequence:
                columns[axis] = turned[:, axis]
                turned = matmul(turned, _about(axis, c[axis]))
            return np.stack(columns, axis=1)
        if self.name == "tilt_torsion":
            normal = self.matrix(c)[:, 2]
            up = np.zeros_like(c)
            up[2] = 1
            return np.stack([up - normal, _about(2, c[0])[:, 1], normal], axis=1)
        return rotations.left_jacobian(c)

    def coordinates(self, R: Array) -> Array:
        """Return coordinates (3, N) [rad] of rotation matrices (3, 3, N)."""
        if self.sequence is not None:
            i, j, k = self.sequence
            sign = 1.0 if (j - i) % 3 == 1 else -1.0
            c = np.empty(R.shape[1:])
            c[j] = np.arctan2(sign * R[i, k], np.hypot(R[i, i], R[i, j]))
            c[i] = np.arctan2(-sign * R[j, k], R[k, k])
            c[k] = np.arctan2(-sign * R[i, j], R[i, i])
            return c
        if self.name == "tilt_torsion":
            sine = np.hypot(R[0, 2], R[1, 2])
            azimuth = np.where(sine < 1e-12, 0.0, np.arctan2(R[1, 2], R[0, 2]))
            return np.stack([azimuth, np.arctan2(sine, R[2, 2]), np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])])
        return rotations.logarithm(R)


def _about(axis: int, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((3, 3, *angle.shape))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R[axis, axis] = 1
    R[j, j], R[j, k], R[k, j], R[k, k] = c, -s, s, c
    return R


def orientation_named(name: str | None) -> Orientation:
    """Return the convention of a name: None or "rotation_vector", an Euler sequence, or "tilt_torsion".

    Raises:
        CoordinatesError: there is no such convention.
    """
    if name is None or name == "rotation_vector":
        return Orientation("rotation_vector", ("rx", "ry", "rz"))
    if name == "tilt_torsion":
        return Orientation(name, ("azimuth", "tilt", "torsion"))
    letters = name.lower()
    if name not in (letters, name.upper()) or sorted(letters) != ["x", "y", "z"]:
        raise CoordinatesError(
            f"unknown orientation {name!r}: use 'rotation_vector', 'tilt_torsion', or three distinct letters, "
            "'XYZ' for angles about moving axes or 'xyz' about fixed axes"
        )
    axes = ["xyz".index(letter) for letter in letters]
    if name == letters:  # turning about fixed axes is turning about moving axes in the opposite order
        axes.reverse()
    return Orientation(name, ("rx", "ry", "rz"), (axes[0], axes[1], axes[2]))


def orientations_with(coordinate: str) -> str:
    """Return in words which conventions have a coordinate; nothing if none has."""
    if coordinate in orientation_named("tilt_torsion").names:
        return "'tilt_torsion'"
    return "'rotation_vector' or three letters such as 'XYZ'" if coordinate in orientation_named(None).names else ""
