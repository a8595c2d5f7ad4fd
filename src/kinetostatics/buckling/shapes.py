"""Buckling modes as motions of bodies and beams, and changes of twist and stiffness due to geometric stiffness (P-Delta).

With the modes φ of (K + λ K_G) φ = 0, φ · K φ = 1, and μ = 1/λ, the inverse of K + K_G exceeds that of K by Σ μ/(1 − μ) φ φᵀ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.buckling.beam_elements import INNER, deflection
from kinetostatics.buckling.stability import Forces, Stability
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.rigid_bodies import RigidBody
from kinetostatics.statics.small_motions import PlacedMotions, signs_of_modes

#: Relative size of motions, and of components, below which they count as zero.
_MOVES = 1e-3
#: Ratio below which forces are rounding.
_NOTHING = 1e-12


@dataclass(frozen=True)
class BucklingModes:
    """The m buckling modes of each of N poses.

    Attributes:
        ratios: (N, m) ratios 1/λ of forces to critical forces; ascending, or descending from :meth:`first`.
        shapes: (N, m, n + b) modes in the coordinates of ``robot``.
        robot: stiffness and geometric stiffness at the poses.
    """

    ratios: Array
    shapes: Array
    robot: Stability

    @classmethod
    def of(cls, robot: Stability) -> BucklingModes:
        """Return all modes."""
        ratios, modes = robot.modes()
        return cls(ratios, np.swapaxes(modes, 1, 2), robot)

    @property
    def motions(self) -> PlacedMotions:
        """Coordinates of the small motions of rigid bodies."""
        return self.robot.motions

    def first(self, count: int) -> BucklingModes:
        """Return the ``count`` modes with the largest ratios, in descending order; NaN where there are fewer.

        The largest component of the platform's twist is positive; if the platform does not move, that of the coordinates is.
        """
        ratios, shapes = self.ratios[:, ::-1][:, :count], self.shapes[:, ::-1][:, :count]
        twists = BucklingModes(ratios, shapes, self.robot).of_body(self.motions.structure.platform, self.motions.o)
        shapes = shapes * signs_of_modes(shapes, twists, _MOVES)
        ratios = np.where(ratios < _NOTHING, 0.0, ratios)
        shapes = np.where(ratios[..., None] > 0, shapes, np.nan)
        missing = ((0, 0), (0, count - ratios.shape[1]))
        return BucklingModes(np.pad(ratios, missing), np.pad(shapes, (*missing, (0, 0)), constant_values=np.nan), self.robot)

    def of_body(self, body: RigidBody, point: Array) -> Array:
        """Return displacement of a point (3, N) of a body, and rotation of the body, world axes (N, m, 6) [m, rad]."""
        return self.motions.of_body(self.shapes, body, point)

    def of_beam(self, name: str, stations: int) -> Array:
        """Return displacement and rotation along a beam's centre line, beam axes (N, m, stations, 6) [m, rad]."""
        return self._line(name, np.linspace(0, 1, stations))

    def _line(self, name: str, fractions: Array) -> Array:
        """Return displacement and rotation at fractions (S,) of a beam's length, beam axes (N, m, S, 6) [m, rad]."""
        structure, item, energy = self.motions.structure, self.motions.structure.model.beams[name], self.robot.beams[name]
        frames, ends = self.motions.frames, next(beam for beam in structure.beams if beam.name == name)
        start, length = item.ends(frames)[0], item.length(frames)[:, None]
        twist = self.of_body(ends.inner, start).reshape(*self.shapes.shape[:2], 2, 3)
        first = np.einsum("ijn,nmki->kjnm", item.world_axes(frames), twist)
        u = np.einsum("ikn,nmk->inm", energy.motions, self.shapes[..., list(energy.columns)])
        inner = np.moveaxis(self.shapes[..., energy.inner], 2, 0)
        s = fractions[:, None, None]
        found = np.empty((6, len(fractions), *self.shapes.shape[:2]))
        found[0], found[3] = first[0, 0] + s * u[0], first[1, 0] + s * u[1] / length
        for k, EI in enumerate((1 / item.compliances[5], 1 / item.compliances[4])):
            values, slopes = deflection(fractions, u[2 + 3 * k : 5 + 3 * k], inner[INNER * k : INNER * (k + 1)], EI, length[:, 0])
            found[1 + k], found[5 - k] = first[0, 1 + k] + values, (1 - 2 * k) * slopes
        return found.transpose(2, 3, 1, 0)

    def energies(self) -> Mapping[str, Array]:
        """Return twice the strain energy (N, m) of every beam."""
        return {name: item.of(np.swapaxes(self.shapes, 1, 2)) for name, item in self.robot.beams.items()}

    def work(self, forces: Forces) -> Array:
        """Return the work (N, m) of loads and weights in the modes."""
        o, frames, model = self.motions.o, self.motions.frames, self.motions.structure.model
        bodies: dict[RigidBody, Array] = {}
        for body, wrench, _ in forces.others:
            bodies[body] = bodies.get(body, 0.0) + wrench
        found = sum((np.einsum("in,nmi->nm", wrench, self.of_body(body, o)) for body, wrench in bodies.items()), np.zeros(()))
        points, weights = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2
        for name, beam in model.beams.items():
            length, axes = beam.length(frames), beam.world_axes(frames)
            weight = beam.line_density(length) * forces.gravity
            first, last = np.split(
                forces.lines.get(name, 0.0) + np.tile([*weight, *cross(beam.lever(frames), weight)], (2, 1)), 2
            )
            load = first[:, None] + (last - first)[:, None] * points[:, None]  # (6, S, N)
            local = np.einsum("ijn,kisn->nskj", axes, load.reshape(2, 3, *load.shape[1:])).reshape(len(length), len(points), 6)
            found = found + np.einsum("s,n,nsi,nmsi->nm", weights, length, local, self._line(name, points))
        return found

    def second_order(self, forces: Forces) -> tuple[Array, Array, Array, Array]:
        """Return changes of the platform's twist (6, N) and compliance (6, 6, N) about o due to geometric stiffness.

        Also the relative changes (6, N) of the stiffness and the corresponding motions of the platform, the columns of (6, 6, N),
        with rotations multiplied by the robot's length; 0 where the platform is rigid. All are NaN at poses that buckle.
        """
        structure = self.motions.structure
        with np.errstate(divide="ignore"):
            gain = np.where(self.ratios < 1, self.ratios / (1 - self.ratios), np.nan)
        moved = self.of_body(structure.platform, self.motions.o)
        twist = np.einsum("nm,nm,nmi->in", gain, self.work(forces), moved)
        compliance = np.einsum("nm,nmi,nmj->ijn", gain, moved, moved)
        fine = np.all(np.isfinite(moved), axis=(1, 2)) & np.all(np.isfinite(gain), axis=1)
        moved, gain = np.where(fine[:, None, None], moved, 0.0), np.where(fine[:, None], gain, 0.0)
        scale = np.repeat([1.0, structure.model.length], 3)
        U, sizes, V = np.linalg.svd(np.swapaxes(moved * scale, 1, 2), full_matrices=False)
        V = V * (sizes > _MOVES * sizes[:, :1])[..., None]
        values, axes = np.linalg.eigh(np.einsum("nim,nm,njm->nij", V, gain, V))
        changes = np.where(fine, -values.T / (1 + values.T), np.nan)
        return twist, compliance, changes, (U * sizes[:, None] @ axes).transpose(1, 2, 0)
