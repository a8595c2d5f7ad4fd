"""Array types, the change from inner arrays (poses last) to public ones (poses first), and long batches in chunks and threads.

To compile a function, it is called at an example pose with arrays of type ``object``. Their *recorded* numbers store every
operation on them.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
#: Arrays of numbers, truth values or strings, as stored in maps.
Values: TypeAlias = NDArray[np.generic]
#: Indices along an axis.
Index: TypeAlias = NDArray[np.intp]
#: Truth values.
Mask: TypeAlias = NDArray[np.bool_]
Kept = TypeVar("Kept", bound=Values)
Given = TypeVar("Given")
Found = TypeVar("Found")

#: Largest number of poses in a chunk: more do not fit the processor's cache, and each chunk costs some milliseconds.
AT_ONCE = 5500
#: Interval [s] after which Python switches threads. Calls of compiled code are shorter than Python's default of 5 ms. With this
#: interval, two threads are up to 1.8 times as fast as one; with the default, 1.1 times.
TURN = 5e-4

_here = threading.local()
_lock = threading.Lock()
_turns: list[float] = []  # Python's own interval [s], once for each active pool


def frozen(array: Kept) -> Kept:
    """Make the array itself read-only, and return it."""
    array.setflags(write=False)
    return array


def empty_for(shape: tuple[int, ...], *sources: Array) -> Array:
    """Return an uninitialized array for results computed from ``sources``: of type ``object`` if a source is, else of floats."""
    kind = next((source for source in sources if source.dtype == object), None)
    return np.empty(shape) if kind is None else np.empty_like(kind, shape=shape)


def zeros_for(shape: tuple[int, ...], *sources: Array) -> Array:
    """Return zeros for results computed from ``sources``, with the type of :func:`empty_for`."""
    kind = next((source for source in sources if source.dtype == object), None)
    return np.zeros(shape) if kind is None else np.zeros_like(kind, shape=shape)


def is_filled(array: Array) -> Mask:
    """True where an entry is not zero; recorded numbers count as nonzero."""
    if array.dtype != object:
        return array != 0
    return np.array([not isinstance(entry, int | float) or entry != 0 for entry in array.flat], dtype=bool).reshape(array.shape)


def everywhere(condition: Mask) -> bool:
    """Whether a condition is true everywhere, so that the calculation for the other case can be skipped; False if recorded."""
    return condition.dtype != object and bool(np.all(condition))


def settles(condition: Mask) -> bool:
    """Whether a condition is true everywhere.

    A recorded condition that is true at the example pose becomes a guard: where it is false, compiled code is not valid.
    """
    everywhere = np.all(condition)
    return bool(getattr(everywhere, "value", True)) and bool(everywhere)


def copy_for(array: Array, source: Array) -> Array:
    """Return a copy in which results computed from ``source`` can be stored: of type ``object`` if either array is."""
    if array.dtype == object or source.dtype != object:
        return np.array(array, subok=True)
    copy = np.empty_like(source, shape=array.shape)
    copy[...] = array
    return copy


def batch_first(array: Array, shape: tuple[int, ...]) -> Array:
    """Return components (…, N) of N poses as a read-only array (*shape, …); ``shape`` is () for a single pose."""
    if not shape:
        return frozen(np.array(array[..., 0], order="C", subok=True))
    turned = array.transpose(array.ndim - 1, *range(array.ndim - 1))
    return frozen(np.ascontiguousarray(turned).reshape(shape + turned.shape[1:]))


def chunks(poses: int) -> list[slice]:
    """Return slices of nearly equal size, at most :data:`AT_ONCE`, that cover all poses."""
    count = -(-poses // AT_ONCE)
    return [slice(poses * k // count, poses * (k + 1) // count) for k in range(count)]


@contextmanager
def _short_turns() -> Iterator[None]:
    """Let Python switch threads every :data:`TURN` seconds within the context; contexts in several threads may overlap."""
    with _lock:
        _turns.append(_turns[0] if _turns else sys.getswitchinterval())
        sys.setswitchinterval(min(TURN, _turns[0]))
    try:
        yield
    finally:
        with _lock:
            usual = _turns.pop()
            if not _turns:
                sys.setswitchinterval(usual)


def threads() -> int:
    """Return ``OMP_NUM_THREADS``, as used by NumPy's own libraries, or the number of cores that this process may use."""
    given = os.environ.get("OMP_NUM_THREADS", "")
    if given.isdecimal() and int(given):
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(
    function: Callable[[Given], Found], parts: Iterable[Given], enabled: bool = True, most: int | None = None
) -> list[Found]:
    """Return the results of a function for all parts, in order.

    A call of ``in_threads`` within ``function`` uses threads only if this call uses none and ``most`` is not 1.

    Args:
        enabled: whether to use threads.
        most: largest number of threads; None: :func:`threads`.
    """
    parts = list(parts)
    before = getattr(_here, "alone", False)
    number = min(most or threads(), len(parts)) if enabled and not before else 1
    if number < 2:
        _here.alone = before or most == 1
        try:
            return [function(part) for part in parts]
        finally:
            _here.alone = before
    with _short_turns(), ThreadPoolExecutor(number, initializer=lambda: setattr(_here, "alone", True)) as pool:
        return list(pool.map(function, parts))
