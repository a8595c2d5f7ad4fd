"""How the whole robot moves under load: every joint's outer side, every rigid link, every beam's bent line.

The platform's twist and the beams' own deformations fix how far the passive joints turn; from base to platform the motions
then add up. Everything is linear, so each contribution to the twist has motions of its own, along an axis S.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics import beams as beam_formulas
from kinetostatics.beam_models import BeamModel
from kinetostatics.equilibrium import Solution
from kinetostatics.limbs import LimbStatics
from kinetostatics.linalg import Cholesky
from kinetostatics.screws import move_twist, move_wrench
from kinetostatics.topology import Edge

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LoadedBeam:
    """A beam with what loads it, for each contribution; in beam axes, arrays (…, S, N).

    Attributes:
        model: the beam.
        axes: (3, 3, N) beam axes in the world.
        length: (N,) [m].
        end: (3, N) arm from o to the outer end.
        wrench: (6, S, N) wrench at the outer end.
        load: (3, S, N) its own weight [N/m].
        inner: (6, S, N) motion of its inner end as a rigid body, about o, world axes.
    """

    model: BeamModel
    axes: Array
    length: Array
    end: Array
    wrench: Array
    load: Array
    inner: Array

    def end_twist(self) -> Array:
        """Return what its own deformation adds to everything outboard (6, S, N), about o, world axes."""
        c = self.model.compliances[:, None, None]
        local = beam_formulas.end_displacement(c, self.length, self.wrench)
        local = local + beam_formulas.sag(c, self.length, self.load)
        return move_twist(self.to_world(local), -self.end[:, None])

    def to_world(self, twist: Array) -> Array:
        """Turn twists or wrenches (6, S, N) from beam into world axes."""
        return np.concatenate([np.einsum("ijn,jsn->isn", self.axes, part) for part in (twist[:3], twist[3:])])


@dataclass(frozen=True)
class Deformation:
    """Motions of one chunk of poses, about o, world axes; the S axis holds the contributions.

    Attributes:
        motions: twist (6, S, N) of the outer side of every joint and beam, by the edge's key.
        beams: the loaded beams by name.
    """

    motions: dict[str, Array]
    beams: dict[str, LoadedBeam]


def deform(solution: Solution) -> Deformation:
    """Compute the motions of everything in one chunk of poses."""
    deformation = Deformation({}, {})
    topology = None
    for statics, intensities in zip(solution.statics, solution.intensities, strict=True):
        group = statics.group
        topology = group.robot.topology
        totals = _total_wrenches(solution, statics, intensities)
        for position, limb in enumerate(group.limbs):
            own = group.numbers[position] + 2
            _deform_limb(solution, statics, position, own, totals[:, :, position], deformation)
            _deform_branches(solution, group.robot, limb.branches, own, None, deformation)
    robot = solution.statics[0].group.robot if solution.statics else None
    if robot is not None and topology is not None:
        _deform_branches(solution, robot, topology.base.edges, None, None, deformation)
        _deform_branches(solution, robot, topology.platform.edges, 1, solution.twists, deformation)
    return deformation


def _total_wrenches(solution: Solution, statics: LimbStatics, intensities: Array) -> Array:
    """Return what the platform puts on each limb, for each contribution (6, S, g, N)."""
    totals = np.einsum("kign,isgn->ksgn", statics.J_c, intensities)
    for position, number in enumerate(statics.group.numbers):
        totals[:, 2 + number, position] += statics.R_g[:, position]
    return totals


def _only(source: int | None, count: int, array: Array) -> Array:
    """Return an array (…, S, N) that is ``array`` (…, N) for one contribution and zero for the others."""
    result = np.zeros((array.shape[0], count, array.shape[-1]))
    if source is not None:
        result[:, source] = array
    return result


def _deform_limb(solution: Solution, statics: LimbStatics, position: int, own: int, total: Array, out: Deformation) -> None:
    group, geometry = statics.group, statics.geometry
    limb, S = group.limbs[position], len(solution.sources)
    loaded: list[LoadedBeam] = []
    for b, model in enumerate(group.beams[position]):
        axes, end = geometry.beam_axes[:, :, b, position], geometry.beam_ends[:, b, position]
        wrench = total + _only(own, S, statics.beyond[:, b, position])
        moved = move_wrench(wrench, end[:, None])
        local = np.concatenate([np.einsum("jin,jsn->isn", axes, part) for part in (moved[:3], moved[3:])])
        load = _only(own, S, statics.load[:, b, position])
        loaded.append(LoadedBeam(model, axes, geometry.beam_lengths[b, position], end, local, load, np.zeros_like(local)))
    elastic = [beam.end_twist() for beam in loaded]
    gap = solution.twists - sum(elastic, np.zeros_like(solution.twists))
    twists = geometry.twists[:, :, position]
    turned = _joint_motions(twists * group.passive[:, None], gap, group.robot.length)
    units = {name: unit for unit in group.units[position] for name in unit.joints}
    first = {id(unit): int(np.flatnonzero(group.unit_of == k)[0]) for k, unit in enumerate(group.units[position])}
    motion = np.zeros_like(solution.twists)
    at = 0
    for edge in limb.path:
        if edge.beam is not None:
            beam = loaded[at]
            out.beams[edge.beam] = LoadedBeam(beam.model, beam.axes, beam.length, beam.end, beam.wrench, beam.load, motion)
            motion = motion + elastic[at]
            at += 1
        elif edge.joint in units and units[edge.joint].joints[-1] == edge.joint:
            unit = units[edge.joint]
            for f in range(first[id(unit)], first[id(unit)] + len(unit.freedoms)):
                motion = motion + twists[:, f, None] * turned[f]
        out.motions[edge.key] = motion


def _joint_motions(twists: Array, gap: Array, length: float) -> Array:
    """Return how far the passive freedoms (k, S, N) move so that the limb meets the platform; local freedoms stay."""
    k = twists.shape[1]
    if k == 0:
        return np.zeros((0, *gap.shape[1:]))
    scale = np.array([1 / length] * 3 + [1.0] * 3)[:, None, None]
    A, left = twists * scale, gap * scale
    sizes = np.sqrt(np.sum(A * A, axis=0))
    sizes = np.where(sizes > 0, sizes, 1.0)
    A = A / sizes
    normal = np.einsum("ijn,ikn->jkn", A, A)
    normal[np.arange(k), np.arange(k)] += 1e-11
    factor = Cholesky(normal)
    result = np.zeros((k, *gap.shape[1:]))
    for _ in range(3):
        step = factor.solve(np.einsum("ijn,isn->jsn", A, left))
        result += step
        left = left - np.einsum("ijn,jsn->isn", A, step)
    return result / sizes[:, None]


def _deform_branches(
    solution: Solution, robot: object, edges: tuple[Edge, ...], own: int | None, root: Array | None, out: Deformation
) -> None:
    """Let dead branches follow what they hang on, their beams bent by their own weight."""
    from kinetostatics.robot import Robot

    assert isinstance(robot, Robot)
    if not edges:
        return
    S, frames, o = len(solution.sources), solution.frames, solution.o
    weights = robot.weights.wrenches(frames, o, solution.gravity)
    names = robot.weights.names
    for edge in edges:
        if edge.parent is None:
            motion = np.zeros_like(solution.twists) if root is None else root
        else:
            motion = out.motions[edge.parent]
        if edge.beam is not None:
            model = robot.beams[edge.beam]
            axes = frames.orientations(np.array([model.span.carrier]), model.axes[:, :, None])[:, :, 0]
            end = frames.points(np.array([model.span.end_body]), model.span.end[:, None])[:, 0] - o
            length = model.length(frames)
            beyond = np.einsum("w,iwn->in", np.array([name in edge.outboard for name in names], dtype=float), weights)
            moved = move_wrench(beyond, end)
            local = np.concatenate([np.einsum("jin,jn->in", axes, part) for part in (moved[:3], moved[3:])])
            mass = np.full_like(length, model.mass) if model.mass_per_length is None else model.mass_per_length * length
            load = np.einsum("jin,jn->in", axes, solution.gravity) * mass / length
            beam = LoadedBeam(model, axes, length, end, _only(own, S, local), _only(own, S, load), motion)
            out.beams[edge.beam] = beam
            motion = motion + beam.end_twist()
        out.motions[edge.key] = motion
