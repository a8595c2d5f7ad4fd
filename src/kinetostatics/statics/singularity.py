"""Poses without equilibrium, and poses at which the rank of a limb changes.

A pose is singular if the platform can move with locked actuators, if a limb cannot carry its weight, or if a telescopic
beam has a negative length.

Ranks and bases are normally decided once per robot (method page, section 2). If a limb is stretched, or if two of its axes
coincide, its joint twists become dependent: its passive joints allow one motion less and it transmits one wrench more. The ranks
of the limb are then decided at that pose. The rank of its compliance may change too: a limb of which only the actuators are
elastic is compliant in the directions in which they move it; a stretched limb has fewer of these directions.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs import force_method
from kinetostatics.limbs.compliance import rigid_counts
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.grouping import decided_at
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import definite, normalize, numerical_rank
from kinetostatics.mechanism.limbs import carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.plates import Equilibrium
from kinetostatics.statics.robot_statics import RobotStatics

#: Smallest eigenvalue of the Gram matrix of all unit wrenches (a squared sine) above which the platform counts as constrained.
CONSTRAINED = 1e-12
#: Largest unbalanced fraction of a limb's weight on its passive joints.
UNBALANCED = 1e-7


def where_singular(statics: Iterable[LimbStatics], balance: Equilibrium, unbalanced: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Return a mask (N,): True where the platform can still move, or a limb or branch is not in equilibrium with its loads."""
    return without_equilibrium(balance.singular | ~is_constrained(statics, balance.scale, len(balance.singular)), unbalanced)


