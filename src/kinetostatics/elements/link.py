"""Elastic links: the questions that topology, weights, statics and vibration ask of a link between two ends.

A class of links that subclasses :class:`ElasticLink` answers those that have no default. Its *ends* are the ends of its span,
the start towards the base. With the start fixed, the twist of the end is F w + S g in the link's axes, with a wrench w about the
end and gravity g.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.element import ElasticElement, WithoutInside
from kinetostatics.elements.joint import ElasticJoints, PlacedJoints
from kinetostatics.elements.rods import Numbers, VibratingMatrices
from kinetostatics.exceptions import StaticsError
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import normalize
from kinetostatics.mechanism.beam_geometry import Span
from kinetostatics.mechanism.joints import ElasticJoint
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import FixedVectors, Frames

if TYPE_CHECKING:
    import pinocchio as pin


class VibratingLink(Protocol):
    """Dynamic stiffness D(λ) of a link at N poses, at the square λ = ω² (N, m) of the angular frequency [1/s²].

    Rows and columns are the twists [d; r] of start and end, in the link's axes, then b ``inner`` coordinates; forces on the link.
    """

    @property
    def inner(self) -> int: ...

    def take(self, poses: Index) -> VibratingLink:
        """Return the link at some of the poses."""

    def piece(self, count: int) -> VibratingLink:
        """Return one of ``count`` equal pieces of the link, one after the other."""

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        """Return D (N, m, 12 + b, 12 + b); λ may be complex."""

    def pencil(self, square: Array) -> tuple[Array, Array]:
        """Return K̃ and M̃ (N, m, 12 + b, 12 + b) of D(λ) = K̃ − λ M̃ with M̃ = −dD/dλ."""

    def clamped_square(self) -> Array:
        """Return a lower bound (N, 1) of the lowest λ of the link with clamped ends; infinite if it has no modes then."""

    def clamped_modes(self, square: Array) -> Index:
        """Return the number (N, m) of modes below λ of the link with clamped ends."""

    def axial_stiffness(self) -> Array:
        """Return the static stiffness (N, 1) [N/m] along the axis of a telescopic link."""

    def inside(self, ends: Array, forces: Array, square: Array, fraction: float) -> Array:
        """Return displacement and rotation (N, m, 6) at a fraction of the length, of a link with an inside.

        Args:
            ends, forces: (N, m, 12) motions of the ends, and forces on them.
        """


@dataclass(frozen=True, eq=False)
class LinkSurface:
    """Surface of an elastic link, in its axes; it is displaced linearly with the link's coordinates.

    Attributes:
        points, triangles: (S, 3) [m] in the frame of the robot's link, and (T, 3) numbers of points.
        recovery: (S, 3, 6n + m) displacements by unit twists [d; r] of the ends, start first, and internal coordinates.
        vibration: the link in vibrations.
        weight: (m, 3) loads on the internal coordinates due to gravity of 1 m/s² along each axis.
    """

    points: Array
    triangles: Index
    recovery: Array
    vibration: VibratingMatrices
    weight: Array


class ElasticLink(Protocol):
    """An elastic link of a robot, independent of the pose.

    Attributes:
        name: its name.
        span: bodies and positions of its ends.
        axes: (3, 3) its axes as columns, in the carrier body.
        centre: (3,) its centre of mass in the carrier body [m]; None: the middle between its ends.
        telescopic: whether its length depends on the pose.
        surface: its surface, if known.
    """

    name: str
    span: Span
    axes: Array
    centre: Array | None
    telescopic: bool = False
    surface: LinkSurface | None = None

    def ends(self, frames: Frames) -> tuple[Array, Array]:
        """Return the positions (3, N) [m] of start and end, world axes."""
        span = self.span
        return frames.point(span.start_body, span.start), frames.point(span.end_body, span.end)

    def world_axes(self, frames: Frames) -> Array:
        """Return the axes x, y, z as columns (3, 3, N), world axes."""
        return frames.orientations(np.array([self.span.carrier]), self.axes[:, :, None])[:, :, 0]

    def length(self, frames: Frames) -> Array:
        """Return the distance (N,) [m] of the ends."""
        start, end = self.ends(frames)
        return np.asanyarray(np.sqrt(np.sum((end - start) ** 2, axis=0)))

    def remaining_length(self, frames: Frames) -> Array:
        """Return the length (N,) [m]; negative where a telescopic link is retracted too far."""
        return self.length(frames)

    def turning_compliance(self, frames: Frames) -> Array:
        """Return an upper bound (N,) [rad/(N·m)] of the rotation of end and chord relative to the start, per unit of moment."""
        return np.full_like(self.length(frames), np.inf)  # unknown

    def mass_at(self, frames: Frames) -> Array:
        """Return the mass (N,) [kg]."""
        raise NotImplementedError

    def inertia_at(self, frames: Frames) -> tuple[int, pin.Inertia]:
        """Return the link as a rigid body at one pose: the carrier body, and the ``pin.Inertia`` in it."""
        raise NotImplementedError

    def misfit(self, frames: Frames, kind: str) -> Array:
        """Return the twist (6, N) of the end, about it, world axes, per unit of an assembly error, such as 1 m of "length"."""
        raise NotImplementedError

    def inertial_load(
        self,
        frames: Frames,
        acceleration: Callable[[int, Array], Array],
        couple: Callable[[int, Array, Array], Array],
    ) -> tuple[Array | None, Sequence[Array]]:
        """Return the inertial load of a moving link, world axes.

        It consists of the load (12, N) along the link, force and moment per length at its start, then at its end (None for links
        without an inside), and of wrenches (6, N) at start and ends that replace it, each about the end at which it acts.

        Args:
            acceleration: returns the acceleration (3, N) [m/s²] of a point (3, N) of a body.
            couple: returns −(J α + ω × J ω) (3, N) of a body for an inertia J (3, 3) in given axes (3, 3, N).

        Raises:
            StaticsError: the load is unknown.
        """
        raise StaticsError(f"the inertial load of the elastic link {self.name!r} is unknown: it is no beam")

    def vibrating(self, frames: Frames) -> VibratingLink:
        """Return the link's dynamic stiffness."""
        raise NotImplementedError

    def stacked(
        self, links: Sequence[ElasticLink], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> ElasticElement:
        """Return corresponding links of g equal limbs; arguments as of :class:`kinetostatics.elements.joint.ElasticJoints`.

        Links with constant F and S return :class:`ElasticLinks`.
        """
        raise NotImplementedError

    def coupled(
        self,
        links: Sequence[Sequence[ElasticLink]],
        edges: Sequence[Sequence[Edge]],
        elements: Sequence[int],
        signs: NDArray[np.int8],
    ) -> ElasticElement:
        """Return corresponding links of g equal limbs with p ≥ 2 outer ends.

        Args:
            links, edges: for each limb, the link at each outer end, and the edges.
            elements: indices of the p elements in the limb.
            signs: (p, M) signs of the cut-joint wrenches at each end.
        """
        raise TypeError(f"{self.name!r} has two ends")


class PlacedLink(Protocol):
    """The description of an elastic link that is no beam, see :class:`kinetostatics.description.flexible.ElasticPart`."""

    def model(self, mechanism: Mechanism, span: Span, zero: Frames) -> ElasticLink:
        """Return the link in its robot, with ``span`` from base to platform; ``zero`` is the closed zero pose."""


class ElasticLinks(ElasticJoints):
    """Corresponding links of g equal limbs, as elastic joints at their ends with a displacement under their own weight."""

    kind = "links"
    in_every_direction = has_line = True

    def __init__(
        self,
        links: Sequence[ElasticLink],
        flexibilities: Sequence[tuple[Array, Array]],
        edges: Sequence[Edge],
        element: int = 0,
        signs: NDArray[np.int8] | None = None,
    ) -> None:
        """Set the links and their ``flexibilities``: F (6, 6) [m/N, …] and S (6, 3) [m/(m/s²), …] of each."""
        compliances, sags = zip(*flexibilities, strict=True)
        frames = [np.block([[link.axes, link.span.end[:, None]], [0.0, 0.0, 0.0, 1.0]]) for link in links]
        parts = zip(links, frames, compliances, strict=True)
        super().__init__([ElasticJoint(link.name, link.span.end_body, *rest) for link, *rest in parts], edges, element, signs)
        self.sag, self.stiffness = np.stack(sags, axis=-1), np.stack([np.linalg.inv(item) for item in compliances], axis=-1)
        self._starts = FixedVectors([[(link.span.start_body, link.span.start)] for link in links])

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedLinks:
        at = super().placed(frames, o, twists)
        along = normalize(at.arm + o[:, None] - self._starts.points(frames)[:, 0])
        return PlacedLinks(at.signs, at.element, at.axes, at.arm, self, self, along)


class StackedMatrices(Protocol):
    """Matrices of g links: S (6p, 3, g), and the stiffness (6p, 6p, g) of their outer ends."""

    sag: Array
    stiffness: Array


class UnderOwnWeight(WithoutInside):
    """What links with constant F and S have in common at N poses; ``axes`` (3, 3, g, N): their axes, world axes."""

    links: StackedMatrices
    axes: Array

    def own_load(self, gravity: Array) -> Array:
        return np.einsum("ijgn,in->jgn", self.axes, gravity)

    def own_displacement(self, load: Array) -> Array:
        """Return u_0 = S g."""
        return np.einsum("ijg,j...gn->i...gn", self.links.sag, load)

    def strain_energy(self, forces: Array, displacements: Array) -> Array:
        """Return ½ uᵀ F⁻¹ u: under the own weight, u is not F w."""
        return np.einsum("ign,ijg,jgn->gn", displacements, self.links.stiffness, displacements) / 2


@dataclass(frozen=True, eq=False)
class PlacedLinks(UnderOwnWeight, PlacedJoints):
    """Corresponding links at N poses; ``along`` (3, g, N) are the directions from their starts to their ends."""

    links: ElasticLinks
    along: Array

    @property
    def line(self) -> tuple[Array, Array]:
        return self.along, self.arm


def no_length_text(beams: Iterable[ElasticLink], frames: Frames, pose: int) -> str | None:
    """Return an error message that names the telescopic beams without length at a pose; None if there is none."""
    short = {beam.name: float(beam.remaining_length(frames)[pose]) for beam in beams if beam.telescopic}
    named = ", ".join(f"{name!r} ({length:.3g} m from start to end)" for name, length in short.items() if length <= 0)
    return f"telescopic beams have no length at this pose: {named}" if named else None
