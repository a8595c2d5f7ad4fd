"""Maps that are reduced along dimensions while they are computed: largest and mean values, worst poses, numbers of poses.

Dimensions that follow one another with the same operation are a *group* and are reduced together, groups in the order given.
Invalid poses have the value NaN and are skipped. A *slab* is a block of the grid whose variables are in memory at one time. It
contains all poses along all groups but the last; along the last, *partial* results are combined in the order of the slabs. Slabs
depend on the grid only; therefore the numbers are the same for any number of threads.
"""

from __future__ import annotations

import itertools
import math
import re
import warnings
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kinetostatics.arguments import check_mapping
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array, Index, Kept, Values, in_threads
from kinetostatics.units import find_unit, parse_number
from kinetostatics.workspace.block import Progress, compute, warn_of_jumps
from kinetostatics.workspace.dataset import Labels, coordinates, dataset
from kinetostatics.workspace.grid import Axis, Block, block_sizes, cut
from kinetostatics.workspace.store import Arrays
from kinetostatics.workspace.sweep_plan import SweepPlan

if TYPE_CHECKING:
    import xarray as xr

#: Number of poses in a slab, largest number if a slab cannot be smaller, and number in a block of a slab.
SLAB, WHOLE, BLOCK = 2**16, 2**21, 20_000
#: Variables that the assembly modes and the validity of poses need.
NEEDED = ("status", "limit_exceeded", "mode", "platform_pose", "q", "characteristic_length")
OPERATION = re.compile(r"(max|min|mean|argmax|argmin)|(quantile)\s+(0?\.\d+|0|1)|(count)\s*([<>]=?)\s*(.+)")
COMPARISONS = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}


class Group(NamedTuple):
    """Dimensions that are reduced together: the operation as given, and its name, comparison and number; names and sizes."""

    text: str
    name: str
    sign: str
    number: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]

    @property
    def extreme(self) -> np.ufunc:
        return np.fmax if self.name.endswith("max") else np.fmin


class Partial(NamedTuple):
    """Partial result of a group, arrays over the dimensions that are not reduced yet.

    ``values``: of a mean the sum. ``numbers``: numbers of valid poses; of argmax and argmin, the number of the picked pose in the
    group, in the order of the grid. ``places``: by dimension, index of the pose that this or an earlier group picked; −1: none.
    """

    values: Array
    numbers: Index
    places: Mapping[str, Index]

    def part(self, where: Block) -> Partial:
        return Partial(self.values[where], self.numbers[where], {dim: index[where] for dim, index in self.places.items()})


def nothing(group: Group, shape: tuple[int, ...], places: Iterable[str]) -> Partial:
    """Return the partial result of no poses."""
    empty = 0.0 if group.name in ("mean", "count") else np.nan
    return Partial(np.full(shape, empty), np.zeros(shape, dtype=np.intp), {dim: np.full(shape, -1) for dim in places})


def read_groups(reduce: Mapping[str, str], axes: Sequence[Axis]) -> list[Group]:
    """Return the groups of ``reduce``, operations by dimension of the grid."""
    check_mapping("reduce", reduce, '{"rx": "max", "ry": "max"}')
    names = [axis.name for axis in axes]
    groups = []
    for text, pairs in itertools.groupby(reduce.items(), lambda pair: pair[1]):
        chosen = [name for name, _ in pairs]
        for name in chosen:
            if name not in names:
                raise ArgumentError(f"reduce: {name!r} is not swept: {near_names(name, names)}")
        match = OPERATION.fullmatch(text.strip()) if isinstance(text, str) else None
        if match is None:
            raise ArgumentError(
                f"reduce: {text!r} is not an operation: max, min, mean, argmax, argmin, 'quantile 0.95', or 'count > 5e-5', "
                "with >, >=, < or <="
            )
        name, number = match[1] or match[2] or match[4], match[3] or match[6] or ""
        sizes = {axis.name: axis.size for axis in axes if axis.name in chosen}
        groups.append(Group(text, name, match[5] or "", number, tuple(sizes), tuple(sizes.values())))
    return groups