def without_equilibrium(singular: NDArray[np.bool_], unbalanced: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Return a mask (N,): True where ``singular`` is, or where a limb or branch is not in equilibrium with its loads."""
    for part in unbalanced.values():
        singular = singular | (part > UNBALANCED)
    return singular


def has_negative_length(robot: RobotStatics, frames: Frames) -> NDArray[np.bool_]:
    result = np.zeros(frames.position.shape[2], dtype=bool)
    for beam in robot.elastic_links.values():
        if beam.telescopic:
            result |= beam.remaining_length(frames) < 0
    return result


def any_limb(groups: Sequence[NDArray[np.bool_]], N: int) -> NDArray[np.bool_]:
    """Return a mask (N,): True where any limb has True in the masks ``groups``, one (g, N) for each group of g limbs."""
    found = np.zeros(N, dtype=bool)
    for group in groups:
        found |= np.any(group, axis=0)
    return found


def is_constrained(statics: Iterable[LimbStatics], scale: Array, N: int) -> NDArray[np.bool_]:
    """Return a mask (N,): True where no motion of the platform is free, as Σ ŵ ŵᵀ of all unit wrenches ŵ is definite."""
    gram = np.zeros((6, 6, N))
    for item in statics:
        unit = normalize(item.J_c[:, : len(item.group.basis.constraint)] * scale[:, None, None, None])
        gram += np.einsum("ikgn,jkgn->ijn", unit, unit)
    return definite(gram, CONSTRAINED)


def unbalanced_parts(
    robot: RobotStatics,
    frames: Frames,
    o: Array,
    weights: Array,
    statics: Iterable[LimbStatics],
    loads: Mapping[str, Array],
) -> dict[str, Array]:
    """Return, by limb, the fraction |residual of Eq. (3)| / Σ |weights and ``loads``| (N,) that its passive joints cannot carry.

    Open branches belong to the limb that carries them, or to ``base`` or ``platform``, which are further keys.
    """
    sizes = {attachment: _size(wrench, robot.length) for attachment, wrench in loads.items()}
    result: dict[str, Array] = {}
    for item in statics:
        for position, limb in enumerate(item.group.limbs):
            own = weights[:3, robot.weights.of(limb.name)]
            total = np.sqrt(np.sum(own**2, axis=0)).sum(axis=0)
            total = sum((size for attachment, size in sizes.items() if attachment in limb.attachments), total)
            left = np.max(np.abs(item.unbalanced[:, position]), axis=0, initial=0.0)
            result[limb.name] = left / np.where(total > 0, total, 1.0)
    for branch in robot.passive_branch_joints:
        carried = np.einsum("w,iwn->in", branch.outboard, weights)
        total = np.sqrt(np.sum((weights[:3] * branch.outboard[:, None]) ** 2, axis=0)).sum(axis=0)
        for attachment, wrench in loads.items():
            if carries(branch.edge, attachment):
                carried, total = carried + wrench, total + sizes[attachment]
        power = np.abs(np.einsum("ikn,in->kn", branch.twists(frames, o), carried)) / branch.scale[:, None]
        part = np.max(power, axis=0, initial=0.0) / np.where(total > 0, total, 1.0)
        result[branch.owner] = np.maximum(result.get(branch.owner, 0.0), part)
    return result


def _size(wrench: Array, length: float) -> Array:
    """Return the magnitudes (N,) [N] of wrenches (6, N) about o, with moments divided by ``length`` [m]."""
    found: Array = np.sqrt(np.sum(wrench[:3] ** 2, axis=0)) + np.sqrt(np.sum(wrench[3:] ** 2, axis=0)) / length
    return found


def groups_of_poses(
    robot: RobotStatics, frames: Frames, o: Array, statics: tuple[LimbStatics, ...]
) -> dict[int, tuple[LimbGroup, ...]]:
    """Return the groups of limbs at every pose at which a limb has other ranks than at generic poses, by index of the pose.

    ``statics`` has the statics of N poses for the groups of generic poses.
    """
    stiffening = [k for k, item in enumerate(statics) if item.group.partly_elastic]
    stiffening = [k for k in stiffening if statics[k].may_stiffen.any()]
    if not stiffening and not any([item.doubtful.any() for item in statics]):
        return {}
    doubtful = np.zeros(o.shape[1], dtype=bool)
    for item in statics:
        doubtful |= np.any(item.doubtful, axis=0)
    rigid: dict[int, NDArray[np.intp]] = {}
    for k in stiffening:
        item = statics[k]
        at = np.flatnonzero(np.any(item.may_stiffen, axis=0))
        rigid[k] = np.full(item.may_stiffen.shape, item.group.rigid_directions)
        rigid[k][:, at] = rigid_counts(item.C[..., at])
        doubtful |= np.any(rigid[k] != item.group.rigid_directions, axis=0)
    if not np.any(doubtful):
        return {}
    found = {}
    for pose in np.flatnonzero(doubtful & np.all(np.isfinite(o), axis=0)).tolist():
        here = frames.take(np.array([pose]))
        if not here.are_finite()[0]:
            continue
        changed = {number for item in statics for number in _changed(item, here, o[:, [pose]], pose)}
        counts_of = {
            number: int(count)
            for k, counts in rigid.items()
            for number, count in zip(statics[k].group.numbers, counts[:, pose], strict=True)
            if count != statics[k].group.rigid_directions
        }
        if changed or counts_of:
            found[pose] = tuple(group for item in statics for group in _regrouped(robot, item.group, changed, counts_of, here))
    return found


def parts_of_batch(
    robot: RobotStatics, frames: Frames, o: Array, statics: tuple[LimbStatics, ...], doubtful: NDArray[np.bool_]
) -> list[tuple[slice, tuple[LimbGroup, ...] | None]]:
    """Divide a batch into poses at which all limbs have their usual ranks, and single poses with their own groups of limbs.

    ``statics`` has the statics of N poses for the groups of generic poses; at ``doubtful`` poses (N,), ranks may differ.
    """
    N = o.shape[1]
    special: dict[int, tuple[LimbGroup, ...]] = {}
    if doubtful.any() and frames.take(np.flatnonzero(doubtful)).are_finite().any():
        special = groups_of_poses(robot, frames, o, statics)
    ends = sorted({0, N, *special, *(pose + 1 for pose in special)})
    return [(slice(start, end), special.get(start)) for start, end in itertools.pairwise(ends)] or [(slice(0, 0), None)]


def _changed(item: LimbStatics, frames: Frames, o: Array, pose: int) -> list[int]:
    """Return the limbs of a group, by index in the robot, whose ranks at one pose differ from their ranks at generic poses."""
    group, tolerance = item.group, item.group.model.rank_tolerance
    places = np.flatnonzero(item.doubtful[:, pose]).tolist()
    if not places:
        return []
    geometry = group.geometry(frames, o)
    if group.is_serial:
        usual = (6 - len(group.basis.constraint), len(group.basis.carried))
    else:
        assert group.elimination is not None
        usual = (len(group.elimination.joints), len(group.elimination.platform))
        A = group.joint_equations(geometry)
    found = []
    for place in places:
        twists = group.even_twists(geometry)[:, :, place, 0]
        if group.is_serial:
            passive, carried = twists[:, group.passive], twists[:, group.platform_joint]
            ranks = numerical_rank(passive, tolerance)[0], numerical_rank(carried, tolerance)[0]
        else:
            ranks = force_method.ranks(A[:, :, place], group.platform_sum, tolerance)
        if ranks != usual:
            found.append(group.numbers[place])
    return found


def _regrouped(
    robot: RobotStatics, group: LimbGroup, changed: set[int], rigid: Mapping[int, int], frames: Frames
) -> list[LimbGroup]:
    """Return the limbs of a group as several groups, because the decisions on some limbs change at one pose.

    Args:
        changed: indices of limbs whose ranks change; they get new bases.
        rigid: number of rigid directions, by index of the limb; only for limbs with a new number.
    """
    if not (changed | rigid.keys()).intersection(group.numbers):
        return [group]
    result = []
    for place, number in enumerate(group.numbers):
        alone = group.alone(place)
        alone.rigid_directions = rigid.get(number, group.rigid_directions)
        result.append(decided_at(robot, number, frames) if number in changed else alone)
    return result
