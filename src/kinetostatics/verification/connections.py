"""Connections of a frame: free and elastic directions of joints, and their assembly errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.joint_types import Axes
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import first_largest
from kinetostatics.verification.frame import FrameSpring
from kinetostatics.verification.pieces import PlacedJoint

if TYPE_CHECKING:
    from kinetostatics.description.elements import JointStiffness

#: Axes of free directions in the table of joint types, x along the joint's axis; universal joints are treated separately.
NUMBERS = {Axes.NONE: (), Axes.AXIS: (0,), Axes.ACROSS: (1, 2), Axes.ALL: (0, 1, 2)}
#: Largest angle between an axis and an axis of the joint's frame that counts as zero [rad].
ALONG = 1e-9


def joint_axes(joint: PlacedJoint) -> Array:
    """Return axes (3, 3): x along the joint's axis; of a universal joint, y along its first axis and x normal to both.

    Joints without an axis have the axes of their frame on the predecessor.
    """
    frame = joint.frames[0][:3, :3]
    if not joint.type.has_axis:
        return frame
    if joint.type.turns is Axes.BOTH:
        return _axes_from(np.cross(joint.axis, joint.axis2), joint.axis)
    # the transverse axes are arbitrary; those of the frame may be axes of springs
    across = frame - np.outer(joint.axis, joint.axis @ frame)
    return _axes_from(joint.axis, across[:, first_largest(np.linalg.norm(across, axis=0))])


def _axes_from(x: Array, y: Array) -> Array:
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def releases(joint: PlacedJoint, elastic: JointStiffness | None) -> tuple[Array, NDArray[np.bool_]]:
    """Return axes (3, 3) of a joint, and the mask (6,) of free directions along and about them, without lock or spring.

    A spring constrains a freedom whose direction is in the span of the axes with finite stiffness.
    """
    free = np.zeros(6, dtype=bool)
    axes = joint_axes(joint)
    if joint.locked:
        return axes, free
    held = [_spanned_by(joint.frames[0][:3, :3], finite) for finite in _finite(elastic)]
    if joint.type.turns is Axes.BOTH:
        loose = [axis for axis in (joint.axis, joint.axis2) if not held[1](axis)]
        if len(loose) == 1:  # the two axes need not be perpendicular
            axes = _axes_from(loose[0], np.cross(joint.axis, joint.axis2))
        free[{0: [], 1: [3], 2: [4, 5]}[len(loose)]] = True
        return axes, free
    for group, directions in enumerate((joint.type.slides, joint.type.turns)):
        for direction in NUMBERS[directions]:
            free[3 * group + direction] = not held[group](axes[:, direction])
    return axes, free


def _spanned_by(frame: Array, finite: NDArray[np.bool_]) -> Callable[[Array], bool]:
    """Return a test whether a direction is in the span of some axes of a frame."""
    return lambda direction: bool(np.any(finite)) and bool(np.linalg.norm(frame[:, ~finite].T @ direction) < ALONG)


def joint_springs(joint: PlacedJoint, elastic: JointStiffness | None) -> tuple[FrameSpring, ...]:
    """Return the springs of an elastic joint, in series: bearing, and actuator."""
    if elastic is None:
        return ()
    springs = []
    finite = np.concatenate(_finite(elastic))
    if np.any(finite):
        given = np.concatenate([np.full(3, np.inf) if values is None else values for values in (elastic.linear, elastic.angular)])
        springs.append(FrameSpring(joint.frames[0][:3, :3], np.where(finite, given, np.inf)))
    if elastic.drive is not None and np.isfinite(elastic.drive):
        stiffness = np.full(6, np.inf)
        stiffness[0 if joint.type.is_slide else 3] = elastic.drive
        springs.append(FrameSpring(joint_axes(joint), stiffness))
    return tuple(springs)


def _finite(elastic: JointStiffness | None) -> list[NDArray[np.bool_]]:
    """Return the masks (3,) of axes with a spring, for linear and angular stiffness."""
    groups = (None, None) if elastic is None else (elastic.linear, elastic.angular)
    return [np.zeros(3, dtype=bool) if values is None else np.isfinite(values) & (np.array(values) != 0) for values in groups]


def joint_assembly_error(error: object, joint: PlacedJoint) -> Array:
    """Return the displacement (6,) of the outer side relative to the inner side at the centre, world axes [m, rad].

    Args:
        error: the same displacement as given by the user, in world axes or with its own ``frame``; or None.
        joint: the joint.
    """
    if error is None or (isinstance(error, Mapping) and "twist" not in error):  # error of a beam with the joint's name
        return np.zeros(6)
    own = isinstance(error, Mapping) and error.get("frame", "world") == "joint"
    twist = np.asarray(error["twist"] if isinstance(error, Mapping) else error, dtype=float)
    if not own:
        return twist
    axes = joint.frames[0][:3, :3]
    return np.append(axes @ twist[:3], axes @ twist[3:])
