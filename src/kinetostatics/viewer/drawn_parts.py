"""Joints, springs and point masses: positions at F undeformed poses, and twists by each of K contributions (loads, weights)."""

from __future__ import annotations

import os.path
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.elements import Spring
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import axis_across
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.viewer.drawn_poses import DrawnPoses
from kinetostatics.viewer.shapes import carried_along, crossed


@dataclass(frozen=True, eq=False)
class DrawnJoint:
    """A drawn joint; successive hinges with a common centre are drawn as one ball.

    Attributes:
        name: name of the joint; for a ball, the common beginning of the names of its joints.
        joints: names of its joints; a joint that closes a loop has the loop's name.
        links: names of the connected links.
        centre: (F, 3) position at rest [m].
        axis: (F, 3) axis of a joint drawn as a pin; None for a ball.
        twist: (F, K, 6) twists of the centre [m, rad].
        actuated: whether the joint is an actuator.
        beam: name of the telescopic beam that contains the joint, or None.
    """

    name: str
    joints: tuple[str, ...]
    links: frozenset[str]
    centre: Array
    axis: Array | None
    twist: Array
    actuated: bool
    beam: str | None


def find_joints(poses: DrawnPoses) -> list[DrawnJoint]:
    """Return all joints with freedoms, except floating joints without stiffness."""
    robot = poses.robot
    inside = {name: beam for beam, span in robot.topology.spans.items() for name in span.spanned}
    joints: list[DrawnJoint] = []
    size = 1e-7 * (1 + float(np.abs(poses.o).max()))
    for connection in robot.mechanism.connections.values():
        is_free = connection.type.is_free and connection.name not in robot.description.joint_stiffness
        if connection.type.is_fixed or is_free:
            continue
        centre = _centre(poses, connection)
        links = frozenset((connection.predecessor, connection.successor))
        turning = connection.type.is_hinge and not connection.actuated
        before = joints[-1] if joints else None
        if (
            turning and before is not None and before.links & links and not before.actuated and before.beam is None
            and all(robot.mechanism.connections[name].type.is_hinge for name in before.joints)
            and float(np.abs(before.centre - centre).max()) < size
        ):  # fmt: skip
            names = (*before.joints, connection.name)
            common = os.path.commonprefix([before.name, connection.name])  # noqa: RUF071 - of any texts
            common = common.rstrip("_-. ") or names[0]
            joints[-1] = DrawnJoint(common, names, before.links | links, before.centre, None, before.twist, False, None)
            continue
        single = _axis(poses, connection) if connection.type.is_on_axis else None
        joints.append(
            DrawnJoint(
                connection.name, (connection.name,), links, centre, single, _twist(poses, connection, centre),
                connection.actuated, inside.get(connection.name),
            )
        )  # fmt: skip
    return joints


def _centre(poses: DrawnPoses, connection: Connection) -> Array:
    """(F, 3) [m], as a point of the successor."""
    return poses.placed(connection.successor_body, connection.successor_frame)[:, :3, 3]


def _axis(poses: DrawnPoses, connection: Connection) -> Array:
    """(F, 3), as a direction fixed to the predecessor."""
    frame = poses.placed(connection.predecessor_body, connection.predecessor_frame)
    return np.asanyarray(frame[:, :3, :3] @ connection.axis)


def _twist(poses: DrawnPoses, connection: Connection, centre: Array) -> Array:
    """(F, K, 6) [m, rad], of the centre as a point of the successor; of the predecessor if only the predecessor is rigid."""
    rigid = poses.rigid
    link = connection.successor if connection.successor in rigid else connection.predecessor
    return poses.twist_at(link if link in rigid else connection.successor, centre)


def marker_radius(poses: DrawnPoses, joint: DrawnJoint, size: float) -> float:
    """Return the mean radius [m] of the beams at the joint, or of all beams if there are none, within limits."""
    beams = poses.robot.description.beams.values()
    near = [max(beam.section.extent) for beam in beams if beam.link in joint.links]
    some = near or [max(beam.section.extent) for beam in beams] or [0.016 * size]
    return float(np.clip(np.mean(some), 0.006 * size, 0.05 * size))


#: Density of steel [kg/m³]; point masses are drawn as steel balls.
STEEL = 7850.0


@dataclass(frozen=True, eq=False)
class DrawnSpring:
    """One spring at F poses.

    Attributes:
        description: the spring of the robot's description.
        ends: positions (F, 3) of its two ends at rest [m].
        twists: twists (F, K, 6) of its two ends [m, rad].
        tension: (F,) force, tension positive [N].
    """

    description: Spring
    ends: tuple[Array, Array]
    twists: tuple[Array, Array]
    tension: Array

    @property
    def links(self) -> tuple[str, str]:
        return self.description.predecessor, self.description.successor

    @property
    def length(self) -> Array:
        """(F,) at rest [m]."""
        return np.asanyarray(np.linalg.norm(self.ends[1] - self.ends[0], axis=-1))

    @property
    def direction(self) -> Array:
        """(F, 3) unit vector from the first end to the second; zero at zero length."""
        length = self.length[:, None]
        return np.asanyarray((self.ends[1] - self.ends[0]) / np.where(length > 0, length, 1.0))

    def frames(self) -> Array:
        """(F, 4, 4), origin at the first end, z towards the second; from pose to pose they turn about z as little as possible."""
        result = zeros_for((len(self.length), 4, 4), self.direction)
        result[:] = np.eye(4)
        z = self.direction
        z = np.where(np.any(z != 0, axis=-1, keepdims=True), z, [0.0, 0.0, 1.0])
        x = carried_along(axis_across(z[0]), z)
        result[:, :3, 0], result[:, :3, 1], result[:, :3, 2] = x, crossed(z, x), z
        result[:, :3, 3] = self.ends[0]
        return result


def find_springs(poses: DrawnPoses) -> list[DrawnSpring]:
    springs = []
    for name, spring in poses.robot.description.springs.items():
        ends, twists = [], []
        for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
            frame = poses.frame(link)
            ends.append(frame[:, :3, :3] @ np.array(local) + frame[:, :3, 3])
            twists.append(poses.twist_at(link, ends[-1]))
        springs.append(DrawnSpring(spring, (ends[0], ends[1]), (twists[0], twists[1]), poses.tension(name)))
    return springs


def find_masses_at_points(poses: DrawnPoses, with_visuals: Collection[str]) -> dict[str, Array]:
    """Return positions (F, 3) [m] of links that have a mass, but no moments of inertia, beams or visuals."""
    positions, description = {}, poses.robot.description
    others = {*with_visuals, *(link.link for link in description.elastic_links.values())}
    for name, link in description.links.items():
        if link.mass > 0 and not any(link.inertia.moments) and name not in others:
            positions[name] = (poses.frame(name) @ np.array([*link.center_of_mass, 1.0]))[:, :3]
    return positions


def radius_of_ball(mass: float, size: float) -> float:
    """Return the radius [m] of a steel ball of this mass [kg], limited to 1 to 6 % of the robot's size [m]."""
    return float(np.clip((3 * mass / (4 * np.pi * STEEL)) ** (1 / 3), 0.01 * size, 0.06 * size))
