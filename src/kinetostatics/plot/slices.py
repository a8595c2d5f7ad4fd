"""Slices of a map: a quantity over two coordinates in colour, on Cartesian axes, or on polar ones for azimuth and tilt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.contour import ContourSet
from matplotlib.path import Path
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.masks import (
    Mask,
    area,
    areas_of,
    check_numbers,
    draw_areas,
    edges,
    extrapolated,
    legend_of,
    masks_of,
    smooth_field,
)
from kinetostatics.plot.selection import (
    ShownAxis,
    axis_of,
    check_range,
    chosen_names,
    in_figure_units,
    label,
    range_of,
    select_each,
)
from kinetostatics.plot.style import COLOURS, ONE_COLUMN, ROW, figure_of, name_ticks, new_panels, styled, title_of, wrapped

#: Largest number of cells drawn as vectors in a PDF or SVG. More cells are pixels; text, lines and hatches remain vectors.
VECTOR_CELLS = 10_000
#: Largest number of slices of a series without explicit choice.
PANELS = 6
#: Font size of the numbers at contour lines [pt].
NUMBERS = 6


@styled
def slice(
    ds: xr.Dataset,
    what: str = "linear_sag",
    x: str | None = None,
    y: str | None = None,
    *,
    series: str | Mapping[str, Sequence[float]] | None = None,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    contours: bool | int = True,
    value_range: tuple[float, float] | None = None,
    polar: bool | None = None,
    beyond_limits: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw a quantity over two of the swept coordinates, with a coloured cell for each valid pose.

    Over azimuth and tilt the axes are polar: the azimuth is the angle, from the right, and the tilt the radius. A point is in the
    direction in which the platform leans, seen from above.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        what: quantity, see :func:`kinetostatics.indices.quantity`: "linear_sag", "twist:rx", "actuator_force:prismatic_1", ….
        x: coordinate of the horizontal axis; default: the first swept coordinate that is not fixed.
        y: coordinate of the vertical axis; default: the next one.
        series: another coordinate, with slices side by side for each of its values; of more than six values three are drawn, with
            a note and a warning. Or ``{"z": [0.3, 0.6]}``, to choose values.
        at: values of the other coordinates [m, rad]; the nearest pose of the map is shown, with its values in the title.
        unit: unit of the quantity, such as "µm", "deg", "N/µm"; default: chosen by magnitude.
        contours: contour lines: True, False, or their approximate number.
        value_range: range of the colours, in the unit of the figure. Default: the range of all values but a few outliers; the
            title of the colour bar then gives the range of the outliers.
        polar: whether to use polar axes; default: for azimuth and tilt, if all tilts are 0 or more and all azimuths within one
            turn.
        beyond_limits: whether to include poses beyond joint limits.
        ax: axes to draw on, with ``projection="polar"`` for a polar figure; default: a new figure one column wide.

    Returns:
        The axes; the colours are ``ax.collections[0]``. For a series, the axes of the first slice; all are ``ax.figure.axes``.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose of the slice is valid.
    """
    at = dict(at or {})
    check_range(value_range)
    third = series if isinstance(series, str) or series is None else next(iter(series), "")
    dims = chosen_names(ds, (x, y), (*at, *filter(None, [third])), "a slice")
    for name in dims:
        axis_of(ds, name)  # checks the names first
    goes = is_polar(ds, dims, polar, ax)
    across = (ROUND, OUTWARDS) if goes else dims
    most = PANELS if third in ds.dims and ds.sizes[third] <= PANELS else ROW
    parts, left_out = select_each(ds, what, across, series, most, at, beyond_limits)
    if len(parts) > 1 and ax is not None:
        raise ArgumentError("slices of a series need a new figure; ax= is for one slice")
    selections = list(parts.values())
    check_numbers(what, selections, "this slice" if len(selections) == 1 else "these slices")
    values, unit = in_figure_units(selections, unit)
    first = selections[0]
    plane = (polar_plane if goes else rectangular_plane)(*first.axes)
    axes = [ax] if ax is not None else _axes(plane, len(selections))
    figure = figure_of(axes[0])
    span = range_of(values, value_range)
    low, high = span.low, span.high
    levels = []
    if high - low > 1e-9 * max(abs(low), abs(high)) and contours and min(first.values.shape) > 1:
        ticks = MaxNLocator(7 if contours is True else int(contours)).tick_values(low, high)
        levels = [level for level in ticks if low < level < high]
    masks, drawn = [], []
    for k, (panel, (name, part), numbers) in enumerate(zip(axes, parts.items(), values, strict=True)):
        reasons = masks_of(part.values, part.status)
        masks += reasons
        drawn.append(_draw(panel, plane, numbers, reasons, (low, high), levels, part.what))
        label_axes(panel, plane, *part.axes)
        panel.set_title(title_of(panel, name or part.fixed))
        if k + ROW < len(selections):  # another one below
            panel.tick_params(labelbottom=goes)
            panel.set_xlabel("")
        if k % ROW and not goes:
            panel.tick_params(labelleft=False)
            panel.set_ylabel("")
    text = wrapped(label(first.long_name, unit) + span.note, figure)
    pad = 0.11 if goes and len(selections) == 1 else 0.02
    bar = figure.colorbar(drawn[0][0], ax=axes, label=text, pad=pad, extend=span.extend)
    if len(selections) > 1:
        figure.suptitle(title_of(axes[0], ", ".join(filter(None, (first.fixed, left_out)))))
    if high - low <= 1e-9 * max(abs(low), abs(high)):  # one number
        bar.set_ticks([low])
    elif levels:
        bar.set_ticks(levels)
        bar.ax.hlines(levels, 0, 1, colors="white", linewidth=0.6, transform=bar.ax.get_yaxis_transform())
    legend_of(figure, masks)
    for panel, (_, lines, rim) in zip(axes, drawn, strict=True):
        if lines is not None:
            _label_contours(panel, lines, rim)
    return axes[0]


