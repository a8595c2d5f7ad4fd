"""Continuity between neighbours on the grid: an edge along which a joint jumps leads to another assembly mode.

Joint coordinates are continuous functions of the prescribed ones, so that steps between neighbours on the grid vary little. A
step that is much larger than the adjacent ones is checked: the path from one of the two poses is followed in small steps, and
either arrives at the other or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, Index, Mask

Single = NDArray[np.float32]

#: A step is suspect if it differs from those before and behind it by that part of the smaller of these and of the usual step.
BESIDE, USUAL = 0.5, 0.2
#: A step so much larger than usual is suspect where there are none beside it.
LARGE = 4.0
#: Scaled difference [rad] up to which two poses are the same.
SAME = 1e-6


@dataclass(frozen=True, eq=False)
class JointScale:
    """How differences of model coordinates are measured: lengths by the characteristic length, angles without full turns."""

    weights: Array
    angles: Mask

    def difference(self, first: Array, second: Array) -> Array:
        """Return the largest scaled difference (…) of two poses (…, nq) [rad]; NaN where there is none."""
        gap = (second - first) * self.weights
        gap = np.abs(np.where(self.angles, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap))
        return np.asarray(gap.max(axis=-1)) if gap.shape[-1] else np.zeros(gap.shape[:-1])


@dataclass(frozen=True, eq=False)
class Edges:
    """Pairs of neighbours on a grid, by their flat numbers."""

    first: Index
    second: Index

    def __len__(self) -> int:
        return len(self.first)

    def where(self, chosen: Mask) -> Edges:
        """Return some of them."""
        return Edges(self.first[chosen], self.second[chosen])


def neighbours(shape: Sequence[int]) -> Iterator[tuple[int, tuple[slice, ...], tuple[slice, ...]]]:
    """Yield each axis with the selections of the lower and the upper ends of its edges."""
    for axis, size in enumerate(shape):
        if size > 1:
            everything = [slice(None)] * len(shape)
            lower, upper = list(everything), list(everything)
            lower[axis], upper[axis] = slice(0, -1), slice(1, None)
            yield axis, tuple(lower), tuple(upper)


def suspect_edges(q: Array, reached: Mask, scale: JointScale) -> Edges:
    """Return the edges with unusually large steps.

    Args:
        q: (…grid, nq) model coordinates, NaN where not reached.
        reached: (…grid) mask of reached poses.
        scale: scale of differences.
    """
    # joints first, because a maximum over the last axis is slow; in single precision, which is enough to suspect
    joints = np.ascontiguousarray(np.moveaxis(q, -1, 0), dtype=np.float32)
    numbers = np.arange(reached.size).reshape(reached.shape)
    firsts, seconds = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)]
    for axis, lower, upper in neighbours(reached.shape):
        both = np.moveaxis(reached[lower] & reached[upper], axis, 0)
        if np.any(both):
            found = np.moveaxis(_suspect(np.moveaxis(joints, axis + 1, 1), both, scale), 0, axis)
            firsts.append(numbers[lower][found])
            seconds.append(numbers[upper][found])
    return Edges(np.concatenate(firsts), np.concatenate(seconds))


def _suspect(joints: Single, both: Mask, scale: JointScale) -> Mask:
    """Return which steps (n − 1, …) of joints (nq, n, …) along the first axis are suspect; ``both`` tells where there are any."""
    step = np.zeros(both.shape, dtype=np.float32)
    turn = np.zeros((both.shape[0] - 1, *both.shape[1:]), dtype=np.float32)  # how much a step differs from the next
    for row, weight, circular in zip(joints, scale.weights, scale.angles, strict=True):
        gap = (row[1:] - row[:-1]) * np.float32(weight)
        if circular:
            gap[gap > np.pi] -= 2 * np.pi
            gap[gap < -np.pi] += 2 * np.pi
        np.fmax(step, np.abs(gap), out=step)
        np.fmax(turn, np.abs(gap[1:] - gap[:-1]), out=turn)
    usual = float(np.median(step[both]))
    pair = both[1:] & both[:-1]
    odd = ~pair | (turn > BESIDE * np.minimum(step[1:], step[:-1]) + USUAL * usual)
    suspect = both & (step > SAME)
    suspect[1:] &= odd
    suspect[:-1] &= odd
    alone = both.copy()  # without a neighbour on its line
    alone[1:] &= ~pair
    alone[:-1] &= ~pair
    return np.asarray(suspect & ~(alone & (step <= LARGE * usual)))
