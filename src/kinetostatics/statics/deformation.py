"""Displacements of all links and beams under load, for each contribution to the platform's twist (axis S).

The motions of the passive joints follow from the platform's twist and the deformations of the beams. The motions of joints and
beams add up from base to platform. Arrays of equal limbs are ``(component, S, limb, pose)``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.actuator import BranchJoint
from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import least_squares
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.statics.link_loads import with_contributions
from kinetostatics.statics.plates import Plates, places_of
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution


@dataclass(frozen=True)
class ElasticDeformation:
    """Deformation of one beam, joint or actuator in each of g equal limbs, or the assembly error of one joint or beam.

    Attributes:
        kind: ``beams``, ``joints``, ``actuators`` or ``assembly_errors``.
        names: name of the beam or joint in each limb.
        group, number: the group that contains the limbs, and its index.
        positions: indices of the g limbs in the group.
        cut_signs: (M,) sign of each cut-joint wrench in the wrench that the beam or joint transmits; 0 if it is not part of it.
        motion: (6, g, N) twist of the outboard side relative to the inboard side about o [m, rad], the sum of all contributions.
    """

    kind: str
    names: tuple[str, ...]
    group: LimbGroup
    number: int
    positions: tuple[int, ...]
    cut_signs: NDArray[np.int8]
    motion: Array


@dataclass(frozen=True)
class Deformation:
    """Displacements at N poses; twists are about o, world axes.

    Attributes:
        motions: by key of each joint and beam, the twist (6, S, N) of its outboard side.
        elastic: deformations and assembly errors in the limbs.
        actuator_deformations: by joint, the deformation (S, N) of its elastic actuator along the joint's coordinate [m, rad].
        spring_energy: (N,) strain energy of all elastic joints and actuators of the limbs [J].
    """

    motions: dict[str, Array]
    beams: list[LoadedBeams]
    elastic: list[ElasticDeformation]
    actuator_deformations: dict[str, Array]
    spring_energy: Array

    @cached_property
    def places(self) -> Mapping[str, tuple[int, int]]:
        """By name of a beam: the index of its entry in ``beams``, and the index of the beam in this entry."""
        return {name: (k, position) for k, stack in enumerate(self.beams) for position, name in enumerate(stack.names)}


def deform(robot: RobotStatics, solution: Solution) -> Deformation:
    """Return the displacements of all parts in an equilibrium, by contribution."""
    out = Deformation({}, [], [], {}, zeros_for((solution.o.shape[1],), solution.o))
    if robot.topology.plates:
        _deform_plates(robot, solution, out)
    for number in range(len(solution.statics)):
        _deform_limbs(solution, number, out)
    S = len(solution.contributions)
    branches: list[tuple[tuple[Edge, ...], int, int, Array | None]]
    branches = [(limb.branches, 2 + k, solution.place_of_strains(k), None) for k, limb in enumerate(robot.topology.limbs)]
    hanging = [(limb.branches, 1 if limb.on_platform else S) for limb in robot.topology.hanging]
    on_base, on_platform = (part.edges[len(part.plate) :] for part in (robot.topology.base, robot.topology.platform))
    branches += [(edges, own, own, None) for edges, own in (*hanging, (on_base, S))]
    branches.append((on_platform, 1, 1, solution.twists))
    moved = _deform_branch_actuators(robot, solution, [(edges, strains) for edges, _, strains, _ in branches], out)
    for edges, forces, strains, root in branches:
        if edges:
            _deform_branches(robot, solution, edges, forces, strains, root, moved, out)
    along = [(solution.contributions.index(item.load.name), item.load.lines) for item in solution.applied if item.load.lines]
    if along:
        out.beams[:] = [stack.with_lines(along) for stack in out.beams]
    return out


def _deform_plates(robot: RobotStatics, solution: Solution, out: Deformation) -> None:
    """Compute the motions of the interfaces of an elastic base and platform and add them to ``out``."""
    plates, count = Plates(robot, solution.frames, solution.o, solution.statics), len(solution.contributions)
    places = places_of(solution.contributions, [solution.place_of_strains(k) for k in range(len(robot.topology.limbs))])
    statics = [solution.statics_of_weights(number) for number in range(len(solution.statics))]
    wrenches = plates.by_weights(statics, solution.weights, places, count)
    for more in (plates.by_intensities(solution.intensities), plates.by_loads(solution.applied, count)):
        wrenches = [mine + other for mine, other in zip(wrenches, more, strict=True)]
    displaced = plates.displacements(wrenches, solution.gravity, solution.assembly_errors, places)
    for role, placed, (forces, moved, twists) in zip(robot.topology.plates, plates.placed, displaced, strict=True):
        out.spring_energy[:] += placed.strain_energy(forces.sum(axis=1), moved.sum(axis=1)).sum(axis=0)
        edges, root = robot.topology.plates[role], solution.twists if role == "platform" else np.zeros_like(solution.twists)
        for edge, twist in zip(edges, np.split(twists, len(edges)), strict=True):
            out.motions[edge.key] = root + twist
            for number, item in enumerate(solution.statics):
                for position, limb in enumerate(item.group.numbers):
                    signs = np.zeros(len(item.group.to_platform), dtype=np.int8)
                    for other, cut, sign in edge.limb_cuts:
                        signs[cut] += sign * (other == limb)
                    if signs.any():
                        name, moved = (robot.topology.part_of(edge),), twist.sum(axis=1)[:, None]
                        out.elastic.append(ElasticDeformation("links", name, item.group, number, (position,), signs, moved))


def _deform_limbs(solution: Solution, number: int, out: Deformation) -> None:
    """Compute the motions of a group of limbs and add them to ``out``.

    Under the forces w of cut-joint wrenches, weights and loads an element deforms by u = F w + u_0, which moves all outboard
    parts by a twist t_e. From base to platform the twists add up: t_outer = t_inner + t_e + e + S q, with assembly errors e and
    the motions q of passive joints with unit twists S, see :func:`_joint_motions`.
    """
    statics = solution.statics_of_weights(number)
    group = statics.group
    geometry = group.geometry(solution.frames, solution.o)
    # forces and the strains that they cause may belong to different contributions
    cut_wrenches, share = solution.cut_wrenches(number, strains=True), solution.contribution_mask(group, strains=True)
    moved_share = solution.contribution_mask(group) - share
    S, g, N = cut_wrenches.shape[2:]
    elements, signs = group.elements[0], group.element_cut_signs
    # by element: twist (6, S, g, N) of all outboard parts due to its elasticity and its assembly error
    deformed: dict[int, Array] = {}
    beam_of: dict[int, LoadedBeams] = {}
    everyone = tuple(range(g))
    for e, (elastic, placed) in enumerate(zip(group.elastic, geometry.elements, strict=True)):
        weights, own = statics.loads.carried[e], statics.loads.own[e]
        carried = placed.carried(cut_wrenches) + _with_loads(solution, number, share * weights[:, None], e)
        forces = placed.forces(carried)
        displacements = placed.displacements(forces)
        if own is not None:
            displacements += placed.own_displacement(share * own[:, None])
        for k, motion in placed.motions(displacements):
            deformed[k] = deformed.get(k, 0.0) + motion
            out.elastic.append(
                ElasticDeformation(elastic.kind, elastic.names, group, number, everyone, signs[k], motion.sum(axis=1))
            )
        out.actuator_deformations.update(placed.travels(displacements))
        if not elastic.has_inside:
            out.spring_energy[:] += placed.strain_energy(forces.sum(axis=1), displacements.sum(axis=1)).sum(axis=0)
        elif own is not None:
            alone = placed.inside((placed.carried(statics.particular) + weights)[:, None], own[:, None])
            alone = alone.turned(alone.inner) if elements[k].turned else alone
            beam_of[k] = replace(placed.inside(carried, share * own[:, None]), axial_correction=moved_share * alone.axial_force())
    _add_assembly_errors(solution, number, deformed, beam_of, out)
    # motions of base and platform, by the elements that begin at them, and by the cut joints that end there
    root = np.zeros((6, S, g, N))
    if group.limbs[0].on_platform:
        root = root + solution.twists[:, :, None]
    keys = {
        k: [limb.edges[row[k].edges[0]].parent for limb, row in zip(group.limbs, group.elements, strict=True)]
        for k, element in enumerate(elements)
        if element.parent < 0
    }
    roots = {k: _of_plate(out, row, root) for k, row in keys.items() if any(row)}
    end = zeros_for((6, S, g, N), solution.twists)
    end[:, : solution.twists.shape[1]] += solution.twists[:, :, None]
    ends = [_of_plate(out, [limb.ports[cut] for limb in group.limbs], end) for cut in range(len(group.to_platform))]
    turned = _joint_motions(solution, statics, geometry, deformed, signs, roots, ends)
    # sum of the motions of all elements from base to platform
    motions: list[Array] = []
    for k, element in enumerate(elements):
        inner = motions[element.parent] if element.parent >= 0 else roots.get(k, root)
        outer = inner
        if k in beam_of:
            beam_of[k] = replace(beam_of[k], inner=inner)
        if k in deformed:
            outer = outer + deformed[k]
        for f in np.flatnonzero(group.compound_of == element.compound) if element.compound is not None else ():
            outer = outer + geometry.twists[:, None, f] * turned[f]
        motions.append(outer)
        for position, limb in enumerate(group.limbs):
            edges = group.elements[position][k].edges
            out.motions.update((limb.edges[edge].key, inner[:, :, position]) for edge in edges[:-1])
            out.motions[limb.edges[edges[-1]].key] = outer[:, :, position]
    for k, beams in beam_of.items():
        out.beams.append(beams.turned(motions[k]) if elements[k].turned else beams)


def _of_plate(out: Deformation, keys: Sequence[str | None], root: Array) -> Array:
    """Return ``root`` (6, S, g, N) with the motion of an elastic base or platform where limbs have a key of its edges."""
    if not any(keys):
        return root
    found = zeros_for(root.shape, root, *(out.motions[key] for key in keys if key))
    found[:] = root
    for position, key in enumerate(keys):
        if key:
            motion = out.motions[key]
            found[:, : motion.shape[1], position] = motion
    return found


def _with_loads(solution: Solution, number: int, weights: Array, element: int) -> Array:
    """Add loads on links to what one elastic element of each limb carries (c, S, g, N) under weights.

    Args:
        number, element: indices of the group of limbs and of the element.
    """
    parts = [item.statics[number] for item in solution.applied]
    loads = [None if part is None else part.loads.carried[element] for part in parts]
    return with_contributions(weights, solution.applied, loads)


def _add_assembly_errors(
    solution: Solution, number: int, deformed: dict[int, Array], beam_of: dict[int, LoadedBeams], out: Deformation
) -> None:
    """Add the assembly errors of a group of limbs to ``deformed`` and ``beam_of``, both by element, and to ``out.elastic``."""
    statics, errors, assembly_errors = solution.statics[number], solution.errors[number], solution.assembly_errors
    if errors is None or assembly_errors is None:
        return
    group = statics.group
    S = solution.contribution_mask(group).shape[0]
    signs, number_of_errors = group.element_cut_signs, solution.contributions.index("assembly_errors")
    for k in range(errors.shape[1]):
        if np.any(errors[:, k]):
            more = np.zeros((6, S, *errors.shape[2:]))
            more[:, number_of_errors] = errors[:, k]
            deformed[k] = deformed.get(k, 0.0) + more
            if k in beam_of:
                stretch = np.zeros((S, *errors.shape[2:]))
                stretch[number_of_errors] = np.einsum("ign,ign->gn", beam_of[k].axes[:, 0], errors[:3, k])
                beam_of[k] = replace(beam_of[k], stretch=stretch)
    for position, limb in enumerate(group.limbs):
        for k, element in enumerate(group.elements[position]):
            for edge in (limb.edges[index] for index in element.edges):
                if assembly_errors.concerns(edge):
                    motion = assembly_errors.of_edge(edge, solution.frames, solution.o)[:, None]
                    name = group.model.topology.part_of(edge)
                    out.elastic.append(
                        ElasticDeformation("assembly_errors", (name,), group, number, (position,), signs[k], motion)
                    )


def _joint_motions(
    solution: Solution,
    statics: LimbStatics,
    geometry: LimbGeometry,
    deformed: Mapping[int, Array],
    signs: NDArray[np.int8],
    roots: Mapping[int, Array],
    ends: Sequence[Array],
) -> Array:
    """Solve for the motions q (k, S, g, N) of k freedoms of joints that keep the limbs connected; local freedoms do not move.

    Σ ± S_j q_j = gap − Σ ± t_e for each cut joint, in the sense of least squares, with the twist of the platform, or 0, as gap.
    The motions ``roots`` of an elastic base count among the t_e; ``ends`` are the twists of the platform at the cut joints.
    The edges that transmit the wrench of a cut joint form either a path to the platform, along which the motions add up to the
    motion of the platform, or a ring, around which they add up to zero.
    """
    group = statics.group
    M, (S, g, N) = len(group.to_platform), ends[0].shape[1:] if ends else (0, *geometry.limb_axes.shape[2:])
    turned = zeros_for((len(group.passive), S, g, N), solution.twists)
    passive = np.flatnonzero(group.passive)
    if not passive.size or not M:
        return turned
    gap = zeros_for((M, 6, S, g, N), solution.twists)
    for number in np.flatnonzero(group.to_platform).tolist():
        gap[number] = ends[number]
    for k, motion in (*deformed.items(), *roots.items()):
        for cut in np.flatnonzero(signs[k]):
            gap[cut] -= signs[k, cut] * motion
    scale = np.array([1 / group.model.length] * 3 + [1.0] * 3).reshape(6, 1, 1, 1)
    twists = geometry.twists[:, passive] * scale
    A = (group.dof_cut_signs[passive].T[:, None, :, None, None] * twists).reshape(6 * M, len(passive), g, N)
    left = (gap * scale[None]).reshape(6 * M, S, g, N)
    sizes = np.sqrt(np.sum(A * A, axis=0))
    sizes = np.where(sizes > 0, sizes, 1.0)
    A = A / sizes
    rank = 6 - statics.J_c.shape[1] if group.elimination is None else len(group.elimination.joints)
    result = np.zeros((len(passive), S, g, N))
    for _ in range(2):  # the second round removes the error of the normal equations
        step = least_squares(A, left, len(passive) - rank)
        result = result + step
        left = left - np.einsum("ij...,js...->is...", A, step)
    turned[passive] = result / sizes[:, None]
    return turned


def _deform_branches(
    robot: RobotStatics,
    solution: Solution,
    edges: tuple[Edge, ...],
    forces: int,
    strains: int,
    root: Array | None,
    moved: Mapping[str, tuple[str, BranchJoint]],
    out: Deformation,
) -> None:
    """Compute the motions of open branches, which are chains of links with a free end: t_outer = t_inner + t_e + s c f + e.

    t_e is due to u = F w + u_0, and s c f to elastic actuators, see :mod:`kinetostatics.elements.actuator`.

    Args:
        edges: joints and beams of the branches, inboard ones first.
        forces: index of the contribution of the branches' weight. The weight of branches on the base displaces nothing else and
            is no contribution; its index is the number of contributions.
        strains: index of the contribution that contains the deflection of the branches under their own weight.
        root: (6, S, N) twist of the body that carries edges without :attr:`Edge.parent`; None if this body is fixed.
        moved: by key of each joint that an elastic actuator moves: the actuator's name, and the joint.
        out: receives motions and beams.
    """
    frames, assembly_errors = solution.frames, solution.assembly_errors
    share, axial_correction = np.zeros((2, max(len(solution.contributions), forces + 1), 1, 1))
    share[strains] = 1
    axial_correction[forces] += 1
    axial_correction[strains] -= 1
    shifts: dict[str, Array] = {}  # of the outer ends, by edge
    still, no_freedoms = np.zeros((6, len(share), solution.o.shape[1])), np.zeros((6, 0, 1, solution.o.shape[1]))
    for edge in edges:
        if edge.parent is None:
            motion = still if root is None else root
        else:
            motion = out.motions[edge.parent]
            motion = np.concatenate([motion, still[:, motion.shape[1] :]], axis=1)
        off = np.zeros((6, len(share), solution.o.shape[1]))
        if assembly_errors is not None and assembly_errors.concerns(edge):
            off[:, solution.contributions.index("assembly_errors")] = assembly_errors.of_edge(edge, frames, solution.o)
        for element, ends in robot.branch_elements.get(edge.key, ()):
            own = robot.weights.carried_by(edge, solution.weights)
            weights = [robot.weights.carried_by(end, solution.weights)[:, None] * share[:, 0] for end in ends]
            pairs = zip(ends, weights, strict=True)
            carried = np.concatenate([_with_branch_loads(solution, end, weight) for end, weight in pairs])[:, :, None]
            placed = element.placed(frames, solution.o, no_freedoms)
            displacements, weight = placed.displacements(placed.forces(carried)), placed.own_load(solution.gravity)
            load = None if weight is None else share * weight[:, None]
            if load is not None:
                displacements += placed.own_displacement(load)
            if element.has_inside and load is not None and placed.line is not None:
                x = placed.line[0]
                stretch, axial = np.einsum("ign,isn->sgn", x, off[:3]), np.einsum("ign,in->gn", x, own[:3])
                beams = replace(placed.inside(carried, load), inner=motion[:, :, None], stretch=stretch)
                out.beams.append(replace(beams, axial_correction=axial_correction * axial))
            for k, deformed in placed.motions(displacements):
                outer = ends[k].key
                shifts[outer] = shifts.get(outer, 0.0) + deformed[:, :, 0]
        motion = motion + shifts.get(edge.key, 0.0)
        if edge.key in moved:
            actuator, joint = moved[edge.key]
            known = out.actuator_deformations[actuator][: len(share)]
            missing = np.zeros((len(share) - len(known), *known.shape[1:]))  # the actuator may have fewer contributions
            travel = np.concatenate([known, missing])
            motion = motion + joint.twist(frames, solution.o)[:, None] * travel
        out.motions[edge.key] = motion + off


def _deform_branch_actuators(
    robot: RobotStatics, solution: Solution, branches: Sequence[tuple[tuple[Edge, ...], int]], out: Deformation
) -> dict[str, tuple[str, BranchJoint]]:
    """Compute the deformations c Σ r_j s_jᵀ w_j of elastic actuators that move joints of open branches only, for ``out``.

    ``branches`` are the joints and beams, each tuple with its ``strains``; for this term and the result ``moved`` see
    :func:`_deform_branches`.
    """
    found: dict[str, tuple[str, BranchJoint]] = {}
    place_of = {edge.key: place for edges, place in branches for edge in edges}
    for actuator, joints in robot.branch_actuators:
        found |= {joint.edge.key: (actuator.joint, joint) for joint in joints}
        if actuator.joint in out.actuator_deformations:
            continue
        force = np.zeros((len(solution.contributions) + 1, solution.o.shape[1]))
        for joint in joints:
            share = np.zeros((len(force), 1))
            share[place_of[joint.edge.key]] = 1
            own = robot.weights.carried_by(joint.edge, solution.weights)[:, None] * share
            carried = _with_branch_loads(solution, joint.edge, own)
            force = force + np.einsum("in,isn->sn", joint.twist(solution.frames, solution.o), carried)
        out.actuator_deformations[actuator.joint] = actuator.compliance * force
    return found


def _with_branch_loads(solution: Solution, edge: Edge, weights: Array) -> Array:
    """Add loads on links to the ``weights`` (6, S, N) that a joint or beam of an open branch carries."""
    loads = []
    for item in solution.applied:
        carried = [wrench for attachment, wrench in item.load.wrenches.items() if carries(edge, attachment)]
        loads.append(np.sum(carried, axis=0) if carried else None)
    return with_contributions(weights, solution.applied, loads)