def partial(
    group: Group, values: Array, places: Mapping[str, Index], names: Sequence[str], starts: Mapping[str, int], units: str
) -> Partial:
    """Reduce a quantity along a group.

    Args:
        values, places: the quantity, and indices of poses that earlier groups picked, over the dimensions ``names``.
        starts: index in the grid of the first value along each dimension.
        units: units of the quantity.
    """
    axes = [names.index(dim) for dim in group.dims]

    def flat(array: Kept) -> Kept:
        moved = np.moveaxis(array, axes, range(-len(axes), 0))
        return np.ascontiguousarray(moved).reshape(*moved.shape[: -len(axes)], -1)  # type: ignore[return-value]

    each = flat(values)
    there = ~np.isnan(each)
    counts = np.sum(there, axis=-1)
    if group.name == "mean":
        return Partial(np.sum(np.where(there, each, 0.0), axis=-1), counts, {})
    if group.name == "count":
        unit = find_unit(units)
        limit = parse_number(group.number, unit.kind if unit else "number", f"reduce: {group.text}")
        return Partial(np.sum(COMPARISONS[group.sign](each, limit), axis=-1, dtype=float), counts, {})
    if group.name == "quantile":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # no valid pose
            return Partial(np.asarray(np.nanquantile(each, float(group.number), axis=-1)), counts, {})
    extremes = group.extreme.reduce(each, axis=-1)
    if not group.name.startswith("arg"):
        return Partial(extremes, counts, {})
    first = np.argmax(each == extremes[..., None], axis=-1)
    where = np.unravel_index(first, [values.shape[k] for k in axes])
    here = {dim: starts[dim] + k for dim, k in zip(group.dims, where, strict=True)}
    earlier = {dim: np.take_along_axis(flat(index), first[..., None], -1)[..., 0] for dim, index in places.items()}
    picked = {dim: np.where(counts > 0, index, -1) for dim, index in {**earlier, **here}.items()}
    return Partial(extremes, np.ravel_multi_index(list(here.values()), group.shape), picked)


def combined(group: Group, first: Partial, second: Partial) -> Partial:
    """Return the partial result of two parts of a group."""
    if group.name in ("mean", "count"):
        return Partial(first.values + second.values, first.numbers + second.numbers, {})
    values = group.extreme(first.values, second.values)
    other = (second.values == values) & ((first.values != values) | (second.numbers < first.numbers))
    places = {dim: np.where(other, second.places[dim], index) for dim, index in first.places.items()}
    return Partial(values, np.where(other, second.numbers, first.numbers), places)


def result_of(group: Group, whole: Partial) -> Array:
    """Return the values of a group from the result of all its poses."""
    if group.name != "mean":
        return whole.values
    return np.divide(whole.values, whole.numbers, out=np.full(whole.values.shape, np.nan), where=whole.numbers > 0)


