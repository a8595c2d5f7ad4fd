"""Displacements of beams and links by contribution to the twist, the twist by elastic part, and gravity by mechanism."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.limbs.group import carried_wrench
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.screws import move_twist
from kinetostatics.mechanism.limbs import LimbSegment
from kinetostatics.results.parts import FRACTIONS
from kinetostatics.results.pose_arrays import Batch
from kinetostatics.robot import Robot
from kinetostatics.statics.deformation import Deformation
from kinetostatics.statics.loaded_beams import LoadedBeams
from kinetostatics.statics.solution import Solution, unit_cut_wrenches


def beam_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """Return displacement and rotation of the stations of all beams (…, n, 6), by beam and contribution."""
    return _of_beams(robot, batch, solutions, deformations, lambda beams: np.swapaxes(beams.lines(FRACTIONS), 0, 1))


def axial_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """Return the axial forces (…) at the platform ends of all beams, by beam and contribution."""
    return _of_beams(robot, batch, solutions, deformations, LoadedBeams.axial_force)


def _of_beams(
    robot: Robot,
    batch: Batch,
    solutions: Sequence[Solution],
    deformations: Sequence[Deformation],
    of: Callable[[LoadedBeams], Array],
) -> Mapping[str, Mapping[str, Array]]:
    """Return the quantity that ``of`` computes for stacks of beams (…, S, g, N), by beam and contribution."""
    stacks = [[of(beams) for beams in d.beams] for d in deformations]
    found: dict[str, Mapping[str, Array]] = {}
    for name in robot.description.beams:
        places = [d.places[name] for d in deformations]
        mine = [stack[k][..., position, :] for stack, (k, position) in zip(stacks, places, strict=True)]
        found[name] = batch.by_source(solutions[0].sources, mine)
    return ResultMapping(found)


def link_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """Return the twists (…, 6) of all rigid links at their own origins, by link and contribution; links of beams are left out."""
    topology, mechanism, sources = robot.topology, robot.mechanism, solutions[0].sources
    elastic = {beam.link for beam in robot.description.beams.values()}
    result: dict[str, Mapping[str, Array]] = {}
    for link in robot.description.links:
        if link in topology.carried_by:
            twists = [d.motions[topology.carried_by[link]][:, : len(sources)] for d in deformations]
        elif link in elastic:
            continue
        elif link in topology.platform.links:
            twists = [s.twists for s in solutions]
        elif link in topology.base.links:
            twists = [np.zeros_like(s.twists) for s in solutions]
        else:
            continue
        body, placement = mechanism.body_of[link]
        moved = [move_twist(t, s.frames.point(body, placement[:3, 3]) - s.o) for t, s in zip(twists, solutions, strict=True)]
        result[link] = batch.by_source(sources, moved)
    return ResultMapping(result)


def source_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """Return the parts P_sᵀ c_s w_s of the twist (…, 6), by kind and name of the elastic part s (method page, section 6)."""
    parts: dict[str, dict[str, list[Array]]] = {}
    for solution, deformation in zip(solutions, deformations, strict=True):
        units = unit_cut_wrenches(robot.statics, solution)
        mine: dict[tuple[str, str], Array] = {}
        for item in deformation.elastic:
            carried = carried_wrench(item.cut_signs, units[item.number])[:, :, list(item.positions)]
            twists = np.einsum("iagn,ign->agn", carried, item.motion)
            for position, name in enumerate(item.names):
                mine[item.kind, name] = mine.get((item.kind, name), 0.0) + twists[:, position]
        for (kind, name), twist in mine.items():
            parts.setdefault(kind, {}).setdefault(name, []).append(twist)
    return ResultMapping(
        {kind: ResultMapping({name: batch.public(chunks) for name, chunks in named.items()}) for kind, named in parts.items()}
    )


def part_contributions(robot: Robot, batch: Batch, sources: Mapping[str, Mapping[str, Array]]) -> Mapping[str, tuple[Array, ...]]:
    """Sum the contributions of :func:`source_contributions` over the parts of each divided limb (…, 6), inboard ones first."""
    beams, nothing = robot.description.beams, batch.public([np.zeros((6, len(batch.valid)))])
    twists = [
        (f"beam:{name}" if kind == "beams" or (kind == "assembly_errors" and name in beams) else name, twist)
        for kind, named in sources.items()
        for name, twist in named.items()
    ]

    def of_part(part: LimbSegment) -> Array:
        return frozen(sum((twist for key, twist in twists if key in part.keys), nothing))

    limbs = [limb for limb in robot.topology.limbs if len(limb.parts) > 1]
    return ResultMapping({limb.name: tuple(of_part(part) for part in limb.parts) for limb in limbs})


#: The mechanisms by which gravity acts, Eq. (12).
MECHANISMS = ("platform_weight", "attached", "deformation")


def by_mechanism_of_gravity(platform_weight: Array, limbs: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    """Return the parts of a quantity due to gravity by mechanism; those of the limbs, by limb and mechanism, are summed."""
    sums = {name: sum((parts[name] for parts in limbs.values()), np.zeros_like(platform_weight)) for name in MECHANISMS[1:]}
    return {"platform_weight": platform_weight, **sums}
