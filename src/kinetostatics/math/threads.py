"""Threads for parts of a batch, where functions spend their time outside of Python, as compiled code does."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Part = TypeVar("Part")
Found = TypeVar("Found")


def threads() -> int:
    """Return the number of threads: ``OMP_NUM_THREADS``, as for NumPy's own libraries, or the number of cores."""
    given = os.environ.get("OMP_NUM_THREADS", "")
    if given.isdecimal() and int(given):
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(function: Callable[[Part], Found], parts: Iterable[Part], wanted: bool = True) -> list[Found]:
    """Return a function's results for all parts, in order; ``wanted``: whether threads are of use."""
    parts = list(parts)
    number = min(threads(), len(parts)) if wanted else 1
    if number < 2:
        return [function(part) for part in parts]
    with ThreadPoolExecutor(number) as pool:
        return list(pool.map(function, parts))
