"""How well a calibration's readings fit."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plot.display_units import display_unit
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, new_axes, styled
from kinetostatics.results.calibration import Calibration

#: Markers of gauges, which must differ without colour.
MARKERS = "osD^v<>Pd*"


@styled
def calibration(found: Calibration, *, kind: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw measured less computed readings over the computed ones, with outliers ringed and named by their rows.

    Args:
        found: of :func:`kinetostatics.calibrate`.
        kind: "length" or "angle", the readings that are drawn; default: lengths, if there are any.
        ax: to draw on; default: a new figure one column and a half wide.

    Returns:
        The axes: a marker for each gauge; the band is twice the standard deviation of a reading of each, the widest of them.

    Raises:
        ArgumentError: this is no calibration, or it has no readings of the kind.
    """
    if not isinstance(found, Calibration):
        raise ArgumentError(f"{found!r} is no calibration: ks.calibrate(robot, …) makes one")
    kinds = np.array([found.gauges[name].kind for name in found.gauge_of])
    kind = kind or ("length" if "length" in kinds else "angle")
    mine = kinds == kind
    if not np.any(mine):
        raise ArgumentError(f"kind is {kind!r}, of which there are no readings; it must be one of 'length', 'angle'")
    across, across_unit = display_unit("m" if kind == "length" else "rad", found.computed[mine])
    up, up_unit = display_unit("m" if kind == "length" else "rad", found.residuals[mine])
    wrong = {(item.row, item.gauge) for item in found.outliers}
    ax = new_axes(1.5 * ONE_COLUMN, 0.8 * ONE_COLUMN) if ax is None else ax
    names = [name for name, gauge in found.gauges.items() if gauge.kind == kind]
    colours = mpl.colormaps[COLOURS](np.linspace(0.1, 0.8, len(names)))
    band = 2 * found.sigma[mine].max() / up
    ax.axhspan(-band, band, color="0.92", linewidth=0, label="±2 standard deviations")
    ax.axhline(0.0, color="0.3", linewidth=0.6)
    for k, name in enumerate(names):
        at = np.array([one == name for one in found.gauge_of])
        x, y = found.computed[at] / across, found.residuals[at] / up
        ax.plot(x, y, MARKERS[k % len(MARKERS)], color=colours[k], label=name)
        for row, one, other in zip(found.rows[at].tolist(), x, y, strict=True):
            if (row, name) in wrong:
                ax.plot(one, other, "o", markersize=9, markerfacecolor="none", color="0.2", markeredgewidth=0.8)
                ax.annotate(f"row {row}", (one, other), xytext=(7, 0), textcoords="offset points", va="center")
    ax.set_xlabel(f"computed reading [{across_unit}]")
    ax.set_ylabel(f"measured less computed [{up_unit}]")
    ax.grid(color="0.85", linewidth=0.4)
    ax.set_axisbelow(True)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=min(len(names) + 1, 4))
    return ax
