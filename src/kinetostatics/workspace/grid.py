"""The grid of a sweep: its axes, vectors that may vary along them, and its division into blocks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.arguments import check_mapping, numbers
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Values

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot
from kinetostatics.units import PLATFORM_UNITS

#: A part of the grid: a range of indices along each axis.
Block = tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class Axis:
    """One dimension of the grid.

    Attributes:
        kind: "parameter" of the robot file, "case" (a dimension of a load or of gravity) or "coordinate" of platform or
            actuators.
        values: (n,) numbers in SI, or strings.
        units: units of the values; empty if unknown.
    """

    name: str
    kind: str
    values: Values
    units: str = ""

    @property
    def size(self) -> int:
        return len(self.values)

    @property
    def long_name(self) -> str:
        if self.kind == "parameter":
            return f"parameter {self.name} of the robot file"
        if self.kind == "case":
            return f"{self.name} of loads"
        if PLATFORM_UNITS.get(self.name) == "m":
            return f"{self.name} of the platform's reference point o"
        return f"orientation coordinate {self.name} of the platform" if self.units == "rad" else self.name

    def as_json(self) -> dict[str, object]:
        return {"kind": self.kind, "units": self.units, "values": self.values.tolist()}


@dataclass(frozen=True, eq=False)
class Field:
    """A load, gravity or a point, which may vary along axes of the grid.

    Attributes:
        dims: names of these axes.
        values: (…, k) vectors, one axis for each of ``dims``.
    """

    dims: tuple[str, ...]
    values: Array

    def of(self, axes: Sequence[Axis], block: Block) -> Array:
        """Return the vectors in a block (…, k), with the grid's ``axes``; axes along which the field is constant have size 1."""
        names = [axis.name for axis in axes]
        values = self.values[tuple(block[names.index(name)] for name in self.dims)]
        order = sorted(range(len(self.dims)), key=lambda k: names.index(self.dims[k]))
        values = values.transpose(*order, len(self.dims))
        return values.reshape(*(values.shape[order.index(self.dims.index(n))] if n in self.dims else 1 for n in names), -1)

    def within(self, axes: Sequence[Axis], block: Block) -> Field:
        ranges = dict(zip((axis.name for axis in axes), block, strict=True))
        return Field(self.dims, self.values[tuple(ranges[name] for name in self.dims)])

    def as_json(self) -> object:
        return self.values.tolist() if not self.dims else {"dims": list(self.dims), "values": self.values.tolist()}


def sizes_of(block: Block) -> tuple[int, ...]:
    return tuple(piece.stop - piece.start for piece in block)


# ---- axes and fields from arguments ----------------------------------------------------------------------------------


def split_values(
    what: str, given: Mapping[str, object], kind: str, units: Mapping[str, str] | str = ""
) -> tuple[list[Axis], dict[str, float | str]]:
    """Return an axis for each one-dimensional array, and the single values.

    Args:
        what: the argument's name, for messages.
        given: numbers and arrays by name; parameters may be strings too.
        kind: kind of the axes.
        units: units by name, or one unit for all.
    """
    check_mapping(what, given, '{"z": [0.4, 0.5, 0.6]}')
    axes: list[Axis] = []
    held: dict[str, float | str] = {}
    for name, value in given.items():
        array = _array(what, name, value, text=kind == "parameter")
        if array.ndim == 0:
            held[name] = array.item()
            continue
        if array.ndim > 1:
            raise ArgumentError(
                f"{what}: {name} has the shape {array.shape}; a sweep takes the outer product of one-dimensional arrays"
            )
        if not len(array):
            raise ArgumentError(f"{what}: {name} is empty")
        if len(set(array.tolist())) < len(array):
            raise ArgumentError(f"{what}: {name} has a value twice; values along a dimension must be distinct")
        axes.append(Axis(name, kind, array, units if isinstance(units, str) else units.get(name, "")))
    return axes, held


