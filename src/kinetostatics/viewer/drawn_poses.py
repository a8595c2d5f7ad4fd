"""Interface of the poses of a scene, with or without loads."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move
from kinetostatics.robot import Robot


class DrawnPoses(ABC):
    """F poses of a robot, and displacements of its points by each of K contributions; all arrays have the axis F first.

    Attributes:
        robot: the robot.
        count: number of poses, F.
        step: interval of the shown stations of a beam; its ends and its middle are included.
        rigid: links with a twist of their own.
        sources: names of the contributions.
        labels: labels of the contributions on the page.
    """

    robot: Robot
    count: int
    step: int
    rigid: Collection[str]
    sources: tuple[str, ...]
    labels: tuple[str, ...]

    @abstractmethod
    def frame(self, link: str) -> Array:
        """Return the frames (F, 4, 4) of a link at rest."""

    @property
    @abstractmethod
    def platform_frame(self) -> Array:
        """The frames o-xyz (F, 4, 4) at rest."""

    @property
    def o(self) -> Array:
        """The points o (F, 3) at rest [m]."""
        return np.asarray(self.platform_frame[:, :3, 3])

    @property
    @abstractmethod
    def platform_twist(self) -> Array:
        """(F, K, 6) twist of the platform by each contribution, at o, world axes [m, rad]."""

    @abstractmethod
    def link_twist(self, link: str) -> Array | None:
        """Return what each contribution does (F, K, 6) to a link at its own origin; None if it carries a beam."""

    def twist_at(self, link: str, point: Array) -> Array:
        """Return what each contribution does (F, K, 6) to the points (F, 3) of a link.

        A link that carries a beam has no twist of its own: the point follows the nearer end of the nearest beam.
        """
        own = self.link_twist(link)
        if own is not None:
            return moved(own, point - self.frame(link)[:, :3, 3])
        ends = []
        for name, beam in self.robot.description.beams.items():
            if beam.link == link:
                _, points = self.beam_line(name)
                for end in (0, -1):
                    ends.append((float(np.linalg.norm(points[0, end] - point[0])), name, end, points[:, end]))
        if not ends:
            return np.zeros((self.count, len(self.sources), 6))
        _, name, end, at = min(ends, key=lambda item: item[0])
        return moved(self.beam_twists(name)[:, :, end], point - at)

    @abstractmethod
    def beam_line(self, name: str) -> tuple[Array, Array]:
        """Return axes (F, 3, 3) and points (F, n, 3) [m] of a beam at rest."""

    @abstractmethod
    def beam_twists(self, name: str) -> Array:
        """Return the twists (F, K, n, 6) of a beam's stations by each contribution [m, rad]."""

    @abstractmethod
    def tension(self, name: str) -> Array:
        """Return the force (F,) [N] of a spring."""


def moved(twist: Array, arm: Array) -> Array:
    """Return twists (F, K, 6) of a body at a point that lies ``arm`` (F, 3) from where they were given."""
    return move("twist", twist, arm[:, None], components_last=True)
