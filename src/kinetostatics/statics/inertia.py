"""Inertial loads (d'Alembert) of moving links and beams.

A rigid link of mass m and inertia J about its centre of mass G, with angular velocity ω and angular acceleration α, is loaded by
the force −m a_G and the moment −(J α + ω × J ω). Along a beam of mass μ per length, the acceleration a and the load −μ a per
length vary linearly between its ends; the rotary inertia of the sections is a moment per length. A telescopic beam stretches: the
velocity of its mass m at the pose varies linearly between the velocities v₁, v₂ of its ends, with the kinetic energy
m (v₁² + v₁·v₂ + v₂²)/6, whichever link has the beam. At its ends, the beam loads the rest of the robot
by the opposites of the reactions that it would have if clamped at both ends. Displacements and section forces of the beam are the
sum of two parts: one of the clamped beam, one due to these end loads.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import cross, least_squares
from kinetostatics.math.screws import move_wrench
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, LinkLoads
from kinetostatics.statics.robot_statics import RobotStatics

#: The name of the contribution.
INERTIA = "inertia"


def inertial_load(
    robot: RobotStatics, frames: Frames, twists: Array, rates: Array, local: Array, payload: LinkLoads | None
) -> AppliedLoad:
    """Return the inertial loads of a moving robot at N poses.

    A mass m with the inertia J at c exerts −m c″ and −(J α + ω × J ω). Local freedoms accelerate so that no inertial force acts
    along them, since no actuator or spring acts there.

    Args:
        twists: (6, B, N) twists of all bodies at the world's origin, world axes [m/s, rad/s].
        rates: (6, B, N) time derivatives of the twists if local freedoms do not move [m/s², rad/s²].
        local: (6, B, k, N) twists of all bodies per unit of each of the k local freedoms.
        payload: payload and loads on links, broadcast to the N poses; only masses have inertia.
    """

    def moving(rates: Array) -> _InertialLoads:
        return _InertialLoads(robot, frames, twists, rates, payload)

    found, k = moving(rates), local.shape[2]
    if k:
        more = np.stack([moving(rates + local[:, :, m]).by_body - found.by_body for m in range(k)], axis=2)
        mass = np.einsum("ibkn,ibmn->kmn", local, more)
        forces = np.einsum("ibkn,ibn->kn", local, found.by_body)
        found = moving(rates - np.einsum("ibkn,kn->ibn", local, least_squares(mass, forces[:, None])[:, 0]))
    return AppliedLoad(INERTIA, found.wrenches, found.points, "load", found.lines)


class _InertialLoads:
    """Inertial loads at N poses: ``wrenches``, ``points`` and ``lines`` as in :class:`AppliedLoad`, and wrenches by body."""

    def __init__(self, robot: RobotStatics, frames: Frames, twists: Array, rates: Array, payload: LinkLoads | None) -> None:
        self.robot, self.frames, self.twists, self.rates = robot, frames, twists, rates
        _, self.o = robot.mechanism.platform_pose(frames)
        self.wrenches: dict[str, Array] = {}
        self.points: dict[str, Array] = {}
        self.lines: dict[str, Array] = {}
        self.by_body = np.zeros(twists.shape)  # about the world's origin
        for name in robot.weights.names:
            if name.startswith("beam:"):
                self._add_link(name.removeprefix("beam:"))
            else:
                body, own = robot.mechanism.body_of[name][0], robot.weights.inertias[name]
                self._add_mass(name, body, frames.rotation[:, :, body], frames.point(body, own.lever), own.mass, own.inertia)
        for attachment, body, point, mass, R, inertia in payload.masses(frames) if payload is not None else ():
            self._add_mass(attachment, body, R, point, mass, inertia)

    def _acceleration(self, body: int, point: Array) -> Array:
        """Return the acceleration v̇ + α × p + ω × (v + ω × p) (3, N) [m/s²] of a point p (3, N) of a body."""
        v, w = self.twists[:3, body], self.twists[3:, body]
        return self.rates[:3, body] + cross(self.rates[3:, body], point) + cross(w, v + cross(w, point))

    def _couple(self, body: int, R: Array, inertia: Array) -> Array:
        """Return −(J α + ω × J ω) (3, N) of an inertia J (3, 3) or (3, 3, N), given in the axes R (3, 3, N)."""
        full = np.broadcast_to(inertia if inertia.ndim == 3 else inertia[:, :, None], R.shape)
        world = np.einsum("ijn,jkn,lkn->iln", R, full, R)
        w = self.twists[3:, body]
        momentum = np.einsum("ijn,jn->in", world, w)
        return -np.einsum("ijn,jn->in", world, self.rates[3:, body]) - cross(w, momentum)

    def _add_mass(self, attachment: str, body: int, R: Array, centre: Array, mass: Array | float, inertia: Array) -> None:
        wrench = np.concatenate([-mass * self._acceleration(body, centre), self._couple(body, R, inertia)])
        self._put(attachment, body, wrench, centre)

    def _add_link(self, name: str) -> None:
        """Add the load of a beam or other elastic link, whose ends are the start of its spans, and the end of each."""
        links, topology, frames = self.robot.elastic_links, self.robot.topology, self.frames
        line, wrenches = links[name].inertial_load(frames, self._acceleration, self._couple)
        if line is not None:
            self.lines[name] = line
        for wrench, (key, end, attachment) in zip(wrenches, topology.interfaces(name), strict=True):
            body = (links[key].span.start_body, links[key].span.end_body)[end]
            self._put(attachment, body, wrench, links[key].ends(frames)[end])

    def _put(self, attachment: str, body: int, wrench: Array, point: Array) -> None:
        """Add a wrench (6, N) about a point (3, N) [m] to the wrenches of an attachment and of a body."""
        self.by_body[:, body] += move_wrench(wrench, -point)
        self.wrenches[attachment] = self.wrenches.get(attachment, 0.0) + move_wrench(wrench, self.o - point)
        self.points.setdefault(attachment, point)
