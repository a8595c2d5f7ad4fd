"""One pose of a robot, drawn without loads: with the free motions of its platform, or with its modes of vibration."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.elements.beam import BeamModel
from kinetostatics.elements.static_model import make_beam_models
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration, taken
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.numbers import NumberFormat
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import logarithm
from kinetostatics.math.screws import describe_twist
from kinetostatics.mechanism.tree import Frames
from kinetostatics.reports.dynamics import HERTZ, NONE, per_cent
from kinetostatics.reports.pose import count as counted
from kinetostatics.results.dynamics import Modes
from kinetostatics.results.parts import FRACTIONS
from kinetostatics.robot import Robot, robot_of
from kinetostatics.sections.kinds import Section
from kinetostatics.viewer.drawn_poses import DrawnPoses, moved, place_of


class SinglePose(DrawnPoses):
    """One pose of a robot, F = 1; forces of springs are unknown.

    Attributes:
        configuration: the pose; None if the loops of the robot cannot be closed.
        frames: frames of the bodies.
    """

    count, step = 1, 1
    configuration: Configuration | None
    frames: Frames

    @property
    @abstractmethod
    def notes(self) -> list[str]:
        """Notes of the page."""

    def placed(self, body: int, placement: Array) -> Array:
        return np.moveaxis(self.frames.matrices(body, placement), -1, 0)

    @cached_property
    def _models(self) -> Mapping[str, BeamModel]:
        return make_beam_models(self.robot.mechanism, self.robot.topology.spans, self.frames)

    @cached_property
    def _beams(self) -> dict[str, tuple[Array, Array]]:
        lines = {}
        for name, model in self._models.items():
            start, end = (point.T for point in model.ends(self.frames))
            axes = self.frames.rotation[:, :, model.span.carrier, 0] @ model.axes
            lines[name] = axes[None], start[:, None] + FRACTIONS[:, None] * (end - start)[:, None]
        return lines

    def beam_line(self, name: str) -> tuple[Array, Array]:
        return self._beams[name]

    def section(self, name: str) -> Section:
        return self._models[name].section

    def tension(self, name: str) -> Array:
        """Return zero (1,) in place of the unknown force."""
        return np.zeros(1)


#: Step of the difference quotient for twists of links, as a part of a free motion.
STEP = 1e-5


class UnloadedPose(SinglePose):
    """One pose of a robot, F = 1; its contributions are the platform's free motions, of arbitrary magnitude.

    Args:
        shown: a pose; or a robot, drawn at its zero pose, or with all joints at zero if its loops cannot be closed.
        message: the reason if the pose cannot be analysed.
    """

    def __init__(self, shown: Configuration | Robot, message: str | None = None) -> None:
        self.robot = robot_of(shown) if isinstance(shown, Configuration) else shown
        self.rigid = self.robot.mechanism.body_of  # all links
        self.configuration = shown if isinstance(shown, Configuration) else None
        self.frames, self.poses, reason = self._placed()
        self.message = message or reason
        self.contribution_names = self.labels = self._names()

    def _placed(self) -> tuple[Frames, SolverState | None, str | None]:
        """Return the frames of the bodies; the closed pose, or None; and the reason if the loops cannot be closed, or None."""
        if self.configuration is not None:
            return self.configuration.frames, self.configuration.poses, None
        try:
            return self.robot.zero_frames, self.robot.zero_poses, None
        except KinetostaticsError as error:
            neutral = self.robot.mechanism.tree.neutral[:, None]
            return self.robot.frames_at(neutral), None, str(error)

    @cached_property
    def _free_motions(self) -> tuple[Array, Array]:
        """The platform's k free twists at o (6, k) [m, rad], and the rates (nv, k) of the tree's joint coordinates."""
        robot, nv = self.robot, self.robot.mechanism.tree.nv
        if self.poses is None or not np.all(np.isfinite(self.frames.position)):
            return np.zeros((6, 0)), np.zeros((nv, 0))
        return robot.mobility_analysis.free_motions(robot.actuator_coordinates, self.poses)

    def _names(self) -> tuple[str, ...]:
        count = self._free_motions[0].shape[1]
        return ("free motion",) if count == 1 else tuple(f"free motion {k + 1}" for k in range(count))

    @property
    def notes(self) -> list[str]:
        words = "; ".join(describe_twist(twist, self.robot.length) for twist in self._free_motions[0].T)
        if self.message is None and words:
            return [f"with the actuators locked the platform can still move: {words}"]
        return [self.message] if self.message else []

    @property
    def platform_twist(self) -> Array:
        return self._twist(*self.robot.mechanism.platform_frame)

    def link_twist(self, link: str) -> Array:
        return self._twist(*self.robot.mechanism.body_of[link])

    def _twist(self, body: int, placement: Array) -> Array:
        """Return the k free motions (1, k, 6) of a body at the origin of the frame ``placement`` on it."""
        plus, minus = (np.moveaxis(frames.matrices(body, placement), -1, 0) for frames in self._stepped)
        turn = np.moveaxis(plus[:, :3, :3] @ np.swapaxes(minus[:, :3, :3], 1, 2), 0, -1)
        return np.concatenate([plus[:, :3, 3] - minus[:, :3, 3], logarithm(turn).T], axis=1)[None] / (2 * STEP)

    @cached_property
    def _stepped(self) -> tuple[Frames, Frames]:
        """The frames after a small step forwards along each of k free motions, and after a small step backwards."""
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
        """Return twists (1, k, n, 6) of a beam's stations, interpolated linearly between its ends."""
        span, (_, points) = self.robot.topology.spans[name], self.beam_line(name)
        ends = []
        for body, point in ((span.start_body, points[:, 0]), (span.end_body, points[:, -1])):
            ends.append(moved(self._twist(body, np.eye(4)), point - self.frames.position[:, body].T))
        part = FRACTIONS[:, None]
        return (1 - part) * ends[0][:, :, None] + part * ends[1][:, :, None]


