"""Everything that weighs something: rigid links at their centre of mass, beams evenly along their length."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics import Frames
from kinetostatics.linalg import cross

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]


class Weights:
    """The robot's weights.

    Attributes:
        names: a rigid link's own name, or ``beam:`` and the beam's; those of the limbs in turn, then base, then platform.
        owner: for each of them the limb it belongs to, or ``base`` or ``platform``.
    """

    def __init__(self, robot: Robot) -> None:
        topology, description = robot.topology, robot.description
        parts = [(limb.name, limb.weights) for limb in topology.limbs]
        parts += [("base", topology.base.weights), ("platform", topology.platform.weights)]
        self.names = [name for _, names in parts for name in names]
        self.owner = [owner for owner, names in parts for _ in names]
        self._number = {name: k for k, name in enumerate(self.names)}
        rigid = [name for name in self.names if not name.startswith("beam:")]
        self._beams = [robot.beams[name.removeprefix("beam:")] for name in self.names if name.startswith("beam:")]
        self._is_rigid = np.array([not name.startswith("beam:") for name in self.names], dtype=bool)
        self._mass = np.array([description.links[name].mass for name in rigid])
        placements = [robot.mechanism.body_of[name] for name in rigid]
        self._body = np.array([body for body, _ in placements], dtype=np.intp)
        self._centre = (
            np.array(
                [
                    placement[:3, :3] @ np.array(description.links[name].center_of_mass) + placement[:3, 3]
                    for name, (_, placement) in zip(rigid, placements, strict=True)
                ]
            )
            .reshape(-1, 3)
            .T
        )
        spans = [beam.span for beam in self._beams]
        self._ends = [
            (
                np.array([s.start_body for s in spans], dtype=np.intp),
                np.array([s.start for s in spans]).reshape(-1, 3).T,
            ),
            (np.array([s.end_body for s in spans], dtype=np.intp), np.array([s.end for s in spans]).reshape(-1, 3).T),
        ]

    def masses(self, frames: Frames) -> Array:
        """Return all masses (W, N) [kg]; those of telescopic beams follow the pose."""
        N = frames.position.shape[2]
        result = np.empty((len(self.names), N))
        result[self._is_rigid] = self._mass[:, None]
        if self._beams:
            result[~self._is_rigid] = np.array(
                [
                    np.full(N, beam.mass) if beam.mass_per_length is None else beam.mass_per_length * beam.length(frames)
                    for beam in self._beams
                ]
            )
        return result

    def centres(self, frames: Frames) -> Array:
        """Return all centres of mass (3, W, N) [m]."""
        N = frames.position.shape[2]
        result = np.empty((3, len(self.names), N))
        result[:, self._is_rigid] = frames.points(self._body, self._centre)
        if self._beams:
            start, end = (frames.points(bodies, points) for bodies, points in self._ends)
            result[:, ~self._is_rigid] = (start + end) / 2
        return result

    def wrenches(self, frames: Frames, o: Array, gravity: Array) -> Array:
        """Return the weights' wrenches (6, W, N) about ``o`` (3, N) under ``gravity`` (3, N) [m/s²]."""
        force = self.masses(frames)[None] * gravity[:, None]
        return np.concatenate([force, cross(self.centres(frames) - o[:, None], force)])

    def sum(self, names: Iterable[str], wrenches: Array) -> Array:
        """Return the sum (6, N) of the wrenches (6, W, N) of some weights."""
        which = [self._number[name] for name in names]
        return np.asarray(wrenches[:, which].sum(axis=1))

    def of(self, owner: str) -> NDArray[np.bool_]:
        """Return which weights belong to a limb, to ``base`` or to ``platform``."""
        return np.array([item == owner for item in self.owner], dtype=bool)
