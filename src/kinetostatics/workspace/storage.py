"""A sweep on disk: finished blocks beside the file that they will be, so that an interrupted sweep goes on where it was.

Whether there is room for a map is asked before anything is computed.
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from kinetostatics.exceptions import ArgumentError
from kinetostatics.workspace.grid import Block, cut
from kinetostatics.workspace.schema import Labels, template
from kinetostatics.workspace.sweep_spec import SweepSpec, plain
from kinetostatics.workspace.targets import STORES, Store

if TYPE_CHECKING:
    import xarray as xr


#: Of the layout of the folder of finished blocks, and of what is in them.
FORMAT = 2
#: Attributes of a Dataset that say what sweep it comes from, and what messages call other values of them.
COMPARED = {
    "arguments": "other arguments",
    "robot_text_sha256": "another robot",
    "kinetostatics_version": "another version of kinetostatics",
    "pinocchio_version": "another version of pinocchio",
    "numpy_version": "another version of numpy",
}


def store_of(path: str) -> Store:
    """Return what a file's name asks for.

    Raises:
        ArgumentError: its ending is none that is known.
    """
    for ending, store in STORES.items():
        if path.rstrip("/").lower().endswith(ending):
            return store
    raise ArgumentError(f"out is {path!r}; it must end in .nc (netCDF) or .zarr")


def open_map(path: str) -> xr.Dataset:
    """Open a stored map; its numbers are read when they are needed."""
    import xarray as xr

    return xr.open_dataset(path, engine=store_of(path).engine)


class Storage:
    """The file or folder ``out``, and beside it ``out.parts`` with the blocks that are finished.

    Attributes:
        path: of the map.
        done: whether the whole map is there already.
        sizes: of blocks: those of an interrupted sweep if there is one.
    """

    def __init__(self, path: str, spec: SweepSpec, sizes: Sequence[int], attributes: Mapping[str, object], restart: bool) -> None:
        self.path = path.rstrip("/")
        self.store = store_of(path)
        self.spec = spec
        self.folder = f"{self.path}.parts"
        self.sizes = tuple(sizes)
        self._notes = os.path.join(self.folder, "sweep.json")
        self.done = self._is_done(attributes, restart)
        if self.done:
            return
        parent = os.path.dirname(os.path.abspath(self.path))
        if not os.path.isdir(parent):
            raise ArgumentError(f"out is {path!r}, but there is no folder {parent!r}")
        if restart:
            shutil.rmtree(self.folder, ignore_errors=True)
        self._resumed = os.path.exists(self._notes)
        if self._resumed:
            self._resume()

    def _is_done(self, attributes: Mapping[str, object], restart: bool) -> bool:
        if not os.path.exists(self.path):
            return False
        try:
            with open_map(self.path) as there:
                found = dict(there.attrs)
        except Exception:
            found = {}
        if "sweep_sha256" not in found:
            raise ArgumentError(f"{self.path} is there already and is not the map of a sweep; choose another name")
        if restart:
            return False
        if found["sweep_sha256"] == self.spec.identity:
            return True
        differ = [what for key, what in COMPARED.items() if found.get(key) != attributes.get(key)] or ["other arguments"]
        raise ArgumentError(
            f"{self.path} is the map of another sweep, with {', '.join(differ)}; choose another name, or let it be replaced "
            "(restart=True, --restart)"
        )

    def begin(self) -> None:
        """Make the folder of finished blocks, if no interrupted sweep has left it; nothing is written before."""
        if self._resumed:
            return
        os.makedirs(self.folder, exist_ok=True)
        notes = {"format": FORMAT, "sizes": list(self.sizes), "facts": plain(self.spec.facts)}
        unfinished = f"{self._notes}.tmp"
        with open(unfinished, "w", encoding="utf-8") as file:
            json.dump(notes, file, ensure_ascii=False)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, self._notes)

    def _resume(self) -> None:
        try:
            with open(self._notes, encoding="utf-8") as file:
                notes = json.load(file)
            known, sizes = notes["facts"], tuple(int(size) for size in notes["sizes"])
            good = notes["format"] == FORMAT and len(sizes) == len(self.sizes)
        except (OSError, ValueError, KeyError, TypeError):
            known, sizes, good = {}, self.sizes, False
        # through JSON, as the others have come
        facts = json.loads(json.dumps(plain(self.spec.facts)))
        differ = sorted(key for key in {*facts, *known} if facts.get(key) != known.get(key))
        if differ or not good:
            robot = "robot, or its file has changed"
            named = dict.fromkeys(robot if key in ("robot", "robot's files") else key for key in differ)
            what = ", with another " + ", ".join(named) if differ else ", which cannot be read"
            raise ArgumentError(
                f"{self.folder} holds the finished blocks of another sweep{what}; give its arguments to go on with it, choose "
                "another name, or begin anew (restart=True, --restart)"
            )
        self.sizes = sizes

    # ---- blocks -----------------------------------------------------------------------------------------------------

    def blocks(self) -> Iterator[tuple[str, Block, bool]]:
        """Yield the file of each block, the block, and whether it is finished."""
        there = set(os.listdir(self.folder))
        for number, block in enumerate(cut(self.spec.shape, self.sizes)):
            name = f"{number:08d}.block"
            yield os.path.join(self.folder, name), block, name in there

    def create(self, template: xr.Dataset) -> tuple[dict[str, object], Callable[[Mapping[str, object]], None]]:
        """Return the arrays of an empty store for the whole map, which :meth:`publish` moves to its place, and what closes it."""
        if os.path.isdir(self._unfinished):
            shutil.rmtree(self._unfinished)
        elif os.path.exists(self._unfinished):
            os.remove(self._unfinished)
        sizes = {axis.name: size for axis, size in zip(self.spec.axes, self.sizes, strict=True)}
        return self.store.create(self._unfinished, template, sizes)

    @property
    def _unfinished(self) -> str:
        return os.path.join(self.folder, f"whole{self.store.ending}")

    def publish(self) -> None:
        """Move the whole map to its place, and remove the blocks."""
        if os.path.isdir(self.path):
            shutil.rmtree(self.path)
        os.replace(self._unfinished, self.path)
        shutil.rmtree(self.folder, ignore_errors=True)


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
