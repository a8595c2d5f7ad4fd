"""Where the numbers of a sweep go: arrays in memory, a netCDF file, a zarr store; written and read by parts of the grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinetostatics.workspace.assembly_modes.repair import Finished
from kinetostatics.workspace.grid import Block, cut, shape_of
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.schema import Labels, Variable, variables

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[Any]


class Target(Protocol):
    """Something that holds the variables of a sweep."""

    def write(self, name: str, where: Block, values: Array) -> None:
        """Write a part of a variable; ``where`` is along the dimensions that it shares with the grid."""

    def read(self, name: str, where: Block) -> Array:
        """Return a part of a variable."""


def part_of(plan: Plan, item: Variable, block: Block) -> Block:
    """Return what a block of the whole grid is along the axes that a variable has."""
    return plan.part(block, *item.kinds)


def write_block(target: Target, plan: Plan, labels: Labels, block: Block, numbers: Mapping[str, Array]) -> None:
    """Write all variables of a block."""
    for name, item in variables(labels).items():
        target.write(name, part_of(plan, item, block), numbers[name])


def joint_state(target: Target, labels: Labels, where: Block) -> Array:
    """Return the model coordinates of poses; behind them x, y, z of o where some of them are loose and tell nothing."""
    q = target.read("q", where)
    if not any(labels.loose):
        return q
    return np.concatenate([q, target.read("platform_pose", where)[..., :3]], axis=-1)


def patch(
    target: Target,
    plan: Plan,
    labels: Labels,
    combination: Combination,
    cases: Block,
    region: Block,
    finished: Finished,
    sizes: Sequence[int],
) -> None:
    """Write what the second look at a region of one robot has changed, in pieces of the coordinate axes of given sizes."""
    robot = tuple(slice(k, k + 1) for k in combination)
    shape = tuple(piece.stop - piece.start for piece in region)
    changed = np.zeros(finished.mode.size, dtype=np.intp)
    changed[finished.which] = np.arange(1, len(finished.which) + 1)
    changed = changed.reshape(shape)
    for piece in cut(shape, sizes):
        local = changed[piece].ravel()
        there = tuple(slice(p.start + r.start, p.stop + r.start) for p, r in zip(piece, region, strict=True))
        block = (*robot, *cases, *there)
        items = variables(labels)
        target.write(
            "mode", part_of(plan, items["mode"], block), finished.mode[piece].reshape((*(1 for _ in robot), *_sizes(piece)))
        )
        places = np.flatnonzero(local)
        if not places.size or finished.numbers is None:
            continue
        rows = local[places] - 1
        for name, item in items.items():
            if "coordinate" not in item.kinds or name == "mode":
                continue
            where = part_of(plan, item, block)
            values = np.array(target.read(name, where))
            mine = _sizes(cases) if "case" in item.kinds else ()
            tail = values.shape[values.ndim - len(item.labels) :]
            flat = values.reshape((*mine, local.size, *tail))
            index: tuple[Any, ...] = (slice(None),) * len(mine)
            flat[(*index, places)] = finished.numbers[name][(*index, rows)]
            target.write(name, where, flat.reshape(values.shape))


def _sizes(block: Block) -> tuple[int, ...]:
    return tuple(piece.stop - piece.start for piece in block)


class Memory:
    """Arrays in memory, of the whole grid or of one block of it."""

    def __init__(self, plan: Plan, labels: Labels, block: Block | None = None) -> None:
        self.plan, self.items = plan, variables(labels)
        self.block = block or tuple(slice(0, size) for size in shape_of(plan.axes))
        self.arrays: dict[str, Array] = {}
        self._tails = tails(labels)
        for name, item in self.items.items():
            self.arrays[name] = np.full((*_sizes(part_of(plan, item, self.block)), *self._tails[name]), item.nothing, item.dtype)

    def _local(self, name: str, where: Block) -> Block:
        starts = [piece.start for piece in part_of(self.plan, self.items[name], self.block)]
        return tuple(slice(piece.start - s, piece.stop - s) for piece, s in zip(where, starts, strict=True))

    def write(self, name: str, where: Block, values: Array) -> None:
        """See :class:`Target`."""
        self.arrays[name][self._local(name, where)] = values

    def read(self, name: str, where: Block) -> Array:
        """See :class:`Target`."""
        return self.arrays[name][self._local(name, where)]

    def dataset(self, template: xr.Dataset) -> xr.Dataset:
        """Return the arrays as a Dataset."""
        data = {name: (template[name].dims, array, template[name].attrs) for name, array in self.arrays.items()}
        return template.assign(data)


def tails(labels: Labels) -> dict[str, tuple[int, ...]]:
    """Return the sizes of each variable's own dimensions."""
    sizes = {
        "component": 6,
        "component_2": 6,
        "source": len(labels.sources),
        "way": len(labels.ways),
        "actuator": len(labels.actuators),
        "wrench": len(labels.wrenches),
        "attached_wrench": len(labels.attached),
        "platform_coordinate": len(labels.pose),
        "joint_coordinate": len(labels.q),
        "beam": len(labels.beams),
    }
    return {name: tuple(sizes[label] for label in item.labels) for name, item in variables(labels).items()}


