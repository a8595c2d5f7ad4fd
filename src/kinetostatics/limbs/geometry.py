"""Geometry of equal limbs at N poses: unit twists, joint centres, limb axes and beam axes, and unit wrenches along
these axes. The inboard side of a joint is the side of the base, its outboard side the side of the platform.

Axes and centres are fixed in bodies of the robot. Arrays are ``(component, member, limb, pose)``, world axes, arms from o.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.limbs.static_model import StaticModel
from kinetostatics.math.arrays import Array, Index, Mask, zeros_for
from kinetostatics.math.linalg import axis_across, cross, dot, normalize
from kinetostatics.math.screws import unit_twist, wrench_of_couple, wrench_of_force
from kinetostatics.mechanism.beam_model import BeamModel
from kinetostatics.mechanism.joints import CompoundJoint, ElasticJoint, sides
from kinetostatics.mechanism.limbs import Limb
from kinetostatics.mechanism.tree import Frames

#: Cosine of the angle between axes that count as parallel.
_ALIKE = 1 - 1e-6
#: Sine of the angle below which two directions count as parallel; also a distance relative to the characteristic length.
PARALLEL = 1e-6
#: Sine of the angle below which two axes have no intersection.
_MEETS_NOWHERE = 1e-3
#: A component of a unit vector above this decides its sign.
_CLEAR = 0.2


@dataclass(frozen=True)
class Candidate:
    """A candidate wrench: a unit force through the centre of a joint, or a unit couple, along a direction.

    Attributes:
        direction: ``("limb", k)``: axis x, y or z of the limb; ``("beam", b)``: along the b-th beam, through its platform end;
            ``("axis", f)``: axis of the f-th freedom; ``("cross", f, h)``: perpendicular to the axes of two freedoms;
            ``("cross_limb", f, k)``: perpendicular to the axis of a freedom and a limb axis; ``("to", u)``: towards the centre of
            the u-th joint; ``("meets", f, h)``: intersecting the axes of two freedoms; ``("complement", s)``: no direction, but
            the s-th seed of a complementary wrench, see :mod:`kinetostatics.limbs.basis_choice`.
        centre: the joint whose centre lies on the line of the force; or two freedoms, whose axes intersect on this line; None for
            a couple.
        label: name in reports.
    """

    NOT_RECORDED: ClassVar = ("label",)

    direction: tuple[str | int, ...]
    centre: int | tuple[int, int] | None
    label: str


@dataclass(frozen=True)
class Basis:
    """The candidates chosen for one limb.

    Attributes:
        constraint, attached: chosen candidates of J_ic and J_ig.
        independent: indices of allowed twists that are independent at generic poses, for the completion of J_ic.
        carried: indices of freedoms of the platform joint that are independent at generic poses, for the completion of J_ig.
        gap: ratio of the smallest kept to the largest dropped singular value of the limb's twists.
    """

    constraint: tuple[Candidate, ...]
    attached: tuple[Candidate, ...]
    independent: tuple[int, ...]
    carried: tuple[int, ...]
    gap: float


@dataclass(frozen=True)
class LimbGeometry:
    """Geometry of a group of g limbs at N poses; all arms are from o [m], world axes.

    Attributes:
        axes: (3, k, g, N) axes of all freedoms, with a sense that does not depend on the file, see :func:`_orientations`.
        twists: (6, k, g, N) unit twists of all freedoms about o, outboard relative to inboard side, as in Eqs. (2), (4).
        centres: (3, compounds + 1, g, N) joint centres, and the platform end of the limb. A joint without a centre has the point
            of its axis nearest to the neighbouring joint centre; in a limb with rings, nearest to o.
        limb_axes: (3, 3, g, N) columns x, y, z; z along the limb.
        beam_axes: (3, 3, beams, g, N).
        beam_lengths: (beams, g, N) [m].
        beam_ends: (3, beams, g, N) platform ends.
        beam_levers: (3, beams, g, N) vectors from the middles of beams to their centres of mass.
        spring_axes: (3, 3, springs, g, N) axes of the frames of elastic joints.
        spring_arms: (3, springs, g, N) origins of the frames of elastic joints.
    """

    axes: Array
    twists: Array
    centres: Array
    limb_axes: Array
    beam_axes: Array
    beam_lengths: Array
    beam_ends: Array
    beam_levers: Array
    spring_axes: Array
    spring_arms: Array


class LimbSkeleton:
    """Points and directions of equal limbs, fixed in the bodies of the robot.

    Attributes:
        dofs: for every limb, the freedoms of its joints, inboard ones first.
        rotates: (k,) True for rotations.
        passive: (k,) True for passive freedoms.
        compound_of: (k,) index of the compound joint of each freedom.
        y_choice: reference of the y axis: ``("axis", f)`` or ``("world", -1)``.
    """

    def __init__(
        self,
        model: StaticModel,
        limbs: Sequence[Limb],
        compounds: Sequence[Sequence[CompoundJoint]],
        beams: Sequence[Sequence[BeamModel]],
        springs: Sequence[Sequence[ElasticJoint]],
    ) -> None:
        self._compounds = compounds[0]
        self.dofs = rows = [[dof for compound in row for dof in compound.dofs] for row in compounds]
        self.rotates = np.array([dof.rotates for dof in rows[0]], dtype=bool)
        self.passive = np.array([dof.passive for dof in rows[0]], dtype=bool)
        self.compound_of = np.array([k for k, compound in enumerate(compounds[0]) for _ in compound.dofs], dtype=np.intp)
        signs = np.array([[f.sign for f in row] for row in rows], dtype=float).reshape(len(rows), -1).T[..., None]
        self._signs = signs if np.any(signs < 0) else None
        spans = [[beam.span for beam in row] for row in beams]
        self._axes = _Vectors([[(f.body, f.axis) for f in row] for row in rows])
        self._beam_axes = _Vectors([[(beam.span.carrier, beam.axes) for beam in row] for row in beams], (3, 3))
        self._spring_axes = _Vectors([[(spring.body, spring.frame[:3, :3]) for spring in row] for row in springs], (3, 3))
        self._centres = _Vectors([[(f.centre_body, f.centre) for f in row] for row in rows])
        self._outer_ends = _Vectors([[_outer_point(model, limb)] for limb in limbs])
        self._beam_starts = _Vectors([[(s.start_body, s.start) for s in row] for row in spans])
        self._beam_ends = _Vectors([[(s.end_body, s.end) for s in row] for row in spans])
        given = [[np.zeros(3) if beam.centre is None else beam.centre for beam in row] for row in beams]
        self._beam_centres = _Vectors(
            [[(s.carrier, c) for s, c in zip(*row, strict=True)] for row in zip(spans, given, strict=True)]
        )
        centred = [[beam.centre is not None for beam in row] for row in beams]
        self._centred = np.array(centred, dtype=bool).reshape(len(beams), -1).T[..., None]
        self._spring_points = _Vectors([[(spring.body, spring.frame[:3, 3]) for spring in row] for row in springs])
        self._loose = _nearest_centres([compound.has_centre for compound in self._compounds], limbs[0].is_serial)
        last = self._compounds[-1] if self._compounds and self._compounds[-1].edge == len(limbs[0].edges) - 1 else None
        self._ends_at_joint = last is not None and (not last.has_centre or all(dof.rotates for dof in last.dofs))
        self._last_dofs = [int(np.flatnonzero(self.compound_of == u)[-1]) for u in range(len(self._compounds))]
        zero = model.zero_frames
        axes, arms, centres = self._joints(zero, np.zeros((3, 1)))
        z = self._limb_z(self._beam_axes.at(zero), centres)[:, :, 0]
        self.y_choice = self._choose_y(axes[:, :, 0, 0], z[:, 0])
        self._world_y = axis_across(z)
        named = np.array([compound.has_axis(dof.rotates) for compound in compounds[0] for dof in compound.dofs], dtype=bool)
        moments = np.where(self.rotates[:, None], cross(arms, axes)[..., 0], 0.0)
        self._orientations = _orientations(axes[..., 0], moments, named, model.length)[:, :, None]

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        beam_axes, spring_axes = self._beam_axes.at(frames), self._spring_axes.at(frames)
        axes, arms, centres = self._joints(frames, o)
        o = o[:, None, None]
        twists = unit_twist(axes, arms, self.rotates[:, None, None])
        if self._signs is not None:
            twists *= self._signs
        axes = axes * self._orientations
        beam_starts, beam_ends = self._beam_starts.points(frames), self._beam_ends.points(frames)
        beam_levers = zeros_for(beam_ends.shape, beam_ends)
        if np.any(self._centred):
            beam_levers = np.where(self._centred, self._beam_centres.points(frames) - (beam_starts + beam_ends) / 2, beam_levers)
        z = self._limb_z(beam_axes, centres)
        reference = axes[:, self.y_choice[1]] if self.y_choice[0] == "axis" else self._world_y[:, :, None]
        y = normalize(reference - z * dot(z, reference))
        return LimbGeometry(
            axes=axes,
            twists=twists,
            centres=centres,
            limb_axes=np.stack([cross(y, z), y, z], axis=1),
            beam_axes=beam_axes,
            beam_lengths=dot(beam_axes[:, 0], beam_ends - beam_starts),
            beam_ends=beam_ends - o,
            beam_levers=beam_levers,
            spring_axes=spring_axes,
            spring_arms=self._spring_points.points(frames) - o,
        )

    def _joints(self, frames: Frames, o: Array) -> tuple[Array, Array, Array]:
        """Return axes of the freedoms as in the file, arms to a point of each axis (3, k, g, N), and ``LimbGeometry.centres``."""
        axes, arms = self._axes.at(frames), self._centres.points(frames) - o[:, None, None]
        centres = np.concatenate([arms[:, self._last_dofs], self._outer_ends.points(frames) - o[:, None, None]], axis=1)
        for compound, near in self._loose.items():
            along = axes[:, self._last_dofs[compound]]
            arm = centres[:, compound] if near is None else centres[:, compound] - centres[:, near]
            centres[:, compound] -= along * dot(along, arm)
        if self._ends_at_joint:  # at the intersection of the last joint's axes
            centres[:, -1] = centres[:, -2]
        return axes, arms, centres

    def _limb_z(self, beam_axes: Array, centres: Array) -> Array:
        """Return the limbs' z axes (3, g, N): along the last beam, else from the first joint to the platform end, else up."""
        if beam_axes.shape[2]:
            return beam_axes[:, 0, -1]
        axis = centres[:, -1] - centres[:, 0]
        far = dot(axis, axis) > 1e-18
        return np.where(far, normalize(axis), np.array([0.0, 0.0, 1.0])[:, None, None])

    def _choose_y(self, axes: Array, z: Array) -> tuple[str, int]:
        """Choose the reference of the y axis, not parallel to ``z`` (3,).

        In order of preference: a passive single axis, an axis of a passive universal joint, a driven single axis, the world.
        """
        for turns, passive in ((Axes.AXIS, True), (Axes.BOTH, True), (Axes.AXIS, False)):
            for f, k in enumerate(self.compound_of):
                kind = self._compounds[k].type
                suitable = kind.turns is turns and kind.slides is not Axes.ACROSS
                if suitable and self.passive[f] == passive and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                    return "axis", f
        return "world", -1


