"""Smooth borders of masks on a grid, as zero lines of a field that separates the poses."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

#: Number of smoothing steps (more would shrink the borders of discs), and least magnitude of the field at each pose.
ROUNDS, LEAST = 2, 0.05


def level_of(inside: NDArray[np.bool_], closed: bool = False) -> Array:
    """Return a smooth field over a grid of any dimension, positive (up to 1) inside a mask and negative (to −1) outside.

    Its zero is the border. Plain smoothing would lose thin parts; here the sign at each pose is restored after each step, as in
    surface nets (S. F. F. Gibson, *Medical Image Computing and Computer-Assisted Intervention*, 1998).

    Args:
        inside: mask of the poses.
        closed: whether the first axis is periodic.
    """
    sign = np.where(inside, 1.0, -1.0)
    field = sign
    for k in range(ROUNDS):
        for axis, size in enumerate(inside.shape):
            wide = np.pad(field, [(int(n == axis),) * 2 for n in range(field.ndim)], "wrap" if closed and axis == 0 else "edge")
            field = field / 2 + (wide.take(range(size), axis) + wide.take(range(2, size + 2), axis)) / 4
        kept = np.abs(field) if k == ROUNDS - 1 else sign * field  # last step: no loss of magnitude in thin parts
        field = sign * np.maximum(kept, LEAST)
    return field


def continued(values: Array) -> Array:
    """Return values over a grid, extrapolated linearly to neighbouring poses without a value."""
    for _ in range(2):  # the second step covers corners
        total, count = np.zeros(values.shape), np.zeros(values.shape)
        for axis, size in enumerate(values.shape):
            wide = np.pad(values, [(2 * int(k == axis),) * 2 for k in range(values.ndim)], constant_values=np.nan)
            for near, far in ((1, 0), (3, 4)):
                one, two = (wide.take(range(at, at + size), axis) for at in (near, far))
                found = np.where(np.isfinite(two), 2 * one - two, one)
                there = np.isfinite(found)
                total[there] += found[there]
                count += there
        mean = np.divide(total, count, out=np.full(values.shape, np.nan), where=count > 0)
        values = np.where(np.isfinite(values), values, mean)
    return values


def edges(values: Array) -> Array:
    """Return the borders (n + 1,) of cells around sorted values (n,)."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def area(ax: Axes, x: Array, y: Array, field: Array) -> Path:
    """Return the area in which a field (len x, len y) is positive, in data coordinates."""
    drawn = ax.contourf(x, y, field.T, levels=[0.0, 2.0])
    (path,) = drawn.get_paths()
    drawn.remove()
    return path


def draw_rim(ax: Axes, x: Array, y: Array, field: Array) -> None:
    """Draw the line at which a field (len x, len y) is 0."""
    ax.contour(x, y, field.T, levels=[0.0], colors="0.3", linewidths=0.5, zorder=2)
