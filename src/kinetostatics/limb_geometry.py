"""Where joints, beams and springs of limbs that are built alike are: unit twists, centres, limb axes, beam axes at many poses.

All of them are fixed in bodies of the robot. Arrays are ``(component, member, limb, pose)``, world axes, arms from o.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.beam_models import BeamModel
from kinetostatics.kinematics import Frames
from kinetostatics.limb_joints import Unit, sides
from kinetostatics.linalg import cross, dot, normalize
from kinetostatics.springs import Spring
from kinetostatics.topology import Limb

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LimbGeometry:
    """What N poses of a group of g limbs look like; all arms are from o [m], world axes.

    Attributes:
        axes: (3, k, g, N) axes of all freedoms.
        twists: (6, k, g, N) unit twists of all freedoms about o, outboard relative to inboard: the columns behind Eqs. (2), (4).
        centres: (3, units + 1, g, N) joint centres, and the limb's outer end.
        limb_axes: (3, 3, g, N) columns x, y, z; z along the limb.
        beam_axes: (3, 3, beams, g, N).
        beam_lengths: (beams, g, N) [m].
        beam_ends: (3, beams, g, N) outer ends.
        spring_axes: (3, 3, springs, g, N) axes of the sprung joints' frames.
        spring_arms: (3, springs, g, N) their origins.
    """

    axes: Array
    twists: Array
    centres: Array
    limb_axes: Array
    beam_axes: Array
    beam_lengths: Array
    beam_ends: Array
    spring_axes: Array
    spring_arms: Array


class LimbSkeleton:
    """What of alike limbs has a place, fixed in the robot's bodies.

    Attributes:
        freedoms: of every limb, the freedoms of its joints, inboard ones first.
        rotates: (k,) which of them are rotations.
        passive: (k,) which of them are passive.
        unit_of: (k,) the unit that each belongs to.
        y_choice: what the limbs' y axis follows: ``("axis", f)`` or ``("world", -1)``.
    """

    def __init__(
        self,
        robot: Robot,
        limbs: Sequence[Limb],
        units: Sequence[Sequence[Unit]],
        beams: Sequence[Sequence[BeamModel]],
        springs: Sequence[Sequence[Spring]],
    ) -> None:
        self._units = units[0]
        self.freedoms = rows = [[freedom for unit in row for freedom in unit.freedoms] for row in units]
        self.rotates = np.array([freedom.rotates for freedom in rows[0]], dtype=bool)
        self.passive = np.array([freedom.passive for freedom in rows[0]], dtype=bool)
        self.unit_of = np.array([k for k, unit in enumerate(units[0]) for _ in unit.freedoms], dtype=np.intp)
        self._axes = _Members([[f.body for f in row] for row in rows], [[f.axis for f in row] for row in rows])
        self._centres = _Members([[f.centre_body for f in row] for row in rows], [[f.centre for f in row] for row in rows])
        self._sign = np.array([[f.sign for f in row] for row in rows], dtype=float).reshape(len(rows), -1).T[..., None]
        outer = [_outer_point(robot, limb) for limb in limbs]
        self._outer_points = _Members([[body] for body, _ in outer], [[point] for _, point in outer])
        spans = [[beam.span for beam in row] for row in beams]
        self._beam_starts = _Members([[s.start_body for s in row] for row in spans], [[s.start for s in row] for row in spans])
        self._beam_ends = _Members([[s.end_body for s in row] for row in spans], [[s.end for s in row] for row in spans])
        self._beam_axes = _Members([[s.carrier for s in row] for row in spans], [[m.axes for m in row] for row in beams], (3, 3))
        bodies = [[spring.body for spring in row] for row in springs]
        self._spring_axes = _Members(bodies, [[spring.frame[:3, :3] for spring in row] for row in springs], (3, 3))
        self._spring_points = _Members(bodies, [[spring.frame[:3, 3] for spring in row] for row in springs])
        self._last_freedoms = [int(np.flatnonzero(self.unit_of == u)[-1]) for u in range(len(self._units))]
        z = self._limb_z(robot.zero_frames)[:, :, 0]
        self.y_choice = self._choose_y(robot.zero_frames, z[:, 0])
        self._world_y = np.eye(3)[:, np.argmin(np.abs(z), axis=0)]

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        """Evaluate the limbs at given frames; ``o`` (3, N) is the reference point [m]."""
        o = o[:, None, None]
        axes = self._axes.directions(frames)
        arms = self._centres.points(frames) - o
        twists = np.empty((6, *axes.shape[1:]))
        slides = np.flatnonzero(~self.rotates)
        twists[:3], twists[3:] = cross(arms, axes), axes
        twists[:3, slides], twists[3:, slides] = axes[:, slides], 0.0
        if np.any(self._sign < 0):
            twists *= self._sign
        centres = np.concatenate([arms[:, self._last_freedoms], self._outer_points.points(frames) - o], axis=1)
        beam_axes = self._beam_axes.orientations(frames)
        end = self._beam_ends.points(frames)
        lengths = dot(beam_axes[:, 0], end - self._beam_starts.points(frames))
        z = self._limb_z(frames)
        follow = axes[:, self.y_choice[1]] if self.y_choice[0] == "axis" else self._world_y[:, :, None]
        y = normalize(follow - z * dot(z, follow))
        return LimbGeometry(
            axes=axes,
            twists=twists,
            centres=centres,
            limb_axes=np.stack([cross(y, z), y, z], axis=1),
            beam_axes=beam_axes,
            beam_lengths=lengths,
            beam_ends=end - o,
            spring_axes=self._spring_axes.orientations(frames),
            spring_arms=self._spring_points.points(frames) - o,
        )

    def _limb_z(self, frames: Frames) -> Array:
        """Return the limbs' z axes (3, g, N): along the last beam, else from the first joint to the outer end, else up."""
        if self._beam_axes.count:
            return self._beam_axes.orientations(frames)[:, 0, -1]
        outer = self._outer_points.points(frames)[:, 0]
        if len(self.passive):
            axis = outer - self._centres.points(frames)[:, 0]
            if float(np.min(np.sqrt(dot(axis, axis)), initial=1.0)) > 1e-9:
                return normalize(axis)
        up = np.zeros_like(outer)
        up[2] = 1
        return up

    def _choose_y(self, frames: Frames, z: Array) -> tuple[str, int]:
        """Choose what the y axis across ``z`` (3,) follows: a passive revolute, else a universal's axis, else a world axis."""
        axes = self._axes.directions(frames)[:, :, 0, 0]
        for kinds in (("revolute", "continuous", "cylindrical"), ("universal",)):
            for k, unit in enumerate(self._units):
                for f in np.flatnonzero(self.unit_of == k):
                    if unit.kind in kinds and self.passive[f] and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                        return "axis", int(f)
        return "world", -1


