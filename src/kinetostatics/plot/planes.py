"""Cells and lines of a slice in the plane: Cartesian, or polar for the coordinates azimuth and tilt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.rims import continued, edges, level_of
from kinetostatics.plot.selection import ShownAxis
from kinetostatics.plot.style import name_ticks

#: Angular and radial coordinate of polar figures.
ROUND, OUTWARDS = "azimuth", "tilt"
#: Largest angle of a piece of a cell [°], since Matplotlib draws straight sides.
PIECE = 2.0
#: Largest aspect ratio of figures with equal scales.
SLENDER = 4.0
#: Steps between azimuth labels [°]; the smallest one with at most nine labels is used.
STEPS = (1, 2, 5, 10, 15, 30, 45)


@dataclass(frozen=True, eq=False)
class Plane:
    """Cells and lines of a slice.

    Attributes:
        polar: whether the first coordinate is an angle [rad] and the second a radius.
        x_edges, y_edges: borders of the cells.
        cells: index along x of the value of each column of cells; in polar figures a value has several columns.
        x, y: positions of the values for contour lines.
        lines: index along x of the value at each ``x``; on a full circle the first value is repeated at the end.
        ratio: height by width for equal scales of both axes; None: scales are independent.
    """

    polar: bool
    x_edges: Array
    y_edges: Array
    cells: NDArray[np.intp]
    x: Array
    y: Array
    lines: NDArray[np.intp]
    ratio: float | None = None

    @property
    def full(self) -> bool:
        """Whether the cells cover the full circle."""
        return self.polar and bool(self.x_edges[-1] - self.x_edges[0] > 2 * math.pi - 1e-6)

    @property
    def closed(self) -> bool:
        """Whether the first and the last value along x are neighbours."""
        return len(self.lines) > len(set(self.lines.tolist()))

    def continued(self, values: Array) -> Array:
        """Return values (len x, len y), extrapolated to neighbouring poses without a value."""
        return continued(np.pad(values, ((2, 2), (0, 0)), "wrap"))[2:-2] if self.closed else continued(values)

    def field(self, where: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
        """Return :func:`level_of` a mask (len x, len y), interpolated over the cells: positions along x and y, and the field."""
        field = level_of(where, self.closed)[self.lines]
        first, last = self.x[[0, -1]] if self.closed else self.x_edges[[0, -1]]
        pieces = math.ceil((last - first) / math.radians(PIECE)) if self.polar else 1
        x = np.unique(np.concatenate([np.linspace(first, last, pieces + 1), self.x]))
        place = np.interp(x, self.x, np.arange(len(self.x)))
        before = np.minimum(place.astype(int), len(self.x) - 2)
        part = (place - before)[:, None]
        field = np.pad((1 - part) * field[before] + part * field[before + 1], ((0, 0), (1, 1)), "edge")
        return x, np.array([self.y_edges[0], *self.y, self.y_edges[-1]]), field


def goes_round(ds: xr.Dataset, dims: Sequence[str], polar: bool | None, ax: Axes | None) -> bool:
    """Return whether a slice is polar: for azimuth and tilt, unless chosen otherwise.

    Raises:
        ArgumentError: a polar figure is requested for other coordinates, or the given axes are of the other kind.
    """
    suits = set(dims) == {ROUND, OUTWARDS} and not any(ds[name].dtype.kind in "OUS" for name in dims)
    if suits:
        turn, tilt = np.asarray(ds[ROUND].values), np.asarray(ds[OUTWARDS].values)
        suits = bool(np.ptp(turn) <= 2 * math.pi * (1 + 1e-9) and tilt.min() > -1e-9)
    if polar and not suits:
        raise ArgumentError(
            "polar figures need azimuth and tilt, with tilts of 0 or more and azimuths within one turn; "
            f"here the coordinates are {' and '.join(dims)}"
        )
    given = None if ax is None else isinstance(ax, PolarAxes)
    if (given is not None and polar is not None and given != polar) or (given and not suits):
        expected = "axes made with projection='polar'" if polar else "axes without projection='polar'"
        raise ArgumentError(f"this slice needs {expected}")
    return suits if polar is None and given is None else bool(polar or given)


def rectangle(across: ShownAxis, up: ShownAxis) -> Plane:
    """Return cells on a rectangle."""
    every = np.arange(len(across.values))
    x, y = edges(across.values), edges(up.values)
    ratio = float(np.ptp(y) / np.ptp(x))
    in_space = {across.name, up.name} <= {"x", "y", "z"} and across.unit == up.unit and 1 / SLENDER < ratio < SLENDER
    return Plane(False, x, y, every, across.values, up.values, every, ratio if in_space else None)


def round_a_pole(across: ShownAxis, up: ShownAxis) -> Plane:
    """Return cells in polar coordinates: ``across`` are azimuths, ``up`` are tilts, both sorted [°]."""
    turn, every = across.values, np.arange(len(across.values))
    borders, gap = edges(turn), turn[0] + 360.0 - turn[-1]
    # the border between the last and the first azimuth is in the middle, too
    borders[0], borders[-1] = max(borders[0], turn[0] - gap / 2), min(borders[-1], turn[-1] + gap / 2)
    pieces = np.maximum(1, np.ceil(np.diff(borders) / PIECE - 1e-9)).astype(int)
    fine = [np.linspace(a, b, count, endpoint=False) for a, b, count in zip(borders[:-1], borders[1:], pieces, strict=True)]
    outwards = edges(up.values)
    outwards[0] = max(outwards[0], 0.0)
    closes = 1e-9 < gap <= 1.5 * np.diff(turn).max(initial=0.0)
    lines = np.append(every, 0) if closes else every
    return Plane(
        polar=True,
        x_edges=np.radians(np.append(np.concatenate(fine), borders[-1])),
        y_edges=outwards,
        cells=np.repeat(every, pieces),
        x=np.radians(np.append(turn, turn[0] + 360.0) if closes else turn),
        y=up.values,
        lines=lines,
    )


def label_axes(ax: Axes, plane: Plane, across: ShownAxis, up: ShownAxis) -> None:
    """Set titles, ticks and limits of the axes."""
    if isinstance(ax, PolarAxes):
        _label_round(ax, plane, across, up)
        return
    ax.set(xlabel=across.label, ylabel=up.label, xlim=plane.x_edges[[0, -1]], ylim=plane.y_edges[[0, -1]])
    name_ticks(ax.xaxis, across)
    name_ticks(ax.yaxis, up)


def _label_round(ax: PolarAxes, plane: Plane, across: ShownAxis, up: ShownAxis) -> None:
    first, last = np.degrees(plane.x_edges[[0, -1]])
    step = next((step for step in STEPS if (last - first) / step < 9), STEPS[-1])
    ticks = [k * step for k in range(math.ceil(first / step - 1e-9), math.floor(last / step + 1e-9) + 1)]
    if plane.full:
        ticks = list(range(0, 360, step))
        names = [_degrees(tick - 360 if tick > 180 and across.values.min() < 0 else tick) for tick in ticks]
    else:
        names = [_degrees(tick) for tick in ticks]
    ax.set_xticks(np.radians(ticks), names)
    ax.set_thetalim(*((0.0, 2 * math.pi) if plane.full else plane.x_edges[[0, -1]]))
    ax.set_ylim(0.0, plane.y_edges[-1])
    most = plane.y_edges[-1]  # no number on the outer circle
    tilts = up.values if len(up.values) == 1 else MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(0, most)
    ax.set_yticks([tilt for tilt in tilts if 0 < tilt < 0.9 * most or len(tilts) == 1])
    ax.yaxis.set_major_formatter(FuncFormatter(lambda tilt, _: _degrees(round(tilt, 2))))
    ax.set_axisbelow(False)
    ax.grid(color="white", linewidth=0.4, alpha=0.5)
    ax.tick_params(axis="x", pad=0)
    for name in ax.get_yticklabels():
        name.set(ha="center", va="center", fontsize=6)
        name.set_bbox({"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"})
    ax.set_xlabel(f"{ROUND} (angular), {OUTWARDS} (radial) [°]", labelpad=4)


def _degrees(value: float) -> str:
    return f"{value:g}°".replace("-", "−")
