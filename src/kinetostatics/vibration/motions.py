"""Modes as motions of bodies and beams, with participation and energies, and the platform's response to harmonic forces.

With the complex stiffness s K, s = 1 + iη or 1 + iωβ, and the complex mass c M, c = 1 − iα/ω, the equation of motion of the robot
is s D(λ c/s) q = f: damping only makes λ complex. Forces act on the platform, or the floor moves. A piece of a beam is one of the
equal rods into which the beam is divided.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Real

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.elements.rods import Numbers
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.statics.small_motions import PlacedMotions
from kinetostatics.vibration.eigenpairs import Eigenpairs, independent_motions
from kinetostatics.vibration.vibration_model import Part, PlacedRod, VibrationModel


@dataclass(frozen=True)
class ModeShapes:
    """The lowest m modes of N poses, with the robot's motions per unit of each coordinate."""

    pairs: Eigenpairs
    motions: PlacedMotions

    def of_body(self, body: RigidBody, point: Array) -> Array:
        """Return displacement of a point (3, N) of a body, and rotation of the body: (N, m, 6), world axes [m, rad]."""
        return self.motions.of_body(self.pairs.shapes, body, point)

    def of_beam(self, name: str, stations: int) -> Array:
        """Return displacement and rotation (N, m, stations, 6) at equidistant stations of a beam's length, beam axes [m, rad]."""
        item, square = self.pairs.model.beams[name], self._finite
        forces = [(u, (item.piece.dynamic_stiffness(square) @ u[..., None])[..., 0]) for u in self._pieces(item, name)]
        found = np.empty((*square.shape, stations, 6))
        for k, place in enumerate(np.linspace(0, item.pieces, stations)):
            number = min(int(place), item.pieces - 1)
            u, f = forces[number]
            found[..., k, :] = item.piece.inside(u, f, square, place - number)
        return found

    @cached_property
    def participation(self) -> Array:
        """Momentum (N, m, 6) of the modes per angular frequency, about o, world axes [kg, kg·m]: ∫ φ dm, ∫ r × φ dm."""
        found = np.zeros((*self._finite.shape, 6))
        for part in self.pairs.model.masses.values():
            found += np.einsum("nij,nik,nmk->nmj", part.carried, part.matrix, self._local(part))
        for name, item in self.pairs.model.beams.items():
            D = item.piece.dynamic_stiffness(self._finite)
            for k, u in enumerate(self._pieces(item, name)):
                force = (D @ u[..., None])[..., 0] / -self._finite[..., None]
                found += np.einsum("nij,nmi->nmj", item.carried_piece(k), force)
        return found

    @cached_property
    def inertia(self) -> Array:
        """Mass matrix Σ Rᵀ M R (N, 6, 6) of all moving parts as one rigid body, about o [kg, kg·m, kg·m²]."""
        zero = np.zeros((len(self._finite), 1))
        found = np.zeros((len(zero), 6, 6))
        for part in self.pairs.model.masses.values():
            found += np.swapaxes(part.carried, 1, 2) @ part.matrix @ part.carried
        for item in self.pairs.model.beams.values():
            M = item.rod.pencil(zero)[1][:, 0]
            found += np.swapaxes(item.carried, 1, 2) @ M @ item.carried
        return found

    @cached_property
    def strain_energy(self) -> Mapping[str, Array]:
        """Shares (N, m) of the strain energy, by name of the beam, elastic joint, actuator or spring."""
        found = {name: _energy(self._local(part), part.matrix[:, None]) for name, part in self.pairs.model.springs.items()}
        for name, item in self.pairs.model.beams.items():
            K = item.piece.pencil(self._finite)[0]
            found[self._label(name)] = found.get(self._label(name), 0.0) + self._energy_of(name, K)
        return _shares(found)

    @cached_property
    def kinetic_energy(self) -> Mapping[str, Array]:
        """Shares (N, m) of the kinetic energy, by name of the beam, link or payload."""
        found = {name: _energy(self._local(part), part.matrix[:, None]) for name, part in self.pairs.model.masses.items()}
        for name, item in self.pairs.model.beams.items():
            found[self._label(name)] = self._energy_of(name, item.piece.pencil(self._finite)[1])
        return _shares(found)

    def _label(self, name: str) -> str:
        return f"beam {name}" if name in self.motions.structure.model.beams else f"flexible {name}"

    def _energy_of(self, name: str, matrix: Array) -> Array:
        """Return u · A u (N, m), summed over a beam's pieces, with the matrix A of a piece and the motions u of its ends."""
        parts = [_energy(u, matrix) for u in self._pieces(self.pairs.model.beams[name], name)]
        return np.sum(parts, axis=0)

    @property
    def _finite(self) -> Array:
        """λ (N, m), with 1 for missing modes."""
        return np.where(np.isfinite(self.pairs.square), self.pairs.square, 1.0)

    def _local(self, part: Part) -> Array:
        """Return the displacements (N, m, r) of a mass or spring in the modes."""
        return np.einsum("nrk,nmk->nmr", part.motions, self.pairs.shapes[..., list(part.columns)])

    def _pieces(self, item: PlacedRod, name: str) -> Iterator[Array]:
        """Yield displacements and rotations (N, m, 12) of the ends of every piece of a beam, beam axes [m, rad]."""
        model = self.pairs.model
        for columns, motions in item.moved(model.first_along[name], model.size):
            yield (motions[:, None] @ self.pairs.shapes[..., columns, None])[..., 0]


