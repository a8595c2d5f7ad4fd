"""Buckling modes, and the members that buckle.

Members are collinear beams, welded or telescopic, that buckle together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.buckling.beam_elements import INNER, deflection
from kinetostatics.buckling.stability import Forces, Stability, forces_of, stability, surely_stable
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.second_order import Changes, second_order
from kinetostatics.statics.small_motions import BeamEnds, PlacedMotions, SmallMotions, signs_of_modes
from kinetostatics.statics.solution import Solution

#: Relative size below which motions, and components of them, count as zero.
_MOVES = 1e-3
#: Ratio below which forces are rounding.
_NOTHING = 1e-12


@dataclass(frozen=True)
class BucklingModes:
    """The m buckling modes of each of N poses.

    Attributes:
        ratios: (N, m) ratios 1/λ of the forces to the critical forces, ascending; descending if returned by :meth:`first`.
        shapes: (N, m, n + b) modes in the coordinates of ``robot``.
        robot: stiffness and geometric stiffness at the poses.
    """

    ratios: Array
    shapes: Array
    robot: Stability

    @classmethod
    def of(cls, robot: Stability) -> BucklingModes:
        ratios, modes = robot.modes()
        return cls(ratios, np.swapaxes(modes, 1, 2), robot)

    @property
    def motions(self) -> PlacedMotions:
        return self.robot.motions

    def first(self, count: int) -> BucklingModes:
        """Return the ``count`` modes with the largest ratios, in descending order; NaN where there are fewer.

        The largest component of the platform's twist is positive; if the platform does not move, the largest coordinate is
        positive.
        """
        ratios, shapes = self.ratios[:, ::-1][:, :count], self.shapes[:, ::-1][:, :count]
        twists = BucklingModes(ratios, shapes, self.robot).of_body(self.motions.structure.platform, self.motions.o)
        shapes = shapes * signs_of_modes(shapes, twists, _MOVES)
        ratios = np.where(ratios < _NOTHING, 0.0, ratios)
        shapes = np.where(ratios[..., None] > 0, shapes, np.nan)
        missing = ((0, 0), (0, count - ratios.shape[1]))
        return BucklingModes(np.pad(ratios, missing), np.pad(shapes, (*missing, (0, 0)), constant_values=np.nan), self.robot)

    def of_body(self, body: RigidBody, point: Array) -> Array:
        """Return displacement of a point (3, N) of a body, and rotation of the body: (N, m, 6), world axes [m, rad]."""
        return self.motions.of_body(self.shapes, body, point)

    def of_beam(self, name: str, stations: int) -> Array:
        """Return displacement and rotation (N, m, stations, 6) at equidistant stations of a beam's length, beam axes [m, rad]."""
        return self._line(name, np.linspace(0, 1, stations))

    def _line(self, name: str, fractions: Array) -> Array:
        """Return displacement and rotation (N, m, S, 6) at fractions (S,) of a beam's length, beam axes [m, rad]."""
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


#: Beams are collinear up to this distance, relative to their length.
_IN_LINE = 1e-6
#: Strain energy, relative to the largest strain energy of a member, above which a member takes part in a mode.
_TAKES_PART = 0.05
#: Estimate of the largest ratio, relative to the one of interest, below which no eigenvalues are computed.
_NO_RISK = 0.1
#: Largest number of matrix entries at a time.
_CHUNK = 2_000_000
#: Number of poses at a time for the upper bounds.
_BLOCK = 512


