"""Parts of motions due to each contribution (load or weight), elastic part and mechanism of gravity; effect of a payload."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.elements.element import carried_wrench
from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.layout.mapping import ResultMapping, ShortRepr
from kinetostatics.math.arrays import Array, Mask, frozen
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import move_twist, wrench_of_couple, wrench_of_force
from kinetostatics.mechanism.limbs import Limb, LimbSegment
from kinetostatics.mechanism.tree import Frames
from kinetostatics.results.parts import FRACTIONS
from kinetostatics.results.pose_arrays import Batch
from kinetostatics.robot import Robot
from kinetostatics.statics.deformation import Deformation
from kinetostatics.statics.joint_wrenches import actuator_forces_from, joint_contributions, joints_in_order
from kinetostatics.statics.link_loads import PAYLOAD, AppliedLoad, link_frame
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution, of_deformation, unit_cut_wrenches
from kinetostatics.statics.springs import motion_of, solve_with_springs


def beam_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """(…, n, 6) displacement and rotation at n stations of each beam, world axes [m, rad], by beam and contribution."""
    return _of_beams(robot, batch, solutions, deformations, lambda beams: np.swapaxes(beams.lines(FRACTIONS), 0, 1))


def axial_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """(…) axial force at the platform end of each beam [N], tension positive, by beam and contribution."""
    return _of_beams(robot, batch, solutions, deformations, LoadedBeams.axial_force)


def _of_beams(
    robot: Robot,
    batch: Batch,
    solutions: Sequence[Solution],
    deformations: Sequence[Deformation],
    of: Callable[[LoadedBeams], Array],
) -> Mapping[str, Mapping[str, Array]]:
    """Return a quantity by beam and contribution; ``of`` returns it as (…, S, g, N) for g beams and S contributions."""
    stacks = [[of(beams) for beams in d.beams] for d in deformations]
    by_beam: dict[str, Mapping[str, Array]] = {}
    for name in robot.description.beams:
        places = [d.places[name] for d in deformations]
        arrays = [stack[k][..., position, :] for stack, (k, position) in zip(stacks, places, strict=True)]
        by_beam[name] = batch.by_contribution(solutions[0].contributions, arrays)
    return ResultMapping(by_beam)


def link_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """(…, 6) twist of each rigid link at the link's origin, world axes [m, rad], by link and contribution."""
    topology, result = robot.topology, {}
    elastic = {beam.link for beam in robot.description.beams.values()}
    starts = {part.link: topology.span_ends[name][0] for name, part in robot.description.flexible.items()}
    for link in robot.description.links:
        attachment = starts.get(link, link)  # other elastic links move with their inner ends
        if attachment in topology.carried_by or (
            link not in elastic and link in (*topology.base.links, *topology.platform.links)
        ):
            body, placement = robot.mechanism.body_of[link]
            points = [s.frames.point(body, placement[:3, 3]) for s in solutions]
            twists = _twists_at(robot, solutions, deformations, attachment, points)
            result[link] = batch.by_contribution(solutions[0].contributions, twists)
    return ResultMapping(result)


def interface_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """(…, n, 6) twist of the n interfaces of each elastic link that is no beam, world axes [m, rad], by link and contribution."""
    result = {}
    for link in robot.description.flexible:
        by_end = []
        for name, end, attachment in robot.topology.interfaces(link):
            points = [robot.statics.elastic_links[name].ends(s.frames)[end] for s in solutions]
            by_end.append(_twists_at(robot, solutions, deformations, attachment, points))
        result[link] = batch.by_contribution(solutions[0].contributions, [np.stack(ends) for ends in zip(*by_end, strict=True)])
    return ResultMapping(result)


def _twists_at(
    robot: Robot, solutions: Sequence[Solution], deformations: Sequence[Deformation], attachment: str, points: Sequence[Array]
) -> list[Array]:
    """Return the twists (6, S, N) of the body at an attachment at points (3, N), for S contributions."""
    count, chunks = len(solutions[0].contributions), zip(solutions, deformations, points, strict=True)
    return [move_twist(motion_of(robot.statics, s, d, attachment)[:, :count], (point - s.o)[:, None]) for s, d, point in chunks]


def source_contributions(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], deformations: Sequence[Deformation]
) -> Mapping[str, Mapping[str, Array]]:
    """(…, 6) twist of the platform at o due to each elastic part and each assembly error, by kind and name of the part."""
    parts: dict[str, dict[str, list[Array]]] = {}
    for solution, deformation in zip(solutions, deformations, strict=True):
        units = unit_cut_wrenches(robot.statics, solution)
        part_twists: dict[tuple[str, str], Array] = {}
        for part in deformation.elastic:
            carried = carried_wrench(part.cut_signs, units[part.number])[:, :, list(part.positions)]
            twists = np.einsum("iagn,ign->agn", carried, part.motion)
            for position, name in enumerate(part.names):
                part_twists[part.kind, name] = part_twists.get((part.kind, name), 0.0) + twists[:, position]
        for (kind, name), twist in part_twists.items():
            parts.setdefault(kind, {}).setdefault(name, []).append(twist)
    return ResultMapping(
        {kind: ResultMapping({name: batch.public(chunks) for name, chunks in named.items()}) for kind, named in parts.items()}
    )