def _array(what: str, name: str, value: object, text: bool) -> Values:
    try:
        array = np.asarray(value)
    except ValueError:
        raise ArgumentError(f"{what}: {name} is {value!r}, not a number or an array of numbers") from None
    if text and (array.dtype.kind in "UbiO" or isinstance(value, str)):
        if array.dtype.kind == "O" and not all(isinstance(element, (str, int, float)) for element in array.ravel()):
            raise ArgumentError(f"{what}: {name} is {value!r}; values are numbers or strings")
        return array if array.dtype.kind != "O" else array.astype(str)
    try:
        array = numbers(name, array)
    except ArgumentError:
        raise ArgumentError(f"{what}: {name} is {value!r}, not a number or an array of numbers") from None
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what}: {name} has values that are not finite")
    return array


def read_field(what: str, value: object, size: int) -> tuple[Field, list[Axis]]:
    """Return a vector as a field, and an axis for each dimension along which it varies.

    Args:
        what: the argument's name, for messages.
        value: a vector, or an ``xarray.DataArray`` of vectors with the dimension ``component``.
    """
    dims: tuple[str, ...] = ()
    field: xr.DataArray | None = None
    if hasattr(value, "dims") and hasattr(value, "transpose"):
        if "component" not in value.dims:
            raise ArgumentError(f"{what} has the dimensions {value.dims}; one of them must be 'component', of size {size}")
        field = value.transpose(..., "component")
        dims = tuple(str(name) for name in field.dims[:-1])
    array = numbers(what, value if field is None else field)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ArgumentError(f"{what} has the shape {array.shape}; it must have {size} entries")
    if array.ndim > 1 and field is None:
        raise ArgumentError(
            f"{what} has the shape {array.shape}; give it as an xarray.DataArray, whose dimensions have names, "
            f"for example ('case', 'component')"
        )
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what} has entries that are not finite")
    axes = []
    for position, name in enumerate(dims):
        labels = np.asarray(field[name]) if field is not None and name in field.coords else np.arange(array.shape[position])
        axes.append(Axis(name, "case", labels.astype(str) if labels.dtype.kind == "O" else labels))
    return Field(dims, array), axes


def coordinate_units(robot: Robot, kind: str, names: Sequence[str]) -> dict[str, str]:
    """Return the units of coordinates, by name; ``kind``: "platform" or "actuators"."""
    if kind == "platform":
        return {name: PLATFORM_UNITS.get(name, "") for name in names}
    connections = robot.mechanism.connections
    return {name: connections[name].type.unit if name in connections else "rad" for name in names}


# ---- blocks ----------------------------------------------------------------------------------------------------------


def block_sizes(axes: Sequence[Axis], poses: int) -> tuple[int, ...]:
    """Return the sizes of blocks of about ``poses`` poses; a block extends over the last axes before others are divided.

    A block contains one robot only, because building a robot takes as long as thousands of poses.
    """
    sizes = [1] * len(axes)
    left = max(poses, 1)
    for k in reversed(range(len(axes))):
        if axes[k].kind == "parameter":
            continue
        number = max(1, min(axes[k].size, left))
        pieces = -(-axes[k].size // number)
        sizes[k] = -(-axes[k].size // pieces)  # equal pieces
        left = left // sizes[k]
    return tuple(sizes)


def chunk_sizes(axes: Sequence[Axis], chunks: Mapping[str, int]) -> tuple[int, ...]:
    """Return the block sizes of ``chunks={"z": 5, …}``; dimensions without a size, or with −1, are undivided."""
    names = [axis.name for axis in axes]
    check_mapping("chunks", chunks, '{"z": 10}')
    for name, size in chunks.items():
        if name not in names:
            raise ArgumentError(f"chunks: {name!r} is no dimension of the sweep; it has {', '.join(names) or 'none'}")
        if not isinstance(size, (int, np.integer)) or isinstance(size, bool) or (size < 1 and size != -1):
            raise ArgumentError(f"chunks: the size along {name} is {size!r}; it must be a number of values, or -1 for all")
    return tuple(min(int(chunks[a.name]), a.size) if chunks.get(a.name, -1) != -1 else a.size for a in axes)


def cut(shape: Sequence[int], sizes: Sequence[int]) -> Iterator[Block]:
    """Yield the blocks of a grid in order, the last axis fastest."""
    pieces = [[slice(start, min(start + size, n)) for start in range(0, n, size)] for n, size in zip(shape, sizes, strict=True)]
    yield from itertools.product(*pieces)
