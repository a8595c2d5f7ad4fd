"""Geometric stiffness of a frame with springs: second-order work of the forces at the pose.

A force f of constant direction, on a piece at the arm r, has the second-order potential −½ f·(θ × (θ × r)) under a rotation θ of
the piece. The force and moment of a joint between two pieces rotate with the mean of both rotations. In a beam with the section
forces F and M along its axis e, displacement u and rotation θ, the second-order work is
∫ F·(½ θ × (θ × e) − θ × u′) − ½ M·(θ × θ′) ds (J. C. Simo and L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58, 1986). The sum
is the second derivative of the energy of springs and weights. It is independent of the statics of the package.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.verification.frame import FrameBeam, FrameJoint, FrameModel


def geometric_stiffness(model: FrameModel, joints: Array, beams: Array) -> Array:
    """Return the geometric stiffness (6n, 6n) of n pieces about their reference points by the forces at the pose, with springs.

    Args:
        model: the frame.
        joints: (joints, 6) wrench of the inner piece on the outer piece at the pose, about the joint's centre [N, N·m].
        beams: (beams, 2, 6) wrenches on both ends of each beam at the pose, about these ends [N, N·m].
    """
    n = 6 * len(model.references)
    K = np.zeros((n, n))

    def put(pieces: tuple[int, ...], block: Array) -> None:
        rows = np.concatenate([6 * piece + np.arange(6) for piece in pieces])
        np.add.at(K, np.ix_(rows, rows), block)

    def acts(piece: int, point: Array, force: Array) -> None:
        K[6 * piece + 3 : 6 * piece + 6, 6 * piece + 3 : 6 * piece + 6] += _of_arm(force, point - model.references[piece])

    def moves(pieces: tuple[int, int], points: Array) -> Array:
        """Return displacements and rotations (2, 6, 12) at points of two pieces, by displacements of the pieces."""
        found = np.zeros((2, 6, 12))
        for side, (piece, point) in enumerate(zip(pieces, points, strict=True)):
            found[side, :, 6 * side : 6 * side + 6] = np.eye(6)
            found[side, :3, 6 * side + 3 : 6 * side + 6] = -_cross(point - model.references[piece])
        return found

    for piece, point, force in model.pulls:
        acts(piece, point, force)
    for tie in model.ties:
        one, two = moves(tie.pieces, tie.points)[:, :3]
        apart = tie.axes.T @ (two - one)
        put(tie.pieces, apart.T @ (tie.stiffness[:, None] * apart))
    for joint, wrench in zip(model.joints, joints, strict=True):
        for piece, sign in zip(joint.pieces, (-1, 1), strict=True):
            acts(piece, joint.point, sign * wrench[:3])
        put(joint.pieces, _of_joint(joint, wrench, *moves(joint.pieces, np.array([joint.point] * 2))))
    for beam, ends in zip(model.beams, beams, strict=True):
        for piece, point, end in zip(beam.pieces, beam.points, ends, strict=True):
            acts(piece, point, -end[:3])
        put(beam.pieces, _of_beam(beam, ends[1], *moves(beam.pieces, beam.points)))
    return K


def _cross(v: Array) -> Array:
    """Return the matrix (3, 3) of a cross product."""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _of_arm(force: Array, arm: Array) -> Array:
    """Return the second derivative (3, 3) of −½ f·(θ × (θ × r)) by θ."""
    return np.asarray((force @ arm) * np.eye(3) - (np.outer(force, arm) + np.outer(arm, force)) / 2)


def _symmetric(matrix: Array) -> Array:
    return np.asarray(matrix + matrix.T)


def _of_joint(joint: FrameJoint, wrench: Array, inner: Array, outer: Array) -> Array:
    """Return the second derivative (12, 12) of −F·d − M·φ of a joint's force and moment, without its centre's displacements.

    d is the displacement of the outer piece's centre relative to the inner piece's, in the mean of both pieces' axes; φ is the
    relative rotation vector, to second order θ₂ − θ₁ − ½ θ₁ × θ₂.
    """
    mean, apart = (inner[3:] + outer[3:]) / 2, outer[:3] - inner[:3]
    found = _symmetric(outer[3:].T @ _cross(wrench[3:]) @ inner[3:] / 2 - mean.T @ _cross(wrench[:3]) @ apart)
    if joint.cross is None:
        return found
    # constrained is the angle between its axes a and b, not the rotation about a × b: a·b changes by −(θ₂ − θ₁)·(a × b)
    # + ½ b·(θ₁ × (θ₁ × a)) + ½ a·(θ₂ × (θ₂ × b)) + (θ₁ × a)·(θ₂ × b)
    a, b = joint.cross
    normal = np.cross(a, b)
    angle = inner[3:].T @ _of_arm(b, a) @ inner[3:] + outer[3:].T @ _of_arm(a, b) @ outer[3:]
    angle -= _symmetric(inner[3:].T @ _cross(a).T @ _cross(b) @ outer[3:])
    turn = -_symmetric(outer[3:].T @ _cross(normal) @ inner[3:] / 2)
    return np.asarray(found - wrench[3:] @ normal / (normal @ normal) * (angle - turn))


def _of_beam(beam: FrameBeam, end: Array, first: Array, last: Array) -> Array:
    """Return the second derivative (12, 12) of the work of section forces in a beam with its linear bending shapes.

    Args:
        beam: the beam.
        end: (6,) wrench on its last end [N, N·m].
        first, last: (6, 12) displacements of its ends.
    """
    L, R = beam.length, np.kron(np.eye(2), beam.axes)
    first, last = R.T @ first, R.T @ last
    force, moment, weight, turning = (beam.axes.T @ v for v in (end[:3], end[3:], beam.load[:3], beam.load[3:]))
    of_weight = _of_arm(weight, beam.axes.T @ beam.lever)
    e = np.array([1.0, 0, 0])

    def rigid(s: float) -> Array:
        return np.vstack([first[:3] - s * _cross(e) @ first[3:], first[3:]])

    wrench = np.linalg.solve(_bent(beam, L), last - rigid(L))
    found = np.zeros((12, 12))
    for place, share in zip(*np.polynomial.legendre.leggauss(3), strict=True):  # the integrand is of the fifth degree
        s = L * (1 + place) / 2
        rest = (L - s) * e
        F = force + (L - s) * weight
        M = moment + np.cross(rest, force) + (L - s) * (np.cross(rest, weight) / 2 + turning)
        theta = (rigid(s) + _bent(beam, s) @ wrench)[3:]
        slopes = _bent(beam, s, 1) @ wrench
        along = slopes[:3] - _cross(e) @ first[3:]
        part = _symmetric(theta.T @ _cross(F) @ along + theta.T @ _cross(M) @ slopes[3:] / 2)
        found += share * L / 2 * (part + theta.T @ (of_weight - _of_arm(F, e)) @ theta)
    return found


def _bent(beam: FrameBeam, s: float, derivative: int = 0) -> Array:
    """Return the displacement (6, 6) at s of a beam clamped at its first end by a wrench on its last, or its derivative by s."""
    L, (EA, GA_y, GA_z, GJ, EI_y, EI_z) = beam.length, beam.stiffness
    one, two, three = ((s, s**2 / 2, s**3 / 6), (1.0, s, s**2 / 2))[derivative]
    found = np.diag([one / EA, one / GA_y, one / GA_z, one / GJ, one / EI_y, one / EI_z])
    found[1, 1] += (L * two - three) / EI_z
    found[2, 2] += (L * two - three) / EI_y
    found[1, 5], found[5, 1] = two / EI_z, (L * one - two) / EI_z
    found[2, 4], found[4, 2] = -two / EI_y, -(L * one - two) / EI_y
    return found
