"""Modes of vibration as contributions to the displacements of a scene, and their data for the panel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import taken
from kinetostatics.layout.numbers import NumberFormat
from kinetostatics.math.arrays import Array
from kinetostatics.reports.dynamics import HERTZ, NONE, per_cent
from kinetostatics.reports.pose import count as counted
from kinetostatics.results.dynamics import Modes
from kinetostatics.viewer.shown_poses import place_of
from kinetostatics.viewer.standing import StandingPose

#: Largest number of parts with shares of energy in the panel.
MOST = 6


@dataclass(frozen=True)
class DrawnMode:
    """Texts on a mode: name, frequency, effective masses [%] by direction, and largest shares of energy [%] by part."""

    name: str
    frequency: str
    masses: list[str]
    strain: list[tuple[str, str]]
    kinetic: list[tuple[str, str]]


class ModePoses(StandingPose):
    """One pose of a robot, F = 1; the contributions are its modes, for a modal mass of 1 kg.

    Args:
        modes: modes of one pose or a batch.
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
        self.sources = self.labels = tuple(f"mode {k + 1}" for k in range(int(np.sum(self._found))))

    def _at_pose(self, array: Array) -> Array:
        """Return the shown pose of an array (*batch, …) of the modes."""
        return np.asarray(array.reshape(-1, *array.shape[len(self.modes.shape) :])[self._place])

    def _of_modes(self, array: Array) -> Array:
        """Return the modes (1, K, …) of an array (*batch, count, …)."""
        return self._at_pose(array)[self._found][None]

    @property
    def drawn(self) -> list[DrawnMode]:
        """Texts on all modes."""
        frequencies, masses = self._of_modes(self.modes.frequencies)[0], self._of_modes(self.modes.effective_masses)[0]
        form = NumberFormat.of(frequencies[:1], HERTZ, digits=4)
        return [
            DrawnMode(
                f"{name} of {len(self.sources)}", form.with_unit(frequencies[k]), [per_cent(part) for part in masses[k]],
                self._largest(self.modes.strain_energy_shares, k), self._largest(self.modes.kinetic_energy_shares, k),
            )
            for k, name in enumerate(self.sources)
        ]  # fmt: skip

    def _largest(self, shares: Mapping[str, Array], mode: int) -> list[tuple[str, str]]:
        found = {name: float(self._of_modes(part)[0, mode]) for name, part in shares.items()}
        ranked = sorted(found, key=lambda name: -round(found[name], 6))[:MOST]
        return [(name, per_cent(found[name])) for name in ranked if found[name] > NONE]

    @property
    def notes(self) -> list[str]:
        """Notes of the page."""
        zero = int(self._at_pose(self.modes.zero_frequencies))
        return [f"nothing resists {counted(zero, 'motion')}, of frequency zero, left out here"] if zero else []

    @property
    def platform_twist(self) -> Array:
        """(1, K, 6) twist of the platform, at o."""
        return self._of_modes(self.modes.twists)

    def link_twist(self, link: str) -> Array | None:
        """Return the twists (1, K, 6) of a link at its own origin; None if it contains a beam."""
        return self._of_modes(self.modes.link_twists[link]) if link in self.rigid else None

    def beam_twists(self, name: str) -> Array:
        """Return displacement and rotation (1, K, n, 6) of the stations of a beam."""
        return self._of_modes(self.modes.beam_lines[name])