class Members:
    """The members of a robot: collinear beams, welded or telescopic, that buckle together.

    Attributes:
        names: names of the beams of each member, from the base end to the platform end; members in the order of the file.
        structure: bodies, joints, beams and coordinates of the robot's small motions.
    """

    def __init__(self, model: RobotStatics) -> None:
        self.structure = structure = SmallMotions(model)
        frames = model.zero_frames
        self._x = {name: frames.direction(beam.span.carrier, beam.axes[:, 0])[:, 0] for name, beam in model.beams.items()}
        spans = {name: beam.span for name, beam in model.beams.items()}
        self._ends = {
            name: (frames.point(span.start_body, span.start)[:, 0], frames.point(span.end_body, span.end)[:, 0])
            for name, span in spans.items()
        }
        self._slides = {
            joint.connection.name: frames.direction(joint.connection.predecessor_body, joint.connection.axis_on(True))[:, 0]
            for joint in structure.joints
            if joint.connection.type.is_slide
        }
        pairs = ((a.name, b.name) for a in structure.beams for b in self._in_line_with(a))
        together = joined(model.beams, pairs)
        self.names = tuple(self._in_order(mine) for mine in dict.fromkeys(together[name] for name in model.beams))

    def _in_order(self, names: frozenset[str]) -> tuple[str, ...]:
        x = self._x[min(names)]
        sense = sum(np.sign(x @ self._x[name]) for name in names)
        return tuple(sorted(names, key=lambda name: (float(sense or 1.0) * float(x @ sum(self._ends[name])), name)))

    def _in_line_with(self, a: BeamEnds) -> Iterator[BeamEnds]:
        """Yield the beams that are collinear with a beam at a body that is neither base nor platform."""
        graph, x = self.structure.graph, self._x[a.name]
        welded, size = self._welded(x), max(float(np.linalg.norm(np.subtract(*self._ends[a.name]))), 1e-3)
        for behind, body in ((1, a.outer), (-1, a.inner)):
            if body in (graph.base, graph.platform):
                continue
            for b in self.structure.beams:
                for ahead, other in ((1, b.inner), (-1, b.outer)):
                    if b is a or other not in welded[body]:
                        continue
                    y, first, second = self._x[b.name], self._ends[a.name][behind > 0], self._ends[b.name][ahead < 0]
                    if behind * ahead * (x @ y) > 0 and np.linalg.norm(cross(x, y)) < _IN_LINE:
                        if np.linalg.norm(cross(x, second - first)) < _IN_LINE * size:
                            yield b

    def _welded(self, x: Array) -> dict[RigidBody, frozenset[RigidBody]]:
        """Return for every body the bodies that are fixed to it, elastically or rigidly, or slide relative to it along x."""
        ends = {self.structure.graph.base, self.structure.graph.platform}
        along = {name for name, axis in self._slides.items() if np.linalg.norm(cross(axis, x)) < _IN_LINE}
        return joined(
            self.structure.columns,
            (
                (joint.inner, joint.outer)
                for joint in self.structure.joints
                if (joint.connection.type.is_fixed or joint.connection.name in along) and not {joint.inner, joint.outer} & ends
            ),
        )

    def ratios(self, solution: Solution, least: float = 0.0) -> dict[str, Array]:
        """Return for every beam the ratio (N,) of the forces to the critical forces of its member.

        The ratio is the largest 1/λ of the buckling modes in which the member takes part; it is 0 without such a mode, as under
        tension, and at poses where a bound shows that all ratios are below ``least``.
        """
        found = np.zeros((len(self.names), solution.o.shape[1]))
        if self.names:
            forces = forces_of(self.structure, solution)
            doubtful = self._doubtful(forces, solution.compliance, least) if least else np.arange(found.shape[1])
            for chunk in self._chunks(len(doubtful)):
                poses = doubtful[chunk]
                found[:, poses] = self._ratios(stability(self.structure, forces.take(poses)))
        return {name: ratio for member, ratio in zip(self.names, found, strict=True) for name in member}

    def buckles(self, solution: Solution) -> Mask:
        nowhere = np.zeros(solution.o.shape[1], dtype=bool)
        return np.any([nowhere, *(ratio >= 1 for ratio in self.ratios(solution, 1.0).values())], axis=0)

    def _doubtful(self, forces: Forces, compliance: Array, least: float) -> Index:
        """Return the poses where a ratio may be ``least`` or above."""
        doubtful = np.flatnonzero(self._estimate(forces, compliance) >= _NO_RISK * least)
        parts = np.array_split(doubtful, -(-len(doubtful) // _BLOCK)) if len(doubtful) else []
        rest = [part[~surely_stable(self.structure, forces.take(part), 1 / least)] for part in parts]
        return np.concatenate([doubtful[:0], *rest])

    def _chunks(self, N: int) -> list[Index]:
        coordinates = len(self.structure.freedoms) + 2 * INNER * len(self.structure.beams)
        return np.array_split(np.arange(N), max(-(-N * coordinates**2 // _CHUNK), 1)) if N else []

    def modes(self, solution: Solution, poses: Index, count: int) -> Iterator[BucklingModes]:
        """Yield the ``count`` modes with the largest ratios 1/λ at the given poses, in chunks of poses."""
        forces = forces_of(self.structure, solution).take(poses)
        for some in self._chunks(len(poses)):
            yield BucklingModes.of(stability(self.structure, forces.take(some))).first(count)

    def second_order(self, solution: Solution, poses: Index | None = None) -> Changes:
        """Return the results of second order at the given poses (None: all)."""
        structure, some = self.structure, slice(None) if poses is None else poses
        return second_order(structure.model, structure.parts, solution, some)

    def _ratios(self, item: Stability) -> Array:
        ratios, modes = item.modes()
        energies = np.array([sum(item.beams[name].of(modes) for name in member) for member in self.names])
        mine = np.where(energies >= _TAKES_PART * energies.max(axis=0), ratios, 0.0)
        return np.asarray(mine.max(axis=2))

    def _estimate(self, forces: Forces, compliance: Array) -> Array:
        """Return an upper estimate (N,) of the largest ratio of the forces to the critical forces.

        The estimate is the sum of the moments of all forces about joints and beam ends, times the sum of all rotational
        compliances, as if all parts were in series. For robots without loops it is a strict bound; in loops, parts may rotate
        further, which the margin of ``_NO_RISK`` covers.
        """
        model, freedoms = self.structure.model, self.structure.freedoms
        lengths = {name: beam.length(forces.frames) for name, beam in model.beams.items()}
        soft = {name: length * model.beams[name].compliances[4:6].max() for name, length in lengths.items()}
        turning = self.structure.turning
        springs = {
            k: model.length ** (2 * (k in turning)) / item.stiffness
            for k, item in enumerate(freedoms)
            if item is not None and item.stiffness
        }
        springs.update({item.column: item.times**2 * springs[item.master] for item in self.structure.followers})
        turns = sum(soft.values()) + sum(c for k, c in springs.items() if k in turning) / model.length**2
        with np.errstate(divide="ignore", invalid="ignore"):  # the length of a telescopic beam may be zero
            turns += sum(c for k, c in springs.items() if k not in turning) / np.min(list(lengths.values()), axis=0) ** 2
        arms = sum(np.linalg.norm(forces.beams[name], axis=1).max(axis=0) * lengths[name] for name in lengths)
        arms += np.linalg.norm(forces.joints, axis=0).max(axis=0, initial=0.0) * model.length
        return np.asarray(arms * (turns + np.trace(compliance[3:, 3:])))
