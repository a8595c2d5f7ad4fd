"""Lines: quantities over one coordinate of a map, and over time along a trajectory."""

from __future__ import annotations

import os.path
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from kinetostatics.arguments import check_choice
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.numbers import NOISE
from kinetostatics.plot.masks import check_numbers, common_masks, draw_ranges, edges, patches_of
from kinetostatics.plot.selection import chosen_names, display_unit, in_figure_units, label, select, select_each, typeset
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
    wrapped,
)
from kinetostatics.results.path import OVER_TIME, PathResult


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
    """Draw quantities of one unit over a swept coordinate, or one quantity for several values of another coordinate.

    Args:
        ds, at, unit, beyond_limits: see :func:`slice`.
        what: one or more quantities, see :func:`kinetostatics.indices.quantity`.
        x: coordinate of the horizontal axis; default: the first swept coordinate that is not fixed.
        series: another coordinate, with a line for each value; of more than six values five are drawn, with a note and a warning.
            Or ``{"z": [0.3, 0.6]}``, to choose up to six values.
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
        selections = [select(ds, name, (x,), at, beyond_limits) for name in names]
        parts = {part.long_name: part for part in selections}
        if len(parts) < len(selections):
            parts = {part.what: part for part in selections}
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
            # the markers of different lines are at different values
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
    same = list(os.path.commonprefix([name.split() for name in names]))  # noqa: RUF071 - of words
    while same and same[-1] in ("along", "about", "of", "by"):
        same.pop()
    return " ".join(same) or "quantity"


#: Quantities of actuators over their velocities.
OVER_SPEED = {"force_speed": ("actuator_force", "actuator_speed"), "torque_speed": ("actuator_torque", "actuator_rate")}


@styled
def path(found: PathResult, what: str = "displacement", *, ax: Axes | None = None) -> Axes:
    """Draw a quantity over time along a trajectory, or actuator forces over actuator velocities.

    Args:
        found: result of :meth:`Trajectory.analyze`.
        what: a quantity of :meth:`PathResult.over_time`; or "torque_speed", "force_speed", to select motors.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes; of more than six lines, the six with the largest peaks are drawn.

    Raises:
        ArgumentError: ``found`` is not the result of a trajectory, or the quantity is unknown.
    """
    if not isinstance(found, PathResult):
        raise ArgumentError(f"{found!r} is no result of a trajectory: ks.trajectory(robot, …).analyze() computes it")
    check_choice("what", what, (*OVER_TIME, *OVER_SPEED))
    up, across = OVER_SPEED.get(what, (what, None))
    entry, lines, peaks = OVER_TIME[up], found.over_time(up), found.peaks(up)
    if not lines:
        raise ArgumentError(f"{found.result.robot.name!r} has no {entry.words.removeprefix('largest ')} [{entry.unit}]")
    ranked = sorted(lines, key=lambda name: -abs(peaks[name].value))
    shown = [name for name in ranked if abs(peaks[name].value) > NOISE * abs(peaks[ranked[0]].value)] or ranked
    names = [name for name in lines if name in shown[: len(DASHES)]]
    size, unit = display_unit(entry.unit, [lines[name] for name in names])
    ax = new_axes(ONE_COLUMN, 0.75 * ONE_COLUMN) if ax is None else ax
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.72, len(names)))
    for name, colour, dashes in zip(names, colours, DASHES, strict=False):
        x = found.times if across is None else found.over_time(across)[name]
        ax.plot(x, lines[name] / size, color=colour, linestyle=dashes, label=name)
    words = entry.words.format(point=found.result.point_name)
    ax.set(xlabel="time [s]" if across is None else label(OVER_TIME[across].words, OVER_TIME[across].unit))
    ax.set(
        ylabel=wrapped(label(words, unit), figure_of(ax)),
        title="" if len(names) == len(shown) else f"the largest {len(names)} of {len(shown)}",
    )
    ax.grid(color="0.85", linewidth=0.4)
    ax.xaxis.set_major_locator(MaxNLocator(6))
    if across is None:
        ax.margins(x=0)
    if len(names) > 1:
        legend_below(figure_of(ax), ax.get_lines())
    return ax
