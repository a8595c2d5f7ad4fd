"""Where the numbers of a sweep go: arrays in memory, a netCDF file, a zarr store; written and read by parts of the grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from kinetostatics.math.arrays import Index, Values
from kinetostatics.workspace.assembly_modes.repair import Finished, finish
from kinetostatics.workspace.grid import Block, cut, sizes_of
from kinetostatics.workspace.schema import ZERO_MODE, Labels, variables
from kinetostatics.workspace.sweep_spec import Combination, SweepSpec

if TYPE_CHECKING:
    import xarray as xr

Stored: TypeAlias = Any  # arrays and groups of NumPy, h5netcdf and zarr: their types have nothing in common
#: Arrays of a file, and what writes its attributes and closes it.
Created: TypeAlias = tuple[dict[str, Stored], Callable[[Mapping[str, object]], None]]


class Target:
    """The variables of a sweep, over the whole grid or a block of it.

    Attributes:
        arrays: NumPy's, or others that are written and read by slices.
    """

    def __init__(self, spec: SweepSpec, labels: Labels, arrays: Mapping[str, Stored], block: Block | None = None) -> None:
        self.spec, self.labels, self.arrays = spec, labels, arrays
        self._items = variables(labels)
        self._origin = [piece.start for piece in block] if block else [0] * len(spec.axes)

    def write(self, name: str, block: Block, values: Values) -> None:
        """Write a part of a variable: what it has of a block of the grid, of which it may lack axes."""
        where, array = self._where(name, block), self.arrays[name]
        shape = (*sizes_of(where), *array.shape[len(where) :])
        array[where or ...] = np.asarray(values).reshape(shape).astype(array.dtype, copy=False)

    def read(self, name: str, block: Block) -> Values:
        """Return a part of a variable."""
        return np.asarray(self.arrays[name][self._where(name, block) or ...])

    def _where(self, name: str, block: Block) -> Block:
        kinds = self._items[name].varies
        pieces = zip(block, self._origin, self.spec.axes, strict=True)
        return tuple(slice(p.start - start, p.stop - start) for p, start, axis in pieces if axis.kind in kinds)

    def write_block(self, block: Block, numbers: Mapping[str, Values]) -> None:
        """Write all variables of a block."""
        for name in self._items:
            self.write(name, block, numbers[name])

    # ---- the second look --------------------------------------------------------------------------------------------

    def to_finish(self, combination: Combination, cases: Block, region: Block) -> partial[Finished]:
        """Return the second look at a region of one robot, with what is known of it before."""
        block, one = self._block(combination, cases, region), (0,) * len(combination)
        q = self.read("q", block)[one]
        if any(self.labels.loose):  # they tell nothing, but x, y, z of o do
            q = np.concatenate([q, self.read("platform_pose", block)[one][..., :3]], axis=-1)
        length = float(self.read("characteristic_length", block)[one])
        known = {"q": q, "reached": self.read("mode", block)[one] == ZERO_MODE, "length": length}
        return partial(finish, combination=combination, cases=cases, region=region, **known)

    def patch(self, combination: Combination, cases: Block, region: Block, finished: Finished, sizes: Sequence[int]) -> None:
        """Write what the second look has changed, in pieces of the coordinate axes of given sizes."""
        shape = sizes_of(region)
        row = np.full(finished.mode.size, -1)
        row[finished.which] = np.arange(len(finished.which))
        for piece in cut(shape, sizes):
            there = tuple(slice(p.start + r.start, p.stop + r.start) for p, r in zip(piece, region, strict=True))
            block = self._block(combination, cases, there)
            self.write("mode", block, finished.mode[piece])
            rows = row.reshape(shape)[piece].ravel()
            places = np.flatnonzero(rows >= 0)
            if not places.size or finished.numbers is None:
                continue
            for name, item in self._items.items():
                if "coordinate" not in item.varies or name == "mode":
                    continue
                values = self.read(name, block)
                before = sizes_of(cases) if "case" in item.varies else ()
                flat = values.reshape((*before, rows.size, *values.shape[values.ndim - len(item.dims) :]))
                into: tuple[slice | Index, ...] = (*(slice(None) for _ in before), places)
                out_of: tuple[slice | Index, ...] = (*into[:-1], rows[places])
                flat[into] = finished.numbers[name][out_of]
                self.write(name, block, flat)

    def _block(self, combination: Combination, cases: Block, region: Block) -> Block:
        return (*(slice(k, k + 1) for k in combination), *cases, *region)


def in_memory(template: xr.Dataset) -> dict[str, Values]:
    """Return arrays for all variables."""
    return {str(name): np.array(item.values) for name, item in template.data_vars.items()}


@dataclass(frozen=True)
class Store:
    """A kind of file.

    Attributes:
        engine: xarray's name for it.
        ending: of its files.
        needs: packages.
        create: makes an empty one at a path for a template with chunks of given sizes by dimension; returns its arrays, and a
            function that writes the Dataset's attributes and closes it.
    """

    engine: str
    ending: str
    needs: tuple[str, ...]
    create: Callable[[str, xr.Dataset, Mapping[str, int]], tuple[dict[str, object], Callable[[Mapping[str, object]], None]]]


def _chunks(variable: xr.DataArray, sizes: Mapping[str, int]) -> tuple[int, ...]:
    return tuple(min(sizes.get(str(dim), n), n) for dim, n in variable.sizes.items())


def _create_netcdf(path: str, template: xr.Dataset, sizes: Mapping[str, int]) -> Created:
    """Make a netCDF-4 file with h5netcdf."""
    import h5netcdf

    template.drop_vars(list(template.data_vars)).to_netcdf(path, engine="h5netcdf", mode="w")
    file = h5netcdf.File(path, "a")
    arrays = {}
    for name, item in template.data_vars.items():
        # netCDF has no truth values: xarray's way to store them
        dtype, more = (np.dtype(np.int8), {"dtype": "bool"}) if item.dtype == bool else (item.dtype, {})
        fill = np.nan if dtype.kind == "f" else None
        chunks = _chunks(item, sizes) or None
        arrays[str(name)] = created = file.create_variable(name, item.dims, dtype, fillvalue=fill, chunks=chunks)
        created.attrs.update({**item.attrs, **more})

    def close(attributes: Mapping[str, object]) -> None:
        file.attrs.update(attributes)
        file.close()

    return arrays, close


def _create_zarr(path: str, template: xr.Dataset, sizes: Mapping[str, int]) -> Created:
    """Make a zarr store, a folder of chunks; in the format 2, which all versions of zarr read."""
    import zarr

    template.drop_vars(list(template.data_vars)).to_zarr(path, mode="w", consolidated=False, zarr_format=2)
    group: Stored = zarr.open_group(path, mode="a", zarr_format=2)
    arrays = {}
    for name, item in template.data_vars.items():
        attributes = {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in item.attrs.items()}
        arrays[str(name)] = group.create_array(
            name,
            shape=item.shape,
            dtype=item.dtype,
            fill_value=np.nan if item.dtype.kind == "f" else None,
            attributes={"_ARRAY_DIMENSIONS": list(item.dims), **attributes},
            chunks=_chunks(item, sizes),
        )

    def close(attributes: Mapping[str, object]) -> None:
        group.attrs.update(dict(attributes))
        zarr.consolidate_metadata(path, zarr_format=2)

    return arrays, close


_NETCDF = Store("h5netcdf", ".nc", ("h5netcdf", "h5py"), _create_netcdf)
STORES = {".nc": _NETCDF, ".nc4": _NETCDF, ".zarr": Store("zarr", ".zarr", ("zarr",), _create_zarr)}
