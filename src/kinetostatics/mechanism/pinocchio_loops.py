"""Loops of a robot as constraints of Pinocchio, for dynamics with closed loops.

Pinocchio constrains a point or a whole frame of one body to another: a spherical loop is one point, a revolute loop two points, a
fixed loop a frame. Any other loop becomes a series of revolute and prismatic joints in the tree. The last body of the series gets
half the inertia of the successor and is welded to it, so that the total mass is unchanged and no body is massless.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import exponential, three_angles
from kinetostatics.mechanism.mechanism import Connection, Mechanism

if TYPE_CHECKING:
    import pinocchio as pin


def _has_constraint(loop: Connection) -> bool:
    """Whether Pinocchio has a constraint for this type of loop."""
    return loop.type.slides is Axes.NONE and loop.type.turns is not Axes.BOTH


@dataclass(frozen=True)
class LoopModel:
    """A robot at one pose as Pinocchio's tree and constraints.

    Attributes:
        model: ``pin.Model`` with the inertias at the pose, and with added joints that replace loops.
        q: (nq,) coordinates of the pose [m, rad].
        constraints: one or two for each loop, each with the loop's name.
    """

    model: pin.Model
    q: Array
    constraints: list[pin.RigidConstraintModel]


def loop_model(mechanism: Mechanism, model: pin.Model, q: Array, length: float, anchors: bool) -> LoopModel:
    """Return a robot's tree and loops at a pose ``q`` (nq,); the other arguments as in :func:`constraint_models`."""
    import pinocchio as pin

    copy, coordinates, welds = model.copy(), list(np.asarray(q)), {}
    data = model.createData()
    pin.forwardKinematics(model, data, np.asarray(q, dtype=float))
    for loop in mechanism.connections.values():
        if loop.is_loop and not _has_constraint(loop):
            body, frame, other, other_frame, steps = _as_chain(loop, data.oMi)
            copy.inertias[other] = pin.Inertia(
                copy.inertias[other].mass / 2, copy.inertias[other].lever, copy.inertias[other].inertia / 2
            )
            placement = pin.SE3(frame)
            for number, (slides, axis, value) in enumerate(steps, 1):
                joint = (pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned)(axis)
                body = copy.addJoint(body, joint, placement, f"{loop.name}_{number}")
                coordinates.append(value)
                placement = pin.SE3.Identity()
            copy.appendBodyToJoint(body, copy.inertias[other], pin.SE3(other_frame).inverse())
            welds[loop.name] = (body, pin.SE3.Identity(), other, pin.SE3(other_frame))
    return LoopModel(copy, np.array(coordinates), constraint_models(mechanism, copy, length, anchors, welds))


def constraint_models(
    mechanism: Mechanism,
    model: pin.Model,
    length: float,
    anchors: bool,
    welds: dict[str, tuple[int, pin.SE3, int, pin.SE3]] | None = None,
) -> list[pin.RigidConstraintModel]:
    """Return Pinocchio's constraints of all loops; see :meth:`kinetostatics.Robot.constraint_models`.

    Args:
        model: ``pin.Model`` on which the constraints work.
        length: distance [m] between the two points that constrain a hinge.
        anchors: whether to return constraints of Pinocchio 4 instead of ``pin.RigidConstraintModel``.
        welds: for each loop that joints replace, (body, placement, body, placement): the two bodies welded together, and the
            ``pin.SE3`` of the weld in each.
    """
    import pinocchio as pin

    if anchors and not hasattr(pin, "PointAnchorConstraintModel"):
        raise ArgumentError(f"Pinocchio {pin.__version__} has no anchor constraints; use anchors=False")
    constraints: list[pin.RigidConstraintModel] = []
    for loop in mechanism.connections.values():
        if not loop.is_loop:
            continue
        if not _has_constraint(loop) and welds is None:
            raise ArgumentError(
                f"Pinocchio has no constraint for the {loop.type.name} loop {loop.name!r}: use configuration.loop_model(), "
                "which replaces such a loop by joints of the tree"
            )
        sides = (loop.predecessor_body, pin.SE3(loop.predecessor_frame), loop.successor_body, pin.SE3(loop.successor_frame))
        body, first, other, second = (welds or {}).get(loop.name, sides)
        whole = loop.type.is_fixed or not _has_constraint(loop)
        for shift in [np.zeros(3), length * loop.axis] if loop.type.is_hinge else [np.zeros(3)]:
            by = pin.SE3(np.eye(3), shift)
            where = (model, body, first * by, other, second * by)
            if anchors:
                constraints.append((pin.FrameAnchorConstraintModel if whole else pin.PointAnchorConstraintModel)(*where))
            else:
                kind = pin.ContactType.CONTACT_6D if whole else pin.ContactType.CONTACT_3D
                constraints.append(pin.RigidConstraintModel(kind, *where))
            constraints[-1].name = loop.name
    return constraints


def _as_chain(loop: Connection, placements: Sequence[pin.SE3]) -> tuple[int, Array, int, Array, list[tuple[bool, Array, float]]]:
    """Return a loop as a chain of joints: body and frame at its start, body and frame at its end, and its joints.

    A joint is (whether it slides, axis, value). The chain begins at the predecessor, or at a successor that is fixed to the root.
    """
    first = placements[loop.predecessor_body].homogeneous @ loop.predecessor_frame
    second = placements[loop.successor_body].homogeneous @ loop.successor_frame
    between = np.linalg.inv(first) @ second
    R, p, axis = between[:3, :3], between[:3, 3], loop.axis
    slides, turns = loop.type.axes(axis)
    steps = [(True, along, float(along @ p)) for along in slides.T]
    if loop.type.turns is Axes.AXIS:
        steps.append((False, axis, _angle_of(axis, R)))
    elif loop.type.turns is Axes.BOTH:
        turned = _angle_between(axis, loop.axis2, R @ loop.axis2)
        second_turn = exponential(-turned * axis[:, None])[..., 0] @ R
        steps += [(False, axis, turned), (False, loop.axis2, _angle_of(loop.axis2, second_turn))]
    elif loop.type.turns is Axes.ALL:
        angles = three_angles(np.eye(3), R[..., None], np.zeros((3, 1)))[:, 0]
        steps += [(False, about, float(angle)) for about, angle in zip(turns.T, angles, strict=True)]
    if loop.successor_body:
        return loop.predecessor_body, loop.predecessor_frame, loop.successor_body, loop.successor_frame, steps
    back = [(slides, -along, value) for slides, along, value in reversed(steps)]
    return 0, loop.successor_frame, loop.predecessor_body, loop.predecessor_frame, back


def _angle_of(axis: Array, R: Array) -> float:
    """Return the angle [rad] by which R turns about an axis."""
    sine = float(axis @ [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.arctan2(sine, np.trace(R) - 1))


def _angle_between(axis: Array, start: Array, end: Array) -> float:
    """Return the angle [rad] about an axis from direction ``start`` to direction ``end``."""
    a, b = start - axis * (axis @ start), end - axis * (axis @ end)
    return float(np.arctan2(axis @ np.cross(a, b), a @ b))