def _axes(plane: Plane, count: int) -> list[Axes]:
    """Return ``count`` axes on a new figure: one a column wide, or several side by side."""
    width = ONE_COLUMN if count == 1 else 0.62 * ONE_COLUMN
    if plane.ratio is None:
        height = (0.86 if count == 1 else 1.0) * width
    elif count == 1:
        height = float(np.clip(0.64 * plane.ratio + 0.22, 0.5, 1.6)) * width
    else:
        height = float(np.clip(plane.ratio * (width - 0.25) + 0.45, 0.5 * width, 1.6 * ONE_COLUMN))
    axes = new_panels(count, width, height, "polar" if plane.polar else None)
    for ax in axes:
        if plane.ratio is not None:
            ax.set_aspect("equal")
    return axes


def _draw(
    ax: Axes, plane: Plane, values: Array, masks: Sequence[Mask], span: tuple[float, float], levels: Sequence[float], what: str
) -> tuple[QuadMesh, ContourSet | None, Path]:
    """Draw values, masks and contour lines; return the cells, the contour lines if any, and the border of the values."""
    ax.grid(False)
    wide = plane.extrapolated(values).T
    mesh = ax.pcolormesh(
        plane.x_edges,
        plane.y_edges,
        np.ma.masked_invalid(wide[:, plane.cells]),
        cmap=COLOURS,
        vmin=span[0],
        vmax=span[1],
        edgecolors="face",
        linewidth=0.2,
        rasterized=len(plane.cells) * len(plane.y) > VECTOR_CELLS,
        label=what,
        zorder=1,
    )
    rim = area(ax, *plane.field(np.isfinite(values)))
    mesh.set_clip_path(rim, ax.transData)
    draw_areas(ax, [plane.field(where) for where in areas_of(masks)], masks)
    lines = None
    if levels:
        lines = ax.contour(plane.x, plane.y, wide[:, plane.lines], levels=levels, colors="black", linewidths=0.6, zorder=2.2)
        lines.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white", alpha=0.7)])
        lines.set_clip_path(rim, ax.transData)
    return mesh, lines, rim


