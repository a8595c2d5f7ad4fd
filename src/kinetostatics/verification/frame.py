"""A frame of rigid pieces, beams and joints, as plain data: SI units, world axes.

Joints have free and elastic directions, and assembly errors.
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
    """An elastic beam between two pieces, base end first.

    Attributes:
        name: name of the beam.
        pieces: pieces at its ends.
        points: (2, 3) positions of its ends [m].
        axes: (3, 3) x (along), y, z as columns.
        stiffness: EA, κGA_y, κGA_z [N], GJ, EI_y, EI_z [N·m²].
        load: (6,) the beam's weight: force and moment per length [N/m, N].
        length_error: excess of its unstrained length over the distance of its ends [m].
        lever: (3,) vector from its centre line to its mass [m].
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
        """Distance of the beam's ends [m]."""
        return float(np.linalg.norm(self.points[1] - self.points[0]))

    def divided(self, elements: int) -> Array:
        """Return the ends (elements + 1, 3) of equal elements [m]."""
        return np.asarray(self.points[0] + np.linspace(0, 1, elements + 1)[:, None] * (self.points[1] - self.points[0]))


@dataclass(frozen=True)
class FrameSpring:
    """An elastic part of a joint: stiffness (6,) along and about ``axes`` (3, 3) [N/m, N·m/rad], infinite where rigid."""

    axes: Array
    stiffness: Array


@dataclass(frozen=True)
class FrameTie:
    """A spring between ``points`` (2, 3) [m] of two pieces: stiffness (3,) along ``axes`` (3, 3) [N/m]."""

    pieces: tuple[int, int]
    points: Array
    axes: Array
    stiffness: Array


@dataclass(frozen=True)
class FrameJoint:
    """A joint between two pieces, inner first.

    Attributes:
        name: name of the joint. A joint inside several telescopic beams has one entry for each of them.
        pieces: the two pieces.
        point: (3,) its centre [m].
        axes: (3, 3) its x, y, z as columns.
        blocked: (6,) mask of constrained directions along and about these axes.
        springs: its elastic parts, in series with the constraints.
        assembly_error: (6,) displacement of the outer piece relative to the inner when unloaded, at the centre [m, rad].
        cross: the two axes (3,) of a universal joint that is free about both, first the axis fixed to the inner piece; else None.
    """

    name: str
    pieces: tuple[int, int]
    point: Array
    axes: Array
    blocked: NDArray[np.bool_]
    springs: tuple[FrameSpring, ...]
    assembly_error: Array
    cross: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class FrameMass:
    """A rigid body on a piece: its ``mass`` [kg], ``centre`` of mass (3,) [m], and ``inertia`` (3, 3) about it [kg·m²]."""

    piece: int
    centre: Array
    mass: float
    inertia: Array


@dataclass(frozen=True)
class Coordinate:
    """A joint's coordinate: translation of its outer side along the world ``axis`` (3,), or rotation about it."""

    joint: str
    axis: Array
    rotates: bool


@dataclass(frozen=True)
class Actuator:
    """A driven joint.

    Attributes:
        name: its name.
        moves: transmission ratio and coordinate of each joint that the actuator moves, the driven joint first.
        stiffness: stiffness [N/m, N·m/rad] of an elastic actuator that moves several joints; infinite otherwise. An elastic
            actuator of one joint is a spring of this joint.
    """

    name: str
    moves: tuple[tuple[float, Coordinate], ...]
    stiffness: float = np.inf

    @property
    def rotates(self) -> bool:
        """Whether the driven joint rotates."""
        return self.moves[0][1].rotates


