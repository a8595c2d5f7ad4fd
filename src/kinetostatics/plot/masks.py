"""Poses without valid numbers in figures: hatched grey areas, with reasons in the legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.rims import area, draw_rim
from kinetostatics.plot.selection import Selection
from kinetostatics.plot.style import legend_below
from kinetostatics.status import Status


@dataclass(frozen=True)
class Mask:
    """A reason why poses have no number.

    Attributes:
        label: label in the legend.
        hatch: Matplotlib's hatch pattern.
        face: grey of the cells.
        where: mask with the shape of the values.
    """

    label: str
    hatch: str
    face: str
    where: NDArray[np.bool_]


_LOOKS = {
    Status.UNREACHABLE: ("unreachable", "////", "0.93"),
    Status.LIMIT_EXCEEDED: ("beyond joint limits", "....", "0.93"),
    Status.SINGULAR: ("singular", "xxxx", "0.85"),
}
#: NaN at a valid pose, such as an intensity of a degenerate basis.
_NOT_DETERMINED = ("not determined", "++++", "0.93")
_EDGE = "0.4"


def masks_of(values: Array, status: NDArray[np.int8]) -> list[Mask]:
    """Return the reasons for missing values with masks of their poses."""
    missing = np.isnan(values)
    found: dict[tuple[str, str, str], NDArray[np.bool_]] = {}
    for item in Status:
        where = missing & (status == item)
        if where.any():
            look = _LOOKS.get(item, _NOT_DETERMINED)
            found[look] = found.get(look, np.zeros_like(where)) | where
    return [Mask(*look, where) for look, where in found.items()]


def common_masks(parts: Sequence[Selection]) -> list[Mask]:
    """Return the reasons at poses where all quantities are missing."""
    everywhere = np.all([np.isnan(part.values) for part in parts], axis=0)
    return masks_of(np.where(everywhere, np.nan, 0.0), parts[0].status)


def reasons(*parts: Selection) -> str:
    """Return the reasons for missing values as text."""
    values, status = (np.stack([getattr(part, name) for part in parts]) for name in ("values", "status"))
    return ", ".join(mask.label for mask in masks_of(values, status))


def check_numbers(what: str, parts: Sequence[Selection], where: str) -> None:
    """Check that a pose has a value.

    Raises:
        ArgumentError: no pose has a number.
    """
    if not any(np.isfinite(part.values).any() for part in parts):
        raise ArgumentError(f"{what}: no pose of {where} has a number ({reasons(*parts)})")


def areas_of(masks: Sequence[Mask]) -> list[NDArray[np.bool_]]:
    """Return the union of each mask with all later ones, which leaves no gaps between areas drawn in this order."""
    return [np.any([mask.where for mask in masks[k:]], axis=0) for k in range(len(masks))]


def draw_areas(ax: Axes, fields: Sequence[tuple[Array, Array, Array]], masks: Sequence[Mask]) -> None:
    """Hatch the areas in which the fields of masks, each given with its x and y positions, are positive."""
    for field, mask in zip(fields, masks, strict=True):
        path = PathCollection(
            [area(ax, *field)], facecolors=mask.face, edgecolors=_EDGE, linewidths=0, hatch=mask.hatch, zorder=0.5
        )
        path.set_label(mask.label)
        ax.add_collection(path, autolim=False)
        draw_rim(ax, *field)


def draw_ranges(ax: Axes, borders: Array, masks: Sequence[Mask]) -> None:
    """Hatch the ranges of masks (n,) over the whole height, given the n + 1 borders of the cells."""
    for mask in masks:
        steps = np.flatnonzero(np.diff(np.concatenate([[False], mask.where, [False]]).astype(np.int8)))
        for low, high in borders[steps].reshape(-1, 2):
            band = ax.axvspan(low, high, facecolor=mask.face, edgecolor=_EDGE, linewidth=0, hatch=mask.hatch, zorder=0.5)
            band.set_label(mask.label)


def legend_of(figure: Figure, masks: Sequence[Mask]) -> None:
    """Add a legend of masks below the figure, without those in earlier legends."""
    named = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    patches = [patch for patch in patches_of(masks) if patch.get_label() not in named]
    legend_below(figure, patches)


def patches_of(masks: Sequence[Mask]) -> list[Patch]:
    """Return the patches of a legend, one for each reason."""
    each = {mask.label: mask for mask in masks}.values()
    return [Patch(facecolor=m.face, edgecolor=_EDGE, hatch=m.hatch, linewidth=0.4, label=m.label) for m in each]
