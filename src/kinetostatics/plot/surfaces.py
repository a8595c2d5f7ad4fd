"""Surfaces of a quantity over two coordinates, one for each value of a third."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.display_units import label, typeset
from kinetostatics.plot.masks import areas_of, check_numbers, common_masks, continued, level_of
from kinetostatics.plot.selection import check_range, chosen_names, free_names, in_figure_units, range_of, select_each
from kinetostatics.plot.style import (
    COLOURS,
    ONE_COLUMN,
    figure_of,
    legend_below,
    make_room,
    new_panels,
    solid_axes,
    styled,
    title_of,
    wrapped,
)

#: Largest number of surfaces without explicit choice.
SURFACES = 5
#: Median distance of adjacent surfaces, as a part of the range of heights, below which each has its own panel.
NEAR = 0.05
#: Greys of the floor, one for each reason for missing values.
GREYS = ("0.85", "0.7", "0.55", "0.4", "0.25")


@styled
def surface(
    ds: xr.Dataset,
    what: str = "linear_sag",
    x: str | None = None,
    y: str | None = None,
    *,
    series: str | Mapping[str, Sequence[float]] | None = None,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    value_range: tuple[float, float] | None = None,
    beyond_limits: bool = False,
    legend: bool = True,
    ax: Axes3D | None = None,
) -> Axes3D:
    """Draw a quantity over two of the swept coordinates as surfaces, like the paper's Figs 6, 7, 12 and 13.

    Args:
        ds, what, at, unit, beyond_limits: see :func:`slice`.
        x: first horizontal coordinate; default for x and y: the last two swept coordinates that are not fixed.
        y: second horizontal coordinate.
        series: a third coordinate, with a surface for each value, or for five evenly chosen ones (with a note and a warning); or
            ``{"z": [0.3, 0.6]}`` to choose values; default: the remaining coordinate, if any.
        value_range: range of heights, in the unit of the figure, at which surfaces are cut off; default: all values except few
            outliers, whose range the figure then gives.
        legend: whether to add a legend of surfaces and of grey areas.
        ax: axes to draw on, with ``projection="3d"``; default: a new figure one column wide.

    Returns:
        The axes; all surfaces are ``ax.collections[0]``. They have holes at invalid poses; the floor is grey where no surface is
        valid.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose has a number.
    """
    at = dict(at or {})
    check_range(value_range)
    third = series if isinstance(series, str) or series is None else next(iter(series))
    if x is None and y is None and third is None:
        free = free_names(ds, at)
        if len(free) == 3:
            third = free[0]
    x, y = chosen_names(ds, (x, y), (*at, third or ""), "a surface")
    if third is None:
        left = free_names(ds, (*at, x, y))
        third = left[0] if len(left) == 1 else None
    parts, left_out = select_each(ds, what, (x, y), series or third, SURFACES, at, beyond_limits)
    for axis in next(iter(parts.values())).axes:
        if len(axis.values) == 1:
            raise ArgumentError(f"{axis.name} has one value; a surface needs several values along both of its axes")
    check_numbers(what, list(parts.values()), "these surfaces")
    values, unit = in_figure_units(list(parts.values()), unit)
    first = next(iter(parts.values()))
    across, up = first.axes
    span = range_of(values, value_range)
    low, high = span.low, span.high
    values = [np.clip(numbers, low, high) for numbers in values]
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    apart = ax is None and _coincide(values, low, high)
    sheets = [[k] for k in range(len(parts))] if apart else [[*range(len(parts))]]
    axes: list[Axes3D] = [solid_axes(ax, 0.95, "surfaces need")] if not apart else []
    axes = axes or [*new_panels(len(parts), 0.65 * ONE_COLUMN, 0.6 * ONE_COLUMN, "3d")]
    figure = figure_of(axes[0])
    scale = np.array([np.ptp(across.values) or 1.0, np.ptp(up.values) or 1.0, high - low])
    colour_of = mpl.colormaps[COLOURS]
    steps, names, selections = np.linspace(0.05, 0.95, len(parts)), list(parts), list(parts.values())
    plane = np.meshgrid(across.values, up.values, indexing="ij")
    floor = low - 0.08 * (high - low)
    patches: dict[str, Patch] = {}
    for panel, mine in zip(axes, sheets, strict=True):
        quads, colours = [], []
        for k in mine:
            found = cut_cells(np.dstack([*plane, np.clip(continued(values[k]), low, high)]), level_of(np.isfinite(values[k])))
            part = (found[:, :4, 2].mean(axis=1) - low) / (high - low) if len(mine) == 1 else np.full(len(found), steps[k])
            quads.append(found)
            colours.append(colour_of(part))
        # a single collection, since Matplotlib sorts faces by depth within a collection only
        panel.add_collection3d(faces(np.concatenate(quads), np.concatenate(colours), scale, 0.35, first.what))
        masks = common_masks([selections[k] for k in mine])
        for mask, where in zip(masks, areas_of(masks), strict=True):
            grey = patches[mask.label].get_facecolor() if mask.label in patches else GREYS[len(patches)]
            ground = cut_cells(np.dstack([*plane, np.full_like(plane[0], floor)]), level_of(where))
            cells = Poly3DCollection(list(ground), facecolors=grey, edgecolors="none", label=mask.label, zorder=2)
            panel.add_collection3d(cells)
            patches.setdefault(mask.label, Patch(facecolor=grey, edgecolor="0.4", linewidth=0.4, label=mask.label))
        panel.set(xlim=across.values[[0, -1]], ylim=up.values[[0, -1]], zlim=(floor, high))
        panel.set_title(title_of(panel, names[mine[0]] if apart else first.fixed))
        make_room(panel, (across.label, up.label, ""))
    text = label(first.long_name, unit) + span.note
    if apart or len(parts) == 1:
        mappable = ScalarMappable(Normalize(low, high), COLOURS)
        figure.colorbar(
            mappable,
            ax=axes,
            label=wrapped(text, figure),
            shrink=0.95 if apart else 0.65,
            pad=0.02 if apart else 0.1,
            extend=span.extend,
        )
    if apart:
        figure.suptitle(title_of(axes[0], ", ".join(filter(None, (first.fixed, left_out)))))
    elif len(parts) > 1:
        whole = title_of(axes[0], ", ".join(filter(None, (text, first.fixed))))
        axes[0].set_title("\n".join(filter(None, (whole, left_out))))
    if legend:
        named = [
            Patch(facecolor=colour_of(step), edgecolor="black", linewidth=0.3, label=typeset(name))
            for step, name in zip(steps, names, strict=True)
            if name and not apart
        ]
        legend_below(figure, [*named, *patches.values()])
    return axes[0]


def _coincide(sheets: Sequence[Array], low: float, high: float) -> bool:
    """Return whether the median distance of two successive surfaces is below :data:`NEAR` of the range of heights."""
    gaps = [np.abs(two - one) for one, two in pairwise(sheets)]
    return any(np.nanmedian(gap) < NEAR * (high - low) for gap in gaps if np.isfinite(gap).any())


#: Direction towards the light, and the part of a face's brightness that is independent of it.
LIGHT = np.array([-0.35, -0.55, 0.76])
AMBIENT = 0.72


def cut_cells(points: Array, field: Array) -> Array:
    """Return the cells between points (nx, ny, 3) of a grid, clipped to the area in which a field (nx, ny) is positive.

    Returns:
        Polygons (m, 6, 3); the last corner is repeated if there are fewer.
    """
    nx, ny = field.shape
    places = [np.s_[i : nx - 1 + i, j : ny - 1 + j] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    quads = np.stack([points[place] for place in places], axis=2)
    levels = np.stack([field[place] for place in places], axis=2)
    whole, some = (levels > 0).all(axis=2), (levels > 0).any(axis=2)
    found = [quads[whole][:, [0, 1, 2, 3, 3, 3]]]
    for quad, level in zip(quads[some & ~whole], levels[some & ~whole], strict=True):
        ring = []
        for k in range(4):
            near, far = level[k], level[(k + 1) % 4]
            if near > 0:
                ring.append(quad[k])
            if (near > 0) != (far > 0):
                ring.append(quad[k] + near / (near - far) * (quad[(k + 1) % 4] - quad[k]))
        found.append(np.array([ring + (6 - len(ring)) * ring[-1:]]))
    return np.concatenate(found)


def faces(quads: Array, colours: Array, scale: Array, edge: float, label: str) -> Poly3DCollection:
    """Return a collection of faces, shaded by their angle to the light; both sides are alike.

    Args:
        quads: (m, n, 3) corners.
        colours: (m, 4) RGBA colours of the faces.
        scale: (3,) lengths of the axes' box, to which normals are scaled.
        edge: opacity of the black edges.
        label: label of the collection.
    """
    normals = np.cross((quads[:, 2] - quads[:, 0]) / scale, (quads[:, 3] - quads[:, 1]) / scale)
    size = np.linalg.norm(normals, axis=1)
    brightness = AMBIENT + (1 - AMBIENT) * np.abs(normals @ LIGHT) / np.where(size > 0, size, 1)
    lit = np.column_stack([colours[:, :3] * brightness[:, None], colours[:, 3]])
    return Poly3DCollection(list(quads), facecolors=lit, edgecolors=(0, 0, 0, edge), linewidths=0.2, label=label, zorder=3)
