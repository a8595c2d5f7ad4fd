"""Positions, shapes and motions of joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.viewer.drawn_poses import DrawnPoses


@dataclass(frozen=True, eq=False)
class DrawnJoint:
    """A joint as drawn; consecutive hinges about one point are drawn as one ball.

    Attributes:
        name: name of the joint, or common start of the names of a ball's joints.
        joints: names of the joints or loops.
        links: links that it connects.
        centre: (F, 3) position at rest [m].
        axis: (F, 3) axis of a joint with one axis, drawn as a pin; None for a ball.
        twist: (F, K, 6) twist of the centre by each contribution [m, rad].
        driven: whether it is an actuator.
        beam: name of the telescopic beam that contains it, or None.
    """

    name: str
    joints: tuple[str, ...]
    links: frozenset[str]
    centre: Array
    axis: Array | None
    twist: Array
    driven: bool
    beam: str | None


def find_joints(poses: DrawnPoses) -> list[DrawnJoint]:
    """Return all joints with freedoms, except floating ones."""
    robot = poses.robot
    inside = {name: beam for beam, span in robot.topology.beams.items() for name in span.spanned}
    found: list[DrawnJoint] = []
    size = 1e-7 * (1 + float(np.abs(poses.o).max()))
    for connection in robot.mechanism.connections.values():
        loose = connection.type.is_free and connection.name not in robot.description.joint_stiffness
        if connection.type.is_fixed or loose:
            continue  # fixed joints and free bodies are not drawn
        centre = _centre(poses, connection)
        links = frozenset((connection.predecessor, connection.successor))
        turning = connection.type.is_hinge and not connection.driven
        before = found[-1] if found else None
        if (
            turning and before is not None and before.links & links and not before.driven and before.beam is None
            and all(robot.mechanism.connections[name].type.is_hinge for name in before.joints)
            and float(np.abs(before.centre - centre).max()) < size
        ):  # fmt: skip
            names = (*before.joints, connection.name)
            common = _common_start(before.name, connection.name).rstrip("_-. ") or names[0]
            found[-1] = DrawnJoint(common, names, before.links | links, before.centre, None, before.twist, False, None)
            continue
        single = _axis(poses, connection) if connection.type.is_on_axis else None
        found.append(
            DrawnJoint(
                connection.name, (connection.name,), links, centre, single, _twist(poses, connection, centre),
                connection.driven, inside.get(connection.name),
            )
        )  # fmt: skip
    return found


def _centre(poses: DrawnPoses, connection: Connection) -> Array:
    """Return the centre (F, 3), on the successor's side."""
    successor = poses.frame(connection.successor)
    if not connection.is_loop:
        return successor[:, :3, 3]
    outer = poses.robot.description.loops[connection.name].successor_origin.matrix[:3, 3]
    return np.asarray(successor[:, :3, :3] @ outer + successor[:, :3, 3])


def _axis(poses: DrawnPoses, connection: Connection) -> Array:
    """Return the axis (F, 3), on the predecessor's side."""
    description = poses.robot.description
    if connection.is_loop:
        inner = description.loops[connection.name].predecessor_origin.matrix
    else:
        inner = description.joints[connection.name].origin.matrix
    return np.asarray(poses.frame(connection.predecessor)[:, :3, :3] @ (inner[:3, :3] @ connection.axis))


def _twist(poses: DrawnPoses, connection: Connection, centre: Array) -> Array:
    """Return the twist of the centre, as a point of the rigid link if only one link is rigid."""
    rigid = poses.rigid
    link = connection.successor if connection.successor in rigid else connection.predecessor
    return poses.twist_at(link if link in rigid else connection.successor, centre)


def marker_radius(poses: DrawnPoses, joint: DrawnJoint, size: float) -> float:
    """Return the radius [m] of a joint's marker: mean section size of the beams at the joint."""
    beams = poses.robot.description.beams.values()
    near = [max(beam.section.extent) for beam in beams if beam.link in joint.links]
    some = near or [max(beam.section.extent) for beam in beams] or [0.016 * size]
    return float(np.clip(np.mean(some), 0.006 * size, 0.05 * size))


def _common_start(a: str, b: str) -> str:
    """Return the common start of two names."""
    same = [x == y for x, y in zip(a, b, strict=False)]
    return a[: (*same, False).index(False)]
