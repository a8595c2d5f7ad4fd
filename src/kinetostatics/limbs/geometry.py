"""Geometry of equal limbs at N poses: unit twists, joint centres, limb axes and beam axes, and unit wrenches along
these axes. The inboard side of a joint is the side of the base, its outboard side the side of the platform.

Axes and centres are fixed in bodies of the robot. Arrays are ``(component, member, limb, pose)``, world axes, arms from o.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.elements.element import ElasticElement, PlacedElement
from kinetostatics.elements.static_model import StaticModel
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import axis_across, cross, dot, normalize
from kinetostatics.math.screws import unit_twist, wrench_of_couple, wrench_of_force
from kinetostatics.mechanism.joints import CompoundJoint, sides
from kinetostatics.mechanism.limbs import Limb
from kinetostatics.mechanism.tree import FixedVectors, Frames

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
        direction: ``("limb", k)``: axis x, y or z of the limb; ``("beam", e)``: along the line of the e-th elastic element;
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
        elements: the elastic elements.
    """

    axes: Array
    twists: Array
    centres: Array
    limb_axes: Array
    elements: tuple[PlacedElement, ...]


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
        elements: Sequence[ElasticElement],
    ) -> None:
        self._compounds, self._elements = compounds[0], tuple(elements)
        self.dofs = rows = [[dof for compound in row for dof in compound.dofs] for row in compounds]
        self.rotates = np.array([dof.rotates for dof in rows[0]], dtype=bool)
        self.passive = np.array([dof.passive for dof in rows[0]], dtype=bool)
        self.compound_of = np.array([k for k, compound in enumerate(compounds[0]) for _ in compound.dofs], dtype=np.intp)
        signs = np.array([[f.sign for f in row] for row in rows], dtype=float).reshape(len(rows), -1).T[..., None]
        self._signs = signs if np.any(signs < 0) else None
        self._axes = FixedVectors([[(f.body, f.axis) for f in row] for row in rows])
        self._centres = FixedVectors([[(f.centre_body, f.centre) for f in row] for row in rows])
        self._outer_ends = FixedVectors([[_outer_point(model, limb)] for limb in limbs])
        self._without_centre = _nearest_centres([compound.has_centre for compound in self._compounds], limbs[0].is_serial)
        last = self._compounds[-1] if self._compounds and self._compounds[-1].edge == len(limbs[0].edges) - 1 else None
        self._ends_at_joint = last is not None and (not last.has_centre or all(dof.rotates for dof in last.dofs))
        self._last_dofs = [int(np.flatnonzero(self.compound_of == u)[-1]) for u in range(len(self._compounds))]
        axes, arms, centres = self._joints(model.zero_frames, np.zeros((3, 1)))
        placed = self._placed(model.zero_frames, np.zeros((3, 1)), self._twists(axes, arms))
        z = self._limb_z(placed, centres)[:, :, 0]
        self.y_choice = self._choose_y(axes[:, :, 0, 0], z[:, 0])
        self._world_y = axis_across(z)
        named = np.array([compound.has_axis(dof.rotates) for compound in compounds[0] for dof in compound.dofs], dtype=bool)
        moments = np.where(self.rotates[:, None], cross(arms, axes)[..., 0], 0.0)
        self._orientations = _orientations(axes[..., 0], moments, named, model.length)[:, :, None]

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        axes, arms, centres = self._joints(frames, o)
        twists = self._twists(axes, arms)
        axes = axes * self._orientations
        elements = self._placed(frames, o, twists)
        z = self._limb_z(elements, centres)
        reference = axes[:, self.y_choice[1]] if self.y_choice[0] == "axis" else self._world_y[:, :, None]
        y = normalize(reference - z * dot(z, reference))
        return LimbGeometry(
            axes=axes,
            twists=twists,
            centres=centres,
            limb_axes=np.stack([cross(y, z), y, z], axis=1),
            elements=elements,
        )

    def _placed(self, frames: Frames, o: Array, twists: Array) -> tuple[PlacedElement, ...]:
        return tuple(element.placed(frames, o, twists) for element in self._elements)

    def _twists(self, axes: Array, arms: Array) -> Array:
        twists = unit_twist(axes, arms, self.rotates[:, None, None])
        if self._signs is not None:
            twists *= self._signs
        return twists

    def _joints(self, frames: Frames, o: Array) -> tuple[Array, Array, Array]:
        """Return axes of the freedoms as in the file, arms to a point of each axis (3, k, g, N), and ``LimbGeometry.centres``."""
        axes, arms = self._axes.at(frames), self._centres.points(frames) - o[:, None, None]
        centres = np.concatenate([arms[:, self._last_dofs], self._outer_ends.points(frames) - o[:, None, None]], axis=1)
        for compound, near in self._without_centre.items():
            along = axes[:, self._last_dofs[compound]]
            arm = centres[:, compound] if near is None else centres[:, compound] - centres[:, near]
            centres[:, compound] -= along * dot(along, arm)
        if self._ends_at_joint:  # at the intersection of the last joint's axes
            centres[:, -1] = centres[:, -2]
        return axes, arms, centres

    def _limb_z(self, elements: Sequence[PlacedElement], centres: Array) -> Array:
        """Return the limbs' z axes (3, g, N): along the last beam, else from the first joint to the platform end, else up."""
        lines = [element.line for element in elements if element.line is not None]
        if lines:
            return lines[-1][0]
        axis = centres[:, -1] - centres[:, 0]
        far = dot(axis, axis) > 1e-18
        return np.where(far, normalize(axis), np.array([0.0, 0.0, 1.0])[:, None, None])

    def _choose_y(self, axes: Array, z: Array) -> tuple[str, int]:
        """Choose the reference of the y axis, not parallel to ``z`` (3,).

        In order of preference: a passive single axis, an axis of a passive universal joint, an actuated single axis, the world.
        """
        for turns, passive in ((Axes.AXIS, True), (Axes.BOTH, True), (Axes.AXIS, False)):
            for f, k in enumerate(self.compound_of):
                kind = self._compounds[k].type
                suitable = kind.turns is turns and kind.slides is not Axes.ACROSS
                if suitable and self.passive[f] == passive and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                    return "axis", f
        return "world", -1


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
    if edge.span:
        span = model.topology.spans[edge.span]
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
            line = geometry.elements[int(candidate.direction[1])].line
            assert line is not None
            return wrench_of_force(*line)
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
    """Return the arm s × s_0 (3, g, N) from o to the point of a rotation axis nearest to o, for its twist [s_0; s]."""
    twist = geometry.twists[:, dof]
    return cross(twist[3:], twist[:3])


def meeting_point(f: int, h: int, geometry: LimbGeometry, least: float = PARALLEL) -> Array:
    """Return the point p + a ((q − p) × b · n) / n² (3, g, N), n = a × b, of one axis nearest to another; NaN if parallel."""
    a, b = geometry.axes[:, f], geometry.axes[:, h]
    start, normal = foot(f, geometry), cross(a, b)
    square = dot(normal, normal)
    square = np.where(square > max(least, _MEETS_NOWHERE) ** 2, square, np.nan)
    return np.asarray(start + a * dot(cross(foot(h, geometry) - start, b), normal) / square)
