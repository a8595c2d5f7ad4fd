"""A robot without loads, and the free motions of its platform, for poses that are not or cannot be analysed."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import logarithm
from kinetostatics.math.screws import describe_twist
from kinetostatics.mechanism.tree import Frames
from kinetostatics.results.parts import FRACTIONS
from kinetostatics.robot import Robot, robot_of
from kinetostatics.viewer.drawn_poses import moved
from kinetostatics.viewer.standing import StandingPose

#: Step of the difference quotient for the twists of links in a free motion [scaled m, rad].
STEP = 1e-5


class UnloadedPose(StandingPose):
    """One pose of a robot, F = 1, or its tree as the file has it.

    The contributions are the free motions of the platform with locked actuators, of arbitrary magnitude.

    Args:
        shown: a pose; or a robot, drawn at its zero pose, or with all joints at zero if its loops cannot be closed.
        message: reason why the pose cannot be analysed.
    """

    def __init__(self, shown: Configuration | Robot, message: str | None = None) -> None:
        self.robot = robot_of(shown) if isinstance(shown, Configuration) else shown
        self.rigid = self.robot.mechanism.body_of  # all links
        self.configuration = shown if isinstance(shown, Configuration) else None
        self.frames, self.poses, found = self._placed()
        self.message = message or found
        self.sources = self.labels = self._names()

    def _placed(self) -> tuple[Frames, SolverState | None, str | None]:
        """Return frames of the bodies, the closed pose or None, and the reason for None."""
        if self.configuration is not None:
            return self.configuration.frames, self.configuration.poses, None
        try:
            return self.robot.zero_frames, self.robot.zero_poses, None
        except KinetostaticsError as error:
            neutral = self.robot.mechanism.tree.neutral[:, None]
            return self.robot.frames_at(neutral), None, str(error)

    @cached_property
    def _free_motions(self) -> tuple[Array, Array]:
        """The platform's free twists at o (6, k) [m, rad], and the rates (nv, k) of the tree's freedoms."""
        robot, nv = self.robot, self.robot.mechanism.tree.nv
        if self.poses is None or not np.all(np.isfinite(self.frames.position)):
            return np.zeros((6, 0)), np.zeros((nv, 0))
        return robot.mobility_analysis.free_motions(robot.actuator_coordinates, self.poses)

    def _names(self) -> tuple[str, ...]:
        count = self._free_motions[0].shape[1]
        return ("free motion",) if count == 1 else tuple(f"free motion {k + 1}" for k in range(count))

    @property
    def notes(self) -> list[str]:
        """Notes of the page."""
        words = "; ".join(describe_twist(twist, self.robot.length) for twist in self._free_motions[0].T)
        if self.message is None and words:
            return [f"with the actuators locked the platform can still move: {words}"]
        return [self.message] if self.message else []

    @property
    def platform_twist(self) -> Array:
        """(1, k, 6) the free motions of the platform, at o."""
        return self._twist(*self.robot.mechanism.platform_frame)

    def link_twist(self, link: str) -> Array:
        """Return the free motions (1, k, 6) of a link at its own origin."""
        return self._twist(*self.robot.mechanism.body_of[link])

    def _twist(self, body: int, placement: Array) -> Array:
        """Return the free motions (1, k, 6) of a frame of a body, at its origin."""
        plus, minus = (np.moveaxis(frames.matrices(body, placement), -1, 0) for frames in self._stepped)
        turn = np.moveaxis(plus[:, :3, :3] @ np.swapaxes(minus[:, :3, :3], 1, 2), 0, -1)
        return np.concatenate([plus[:, :3, 3] - minus[:, :3, 3], logarithm(turn).T], axis=1)[None] / (2 * STEP)

    @cached_property
    def _stepped(self) -> tuple[Frames, Frames]:
        """The frames after a step along each of k free motions, and after a step backwards."""
        rates = self._free_motions[1]
        if self.poses is None or not rates.shape[1]:
            none = self.frames.take(slice(0, 0))
            return none, none
        start = self.poses.take(np.zeros(rates.shape[1], dtype=np.intp))
        forth, back = (
            self.robot.frames_of(SolverState(self.robot.solver.tree.integrate(start.x, sign * STEP * rates), start.c))
            for sign in (1, -1)
        )
        return forth, back

    def beam_twists(self, name: str) -> Array:
        """Return the free motions (1, k, n, 6) of the stations of a beam, straight between its ends."""
        span, (_, points) = self.robot.topology.beams[name], self.beam_line(name)
        ends = []
        for body, point in ((span.start_body, points[:, 0]), (span.end_body, points[:, -1])):
            ends.append(moved(self._twist(body, np.eye(4)), point - self.frames.position[:, body].T))
        part = FRACTIONS[:, None]
        return (1 - part) * ends[0][:, :, None] + part * ends[1][:, :, None]
