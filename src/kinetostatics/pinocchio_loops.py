"""The loops of a robot as Pinocchio's own constraints, for its dynamics with closed loops."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.mechanism import ROTATING, Connection, Mechanism


def constraint_models(mechanism: Mechanism, model: Any, length: float, anchors: bool) -> list[Any]:
    """Return Pinocchio's constraints of all loops; see :meth:`kinetostatics.Robot.constraint_models`.

    Args:
        mechanism: the robot's joints and loops.
        model: ``pin.Model`` on which the constraints work.
        length: distance [m] of the two points by which a hinge is held.
        anchors: whether constraints of Pinocchio 4 are wanted instead of ``pin.RigidConstraintModel``.
    """
    import pinocchio as pin

    if anchors and not hasattr(pin, "PointAnchorConstraintModel"):
        raise ArgumentError(f"Pinocchio {pin.__version__} has no anchor constraints; use anchors=False")
    found = []
    for loop in mechanism.connections.values():
        if not loop.is_loop:
            continue
        sides = [pin.SE3(frame) for frame in (loop.predecessor_frame, loop.successor_frame)]
        frames = loop.kind == "fixed"
        shifts = [np.zeros(3)] if loop.kind in ("fixed", "spherical") else _points_of_hinge(loop, length)
        for shift in shifts:
            first, second = (side * pin.SE3(np.eye(3), shift) for side in sides)
            where = (model, loop.predecessor_body, first, loop.successor_body, second)
            if anchors:
                found.append((pin.FrameAnchorConstraintModel if frames else pin.PointAnchorConstraintModel)(*where))
            else:
                found.append(
                    pin.RigidConstraintModel(pin.ContactType.CONTACT_6D if frames else pin.ContactType.CONTACT_3D, *where)
                )
            found[-1].name = loop.name
    return found


def _points_of_hinge(loop: Connection, length: float) -> list[np.ndarray]:
    """Return two points of a hinge's axis, in the loop's frame on either side."""
    if loop.kind not in ROTATING:
        raise ArgumentError(
            f"Pinocchio has no constraint for the {loop.kind} loop {loop.name!r}; it has them for fixed, spherical, revolute and "
            "continuous ones: write this joint into the tree, as a run of simple joints, and close the loop elsewhere"
        )
    return [np.zeros(3), length * loop.axis]
