"""One pose of a robot without loads."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_model import make_beam_models
from kinetostatics.mechanism.tree import Frames
from kinetostatics.results.parts import FRACTIONS
from kinetostatics.viewer.drawn_poses import DrawnPoses


class StandingPose(DrawnPoses):
    """One pose of a robot, F = 1, with unknown forces of springs.

    Attributes:
        configuration: the pose; None if the loops of the robot cannot be closed.
        frames: frames of its bodies.
    """

    count, step = 1, 1
    configuration: Configuration | None
    frames: Frames

    @property
    @abstractmethod
    def notes(self) -> list[str]:
        """Notes of the page."""

    def _homogeneous(self, body: int, placement: Array) -> Array:
        return np.moveaxis(self.frames.matrices(body, placement), -1, 0)

    def frame(self, link: str) -> Array:
        """Return the frame (1, 4, 4) of a link."""
        return self._homogeneous(*self.robot.mechanism.body_of[link])

    @property
    def platform_frame(self) -> Array:
        """The frame o-xyz (1, 4, 4)."""
        return self._homogeneous(*self.robot.mechanism.platform_frame)

    @cached_property
    def _beams(self) -> dict[str, tuple[Array, Array]]:
        models = make_beam_models(self.robot.mechanism, self.robot.topology.beams, self.frames)
        found = {}
        for name, model in models.items():
            start, end = (point.T for point in model.ends(self.frames))
            axes = self.frames.rotation[:, :, model.span.carrier, 0] @ model.axes
            found[name] = axes[None], start[:, None] + FRACTIONS[:, None] * (end - start)[:, None]
        return found

    def beam_line(self, name: str) -> tuple[Array, Array]:
        """Return axes (1, 3, 3) and points (1, n, 3) [m] of a beam."""
        return self._beams[name]

    def tension(self, name: str) -> Array:
        """Return zero (1,) for the unknown force of a spring."""
        return np.zeros(1)
