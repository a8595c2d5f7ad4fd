"""Stiffness and mass along a beam whose section varies between stations, see :mod:`kinetostatics.sections.tapered`.

Wrenches and twists refer to the line between the beam's ends, the x axis; centroids may be beside it. A *load along the beam*
(12) is an acceleration a + x A_x + y A_y + z A_z of its points, with x from the start, times its mean mass per length: a, A_x,
A_y, A_z in beam axes; weight has a alone. Strains are ε = C w with the section wrench w and compliances C (6, 6). Functions are
given at the Gauss points of panels, which are halved until polynomials represent C.

*Shapes* are the unit displacements of the end without other loads, and *inner coordinates*, which leave the ends at rest and are
orthonormal in the strain energy. Their strains are C times polynomials between stations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from kinetostatics.description.elements import Beam
from kinetostatics.elements.beam_formulas import of_arm
from kinetostatics.elements.rods import Numbers, VibratingMatrices
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import Cholesky
from kinetostatics.math.rotations import skew
from kinetostatics.sections.kinds import beam_compliance_coefficients
from kinetostatics.sections.tapered import Station, Tapered

_Legendre = np.polynomial.legendre
#: Gauss points and weights of a panel −1 … 1; matrices from values there to Legendre coefficients, and to integrals from −1.
_COUNT = 20
_POINTS, _WEIGHTS = _Legendre.leggauss(_COUNT)
_TO_MODES = np.linalg.inv(_Legendre.legvander(_POINTS, _COUNT - 1))
_INTEGRALS = _Legendre.legvander(_POINTS, _COUNT) @ _Legendre.legint(_TO_MODES, lbnd=-1)
#: Last Legendre coefficients of C, relative to the largest, at which a panel is fine enough; and the finest panel.
_RESOLVED, _FINEST = 1e-11, 1 / 256
#: Degree of the strains' polynomials between stations: the first ten frequencies of tapered cantilevers change by less than 1e-8.
_DEGREE = 10
#: Modes with clamped ends are coordinates of vibrations up to this ratio to the lowest λ.
_KEPT = 100.0
_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Profile:
    """A beam at Q Gauss points.

    Attributes:
        length: [m].
        stations, edges: fractions of the length: of stations, and of the edges of panels.
        compliances: (Q, 6, 6) section compliances C.
        loads: (Q, 6, 12) force and moment per length due to a load along the beam.
    """

    #: Compiled code has no inside of beams with stations.
    NOT_RECORDED: ClassVar = ("length", "stations", "edges", "compliances", "loads")

    length: float
    stations: Array
    edges: Array
    compliances: Array
    loads: Array

    @property
    def nodes(self) -> Array:
        """Fractions (Q,) of the length."""
        return (self.edges[:-1, None] + np.diff(self.edges)[:, None] * (_POINTS + 1) / 2).ravel()

    @property
    def weights(self) -> Array:
        """Weights (Q,) of integrals over the length [m]."""
        return np.outer(np.diff(self.edges) * self.length / 2, _WEIGHTS).ravel()

    def at(self, values: Array, fractions: Array) -> Array:
        """Return continuous functions (n, …) at fractions (n,) of the length, given their values (Q, …)."""
        panel = np.clip(np.searchsorted(self.edges, fractions, side="right") - 1, 0, len(self.edges) - 2)
        local = 2 * (fractions - self.edges[panel]) / np.diff(self.edges)[panel] - 1
        modes = _TO_MODES @ values.reshape(len(self.edges) - 1, _COUNT, -1)
        result = np.einsum("ni,nik->nk", _Legendre.legvander(local, _COUNT - 1), modes[panel])
        return result.reshape(-1, *values.shape[1:])

    def _integral(self, values: Array) -> tuple[Array, Array]:
        """Return the integrals (Q, …) of values (Q, …) from the start, and (…) to the end."""
        parts, sizes = values.reshape(len(self.edges) - 1, _COUNT, -1), np.diff(self.edges)[:, None] * self.length / 2
        whole = sizes * np.einsum("q,pqk->pk", _WEIGHTS, parts)
        inside = (np.tri(len(whole), k=-1) @ whole)[:, None] + sizes[:, None] * (_INTEGRALS @ parts)
        return inside.reshape(values.shape), whole.sum(axis=0).reshape(values.shape[1:])

    def _motions(self, strains: Array) -> tuple[Array, Array]:
        """Return the motions (Q, 6, k), and (6, k) of the end, due to strains (Q, 6, k), with the start at rest."""
        turns, turned = self._integral(strains[:, 3:])
        shifts, shifted = self._integral(strains[:, :3] - skew(_X) @ turns)  # u′ = γ + θ × e_x
        return np.concatenate([shifts, turns], axis=1), np.concatenate([shifted, turned])

    # ---- statics

    @cached_property
    def _static(self) -> tuple[Array, Array, Array, Array]:
        """Section wrenches and motions (Q, 6, 18), motions of the end and resultant about the start (6, 18).

        They are per unit of a wrench at the end, then of a load along the beam.
        """
        s = (self.length * self.nodes)[:, None, None]
        (load, whole), (first, firsts) = self._integral(self.loads), self._integral(s * self.loads[:, :3])
        carried, resultant = whole - load, whole.copy()
        carried[:, 3:] += skew(_X) @ (firsts - first - s * carried[:, :3])
        resultant[3:] += skew(_X) @ firsts
        wrenches = np.concatenate([np.swapaxes(_moved(s - self.length), 1, 2), carried], axis=2)
        return wrenches, *self._motions(self.compliances @ wrenches), resultant

    @property
    def flexibility(self) -> Array:
        """Motion (6, 6) of the end per unit of a wrench there, with the start clamped."""
        return self._static[2][:, :6]

    @property
    def sag(self) -> Array:
        """Motion (6, 12) of the end per unit of a load along the beam, with the start clamped."""
        return self._static[2][:, 6:]

    @property
    def clamped_resultants(self) -> tuple[Array, Array]:
        """Resultant (6, 12) of a load along the beam about the start, and its part at the end if both ends are clamped."""
        return self._static[3], Cholesky(self.flexibility).solve(self.sag)

    @cached_property
    def responses(self) -> tuple[Array, Array]:
        """Section wrenches and motions (Q, 6, 21) per unit of a wrench at the end (6), of a weight per length (3) with the end
        free, and of a load along the beam (12) with both ends clamped.
        """
        last = self.clamped_resultants[1]
        wrenches, motions, _, _ = self._static
        w, u = (np.concatenate([a[:, :, :9], a[:, :, 6:] - a[:, :, :6] @ last], axis=2) for a in (wrenches, motions))
        return w, u

    def strain_energy(self, sections: Array) -> Array:
        """Return the strain energy (…) [J] of section wrenches (6, Q, …) at the nodes."""
        strains = np.einsum("q,qij,jq...->iq...", self.weights, self.compliances, sections)
        return np.sum(sections * strains, axis=(0, 1)) / 2

    # ---- mass

    def _mass(self, motions: Array) -> Array:
        """Return the mass matrix (k, k) of motions (Q, 6, k), divided by the mean mass per length."""
        turned = (self.loads[:, :, 3 * k + 3 : 3 * k + 6] @ -skew(np.eye(3)[k]) for k in (1, 2))  # A_y = α × e_y
        masses = np.concatenate([self.loads[:, :, :3], sum(turned)], axis=2)
        return np.einsum("q,qia,qij,qjb->ab", self.weights, motions, masses, motions, optimize=True)

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) from the start, in beam axes [m]."""
        return self._static[3][[5, 3, 4], [1, 2, 0]] / self.length

    @property
    def gyration(self) -> Array:
        """Moments of inertia (3, 3) about the centre of mass, divided by the mass [m²]."""
        arm, rigid = skew(self.centre), _moved(-self.length * self.nodes[:, None, None])
        return self._mass(rigid)[3:, 3:] / self.length + arm @ arm

    # ---- shapes

    @cached_property
    def shapes(self) -> tuple[Array, Array]:
        """Strains and motions (Q, 6, 6 + b) of the shapes."""
        pieces = []
        for a, b in pairwise(self.stations):
            local = (2 * self.nodes - a - b) / (b - a)
            pieces.append(np.where(np.abs(local) < 1, _Legendre.legvander(np.clip(local, -1, 1), _DEGREE).T, 0.0))
        forces = np.einsum("ij,kq->qijk", np.eye(6), np.concatenate(pieces)).reshape(len(self.nodes), 6, -1)
        strains = self.compliances @ forces
        stiffness = np.einsum("q,qia,qib->ab", self.weights, forces, strains, optimize=True)
        sizes = np.sqrt(np.maximum(stiffness.diagonal(), 1e-300))
        values, axes = np.linalg.eigh(stiffness / np.outer(sizes, sizes))
        soft = values > 1e-12  # not without shear deformation
        strains = strains @ (axes[:, soft] / np.sqrt(values[soft]) / sizes[:, None])
        inner = strains @ np.linalg.qr(self._motions(strains)[1].T, mode="complete")[0][:, 6:]
        unit = self.compliances @ self._static[0][:, :, :6] @ np.linalg.inv(self.flexibility)
        strains = np.concatenate([unit, inner], axis=2)
        return strains, self._motions(strains)[0]

    @property
    def count(self) -> int:
        """Number of inner coordinates."""
        return self.shapes[0].shape[2] - 6

    def turned_forces(self, length: Array, sections: Array, load: Array, lever: Array | None) -> Array:
        """Return what :meth:`.UniformInside.turned_forces` returns; ``load`` is the mean weight per length."""
        (strains, motions), zero = self.shapes, np.zeros((len(self.nodes), 3, 3))
        turns = np.concatenate([zero + np.eye(3), motions[:, 3:]], axis=2)
        stretches, bends = (np.concatenate([zero, part], axis=2) for part in np.split(strains, 2, axis=1))
        eccentric = self.loads[:, [3, 3, 4], [0, 2, 0]]  # arms of the weight
        arms = [
            of_arm(w, _X[:, None]) + of_arm(load, r[:, None])
            for w, r in zip(np.moveaxis(sections[:3], 1, 0), eccentric, strict=True)
        ]
        terms = ((skew(sections[:3]), stretches), (skew(sections[3:]) / 2, bends), (np.stack(arms, axis=2) / 2, turns))
        half = sum(np.einsum("q,qia,ijqn,qjb->abn", self.weights, turns, term, other, optimize=True) for term, other in terms)
        return np.asarray(half + np.swapaxes(half, 0, 1))

    def inner_deflections(self, length: Array, sections: Array) -> Array:
        return np.einsum("q,qib,iq...->b...", self.weights, self.shapes[0][:, :, 6:], sections)

    def inner_lines(self, length: Array, fractions: Array, inner: Array) -> Array:
        return np.einsum("sib,b...->is...", self.at(self.shapes[1][:, :, 6:], fractions), inner)

    def vibrating(self, density: float) -> VibratingProfile:
        """Return the beam in vibrations, with its mean mass per length [kg/m]."""
        closed = np.hstack([-_moved(np.full((1, 1, 1), -self.length))[0], np.eye(6)])  # of the end relative to the start
        moved = self.shapes[1][:, :, :6] @ closed
        moved[:, :, :6] += _moved(-self.length * self.nodes[:, None, None])
        values, axes = np.linalg.eigh(self._mass(self.shapes[1][:, :, 6:]))  # μ/λ with the mean mass per length μ
        modes = self.shapes[1][:, :, 6:] @ axes if density else moved[:, :, :0]
        inner = int(np.sum(_KEPT * values >= values[-1])) if density else 0
        moved = np.concatenate([moved, modes[:, :, ::-1]], axis=2)
        K = np.eye(12 + inner)
        K[:12, :12] = closed.T @ np.linalg.inv(self.flexibility) @ closed
        M = density * self._mass(moved)
        return VibratingProfile(
            K, M[: 12 + inner, : 12 + inner], inner, self, moved, M[: 12 + inner, 12 + inner :], M.diagonal()[12 + inner :]
        )


