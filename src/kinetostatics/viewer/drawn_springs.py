"""Positions, lengths and end motions of springs, and point masses."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.elements import Spring
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import axis_across
from kinetostatics.viewer.drawn_poses import DrawnPoses
from kinetostatics.viewer.shapes import carried_along, crossed

#: Density of steel [kg/m³]; a point mass is drawn as a steel ball.
STEEL = 7850.0


@dataclass(frozen=True, eq=False)
class DrawnSpring:
    """One spring at the shown poses.

    Attributes:
        description: the spring of the robot's description.
        ends: (F, 3) positions of its two ends at rest [m].
        twists: (F, K, 6) twists of its two ends by each contribution [m, rad].
        tension: (F,) tensile force [N].
    """

    description: Spring
    ends: tuple[Array, Array]
    twists: tuple[Array, Array]
    tension: Array

    @property
    def links(self) -> tuple[str, str]:
        """Links at its two ends."""
        return self.description.predecessor, self.description.successor

    @property
    def length(self) -> Array:
        """(F,) length at rest [m]."""
        return np.asarray(np.linalg.norm(self.ends[1] - self.ends[0], axis=-1))

    @property
    def direction(self) -> Array:
        """(F, 3) unit vector from the first end to the second; zero at zero length."""
        length = self.length[:, None]
        return np.asarray((self.ends[1] - self.ends[0]) / np.where(length > 0, length, 1.0))

    def frames(self) -> Array:
        """Return frames (F, 4, 4) at the first end, z towards the second, with minimal rotation along a path."""
        result = np.tile(np.eye(4), (len(self.length), 1, 1))
        z = self.direction
        z = np.where(np.any(z != 0, axis=-1, keepdims=True), z, [0.0, 0.0, 1.0])
        x = carried_along(axis_across(z[0]), z)
        result[:, :3, 0], result[:, :3, 1], result[:, :3, 2] = x, crossed(z, x), z
        result[:, :3, 3] = self.ends[0]
        return result


def find_springs(poses: DrawnPoses) -> list[DrawnSpring]:
    """Return all springs."""
    found = []
    for name, spring in poses.robot.description.springs.items():
        ends, twists = [], []
        for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
            frame = poses.frame(link)
            ends.append(frame[:, :3, :3] @ np.array(local) + frame[:, :3, 3])
            twists.append(poses.twist_at(link, ends[-1]))
        found.append(DrawnSpring(spring, (ends[0], ends[1]), (twists[0], twists[1]), poses.tension(name)))
    return found


def find_masses_at_points(poses: DrawnPoses, looks: Collection[str]) -> dict[str, Array]:
    """Return the positions (F, 3) [m] of point masses (links with mass but no inertia) that are not drawn by ``looks``."""
    found, description = {}, poses.robot.description
    others = {*looks, *(beam.link for beam in description.beams.values())}
    for name, link in description.links.items():
        if link.mass > 0 and not any(link.inertia.moments) and name not in others:
            found[name] = (poses.frame(name) @ np.array([*link.center_of_mass, 1.0]))[:, :3]
    return found


def radius_of_ball(mass: float, size: float) -> float:
    """Return the radius [m] of a steel ball of this mass, limited to 1 to 6 % of the robot's size [m]."""
    return float(np.clip((3 * mass / (4 * np.pi * STEEL)) ** (1 / 3), 0.01 * size, 0.06 * size))
