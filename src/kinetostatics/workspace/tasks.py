"""The pieces of work of a sweep: blocks, which are kept in files, among them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.workspace.block import compute_block
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.schema import Labels
from kinetostatics.workspace.sweep_spec import SweepSpec

#: A piece of work, to be called with what is asked for and the labels; a partial function, which goes to other processes.
Task: TypeAlias = "partial[Any]"


def block_numbers(spec: SweepSpec, labels: Labels, block: Block, path: str | None = None) -> dict[str, NDArray[np.generic]]:
    """Return the variables of a block, having written them to a file if a ``path`` is given."""
    numbers = compute_block(spec, labels, block)
    if path is not None:
        write_part(path, numbers)
    return numbers


def write_part(path: str, numbers: Mapping[str, NDArray[np.generic]]) -> None:
    """Write a block to a file that is there as a whole or not at all, whatever happens to this process."""
    unfinished = f"{path}.{os.getpid()}.tmp"
    arrays = [np.asarray(array, order="C") for array in numbers.values()]
    with open(unfinished, "wb") as file:
        for array in (np.array(list(numbers)), *arrays, _checksum(arrays)):
            np.save(file, array, allow_pickle=False)
    os.replace(unfinished, path)


def read_part(path: str) -> dict[str, NDArray[np.generic]] | None:
    """Return the block of a file, None if it is not whole: after a power failure, say."""
    try:
        with open(path, "rb") as file:
            names = np.load(file, allow_pickle=False)
            arrays = [np.load(file, allow_pickle=False) for _ in names]
            if np.load(file, allow_pickle=False) != _checksum(arrays):
                return None
    except (OSError, ValueError, EOFError):
        return None
    return dict(zip(names.tolist(), arrays, strict=True))


def _checksum(arrays: Sequence[NDArray[np.generic]]) -> NDArray[np.uint64]:
    """Return the sum of all numbers, taken as integers."""
    total = np.zeros((), dtype=np.uint64)
    for array in arrays:
        total += array.reshape(-1).view(f"u{array.itemsize}").sum(dtype=np.uint64)
    return total