class _Vectors:
    """Points or directions (3,), or axes (3, 3), fixed in bodies, for the k members of each of g limbs."""

    def __init__(self, rows: list[list[tuple[int, Array]]], shape: tuple[int, ...] = (3,)) -> None:
        g, k = len(rows), len(rows[0])
        self._shape = (*shape, k, g)
        self._bodies = np.array([body for row in rows for body, _ in row], dtype=np.intp).reshape(g, k).T.ravel()
        vectors = np.array([vector for row in rows for _, vector in row], dtype=float).reshape(g, k, *shape)
        self._vectors = np.moveaxis(vectors, (0, 1), (-1, -2)).reshape(*shape, k * g)

    def points(self, frames: Frames) -> Array:
        """Return points in the world (3, k, g, N) [m]."""
        return self._shaped(frames.points, frames)

    def at(self, frames: Frames) -> Array:
        """Return directions (3, k, g, N) or axes (3, 3, k, g, N) in the world."""
        return self._shaped(frames.directions if self._vectors.ndim == 2 else frames.orientations, frames)

    def _shaped(self, evaluate: Callable[[Index, Array], Array], frames: Frames) -> Array:
        N = frames.position.shape[2]
        if not self._bodies.size:  # avoid indexing
            return zeros_for((*self._shape, N), frames.position)
        return evaluate(self._bodies, self._vectors).reshape(*self._shape, N)