def part_contributions(robot: Robot, batch: Batch, sources: Mapping[str, Mapping[str, Array]]) -> Mapping[str, tuple[Array, ...]]:
    """(…, 6) twist due to each of the parts in series of a limb, from base to platform; limbs of a single part are omitted.

    ``sources``: twist of each elastic part, from :func:`source_contributions`; the twists within a part of the limb are added.
    """
    links, nothing = robot.description.elastic_links, batch.public([np.zeros((6, len(batch.valid)))])
    twists = [
        (f"beam:{name}" if kind in ("beams", "links") or (kind == "assembly_errors" and name in links) else name, twist)
        for kind, named in sources.items()
        for name, twist in named.items()
    ]

    def of_part(part: LimbSegment) -> Array:
        return frozen(sum((twist for key, twist in twists if key in part.keys), nothing))

    limbs = [limb for limb in robot.topology.limbs if len(limb.parts) > 1]
    return ResultMapping({limb.name: tuple(of_part(part) for part in limb.parts) for limb in limbs})


#: The mechanisms by which gravity acts, Eq. (12).
MECHANISMS = ("platform_weight", "attached", "deformation")


def mechanisms_by_limb(contributions: Mapping[str, Array], limbs: Iterable[Limb]) -> Mapping[str, Mapping[str, Array]]:
    """Return the parts "attached" and "deformation" of each limb's weight, from contributions split into them."""
    parts = {limb.name: (contributions[limb.name], contributions[of_deformation(limb.name)]) for limb in limbs}
    return ResultMapping({name: ResultMapping(zip(MECHANISMS[1:], pair, strict=True)) for name, pair in parts.items()})


def by_mechanism_of_gravity(platform_weight: Array, limbs: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    """Return the part of a quantity due to each of the ``MECHANISMS``; ``limbs``: parts by limb and mechanism, to be added."""
    sums = {name: sum((parts[name] for parts in limbs.values()), np.zeros_like(platform_weight)) for name in MECHANISMS[1:]}
    return {"platform_weight": platform_weight, **sums}


# ---- coefficients of a payload ------------------------------------------------------------------------------------

#: Names of the parameters of a payload to which its weight is proportional.
PARAMETERS = ("mass", "first_moment_x", "first_moment_y", "first_moment_z")


@dataclass(frozen=True, eq=False, repr=False)
class PayloadCoefficients(ShortRepr):
    """Twist and forces due to a payload of mass m [kg] with its centre at c [m], per unit of m, m c_x, m c_y and m c_z.

    ``coefficients.twist @ [m, *(m * c)]`` is the payload's contribution to the twist; c is in o-xyz, or in the frame of the link
    that carries the payload.

    Attributes:
        parameters: names of the four parameters: "mass" [kg], "first_moment_x", "first_moment_y", "first_moment_z" [kg·m].
        twist: (…, 6, 4) twist of the platform at o, world axes [m, rad] per unit.
        actuator_forces: (…, 4) force of each actuator [N or N·m] per unit.
        joint_wrenches: (…, 6, 4) wrench of each joint, at its centre, world axes [N, N·m] per unit.
    """

    parameters: tuple[str, ...]
    twist: Array
    actuator_forces: Mapping[str, Array]
    joint_wrenches: Mapping[str, Array]


def payload_coefficients(
    robot: RobotStatics, batch: Batch, solutions: Sequence[Solution], link: str | None
) -> PayloadCoefficients:
    """Return the coefficients of a payload that is carried by ``link`` (None: the platform)."""
    twists, forces, wrenches = [], [], []
    for solution in solutions:
        units = _unit_payloads(robot, solution.frames, solution.gravity, link, _attachments(robot, solution))
        groups = tuple(statics.group for statics in solution.statics)
        none = np.zeros_like(solution.load)
        given = LoadedPoses(solution.frames, none, solution.gravity, applied=tuple(units), groups=groups)
        unit_solution = solve_with_springs(robot, given)
        payload = slice(unit_solution.contributions.index(units[0].name), unit_solution.contributions.index(units[-1].name) + 1)
        twists.append(unit_solution.twists[:, payload])
        at_joints = joint_contributions(robot, unit_solution)[:, :, payload]
        wrenches.append(at_joints)
        forces.append(actuator_forces_from(robot, unit_solution, at_joints))
    return PayloadCoefficients(
        PARAMETERS,
        batch.public(twists),
        ResultMapping({name: batch.public([chunk[name] for chunk in forces]) for name in forces[0]}),
        ResultMapping({name: batch.public([chunk[:, k] for chunk in wrenches]) for name, k in joints_in_order(robot)}),
    )


def _attachments(robot: RobotStatics, solution: Solution) -> Mapping[str, Mask]:
    """Return the bodies that carry the payload at some pose, each with a mask (N,): True at poses where this body carries it."""
    everywhere = np.ones(solution.o.shape[1], dtype=bool)
    for applied in solution.applied:
        if applied.load.name == PAYLOAD:
            several = len(applied.load.wrenches) > 1
            return {name: np.any(w != 0, axis=0) if several else everywhere for name, w in applied.load.wrenches.items()}
    return {robot.topology.platform.root: everywhere}


def _unit_payloads(
    robot: RobotStatics, frames: Frames, gravity: Array, link: str | None, attachments: Mapping[str, Mask]
) -> tuple[AppliedLoad, ...]:
    """Return the weight of 1 kg at the origin of the frame of ``link`` (None: o-xyz), and of 1 kg·m along each of its axes.

    ``attachments``: the bodies that carry the payload, from :func:`_attachments`.
    """
    _, o = robot.mechanism.platform_pose(frames)
    R, origin = link_frame(robot, link, frames)
    wrenches = [wrench_of_force(gravity, origin - o), *(wrench_of_couple(cross(R[:, k], gravity)) for k in range(3))]
    return tuple(
        AppliedLoad(f"{PAYLOAD} {k}", {attachment: np.where(where, wrench, 0.0) for attachment, where in attachments.items()})
        for k, wrench in enumerate(wrenches)
    )