def reduced_map(
    plan: SweepPlan,
    labels: Labels,
    groups: Sequence[Group],
    quantities: Sequence[str],
    attributes: Mapping[str, object],
    number: int,
    progress: Progress,
) -> xr.Dataset:
    """Return the Dataset of reduced quantities and the number of valid poses, over the dimensions that are not reduced.

    Args:
        quantities: names, see :func:`kinetostatics.indices.quantity`; ``plan`` has their variables as outputs.
        number: number of threads.
    """
    import xarray as xr

    from kinetostatics.indices import quantity, valid

    labels = replace(labels, outputs=tuple(name for name in labels.outputs if name in (*NEEDED, *plan.outputs)))
    names, last = [axis.name for axis in plan.axes], groups[-1]
    kept = [k for k, name in enumerate(names) if not any(name in group.dims for group in groups)]
    others = tuple({*range(len(names))} - {*kept})

    def reduced(
        slab: Block, steps: Progress = progress
    ) -> tuple[dict[str, Partial], Index, dict[str, int], dict[str, xr.DataArray]]:
        """Return partial results, numbers of valid poses, numbers of corrected poses, and the quantities without numbers."""
        part = plan.within(slab)
        arrays = Arrays(part, labels, block_sizes(part.axes, BLOCK))
        corrected = compute(arrays, number, steps)
        ds = dataset(part, labels, arrays.arrays, {})
        starts = {name: piece.start for name, piece in zip(names, slab, strict=True)}
        partials, fields = {}, {}
        for what in quantities:
            field = quantity(ds, what)
            values, units, left = field.values, str(field.attrs["units"]), names
            places: Mapping[str, Index] = {}
            for group in groups[:-1]:
                inner = partial(group, values, places, left, starts, units)
                values, places, units = result_of(group, inner), inner.places, "1" if group.sign else units
                left = [name for name in left if name not in group.dims]
            partials[what] = partial(last, values, places, left, starts, units)
            fields[what] = field[(0,) * field.ndim].copy()  # not a view that keeps the whole slab
        return partials, np.sum(valid(ds).values, axis=others), corrected, fields

    tried, _, _, fields = reduced(tuple(slice(0, 1) for _ in names), Progress(1))  # raises errors of names and units
    shape = tuple(plan.axes[k].size for k in kept)
    valid_poses, jumps = np.zeros(shape, dtype=np.int64), Counter[str]()
    totals = {what: nothing(last, shape, result.places) for what, result in tried.items()}
    slabs = list(cut(plan.shape, slab_sizes(plan, groups)))
    for slab, (partials, count, corrected, _) in zip(slabs, in_threads(reduced, slabs, most=number), strict=True):
        where = tuple(slab[k] for k in kept)
        for what, total in totals.items():
            new = combined(last, total.part(where), partials[what])
            total.values[where], total.numbers[where] = new.values, new.numbers
            for dim, index in new.places.items():
                total.places[dim][where] = index
        valid_poses[where] += count
        jumps.update(corrected)
    warn_of_jumps(jumps)
    dims = [names[k] for k in kept]
    data: dict[str, tuple[list[str], Values, dict[str, str]]] = {}
    operations = ", then ".join(f"{group.text} over {' and '.join(group.dims)}" for group in groups)
    for what, field in fields.items():
        units = "1" if any(group.sign for group in groups) else str(field.attrs["units"])
        words = f"{field.attrs['long_name']}: {operations}"
        data[what] = dims, result_of(last, totals[what]), {"units": units, "long_name": words}
        for axis in (axis for axis in plan.axes if axis.name in totals[what].places):
            index = totals[what].places[axis.name]
            at = np.where(index < 0, np.nan if axis.values.dtype.kind in "iuf" else "", axis.values[index])
            more = {"long_name": f"{axis.name} of the pose of {words}", **({"units": axis.units} if axis.units else {})}
            data[f"{what}_at_{axis.name}"] = dims, at if at.dtype.kind == "f" else at.astype(object), more
    data["valid_poses"] = dims, valid_poses, {"units": "1", "long_name": "number of valid poses"}
    coords = {name: array for name, array in coordinates(plan, replace(labels, outputs=())).items() if {*array.dims} <= {*dims}}
    return xr.Dataset(data, coords, {**attributes, **jumps})


def slab_sizes(plan: SweepPlan, groups: Sequence[Group]) -> tuple[int, ...]:
    """Return the sizes of slabs of about ``SLAB`` poses, which extend over the dimensions of the last group before others."""
    undivided = groups if groups[-1].name == "quantile" else groups[:-1]
    whole = [name for group in undivided for name in group.dims]
    count = math.prod(size for group in undivided for size in group.shape)
    if count > WHOLE:
        raise ArgumentError(
            f"reduce: {undivided[-1].text!r} over {' and '.join(whole)} needs all {count:,} poses at once, and at most {WHOLE:,} "
            "are possible: use a coarser grid, or max, min, mean, argmax, argmin or count as the only operation"
        )
    divided = sorted((axis for axis in plan.axes if axis.name not in whole), key=lambda axis: axis.name in groups[-1].dims)
    sizes = dict(zip((axis.name for axis in divided), block_sizes(divided, SLAB // count), strict=True))
    return tuple(sizes.get(axis.name, axis.size) for axis in plan.axes)