@dataclass(frozen=True, eq=False)
class VibratingProfile(VibratingMatrices):
    """A beam with stations in vibrations. The lowest b modes with clamped ends are coordinates; the others are eliminated.

    Attributes:
        moved: (Q, 6, 12 + b + k) motions per unit of each coordinate, and of the eliminated modes, whose stiffness is 1.
        coupling: (12 + b, k) mass matrix of coordinates and eliminated modes.
        inverse: (k,) 1/λ of the eliminated modes [s²].
    """

    profile: Profile
    moved: Array
    coupling: Array
    inverse: Array

    def _mass(self, factors: Numbers) -> Numbers:
        return np.asarray(self.mass + (self.coupling * factors[..., None, :]) @ self.coupling.T)

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        x = square[..., None]
        return np.asarray(self.stiffness - x[..., None] * self._mass(x / (1 - x * self.inverse)))

    def pencil(self, square: Array) -> tuple[Array, Array]:
        x = square[..., None]
        M = self._mass(x * (2 - x * self.inverse) / (1 - x * self.inverse) ** 2)
        return self.dynamic_stiffness(square) + x[..., None] * M, M

    def clamped_modes(self, square: Array) -> Index:
        return np.sum(square[..., None] * self.inverse > 1, axis=-1)

    def inside(self, ends: Array, forces: Array, square: Array, fraction: float) -> Array:
        x = square[..., None]
        motions = np.concatenate([ends, x / (1 - x * self.inverse) * (ends @ self.coupling)], axis=-1)
        return np.asarray(motions @ self.profile.at(self.moved, np.array([fraction]))[0].T)


