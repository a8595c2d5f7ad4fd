"""Polar figure of the capacity: the largest force at o by its direction in a plane."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from kinetostatics.arguments import Keyword, check_choice
from kinetostatics.capacity import capacity as capacity_of
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.plot.selection import display_unit
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, figure_of, legend_below, new_axes, styled

#: Directions of the figure; radius of the figure, relative to the smallest capacity.
_COUNT, _LARGEST = 181, 4.0


@styled
def capacity(configuration: Configuration, plane: str = "xz", **limits: Keyword) -> Axes:
    """Draw the largest force at o over its direction in a plane of the world axes, in the colour of the limit that it reaches.

    Capacities beyond four times the smallest one are drawn on the edge.

    Args:
        configuration: one pose.
        plane: the axis to the right and the axis upwards, such as "xz".
        limits: further arguments of :func:`kinetostatics.capacity`: ``load``, ``gravity``, ``sag``, ….

    Returns:
        Polar axes.
    """
    check_choice("plane", plane, ("xy", "xz", "yz"))
    angle, forces = np.linspace(0, 2 * np.pi, _COUNT), np.zeros((_COUNT, 6))
    forces[:, ["xyz".index(axis) for axis in plane]] = np.array([np.cos(angle), np.sin(angle)]).T
    found = capacity_of(configuration, forces, **limits)
    edge = _LARGEST * float(np.nanmin(found.load, initial=np.inf))
    size, unit = display_unit("N", [np.array(edge)])
    ax = new_axes(ONE_COLUMN, 1.15 * ONE_COLUMN, "polar")
    radius, names = np.fmin(found.load, edge) / size, [*dict.fromkeys(found.limited_by)]
    ax.plot(angle, radius, color="0.75", linewidth=0.8)
    for k, name in enumerate(names):
        here = np.where(found.limited_by == name, radius, np.nan)
        colour = mpl.colormaps[COLOURS](0.8 * k / max(len(names) - 1, 1))
        ax.plot(angle, here, ".", color=colour, label=str(name) or "without limit")
    ax.set(rmin=0, rmax=edge / size, xlabel=f"largest force at o [{unit}]: {plane[0]} to the right, {plane[1]} upwards")
    legend_below(figure_of(ax), ax.get_lines()[1:])
    return ax
