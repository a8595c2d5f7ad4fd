"""Straight elastic beams in limbs. Their forces refer to the platform end, and their compliance is that of a cantilever."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements import beam_formulas
from kinetostatics.elements.element import NO_CUTS, ElasticElement, PlacedSection, outboard_masks
from kinetostatics.elements.link import ElasticLink, VibratingLink
from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.elements.profile import Profile
from kinetostatics.elements.rods import Rod
from kinetostatics.elements.turned_forces import UniformInside
from kinetostatics.layout.mapping import ResultMapping, ShortRepr
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross, dot
from kinetostatics.math.screws import move_wrench, rotate
from kinetostatics.mechanism.beam_geometry import Span
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.tree import FixedVectors, Frames
from kinetostatics.sections.kinds import Section

if TYPE_CHECKING:
    import pinocchio as pin

#: Length, relative to the coordinates of the beam's ends, that counts as zero.
ROUNDING = 1e-9
_ACROSS = np.array([0.0, 1.0, 1.0])


@dataclass(frozen=True, repr=False)
class BeamModel(ShortRepr, ElasticLink):
    """Data of a beam, independent of the pose.

    Attributes:
        section: the cross-section.
        axes: (3, 3) beam axes x, y, z as columns, in the carrier body.
        compliances: (6,) section compliances.
        mass_per_length: mass per length [kg/m], or None if the total ``mass`` is given.
        mass: total mass [kg] if ``mass_per_length`` is None, distributed uniformly over the length at every pose; else 0.
        centre: (3,) centre of ``mass`` in the carrier body [m]. The mass, rigidly connected to the sections, is distributed along
            the line through this centre parallel to the beam. None: the mass is distributed along the beam.
        thermal_expansion: α [1/K].
        profile: stiffness and mass of a beam with stations, whose ``compliances`` are the largest of its sections, for estimates.
    """

    NOT_RECORDED: ClassVar = ("section", "thermal_expansion")

    name: str
    section: Section
    span: Span
    axes: Array
    compliances: Array
    mass_per_length: float | None
    mass: float
    centre: Array | None
    thermal_expansion: float = 0.0
    profile: Profile | None = None

    def length(self, frames: Frames) -> Array:
        """Return L = xᵀ (end − start) (N,) [m], along the beam's x axis."""
        start, end = self.ends(frames)
        return dot(frames.direction(self.span.carrier, self.axes[:, 0]), end - start)

    @property
    def telescopic(self) -> bool:  # type: ignore[override]
        return self.span.start_body != self.span.end_body

    def remaining_length(self, frames: Frames) -> Array:
        """The length (N,) [m], 0 if it is only rounding; negative if a telescopic beam is retracted beyond zero length."""
        length = self.length(frames)
        rounding = ROUNDING * np.max(np.abs(np.stack(self.ends(frames))), axis=(0, 1))
        return np.where(np.abs(length) <= rounding, 0.0, length)

    def turning_compliance(self, frames: Frames) -> Array:
        c = self.compliances
        return self.length(frames) * np.maximum(np.maximum(c[3:4], c[4:5]), c[5:])

    def mass_at(self, frames: Frames) -> Array:
        return self.mass_of(self.length(frames))

    def mass_of(self, length: Array) -> Array:
        """Mass [kg] of a beam of the given length (…) [m]; for a beam with a density, zero if the length is negative."""
        return np.full_like(length, self.mass) if self.mass_per_length is None else self.mass_per_length * np.maximum(length, 0)

    def line_density(self, length: Array) -> Array:
        """Mass per length [kg/m] of a beam of the given length (…) [m]; infinite for a given mass and zero length."""
        if self.mass_per_length is not None:
            return np.full_like(length, self.mass_per_length)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asanyarray(self.mass / length)

    def lever(self, frames: Frames) -> Array:
        """Arm (3, N) [m] from the middle of the beam to its centre of mass, world axes."""
        start, end = self.ends(frames)
        return np.zeros_like(start) if self.centre is None else frames.point(self.span.carrier, self.centre) - (start + end) / 2

    def inertia_at(self, frames: Frames) -> tuple[int, pin.Inertia]:
        """Return the beam as a rigid prism at one pose: the carrier body, and the prism's ``pin.Inertia`` in this body.

        About the prism's centre, the moments of inertia are m (I_y + I_z)/A along the axis and m (L²/12 + I/A) across.
        """
        import pinocchio as pin

        span, section = self.span, self.section
        start, end = self.ends(frames)
        R, p = frames.rotation[:, :, span.carrier, 0], frames.position[:, span.carrier, 0]
        centre = ((start + end) / 2 + self.lever(frames))[:, 0]
        length, mass = float(self.length(frames)[0]), float(self.mass_at(frames)[0])
        about = np.diag(np.array([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area + length**2 / 12 * _ACROSS)
        about = about if self.profile is None else self.profile.gyration
        own = mass * self.axes @ about @ self.axes.T
        return span.carrier, pin.Inertia(mass, R.T @ (centre - p), own)

    def misfit(self, frames: Frames, kind: str) -> Array:
        """See :meth:`ElasticLink.misfit`: x per unit of "length", α L x per unit of "temperature"."""
        axis = frames.direction(self.span.carrier, self.axes[:, 0])
        longer = axis if kind == "length" else axis * self.thermal_expansion * self.length(frames)
        return np.concatenate([longer, np.zeros_like(longer)])

    def inertial_load(
        self,
        frames: Frames,
        acceleration: Callable[[int, Array], Array],
        couple: Callable[[int, Array, Array], Array],
    ) -> tuple[Array, tuple[Array, Array]]:
        """See :meth:`ElasticLink.inertial_load`: per length f = −μ a and −μ (i α + ω × i ω) + lever × f, with gyration i."""
        axes, lever, section = self.world_axes(frames), self.lever(frames), self.section
        density, bodies = self.line_density(self.length(frames)), (self.span.start_body, self.span.end_body)
        if self.profile is not None:
            at_start = acceleration(bodies[0], start := self.ends(frames)[0])
            field = [at_start, *(acceleration(bodies[0], start + axes[:, k]) - at_start for k in range(3))]
            return (load := -density * np.concatenate(field)), self.line_resultants(frames, load)
        if self.telescopic:
            lever = lever - axes[:, 0] * dot(axes[:, 0], lever)
        gyration = np.diag([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area
        moment, parts = density * couple(self.span.carrier, axes, gyration), []
        for body, point in zip(bodies, self.ends(frames), strict=True):
            force = -density * acceleration(body, point + lever)
            parts += [force, moment + cross(lever, force)]
        load = np.concatenate(parts)
        return load, self.line_resultants(frames, load)

    def line_resultants(self, frames: Frames, load: Array) -> tuple[Array, Array]:
        """Return wrenches (6, N) at start and end that replace a load (12, N) along the beam, world axes.

        The load is as of :meth:`inertial_load`. Each wrench is about the end at which it acts. The wrenches are the opposites of
        the reactions of the beam clamped at both ends.
        """
        axes, length = self.world_axes(frames), self.length(frames)
        local = np.concatenate([rotate(axes, part, back=True) for part in np.split(load, 2)])
        if self.profile is not None:
            whole, last = (resultant @ local for resultant in self.profile.clamped_resultants)
        else:
            last = -beam_formulas.clamped_reaction(self.compliances[:, None], length, local)
            whole = beam_formulas.outboard_wrench(length, local, np.zeros_like(length))
        first = whole - move_wrench(last, np.outer([1.0, 0.0, 0.0], -length))
        return rotate(axes, first), rotate(axes, last)

    @property
    def inside(self) -> UniformInside | Profile:
        """Inner coordinates, see :mod:`kinetostatics.elements.turned_forces`."""
        return UniformInside(self.compliances) if self.profile is None else self.profile

    def end_displacement(self, length: Array, wrench: Array) -> Array:
        """Return the twists (6, k, N) of the end under wrenches (6, k, N) there, beam axes, with the start clamped."""
        if self.profile is not None:
            return np.tensordot(self.profile.flexibility, wrench, 1)
        return beam_formulas.end_displacement(self.compliances[:, None, None], length, wrench)

    def vibrating(self, frames: Frames) -> VibratingLink:
        if self.profile is not None:
            return self.profile.vibrating(float(self.line_density(self.length(frames))[0]))
        length, axes = self.length(frames), self.world_axes(frames).transpose(2, 1, 0)
        gyration = np.array([self.section.I_y, self.section.I_z]) / self.section.area
        arm = None if self.centre is None else (axes @ self.lever(frames).T[..., None])[..., 0].T[..., None]
        return Rod(length[:, None], self.compliances, self.line_density(length)[:, None], gyration, arm)

    def stacked(
        self, links: Sequence[ElasticLink], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> ElasticElement:
        return Beams([link for link in links if isinstance(link, BeamModel)], edges, element, signs)


def beams_of(links: Mapping[str, ElasticLink]) -> Mapping[str, BeamModel]:
    """Return the beams among elastic links."""
    return ResultMapping({name: link for name, link in links.items() if isinstance(link, BeamModel)})


class Beams:
    """Corresponding beams of g equal limbs, see :class:`kinetostatics.elements.element.ElasticElement`."""

    kind = "beams"
    in_every_direction = has_line = has_inside = True
    attachments: frozenset[str] = frozenset()

    def __init__(
        self, models: Sequence[BeamModel], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> None:
        """Set the beams; arguments as of :class:`kinetostatics.elements.joint.ElasticJoints`."""
        self.models, self.edges, self.element = tuple(models), tuple(edges), element
        self.signs = NO_CUTS if signs is None else signs
        spans = [model.span for model in models]
        centres = [np.zeros(3) if model.centre is None else model.centre for model in models]
        self._axes = FixedVectors([[(model.span.carrier, model.axes)] for model in models], (3, 3))
        self._starts = FixedVectors([[(span.start_body, span.start)] for span in spans])
        self._ends = FixedVectors([[(span.end_body, span.end)] for span in spans])
        self._centres = FixedVectors([[(span.carrier, centre)] for span, centre in zip(spans, centres, strict=True)])
        self._centred = np.array([model.centre is not None for model in models])[:, None]
        self._compliances = np.array([model.compliances for model in models]).T[..., None]
        self._mass = np.array([model.mass for model in models])[:, None]
        per_length = [np.nan if model.mass_per_length is None else model.mass_per_length for model in models]
        self.profiles = [model.profile for model in models if model.profile is not None]
        responses = [np.hstack([profile.flexibility, profile.sag[:, :3]]) for profile in self.profiles]
        self.responses = np.stack(responses, axis=-1) if responses else np.zeros(0)  # of the end to a wrench and weight
        self._mass_per_length = np.array(per_length)[:, None]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(model.name for model in self.models)

    @property
    def signature(self) -> tuple[object, ...]:
        return self.kind, self.element, tuple(self.signs.tolist()), bool(self.profiles)

    def outboard(self, names: Sequence[str]) -> list[Array]:
        return [outboard_masks(self.edges, names)]

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedBeams:
        axes = self._axes.at(frames)[:, :, 0]
        start, end = self._starts.points(frames)[:, 0], self._ends.points(frames)[:, 0]
        lever = zeros_for(end.shape, end)
        if np.any(self._centred):
            lever = np.where(self._centred, self._centres.points(frames)[:, 0] - (start + end) / 2, lever)
        return PlacedBeams(self.signs, self.element, axes, end - o[:, None], self, dot(axes[:, 0], end - start), lever)

    def densities(self, lengths: Array) -> Array:
        """Return the masses per length (g, N) [kg/m] of beams of given lengths (g, N) [m]."""
        with np.errstate(divide="ignore", invalid="ignore"):  # the length of a telescopic beam may be zero
            return np.where(np.isnan(self._mass_per_length), self._mass / lengths, self._mass_per_length)

    def compliances(self, dimensions: int) -> Array:
        """Return the section compliances (6, …, g, 1) for arrays of a number of dimensions."""
        return self._compliances.reshape(6, *(1,) * (dimensions - 3), -1, 1)


@dataclass(frozen=True, eq=False)
class PlacedBeams(PlacedSection):
    """Corresponding beams at N poses.

    Attributes:
        length: (g, N) [m].
        lever: (3, g, N) vectors from the middles of the beams to their centres of mass [m].
    """

    beams: Beams
    length: Array
    lever: Array

    @property
    def line(self) -> tuple[Array, Array]:
        return self.axes[:, 0], self.arm

    def own_load(self, gravity: Array) -> Array:
        """Return the uniform loads μ [g; lever × g] (6, g, N) due to weight, in beam axes, with the mass μ per length.

        A mass whose centre is not the beam's middle is distributed along a parallel line; its weight also exerts a moment.
        """
        field = np.broadcast_to(gravity[:, None], self.lever.shape)
        load = np.concatenate([field, cross(self.lever, field)])
        return rotate(self.axes, load, back=True) * self.beams.densities(self.length)

    def displacements(self, forces: Array) -> Array:
        if self.beams.profiles:
            return np.einsum("ijg,j...gn->i...gn", self.beams.responses[:, :6], forces)
        return beam_formulas.end_displacement(self.beams.compliances(forces.ndim), self.length, forces)

    def own_displacement(self, load: Array) -> Array:
        if self.beams.profiles:
            return np.einsum("ijg,j...gn->i...gn", self.beams.responses[:, 6:], load[:3])
        return beam_formulas.sag(self.beams.compliances(load.ndim), self.length, load)

    def inside(self, carried: Array, load: Array) -> LoadedBeams:
        mass = np.stack([model.mass_of(self.length[m]) for m, model in enumerate(self.beams.models)])
        end, wrench = self.arm, self.forces(carried)
        none, c = np.zeros(wrench.shape), self.beams.compliances(3)
        profiles = tuple(self.beams.profiles)
        return LoadedBeams(self.beams.names, c, profiles, self.axes, self.length, mass, end, wrench, load, none, none[0], none[0])
