"""Buckling modes, and the members that buckle.

Members are collinear beams, welded or telescopic, that buckle together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.buckling.estimate import estimate
from kinetostatics.buckling.stability import Stability, stability
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import move_twist
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.statics.deformation import Deformation, deform
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import coordinates_of
from kinetostatics.statics.second_order import Changes, second_order, tangent_of
from kinetostatics.statics.small_motions import BeamEnds, PlacedMotions, SmallMotions, signs_of_modes
from kinetostatics.statics.solution import Solution, unit_responses
from kinetostatics.statics.springs import motion_of, unstable_motions

#: Relative size below which motions, and components of them, count as zero.
_MOVES = 1e-3
#: Ratio below which forces are rounding.
_NOTHING = 1e-12


@dataclass(frozen=True)
class BucklingModes:
    """The m buckling modes of each of N poses.

    Attributes:
        ratios: (N, m) ratios 1/λ of the forces to the critical forces, descending; 0 without a mode.
        shapes: (N, m, n + b) modes in the coordinates of ``robot``; NaN without a mode.
        robot: flexibility and geometric stiffness at the poses.
        motions: the coordinates of small motions, at the frames of the poses.
    """

    ratios: Array
    shapes: Array
    robot: Stability
    motions: PlacedMotions

    @classmethod
    def of(cls, robot: Stability, structure: SmallMotions, count: int) -> BucklingModes:
        """Return the ``count`` modes with the largest ratios.

        The largest component of the platform's twist is positive; if the platform does not move, the largest coordinate is
        positive.
        """
        ratios, modes = robot.modes()
        ratios, shapes = ratios[:, ::-1][:, :count], np.swapaxes(modes, 1, 2)[:, ::-1][:, :count]
        ratios = np.where(ratios < _NOTHING, 0.0, ratios)
        shapes = np.where(ratios[..., None] > 0, shapes, np.nan)
        missing = ((0, 0), (0, count - ratios.shape[1]))
        ratios, shapes = np.pad(ratios, missing), np.pad(shapes, (*missing, (0, 0)), constant_values=np.nan)
        solution = robot.before.solution
        found = cls(ratios, shapes, robot, PlacedMotions(structure, solution.frames, solution.o))
        signs = signs_of_modes(np.nan_to_num(shapes), np.nan_to_num(found.of_body(structure.platform, solution.o)), _MOVES)
        return cls(ratios, shapes * signs, robot, found.motions)

    @cached_property
    def _moved(self) -> tuple[Solution, Deformation]:
        """The robot under the forces −λ K_g u of each mode and those of springs: the last m contributions."""
        robot, n = self.robot, self.robot.flexible.shape[1]
        shapes = np.nan_to_num(self.shapes)
        forces = -(shapes @ robot.stiffening)[..., :n] / np.where(self.ratios > 0, self.ratios, 1.0)[..., None]
        forces = (forces - shapes[..., :n] @ robot.springs).transpose(2, 1, 0)
        names, units = [f"mode {k}" for k in range(forces.shape[1])], robot.geometric.unit_loads()
        wrenches: list[dict[str, Array]] = [{} for _ in names]
        for size, unit in zip(forces, units, strict=True):
            for attachment, wrench in unit.wrenches.items():
                for k, own in enumerate(wrenches):
                    own[attachment] = own.get(attachment, 0.0) + size[k] * wrench
        loads = [AppliedLoad(name, own, {}, "change") for name, own in zip(names, wrenches, strict=True)]
        twists = np.einsum("ijn,jan,amn->imn", robot.before.solution.compliance, robot.generalized_forces, forces)
        model = self.motions.structure.model
        _, solution = unit_responses(model, robot.before, loads, twists)
        return solution, deform(model, solution)

    def _of_modes(self, array: Array) -> Array:
        """Return the modes (…, m, …) of all contributions (k, S, …), NaN without a mode."""
        first = len(self.robot.before.solution.contributions)
        return array[:, first : first + self.ratios.shape[1]]

    def of_body(self, body: RigidBody, point: Array) -> Array:
        """Return displacement of a point (3, N) of a body, and rotation of the body: (N, m, 6), world axes [m, rad]."""
        solution, deformation = self._moved
        twists = motion_of(self.motions.structure.model, solution, deformation, next(iter(body.attachments)))
        found = move_twist(self._of_modes(twists), point - solution.o).transpose(2, 1, 0)
        return np.where(self.ratios[..., None] > 0, found, np.nan)

    def of_beam(self, name: str, stations: int) -> Array:
        """Return displacement and rotation (N, m, stations, 6) at equidistant stations of a beam's length, beam axes [m, rad]."""
        fractions, model = np.linspace(0, 1, stations), self.motions.structure.model.beams[name]
        solution, deformation = self._moved
        number, position = deformation.places[name]
        lines = deformation.beams[number].lines(fractions)[:, :, :, position]
        lines = self._of_modes(np.swapaxes(lines, 1, 2))
        axes, length = model.world_axes(solution.frames), model.length(solution.frames)
        local = np.concatenate([np.einsum("ijn,imsn->jmsn", axes, part) for part in np.split(lines, 2)])
        inner = self.shapes[..., self.robot.beams[name].inner].transpose(2, 1, 0)
        local += np.swapaxes(model.inside.inner_lines(length, fractions, inner), 1, 2)
        return local.transpose(3, 1, 2, 0)

    def energies(self) -> Mapping[str, Array]:
        """Return twice the strain energy (N, m) of every beam."""
        return {name: item.of(np.swapaxes(self.shapes, 1, 2)) for name, item in self.robot.beams.items()}