def _nearest_centres(has_centre: Sequence[bool], is_serial: bool) -> dict[int, int | None]:
    """Return, for each joint without a centre, the nearest joint with a centre; of two equally near joints, the outer one.

    The value is None if no joint has a centre, and in a limb with rings.
    """
    known = [u for u, has in enumerate(has_centre) if has and is_serial]
    return {
        u: min(known, key=lambda other: (abs(other - u), -other), default=None) for u, has in enumerate(has_centre) if not has
    }


def _orientations(axes: Array, moments: Array, named: Mask, length: float) -> Array:
    """Return the signs (k, g) of the axes of g limbs that give each axis a sense independent of the file.

    At the closed zero pose an axis points upwards. A horizontal axis is directed anticlockwise about the world's z axis; if it
    intersects the z axis, it has a positive component along x, or else along y. Parallel axes of a limb have the same sense.

    Args:
        axes: (3, k, g) directions of the axes in the file.
        moments: (3, k, g) moments of unit forces along the axes, about the world's origin [m]; zero for translations.
        named: (k,) True for axes that are features of the robot, False for arbitrary axes of the file, as in a spherical joint.
            Only the moments of features are used.
    """
    cosines = np.einsum("ikg,ihg->khg", axes, axes) * named[:, None]
    alike = np.where(np.abs(cosines) > _ALIKE, np.sign(cosines), 0.0)
    around = np.einsum("khg,hg->kg", alike, moments[2] * named[:, None]) / length
    signs = np.ones(axes.shape[1:])
    for size in (axes[1], axes[0], around, axes[2]):  # the last has priority
        signs = np.where(np.abs(size) > _CLEAR, np.sign(size), signs)
    return signs


