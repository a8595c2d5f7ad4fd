"""Elastic joints and bearings: compliances at a joint's centre, in its frame on the predecessor's side; and elastic actuators.

The rules are those of ``<joint_stiffness>`` in the page on robot files. Along a constrained direction of the joint, a missing or
infinite stiffness means rigid. Along a freedom, a finite positive stiffness is a spring; with any other value the freedom is
passive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.description.elements import JointStiffness, Vector
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.mechanism import Mechanism


@dataclass(frozen=True)
class ElasticJoint:
    """The elasticity of one joint.

    Attributes:
        joint: name of the joint.
        body, frame: the joint frame (4, 4) in the body on the predecessor's side.
        linear: (3, 3) displacement of one side relative to the other per force, in the frame [m/N].
        angular: (3, 3) rotation per moment about the frame's origin [rad/(N·m)].
    """

    joint: str
    body: int
    frame: Array
    linear: Array
    angular: Array


@dataclass(frozen=True)
class Drive:
    """An elastic actuator, deformed by its own force plus the forces of joints that mimic it, times their multipliers.

    Attributes:
        joint: name of the joint.
        compliance: compliance along its coordinate [m/N, rad/(N·m)].
        moves: the joint and those that mimic it, with their motion per unit of its coordinate.
    """

    joint: str
    compliance: float
    moves: tuple[tuple[str, float], ...]


def springs_of(mechanism: Mechanism, joint: str) -> tuple[ElasticJoint, ...]:
    """Return the elasticity of a joint or of its bearings; none for a rigid joint."""
    stiffness = mechanism.description.joint_stiffness.get(joint)
    if stiffness is None:
        return ()
    connection = mechanism.connections[joint]
    linear, angular = np.diag(_compliances(stiffness.linear)), np.diag(_compliances(stiffness.angular))
    if not np.any(linear) and not np.any(angular):
        return ()
    return (ElasticJoint(joint, connection.predecessor_body, connection.predecessor_frame, linear, angular),)


def drives_of(mechanism: Mechanism) -> dict[str, Drive]:
    """Return all elastic actuators by the name of their joint."""
    found = {}
    for name, stiffness in mechanism.description.joint_stiffness.items():
        if stiffness.drive is not None and stiffness.drive < np.inf:
            found[name] = drive_of(mechanism, name, 1 / stiffness.drive)
    return found


def drive_of(mechanism: Mechanism, name: str, compliance: float) -> Drive:
    """Return the actuator of a joint with a compliance [m/N, rad/(N·m)]; infinite: it exerts no force."""
    followers = [(item.name, item.mimic) for item in mechanism.connections.values() if item.mimic is not None]
    moves = ((follower, mimic.multiplier) for follower, mimic in followers if mimic.joint == name)
    return Drive(name, compliance, ((name, 1.0), *moves))


def is_sprung(stiffness: JointStiffness | None, rotates: bool, axis: Array | None) -> bool:
    """Whether a joint's freedom is elastic.

    Args:
        stiffness: stiffness of the joint, or None.
        rotates: whether the freedom is a rotation.
        axis: (3,) axis of the freedom in the joint frame on the predecessor's side, None if it moves in this frame.
    """
    group = None if stiffness is None else stiffness.angular if rotates else stiffness.linear
    if group is None:
        return False
    compliances = _compliances(group)
    if np.all(compliances > 0):
        return True
    if axis is None:
        return False
    along = int(np.argmax(np.abs(axis)))
    return bool(abs(axis[along]) > 1 - 1e-9 and compliances[along] > 0)


def _compliances(stiffness: Vector | None) -> Array:
    """Return the (3,) inverses, 0 for rigid or free directions."""
    if stiffness is None:
        return np.zeros(3)
    return np.array([1 / k if 0 < k < np.inf else 0.0 for k in stiffness])
