"""Quantities over one coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plot.display_units import label, typeset
from kinetostatics.plot.masks import check_numbers, common_masks, draw_ranges, patches_of
from kinetostatics.plot.rims import edges
from kinetostatics.plot.selection import chosen_names, in_figure_units, select, select_each
from kinetostatics.plot.style import (
    COLOURS,
    DASHES,
    MARKERS,
    ONE_COLUMN,
    figure_of,
    legend_below,
    name_ticks,
    new_axes,
    styled,
    title_of,
)


@styled
def line(
    ds: xr.Dataset,
    what: str | Sequence[str] = "linear_sag",
    x: str | None = None,
    *,
    series: str | Mapping[str, Sequence[float]] | None = None,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    beyond_limits: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw quantities of one unit over one of the swept coordinates, or one quantity for several values of another.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        what: one or more quantities, see :func:`kinetostatics.indices.quantity`.
        x: coordinate of the horizontal axis; default: the first swept coordinate that is not fixed.
        series: another coordinate, with a line for each value, or for five of more than six values (with a note and a warning);
            or ``{"z": [0.3, 0.6]}`` to choose up to six.
        at: values of the other coordinates [m, rad]; the nearest pose of the map is shown, with its values in the title.
        unit: unit of the quantities; default: chosen by magnitude.
        beyond_limits: whether to include poses beyond joint limits.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes. Lines have gaps at invalid poses; the figure is hatched where no line is valid.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose has a number.
    """
    names = [what] if isinstance(what, str) else list(what)
    if not names or len(names) > len(DASHES) or (series is not None and len(names) > 1):
        raise ArgumentError(f"a figure shows one to {len(DASHES)} quantities, or one quantity with series=")
    at = dict(at or {})
    chosen = next(iter(series.values())) if isinstance(series, Mapping) and series else ()
    if len(chosen) > len(DASHES):
        raise ArgumentError(f"a series of lines has at most {len(DASHES)} values, not {len(chosen)}")
    fixed = () if series is None else (series,) if isinstance(series, str) else tuple(series)
    (x,) = chosen_names(ds, (x,), (*at, *fixed), "a line")
    note = ""
    if series is None:
        found = [select(ds, name, (x,), at, beyond_limits) for name in names]
        parts = {part.long_name: part for part in found}
        if len(parts) < len(found):
            parts = {part.what: part for part in found}
    else:
        parts, note = select_each(ds, names[0], (x,), series, len(DASHES), at, beyond_limits)
    check_numbers(", ".join(names), list(parts.values()), "this line" if len(parts) == 1 else "these lines")
    values, unit = in_figure_units(list(parts.values()), unit)
    first = next(iter(parts.values()))
    across = first.axes[0]
    ax = new_axes(ONE_COLUMN, 0.75 * ONE_COLUMN) if ax is None else ax
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.72, len(parts)))
    every = max(1, len(across.values) // 10)
    for k, (name, numbers) in enumerate(zip(parts, values, strict=True)):
        ax.plot(
            across.values,
            numbers,
            label=typeset(name if np.isfinite(numbers).any() else f"{name}: no valid pose"),
            color=colours[k],
            linestyle=DASHES[k],
            marker=MARKERS[k],
            # markers of the lines at different places
            markevery=(k * every // len(parts), every),
            markerfacecolor="white",
            markeredgewidth=0.8,
        )
    masks, borders = common_masks(list(parts.values())), edges(across.values)
    draw_ranges(ax, borders, masks)
    shown = {part.long_name for part in parts.values()}
    text = shown.pop() if len(shown) == 1 else _common(list(shown))
    ax.set(
        xlabel=across.label,
        ylabel=label(text, unit),
        title=title_of(ax, ", ".join(filter(None, (first.fixed, note)))),
        xlim=(borders[0], borders[-1]),
    )
    name_ticks(ax.xaxis, across)
    if len(parts) > 1 or masks:
        handles = ax.get_lines() if len(parts) > 1 else []
        legend_below(figure_of(ax), [*handles, *patches_of(masks)])
    return ax


def _common(names: list[str]) -> str:
    """Return the common first words of all names, or "quantity"."""
    words = [name.split() for name in names]
    same = []
    for group in zip(*words, strict=False):
        if len(set(group)) > 1:
            break
        same.append(group[0])
    while same and same[-1] in ("along", "about", "of", "by"):
        same.pop()
    return " ".join(same) or "quantity"