class NetCDF:
    """A netCDF-4 file, written with h5netcdf."""

    engine, ending, needs = "h5netcdf", ".nc", ("h5netcdf", "h5py")

    def __init__(self, path: str, template: xr.Dataset, sizes: Mapping[str, int]) -> None:
        import h5netcdf

        large = [str(name) for name in template.data_vars]
        template.drop_vars(large).to_netcdf(path, engine="h5netcdf", mode="w")
        self._file = h5netcdf.File(path, "a")
        self._variables: dict[str, Any] = {}
        for name in large:
            variable = template[name]
            chunks = tuple(min(sizes.get(str(dim), n), n) for dim, n in variable.sizes.items())
            fill = np.nan if variable.dtype.kind == "f" else None
            options = {"chunks": chunks} if chunks else {}
            truth = variable.dtype.kind == "b"  # netCDF has none: xarray's way to store it
            dtype = np.dtype(np.int8) if truth else variable.dtype
            created = self._file.create_variable(name, variable.dims, dtype, fillvalue=fill, **options)
            for key, value in {**variable.attrs, **({"dtype": "bool"} if truth else {})}.items():
                created.attrs[key] = value
            self._variables[name] = created

    def write(self, name: str, where: Block, values: Array) -> None:
        """See :class:`Target`."""
        self._variables[name][where if where else ...] = values.astype(np.int8) if values.dtype.kind == "b" else values

    def read(self, name: str, where: Block) -> Array:
        """See :class:`Target`."""
        return np.asarray(self._variables[name][where if where else ...])

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Write the attributes of the Dataset, and end."""
        for key, value in attributes.items():
            self._file.attrs[key] = value
        self._file.close()


class Zarr:
    """A zarr store, a folder of chunks; in the format 2, which all versions of zarr read."""

    engine, ending, needs = "zarr", ".zarr", ("zarr",)

    def __init__(self, path: str, template: xr.Dataset, sizes: Mapping[str, int]) -> None:
        import zarr

        large = [str(name) for name in template.data_vars]
        template.drop_vars(large).to_zarr(path, mode="w", consolidated=False, zarr_format=2)
        self._path = path
        self._group: Any = zarr.open_group(path, mode="a", zarr_format=2)
        self._arrays: dict[str, Any] = {}
        for name in large:
            variable = template[name]
            chunks = tuple(min(sizes.get(str(dim), n), n) for dim, n in variable.sizes.items())
            plain = {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in variable.attrs.items()}
            self._arrays[name] = self._group.create_array(
                name,
                shape=variable.shape,
                chunks=chunks,
                dtype=variable.dtype,
                fill_value=np.nan if variable.dtype.kind == "f" else None,
                attributes={"_ARRAY_DIMENSIONS": [str(dim) for dim in variable.dims], **plain},
            )

    def write(self, name: str, where: Block, values: Array) -> None:
        """See :class:`Target`."""
        self._arrays[name][where if where else ...] = values

    def read(self, name: str, where: Block) -> Array:
        """See :class:`Target`."""
        return np.asarray(self._arrays[name][where if where else ...])

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Write the attributes of the Dataset, and end."""
        import zarr

        self._group.attrs.update(dict(attributes))
        zarr.consolidate_metadata(self._path, zarr_format=2)


STORES: dict[str, type[NetCDF] | type[Zarr]] = {".nc": NetCDF, ".nc4": NetCDF, ".zarr": Zarr}
