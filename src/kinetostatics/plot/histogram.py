"""How far robots of one design differ, as a histogram."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.plot.display_units import display_unit
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, new_axes, styled
from kinetostatics.results.spread import LENGTHS, Spread
from kinetostatics.results.tool_point import named_point

#: Bars of a histogram.
BARS = 60


@styled
def spread(found: Spread, what: str = "displacement", *, ax: Axes | None = None) -> Axes:
    """Draw how many robots made at random have how much of a quantity, and what first order says of them.

    Args:
        found: of :func:`kinetostatics.spread`.
        what: "displacement" or "rotation", distances from the nominal robot, a component "x" … "rz" of the twist, or an actuator.
        ax: to draw on; default: a new figure one column wide.

    Returns:
        The axes: bars are robots, the line is the same robots to first order, the dashed lines are its worst case.

    Raises:
        ArgumentError: this is no spread, there is no such quantity, or it is the same for all robots.
    """
    if not isinstance(found, Spread):
        raise ArgumentError(f"{found!r} is no spread: ks.spread(pose, …) finds it")
    values = found.samples.named(what)
    worst, is_length = float(found.worst_case.named(what)), what in LENGTHS
    nominal = 0.0 if is_length else float(found.nominal.named(what))
    if not worst > 0:
        raise ArgumentError(f"{what} is the same for all robots, to first order: there is nothing to draw")
    if what in found.nominal.actuator_forces:
        kind = found.result.robot.mechanism.connections[what].type
        unit, title = kind.force_unit, f"{'force' if kind.is_slide else 'torque'} of {what}"
    else:
        unit = "m" if what == "displacement" or what in COMPONENTS[:3] else "rad"
        off = "from the nominal robot"
        titles = {"displacement": f"distance of {named_point(found.tool)} {off}", "rotation": f"rotation {off}"}
        title = titles.get(what, f"{what} of the twist")
    values = values[np.isfinite(values)]
    size, name = display_unit(unit, [nominal, values.min(), values.max()])
    dark, light = mpl.colormaps[COLOURS]([0.1, 0.75])
    ax = new_axes(1.4 * ONE_COLUMN, 2.3) if ax is None else ax
    _, edges, _ = ax.hist(values / size, BARS, color=light, edgecolor="white", linewidth=0.3, label=f"{len(values):,} robots")
    ax.hist(_first_order(found, what) / size, edges.tolist(), histtype="step", color=dark, label="first order")
    for sign in (1,) if is_length else (1, -1):
        label = "worst case" if sign > 0 else None
        ax.axvline((nominal + sign * worst) / size, color="0.3", linestyle="--", linewidth=0.8, label=label)
    ax.set_xlabel(f"{title} [{name}]")
    ax.set_ylabel("robots")
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 1.16), ncols=3)
    return ax


def _first_order(found: Spread, what: str) -> Array:
    """Return a quantity (robots,) of the robots made at random, to first order."""
    parts = [(found.effects[name], (found.values[name] - item.value) / item.tolerance) for name, item in found.parameters.items()]
    if what in LENGTHS:
        change = sum(np.outer(part, effect.twist[LENGTHS[what]]) for effect, part in parts)
        return np.asarray(np.linalg.norm(change, axis=-1))
    return np.asarray(found.nominal.named(what) + sum(part * effect.named(what) for effect, part in parts))
