"""An upper estimate of the largest ratio 1/λ of the forces to the critical forces, without eigenvalues.

A force f on a part of length r that turns by θ does the work f r θ² of second order, a moment M between two parts that turn by θ
and φ the work M θ φ, if θ and φ have different directions. A part turns by the deformation of its limb, at most as if its beams
and all elastic joints were in series; and with the platform, unless no passive joint separates it from the base. A beam between
passive joints turns with the platform as far as its ends are displaced. A beam between ball joints turns no other part by its
bending.

All works are added up, as are all compliances. The estimate is four times the ratio of a cantilever, and more for other robots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.stiffness_matrix import is_coupled
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined
from kinetostatics.math.screws import move_wrench
from kinetostatics.statics.geometric_stiffness import JunctionWrenches
from kinetostatics.statics.rotation_groups import BASE, PLATFORM, Junction
from kinetostatics.statics.small_motions import SmallMotions
from kinetostatics.statics.solution import Solution


@dataclass(frozen=True)
class _Springs:
    """Compliances of all elastic joints together: against rotations [rad/(N·m)], and against displacements [m/N].

    ``both``: whether there are both.
    """

    hinges: Array | float
    slides: Array | float
    both: bool

    @classmethod
    def of(cls, structure: SmallMotions) -> _Springs:
        # a force and a moment deform a joint that couples them at most twice as much as if it did not
        coupled = {k for joint in structure.joints if is_coupled(structure.stiffness_of(joint)) for k in joint.columns}
        compliance = {
            k: (1 + (k in coupled)) / item.stiffness for k, item in enumerate(structure.freedoms) if item and item.stiffness
        }
        compliance.update({item.column: item.times**2 * compliance[item.master] for item in structure.followers})
        turning = [k in structure.rotations for k in compliance]
        hinges, slides = (
            sum(c for c, turns in zip(compliance.values(), turning, strict=True) if turns == kind) for kind in (True, False)
        )
        return cls(hinges, slides, set(turning) == {True, False})


def estimate(structure: SmallMotions, solution: Solution) -> Array:
    """Return the estimate (N,)."""
    model, C = structure.model, solution.compliance
    limbs: dict[int, list[Junction]] = {}
    for item in structure.rotation_groups.junctions:
        limbs.setdefault(item.owner, []).append(item)
    loops = len(limbs) > 1 or not all(model.topology.all_limbs[number].is_serial for number in limbs)
    loads = [item.load for item in solution.applied]
    transmitted = JunctionWrenches(model, solution, loads, range(len(solution.contributions)), True)
    inside, outside, springs = np.zeros_like(C[0, 0]), np.zeros_like(C[0, 0]), _Springs.of(structure)
    plates = [model.elastic_links[str(edge.span)] for edges in model.topology.plates.values() for edge in edges]
    springs = replace(springs, hinges=springs.hinges + sum(link.turning_compliance(solution.frames) for link in plates))
    for junctions in limbs.values():
        with np.errstate(divide="ignore", invalid="ignore"):  # the length of a telescopic beam may be zero
            own, by_platform = _of_limb(structure, solution, junctions, transmitted, springs, loops)
            inside, outside = np.maximum(inside, own), outside + by_platform
    found: Array = inside + outside
    return found


def _of_limb(
    structure: SmallMotions,
    solution: Solution,
    junctions: Sequence[Junction],
    transmitted: JunctionWrenches,
    springs: _Springs,
    loops: bool,
) -> tuple[Array, Array]:
    """Return what a limb adds to the estimate (N,) by its own deformation, and with the platform."""
    model, frames, o, C = structure.model, solution.frames, solution.o, solution.compliance
    spins = structure.rotation_groups.spins
    together = joined((BASE, PLATFORM), ((item.inner, item.outer) for item in junctions if not item.turns))
    on_base, on_platform = together[BASE], together[PLATFORM]  # groups that no passive rotation separates from them
    none = np.zeros_like(C[0, 0])
    arms: dict[str, Array] = {}  # of the junctions, by the keys of their edges
    # works per square of a rotation: on the base, on the platform, and elsewhere of moments, of rigid parts, and of beams
    fixed = carried = moments = levers = chords = none
    pinned = bent = none  # the same times compliances of beams
    soft, longest, strongest, slope, reach = none, none, none, none, none
    for item in junctions:
        arm = frames.point(item.centre.body, item.centre.vector) - o
        wrench, start = move_wrench(transmitted.on_outer_side(item), arm), arm
        force, moment = _size(wrench[:3]), _size(wrench[3:]) if item.inner != item.outer else none
        strongest, chord = np.maximum(strongest, force), none
        if item.outer == PLATFORM:
            carried = carried + force * _size(arm)
        if item.outer in on_platform:
            reach = np.maximum(reach, _size(arm))
        sides = {item.inner, item.outer}
        if item.edge.span is not None:
            link = model.elastic_links[item.edge.span]
            length, turning, start = link.length(frames), link.turning_compliance(frames), link.ends(frames)[0] - o
            weight = model.weights.sum([f"beam:{link.name}"], solution.weights)
            force = force + _size(weight[:3]) / 2  # in the middle
            chord, longest = length * force, np.maximum(longest, length)
            if loops and link.name in model.beams and item.inner in spins and item.outer in spins:
                pinned = np.maximum(pinned, (moment + chord) * turning)
            else:
                soft = soft + turning
        lever = none
        for point, attachment in zip((start, arm), item.attachments, strict=True):  # to the junctions of the parts on its sides
            key = structure.model.topology.carried_by.get(attachment)
            if key in arms:
                lever = lever + force * _size(point - arms[key])
        arms[item.edge.key] = arm
        if not loops or sides <= on_base:  # only beams nearer to the base turn it
            fixed, bent = fixed + moment + lever + chord, bent + (moment + lever + chord) * soft
        elif sides <= on_platform:
            carried = carried + moment + lever + chord
        else:
            moments, levers, chords = moments + moment, levers + lever, chords + chord
            slope = slope + (chord / length**2 if item.edge.span else none)
    longest = longest if any(item.edge.span for item in junctions) else none + model.length
    joints = springs.hinges + springs.slides / longest**2
    shift = (C[0, 0] + C[1, 1] + C[2, 2]) / longest**2
    series = soft + joints
    inside = bent + fixed * joints + carried * series + 2 * (moments + levers + chords) * series
    if springs.both:  # the work is at most the force times the root of both compliances, and that at most half their sum
        inside = inside + strongest * longest / 2 * series
    if not loops:  # the last part carries forces that act at a distance
        return inside + _size(wrench[:3]) * _farthest(structure, solution, arm) * series, none
    turned = C[3, 3] + C[4, 4] + C[5, 5]
    # the sum of the products of two principal compliances, of the platform's rotation and of rotations by its displacement
    products = sum(C[a, a] * C[b, b] - C[a, b] ** 2 for a, b in ((3, 4), (3, 5), (4, 5))) + 2 * shift * turned + 3 * shift**2
    outside = 2 * moments * np.sqrt(np.maximum(products, 0.0)) + 2 * levers * (turned + shift) + carried * turned
    return np.maximum(pinned, inside), outside + 2 * slope * (shift * longest**2 + reach**2 * turned)


def _farthest(structure: SmallMotions, solution: Solution, arm: Array) -> Array:
    """Return the largest distance (N,) [m] of a weight or force from a point at ``arm`` (3, N) from o."""
    centres = structure.model.weights.centres(solution.frames)
    heavy = [centres[:, w] for w in range(centres.shape[1]) if np.any(solution.weights[:3, w])]
    farthest = np.zeros_like(arm[0])
    for point in (solution.o, *heavy, *(point for item in solution.applied for point in item.load.points.values())):
        farthest = np.maximum(farthest, _size(point - solution.o - arm))
    return farthest


def _size(vector: Array) -> Array:
    found: Array = np.sqrt(np.sum(vector * vector, axis=0))
    return found
