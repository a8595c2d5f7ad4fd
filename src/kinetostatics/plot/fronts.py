"""What of one quantity has to be paid for less of another, as a line."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plot.display_units import display_unit, label
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, new_axes, styled
from kinetostatics.results.pareto import ParetoFront


@styled
def pareto(found: ParetoFront, *, ax: Axes | None = None) -> Axes:
    """Draw designs of which none is better in both of two quantities; of a single varied parameter the values stand beside them.

    Args:
        found: of :func:`kinetostatics.pareto`.
        ax: to draw on; default: a new figure one column wide.

    Returns:
        The axes: the first quantity to the right, the second, by ratios where it spans more than a factor of ten, upwards.

    Raises:
        ArgumentError: this is no front.
    """
    if not isinstance(found, ParetoFront):
        raise ArgumentError(f"{found!r} is no front: ks.pareto(robot, …) finds one")
    scales = [display_unit(unit, found.objectives[:, k]) for k, unit in enumerate(found.units)]
    (x, y), (x_unit, y_unit) = (found.objectives / [size for size, _ in scales]).T, (name for _, name in scales)
    ax = new_axes(1.4 * ONE_COLUMN, 2.5) if ax is None else ax
    ax.plot(x, y, "o-", color=mpl.colormaps[COLOURS](0.1))
    if y.min() > 0 and y.max() > 10 * y.min():
        ax.set_yscale("log")
    if len(found.parameters) == 1:
        ((name, values),) = found.parameters.items()
        unit = found[0].units.get(name, "")
        size, shown = display_unit(unit, values) if unit else (1.0, "")
        for place, value in zip(zip(x, y, strict=True), values / size, strict=True):
            ax.annotate(f"{value:.4g} {shown}".rstrip(), place, (4, 3), textcoords="offset points", fontsize=6)
    ax.margins(0.12, 0.1)
    ax.set_xlabel(label(found.minimized[0], x_unit))
    ax.set_ylabel(label(found.minimized[1], y_unit))
    ax.grid(color="0.85", linewidth=0.4, which="both")
    ax.set_axisbelow(True)
    return ax
