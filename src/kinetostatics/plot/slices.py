"""Slices of a map: a quantity over two coordinates, in colour."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from kinetostatics.plot.display_units import label
from kinetostatics.plot.masks import check_numbers, draw_masks, legend_of, masks_of
from kinetostatics.plot.planes import OUTWARDS, ROUND, goes_round, label_axes, rectangle, round_a_pole
from kinetostatics.plot.selection import axis_of, check_range, chosen_names, in_figure_units, range_of, select
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, figure_of, new_axes, styled, title_of

#: With more cells a PDF or SVG holds them as pixels; letters, lines and hatches stay what they are.
VECTOR_CELLS = 10_000
#: Size of the numbers at lines of equal value [pt].
NUMBERS = 6


@styled
def slice(
    ds: xr.Dataset,
    what: str = "linear_sag",
    x: str | None = None,
    y: str | None = None,
    *,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    contours: bool | int = True,
    value_range: tuple[float, float] | None = None,
    polar: bool | None = None,
    beyond_limits: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw a quantity over two of the swept coordinates, one cell of colour for each pose.

    Over azimuth and tilt the figure is polar: azimuth goes round from the right, tilt outwards from the middle, so that it is
    the view from above on where the platform leans.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        what: as in :func:`kinetostatics.indices.quantity`: "linear_sag", "twist:rx", "actuator_force:prismatic_1", ….
        x: the name of the coordinate to the right; default: the first that is swept and not fixed.
        y: the name of the coordinate upwards; default: the next one.
        at: values of the other coordinates [m, rad]; the nearest of the map is shown, and named above the figure.
        unit: of the quantity, such as "µm", "deg", "N/µm"; default: what suits.
        contours: lines of equal value: True, False, or about how many.
        value_range: of the colours, in the figure's unit; default: all values, or without the few outermost where these lie far
            beyond all others; then the bar has an arrow, and says how far they go.
        polar: True or False to insist on polar axes or on rectangular ones; default: polar for azimuth and tilt, if the tilts
            are 0 or more and the azimuths within one turn.
        beyond_limits: show poses beyond the joints' limits like all others.
        ax: to draw on, made with ``projection="polar"`` for a polar figure; default: a new figure one column wide.

    Returns:
        The axes; the colours are ``ax.collections[0]``.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose of the slice has a number.
    """
    at = dict(at or {})
    check_range(value_range)
    dims = chosen_names(ds, (x, y), at, "a slice")
    for name in dims:
        axis_of(ds, name)  # complains about names before anything else does
    goes = goes_round(ds, dims, polar, ax)
    shown = select(ds, what, (ROUND, OUTWARDS) if goes else dims, at, beyond_limits)
    check_numbers(what, [shown], "this slice")
    (values,), unit = in_figure_units([shown], unit)
    plane = (round_a_pole if goes else rectangle)(*shown.axes)
    if ax is None:
        height = 0.86 if plane.ratio is None else float(np.clip(0.64 * plane.ratio + 0.22, 0.5, 1.6))
        ax = new_axes(ONE_COLUMN, height * ONE_COLUMN, projection="polar" if goes else None)
        if plane.ratio is not None:
            ax.set_aspect("equal")
    masked = np.ma.masked_invalid(values.T)
    figure = figure_of(ax)
    span = range_of(masked.compressed(), value_range)
    low, high = span.low, span.high
    ax.grid(False)
    mesh = ax.pcolormesh(
        plane.x_edges,
        plane.y_edges,
        masked[:, plane.cells],
        cmap=COLOURS,
        vmin=low,
        vmax=high,
        edgecolors="face",
        linewidth=0.2,
        rasterized=len(plane.cells) * len(plane.y) > VECTOR_CELLS,
        label=shown.what,
    )
    pad = 0.11 if plane.polar else 0.02
    bar = figure.colorbar(mesh, ax=ax, label=label(shown.long_name, unit) + span.note, pad=pad, extend=span.extend)
    masks = masks_of(shown.values[plane.cells], shown.status[plane.cells])
    draw_masks(ax, plane.x_edges, plane.y_edges, masks, curved=plane.polar)
    ax.set_title(title_of(ax, shown.fixed))
    label_axes(ax, plane, *shown.axes)
    lines = None
    if high - low <= 1e-9 * max(abs(low), abs(high)):  # one number
        bar.set_ticks([low])
    elif contours and min(masked.shape) > 1:
        ticks = MaxNLocator(7 if contours is True else int(contours)).tick_values(low, high)
        levels = [level for level in ticks if low < level < high]
        lines = ax.contour(plane.x, plane.y, masked[:, plane.lines], levels=levels, colors="black", linewidths=0.6, zorder=3)
        lines.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white", alpha=0.7)])
        bar.set_ticks(levels)
        bar.ax.hlines(levels, 0, 1, colors="white", linewidth=0.6, transform=bar.ax.get_yaxis_transform())
    legend_of(figure, masks)
    if lines is not None:
        _number(ax, lines)
    return ax


def _number(ax: Axes, lines: ContourSet) -> None:
    """Write values on lines of equal value, where they touch neither each other, nor the frame, nor numbers of the axes."""
    figure = figure_of(ax)
    figure.draw_without_rendering()  # places of what is there already
    taken = [name.get_window_extent() for axis in (ax.xaxis, ax.yaxis) for name in axis.get_ticklabels()]
    for level, path in zip(lines.levels, lines.get_paths(), strict=True):
        for piece in np.split(path.vertices, np.flatnonzero(path.codes == Path.MOVETO)[1:]):
            places = ax.transData.transform(piece)
            if len(piece) < 2 or np.hypot(*np.diff(places, axis=0).T).sum() * 72 / figure.dpi < 5 * NUMBERS:
                continue
            for part in (0.5, 0.35, 0.65, 0.2, 0.8):
                at = min(int(part * len(piece)), len(piece) - 2)
                run, rise = places[at + 1] - places[at]
                angle = (np.degrees(np.arctan2(rise, run)) + 90) % 180 - 90
                x, y = piece[at].tolist()
                number = ax.text(x, y, _short(level), fontsize=NUMBERS, ha="center", va="center", rotation=angle, zorder=5)
                box = number.get_window_extent().padded(figure.dpi / 72)
                inside = all(ax.patch.contains_point(corner) for corner in box.corners())
                if inside and not any(box.overlaps(other) for other in taken):
                    number.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white")])
                    taken.append(box)
                    break
                number.remove()


def _short(level: float) -> str:
    return f"{level:g}".replace("-", "−")
