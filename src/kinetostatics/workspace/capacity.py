"""Whether there is room for a map, asked before anything is computed."""

from __future__ import annotations

import math
import os
import shutil

from kinetostatics.exceptions import ArgumentError
from kinetostatics.workspace.schema import Labels, template
from kinetostatics.workspace.sweep_spec import SweepSpec


def size_of(spec: SweepSpec, labels: Labels) -> int:
    """Return how many bytes the arrays of a map are."""
    return sum(item.nbytes for item in template(spec, labels).data_vars.values())


def check_memory(spec: SweepSpec, labels: Labels) -> None:
    """See to it that a map fits into the machine's memory.

    Raises:
        ArgumentError: it does not.
    """
    try:
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):  # no such machine
        return
    needed = size_of(spec, labels)
    if needed > memory:
        raise ArgumentError(
            f"a map of {_poses(spec)} takes {_said(needed)}, and this machine has {_said(memory)} of memory: write it to a "
            "file (out=, --out), make it lazy (chunks= in Python), or take a coarser grid"
        )


def check_disk(spec: SweepSpec, labels: Labels, path: str, parts: str) -> None:
    """See to it that a map fits beside its finished blocks, which stay until it is whole.

    Args:
        spec, labels: of the map.
        path: of the file.
        parts: folder of the blocks, those of an interrupted sweep among them.

    Raises:
        ArgumentError: it does not.
    """
    disk = shutil.disk_usage(os.path.dirname(os.path.abspath(path)))
    if disk.total == 0:  # not a disk; what it is will say why it cannot be written to
        return
    there = sum(item.stat().st_size for item in os.scandir(parts) if item.is_file()) if os.path.isdir(parts) else 0
    needed = size_of(spec, labels)
    if 2 * needed > disk.free + there:
        raise ArgumentError(
            f"a map of {_poses(spec)} takes {_said(needed)}, twice that while it is written, and the disk of {path!r} has "
            f"{_said(disk.free)} free: take a coarser grid or another disk"
        )


def _poses(spec: SweepSpec) -> str:
    return "1 pose" if spec.size == 1 else f"{spec.size:,} poses"


def _said(size: float) -> str:
    """Return a number of bytes in words."""
    power = min(int(math.log10(max(size, 1)) / 3), 5)
    return f"{size / 1000**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB', 'PB')[power]}"
