"""What parameters and parts do, as bars."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, new_axes, styled
from kinetostatics.results.sensitivities import Sensitivities, is_location
from kinetostatics.results.tool_point import named_point

#: Bars of each kind, at most.
MOST = 12


@styled
def sensitivities(found: Sensitivities, *, ax: Axes | None = None) -> Axes:
    """Draw by how many per cent one per cent more of each parameter, or of a part's stiffness, changes how far o or a tool moves.

    Args:
        found: of :func:`kinetostatics.sensitivities`.
        ax: to draw on; default: a new figure one column wide.

    Returns:
        The axes: bars to the left are less sag. Parameters of the file are dark, the stiffness of parts is light and hatched.

    Raises:
        ArgumentError: these are no sensitivities, the twist is not among them, or o does not move.
    """
    if not isinstance(found, Sensitivities):
        raise ArgumentError(f"{found!r} are no sensitivities: ks.sensitivities(pose) finds them")
    if "twist" not in found.of:
        raise ArgumentError(f"the bars are of the twist, which was not asked for: of={found.of}")
    size, who = float(np.linalg.norm(found.seen.twist[found.worst][:3])), named_point(found.tool)
    if not size > 0:
        raise ArgumentError(f"{who} does not move, so that nothing has an effect on it")
    rows = [(name, 100 * found.effect(name)[0] / size, False) for name in found if not is_location(name)][:MOST]
    parts = sorted(found.sources, key=lambda name: -abs(found.source_effect(name)))[:MOST]
    rows += [(f"stiffness of {name}", 100 * found.source_effect(name) / size, True) for name in parts]
    dark, light = mpl.colormaps[COLOURS]([0.15, 0.75])
    ax = new_axes(1.4 * ONE_COLUMN, 0.5 + 0.17 * len(rows)) if ax is None else ax
    for place, (_, value, is_part) in enumerate(rows):
        colour, hatch = (light, "////") if is_part else (dark, None)
        ax.barh(place, value, color=colour, hatch=hatch, edgecolor="white", height=0.75)
    ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
    ax.invert_yaxis()
    ax.axvline(0.0, color="0.3", linewidth=0.6)
    ax.set_xlabel(f"change of the displacement of {who} for 1 % more [%]")
    ax.grid(axis="x", color="0.85", linewidth=0.4)
    ax.set_axisbelow(True)
    return ax