#: Beams are collinear up to this distance, relative to their length.
_IN_LINE = 1e-6
#: Strain energy, relative to the largest strain energy of a member, above which a member takes part in a mode.
_TAKES_PART = 0.05
#: Largest number of matrix entries at a time.
_CHUNK = 2_000_000


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
        for poses in self._chunks(solution, least if self.names else np.inf):
            robot = self._stability(solution, poses)
            risky = np.flatnonzero(~(robot.bound() < least)) if least else np.arange(len(poses))
            if len(risky):
                found[:, poses[risky]] = self._ratios(robot, risky)
        return {name: ratio for member, ratio in zip(self.names, found, strict=True) for name in member}

    def buckles(self, solution: Solution) -> Mask:
        """Return where (N,) the tangent stiffness under all forces has an eigenvalue ≤ 0."""
        found = np.zeros(solution.o.shape[1], dtype=bool)
        for poses in self._chunks(solution, 1.0, inner=False):
            tangents = tangent_of(self.structure.model, self.structure.rotation_groups, solution, poses).tangents
            found[poses] = unstable_motions(tangents, len(poses)) > 0
        return found

    def _stability(self, solution: Solution, poses: Index) -> Stability:
        return stability(self.structure.model, self.structure.rotation_groups, solution, poses)

    def _chunks(self, solution: Solution, least: float, inner: bool = True) -> list[Index]:
        """Return the poses where a ratio may be ``least`` or above, in chunks, see :meth:`_split`."""
        doubtful = np.ones(solution.o.shape[1], dtype=bool)
        if least:
            doubtful = ~(estimate(self.structure, solution) < least)
        return self._split(np.flatnonzero(doubtful), inner)

    def _split(self, poses: Index, inner: bool = True) -> list[Index]:
        """Divide poses into chunks for matrices of u and, if ``inner``, of the inner coordinates of all beams."""
        size = sum(coordinates_of(self.structure.rotation_groups).sizes.values())
        size += inner * sum(beam.inside.count for beam in self.structure.model.beams.values())
        return np.array_split(poses, min(-(-len(poses) * size**2 // _CHUNK) or 1, len(poses))) if len(poses) else []

    def modes(self, solution: Solution, poses: Index, count: int) -> Iterator[BucklingModes]:
        """Yield the ``count`` modes with the largest ratios 1/λ at the given poses, in chunks of poses."""
        for some in self._split(poses):
            yield BucklingModes.of(self._stability(solution, some), self.structure, count)

    def second_order(self, solution: Solution, poses: Index | None = None) -> Changes:
        """Return the results of second order at the given poses (None: all)."""
        structure, some = self.structure, slice(None) if poses is None else poses
        return second_order(structure.model, structure.rotation_groups, solution, some)

    def _ratios(self, robot: Stability, poses: Index | slice = slice(None)) -> Array:
        ratios, modes = robot.modes(poses)
        energies = np.array([sum(robot.beams[name].of(modes, poses) for name in member) for member in self.names])
        mine = np.where(energies >= _TAKES_PART * energies.max(axis=0), ratios, 0.0)
        return np.asarray(mine.max(axis=2))
