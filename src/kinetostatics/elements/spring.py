"""Springs between two points.

A spring of length l, tension F = F_0 + k (l − l_0) and direction n pulls its ends together by F n. Under a relative displacement
u of its ends the force changes to first order by K_t u with K_t = k n nᵀ + (F/l) (1 − n nᵀ), by elongation and rotation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.description.elements import Spring
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import wrench_of_force


@dataclass(frozen=True)
class PlacedSpring:
    """A spring at N poses.

    Attributes:
        points: positions (3, N) of its two ends [m].
        attachments: the rigid links, or ends of beams, to which its two ends are attached.
        length, tension: (N,) [m], [N].
        force: (3, N) force on the first end, directed towards the second end [N].
        tangent: (3, 3, N) tangent stiffness K_t [N/m].
    """

    name: str
    points: tuple[Array, Array]
    attachments: tuple[str, str]
    length: Array
    tension: Array
    force: Array
    tangent: Array

    @classmethod
    def between(cls, spring: Spring, points: tuple[Array, Array], attachments: tuple[str, str], least: float) -> PlacedSpring:
        """Return a spring between two points (3, N) [m]; below the length ``least`` [m] its force has no direction and is NaN."""
        span = points[1] - points[0]
        length = np.sqrt(np.sum(span**2, axis=0))
        tension = spring.preload + spring.stiffness * (length - spring.free_length)
        if spring.free_length == spring.preload == 0:
            ratio, n = np.full_like(length, spring.stiffness), np.zeros_like(span)
        else:
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio, n = np.where(length > least, tension / length, np.nan), span / length
        tangent = ratio * np.eye(3)[:, :, None] + (spring.stiffness - ratio) * n[:, None] * n[None]
        return cls(spring.name, points, attachments, length, tension, ratio * span, tangent)

    def end_wrenches(self, force: Array, o: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Apply a force (3, N) [N] to the first end, and its reaction to the second end.

        Returns:
            (wrenches, points): by attachment, the wrench (6, N) about o [N, N·m] and the point of application (3, N) [m].
        """
        wrenches: dict[str, Array] = {}
        points: dict[str, Array] = {}
        for sign, point, attachment in zip((1, -1), self.points, self.attachments, strict=True):
            wrenches[attachment] = wrenches.get(attachment, 0.0) + sign * wrench_of_force(force, point - o)
            points.setdefault(attachment, point)
        return wrenches, points
