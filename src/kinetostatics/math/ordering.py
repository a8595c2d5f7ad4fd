"""Order of numbers that may be equal within rounding, as in symmetric robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Relative difference up to which values count as equal: more than rounding errors of files.
EQUAL = 1e-6
#: Value, relative to the largest, that counts as rounding.
NOTHING = 1e-9


def first_largest(values: ArrayLike, margin: float = EQUAL) -> int:
    """Return the position of the first of the largest values, within a margin, of non-negative values (n,).

    Args:
        values: at least one value.
        margin: relative difference up to which two are equal.
    """
    values = np.asarray(values, dtype=np.float64)
    return int(np.argmax(values >= np.max(values) * (1 - margin)))


def ranked(values: ArrayLike, margin: float = EQUAL) -> list[int]:
    """Return the positions of non-negative values (n,), from the largest to the smallest; equal values keep their order.

    Values that are rounding errors relative to the largest count as equal.
    """
    values = np.asarray(values, dtype=np.float64)
    values = np.where(values > NOTHING * np.max(values, initial=0.0), values, 0.0)
    order = np.argsort(-values, kind="stable").tolist()
    result: list[int] = []
    while len(result) < len(order):
        rest = order[len(result) :]
        alike = int(np.argmin([*(values[rest] >= values[rest[0]] * (1 - margin)), False]))
        result += sorted(rest[: max(alike, 1)])
    return result


def axis_across(directions: ArrayLike) -> NDArray[np.float64]:
    """Return, for each unit vector (3, …), the axis x, y or z (3, …) with the largest angle to it; of equals, the first."""
    sizes = np.abs(np.asarray(directions, dtype=np.float64))
    with np.errstate(invalid="ignore"):
        farthest = np.argmax(sizes <= np.min(sizes, axis=0) + EQUAL, axis=0)
    return np.moveaxis(np.eye(3)[farthest], -1, 0)


def across(axis: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two unit vectors that complete the unit vector ``axis`` (3,) to a right-handed frame; x and y for the axis z."""
    second = np.cross(axis, axis_across(axis))
    second /= np.linalg.norm(second)
    return np.cross(second, axis), second
