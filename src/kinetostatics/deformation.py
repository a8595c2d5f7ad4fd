"""How the whole robot moves under load: every joint's outer side, every rigid link, every beam's bent line.

The platform's twist and the beams' own deformations fix how far the passive joints turn; from base to platform the motions
then add up. Everything is linear, so each contribution to the twist has motions of its own, along an axis S. Limbs built
alike stay stacked: arrays are ``(component, S, limb, pose)``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetostatics import beams as beam_formulas
from kinetostatics.beam_models import BeamModel
from kinetostatics.equilibrium import Solution
from kinetostatics.limbs import LimbStatics
from kinetostatics.linalg import least_squares
from kinetostatics.robot import Robot
from kinetostatics.screws import move_twist, move_wrench
from kinetostatics.topology import Edge

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LoadedBeams:
    """Alike beams of g limbs with what loads them, for each contribution; wrenches and loads in beam axes.

    Attributes:
        models: the beams.
        compliances: (6, g, 1) section compliances.
        axes: (3, 3, g, N) beam axes in the world.
        length: (g, N) [m].
        mass: (g, N) [kg].
        end: (3, g, N) arm from o to the outer end.
        wrench: (6, S, g, N) wrench at the outer end.
        load: (3, S, g, N) own weight [N/m].
        inner: (6, S, g, N) motion of the inner end as a rigid body, about o, world axes.
    """

    models: tuple[BeamModel, ...]
    compliances: Array
    axes: Array
    length: Array
    mass: Array
    end: Array
    wrench: Array
    load: Array
    inner: Array

    def end_twist(self) -> Array:
        """Return what their own deformation adds to everything outboard (6, S, g, N), about o, world axes."""
        c = self.compliances[:, None]
        local = beam_formulas.end_displacement(c, self.length, self.wrench)
        local += beam_formulas.sag(c, self.length, self.load)
        return move_twist(rotate(self.axes, local), -self.end[:, None])

    def lines(self, fractions: Array) -> Array:
        """Return displacement and rotation (6, n, S, g, N) of stations at given fractions of the length, world axes."""
        s = fractions[:, None, None, None] * self.length
        c = self.compliances[:, None, None]
        local = beam_formulas.bent_line(c, self.length, self.wrench[:, None], self.load[:, None], s)
        arm = self.end[:, None, None] - self.axes[:, 0, None, None] * (self.length - s)
        return rotate(self.axes, local) + move_twist(self.inner[:, None], arm)


def rotate(axes: Array, screws: Array, back: bool = False) -> Array:
    """Turn twists or wrenches (6, …, g, N) from the axes (3, 3, g, N) into world axes, or back."""
    result = np.empty(screws.shape)
    for rows in (slice(0, 3), slice(3, 6)):
        result[rows] = np.einsum("ji...gn,j...gn->i...gn" if back else "ij...gn,j...gn->i...gn", axes, screws[rows])
    return result


@dataclass(frozen=True)
class Deformation:
    """Motions of one chunk of poses, about o, world axes; the S axis holds the contributions.

    Attributes:
        motions: twist (6, S, N) of the outer side of every joint and beam, by the edge's key.
        beams: the loaded beams.
    """

    motions: dict[str, Array]
    beams: list[LoadedBeams]


def deform(robot: Robot, solution: Solution) -> Deformation:
    """Compute the motions of everything in one chunk of poses."""
    out = Deformation({}, [])
    for statics, intensities in zip(solution.statics, solution.intensities, strict=True):
        _deform_limbs(solution, statics, intensities, out)
    branches: list[tuple[tuple[Edge, ...], int, Array | None]]
    branches = [(limb.branches, 2 + k, None) for k, limb in enumerate(robot.topology.limbs)]
    branches += [(robot.topology.base.edges, len(solution.sources), None), (robot.topology.platform.edges, 1, solution.twists)]
    for edges, own, root in branches:
        if edges:
            _deform_branches(robot, solution, edges, own, root, out)
    return out


def _deform_limbs(solution: Solution, statics: LimbStatics, intensities: Array, out: Deformation) -> None:
    group, geometry = statics.group, statics.geometry
    S, (g, N) = len(solution.sources), geometry.limb_axes.shape[2:]
    own = np.zeros((S, g, 1))  # the contribution of each limb's own weight
    for position, number in enumerate(group.numbers):
        own[2 + number, position] = 1
    total = np.einsum("kign,isgn->ksgn", statics.J_c, intensities) + own * statics.R_g[:, None]
    motion = np.zeros((6, S, g, N))
    loaded: list[LoadedBeams] = []
    for b in range(len(group.beams[0])):
        axes, end, length = geometry.beam_axes[:, :, b], geometry.beam_ends[:, b], geometry.beam_lengths[b]
        models = tuple(row[b] for row in group.beams)
        mass = np.stack([_mass(model, length[k]) for k, model in enumerate(models)])
        wrench = rotate(axes, move_wrench(total + own * statics.beyond[:, None, b], end[:, None]), back=True)
        load = own * statics.load[:, None, b]
        loaded.append(LoadedBeams(models, group.compliances[:, b], axes, length, mass, end, wrench, load, motion))
    elastic = [beams.end_twist() for beams in loaded]
    gap = solution.twists[:, :, None] - sum(elastic, np.zeros((6, S, g, N)))
    passive = np.flatnonzero(group.passive)
    nullity = len(passive) - (6 - statics.J_c.shape[1])
    turned = np.zeros((len(group.passive), S, g, N))
    turned[passive] = _joint_motions(geometry.twists[:, passive], gap, group.robot.length, nullity)
    after_unit: list[Array] = []
    done = 0
    for k, unit in enumerate(group.units[0]):
        first = int(np.sum([len(item.freedoms) for item in group.units[0][:k]], dtype=int))
        while done < len(loaded) and group.freedoms_before_beam[done] <= first:
            loaded[done] = replace(loaded[done], inner=motion)
            motion = motion + elastic[done]
            done += 1
        for f in range(first, first + len(unit.freedoms)):
            motion = motion + geometry.twists[:, None, f] * turned[f]
        after_unit.append(motion)
    for b in range(done, len(loaded)):
        loaded[b] = replace(loaded[b], inner=motion)
        motion = motion + elastic[b]
    out.beams.extend(loaded)
    for position, limb in enumerate(group.limbs):
        last_joints = {unit.joints[-1]: k for k, unit in enumerate(group.units[position])}
        here, at = np.zeros((6, S, N)), 0
        for edge in limb.path:
            if edge.beam is not None:
                here = loaded[at].inner[:, :, position] + elastic[at][:, :, position]
                at += 1
            elif edge.joint in last_joints:
                here = after_unit[last_joints[edge.joint]][:, :, position]
            out.motions[edge.key] = here


def _mass(model: BeamModel, length: Array) -> Array:
    return np.full_like(length, model.mass) if model.mass_per_length is None else model.mass_per_length * length


def _joint_motions(twists: Array, gap: Array, length: float, nullity: int) -> Array:
    """Return how far freedoms with unit twists (6, k, g, N) move to bridge gaps (6, S, g, N); local freedoms stay."""
    scale = np.array([1 / length] * 3 + [1.0] * 3).reshape(6, 1, 1, 1)
    A, left = twists * scale, gap * scale
    sizes = np.sqrt(np.sum(A * A, axis=0))
    A = A / sizes
    result = np.zeros((A.shape[1], *gap.shape[1:]))
    for _ in range(2):  # the second round removes the error of the normal equations
        step = least_squares(A, left, nullity)
        result += step
        left = left - np.einsum("ij...,js...->is...", A, step)
    return result / sizes[:, None]


def _deform_branches(
    robot: Robot, solution: Solution, edges: tuple[Edge, ...], own: int, root: Array | None, out: Deformation
) -> None:
    """Let dead branches follow what they hang on, their beams bent by their own weight.

    Args:
        robot: the robot.
        solution: the chunk of poses.
        edges: joints and beams of the branches, inboard ones first.
        own: which contribution their weight belongs to; the number of contributions for what hangs on the base: it moves
            nothing but itself, and has a place of its own behind them.
        root: motion of what they hang on where an edge has no parent; None: it stands still.
        out: where the motions are put.
    """
    frames = solution.frames
    share = np.zeros((max(len(solution.sources), own + 1), 1, 1))
    share[own] = 1
    still = np.zeros((6, len(share), solution.o.shape[1]))
    for edge in edges:
        if edge.parent is None:
            motion = still if root is None else root
        else:
            motion = out.motions[edge.parent]
        if edge.beam is not None:
            model = robot.beams[edge.beam]
            axes = frames.orientations(np.array([model.span.carrier]), model.axes[:, :, None])
            end = frames.points(np.array([model.span.end_body]), model.span.end[:, None]) - solution.o[:, None]
            length = model.length(frames)[None]
            beyond = robot.weights.sum(edge.outboard, solution.weights)[:, None]
            local = rotate(axes, move_wrench(beyond, end), back=True)
            mass = _mass(model, length)
            load = np.einsum("jign,jn->ign", axes, solution.gravity) * mass / length
            beams = LoadedBeams(
                (model,),
                model.compliances[:, None, None],
                axes,
                length,
                mass,
                end,
                local[:, None] * share,
                load[:, None] * share,
                motion[:, :, None],
            )
            out.beams.append(beams)
            motion = motion + beams.end_twist()[:, :, 0]
        out.motions[edge.key] = motion
