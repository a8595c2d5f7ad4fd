"""Where an optimum lies between the bounds of what was varied, and how near its requirements are to their limits."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Patch

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.display_units import display_unit
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, figure_of, legend_below, new_axes, styled
from kinetostatics.reports.optimum import place_words
from kinetostatics.results.optimum import BROKEN, CheckedRequirement, Optimum

#: Part of a limit up to which bars are drawn: what is broken by more is cut off there.
MOST = 1.6


@styled
def optimum(found: Optimum, *, ax: Axes | None = None) -> Axes:
    """Draw each varied parameter between its bounds, and how much of the limit of each requirement its worst pose uses.

    Args:
        found: of :func:`kinetostatics.optimize`.
        ax: to draw on; default: a new figure one and a half columns wide.

    Returns:
        The axes: above, parameters, a point between the least and the greatest value that was allowed, on a logarithmic scale
        where both are positive, with a tick for each that was listed. Below, requirements: a bar to 100 % is at its limit, dark
        if it decides, red if it is broken. Beside each stands its value, the worst of all poses, and where that is.

    Raises:
        ArgumentError: this is no optimum.
    """
    if not isinstance(found, Optimum):
        raise ArgumentError(f"{found!r} is no optimum: ks.optimize(robot, …) finds one")
    rows = [f"{name}\n{_written(value, found.units.get(name, ''))}" for name, value in found.parameters.items()]
    rows += [f"{item.text}\n{_worst(item, place_words(found, item))}" for item in found.requirements]
    ax = new_axes(1.7 * ONE_COLUMN, 0.8 + 0.34 * len(rows)) if ax is None else ax
    for place, (name, value) in enumerate(found.parameters.items()):
        _parameter(ax, place, value, np.asarray(found.allowed[name]), found.units.get(name, ""))
    seen = {_requirement(ax, len(found.parameters) + k, item) for k, item in enumerate(found.requirements)}
    ax.axvline(100, color="0.3", linewidth=0.8, linestyle="--")
    ax.set_yticks(range(len(rows)), rows)
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.set_xlim(-4, 100 * MOST if "broken" in seen else 108)
    ax.set_xticks(np.arange(0, 101, 25))
    ratios = " (logarithmic)" if any(min(allowed) > 0 for allowed in found.allowed.values()) else ""
    ax.set_xlabel(f"place between bounds{ratios}, part of the limit that is used [%]")
    ax.set_title(_verdict(found))
    ax.grid(axis="x", color="0.85", linewidth=0.4)
    ax.set_axisbelow(True)
    ways = [(words, _look(words)) for words in ("decides", "has a margin", "broken") if words in seen]
    if len(figure_of(ax).axes) == 1:
        legend_below(figure_of(ax), [Patch(facecolor=c, hatch=h, edgecolor="white", label=w) for w, (c, h) in ways])
    return ax


def _written(value: float, unit: str) -> str:
    size, name = display_unit(unit, [value]) if unit else (1.0, "")
    return f"{value / size:.4g} {name}".rstrip().replace("-", "−")


def _verdict(found: Optimum) -> str:
    if not found.feasible:
        return "not feasible: these parameters come nearest"
    before = "" if np.isnan(found.before) else f" ({_written(found.before, found.unit)} with the file's own parameters)"
    return f"{found.minimized} {_written(found.objective, found.unit)}{before}"


def _parameter(ax: Axes, place: int, value: float, allowed: Array, unit: str) -> None:
    low, high = float(allowed.min()), float(allowed.max())

    def at(number: float) -> float:
        if low == high:
            return 50.0
        if low > 0:
            return float(100 * np.log(number / low) / np.log(high / low))
        return 100 * (number - low) / (high - low)

    ax.plot([0, 100], [place, place], color="0.6", linewidth=2.0, solid_capstyle="butt")
    for number in allowed.tolist():
        ax.plot([at(number)] * 2, [place - 0.12, place + 0.12], color="0.4", linewidth=0.8)
    ax.plot(at(value), place, "D", color=mpl.colormaps[COLOURS](0.1), markersize=6, clip_on=False)
    for number, x, side in ((low, 0, "left"), (high, 100, "right")):
        text = _written(number, unit)
        ax.annotate(text, (x, place), (0, 5), textcoords="offset points", ha=side, color="0.4", fontsize=6)


def _requirement(ax: Axes, place: int, item: CheckedRequirement) -> str:
    """Draw one requirement and return what is true of it."""
    words = "broken" if item.margin < -BROKEN else "decides" if item.active else "has a margin"
    used = np.nan if np.isnan(item.worst) else 1 - item.margin if item.is_below else 1 / (1 + item.margin)
    colour, hatch = _look(words)
    ax.barh(place, 100 * min(used, MOST) if np.isfinite(used) else 100 * MOST, 0.5, color=colour, hatch=hatch, edgecolor="white")
    return words


def _worst(item: CheckedRequirement, place: str) -> str:
    worst = "a pose has no number" if np.isnan(item.worst) else _written(item.worst, item.unit)
    return f"{worst} at {place}".replace("-", "−") if place else worst


def _look(words: str) -> tuple[tuple[float, float, float, float], str | None]:
    dark, light = (to_rgba(colour) for colour in mpl.colormaps[COLOURS]([0.15, 0.75]))
    return {"decides": (dark, None), "has a margin": (light, "////"), "broken": (to_rgba("#b2182b"), "xxxx")}[words]
