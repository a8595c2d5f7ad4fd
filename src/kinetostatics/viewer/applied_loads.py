"""Forces on links other than the load at o and weights: loads on links, the payload's weight, springs."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.viewer.shown_poses import ShownPoses, moved_wrench


def loads_on_links(poses: ShownPoses, kinds: Collection[str]) -> Iterator[tuple[str, str, Array, Array]]:
    """Yield contribution, place, point (F, 3) and wrench (F, 6) about o of loads on links; kinds are "load" and "spring"."""
    solutions, shape, take = poses.result.solutions, poses.result.shape, poses.take
    for k, item in enumerate(solutions[0].applied):
        if item.load.kind not in kinds:
            continue
        loads = [s.applied[k].load for s in solutions]
        nothing = [np.zeros((6, s.o.shape[1])) for s in solutions]
        for place in dict.fromkeys(place for load in loads for place in load.wrenches):  # a place need not be loaded at all poses
            point = [load.points.get(place, none[:3]) for load, none in zip(loads, nothing, strict=True)]
            wrench = [load.wrenches.get(place, none) for load, none in zip(loads, nothing, strict=True)]
            both = [take(np.concatenate(parts, axis=-1).T.reshape(*shape, -1)) for parts in (point, wrench)]
            yield item.load.name, place, both[0], both[1]


def about_point(wrench: Array, point: Array, o: Array, size: float) -> Array:
    """Return wrenches (F, 6) about o as wrenches about points (F, 3), with rounding errors of moments set to zero."""
    found = moved_wrench(wrench, point - o)
    found[:, 3:] = np.where(np.abs(found[:, 3:]) > 1e-9 * size * np.abs(wrench[:, :3]).max(initial=0.0), found[:, 3:], 0.0)
    return found
