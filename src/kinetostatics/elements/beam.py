"""Straight elastic beams in limbs. Their forces refer to the platform end, and their compliance is that of a cantilever."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements import beam_formulas
from kinetostatics.elements.element import NO_CUTS, Section, outboard_masks
from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.elements.vectors import FixedVectors
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross, dot
from kinetostatics.math.screws import rotate
from kinetostatics.mechanism.beam_model import BeamModel
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.tree import Frames


class Beams:
    """Corresponding beams of g equal limbs, see :class:`kinetostatics.elements.element.ElasticElement`."""

    kind = "beams"
    in_every_direction = has_line = True
    places: frozenset[str] = frozenset()

    def __init__(
        self, models: Sequence[BeamModel], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] = NO_CUTS
    ) -> None:
        """Set the beams.

        Args:
            models, edges: the beams, and their edges in the limbs.
            element: index of the element in the limb; irrelevant in open branches.
            signs: (M,) signs of the cut-joint wrenches that the beams transmit; none in open branches.
        """
        self.models, self.edges, self.element, self.signs = tuple(models), tuple(edges), element, signs
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
        self._mass_per_length = np.array(per_length)[:, None]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(model.name for model in self.models)

    @property
    def signature(self) -> tuple[object, ...]:
        return self.kind, self.element, tuple(self.signs.tolist())

    def outboard(self, names: Sequence[str]) -> list[Array]:
        return [outboard_masks(self.edges, names)]

    def masses(self, frames: Frames) -> tuple[Array, NDArray[np.int8]]:
        return np.stack([model.mass_at(frames) for model in self.models]), self.signs

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
class PlacedBeams(Section):
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
        """Return the uniform loads (6, g, N) due to weight, in beam axes.

        A mass whose centre is not the beam's middle is distributed along a parallel line; its weight also exerts a moment.
        """
        field = np.broadcast_to(gravity[:, None], self.lever.shape)
        load = np.concatenate([field, cross(self.lever, field)])
        return rotate(self.axes, load, back=True) * self.beams.densities(self.length)

    def displacements(self, forces: Array) -> Array:
        return beam_formulas.end_displacement(self.beams.compliances(forces.ndim), self.length, forces)

    def own_displacement(self, load: Array) -> Array:
        return beam_formulas.sag(self.beams.compliances(load.ndim), self.length, load)

    def inside(self, carried: Array, load: Array) -> LoadedBeams:
        return LoadedBeams.under(self.beams.models, self.beams.compliances(3), self.axes, self.length, self.arm, carried, load)
