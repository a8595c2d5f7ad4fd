"""Figures in three dimensions: surfaces of a quantity over two coordinates, and the body of all valid poses of a map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise, product

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.masks import areas_of, check_numbers, common_masks, extrapolated, masks_of, smooth_field
from kinetostatics.plot.selection import (
    check_range,
    chosen_names,
    coordinate_unit,
    free_names,
    in_figure_units,
    label,
    range_of,
    select,
    select_each,
    typeset,
)
from kinetostatics.plot.slices import SLENDER
from kinetostatics.plot.style import (
    COLOURS,
    ONE_COLUMN,
    figure_of,
    legend_below,
    new_panels,
    set_up_solid_axes,
    solid_axes,
    styled,
    title_of,
    wrapped,
)

#: Largest number of surfaces without explicit choice.
SURFACES = 5
#: Median distance of adjacent surfaces, as a part of the range of heights, below which each one is drawn in a panel of its own.
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
    """Draw surfaces of a quantity over two of the swept coordinates, like the paper's Figs 6, 7, 12 and 13.

    Args:
        ds, what, at, unit, beyond_limits: see :func:`slice`.
        x: first horizontal coordinate; default for x and y: the last two swept coordinates that are not fixed.
        y: second horizontal coordinate.
        series: a third coordinate, with a surface for each value; of more than five values five are drawn, with a note and a
            warning. Or ``{"z": [0.3, 0.6]}``, to choose values. Default: the remaining coordinate, if any.
        value_range: lowest and highest height, in the unit of the figure; other heights are set to these limits. Default: the
            range of all values but a few outliers; a note then gives the range of the outliers.
        legend: whether to add a legend of surfaces and of grey areas.
        ax: axes to draw on, with ``projection="3d"``; default: a new figure one column wide.

    Returns:
        The axes; all surfaces are ``ax.collections[0]``. They have holes at invalid poses; at poses where no surface is valid,
        the floor is grey.

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
    for panel, sheet in zip(axes, sheets, strict=True):
        quads, colours = [], []
        for k in sheet:
            polygons = cut_cells(
                np.dstack([*plane, np.clip(extrapolated(values[k]), low, high)]), smooth_field(np.isfinite(values[k]))
            )
            part = (polygons[:, :4, 2].mean(axis=1) - low) / (high - low) if len(sheet) == 1 else np.full(len(polygons), steps[k])
            quads.append(polygons)
            colours.append(colour_of(part))
        # a single collection, since Matplotlib sorts faces by depth within a collection only
        panel.add_collection3d(faces(np.concatenate(quads), np.concatenate(colours), scale, 0.35, first.what))
        masks = common_masks([selections[k] for k in sheet])
        for mask, where in zip(masks, areas_of(masks), strict=True):
            grey = patches[mask.label].get_facecolor() if mask.label in patches else GREYS[len(patches)]
            ground = cut_cells(np.dstack([*plane, np.full_like(plane[0], floor)]), smooth_field(where))
            cells = Poly3DCollection(list(ground), facecolors=grey, edgecolors="none", label=mask.label, zorder=2)
            panel.add_collection3d(cells)
            patches.setdefault(mask.label, Patch(facecolor=grey, edgecolor="0.4", linewidth=0.4, label=mask.label))
        panel.set(xlim=across.values[[0, -1]], ylim=up.values[[0, -1]], zlim=(floor, high))
        panel.set_title(title_of(panel, names[sheet[0]] if apart else first.fixed))
        set_up_solid_axes(panel, (across.label, up.label, ""))
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
    """Whether the median distance of any two successive surfaces is too small to tell them apart."""
    gaps = [np.abs(second - first) for first, second in pairwise(sheets)]
    return any(np.nanmedian(gap) < NEAR * (high - low) for gap in gaps if np.isfinite(gap).any())


#: Direction to the light, and the part of a face's brightness that is independent of this direction.
LIGHT = np.array([-0.35, -0.55, 0.76])
AMBIENT = 0.72


