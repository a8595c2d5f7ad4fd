"""Beams under load: lines of deflection, section wrenches, and twists of their ends due to their own deformation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.elements import beam_formulas
from kinetostatics.elements.beam_formulas import clamped_line, clamped_section_wrench
from kinetostatics.elements.profile import Profile
from kinetostatics.exceptions import StaticsError
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move_twist, rotate


@dataclass(frozen=True)
class LoadedBeams:
    """One beam in each of g equal limbs, with its loads for each of S contributions; wrenches and loads are in beam axes.

    Attributes:
        names: names of the beams.
        compliances: (6, g, 1) section compliances.
        profiles: (g,) profiles of beams with stations; else empty.
        axes: (3, 3, g, N) beam axes in the world.
        length: (g, N) [m].
        mass: (g, N) [kg].
        end: (3, g, N) arm from o to the platform end [m].
        wrench: (6, S, g, N) wrench on the platform end, about this end [N, N·m].
        load: (6, S, g, N) own weight, force and moment per length [N/m, N].
        inner: (6, S, g, N) motion of the base end as a rigid body, about o, world axes [m, rad].
        stretch: (S, g, N) excess length by assembly errors or temperature [m].
        axial_correction: (S, g, N) force that :meth:`axial_force` adds [N]. After
            :func:`kinetostatics.statics.solution.by_mechanism` the forces and the strains due to a limb's weight belong to two
            contributions; ``wrench`` has the axial force due to the weight in the contribution of the strains, and the correction
            moves it to the contribution of the forces. Else the correction is 0.
        line: (12, S, g, N) linearly varying load, force and moment per length at the base end, then force and moment per length
            at the platform end [N/m, N]; None: zero. ``wrench`` contains its resultant at the platform end, see
            :meth:`kinetostatics.elements.beam.BeamModel.line_resultants`.
        is_turned: whether base end and platform end are exchanged.
    """

    names: tuple[str, ...]
    compliances: Array
    profiles: tuple[Profile, ...]
    axes: Array
    length: Array
    mass: Array
    end: Array
    wrench: Array
    load: Array
    inner: Array
    stretch: Array
    axial_correction: Array
    line: Array | None = None
    is_turned: bool = False

    def axial_force(self) -> Array:
        """Return the axial force (S, g, N) [N] at the platform end, tension positive."""
        return np.asanyarray(self.sections(np.ones(1))[0, 0] + self.axial_correction)

    def strain_energy(self) -> Array:
        """Return the strain energy (S, g, N) [J]."""
        if self.profiles:
            return np.stack([p.strain_energy(self.sections(p.nodes)[:, :, :, g]) for g, p in enumerate(self.profiles)], axis=1)
        return beam_formulas.strain_energy(self.compliances[:, None], self.length, self.sections)

    def turned(self, outer: Array) -> LoadedBeams:
        """Return the beams with base end and platform end exchanged.

        ``outer`` (6, S, g, N) is the rigid-body motion of the new base ends.
        """
        if self.profiles:
            reason = "paths from base to platform pass it both ways"
            raise StaticsError(f"what is inside the beam {self.names[0]!r} with stations is unknown: {reason}")
        back = np.array([-1.0, 1.0, -1.0]).reshape(3, 1, 1)
        start = beam_formulas.section_wrench(self.length, self.wrench, self.load, np.zeros_like(self.length))
        signs = np.tile(back, (2, 1, 1))[:, None]
        return replace(
            self,
            axes=self.axes * back[None],
            end=self.end - self.axes[:, 0] * self.length,
            wrench=-start * signs,
            load=self.load * signs,
            inner=outer,
            is_turned=True,
        )

    def sections(self, fractions: Array) -> Array:
        """Return the section wrenches (6, n, S, g, N) at n given fractions of the length from the base end, beam axes."""
        if self.profiles:
            return self._responses(0, fractions)
        s = fractions[:, None, None, None] * self.length
        found = beam_formulas.section_wrench(self.length, self.wrench[:, None], self.load[:, None], s)
        if self.line is not None:
            found = found + clamped_section_wrench(self.compliances[:, None, None], self.length, self.line[:, None], s)
        return found

    def _responses(self, which: int, fractions: Array) -> Array:
        """Return the section wrenches (0) or the bent lines (1) (6, n, S, g, N) of beams with stations, beam axes."""
        loads = np.concatenate([self.wrench, self.load[:3], *(() if self.line is None else (self.line,))])
        every = [profile.at(profile.responses[which], fractions)[:, :, : len(loads)] for profile in self.profiles]
        return np.einsum("gqij,jsgn->iqsgn", np.array(every), loads)

    def with_lines(self, loads: Sequence[tuple[int, Mapping[str, Array]]]) -> LoadedBeams:
        """Return the beams with linearly varying loads.

        ``loads`` has the index of a contribution, and by beam its loads (12, N), see ``lines`` of
        :class:`kinetostatics.statics.link_loads.AppliedLoad`.
        """
        found = np.zeros((12, *self.wrench.shape[1:]))
        for contribution, lines in loads:
            for g, name in enumerate(self.names):
                if name in lines:
                    line = np.roll(lines[name], 6, axis=0) if self.is_turned else lines[name]
                    parts = [np.einsum("ijn,in->jn", self.axes[:, :, g], part) for part in np.split(line, 4)]
                    found[:, contribution, g] = np.concatenate(parts)
        return replace(self, line=found) if np.any(found) else self

    def lines(self, fractions: Array) -> Array:
        """Return displacement and rotation (6, n, S, g, N) at n given fractions of the length, world axes [m, rad]."""
        s = fractions[:, None, None, None] * self.length
        c = self.compliances[:, None, None]
        if self.profiles:
            local = self._responses(1, fractions)
        else:
            local = beam_formulas.bent_line(c, self.length, self.wrench[:, None], self.load[:, None], s)
        arm = self.end[:, None, None] - self.axes[:, 0, None, None] * (self.length - s)
        if self.line is not None and not self.profiles:
            local = local + clamped_line(c, self.length, self.line[:, None], s)
        moved = rotate(self.axes, local) + move_twist(self.inner[:, None], arm)
        moved[:3] += self.axes[:, 0, None, None] * (fractions[:, None, None, None] * self.stretch)
        return moved
