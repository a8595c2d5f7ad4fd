"""Section wrenches, deflections, stresses and buckling ratios of beams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.elements import Beam
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.limbs import beam_formulas
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.results.batch import Batch
from kinetostatics.robot import Robot
from kinetostatics.statics.deformation import Deformation
from kinetostatics.statics.loaded_beams import LoadedBeams
from kinetostatics.statics.solution import Solution

#: Stations along a beam, ends included.
STATIONS = 21
FRACTIONS = frozen(np.linspace(0, 1, STATIONS))


@dataclass(frozen=True, eq=False, repr=False)
class BeamResult(Reported, builder="reports.parts:beam_report"):
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
        euler_ratio: (…) ratio of the forces to the critical forces of the buckling modes in which the beam takes part; it buckles
            at 1 and above. For a strut between two hinges it is N/N_Euler; see :mod:`kinetostatics.buckling`. Collinear beams
            that are welded or telescopic form one member with one ratio.
        member: names of the beams of this member, from its base end to its platform end.
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
    euler_ratio: Array
    strain_energy: Array
    member: tuple[str, ...]

    @property
    def deflection(self) -> Array:
        """(…) largest displacement of the centre line [m]."""
        return np.asarray(np.sqrt((self.deflections**2).sum(axis=-1)).max(axis=-1))


def beam_results(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, BeamResult]:
    """Return the results of all beams by name, in the order of the file."""
    found: dict[str, BeamResult] = {}
    ratios = [robot.members.ratios(solution) for solution in solutions]
    members = {beam: member for member in robot.members.names for beam in member}
    numbers = [[_numbers(stack, solution) for stack in d.beams] for d, solution in zip(deformations, solutions, strict=True)]
    for name, beam in robot.description.beams.items():
        places = [d.places[name] for d in deformations]
        pieces = [(stacks[k], position) for stacks, (k, position) in zip(numbers, places, strict=True)]
        mine = {key: [stack[key][..., position, :] for stack, position in pieces] for key in pieces[0][0]}
        wrenches = [np.swapaxes(w, 0, 1) for w in mine["section_wrenches"]]
        mine["stress"] = [beam.section.largest_stress(w, beam.poisson_ratio) for w in wrenches]
        mine["euler_ratio"] = [ratio[name] for ratio in ratios]
        arrays = {key: batch.public(chunks) for key, chunks in mine.items()}
        found[name] = BeamResult(name, beam, FRACTIONS, **arrays, member=members[name])
    return ResultMapping(found)


def _points(beams: LoadedBeams, solution: Solution) -> Array:
    """Return the undeformed centre lines (n, 3, g, N)."""
    start = solution.o[:, None] + beams.end - beams.axes[:, 0] * beams.length
    return np.swapaxes(start[:, None] + beams.axes[:, :1] * (FRACTIONS[:, None, None] * beams.length), 0, 1)


def centre_lines(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, tuple[Array, Array]]:
    """Return axes and points of :class:`BeamResult` of all beams by name."""
    stacks = [[(stack.axes, _points(stack, s)) for stack in d.beams] for d, s in zip(deformations, solutions, strict=True)]
    found = {}
    for name in robot.description.beams:
        places = [d.places[name] for d in deformations]
        mine = [[array[..., g, :] for array in stack[k]] for stack, (k, g) in zip(stacks, places, strict=True)]
        axes, points = (batch.public(chunks) for chunks in zip(*mine, strict=True))
        found[name] = axes, points
    return ResultMapping(found)


def _numbers(beams: LoadedBeams, solution: Solution) -> dict[str, Array]:
    """Return the arrays (…, g, N) of a :class:`BeamResult` except the stress."""
    parts = {name: getattr(beams, name).sum(axis=1, keepdims=True) for name in ("wrench", "load", "inner")}
    line = None if beams.line is None else beams.line.sum(axis=1, keepdims=True)
    total = replace(beams, **parts, stretch=beams.stretch.sum(axis=0, keepdims=True), line=line)

    def section(s: Array) -> Array:
        return total.sections(s)[:, :, 0]

    sections, lines = section(FRACTIONS[:, None, None] * beams.length), total.lines(FRACTIONS)[:, :, 0]
    return {
        "length": beams.length,
        "mass": beams.mass,
        "axes": beams.axes,
        "points": _points(beams, solution),
        "section_wrenches": np.swapaxes(sections, 0, 1),
        "deflections": np.swapaxes(lines[:3], 0, 1),
        "rotations": np.swapaxes(lines[3:], 0, 1),
        "strain_energy": beam_formulas.strain_energy(beams.compliances, beams.length, section),
    }
