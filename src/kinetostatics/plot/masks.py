"""Poses without valid numbers in figures: grey, hatched, and named in the legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.selection import Selection
from kinetostatics.plot.style import legend_below
from kinetostatics.status import Status

if TYPE_CHECKING:
    from matplotlib.transforms import Transform


@dataclass(frozen=True)
class Mask:
    """A reason why poses have no number.

    Attributes:
        label: in the legend.
        hatch: Matplotlib's.
        face: grey of the cells.
        where: bool, like the values.
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
#: A number that is NaN though the pose is valid, such as an intensity of a degenerate basis.
_NOT_DETERMINED = ("not determined", "++++", "0.93")
_EDGE = "0.4"


def masks_of(values: Array, status: NDArray[np.int8]) -> list[Mask]:
    """Return the reasons that occur, each with its poses; together they are the poses without a number."""
    missing = np.isnan(values)
    found: dict[tuple[str, str, str], NDArray[np.bool_]] = {}
    for item in Status:
        where = missing & (status == item)
        if where.any():
            look = _LOOKS.get(item, _NOT_DETERMINED)
            found[look] = found.get(look, np.zeros_like(where)) | where
    return [Mask(*look, where) for look, where in found.items()]


def edges(values: Array) -> Array:
    """Return the borders (n + 1,) of cells around sorted values (n,)."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def common_masks(parts: Sequence[Selection]) -> list[Mask]:
    """Return the reasons where none of several quantities over the same axes has a number."""
    everywhere = np.all([np.isnan(part.values) for part in parts], axis=0)
    return masks_of(np.where(everywhere, np.nan, 0.0), parts[0].status)


def reasons(*parts: Selection) -> str:
    """Return why poses have no number, in words."""
    values, status = (np.stack([getattr(part, name) for part in parts]) for name in ("values", "status"))
    return ", ".join(mask.label for mask in masks_of(values, status))


def check_numbers(what: str, parts: Sequence[Selection], where: str) -> None:
    """See to it that there is something to be drawn.

    Raises:
        ArgumentError: no pose has a number.
    """
    if not any(np.isfinite(part.values).any() for part in parts):
        raise ArgumentError(f"{what}: no pose of {where} has a number ({reasons(*parts)})")


def draw_masks(
    ax: Axes, x_edges: Array, y_edges: Array, masks: Sequence[Mask], curved: bool = False, transform: Transform | None = None
) -> None:
    """Hatch the cells of masks (len x) or (len x, len y), whose borders are given; ``curved``: their sides along x are arcs."""
    for mask in masks:
        cells = PolyCollection(
            _runs(mask.where.reshape(len(x_edges) - 1, -1), x_edges, y_edges, curved),
            facecolors=mask.face,
            edgecolors=_EDGE,
            linewidths=0,
            hatch=mask.hatch,
            zorder=0.5 if mask.where.ndim == 1 else 2,
            label=mask.label,
            transform=transform or ax.transData,
        )
        ax.add_collection(cells, autolim=False)


def legend_of(figure: Figure, masks: Sequence[Mask]) -> None:
    """Name the masks below everything else; those that an earlier legend of the figure names are not repeated."""
    named = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    patches = [patch for patch in patches_of(masks) if patch.get_label() not in named]
    legend_below(figure, patches)


def patches_of(masks: Sequence[Mask]) -> list[Patch]:
    """Return the patches of a legend."""
    return [Patch(facecolor=m.face, edgecolor=_EDGE, hatch=m.hatch, linewidth=0.4, label=m.label) for m in masks]


def _runs(where: NDArray[np.bool_], x_edges: Array, y_edges: Array, curved: bool) -> list[Array]:
    """Return rectangles that cover the cells, one for each run of them along x: fewer, and without seams.

    Those that are curved have corners at all borders on their way.
    """
    found = []
    for j in range(where.shape[1]):
        steps = np.flatnonzero(np.diff(np.concatenate([[False], where[:, j], [False]]).astype(np.int8)))
        for first, last in zip(steps[::2], steps[1::2], strict=True):
            along = x_edges[first : last + 1] if curved else x_edges[[first, last]]
            low, high = (np.column_stack([along, np.full(len(along), level)]) for level in y_edges[j : j + 2])
            found.append(np.concatenate([low, high[::-1]]))
    return found
