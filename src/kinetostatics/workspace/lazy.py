"""Sweeps as dask arrays: each chunk is a separate sweep, computed by dask's scheduler."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from kinetostatics.exceptions import ArgumentError
from kinetostatics.workspace.dataset import Labels, dataset, shapes
from kinetostatics.workspace.grid import block_sizes, chunk_sizes
from kinetostatics.workspace.sweep_plan import SweepPlan

if TYPE_CHECKING:
    import xarray as xr

#: Number of poses in a chunk with chunks="auto".
AUTO = 20_000


def lazy_dataset(
    plan: SweepPlan,
    labels: Labels,
    chunks: Mapping[str, int] | str,
    attributes: Mapping[str, object],
    computed: Callable[..., xr.Dataset],
) -> xr.Dataset:
    """Return a Dataset of dask arrays.

    Args:
        plan: plan of the sweep.
        labels: labels of the Dataset.
        chunks: sizes along dimensions, or "auto".
        attributes: attributes of the Dataset.
        computed: function that returns the Dataset for a plan, labels, block sizes, attributes and a number of threads.

    Raises:
        ArgumentError: the chunks are invalid.
    """
    import dask.array as da
    import xarray as xr

    if isinstance(chunks, str):
        if chunks != "auto":
            raise ArgumentError(f"chunks is {chunks!r}; it must be sizes by dimension, or 'auto'")
        sizes = block_sizes(plan.axes, AUTO)
    else:
        sizes = chunk_sizes(plan.axes, chunks)
    pieces = dict(zip((axis.name for axis in plan.axes), sizes, strict=True))
    empty = {
        name: da.empty(shape, dtype=item.dtype, chunks=_pieces(plan, pieces, item.varies, shape))  # type: ignore[no-untyped-call]
        for (name, shape), item in zip(shapes(plan, labels).items(), labels.variables.values(), strict=True)
    }
    whole = dataset(plan, labels, empty, attributes)
    numbers = {
        f"number of {axis.name}": (axis.name, da.arange(axis.size, chunks=size))  # type: ignore[no-untyped-call]
        for axis, size in zip(plan.axes, sizes, strict=True)
    }
    found = xr.map_blocks(_chunk, xr.Dataset(numbers, whole.coords), (plan, labels, computed), template=whole)
    return found.assign_coords(whole.coords)  # labels and units are known already


def _pieces(plan: SweepPlan, sizes: Mapping[str, int], varies: tuple[str, ...], shape: tuple[int, ...]) -> tuple[int, ...]:
    mine = [sizes[axis.name] for axis in plan.axes if axis.kind in varies]
    return (*mine, *shape[len(mine) :])


def _chunk(numbers: xr.Dataset, plan: SweepPlan, labels: Labels, computed: Callable[..., xr.Dataset]) -> xr.Dataset:
    """Compute a chunk."""
    ends = (numbers[f"number of {axis.name}"].values for axis in plan.axes)
    part = plan.within(tuple(slice(int(found[0]), int(found[-1]) + 1) for found in ends))
    return computed(part, labels, block_sizes(part.axes, AUTO), {}, 1)
