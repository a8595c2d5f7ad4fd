"""Masses by Pinocchio: inertias of links, models with the robot's masses, wrenches of weights."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.math.arrays import Array

if TYPE_CHECKING:
    import pinocchio as pin

#: Masses below this part of what moves with them are what rounding leaves of a link without mass.
_NOTHING = 1e-14


def link_inertias(model: pin.Model) -> dict[str, pin.Inertia]:
    """Return every link's own ``pin.Inertia``, in the frame of the body (Pinocchio's joint) with which it moves.

    Pinocchio adds up the links that fixed joints weld together; what each of them brings stays in the frame of its fixed
    joint, and what is left is the link that hangs on the moving joint itself.

    Args:
        model: ``pin.Model`` built from a URDF.
    """
    import pinocchio as pin

    rest = {body: pin.Inertia(inertia) for body, inertia in enumerate(model.inertias)}
    totals = {body: inertia.mass for body, inertia in rest.items()}
    found: dict[str, pin.Inertia] = {}
    first: dict[int, str] = {}
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY:
            continue
        parent, body = model.frames[frame.parentFrame], int(frame.parentJoint)
        if parent.type == pin.FrameType.FIXED_JOINT and parent.name != "universe":
            found[frame.name] = pin.Inertia(parent.placement.act(parent.inertia))
            rest[body] = pin.Inertia(rest[body] - found[frame.name]) if parent.inertia.mass else rest[body]
        else:
            first[body] = frame.name
    for body, name in first.items():
        found[name] = rest[body] if rest[body].mass > _NOTHING * totals[body] else pin.Inertia.Zero()
    return found


def weighed(model: pin.Model, bodies: Iterable[tuple[int, pin.Inertia]]) -> pin.Model:
    """Return a copy of a ``pin.Model`` with the given inertias alone: bodies, and a ``pin.Inertia`` in each."""
    import pinocchio as pin

    copy = model.copy()
    for body in range(copy.njoints):
        copy.inertias[body] = pin.Inertia.Zero()
    for body, inertia in bodies:
        if inertia.mass:
            copy.inertias[body] = pin.Inertia(copy.inertias[body] + inertia) if copy.inertias[body].mass else inertia
    return copy


def weight_wrench(inertia: pin.Inertia, rotation: Array, arm: Array, gravity: Array) -> Array:
    """Return the wrench (6,) [N, N·m] of a body's weight about a reference point, world axes.

    Args:
        inertia: ``pin.Inertia`` in the body's frame.
        rotation: (3, 3) of the body.
        arm: (3,) from the reference point to the body's origin, world axes [m].
        gravity: (3,) in world axes [m/s²].
    """
    import pinocchio as pin

    placement = pin.SE3(rotation, arm)
    return np.asarray(placement.act(inertia * placement.actInv(pin.Motion(gravity, np.zeros(3)))).vector)
