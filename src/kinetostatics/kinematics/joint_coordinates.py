"""Coordinates of joints at given poses, and their limits."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kinetostatics.kinematics.mimic import Couplings
from kinetostatics.kinematics.solver import Solver
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import cross, dot
from kinetostatics.mechanism.tree import Frames


class JointCoordinates:
    """The coordinates of all joints and loops with one freedom."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        self._couplings = Couplings(solver.mechanism, solver.mechanism.tree)
        items = solver.mechanism.connections.values()
        cones = {item.name: _widened(0.0, item.cone.angle) for item in items if item.cone is not None}
        self._limits = {item.name: _widened(item.lower, item.upper) for item in items if item.type.is_single} | cones

    def at(self, q: Array, frames: Frames) -> dict[str, Array]:
        """Return the coordinate (N,) of every one-freedom joint and loop [m, rad].

        Angles of continuous joints that others mimic include full turns.
        """
        result: dict[str, Array] = {}
        by_body = {joint.body: joint for joint in self.solver.mechanism.tree.joints}
        for name, body in self.solver.mechanism.body_of_joint.items():
            joint = by_body[body]
            if joint.nv == 1:
                result[name] = self._couplings.coordinate(joint, q)
        for number, loop in enumerate(self.solver.equations.loops):
            if loop.type.is_single:
                result[loop.name] = self.solver.loop_coordinate(number, frames)
        return result

    def limited(self, q: Array, frames: Frames) -> Iterator[tuple[str, Array, tuple[float, float], Mask]]:
        """Yield name, value (N,), limits, and mask (N,) within them, for every one-freedom joint or loop and every cone."""
        coordinates = self.at(q, frames)
        for item in self.solver.mechanism.connections.values():
            if item.cone is not None:
                u, v = (
                    frames.direction(body, frame[:3, :3] @ np.array(axis))
                    for body, frame, axis in (
                        (item.predecessor_body, item.predecessor_frame, item.cone.predecessor_axis),
                        (item.successor_body, item.successor_frame, item.cone.successor_axis),
                    )
                )
                across = cross(u, v)
                value, limits = np.arctan2(np.sqrt(dot(across, across)), dot(u, v)), (0.0, item.cone.angle)
            elif item.name in coordinates:
                value, limits = coordinates[item.name], (item.lower, item.upper)
            else:
                continue
            least, most = self._limits[item.name]
            yield item.name, value, limits, (value >= least) & (value <= most)


def _widened(lower: float, upper: float) -> Array:
    """Return the limits (2,) [m, rad], each moved outwards by a margin for rounding."""
    slack = 1e-9 * max([1.0, *(abs(limit) for limit in (lower, upper) if math.isfinite(limit))])
    return np.array([lower - slack, upper + slack])
