"""Twists, wrenches and the motion of their reference point.

A twist is ``[d; r]``: linear displacement [m] of the body point at the reference point, then rotation [rad]. A wrench is
``[f; m]``: force [N], then moment [N·m] about the reference point. With this order, Pinocchio's, the reciprocal product is
the plain dot product of a twist and a wrench. All arrays are ``(6, …)``, ``(3, …)`` with the batch axes last.

A force through a hinge's axis is reciprocal to its twist; a force beside it has a moment about it, and so does work:

>>> hinge = rotation_twist(axis=np.array([0.0, 0.0, 1.0]), arm=np.array([2.0, 0.0, 0.0]))
>>> through = wrench_of_force(force=np.array([0.0, 5.0, 0.0]), arm=np.array([2.0, 0.0, 0.0]))
>>> beside = wrench_of_force(force=np.array([0.0, 5.0, 0.0]), arm=np.array([3.0, 0.0, 0.0]))
>>> float(through @ hinge), float(beside @ hinge)
(0.0, 5.0)
>>> move_wrench(through, shift=np.array([2.0, 0.0, 0.0])).tolist()  # about a point of the axis: no moment
[0.0, 5.0, 0.0, 0.0, 0.0, 0.0]

Source: J. K. Davidson and K. H. Hunt, Robots and Screw Theory, Oxford 2004, chapters 3 and 5.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array, empty_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.ordering import first_largest
from kinetostatics.math.rotations import skew

#: Names of the components of twists and wrenches at o, and units of a twist's.
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
WRENCH_COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
TWIST_UNITS = ("m", "m", "m", "rad", "rad", "rad")


def wrench_of_force(force: Array, arm: Array) -> Array:
    """Return the wrench of a force [N] that acts at ``arm`` [m] from the reference point."""
    force, arm = np.broadcast_arrays(force, arm)
    return np.concatenate([force, cross(arm, force)])


def wrench_of_couple(couple: Array) -> Array:
    """Return the wrench of a couple [N·m]."""
    return np.concatenate([np.zeros_like(couple), couple])


def rotation_twist(axis: Array, arm: Array) -> Array:
    """Return the unit twist of a rotation about ``axis`` through a point at ``arm`` [m] from the reference point."""
    axis, arm = np.broadcast_arrays(axis, arm)
    return np.concatenate([cross(arm, axis), axis])


def translation_twist(direction: Array) -> Array:
    """Return the unit twist of a translation along ``direction``."""
    return np.concatenate([direction, np.zeros_like(direction)])


def move_wrench(wrench: Array, shift: Array) -> Array:
    """Return the wrench about a reference point that lies ``shift`` [m] from the present one (m_o = m_p + (p − o) × f)."""
    moment = wrench[3:] - cross(shift, wrench[:3])
    result = empty_for((6, *moment.shape[1:]), moment)
    result[:3], result[3:] = wrench[:3], moment
    return result


def move_twist(twist: Array, shift: Array) -> Array:
    """Return the twist at a reference point that lies ``shift`` [m] from the present one (d_o = d_p + r × (o − p))."""
    linear = twist[:3] + cross(twist[3:], shift)
    result = empty_for((6, *linear.shape[1:]), linear)
    result[:3], result[3:] = linear, twist[3:]
    return result


def to_point(shift: Array) -> Array:
    """Return X (…, 6, 6) with which a twist at a reference point becomes X t at one that lies ``shift`` (…, 3) [m] from there.

    A compliance becomes X C Xᵀ, a stiffness X⁻ᵀ K X⁻¹; X⁻¹ is that of the opposite shift.
    """
    found: Array = np.zeros((*shift.shape[:-1], 6, 6))
    found[...] = np.eye(6)
    found[..., :3, 3:] = -np.moveaxis(skew(np.moveaxis(shift, -1, 0)), (0, 1), (-2, -1))
    return found


def stiffness_at(stiffness: Array, shift: Array) -> Array:
    """Return a stiffness (…, 6, 6) at a reference point that lies ``shift`` (…, 3) [m] from the present one."""
    back = to_point(-shift)
    return np.asarray(np.swapaxes(back, -1, -2) @ stiffness @ back)


def compliance_at(compliance: Array, shift: Array) -> Array:
    """Return a compliance (…, 6, 6) at a reference point that lies ``shift`` (…, 3) [m] from the present one."""
    there = to_point(shift)
    return np.asarray(there @ compliance @ np.swapaxes(there, -1, -2))


def describe_twist(twist: Array, length: float) -> str:
    """Say in words what motion a (6,) twist at o is, for messages; its opposite is the same motion.

    Args:
        twist: [d; r] at o.
        length: characteristic length [m] that tells a rotation from a translation.
    """

    def vector(v: Array) -> str:
        return "(" + ", ".join(f"{0.0 if abs(x) < 5e-5 else x:.4g}" for x in v) + ")"

    def direction(v: Array) -> Array:
        return v / (np.linalg.norm(v) * np.sign(v[first_largest(np.abs(v))]))

    linear, angular = twist[:3], twist[3:]
    rate = float(np.linalg.norm(angular))
    if rate * length < 1e-6 * float(np.linalg.norm(linear)):
        return f"a translation along {vector(direction(linear))}"
    axis = direction(angular)
    foot = np.cross(angular, linear) / rate**2
    pitch = float(angular @ linear) / rate**2
    words = f"a rotation about the axis {vector(axis)} through o + {vector(foot)} m"
    if abs(pitch) > 1e-6 * length:
        words += f" with a pitch of {pitch:.4g} m/rad"
    return words
