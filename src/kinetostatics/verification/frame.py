"""A robot at one pose as a frame, in plain data: rigid pieces, connected by beams, joints and springs. SI units, world axes.

Pieces are named by their indices; a piece moves with its reference point. Inner is the side nearer to the base: beams and joints
list their inner piece first (:class:`kinetostatics.verification.pieces.Directions`). An assembly error is a deviation of a joint
or beam from its nominal geometry.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.joint_types import Axes
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import first_largest
from kinetostatics.verification.pieces import PlacedJoint

if TYPE_CHECKING:
    from kinetostatics.description.elements import JointStiffness


@dataclass(frozen=True)
class FrameBeam:
    """An elastic beam between two pieces.

    Attributes:
        points: (2, 3) positions of its ends [m].
        axes: (3, 3) x (from the inner to the outer end), y, z as columns.
        stiffness: EA, κGA_y, κGA_z [N], GJ, EI_y, EI_z [N·m²].
        load: (6,) the beam's weight: force and moment per length [N/m, N].
        length_error: unstrained length minus distance of the ends [m].
        lever: (3,) vector from the beam's centre line to its centre of mass [m].
        mass: mass per length [kg/m].
    """

    name: str
    pieces: tuple[int, int]
    points: Array
    axes: Array
    stiffness: tuple[float, ...]
    load: Array
    length_error: float
    lever: Array
    mass: float = 0.0

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.points[1] - self.points[0]))

    def divided(self, elements: int) -> Array:
        """(elements + 1, 3) positions of the ends of equal elements, from the inner end [m]."""
        return np.asarray(self.points[0] + np.linspace(0, 1, elements + 1)[:, None] * (self.points[1] - self.points[0]))


@dataclass(frozen=True)
class JointSpring:
    """Elastic part of a joint: stiffness (6,) along and about ``axes`` (3, 3) as columns [N/m, N·m/rad], infinite where rigid."""

    axes: Array
    stiffness: Array


@dataclass(frozen=True)
class PointSpring:
    """A spring between ``points`` (2, 3) [m] of two pieces: stiffness (3,) along ``axes`` (3, 3) as columns [N/m]."""

    pieces: tuple[int, int]
    points: Array
    axes: Array
    stiffness: Array


@dataclass(frozen=True)
class FrameJoint:
    """A joint between two pieces. A joint inside several telescopic beams is one `FrameJoint` for each beam.

    Attributes:
        point: (3,) centre of the joint [m].
        axes: (3, 3) axes of the joint as columns.
        blocked: (6,) True for constrained directions along and about these axes.
        assembly_error: (6,) displacement of the outer piece relative to the inner piece when unloaded, at the centre [m, rad].
        cross: only for a universal joint free about both axes: the axes (3,) fixed to the inner and to the outer piece.
    """

    name: str
    pieces: tuple[int, int]
    point: Array
    axes: Array
    blocked: NDArray[np.bool_]
    springs: tuple[JointSpring, ...]
    assembly_error: Array
    cross: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class FrameMass:
    """A rigid body fixed to a piece: mass [kg], ``centre`` of mass (3,) [m], inertia (3, 3) about the centre of mass [kg·m²]."""

    piece: int
    centre: Array
    mass: float
    inertia: Array


@dataclass(frozen=True)
class Coordinate:
    """A joint coordinate along the world ``axis`` (3,): rotation of the outer piece if ``rotates``, else its translation."""

    joint: str
    axis: Array
    rotates: bool


@dataclass(frozen=True)
class Actuator:
    """An actuated joint, with the joints that follow it.

    Attributes:
        moves: transmission ratio and coordinate of each joint that the actuator moves, the actuated joint first.
        stiffness: stiffness [N/m, N·m/rad] of an elastic actuator that moves several joints; infinite otherwise. An actuator that
            moves one joint has its stiffness in a spring of that joint.
    """

    name: str
    moves: tuple[tuple[float, Coordinate], ...]
    stiffness: float = np.inf

    @property
    def rotates(self) -> bool:
        return self.moves[0][1].rotates


@dataclass(frozen=True)
class FrameModel:
    """A frame.

    Attributes:
        references: (n, 3) reference point of each of the n pieces [m]; o for the platform.
        loads: (n, 6) force and moment on each piece about its reference point [N, N·m].
        size: diagonal of the box around all points [m].
        length: unit of length for rotations [m]: mean distance of the platform's joints and beam ends from o, or ``size`` if this
            mean is below 0.001 ``size``.
        springs: springs between pieces; ``loads`` contains their forces at the pose.
        point_forces: forces of springs at the pose and weights of rigid links, each as piece, point (3,) [m], force (3,) [N].
        outside_limbs: names of joints inside the base, of joints inside the platform, and of floating joints.
        compound_joints: names of the hinges of each compound joint of the analysis; the hinges' axes meet in a point.
        masses: rigid links and the payload.
    """

    base: int
    platform: int
    references: Array
    loads: Array
    beams: tuple[FrameBeam, ...]
    joints: tuple[FrameJoint, ...]
    actuators: tuple[Actuator, ...]
    size: float
    length: float
    springs: tuple[PointSpring, ...] = ()
    point_forces: tuple[tuple[int, Array, Array], ...] = ()
    outside_limbs: frozenset[str] = frozenset()
    compound_joints: tuple[frozenset[str], ...] = ()
    masses: tuple[FrameMass, ...] = ()

    @property
    def at_the_pose(self) -> FrameModel:
        """The frame loaded only by weights and by the forces of springs, without assembly errors."""
        loads = np.zeros_like(self.loads)
        for piece, point, force in self.point_forces:
            loads[piece] += np.append(force, np.cross(point - self.references[piece], force))
        joints = tuple(replace(joint, assembly_error=np.zeros(6)) for joint in self.joints)
        return replace(self, loads=loads, joints=joints, beams=tuple(replace(beam, length_error=0.0) for beam in self.beams))

    def compound_of(self, joint: FrameJoint) -> tuple[list[FrameJoint], tuple[int, int]]:
        """Return the hinges of the compound joint that contains ``joint``, and the two pieces that this compound joint connects.

        A joint outside compound joints is returned alone, with its own pieces.
        """
        names = next((names for names in self.compound_joints if joint.name in names), {joint.name})
        if len(names) == 1:
            return [joint], joint.pieces
        hinges = [other for other in self.joints if other.name in names]
        pieces = [piece for hinge in hinges for piece in hinge.pieces]
        # fixed joints may connect the hinges
        rigid = [other for other in self.joints if np.all(other.blocked) and not other.springs and other.name not in names]
        body_of = joined(range(len(self.references)), [other.pieces for other in rigid])
        bodies = [body_of[piece] for piece in pieces]
        first, last = (piece for piece, body in zip(pieces, bodies, strict=True) if bodies.count(body) == 1)
        return hinges, (first, last)

    @property
    def stiffest(self) -> float:
        """Largest of the axial stiffnesses of beams and the stiffnesses of joint springs [N/m]; 1 if the frame is rigid."""
        stiffnesses = [beam.stiffness[0] / beam.length for beam in self.beams]
        unit = np.repeat([1.0, self.length], 3)
        for joint in self.joints:
            for spring in joint.springs:
                stiffnesses += [float(value) for value in spring.stiffness / unit**2 if np.isfinite(value)]
        return max(stiffnesses, default=1.0)

    @property
    def largest_assembly_error(self) -> float:
        """Largest displacement by one assembly error [m]; a rotation is multiplied by ``size``."""
        unit = np.repeat([1.0, self.size], 3)
        displacements = [float(np.linalg.norm(joint.assembly_error * unit)) for joint in self.joints]
        return max([*displacements, *(abs(beam.length_error) for beam in self.beams)], default=0.0)


#: Indices of a joint's free directions in :func:`joint_axes`, by entry of the table of joint types; not for universal joints.
NUMBERS = {Axes.NONE: (), Axes.AXIS: (0,), Axes.ACROSS: (1, 2), Axes.ALL: (0, 1, 2)}
#: A direction lies in the span of a joint's elastic axes if their angle [rad] is smaller than this.
ALONG = 1e-9


def axes_along(x: Array, y: Array) -> Array:
    """Return right-handed unit axes (3, 3) as columns: x along ``x``, y in the plane of ``x`` and ``y``."""
    x = x / np.linalg.norm(x)
    y = y - x * (x @ y)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def joint_axes(joint: PlacedJoint) -> Array:
    """Return axes (3, 3) of a joint as columns; x is along the joint's axis.

    For a universal joint, y is along its first axis and x is normal to both axes. For a joint without an axis, the axes are the
    axes of the joint frame fixed to the predecessor.
    """
    frame = joint.frames[0][:3, :3]
    if not joint.type.has_axis:
        return frame
    if joint.type.turns is Axes.BOTH:
        return axes_along(np.cross(joint.axis, joint.axis2), joint.axis)
    # the transverse axes are arbitrary; those of the frame may be axes of springs
    across = frame - np.outer(joint.axis, joint.axis @ frame)
    return axes_along(joint.axis, across[:, first_largest(np.linalg.norm(across, axis=0))])


def releases(joint: PlacedJoint, elastic: JointStiffness | None) -> tuple[Array, NDArray[np.bool_]]:
    """Return axes (3, 3) of a joint as columns, and a mask (6,): True for free directions along and about these axes.

    A locked joint has no free direction. A direction in the span of axes with finite stiffness is elastic, not free.
    """
    free = np.zeros(6, dtype=bool)
    axes = joint_axes(joint)
    if joint.locked:
        return axes, free
    finite = _finite(elastic)

    def held(group: int, direction: Array) -> bool:
        across = joint.frames[0][:3, :3][:, ~finite[group]]
        return bool(np.any(finite[group]) and np.linalg.norm(across.T @ direction) < ALONG)

    if joint.type.turns is Axes.BOTH:
        free_axes = [axis for axis in (joint.axis, joint.axis2) if not held(1, axis)]
        if len(free_axes) == 1:  # the two axes need not be perpendicular
            axes = axes_along(free_axes[0], np.cross(joint.axis, joint.axis2))
        free[{0: [], 1: [3], 2: [4, 5]}[len(free_axes)]] = True
        return axes, free
    for group, directions in enumerate((joint.type.slides, joint.type.turns)):
        for direction in NUMBERS[directions]:
            free[3 * group + direction] = not held(group, axes[:, direction])
    return axes, free


def joint_springs(joint: PlacedJoint, elastic: JointStiffness | None) -> tuple[JointSpring, ...]:
    """Return the springs of an elastic joint, in series: first its bearing, then its actuator."""
    if elastic is None:
        return ()
    springs = []
    finite = np.concatenate(_finite(elastic))
    if np.any(finite):
        given = np.concatenate([np.full(3, np.inf) if values is None else values for values in (elastic.linear, elastic.angular)])
        springs.append(JointSpring(joint.frames[0][:3, :3], np.where(finite, given, np.inf)))
    if elastic.drive is not None and np.isfinite(elastic.drive):
        stiffness = np.full(6, np.inf)
        stiffness[0 if joint.type.is_slide else 3] = elastic.drive
        springs.append(JointSpring(joint_axes(joint), stiffness))
    return tuple(springs)


def _finite(elastic: JointStiffness | None) -> list[NDArray[np.bool_]]:
    """Return two masks (3,), for linear and for angular stiffness: True for axes with a spring."""
    groups = (None, None) if elastic is None else (elastic.linear, elastic.angular)
    return [np.zeros(3, dtype=bool) if values is None else np.isfinite(values) & (np.array(values) != 0) for values in groups]


def joint_assembly_error(error: object, joint: PlacedJoint) -> Array:
    """Return the displacement (6,) of the joint's outer side relative to its inner side at the centre, world axes [m, rad].

    Args:
        error: the displacement given by the user, in world axes or with its own ``frame``; None if there is none.
    """
    if error is None or (isinstance(error, Mapping) and "twist" not in error):  # a beam with the joint's name has this error
        return np.zeros(6)
    in_joint_axes = isinstance(error, Mapping) and error.get("frame", "world") == "joint"
    twist = np.asarray(error["twist"] if isinstance(error, Mapping) else error, dtype=float)
    if not in_joint_axes:
        return twist
    axes = joint.frames[0][:3, :3]
    return np.append(axes @ twist[:3], axes @ twist[3:])