def _energy(u: Array, matrix: Array) -> Array:
    """Return u · A u (N, m) for displacements u (N, m, r) and a matrix A."""
    return np.asarray(np.einsum("nmr,nmr->nm", u, (matrix @ u[..., None])[..., 0]))


def _shares(energies: Mapping[str, Array]) -> dict[str, Array]:
    total = sum(energies.values(), np.zeros(()))
    with np.errstate(invalid="ignore", divide="ignore"):
        return {name: energy / total for name, energy in energies.items()}


#: Largest number of matrix entries, over poses and frequencies, that are solved at once.
_AT_ONCE = 4_000_000


@dataclass(frozen=True)
class Damping:
    """Damping: loss factor η, or proportional damping with factors α of the mass [1/s] and β of the stiffness [s]."""

    loss: float = 0.0
    mass: float = 0.0
    stiffness: float = 0.0

    @classmethod
    def of(cls, damping: object) -> Damping:
        """Return the damping of a damping ratio ζ of all modes, a loss factor 2ζ, or of ``{"mass": α, "stiffness": β}``."""
        values: Mapping[str, Keyword] = damping if isinstance(damping, Mapping) else {"ratio": damping}
        known = {"mass", "stiffness"} if isinstance(damping, Mapping) else {"ratio"}
        numbers = [value for value in values.values() if isinstance(value, Real) and not isinstance(value, bool)]
        if not set(values) <= known or len(numbers) < len(values) or not all(0 <= float(number) < np.inf for number in numbers):
            raise ArgumentError(
                f'damping is {damping!r}; it must be a damping ratio, such as 0.02, or {{"mass": α, "stiffness": β}} [1/s, s]'
            )
        ratio, mass, stiffness = (float(values.get(name, 0.0)) for name in ("ratio", "mass", "stiffness"))
        return cls(2 * ratio, mass, stiffness)

    def factors(self, omega: Array) -> tuple[Numbers, Numbers]:
        """Return the complex factors s = 1 + i (η + ω β) of the stiffness and c = 1 − i α/ω of the mass at ω [1/s]."""
        return 1 + 1j * (self.loss + omega * self.stiffness), 1 - 1j * self.mass / omega


def responses(model: VibrationModel, platform: Array, carried: Array, omega: Array, damping: Damping) -> tuple[Numbers, Numbers]:
    """Return compliance and transmissibility (N, F, 6, 6) at a point of the platform; NaN where a motion has negative stiffness.

    With damping, s K − ω² c M = s D(λ) at λ = ω² c/s: H = P D⁻¹ Pᵀ/s and T = R − P D⁻¹ f_floor/c.

    Args:
        model: the robot at N poses.
        platform: (N, 6, n) twist of the platform at the point per unit of each coordinate.
        carried: (N, 6, 6) twist of the platform at the point when the whole robot moves with the floor, per unit of the floor's
            translation and rotation about o.
        omega: (F,) angular frequencies [1/s].
        damping: damping of all parts.
    """
    n = model.coordinates
    compliance, transmissibility = np.full((2, model.poses, len(omega), 6, 6), complex(np.nan, np.nan))
    P = np.zeros((model.poses, 6, n))
    P[..., : platform.shape[2]] = platform
    for poses, basis in independent_motions(model):
        here, count = model.take(poses), max(1, _AT_ONCE // (n * n * len(poses) + 1))
        for first in range(0, len(omega), count):
            some = slice(first, first + count)
            s, c = damping.factors(np.broadcast_to(omega[some], (len(poses), len(omega[some]))))
            square = omega[some] ** 2 * c / s
            D, floor = here.dynamic_stiffness(square), here.forces_of_floor(square) / c[..., None, None]
            out = P[poses][:, None]
            if basis is not None:
                Z = basis[:, None]
                D, floor, out = np.swapaxes(Z, -1, -2) @ D @ Z, np.swapaxes(Z, -1, -2) @ floor, out @ Z
            forces = np.broadcast_to(np.swapaxes(out, -1, -2), (*D.shape[:2], D.shape[2], 6))
            moved = out @ np.linalg.solve(D, np.concatenate([forces, floor], axis=-1))
            compliance[poses, some] = moved[..., :6] / s[..., None, None]
            transmissibility[poses, some] = carried[poses][:, None] - moved[..., 6:]
    return compliance, transmissibility
