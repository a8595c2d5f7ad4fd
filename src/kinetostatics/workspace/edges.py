"""Candidates for jumps to another assembly mode: edges between neighbours on the grid with unusually large joint steps.

Joint coordinates are continuous functions of the prescribed ones, so that steps between neighbours on the grid vary little.
Edges with a much larger step than adjacent ones are then checked by :mod:`kinetostatics.workspace.continuity`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, Index, Mask

Single = NDArray[np.float32]

#: A step is suspect if it differs from an adjacent one by more than BESIDE times the smaller of both plus USUAL times the median.
BESIDE, USUAL = 0.5, 0.2
#: A step without adjacent steps is suspect if it exceeds LARGE times the median.
LARGE = 4.0
#: Scaled difference [rad] up to which two poses are the same.
SAME = 1e-6


@dataclass(frozen=True, eq=False)
class JointScale:
    """Scale of differences between model coordinates: lengths are divided by the characteristic length, full turns are ignored.

    Attributes:
        weights: (nq,) factors.
        angles: (nq,) mask of angles.
    """

    weights: Array
    angles: Mask

    def difference(self, first: Array, second: Array) -> Array:
        """Return the largest scaled difference (…) of two poses (…, nq) [rad]; NaN where a pose is not reached."""
        gap = (second - first) * self.weights
        gap = np.abs(np.where(self.angles, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap))
        return np.asarray(gap.max(axis=-1)) if gap.shape[-1] else np.zeros(gap.shape[:-1])


@dataclass(frozen=True, eq=False)
class Edges:
    """Pairs of neighbours on a grid, by flat indices."""

    first: Index
    second: Index

    def __len__(self) -> int:
        return len(self.first)

    def where(self, chosen: Mask) -> Edges:
        """Return the edges of a mask."""
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
    # coordinates along the first axis, for speed; single precision is enough here
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
    """Return the mask of suspect steps (n − 1, …) of joints (nq, n, …) along the first axis; ``both``: both poses are reached."""
    step = np.zeros(both.shape, dtype=np.float32)
    turn = np.zeros((both.shape[0] - 1, *both.shape[1:]), dtype=np.float32)  # difference between consecutive steps
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
    alone = both.copy()  # steps without adjacent steps
    alone[1:] &= ~pair
    alone[:-1] &= ~pair
    return np.asarray(suspect & ~(alone & (step <= LARGE * usual)))
