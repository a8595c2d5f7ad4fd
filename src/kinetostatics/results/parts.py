"""Results of single parts: wrenches, compliance and sag of limbs; section wrenches, deflections and stresses of beams.

Internal arrays contain g equal limbs, or g beams, at N poses. A station is a section of a beam.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.description.elements import Beam
from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.linalg import Cholesky
from kinetostatics.results.pose_arrays import Batch, PoseArrays
from kinetostatics.robot import Robot
from kinetostatics.statics.deformation import Deformation
from kinetostatics.statics.joint_wrenches import limb_wrench
from kinetostatics.statics.link_loads import with_contributions
from kinetostatics.statics.solution import Solution


class LimbResult(Reported):
    """Wrenches, compliance and sag of one limb. The platform exerts the wrenches on the limb; they are about o, world axes.

    In a network (a limb with rings or several joints to the platform), intensities are coordinates of the limb's wrench in a
    basis; :attr:`Result.beams` and :attr:`Result.joint_wrenches` give the forces in its beams and joints.

    Attributes:
        name: name of the limb.
        labels: description of each constraint wrench.
        attached_labels: description of each attached wrench.
        is_network: whether the limb is more than a single chain from base to platform.
        beams: names of the beams between base and platform, inboard ones first.
        platform_joints: names of the joints between limb and platform.
    """

    def __init__(self, arrays: PoseArrays, group: LimbGroup, position: int, rows: tuple[slice, slice]) -> None:
        limb = group.limbs[position]
        self.name: str = limb.name
        self.is_network: bool = not limb.is_serial
        self.beams = tuple(edge.span for edge in limb.edges if edge.span and edge.span in group.model.description.beams)
        self.platform_joints = tuple(edge.joint for edge in limb.platform_edges if edge.joint is not None)
        self.labels: tuple[str, ...] = group.labels[position]
        self.attached_labels: tuple[str, ...] = group.attached_labels[position]
        self._batch, self._arrays, self._rows = arrays._batch, arrays, rows

    def _canonical(self, pick: Callable[[Solution, int], Array], *size: int) -> Array:
        return self._batch.public([self._where_canonical(s, pick, size) for s in self._arrays.solutions])

    def _by_contribution(self, pick: Callable[[Solution, int], Array], size: int) -> Mapping[str, Array]:
        contribution_names = self._arrays.contribution_names
        parts = [self._where_canonical(s, pick, (size, len(contribution_names))) for s in self._arrays.solutions]
        return self._batch.by_contribution(contribution_names, parts)

    def _where_canonical(self, solution: Solution, pick: Callable[[Solution, int], Array], size: tuple[int, ...]) -> Array:
        """(*size, N) quantity in the limb's wrench basis, NaN at poses where the labels do not describe this basis."""
        number, position = solution.places[self.name]
        statics = solution.statics[number]
        if statics.group.at_one_pose:
            return np.full((*size, solution.o.shape[1]), np.nan)
        return np.where(statics.degenerate[position], np.nan, pick(solution, number)[..., position, :])

    @cached_property
    def constraint_wrenches(self) -> Array:
        """(…, 6, n_c) J_ic, Eq. (2), unit wrenches [1, m]."""
        return self._canonical(lambda s, k: s.statics[k].J_c, 6, len(self.labels))

    @cached_property
    def attached_wrenches(self) -> Array:
        """(…, 6, n_g) J_ig, Eq. (4), unit wrenches [1, m]."""
        return self._canonical(lambda s, k: s.statics[k].J_g, 6, len(self.attached_labels))

    @cached_property
    def attached_intensities(self) -> Array:
        """(…, n_g) W_ig due to the limb's own weight and the loads on the limb's links, Eq. (3) [N or N·m]."""
        return self._batch.public(self._arrays._of_chunks(lambda chunk: chunk["attached_intensities"][self._rows[1]]))

    @cached_property
    def attached_contributions(self) -> Mapping[str, Array]:
        """(…, n_g) W_ig due to each contribution: the limb's own weight, and each load on the limb's links."""
        return self._by_contribution(_attached_intensities, len(self.attached_labels))

    @cached_property
    def compliance(self) -> Array:
        """(…, n_c, n_c) C_ic, Eq. (1), displacement along one wrench per intensity of another [m/N, rad/(N·m)]."""
        return self._canonical(lambda s, k: s.statics[k].C, len(self.labels), len(self.labels))

    @cached_property
    def stiffness(self) -> Array:
        """(…, n_c, n_c) K_ic = C_ic⁻¹, Eq. (1) [N/m, N·m/rad]; NaN if the limb is rigid along a constraint wrench."""
        return self._canonical(lambda s, k: _stiffness(s.statics[k]), len(self.labels), len(self.labels))

    @cached_property
    def sag(self) -> Array:
        """(…, n_c) Δ_igc, displacement along each constraint wrench due to weight and loads [m, rad], Eqs. (16), (19), (21)."""
        return self._canonical(lambda s, k: s.statics[k].gravity_displacement, len(self.labels))

    @cached_property
    def intensities(self) -> Array:
        """(…, n_c) W_ic, Eq. (11) [N or N·m]."""
        return self._batch.public(self._arrays._of_chunks(lambda chunk: chunk["intensities"][self._rows[0]]))

    @cached_property
    def contributions(self) -> Mapping[str, Array]:
        """(…, n_c) part of the intensities W_ic due to each contribution to the twist."""
        return self._by_contribution(_intensities, len(self.labels))

    @cached_property
    def wrench(self) -> Array:
        """(…, 6) total wrench J_ic W_ic + J_ig W_ig [N, N·m]."""
        return self._batch.public([_limb_wrench(s, *s.places[self.name]) for s in self._arrays.solutions])


