"""Elastic joints, bearings and actuators: compliances at a joint's centre, in its frame on the predecessor's side.

The rules are those of ``<joint_stiffness>`` in the page on robot files: along a direction that the joint blocks a missing or
infinite stiffness is rigid; along one of its freedoms a finite one is a spring, and any other leaves it free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.description.elements import JointStiffness, Vector
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import across
from kinetostatics.mechanism.mechanism import Mechanism


@dataclass(frozen=True)
class Spring:
    """What is elastic in one joint.

    Attributes:
        joint: its name.
        is_actuator: whether it is the actuator along the joint's own coordinate, else the joint or its bearings.
        body, frame: the joint's frame (4, 4) in the body on the predecessor's side; an actuator's has one axis along the joint's.
        linear: (3, 3) displacement of one side relative to the other per force, in the frame [m/N].
        angular: (3, 3) rotation per moment about the frame's origin [rad/(N·m)].
    """

    joint: str
    is_actuator: bool
    body: int
    frame: Array
    linear: Array
    angular: Array


def springs_of(mechanism: Mechanism, joint: str) -> tuple[Spring, ...]:
    """Return the springs of a joint: itself or its bearings, and its actuator."""
    stiffness = mechanism.description.joint_stiffness.get(joint)
    if stiffness is None:
        return ()
    connection = mechanism.connections[joint]
    place = connection.predecessor_body, connection.predecessor_frame
    zero = np.zeros((3, 3))
    found: list[Spring] = []
    linear, angular = np.diag(_compliances(stiffness.linear)), np.diag(_compliances(stiffness.angular))
    if np.any(linear) or np.any(angular):
        found.append(Spring(joint, False, *place, linear, angular))
    if stiffness.drive is not None and np.isfinite(stiffness.drive):
        # in axes of its own what it does not feel is nothing, and not rounding that looks like another elastic direction
        body, frame, axis = connection.predecessor_body, np.array(connection.predecessor_frame), connection.axis
        if np.max(np.abs(axis)) < 1:
            frame[:3, :3] = frame[:3, :3] @ np.stack([*across(axis), axis], axis=1)
            axis = np.array([0.0, 0.0, 1.0])
        along = np.diag(np.where(np.abs(axis) < 1, 0.0, 1 / stiffness.drive))
        slides = connection.type.is_slide
        found.append(Spring(joint, True, body, frame, along if slides else zero, zero if slides else along))
    return tuple(found)


def is_sprung(stiffness: JointStiffness | None, rotates: bool, axis: Array | None) -> bool:
    """Whether a joint's freedom is held by a spring.

    Args:
        stiffness: of the joint, if it has any.
        rotates: whether the freedom is a rotation.
        axis: (3,) its axis in the joint's frame on the predecessor's side, None if it moves in that frame.
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
    """Return the (3,) inverses, 0 for what is rigid or free."""
    if stiffness is None:
        return np.zeros(3)
    return np.array([1 / k if 0 < k < np.inf else 0.0 for k in stiffness])
