"""A sweep as dask arrays: a graph with one task a block, which computes it wherever dask wants it computed."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Values
from kinetostatics.workspace.block import compute_block
from kinetostatics.workspace.grid import Block, block_sizes, chunk_sizes, cut, sizes_of
from kinetostatics.workspace.schema import Labels, template, variables
from kinetostatics.workspace.sweep_spec import SweepSpec
from kinetostatics.workspace.targets import Target, in_memory

if TYPE_CHECKING:
    import xarray as xr
    from dask.typing import Key

#: Poses of a chunk with chunks="auto".
AUTO = 20_000


@dataclass(frozen=True, eq=False)
class Job:
    """What all tasks of a graph share; dask sends it once to every worker."""

    spec: SweepSpec
    labels: Labels


def lazy_block(job: Job, bounds: tuple[tuple[int, int], ...]) -> dict[str, Values]:
    """Return the variables of a block, which knows nothing of the blocks beside it."""
    spec, labels = job.spec, job.labels
    block: Block = tuple(slice(*pair) for pair in bounds)
    part = template(spec, labels).isel({axis.name: piece for axis, piece in zip(spec.axes, block, strict=True)})
    target = Target(spec, labels, in_memory(part), block)
    target.write_block(block, compute_block(spec, labels, block))
    cases, region = spec.part(block, "case"), spec.part(block, "coordinate")
    for combination in spec.combinations(block):
        finished = target.to_finish(combination, cases, region)(spec, labels)
        target.patch(combination, cases, region, finished, sizes_of(region))
    return dict(target.arrays)


def lazy_dataset(spec: SweepSpec, labels: Labels, chunks: Mapping[str, int] | str) -> xr.Dataset:
    """Return a Dataset of dask arrays.

    Args:
        spec: of the sweep.
        labels: of the Dataset.
        chunks: sizes of the blocks by dimension, or "auto".

    Raises:
        ArgumentError: the chunks make no sense.
    """
    import dask.array as da
    from dask.highlevelgraph import HighLevelGraph

    if isinstance(chunks, str):
        if chunks != "auto":
            raise ArgumentError(f"chunks is {chunks!r}; it must be sizes by dimension, or 'auto'")
        sizes = block_sizes(spec.axes, AUTO)
    else:
        sizes = chunk_sizes(spec.axes, chunks)
    token = spec.identity[:16] + "-" + "-".join(map(str, sizes))
    job, blocks = f"sweep-spec-{token}", f"sweep-{token}"
    counts = [range(-(-n // size)) for n, size in zip(spec.shape, sizes, strict=True)]
    numbers = [tuple(int(k) for k in place) for place in np.ndindex(*(len(count) for count in counts))]
    graph: dict[str, dict[Key, object]] = {job: {job: Job(spec, labels)}, blocks: {}}
    for place, block in zip(numbers, cut(spec.shape, sizes), strict=True):
        bounds = tuple((piece.start, piece.stop) for piece in block)
        graph[blocks][(blocks, *place)] = (lazy_block, job, bounds)
    dependencies: dict[str, set[str]] = {job: set(), blocks: {job}}
    whole = template(spec, labels)
    data = {}
    for name, item in variables(labels).items():
        layer = f"sweep-{name}-{token}"
        mine = [axis.kind in item.varies for axis in spec.axes]
        own = whole[name].shape[sum(mine) :]
        zeros = (0,) * len(own)
        tasks: dict[Key, object] = {}
        for place in numbers:
            if any(k and not here for k, here in zip(place, mine, strict=True)):
                continue  # alike in all blocks along axes that it does not have
            own_place = tuple(k for k, here in zip(place, mine, strict=True) if here)
            tasks[(layer, *own_place, *zeros)] = (operator.getitem, (blocks, *place), name)
        pieces = tuple(
            tuple(min(size, n - start) for start in range(0, n, size))
            for n, size, here in zip(spec.shape, sizes, mine, strict=True)
            if here
        )
        found = HighLevelGraph({**graph, layer: tasks}, {**dependencies, layer: {blocks}})
        array = da.Array(found, layer, (*pieces, *((n,) for n in own)), dtype=item.dtype)  # type: ignore[no-untyped-call]
        data[name] = (whole[name].dims, array, whole[name].attrs)
    return whole.assign(data)