#: Largest number of parts in the panel's tables of energies.
MOST = 6


@dataclass(frozen=True)
class DrawnMode:
    """Texts on a mode: frequency, effective masses [%] by direction, and parts with the largest shares of energy [%]."""

    name: str
    frequency: str
    masses: list[str]
    strain: list[tuple[str, str]]
    kinetic: list[tuple[str, str]]


class ModePoses(SinglePose):
    """One pose of a robot, F = 1; its contributions are its modes of vibration, of modal mass 1 kg.

    Args:
        modes: modes at one pose or a batch of poses.
        pose: index of one pose of a batch.

    Raises:
        ArgumentError: the index of a pose is missing, or the pose has no modes.
    """

    def __init__(self, modes: Modes, pose: int | tuple[int, ...] | None = None) -> None:
        if modes.shape and pose is None:
            raise ArgumentError(f"modes are shown at one pose, and the result has the shape {modes.shape}: choose one by pose=")
        self.modes, self.robot, self.rigid = modes, modes.robot, modes.link_twists
        self._place = 0 if pose is None else place_of(modes.shape, pose)
        self.configuration = taken(modes.configuration, np.array([self._place]), ())
        self.frames = self.configuration.frames
        self._found = np.isfinite(self._at_pose(modes.frequencies))
        if not np.any(self._found):
            raise ArgumentError("the robot has no modes at this pose, so there is nothing to show")
        self.contribution_names = self.labels = tuple(f"mode {k + 1}" for k in range(int(np.sum(self._found))))

    def _at_pose(self, array: Array) -> Array:
        """Return the entry (…) of an array (*batch, …) at the drawn pose."""
        return np.asarray(array.reshape(-1, *array.shape[len(self.modes.shape) :])[self._place])

    def _of_modes(self, array: Array) -> Array:
        """Return the entries (1, K, …) of an array (*batch, count, …) at the drawn pose, for the K modes found."""
        return self._at_pose(array)[self._found][None]

    @property
    def drawn(self) -> list[DrawnMode]:
        frequencies, masses = self._of_modes(self.modes.frequencies)[0], self._of_modes(self.modes.effective_masses)[0]
        form = NumberFormat.of(frequencies[:1], HERTZ, digits=4)
        return [
            DrawnMode(
                f"{name} of {len(self.labels)}", form.with_unit(frequencies[k]), [per_cent(part) for part in masses[k]],
                self._largest(self.modes.strain_energy_shares, k), self._largest(self.modes.kinetic_energy_shares, k),
            )
            for k, name in enumerate(self.contribution_names)
        ]  # fmt: skip

    def _largest(self, shares: Mapping[str, Array], mode: int) -> list[tuple[str, str]]:
        energies = {name: float(self._of_modes(part)[0, mode]) for name, part in shares.items()}
        ranked = sorted(energies, key=lambda name: -round(energies[name], 6))[:MOST]
        return [(name, per_cent(energies[name])) for name in ranked if energies[name] > NONE]

    @property
    def notes(self) -> list[str]:
        zero = int(self._at_pose(self.modes.zero_frequencies))
        return [f"nothing resists {counted(zero, 'motion')}, of frequency zero, left out here"] if zero else []

    @property
    def platform_twist(self) -> Array:
        return self._of_modes(self.modes.twists)

    def squares_and_gravity(self, name: str) -> tuple[Array, Array]:
        return (2 * np.pi * self._of_modes(self.modes.frequencies)) ** 2, super().squares_and_gravity(name)[1]

    def link_twist(self, link: str) -> Array | None:
        return self._of_modes(self.modes.link_twists[link]) if link in self.rigid else None

    def beam_twists(self, name: str) -> Array:
        return self._of_modes(self.modes.beam_lines[name])

    def interface_twists(self, name: str) -> Array:
        return self._of_modes(self.modes.interface_twists[name])