def _moved(x: Array) -> Array:
    """Return the matrices (Q, 6, 6) of twists moved by −x e_x, x (Q, 1, 1); transposed, of wrenches moved by x e_x."""
    return np.eye(6) + x * np.pad(skew(_X), [(0, 3), (3, 0)])


def profile_of(beam: Beam, section: Tapered, length: float) -> Profile:
    """Return the profile of a beam with stations and a length [m]."""

    def panels(a: float, b: float) -> list[tuple[float, Array, Array]]:
        sections = [section.at(a + (b - a) * float(point + 1) / 2)[0] for point in _POINTS]
        C, loads = (np.array(part) for part in zip(*(_at(beam, item, section.area) for item in sections), strict=True))
        modes = np.abs(np.tensordot(_TO_MODES, C, 1))
        if np.all(modes[-2:] <= _RESOLVED * modes.max(axis=0)) or b - a < _FINEST:
            return [(b, C, loads)]
        return panels(a, (a + b) / 2) + panels((a + b) / 2, b)

    stations = np.unique(section.places)
    ends, C, loads = zip(*(panel for a, b in pairwise(stations.tolist()) for panel in panels(a, b)), strict=True)
    profile = Profile(length, stations, np.array([0.0, *ends]), np.concatenate(C), np.concatenate(loads))
    profile.loads[:, :, 3:6] = (length * profile.nodes)[:, None, None] * profile.loads[:, :, :3]
    return profile


def _at(beam: Beam, station: Station, mean_area: float) -> tuple[Array, Array]:
    """Return compliances (6, 6) and loads (6, 12) of a section, without A_x."""
    section, (_, y, z) = station.section, (centroid := np.array([0.0, *station.offset]))
    c = beam_compliance_coefficients(section, beam.youngs_modulus, beam.shear_modulus, beam.shear_areas_of(section))
    about, load = np.eye(6), np.zeros((6, 12))
    about[3:, :3] = -skew(centroid)
    second = section.area * np.outer(centroid, centroid) + np.diag([0.0, section.I_z, section.I_y])
    for k, size, arm in ((0, 1.0, section.area * centroid), (2, y, second[1]), (3, z, second[2])):
        load[:3, 3 * k : 3 * k + 3], load[3:, 3 * k : 3 * k + 3] = size * section.area * np.eye(3), skew(arm)
    return about.T @ (c[:, None] * about), load / mean_area
