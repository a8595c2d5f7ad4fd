"""A quantity over two coordinates, in colour."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plots.display_units import label
from kinetostatics.plots.masks import draw_masks, edges, legend_of, masks_of
from kinetostatics.plots.selection import Selection, chosen_names, in_figure_units, select
from kinetostatics.plots.style import COLOURS, ONE_COLUMN, extend_of, figure_of, name_ticks, new_axes, styled

#: With more cells a PDF or SVG holds them as pixels; letters, lines and hatches stay what they are.
VECTOR_CELLS = 10_000


def slice(
    ds: xr.Dataset,
    what: str = "linear_sag",
    x: str | None = None,
    y: str | None = None,
    *,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    contours: bool | int = True,
    limits: tuple[float, float] | None = None,
    beyond_limits: bool = False,
    ax: Axes | None = None,
    **fixed: float,
) -> Axes:
    """Draw a quantity over two of the swept coordinates, one cell of colour for each pose.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        what: as in :func:`kinetostatics.indices.quantity`: "linear_sag", "twist:rx", "actuator_force:prismatic_1", ….
        x: the name of the coordinate to the right; default: the first that is swept and not fixed.
        y: the name of the coordinate upwards; default: the next one.
        at: values of the other coordinates [m, rad]; the nearest of the map is shown, and named above the figure.
        unit: of the quantity, such as "µm", "deg", "N/µm"; default: what suits.
        contours: lines of equal value: True, False, or about how many.
        limits: smallest and largest value of the colours, in the figure's unit; default: all that is there.
        beyond_limits: show poses beyond the joints' limits like all others.
        ax: to draw on; default: a new figure one column wide.
        **fixed: the same as ``at``: ``z=0.5``. (Coordinates called x and y are fixed by ``at``.)

    Returns:
        The axes; the colours are ``ax.collections[0]``.

    Raises:
        ArgumentError: a name or a value makes no sense, or no pose of the slice has a number.
    """
    at = {**(at or {}), **fixed}
    dims = chosen_names(ds, (x, y), at, "a slice")
    shown = select(ds, what, dims, at, beyond_limits)
    if not np.isfinite(shown.values).any():
        reasons = ", ".join(mask.label for mask in masks_of(shown.values, shown.status))
        raise ArgumentError(f"{what}: no pose of this slice has a number ({reasons})")
    (values,), unit = in_figure_units([shown], unit)
    with styled():
        return _draw(shown, values, label(shown.long_name, unit), contours, limits, ax)


def _draw(
    shown: Selection,
    values: NDArray[np.float64],
    text: str,
    contours: bool | int,
    limits: tuple[float, float] | None,
    ax: Axes | None,
) -> Axes:
    across, up = shown.axes
    masked = np.ma.masked_invalid(values.T)
    ax = new_axes(ONE_COLUMN, 0.86 * ONE_COLUMN) if ax is None else ax
    figure = figure_of(ax)
    low, high = limits if limits is not None else (float(masked.min()), float(masked.max()))
    mesh = ax.pcolormesh(
        edges(across.values),
        edges(up.values),
        masked,
        cmap=COLOURS,
        vmin=low,
        vmax=high,
        edgecolors="face",
        linewidth=0.2,
        rasterized=masked.size > VECTOR_CELLS,
        label=shown.what,
    )
    bar = figure.colorbar(mesh, ax=ax, label=text, pad=0.02, extend=extend_of(masked.compressed(), low, high))
    if contours and high - low > 1e-9 * max(abs(low), abs(high)) and min(masked.shape) > 1:
        ticks = MaxNLocator(7 if contours is True else int(contours)).tick_values(low, high)
        levels = [level for level in ticks if low < level < high]
        lines = ax.contour(across.values, up.values, masked, levels=levels, colors="black", linewidths=0.6, zorder=3)
        lines.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white", alpha=0.7)])
        bar.set_ticks(levels)
        bar.ax.hlines(levels, 0, 1, colors="white", linewidth=0.6, transform=bar.ax.get_yaxis_transform())
        for number in ax.clabel(lines, fontsize=6, inline_spacing=2, fmt=lambda level: f"{level:g}"):
            number.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white")])
    masks = masks_of(shown.values, shown.status)
    draw_masks(ax, across.values, up.values, masks)
    ax.set(xlabel=across.label, ylabel=up.label, title=shown.fixed)
    ax.set(xlim=edges(across.values)[[0, -1]], ylim=edges(up.values)[[0, -1]])
    name_ticks(ax.xaxis, across)
    name_ticks(ax.yaxis, up)
    legend_of(figure, masks)
    return ax