def _label_contours(ax: Axes, lines: ContourSet, rim: Path) -> None:
    """Label contour lines with their values; labels overlap neither each other nor tick labels nor the border."""
    figure = figure_of(ax)
    figure.draw_without_rendering()  # to compute positions of texts
    names = [name for axis in (ax.xaxis, ax.yaxis) for name in axis.get_ticklabels()]
    taken = [(name.get_bbox_patch() or name).get_window_extent() for name in names]
    outline = [Path(corners) for corners in ax.transData.transform_path(rim).to_polygons()]  # holes too

    def within(corner: Array) -> bool:
        place = (float(corner[0]), float(corner[1]))
        return ax.patch.contains_point(place) and sum(piece.contains_point(place) for piece in outline) % 2 == 1

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
                text = f"{level:g}".replace("-", "−")
                number = ax.text(x, y, text, fontsize=NUMBERS, ha="center", va="center", rotation=angle, zorder=5)
                box = number.get_window_extent().padded(figure.dpi / 72)
                inside = all(map(within, box.corners()))
                if inside and not any(box.overlaps(other) for other in taken):
                    number.set_path_effects([patheffects.withStroke(linewidth=1.4, foreground="white")])
                    taken.append(box)
                    break
                number.remove()


#: Angular and radial coordinate of polar figures.
ROUND, OUTWARDS = "azimuth", "tilt"
#: Largest angle of a cell [°]; wider ones are divided, since Matplotlib draws straight sides.
PIECE = 2.0
#: Largest aspect ratio of figures with equal scales.
SLENDER = 4.0
#: Steps between azimuth labels [°]; the smallest step with at most nine labels is used.
STEPS = (1, 2, 5, 10, 15, 30, 45)


@dataclass(frozen=True, eq=False)
class Plane:
    """Grid of a slice: cells for colours, and positions of the values for contour lines.

    Attributes:
        polar: whether x is an angle [rad] and y a radius.
        x_edges, y_edges: borders of the cells.
        cells: for each column of cells, the index of its value along x; in polar figures a value has several columns.
        x, y: positions of the values for contour lines.
        lines: for each ``x``, the index of the value there; on a full circle the first value is repeated at the end.
        ratio: height divided by width of axes with equal scales; None: scales are independent.
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

    def extrapolated(self, values: Array) -> Array:
        """Return values (len x, len y); missing values (NaN) beside known values are extrapolated."""
        return extrapolated(np.pad(values, ((2, 2), (0, 0)), "wrap"))[2:-2] if self.closed else extrapolated(values)

    def field(self, where: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
        """Return positions x and y, and the field (len x, len y) of a mask at these positions; see :func:`smooth_field`."""
        field = smooth_field(where, self.closed)[self.lines]
        first, last = self.x[[0, -1]] if self.closed else self.x_edges[[0, -1]]
        pieces = math.ceil((last - first) / math.radians(PIECE)) if self.polar else 1
        x = np.unique(np.concatenate([np.linspace(first, last, pieces + 1), self.x]))
        place = np.interp(x, self.x, np.arange(len(self.x)))
        before = np.minimum(place.astype(int), len(self.x) - 2)
        part = (place - before)[:, None]
        field = np.pad((1 - part) * field[before] + part * field[before + 1], ((0, 0), (1, 1)), "edge")
        return x, np.array([self.y_edges[0], *self.y, self.y_edges[-1]]), field


def is_polar(ds: xr.Dataset, dims: Sequence[str], polar: bool | None, ax: Axes | None) -> bool:
    """Whether a slice is polar: as ``polar`` or the given axes require; by default, whether it is over azimuth and tilt."""
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


def rectangular_plane(across: ShownAxis, up: ShownAxis) -> Plane:
    every = np.arange(len(across.values))
    x, y = edges(across.values), edges(up.values)
    ratio = float(np.ptp(y) / np.ptp(x))
    in_space = {across.name, up.name} <= {"x", "y", "z"} and across.unit == up.unit and 1 / SLENDER < ratio < SLENDER
    return Plane(False, x, y, every, across.values, up.values, every, ratio if in_space else None)


def polar_plane(across: ShownAxis, up: ShownAxis) -> Plane:
    """Return a polar grid of sorted azimuths ``across`` and tilts ``up`` [°]."""
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
