"""Twists and wrenches: unit screws, change of reference point, change of axes.

A twist is ``[d; r]``: linear displacement [m] of the body point at the reference point, then rotation [rad]. A wrench is
``[f; m]``: force [N], then moment [N·m] about the reference point. With this order, Pinocchio's, the reciprocal product is
the plain dot product of a twist and a wrench. All arrays are ``(6, …)``, ``(3, …)`` with the batch axes last.

:func:`move_twist`, :func:`move_wrench` and :func:`move` change the reference point.

A force that intersects the axis of a hinge is reciprocal to the hinge's twist; a force with a moment about the axis is not:

>>> hinge = unit_twist(axis=np.array([0.0, 0.0, 1.0]), arm=np.array([2.0, 0.0, 0.0]))
>>> through = wrench_of_force(force=np.array([0.0, 5.0, 0.0]), arm=np.array([2.0, 0.0, 0.0]))
>>> beside = wrench_of_force(force=np.array([0.0, 5.0, 0.0]), arm=np.array([3.0, 0.0, 0.0]))
>>> float(through @ hinge), float(beside @ hinge)
(0.0, 5.0)
>>> move_wrench(through, shift=np.array([2.0, 0.0, 0.0])).tolist()  # about a point of the axis: no moment
[0.0, 5.0, 0.0, 0.0, 0.0, 0.0]

Source: J. K. Davidson and K. H. Hunt, Robots and Screw Theory, Oxford 2004, chapters 3 and 5.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from kinetostatics.math.arrays import Array, Mask, empty_for
from kinetostatics.math.linalg import apply, cross, first_largest, transpose

#: Names and units of the components of twists and wrenches at o.
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
WRENCH_COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
TWIST_UNITS = ("m", "m", "m", "rad", "rad", "rad")
WRENCH_UNITS = ("N", "N", "N", "N·m", "N·m", "N·m")
#: Quantities that depend on the reference point.
Kind: TypeAlias = Literal["twist", "wrench", "stiffness", "compliance"]


def wrench_of_force(force: Array, arm: Array) -> Array:
    """Return the wrench [f; arm × f] of a force f [N] that acts at ``arm`` [m] from the reference point."""
    force, arm = np.broadcast_arrays(force, arm)
    return np.concatenate([force, cross(arm, force)])


def wrench_of_couple(couple: Array) -> Array:
    return np.concatenate([np.zeros_like(couple), couple])


def unit_twist(axis: Array, arm: Array, rotates: Mask | bool = True) -> Array:
    """Return the unit twist [arm × s; s] of a rotation about ``axis`` s through a point at ``arm`` [m] from the reference point.

    Where ``rotates`` (…) is false, return the unit twist [s; 0] of a translation along ``axis``.
    """
    linear = cross(arm, axis)
    result = empty_for((6, *linear.shape[1:]), linear)
    result[:3], result[3:] = np.where(rotates, linear, axis), np.where(rotates, axis, 0.0)
    return result


def move_wrench(wrench: Array, shift: Array) -> Array:
    """Return the wrench about the point that lies ``shift`` [m] from the reference point: m_o = m_p − (o − p) × f."""
    moment = wrench[3:] - cross(shift, wrench[:3])
    result = empty_for((6, *moment.shape[1:]), moment)
    result[:3], result[3:] = wrench[:3], moment
    return result


def move_twist(twist: Array, shift: Array) -> Array:
    """Return the twist at the point that lies ``shift`` [m] from the reference point: d_o = d_p + r × (o − p)."""
    linear = twist[:3] + cross(twist[3:], shift)
    result = empty_for((6, *linear.shape[1:]), linear)
    result[:3], result[3:] = linear, twist[3:]
    return result


def rotate(axes: Array, screws: Array, back: bool = False) -> Array:
    """Return twists or wrenches [R a; R b] (6, …) in world axes, given along ``axes`` R (3, 3, …); with ``back`` with Rᵀ."""
    result = empty_for(screws.shape, axes, screws)
    turn = transpose(axes) if back else axes
    result[:3], result[3:] = apply(turn, screws[:3]), apply(turn, screws[3:])
    return result


def move(kind: Kind, array: Array, shift: Array, components_last: bool = False) -> Array:
    """Return a quantity about a reference point that lies ``shift`` (3, …) [m] from the present one.

    With X of :func:`move_twist`, a twist becomes X t, a wrench X⁻ᵀ w, a compliance X C Xᵀ, a stiffness X⁻ᵀ K X⁻¹.

    Args:
        kind: kind of the quantity.
        array: twists or wrenches (6, …), or stiffness or compliance matrices (6, 6, …). Rows and columns of a stiffness are moved
            as wrenches, rows and columns of a compliance as twists.
        shift: vector [m] to the new reference point; its batch axes are the last ones of ``array``.
        components_last: whether all three arrays have their axes of components last, as in results, instead of first.
    """
    moved = move_twist if kind in ("twist", "compliance") else move_wrench
    count = 2 if kind in ("stiffness", "compliance") else 1
    first, last = tuple(range(count)), tuple(range(-count, 0))
    if components_last:
        array, shift = np.moveaxis(array, last, first), np.moveaxis(shift, -1, 0)
    array = moved(array, shift)
    if count == 2:
        array = np.swapaxes(moved(np.swapaxes(array, 0, 1), shift), 0, 1)
    return np.moveaxis(array, first, last) if components_last else array


def describe_twist(twist: Array, length: float) -> str:
    """Return a twist (6,) at o as text for messages; the opposite twist has the same text.

    The characteristic ``length`` [m] decides whether rotations or the pitch are negligible.
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