def _outer_point(model: StaticModel, limb: Limb) -> tuple[int, Array]:
    """Return body and point (3,) [m] of the platform end of a limb: its last joint or beam end."""
    edge = limb.edges[-1]
    if edge.beam:
        span = model.beams[edge.beam].span
        return span.end_body, span.end
    body, frame = sides(edge, model.mechanism.connections[str(edge.joint)])[1]
    return body, frame[:3, 3]


class CandidateWrenches:
    """The wrenches of candidates; directions are computed once and used at all points of application."""

    def __init__(self, geometry: LimbGeometry, length: float, least: float) -> None:
        """Set the geometry and the smallest angles.

        Args:
            length: characteristic length [m].
            least: two directions determine a third if the sine of their angle exceeds this value, two points if their distance
                exceeds this value times ``length``.
        """
        self.geometry, self.length, self.least = geometry, length, least
        self._known: dict[tuple[str | int, ...], Array] = {}

    def of(self, candidate: Candidate) -> Array:
        """Return the wrenches (6, g, N) of a candidate about o; NaN where its direction is undetermined."""
        geometry = self.geometry
        if candidate.direction[0] == "beam":
            number = int(candidate.direction[1])
            return wrench_of_force(geometry.beam_axes[:, 0, number], geometry.beam_ends[:, number])
        if candidate.centre is None:
            return wrench_of_couple(self._direction(candidate.direction, None))
        if isinstance(candidate.centre, tuple):
            point = meeting_point(*candidate.centre, geometry, self.least)
        else:
            point = geometry.centres[:, candidate.centre]
        return wrench_of_force(self._direction(candidate.direction, point), point)

    def _direction(self, direction: tuple[str | int, ...], point: Array | None) -> Array:
        """Return a unit vector (3, g, N); ``point`` (3, g, N) is the point of application of a force, or None."""
        if point is not None and direction[0] in ("to", "meets"):
            return self._from(point, str(direction[0]), [int(number) for number in direction[1:]])
        if direction not in self._known:
            self._known[direction] = self._fixed(str(direction[0]), [int(number) for number in direction[1:]])
        return self._known[direction]

    def _fixed(self, kind: str, which: list[int]) -> Array:
        geometry = self.geometry
        if kind == "limb":
            return geometry.limb_axes[:, which[0]]
        if kind == "axis":
            return geometry.axes[:, which[0]]
        other = geometry.axes if kind == "cross" else geometry.limb_axes
        return self._along(cross(geometry.axes[:, which[0]], other[:, which[1]]), 1.0)

    def _from(self, point: Array, kind: str, which: list[int]) -> Array:
        geometry = self.geometry
        if kind == "to":
            return self._along(geometry.centres[:, which[0]] - point, self.length)
        # planes through the point, each with one of the axes
        planes = [self._along(cross(geometry.axes[:, f], point - foot(f, geometry)), self.length) for f in which]
        return self._along(cross(planes[0], planes[1]), 1.0)

    def _along(self, vector: Array, size: float) -> Array:
        square = dot(vector, vector)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(square > (self.least * size) ** 2, vector / np.sqrt(square), np.nan)


def foot(dof: int, geometry: LimbGeometry) -> Array:
    """Return the arm (3, g, N) from o to the point of a rotation axis nearest to o."""
    twist = geometry.twists[:, dof]
    return cross(twist[3:], twist[:3])


def meeting_point(f: int, h: int, geometry: LimbGeometry, least: float = PARALLEL) -> Array:
    """Return the point (3, g, N) of one rotation axis nearest to another; NaN if they are parallel."""
    a, b = geometry.axes[:, f], geometry.axes[:, h]
    start, normal = foot(f, geometry), cross(a, b)
    square = dot(normal, normal)
    square = np.where(square > max(least, _MEETS_NOWHERE) ** 2, square, np.nan)
    return np.asarray(start + a * dot(cross(foot(h, geometry) - start, b), normal) / square)
