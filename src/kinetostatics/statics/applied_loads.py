"""Loads that act at places of a robot other than its platform's o: on rigid links, and at the ends of beams.

A load at a place of a limb goes the way that weights go: the limb holds it by attached wrenches and sags under it. Each load is a
contribution of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics, limb_statics_under
from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames


@dataclass(frozen=True)
class AppliedLoad:
    """A load of N poses.

    Attributes:
        name: of its contribution.
        wrenches: (6, N) about o, world axes, by the place at which they act [N, N·m].
        points: (3, N) where a force acts [m], by the place, for pictures.
        kind: "load"; "spring", its force at the pose; or "change", a unit change of that, which acts as often as it is.
    """

    name: str
    wrenches: Mapping[str, Array]
    points: Mapping[str, Array] = field(default_factory=dict)
    kind: str = "load"

    def take(self, poses: Index | slice) -> AppliedLoad:
        """Return the load of some of the poses."""
        wrenches = {place: array[:, poses] for place, array in self.wrenches.items()}
        points = {place: array[:, poses] for place, array in self.points.items()}
        return AppliedLoad(self.name, wrenches, points, self.kind)

    def at(self, places: Iterable[str]) -> dict[str, Array]:
        """Return the wrenches that act at some places."""
        mine = set(places)
        return {place: wrench for place, wrench in self.wrenches.items() if place in mine}


@dataclass(frozen=True)
class AppliedStatics:
    """A load, and what it does to every group of limbs by itself.

    Attributes:
        load: the load.
        statics: for each group of limbs those under this load alone; None where it loads none of them.
        share: (S, N) how many times it belongs to each contribution.
    """

    load: AppliedLoad
    statics: tuple[LimbStatics | None, ...]
    share: Array

    @property
    def times(self) -> Array:
        """How many times it acts in all (N,)."""
        return np.asarray(self.share.sum(axis=0))


def applied_statics(
    loads: Iterable[AppliedLoad], groups: Iterable[LimbGroup], frames: Frames, o: Array, first: int, sources: int
) -> tuple[AppliedStatics, ...]:
    """Find what loads do to limbs by themselves; the first load's contribution has the number ``first``."""
    found, groups = [], list(groups)
    for number, load in enumerate(loads, first):
        mine = [load.at(place for limb in group.limbs for place in limb.places) for group in groups]
        parts = [limb_statics_under(group, frames, o, w) if w else None for group, w in zip(groups, mine, strict=True)]
        share = np.zeros((sources, o.shape[1]))
        share[number] = 1.0
        found.append(AppliedStatics(load, tuple(parts), share))
    return tuple(found)


def by_place(applied: Iterable[AppliedStatics]) -> dict[str, Array]:
    """Return what acts at each place in all (6, N), about o."""
    found: dict[str, Array] = {}
    for item in applied:
        for place, wrench in item.load.wrenches.items():
            found[place] = found.get(place, 0.0) + wrench * item.times
    return found


def of_contributions(applied: Iterable[AppliedStatics], pick: Callable[[AppliedStatics], Array | None], like: Array) -> Array:
    """Return what is picked of every load (…, N), a column for each contribution.

    Args:
        applied: the loads.
        pick: returns (A, …, N), or None for nothing.
        like: (A, S, …, N) what is added to: those of weights, which may have contributions more.
    """
    total = like
    for item in applied:
        part = pick(item)
        if part is not None:
            share = item.share.reshape(item.share.shape[0], *(1,) * (part.ndim - 2), item.share.shape[1])
            if total is like:
                total = np.array(like)
            total[:, : len(item.share)] += part[:, None] * share
    return total


def sum_of(applied: Iterable[AppliedStatics], places: Iterable[str] | None = None) -> Array:
    """Return the sum (6, N) of what acts at some places, about o; None: at all. Zeros (6, 1) where nothing does."""
    wrenches = by_place(applied)
    mine = [wrenches[place] for place in (wrenches if places is None else dict.fromkeys(places)) if place in wrenches]
    return np.sum(mine, axis=0) if mine else np.zeros((6, 1))
