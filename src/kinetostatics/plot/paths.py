"""Quantities over time along a trajectory, and actuator forces over actuator velocities."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from kinetostatics.arguments import check_choice
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.numbers import NOISE
from kinetostatics.plot.display_units import display_unit, label
from kinetostatics.plot.style import COLOURS, DASHES, ONE_COLUMN, figure_of, legend_below, new_axes, styled, wrapped
from kinetostatics.results.path import OVER_TIME, PathResult

#: Quantities of actuators over their velocities.
OVER_SPEED = {"force_speed": ("actuator_force", "actuator_speed"), "torque_speed": ("actuator_torque", "actuator_rate")}


@styled
def path(found: PathResult, what: str = "displacement", *, ax: Axes | None = None) -> Axes:
    """Draw a quantity over time along a trajectory, or forces of actuators over their velocities.

    Args:
        found: result of :meth:`Trajectory.analyze`.
        what: a quantity of :meth:`PathResult.over_time`; or "torque_speed", "force_speed", for the choice of motors.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes, with at most six lines, those of the largest peaks.

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
