"""The reachable poses of a robot in three dimensions, coloured by a quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, product

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.plot.display_units import coordinate_unit, label
from kinetostatics.plot.masks import check_numbers, level_of, masks_of
from kinetostatics.plot.selection import check_range, chosen_names, in_figure_units, range_of, select
from kinetostatics.plot.slices import SLENDER
from kinetostatics.plot.style import COLOURS, figure_of, legend_below, make_room, solid_axes, styled, title_of, wrapped
from kinetostatics.plot.surfaces import faces

#: Components of ``platform_pose`` that can be axes.
POSITIONS = ("x", "y", "z")
#: Coordinates of the platform; maps over others, such as actuators, are drawn over the position of o.
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
    """Draw the body of all valid poses of a map over three coordinates, its surface coloured by a quantity.

    Args:
        ds, at, unit, value_range, beyond_limits: see :func:`slice`.
        colour: quantity, see :func:`kinetostatics.indices.quantity`.
        axes: names of three swept coordinates, or "x", "y", "z" for the position of o; default: the swept coordinates if they are
            those of the platform, else the position of o.
        cut: whether to remove the octant facing the viewer, to show the inside.
        ax: axes to draw on, with ``projection="3d"``; default: a new figure one column wide.

    Returns:
        The axes; the faces are ``ax.collections[0]``. A face between a valid and an invalid pose has the colour of the valid
        one. The wire frame is the range of the sweep.

    Raises:
        ArgumentError: a name or a value is invalid, or no pose is valid.
    """
    at = dict(at or {})
    check_range(value_range)
    named = list(axes) if axes is not None else [None] * 3
    if len(named) != 3:
        raise ArgumentError(f"a workspace has three axes, not {len(named)}")
    known = all(name is None or name in ds.dims for name in named)
    dims = chosen_names(ds, [None] * 3 if not known else named, at, "a workspace")
    if axes is None and set(dims) <= set(_PLATFORM):
        dims.sort(key=lambda name: name == "z")  # upwards
    elif axes is None:
        known, named = False, list(POSITIONS)
    shown = select(ds, colour, dims, at, beyond_limits)
    if known:
        grid = np.stack(np.meshgrid(*(axis.values for axis in shown.axes), indexing="ij"), axis=-1)
        labels = [axis.label for axis in shown.axes]
    else:
        grid, labels = _positions(ds, [str(name) for name in named], dims, at)
    good = np.isfinite(shown.values) & np.isfinite(grid).all(axis=-1)
    check_numbers(colour, [shown], "this workspace")
    (values,), unit = in_figure_units([shown], unit)
    corners, nodes = skin(grid, level_of(good), _octant(good) & cut)
    levels = values[tuple(nodes.T)]
    span = range_of([levels], value_range)
    low, high = span.low, span.high
    ax = solid_axes(ax, 0.82, "a workspace needs")
    reach = grid.reshape(-1, 3) if known else corners.reshape(-1, 3)
    start, end = np.nanmin(reach, axis=0), np.nanmax(reach, axis=0)
    flat = 0.05 * (end - start).max() * (end <= start)  # the body of a planar robot
    start, end = start - flat, end + flat
    scale = np.where(end > start, end - start, 1.0)
    norm = Normalize(low, high if high > low else low + (abs(low) or 1.0))
    ax.add_collection3d(faces(corners, mpl.colormaps[COLOURS](norm(levels)), scale, 0.25, shown.what))
    ax.set(xlim=(start[0], end[0]), ylim=(start[1], end[1]), zlim=(start[2], end[2]), title=title_of(ax, shown.fixed))
    make_room(ax, labels)
    if set(dims if known else named) == set(POSITIONS) and scale.max() < SLENDER * scale.min():
        ax.set_box_aspect(4 * scale / scale.max(), zoom=1.1)  # lengths as they are
    figure = figure_of(ax)
    bar = ScalarMappable(norm, COLOURS)
    text = wrapped(label(shown.long_name, unit) + span.note, figure)
    figure.colorbar(bar, ax=ax, label=text, shrink=0.65, pad=0.17, extend=span.extend)
    masks = masks_of(shown.values, shown.status)
    if known:
        box = np.array(list(product(*zip(start, end, strict=True))))
        wires = [np.array(pair) for pair in combinations(box, 2) if np.sum(pair[0] != pair[1]) == 1]
        ax.add_collection3d(Line3DCollection(wires, colors="0.35", linewidths=0.6, linestyles=":", zorder=2))
    if masks:
        part = [f"{mask.label} {100 * mask.where.mean():.2g} %" for mask in masks]
        note = Patch(facecolor="white", edgecolor="0.35", linestyle=":", label="not drawn: " + ", ".join(part))
        legend_below(figure, [note])
    return ax


def skin(points: Array, field: Array, cut: NDArray[np.bool_]) -> tuple[Array, NDArray[np.intp]]:
    """Return the zero surface of a field over a grid, with a face for each pair of neighbours of different signs.

    A corner of faces is the mean of the intersections of a cell's edges with the surface (dual contouring of the cells). Outside
    the grid, the field is negative.

    Args:
        points: (nx, ny, nz, 3) positions of the nodes; NaN where unknown.
        field: (nx, ny, nz) field, positive inside.
        cut: (nx, ny, nz) mask of removed nodes; the surface is midway between them and their neighbours.

    Returns:
        Corners (m, 4, 3) of the faces, and the indices (m, 3) of their inner nodes.
    """
    around = [(1, 1)] * 3
    field = np.pad(np.where(cut, -1.0, field), around, constant_values=-1.0)
    cut, points = np.pad(cut, around), np.pad(points, [*around, (0, 0)], "edge")
    total, count = (np.zeros((*(size - 1 for size in field.shape), last)) for last in (3, 1))
    found = []
    for axis in range(3):
        ends = [tuple(np.s_[k : k - 1 or None] if n == axis else np.s_[1:-1] for n in range(3)) for k in (0, 1)]
        (near, far), (one, two) = (field[end] for end in ends), (points[end] for end in ends)
        passes = (near > 0) != (far > 0)
        one, two = (np.where(np.isfinite(a), a, b) for a, b in ((one, two), (two, one)))
        part = np.divide(near, near - far, out=np.full(near.shape, 0.5), where=passes & ~cut[ends[0]] & ~cut[ends[1]])
        through = np.where(passes[..., None], one + part[..., None] * (two - one), 0.0)
        across, up = np.eye(3, dtype=np.intp)[[n for n in range(3) if n != axis]]
        cells = np.stack([0 * across, across, across + up, up])
        for cell in cells:
            place = tuple(np.s_[first : first + size] for first, size in zip(cell, passes.shape, strict=True))
            total[place] += through
            count[place] += passes[..., None]
        first = np.argwhere(passes)
        inside = first + np.eye(3, dtype=np.intp)[axis] * (far[passes] > 0)[:, None]
        found.append((first[:, None] + cells, inside - np.eye(3, dtype=np.intp)[axis]))
    corners, nodes = (np.concatenate(part) for part in zip(*found, strict=True))
    return (total / np.maximum(count, 1))[tuple(np.moveaxis(corners, -1, 0))], nodes


def _positions(ds: xr.Dataset, named: Sequence[str], dims: Sequence[str], at: Mapping[str, float]) -> tuple[Array, list[str]]:
    """Return the positions of o (…, 3) over ``dims`` in display units, and the axes' labels."""
    strange = [name for name in named if name not in POSITIONS]
    if strange:
        raise ArgumentError(f"{strange[0]!r} is not swept; axes= needs three swept coordinates, or x, y, z for the position of o")
    parts = [select(ds, f"platform_pose:{name}", dims, at, True).values for name in named]
    grid = np.stack(parts, axis=-1)
    size, unit = coordinate_unit("m", np.nan_to_num(grid))
    return grid / size, [label(name, unit) for name in named]


def _octant(good: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask of the octant of large first, small second, large third coordinate; empty if it contains the body."""
    octant = np.zeros_like(good)
    first, second, third = (size // 2 for size in good.shape)
    octant[good.shape[0] - first :, :second, good.shape[2] - third :] = True
    return octant & bool((good & ~octant).any())
