"""Poses without valid numbers in figures: hatched grey areas; the legend gives the reasons.

The smooth border of an area is the zero line of a field over the grid of poses, which is positive inside the area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.path import Path
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.selection import Selection
from kinetostatics.plot.style import legend_below
from kinetostatics.status import Status


@dataclass(frozen=True)
class Mask:
    """Poses with missing values for one reason: its label, hatch pattern and grey; ``where`` is True at these poses."""

    label: str
    hatch: str
    face: str
    where: NDArray[np.bool_]


_LOOKS = {
    Status.UNREACHABLE: ("unreachable", "////", "0.93"),
    Status.LIMIT_EXCEEDED: ("beyond joint limits", "....", "0.93"),
    Status.SINGULAR: ("singular", "xxxx", "0.85"),
}
#: Look of NaN at a valid pose, such as an intensity of a degenerate basis.
_NOT_DETERMINED = ("not determined", "++++", "0.93")
_EDGE = "0.4"


def masks_of(values: Array, status: NDArray[np.int8]) -> list[Mask]:
    """Return a mask for each reason why ``values`` are missing (NaN)."""
    missing = np.isnan(values)
    areas: dict[tuple[str, str, str], NDArray[np.bool_]] = {}
    for reason in Status:
        where = missing & (status == reason)
        if where.any():
            look = _LOOKS.get(reason, _NOT_DETERMINED)
            areas[look] = areas.get(look, np.zeros_like(where)) | where
    return [Mask(*look, where) for look, where in areas.items()]


def common_masks(parts: Sequence[Selection]) -> list[Mask]:
    """Return the masks of poses at which the values of all selections are missing."""
    everywhere = np.all([np.isnan(part.values) for part in parts], axis=0)
    return masks_of(np.where(everywhere, np.nan, 0.0), parts[0].status)


def check_numbers(what: str, parts: Sequence[Selection], where: str) -> None:
    """Raise an error if no pose has a number."""
    if not any(np.isfinite(part.values).any() for part in parts):
        values = np.stack([part.values for part in parts])
        status = np.stack([part.status for part in parts])
        reasons = ", ".join(mask.label for mask in masks_of(values, status))
        raise ArgumentError(f"{what}: no pose of {where} has a number ({reasons})")


def areas_of(masks: Sequence[Mask]) -> list[NDArray[np.bool_]]:
    """Return the union of each mask with all later masks; areas drawn in this order have no gaps between them."""
    return [np.any([mask.where for mask in masks[k:]], axis=0) for k in range(len(masks))]


def draw_areas(ax: Axes, fields: Sequence[tuple[Array, Array, Array]], masks: Sequence[Mask]) -> None:
    """Hatch the area of each mask; ``fields`` contains x, y and the field (len x, len y) of each mask."""
    for field, mask in zip(fields, masks, strict=True):
        path = PathCollection(
            [area(ax, *field)], facecolors=mask.face, edgecolors=_EDGE, linewidths=0, hatch=mask.hatch, zorder=0.5
        )
        path.set_label(mask.label)
        ax.add_collection(path, autolim=False)
        x, y, values = field
        ax.contour(x, y, values.T, levels=[0.0], colors="0.3", linewidths=0.5, zorder=2)


def draw_ranges(ax: Axes, borders: Array, masks: Sequence[Mask]) -> None:
    """Hatch the cells in masks (n,) over one coordinate, from bottom to top; ``borders`` (n + 1,) separate the cells."""
    for mask in masks:
        steps = np.flatnonzero(np.diff(np.concatenate([[False], mask.where, [False]]).astype(np.int8)))
        for low, high in borders[steps].reshape(-1, 2):
            band = ax.axvspan(low, high, facecolor=mask.face, edgecolor=_EDGE, linewidth=0, hatch=mask.hatch, zorder=0.5)
            band.set_label(mask.label)


def legend_of(figure: Figure, masks: Sequence[Mask]) -> None:
    """Add a legend of masks below the figure; reasons that are in an earlier legend are omitted."""
    named = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    patches = [patch for patch in patches_of(masks) if patch.get_label() not in named]
    legend_below(figure, patches)


def patches_of(masks: Sequence[Mask]) -> list[Patch]:
    each = {mask.label: mask for mask in masks}.values()
    return [Patch(facecolor=m.face, edgecolor=_EDGE, hatch=m.hatch, linewidth=0.4, label=m.label) for m in each]


#: Number of smoothing steps (more would shrink the borders of discs), and least magnitude of the field at each pose.
ROUNDS, LEAST = 2, 0.05


def smooth_field(inside: NDArray[np.bool_], closed: bool = False) -> Array:
    """Return a smooth field over a grid of any dimension: 0 to 1 inside a mask, −1 to 0 outside; its zero is the border.

    Smoothing alone would remove thin parts. Therefore the sign at each pose is restored after each smoothing step, as in surface
    nets (S. F. F. Gibson, *Medical Image Computing and Computer-Assisted Intervention*, 1998).

    Args:
        inside: True at the poses in the mask.
        closed: whether the first axis is periodic.
    """
    sign = np.where(inside, 1.0, -1.0)
    field = sign
    for k in range(ROUNDS):
        for axis, size in enumerate(inside.shape):
            wide = np.pad(field, [(int(n == axis),) * 2 for n in range(field.ndim)], "wrap" if closed and axis == 0 else "edge")
            field = field / 2 + (wide.take(range(size), axis) + wide.take(range(2, size + 2), axis)) / 4
        kept = np.abs(field) if k == ROUNDS - 1 else sign * field  # the last step keeps the magnitude in thin parts
        field = sign * np.maximum(kept, LEAST)
    return field


def extrapolated(values: Array) -> Array:
    """Return values over a grid; missing values (NaN) beside known values are extrapolated linearly."""
    for _ in range(2):  # the second step covers corners
        total, count = np.zeros(values.shape), np.zeros(values.shape)
        for axis, size in enumerate(values.shape):
            wide = np.pad(values, [(2 * int(k == axis),) * 2 for k in range(values.ndim)], constant_values=np.nan)
            for near, far in ((1, 0), (3, 4)):
                first, second = (wide.take(range(at, at + size), axis) for at in (near, far))
                estimate = np.where(np.isfinite(second), 2 * first - second, first)
                there = np.isfinite(estimate)
                total[there] += estimate[there]
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
    """Return the border of the area in which a field (len x, len y) is positive, in data coordinates."""
    drawn = ax.contourf(x, y, field.T, levels=[0.0, 2.0])
    (path,) = drawn.get_paths()
    drawn.remove()
    return path