class _Members:
    """Bodies and local vectors of the k-th member of g limbs, as the frames want them: member by member, limb by limb."""

    def __init__(self, bodies: list[list[int]], vectors: list[list[Array]], shape: tuple[int, ...] = (3,)) -> None:
        g, k = len(bodies), len(bodies[0])
        self.count, self.limbs = k, g
        self.bodies = np.array(bodies, dtype=np.intp).reshape(g, k).T.ravel()
        stacked = np.array(vectors, dtype=float).reshape(g, k, *shape)
        self.vectors = np.moveaxis(stacked, (0, 1), (-1, -2)).reshape(*shape, k * g)

    def points(self, frames: Frames) -> Array:
        """Return world positions (3, k, g, N)."""
        if not self.count:  # which indexing would pay for
            return np.zeros((3, 0, self.limbs, frames.position.shape[2]))
        return self._shaped(frames.points(self.bodies, self.vectors))

    def directions(self, frames: Frames) -> Array:
        """Return world directions (3, k, g, N)."""
        return self._shaped(frames.directions(self.bodies, self.vectors))

    def orientations(self, frames: Frames) -> Array:
        """Return world orientations (3, 3, k, g, N)."""
        if not self.count:
            return np.zeros((3, 3, 0, self.limbs, frames.position.shape[2]))
        return self._shaped(frames.orientations(self.bodies, self.vectors))

    def _shaped(self, array: Array) -> Array:
        return array.reshape(*array.shape[:-2], self.count, self.limbs, array.shape[-1])


def _outer_point(robot: Robot, limb: Limb) -> tuple[int, Array]:
    """Return body and point (3,) [m] of a limb's outer end: its last joint's or beam's."""
    edge = limb.edges[-1]
    if edge.beam:
        span = robot.beams[edge.beam].span
        return span.end_body, span.end
    connection = robot.mechanism.connections[str(edge.joint)]
    body, frame = sides(edge, connection)[1]
    return body, frame[:3, 3]
