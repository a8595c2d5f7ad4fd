"""Members: collinear beams, welded or telescopic, that buckle together; their ratios of load to critical load."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.buckling.beam_elements import INNER
from kinetostatics.buckling.shapes import BucklingModes
from kinetostatics.buckling.stability import Forces, Stability, forces_of, stability, surely_stable
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.rigid_bodies import RigidBody
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.small_motions import BeamEnds, SmallMotions
from kinetostatics.statics.solution import Solution

#: Beams are collinear up to this distance, relative to their length.
_IN_LINE = 1e-6
#: Strain energy, relative to the member with the largest one, above which a member takes part in a mode.
_TAKES_PART = 0.05
#: Upper bound of the ratios below which no eigenvalues are computed.
_NO_RISK = 0.1
#: Largest number of matrix entries at a time.
_CHUNK = 2_000_000
#: Number of poses at a time for the upper bounds.
_BLOCK = 512


class Members:
    """The members of a robot.

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
        pairs = ((a.name, b.name) for a in structure.beams for b in structure.beams if a is not b and self._are_in_line(a, b))
        together = joined(model.beams, pairs)
        self.names = tuple(self._in_order(mine) for mine in dict.fromkeys(together[name] for name in model.beams))

    def _in_order(self, names: frozenset[str]) -> tuple[str, ...]:
        x = self._x[min(names)]
        sense = sum(np.sign(x @ self._x[name]) for name in names)
        return tuple(sorted(names, key=lambda name: (float(sense or 1.0) * float(x @ sum(self._ends[name])), name)))

    def _are_in_line(self, a: BeamEnds, b: BeamEnds) -> bool:
        """Whether two beams are collinear at a body that is neither base nor platform."""
        graph, welded = self.structure.graph, self._welded(self._x[a.name])
        for behind, body in ((1, a.outer), (-1, a.inner)):
            for ahead, other in ((1, b.inner), (-1, b.outer)):
                if body in (graph.base, graph.platform) or other not in welded[body]:
                    continue
                x, y = behind * self._x[a.name], ahead * self._x[b.name]
                first, second = self._ends[a.name][behind > 0], self._ends[b.name][ahead < 0]
                size = max(float(np.linalg.norm(np.subtract(*self._ends[a.name]))), 1e-3)
                if x @ y > 0 and np.linalg.norm(cross(x, y)) < _IN_LINE:
                    if np.linalg.norm(cross(x, second - first)) < _IN_LINE * size:
                        return True
        return False

    def _welded(self, x: Array) -> dict[RigidBody, frozenset[RigidBody]]:
        """Return for every body the bodies that are fixed to it, elastically or rigidly, or slide relative to it along x."""
        graph, frames = self.structure.graph, self.structure.model.zero_frames
        pairs = []
        for joint in self.structure.joints:
            item = joint.connection
            axis = frames.direction(item.predecessor_body, item.axis_on(True))[:, 0]
            slides = item.type.is_slide and np.linalg.norm(cross(axis, x)) < _IN_LINE
            if (item.type.is_fixed or slides) and not {joint.inner, joint.outer} & {graph.base, graph.platform}:
                pairs.append((joint.inner, joint.outer))
        return joined(self.structure.columns, pairs)

    def ratios(self, solution: Solution) -> dict[str, Array]:
        """Return for every beam the ratio (N,) of the forces to the critical forces of its member.

        It is the largest 1/λ of all buckling modes in which the member takes part; 0 without such a mode, as under tension.
        """
        found = np.zeros((len(self.names), solution.o.shape[1]))
        if self.names:
            forces = forces_of(self.structure, solution)
            for poses in self._chunks(found.shape[1]):
                found[:, poses] = self._ratios(stability(self.structure, forces.take(poses)))
        return {name: ratio for member, ratio in zip(self.names, found, strict=True) for name in member}

    def buckles(self, solution: Solution) -> Mask:
        """Return the mask (N,) of poses at which a member buckles."""
        forces = forces_of(self.structure, solution)
        doubtful = np.flatnonzero(self._estimate(forces, solution.compliance) >= _NO_RISK)
        found = np.zeros(solution.o.shape[1], dtype=bool)
        parts = np.array_split(doubtful, -(-len(doubtful) // _BLOCK)) if len(doubtful) else []
        rest = [part[~surely_stable(self.structure, forces.take(part))] for part in parts]
        doubtful = np.concatenate([doubtful[:0], *rest])
        for chunk in self._chunks(len(doubtful)):
            poses = doubtful[chunk]
            item = stability(self.structure, forces.take(poses))
            if not item.is_stable():
                found[poses] = np.any(self._ratios(item) >= 1, axis=0)
        return found

    def _chunks(self, N: int) -> list[Index]:
        coordinates = len(self.structure.freedoms) + 2 * INNER * len(self.structure.beams)
        return np.array_split(np.arange(N), max(-(-N * coordinates**2 // _CHUNK), 1)) if N else []

    def modes(self, solution: Solution, poses: Index, count: int) -> Iterator[BucklingModes]:
        """Yield the first modes of the given poses, of some after others."""
        forces = forces_of(self.structure, solution).take(poses)
        for some in self._chunks(len(poses)):
            yield BucklingModes.of(stability(self.structure, forces.take(some))).first(count)

    def second_order(self, solution: Solution, poses: Index | None = None) -> tuple[Array, ...]:
        """Return what geometric stiffness changes at all poses, or the given ones, see :meth:`BucklingModes.second_order`."""
        forces = forces_of(self.structure, solution)
        forces = forces if poses is None else forces.take(poses)
        parts = []
        for some in self._chunks(forces.o.shape[1]):
            here = forces.take(some)
            parts.append(BucklingModes.of(stability(self.structure, here)).second_order(here))
        return tuple(np.concatenate(items, axis=-1) for items in zip(*parts, strict=True))

    def _ratios(self, item: Stability) -> Array:
        """Return the ratios (members, N) of forces to critical forces."""
        ratios, modes = item.modes()
        energies = np.array([sum(item.beams[name].of(modes) for name in member) for member in self.names])
        mine = np.where(energies >= _TAKES_PART * energies.max(axis=0), ratios, 0.0)
        return np.where(np.isnan(ratios[:, 0]), np.nan, mine.max(axis=2))

    def _estimate(self, forces: Forces, compliance: Array) -> Array:
        """Return an upper bound (N,) of the largest ratio.

        It is the product of the sums of all moments of forces about joints and beam ends and of all rotational compliances, as if
        all parts were in series. The bound is rigorous for robots without loops; with loops, parts may rotate further, which the
        margin of ``_NO_RISK`` covers.
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
