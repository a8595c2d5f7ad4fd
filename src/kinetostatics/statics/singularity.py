"""Poses without equilibrium: a free motion of the platform, a limb that cannot carry its weight, a telescope without length."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import definite, normalize
from kinetostatics.mechanism.limbs import carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.platform_equilibrium import PlatformEquilibrium
from kinetostatics.statics.robot_statics import RobotStatics

#: Smallest eigenvalue of the Gram matrix of all unit wrenches (a squared sine) above which the platform counts as constrained.
CONSTRAINED = 1e-12
#: Largest unbalanced fraction of a limb's weight on its passive joints.
UNBALANCED = 1e-7


def where_singular(
    statics: Iterable[LimbStatics], balance: PlatformEquilibrium, unbalanced: Mapping[str, Array]
) -> NDArray[np.bool_]:
    """Return the mask (N,) of poses at which the platform can still move, or a limb is not in equilibrium with its weight."""
    return without_equilibrium(balance.singular | ~is_constrained(statics, balance.scale, len(balance.singular)), unbalanced)


def without_equilibrium(singular: NDArray[np.bool_], unbalanced: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Return ``singular`` (N,), extended by the poses at which a limb or branch is not in equilibrium with its loads."""
    for part in unbalanced.values():
        singular = singular | (part > UNBALANCED)
    return singular


def has_negative_length(robot: RobotStatics, frames: Frames) -> NDArray[np.bool_]:
    """Return the mask (N,) of poses at which the length of a telescopic beam is not positive."""
    result = np.zeros(frames.position.shape[2], dtype=bool)
    for beam in robot.beams.values():
        if beam.telescopic:
            result |= beam.remaining_length(frames) < 0
    return result


def any_limb(groups: Sequence[NDArray[np.bool_]], N: int) -> NDArray[np.bool_]:
    """Return the mask (N,) of poses at which any limb satisfies a condition, from the masks (g, N) of the groups."""
    found = np.zeros(N, dtype=bool)
    for group in groups:
        found |= np.any(group, axis=0)
    return found


def is_constrained(statics: Iterable[LimbStatics], scale: Array, N: int) -> NDArray[np.bool_]:
    """Return the mask (N,) of poses with a constrained platform, by the smallest eigenvalue of the wrenches' Gram matrix."""
    gram = np.zeros((6, 6, N))
    for item in statics:
        unit = normalize(item.J_c * scale[:, None, None, None])
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
    """Return, by limb and branch, the fraction (N,) of its weight and ``loads`` that its passive joints cannot carry."""
    sizes = {place: _size(wrench, robot.length) for place, wrench in loads.items()}
    result: dict[str, Array] = {}
    for item in statics:
        for position, limb in enumerate(item.group.limbs):
            own = weights[:3, robot.weights.of(limb.name)]
            total = np.sqrt(np.sum(own**2, axis=0)).sum(axis=0)
            total = sum((size for place, size in sizes.items() if place in limb.places), total)
            left = np.max(np.abs(item.unbalanced[:, position]), axis=0, initial=0.0)
            result[limb.name] = np.maximum(result.get(limb.name, 0.0), left / np.where(total > 0, total, 1.0))
    for branch in robot.open_branches:
        carried = np.einsum("w,iwn->in", branch.outboard, weights)
        total = np.sqrt(np.sum((weights[:3] * branch.outboard[:, None]) ** 2, axis=0)).sum(axis=0)
        for place, wrench in loads.items():
            if carries(branch.edge, place):
                carried, total = carried + wrench, total + sizes[place]
        power = np.abs(np.einsum("ikn,in->kn", branch.twists(frames, o), carried)) / branch.scale[:, None]
        part = np.max(power, axis=0, initial=0.0) / np.where(total > 0, total, 1.0)
        result[branch.owner] = np.maximum(result.get(branch.owner, 0.0), part)
    return result


def _size(wrench: Array, length: float) -> Array:
    """Return the magnitude (N,) of wrenches (6, N) about o [N], moments divided by the length."""
    found: Array = np.sqrt(np.sum(wrench[:3] ** 2, axis=0)) + np.sqrt(np.sum(wrench[3:] ** 2, axis=0)) / length
    return found
