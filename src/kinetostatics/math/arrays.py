"""Array types, conversion between inner and public layout, and chunks of long batches."""

from __future__ import annotations

from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
#: Arrays of numbers, truth values or strings, as stored in maps.
Values: TypeAlias = NDArray[np.generic]
#: Positions in an axis.
Index: TypeAlias = NDArray[np.intp]
#: Truth values.
Mask: TypeAlias = NDArray[np.bool_]

Kept = TypeVar("Kept", bound=NDArray[np.generic])

#: Largest number of poses in a chunk, limited by the processor's cache. Each chunk costs some milliseconds.
AT_ONCE = 5500


def frozen(array: Kept) -> Kept:
    """Return the array, made read-only."""
    array.setflags(write=False)
    return array


def empty_for(shape: tuple[int, ...], *sources: Array) -> Array:
    """Return an uninitialized array for results computed from ``sources``: of recorded numbers if a source has them."""
    kind = next((source for source in sources if source.dtype == object), None)
    return np.empty(shape) if kind is None else np.empty_like(kind, shape=shape)


def zeros_for(shape: tuple[int, ...], *sources: Array) -> Array:
    """Return an array of zeros for results computed from ``sources``; see :func:`empty_for`."""
    kind = next((source for source in sources if source.dtype == object), None)
    return np.zeros(shape) if kind is None else np.zeros_like(kind, shape=shape)


def is_filled(array: Array) -> Mask:
    """Return the mask of nonzero entries; recorded results count as nonzero."""
    if array.dtype != object:
        return array != 0
    return np.array([not isinstance(entry, int | float) or entry != 0 for entry in array.flat], dtype=bool).reshape(array.shape)


def everywhere(condition: Mask) -> bool:
    """Return whether a condition is true everywhere, so that a calculation can be skipped; always False in a record."""
    return condition.dtype != object and bool(np.all(condition))


def settles(condition: Mask) -> bool:
    """Return whether a condition is true everywhere.

    In a record, it is evaluated at the example pose; if true there, it becomes a condition of validity (guard) of the record.
    """
    found = np.all(condition)
    return bool(getattr(found, "value", True)) and bool(found)


def copy_for(array: Array, source: Array) -> Array:
    """Return a copy of an array to which results computed from ``source`` may be added; see :func:`empty_for`."""
    if array.dtype == object or source.dtype != object:
        return np.array(array, subok=True)
    copy = np.empty_like(source, shape=array.shape)
    copy[...] = array
    return copy


def batch_first(array: Array, shape: tuple[int, ...]) -> Array:
    """Return an array ``(…components, N)`` as the read-only public one ``(*shape, …components)``."""
    if not shape:
        return frozen(np.array(array[..., 0], order="C"))
    turned = array.transpose(array.ndim - 1, *range(array.ndim - 1))
    return frozen(np.ascontiguousarray(turned).reshape(shape + turned.shape[1:]))


def chunks(poses: int) -> list[slice]:
    """Return slices of nearly equal size that cover all poses."""
    count = -(-poses // AT_ONCE)
    return [slice(poses * k // count, poses * (k + 1) // count) for k in range(count)]