def _stiffness(statics: LimbStatics) -> Array:
    """(n_c, n_c, g, N) stiffness K_ic of each limb; NaN if the limbs are rigid along a constraint wrench."""
    C = statics.C
    if statics.group.rigid_directions:
        return np.full_like(C, np.nan)
    return Cholesky(C).solve(np.broadcast_to(np.eye(C.shape[0])[:, :, None, None], C.shape))


def _intensities(solution: Solution, number: int) -> Array:
    """(n_c, S, g, N) intensities W_ic due to each of S contributions; NaN where they are indeterminate."""
    return np.where(solution.undetermined[number][:, None], np.nan, solution.intensities[number])


def _attached_intensities(solution: Solution, number: int) -> Array:
    """(n_g, S, g, N) attached intensities W_ig due to each of S contributions."""
    statics = solution.statics_of_weights(number)
    total = statics.W_g[:, None] * solution.contribution_mask(statics.group)
    parts = [applied.statics[number] for applied in solution.applied]
    return with_contributions(total, solution.applied, [None if part is None else part.W_g for part in parts])


def _limb_wrench(solution: Solution, number: int, position: int) -> Array:
    """(6, N) wrench of the platform on a limb about o; NaN where it is indeterminate."""
    unknown = np.any(solution.undetermined[number][:, position], axis=0)
    return np.where(unknown, np.nan, limb_wrench(solution, number, position))


def wrench_units(labels: Sequence[str], wrenches: Array) -> list[str]:
    """Return the unit of each intensity: N·m for a couple (by its label, or a wrench without force), N otherwise."""
    units = []
    for k, label in enumerate(labels):
        forces = np.abs(wrenches[..., :3, k])
        finite = forces[np.isfinite(forces)]
        couple = label.startswith("couple") or (finite.size > 0 and bool(np.all(finite < 1e-12)))
        units.append("N·m" if couple else "N")
    return units


def paper_forces(limbs: Mapping[str, LimbResult], beams: Mapping[str, BeamResult]) -> Mapping[str, Mapping[str, Array]]:
    """Return :attr:`Result.paper_forces`."""
    by_limb = {}
    for number, (name, limb) in enumerate(limbs.items(), 1):
        if limb.is_network:
            continue
        forces = {f"f_{number}{k + 1}": limb.intensities[..., k] for k in range(limb.intensities.shape[-1])}
        if limb.beams:
            forces[f"f_{number}a"] = beams[limb.beams[0]].section_wrenches[..., 0, 0]
        by_limb[name] = ResultMapping(forces)
    return ResultMapping(by_limb)


#: Number of stations of a beam, ends included, and their positions relative to its length.
STATIONS = 21
FRACTIONS = frozen(np.linspace(0, 1, STATIONS))


@dataclass(frozen=True, eq=False)
class _EulerRatios:
    """The ratios of all beams, computed when the first of them is asked for."""

    robot: Robot
    batch: Batch
    solutions: tuple[Solution, ...]

    @cached_property
    def of_beams(self) -> Mapping[str, Array]:
        chunks = [self.robot.members.ratios(solution) for solution in self.solutions]
        return {name: self.batch.public([chunk[name] for chunk in chunks]) for name in self.robot.description.beams}


