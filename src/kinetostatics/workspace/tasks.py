"""The pieces of work of a sweep: what is done for one of them, in this process or another."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.workspace.compute import compute_block
from kinetostatics.workspace.finishing import Finished, finish
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.schema import Labels


@dataclass(frozen=True)
class BlockTask:
    """Compute a block; ``path``: write it to a file instead of returning it."""

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


Task = BlockTask | FinishTask


def perform(plan: Plan, labels: Labels, task: Task) -> dict[str, NDArray[Any]] | Finished | None:
    """Do a piece of work and return what comes of it."""
    if isinstance(task, FinishTask):
        return finish(plan, labels, task.combination, task.cases, task.region, task.q, task.reached)
    numbers = compute_block(plan, labels, task.block)
    if task.path is None:
        return numbers
    write_part(task.path, numbers)
    return None


def write_part(path: str, numbers: dict[str, NDArray[Any]]) -> None:
    """Write a block to a file that is there as a whole or not at all, whatever happens meanwhile."""
    unfinished = f"{path}.{os.getpid()}.tmp"
    with open(unfinished, "wb") as file:
        np.savez(file, **numbers)  # type: ignore[arg-type]
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)


def read_part(path: str) -> dict[str, NDArray[Any]]:
    """Return the block of a file."""
    with np.load(path, allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}
