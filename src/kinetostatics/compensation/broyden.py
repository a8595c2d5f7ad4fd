"""Broyden's method for the pose to be commanded, on arrays of floats or of recorded numbers.

The unknowns are the coordinates u commanded to the unloaded robot. The pose of the loaded platform is that of u displaced by the
twist; it must have the target coordinates. The first step subtracts the sag at the target pose. The sag at the new pose differs
slightly, and Broyden's update corrects the Jacobian, initially the identity, by these differences. (C. G. Broyden, A class of
methods for solving nonlinear simultaneous equations, Mathematics of Computation 19, 1965.)

For a tool's tip, the initial Jacobian is that of the tip's coordinates with respect to the commanded ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.linalg import apply, dot
from kinetostatics.math.rotations import Orientation

#: Error [m, and rad times the characteristic length; relative for robots above 1 m] that counts as corrected, and the goal.
CORRECTED, EXACT = 1e-12, 1e-15
#: Error that counts as corrected if actuator coordinates are prescribed instead of platform coordinates.
BY_ACTUATORS = 1e-9
#: Largest number of corrections, and of successive ones that do not halve the error.
MOST, STALE = 40, 4


def error_tolerance(length: float) -> float:
    """Return the error [m] that counts as corrected, for a characteristic length [m]."""
    return CORRECTED * max(1.0, length)


def arrival_tolerance(robot: RobotKinematics) -> float:
    """Return the position error [m] of a pose assembled from actuator coordinates, limited by the closure of loops."""
    return BY_ACTUATORS * max(1.0, robot.length) + 10 * robot.length * robot.closing_error


class ScaledCoordinates:
    """Some coordinates of the platform, scaled to lengths.

    Attributes:
        names: names of the coordinates.
        orientation: convention of the angles.
        scale: (n, 1) factors that convert them to lengths [m].
    """

    def __init__(self, names: Sequence[str], orientation: Orientation, length: float) -> None:
        """Select coordinates of a convention by name; ``length`` is the robot's characteristic length [m]."""
        self.names, self.orientation = tuple(names), orientation
        known = orientation.pose_names
        self._rows = [known.index(name) for name in names]
        self.scale = np.array([1.0 if name in "xyz" else length for name in names])[:, None]

    def of(self, frame: tuple[Array, Array], near: Array | None = None) -> Array:
        """Return the scaled coordinates (n, N) [m] of a frame: rotation (3, 3, N) and position (3, N).

        Of angles that differ by full turns, those nearest to ``near`` (3, N) are returned.
        """
        both = np.concatenate([frame[1], self.orientation.coordinates(frame[0], near=near)])
        found: Array = both[self._rows] * self.scale
        return found


@dataclass(frozen=True)
class BroydenSearch:
    """State of the search at N poses.

    Attributes:
        u: (n, N) scaled commanded coordinates.
        step: (n, N) last change of u.
        inverse: (n, n, N) approximate inverse Jacobian.
        error: (n, N) error of the loaded platform before this change.
        size: (N,) magnitude of the error.
        stale: (N,) number of successive steps that did not halve it.
        going: (N,) whether to continue.
    """

    u: Array
    step: Array
    inverse: Array
    error: Array
    size: Array
    stale: Array
    going: Mask

    @classmethod
    def started(cls, u: Array, inverse: Array, error: Array) -> BroydenSearch:
        """Return the first step from the target pose (n, N), with an inverse Jacobian (n, n, N) and the error there (n, N)."""
        size = _size(error)
        still, never = zeros_for(u.shape, u), zeros_for(size.shape, size)
        return cls(u, still, inverse, error, size, never, np.isfinite(size) & (size > EXACT)).moved()

    def moved(self) -> BroydenSearch:
        """Return the search after the next step; converged poses are unchanged."""
        step = np.where(self.going, -apply(self.inverse, self.error), 0.0)
        return replace(self, u=self.u + step, step=step)

    def updated(self, error: Array, tolerance: float) -> BroydenSearch:
        """Return the search after an update with the error (n, N) at the present ``u``, and after the next step."""
        inverse = _broyden_update(self.inverse, self.step, error - self.error, self.going)
        smaller = _size(error) < self.size / 2
        stale = np.where(smaller, 0.0, self.stale + 1.0)
        size = np.where(self.going, _size(error), self.size)
        going = self.going & np.isfinite(size) & (size > EXACT) & ~((size <= tolerance) & ~smaller) & (stale < STALE)
        return BroydenSearch(self.u, self.step, inverse, error, size, stale, going).moved()


def _broyden_update(inverse: Array, step: Array, change: Array, going: Mask) -> Array:
    """Return inverse Jacobians (n, n, N) by Broyden's update, from steps (n, N) and the resulting changes."""
    moved = apply(inverse, change)
    along = dot(step, moved)
    usable = going & np.isfinite(along) & (np.abs(along) > 0.1 * dot(step, step))
    direction = np.einsum("in,ijn->jn", step, inverse) / np.where(usable, along, 1.0)
    update = np.einsum("in,jn->ijn", step - moved, direction)
    found: Array = inverse + np.where(usable, update, 0.0)
    return found


def _size(error: Array) -> Array:
    found: Array = np.max(np.abs(error), axis=0, initial=0.0)
    return found
