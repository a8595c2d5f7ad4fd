"""The pieces of work of a sweep: what is done for one of them, in this process or another."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.workspace.assembly_modes.repair import finish
from kinetostatics.workspace.block import compute_block
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.schema import Labels
from kinetostatics.workspace.sweep_spec import Combination, SweepSpec


@dataclass(frozen=True)
class BlockTask:
    """Compute a block; ``path``: and write it to a file."""

    block: Block
    path: str | None = None


@dataclass(frozen=True, eq=False)
class FinishTask:
    """Look at a region of the coordinate axes of one robot, see :func:`finish`."""

    combination: Combination
    cases: Block
    region: Block
    q: NDArray[np.float64]
    reached: NDArray[np.bool_]
    length: float


Task = BlockTask | FinishTask


def perform(spec: SweepSpec, labels: Labels, task: Task) -> Any:
    """Do a piece of work and return what comes of it: the variables of a block, or a :class:`Finished` one."""
    if isinstance(task, FinishTask):
        return finish(spec, labels, **vars(task))
    numbers = compute_block(spec, labels, task.block)
    if task.path is not None:
        write_part(task.path, numbers)
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