@dataclass(frozen=True, eq=False, repr=False)
class BeamResult(Reported):
    """Results of one beam at n stations from its base end to its platform end.

    Attributes:
        name: name of the beam.
        description: the beam's data in the file.
        stations: (n,) relative positions of the stations, from 0 at the base end to 1 at the platform end.
        length: (…) length [m].
        mass: (…) mass [kg].
        axes: (…, 3, 3) beam axes x (along), y, z as columns, world axes.
        points: (…, n, 3) the undeformed centre line [m].
        section_wrenches: (…, n, 6) N, V_y, V_z, T, M_y, M_z in beam axes, exerted by the outer part on the inner one [N, N·m].
        deflections: (…, n, 3) displacement of the centre line, world axes [m].
        rotations: (…, n, 3) rotation of the sections, world axes [rad].
        stress: (…) largest von Mises stress of the stations, from all six section forces [Pa]; NaN for ``<section>``, whose
            outline is unknown. Stress concentrations at inner corners of rectangular tubes are ignored.
        member: names of the beams of the beam's member, from its base end to its platform end, see :attr:`euler_ratio`.
        strain_energy: (…) strain energy [J].
    """

    name: str
    description: Beam
    stations: Array
    length: Array
    mass: Array
    axes: Array
    points: Array
    section_wrenches: Array
    deflections: Array
    rotations: Array
    stress: Array
    _euler_ratio: _EulerRatios
    strain_energy: Array
    member: tuple[str, ...]

    @cached_property
    def euler_ratio(self) -> Array:
        """(…) ratio of the forces to the critical forces of the buckling modes in which the beam takes part.

        1 and above means buckling. For a strut between two hinges the ratio is N/N_Euler; see :mod:`kinetostatics.buckling`.
        Collinear beams that are welded or telescopic form one member with one ratio.
        """
        return self._euler_ratio.of_beams[self.name]

    @property
    def deflection(self) -> Array:
        """(…) largest displacement of the centre line [m]."""
        return np.asarray(np.sqrt((self.deflections**2).sum(axis=-1)).max(axis=-1))


def beam_results(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, BeamResult]:
    beams: dict[str, BeamResult] = {}
    ratios = _EulerRatios(robot, batch, tuple(solutions))
    members = {beam: member for member in robot.members.names for beam in member}
    at = np.union1d(FRACTIONS, [place for beam in robot.beams.values() for place in beam.section.places])
    pairs = zip(deformations, solutions, strict=True)
    numbers = [[_beam_arrays(stack, solution, at) for stack in d.beams] for d, solution in pairs]
    for name, beam in robot.description.beams.items():
        places, section = [d.places[name] for d in deformations], robot.beams[name].section
        pieces = [(stacks[k], position) for stacks, (k, position) in zip(numbers, places, strict=True)]
        chunk_arrays = {key: [stack[key][..., position, :] for stack, position in pieces] for key in pieces[0][0]}
        wrenches = [np.swapaxes(w, 0, 1) for w in chunk_arrays["section_wrenches"]]
        chunk_arrays["stress"] = [
            section.stress_along(w, at, beam.poisson_ratio).max(axis=0)
            if section.places
            else section.largest_stress(w, beam.poisson_ratio)
            for w in wrenches
        ]
        chunk_arrays["section_wrenches"] = [w[np.isin(at, FRACTIONS)] for w in chunk_arrays["section_wrenches"]]
        arrays = {key: batch.public(chunks) for key, chunks in chunk_arrays.items()}
        beams[name] = BeamResult(name, beam, FRACTIONS, **arrays, _euler_ratio=ratios, member=members[name])
    return ResultMapping(beams)


def _centre_lines(beams: LoadedBeams, solution: Solution) -> Array:
    """(n, 3, g, N) stations on the undeformed centre lines, world axes [m]."""
    start = solution.o[:, None] + beams.end - beams.axes[:, 0] * beams.length
    return np.swapaxes(start[:, None] + beams.axes[:, :1] * (FRACTIONS[:, None, None] * beams.length), 0, 1)


def centre_lines(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, tuple[Array, Array]]:
    """Return ``axes`` and ``points`` of the :class:`BeamResult` of each beam."""
    stacks = [[(stack.axes, _centre_lines(stack, s)) for stack in d.beams] for d, s in zip(deformations, solutions, strict=True)]
    lines = {}
    for name in robot.description.beams:
        places = [d.places[name] for d in deformations]
        arrays = [[array[..., g, :] for array in stack[k]] for stack, (k, g) in zip(stacks, places, strict=True)]
        axes, points = (batch.public(chunks) for chunks in zip(*arrays, strict=True))
        lines[name] = axes, points
    return ResultMapping(lines)


def _beam_arrays(beams: LoadedBeams, solution: Solution, at: Array) -> dict[str, Array]:
    """Return the arrays of :class:`BeamResult` by name, as (…, g, N), without ``stress`` and ``_euler_ratio``.

    Section wrenches are given at more fractions ``at`` of the length.
    """
    parts = {name: getattr(beams, name).sum(axis=1, keepdims=True) for name in ("wrench", "load", "inner")}
    line = None if beams.line is None else beams.line.sum(axis=1, keepdims=True)
    total = replace(beams, **parts, stretch=beams.stretch.sum(axis=0, keepdims=True), line=line)

    sections, lines = total.sections(at)[:, :, 0], total.lines(FRACTIONS)[:, :, 0]
    return {
        "length": beams.length,
        "mass": beams.mass,
        "axes": beams.axes,
        "points": _centre_lines(beams, solution),
        "section_wrenches": np.swapaxes(sections, 0, 1),
        "deflections": np.swapaxes(lines[:3], 0, 1),
        "rotations": np.swapaxes(lines[3:], 0, 1),
        "strain_energy": total.strain_energy()[0],
    }