@dataclass(frozen=True)
class FrameModel:
    """The whole frame.

    Attributes:
        base, platform: indices of their pieces.
        references: (n, 3) reference point of each piece [m]; o for the platform.
        loads: (n, 6) force and moment on every piece about its reference point [N, N·m].
        beams, joints: connections of the pieces.
        actuators: the driven joints.
        size: diagonal of the box around all points [m].
        length: scale of rotations [m]: mean distance of the platform's joints and beam ends from o; if this is zero, the size.
        ties: springs between pieces; their forces at the pose are among the loads.
        within: names of the joints inside the base or the platform, and of all floating joints.
        runs: for each compound joint of the analysis, the names of its hinges, whose axes meet in a point.
        pulls: forces of springs and weights of rigid links, each as piece, point (3,) [m] and force (3,) [N].
        masses: rigid links, and the payload.
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
    ties: tuple[FrameTie, ...] = ()
    pulls: tuple[tuple[int, Array, Array], ...] = ()
    within: frozenset[str] = frozenset()
    runs: tuple[frozenset[str], ...] = ()
    masses: tuple[FrameMass, ...] = ()

    @property
    def at_the_pose(self) -> FrameModel:
        """The frame under the forces of springs and weights only, without assembly errors."""
        loads = np.zeros_like(self.loads)
        for piece, point, force in self.pulls:
            loads[piece] += np.append(force, np.cross(point - self.references[piece], force))
        joints = tuple(replace(joint, assembly_error=np.zeros(6)) for joint in self.joints)
        return replace(self, loads=loads, joints=joints, beams=tuple(replace(beam, length_error=0.0) for beam in self.beams))

    def run_of(self, joint: FrameJoint) -> tuple[list[FrameJoint], tuple[int, int]]:
        """Return the hinges of the compound joint that contains a joint, and the pieces that they connect."""
        names = next((run for run in self.runs if joint.name in run), {joint.name})
        if len(names) == 1:
            return [joint], joint.pieces
        run = [item for item in self.joints if item.name in names]
        pieces = [piece for item in run for piece in item.pieces]
        # fixed joints may connect the hinges
        rigid = [item for item in self.joints if np.all(item.blocked) and not item.springs and item.name not in names]
        body_of = joined(range(len(self.references)), [item.pieces for item in rigid])
        bodies = [body_of[piece] for piece in pieces]
        first, last = (piece for piece, body in zip(pieces, bodies, strict=True) if bodies.count(body) == 1)
        return run, (first, last)

    @property
    def stiffest(self) -> float:
        """Largest axial stiffness of a beam or stiffness of a joint [N/m]; 1 if everything is rigid."""
        found = [beam.stiffness[0] / beam.length for beam in self.beams]
        unit = np.repeat([1.0, self.length], 3)
        for joint in self.joints:
            for spring in joint.springs:
                found += [float(value) for value in spring.stiffness / unit**2 if np.isfinite(value)]
        return max(found, default=1.0)

    @property
    def largest_assembly_error(self) -> float:
        """Largest displacement by a single assembly error [m]; rotations are multiplied by the size."""
        unit = np.repeat([1.0, self.size], 3)
        found = [float(np.linalg.norm(joint.assembly_error * unit)) for joint in self.joints]
        return max([*found, *(abs(beam.length_error) for beam in self.beams)], default=0.0)


#: Indices of the free directions, by entry of the table of joint types: x is along the joint's axis. Universal joints are treated
#: separately.
NUMBERS = {Axes.NONE: (), Axes.AXIS: (0,), Axes.ACROSS: (1, 2), Axes.ALL: (0, 1, 2)}
#: Largest angle between a free direction and the span of a joint's elastic axes that counts as zero [rad].
ALONG = 1e-9


def axes_along(x: Array, y: Array) -> Array:
    """Return right-handed axes (3, 3) as columns: x along the first vector, y in the plane of both."""
    x = x / np.linalg.norm(x)
    y = y - x * (x @ y)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def joint_axes(joint: PlacedJoint) -> Array:
    """Return axes (3, 3): x along the joint's axis; of a universal joint, y along its first axis and x normal to both.

    For a joint without an axis, these are the axes of the joint frame on the predecessor.
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
    """Return axes (3, 3) of a joint, and the mask (6,) of free directions along and about them.

    A direction is not free if the joint is locked, or if the direction is in the span of the axes with finite stiffness.
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
        loose = [axis for axis in (joint.axis, joint.axis2) if not held(1, axis)]
        if len(loose) == 1:  # the two axes need not be perpendicular
            axes = axes_along(loose[0], np.cross(joint.axis, joint.axis2))
        free[{0: [], 1: [3], 2: [4, 5]}[len(loose)]] = True
        return axes, free
    for group, directions in enumerate((joint.type.slides, joint.type.turns)):
        for direction in NUMBERS[directions]:
            free[3 * group + direction] = not held(group, axes[:, direction])
    return axes, free


def joint_springs(joint: PlacedJoint, elastic: JointStiffness | None) -> tuple[FrameSpring, ...]:
    """Return the springs of an elastic joint, in series: its bearing and its actuator."""
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
        error: this displacement as given by the user, in world axes or with its own ``frame``; or None.
        joint: the joint.
    """
    if error is None or (isinstance(error, Mapping) and "twist" not in error):  # a beam with the joint's name has this error
        return np.zeros(6)
    own = isinstance(error, Mapping) and error.get("frame", "world") == "joint"
    twist = np.asarray(error["twist"] if isinstance(error, Mapping) else error, dtype=float)
    if not own:
        return twist
    axes = joint.frames[0][:3, :3]
    return np.append(axes @ twist[:3], axes @ twist[3:])