def cut_cells(points: Array, field: Array) -> Array:
    """Return the cells of a grid of points (nx, ny, 3), clipped to the area in which a field (nx, ny) is positive.

    Returns:
        Polygons (m, 6, 3); polygons with fewer corners repeat their last corner.
    """
    nx, ny = field.shape
    places = [np.s_[i : nx - 1 + i, j : ny - 1 + j] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    quads = np.stack([points[place] for place in places], axis=2)
    levels = np.stack([field[place] for place in places], axis=2)
    whole, some = (levels > 0).all(axis=2), (levels > 0).any(axis=2)
    polygons = [quads[whole][:, [0, 1, 2, 3, 3, 3]]]
    for quad, level in zip(quads[some & ~whole], levels[some & ~whole], strict=True):
        ring = []
        for k in range(4):
            near, far = level[k], level[(k + 1) % 4]
            if near > 0:
                ring.append(quad[k])
            if (near > 0) != (far > 0):
                ring.append(quad[k] + near / (near - far) * (quad[(k + 1) % 4] - quad[k]))
        polygons.append(np.array([ring + (6 - len(ring)) * ring[-1:]]))
    return np.concatenate(polygons)


def faces(quads: Array, colours: Array, scale: Array, edge: float, label: str) -> Poly3DCollection:
    """Return a collection of faces, shaded by their angle to the light; both sides have the same colour.

    Args:
        quads: (m, n, 3) corners.
        colours: (m, 4) RGBA colours of the faces.
        scale: (3,) ranges of the three axes, by which positions are divided before angles to the light are computed.
        edge: opacity of the black edges.
        label: label of the collection.
    """
    normals = np.cross((quads[:, 2] - quads[:, 0]) / scale, (quads[:, 3] - quads[:, 1]) / scale)
    size = np.linalg.norm(normals, axis=1)
    brightness = AMBIENT + (1 - AMBIENT) * np.abs(normals @ LIGHT) / np.where(size > 0, size, 1)
    lit = np.column_stack([colours[:, :3] * brightness[:, None], colours[:, 3]])
    return Poly3DCollection(list(quads), facecolors=lit, edgecolors=(0, 0, 0, edge), linewidths=0.2, label=label, zorder=3)


#: Components of ``platform_pose`` for the axes.
POSITIONS = ("x", "y", "z")
#: Coordinates of the platform; maps over other coordinates, such as actuators, are drawn over the position of o.
_PLATFORM = (*POSITIONS, "rx", "ry", "rz", "azimuth", "tilt", "torsion")


@styled
def workspace(
    ds: xr.Dataset,
    colour: str = "linear_sag",
    axes: Sequence[str] | None = None,
    *,
    at: Mapping[str, float] | None = None,
    unit: str | None = None,
    value_range: tuple[float, float] | None = None,
    cut: bool = True,
    beyond_limits: bool = False,
    ax: Axes3D | None = None,
) -> Axes3D:
    """Draw the body of all valid poses over three coordinates; a quantity colours its surface.

    Args:
        ds, at, unit, value_range, beyond_limits: see :func:`slice`.
        colour: quantity, see :func:`kinetostatics.indices.quantity`.
        axes: names of three swept coordinates, or "x", "y", "z" for the position of o. Default: the swept coordinates if they are
            coordinates of the platform, else the position of o.
        cut: whether to remove the octant nearest to the viewer, to show the inside.
        ax: axes to draw on, with ``projection="3d"``; default: a new figure one column wide.

    Returns:
        The axes; the faces are ``ax.collections[0]``. A face between a valid and an invalid pose has the colour of the valid
        pose. Dotted lines are the edges of the swept box.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose is valid.
    """
    at = dict(at or {})
    check_range(value_range)
    named = list(axes) if axes is not None else [None] * 3
    if len(named) != 3:
        raise ArgumentError(f"a workspace has three axes, not {len(named)}")
    are_swept = all(name is None or name in ds.dims for name in named)
    dims = chosen_names(ds, [None] * 3 if not are_swept else named, at, "a workspace")
    if axes is None and set(dims) <= set(_PLATFORM):
        dims.sort(key=lambda name: name == "z")  # upwards
    elif axes is None:
        are_swept, named = False, list(POSITIONS)
    shown = select(ds, colour, dims, at, beyond_limits)
    if are_swept:
        grid = np.stack(np.meshgrid(*(axis.values for axis in shown.axes), indexing="ij"), axis=-1)
        labels = [axis.label for axis in shown.axes]
    else:
        grid, labels = _positions(ds, [str(name) for name in named], dims, at)
    good = np.isfinite(shown.values) & np.isfinite(grid).all(axis=-1)
    check_numbers(colour, [shown], "this workspace")
    (values,), unit = in_figure_units([shown], unit)
    corners, nodes = skin(grid, smooth_field(good), _octant(good) & cut)
    levels = values[tuple(nodes.T)]
    span = range_of([levels], value_range)
    low, high = span.low, span.high
    ax = solid_axes(ax, 0.82, "a workspace needs")
    reach = grid.reshape(-1, 3) if are_swept else corners.reshape(-1, 3)
    start, end = np.nanmin(reach, axis=0), np.nanmax(reach, axis=0)
    flat = 0.05 * (end - start).max() * (end <= start)  # the body of a planar robot
    start, end = start - flat, end + flat
    scale = np.where(end > start, end - start, 1.0)
    norm = Normalize(low, high if high > low else low + (abs(low) or 1.0))
    ax.add_collection3d(faces(corners, mpl.colormaps[COLOURS](norm(levels)), scale, 0.25, shown.what))
    ax.set(xlim=(start[0], end[0]), ylim=(start[1], end[1]), zlim=(start[2], end[2]), title=title_of(ax, shown.fixed))
    set_up_solid_axes(ax, labels)
    if set(dims if are_swept else named) == set(POSITIONS) and scale.max() < SLENDER * scale.min():
        ax.set_box_aspect(4 * scale / scale.max(), zoom=1.1)  # lengths as they are
    figure = figure_of(ax)
    bar = ScalarMappable(norm, COLOURS)
    text = wrapped(label(shown.long_name, unit) + span.note, figure)
    figure.colorbar(bar, ax=ax, label=text, shrink=0.65, pad=0.17, extend=span.extend)
    masks = masks_of(shown.values, shown.status)
    if are_swept:
        box = np.array(list(product(*zip(start, end, strict=True))))
        wires = [np.array(pair) for pair in combinations(box, 2) if np.sum(pair[0] != pair[1]) == 1]
        ax.add_collection3d(Line3DCollection(wires, colors="0.35", linewidths=0.6, linestyles=":", zorder=2))
    if masks:
        part = [f"{mask.label} {100 * mask.where.mean():.2g} %" for mask in masks]
        note = Patch(facecolor="white", edgecolor="0.35", linestyle=":", label="not drawn: " + ", ".join(part))
        legend_below(figure, [note])
    return ax


def skin(points: Array, field: Array, cut: NDArray[np.bool_]) -> tuple[Array, NDArray[np.intp]]:
    """Return the zero surface of a field over a grid: one face between any two neighbouring nodes where its signs differ.

    Each corner of a face is inside a cell of the grid, at the mean of the intersections of the cell's edges with the surface
    (dual contouring). Outside the grid, the field is negative.

    Args:
        points: (nx, ny, nz, 3) positions of the nodes; NaN where unknown.
        field: (nx, ny, nz) field, positive inside.
        cut: (nx, ny, nz) True at removed nodes; the surface is midway between removed nodes and their neighbours.

    Returns:
        Corners (m, 4, 3) of the faces, and indices (m, 3) of the node on the positive side of each face.
    """
    around = [(1, 1)] * 3
    field = np.pad(np.where(cut, -1.0, field), around, constant_values=-1.0)
    cut, points = np.pad(cut, around), np.pad(points, [*around, (0, 0)], "edge")
    total, count = (np.zeros((*(size - 1 for size in field.shape), last)) for last in (3, 1))
    face_indices = []
    for axis in range(3):
        ends = [tuple(np.s_[k : k - 1 or None] if n == axis else np.s_[1:-1] for n in range(3)) for k in (0, 1)]
        (near, far), (start, end) = (field[side] for side in ends), (points[side] for side in ends)
        passes = (near > 0) != (far > 0)
        start, end = (np.where(np.isfinite(a), a, b) for a, b in ((start, end), (end, start)))
        part = np.divide(near, near - far, out=np.full(near.shape, 0.5), where=passes & ~cut[ends[0]] & ~cut[ends[1]])
        through = np.where(passes[..., None], start + part[..., None] * (end - start), 0.0)
        across, up = np.eye(3, dtype=np.intp)[[n for n in range(3) if n != axis]]
        cells = np.stack([0 * across, across, across + up, up])
        for cell in cells:
            place = tuple(np.s_[first : first + size] for first, size in zip(cell, passes.shape, strict=True))
            total[place] += through
            count[place] += passes[..., None]
        first = np.argwhere(passes)
        inside = first + np.eye(3, dtype=np.intp)[axis] * (far[passes] > 0)[:, None]
        face_indices.append((first[:, None] + cells, inside - np.eye(3, dtype=np.intp)[axis]))
    corners, nodes = (np.concatenate(part) for part in zip(*face_indices, strict=True))
    return (total / np.maximum(count, 1))[tuple(np.moveaxis(corners, -1, 0))], nodes


def _positions(ds: xr.Dataset, named: Sequence[str], dims: Sequence[str], at: Mapping[str, float]) -> tuple[Array, list[str]]:
    """Return positions of o (…, 3) over ``dims``, and labels of the axes, both in display units."""
    strange = [name for name in named if name not in POSITIONS]
    if strange:
        raise ArgumentError(f"{strange[0]!r} is not swept; axes= needs three swept coordinates, or x, y, z for the position of o")
    parts = [select(ds, f"platform_pose:{name}", dims, at, True).values for name in named]
    grid = np.stack(parts, axis=-1)
    size, unit = coordinate_unit("m", np.nan_to_num(grid))
    return grid / size, [label(name, unit) for name in named]


def _octant(good: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask of the octant nearest to the viewer: large first, small second, large third coordinate.

    The mask is False everywhere if this octant contains the whole body.
    """
    octant = np.zeros_like(good)
    first, second, third = (size // 2 for size in good.shape)
    octant[good.shape[0] - first :, :second, good.shape[2] - third :] = True
    return octant & bool((good & ~octant).any())
