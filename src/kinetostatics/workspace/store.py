"""Arrays of a sweep: in memory, or chunk by chunk in a zarr store, from which an interrupted sweep is resumed.

The map is the file ``out`` of a sweep, such as ``map.nc``; the store is a folder beside it, ``map.nc.part``. Its chunks are the
blocks of the sweep. ``status`` is written last for each block: a block is complete if its chunk of ``status`` exists.

Several jobs may fill one store. While they compute, they share the lock of the file ``map.nc.part.lock``; a job that corrects
assembly modes and publishes the map holds it alone. The operating system releases the lock of a job that is killed.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import json
import math
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.layout.report import as_json
from kinetostatics.math.arrays import Values
from kinetostatics.output_files import replacing
from kinetostatics.workspace.dataset import Labels, attributes_of, dataset, shapes
from kinetostatics.workspace.grid import Block, cut
from kinetostatics.workspace.sweep_plan import SweepPlan

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    import xarray as xr

Stored: TypeAlias = Any  # arrays and groups of NumPy, zarr and h5netcdf, without a common type

#: Packages by file extension; the first is the engine of xarray.
ENGINES = {".nc": ("h5netcdf", "h5py", "zarr"), ".nc4": ("h5netcdf", "h5py", "zarr"), ".zarr": ("zarr",)}
#: Upper bound of what a netCDF file has beside its numbers [bytes].
HEADER = 2**20
#: Attribute of an unfinished store with the identity of its sweep, and prefix of its files with corrections by continuity.
NOTES, CHANGES = "unfinished", ".continuity"
#: Attributes of a Dataset that identify its sweep, with phrases for different values in messages.
COMPARED = {
    "arguments": "other arguments",
    "robot_text_sha256": "another robot",
    "kinetostatics_version": "another version of kinetostatics",
    "pinocchio_version": "another version of pinocchio",
    "numpy_version": "another version of numpy",
}


def packages_of(path: str) -> tuple[str, ...]:
    """Return the packages needed for a file; the first is xarray's engine."""
    for ending, packages in ENGINES.items():
        if path.rstrip("/").lower().endswith(ending):
            return packages
    raise ArgumentError(f"out is {path!r}; it must end in .nc (netCDF) or .zarr")


def map_exists(path: str, identity: str, attributes: Mapping[str, object], restart: bool) -> bool:
    """Whether the map of this sweep exists already.

    Args:
        identity: digest of the sweep, :attr:`SweepPlan.identity`.
        restart: whether a map of another sweep may be overwritten.

    Raises:
        ArgumentError: ``path`` is no map, or it is the map of another sweep that may not be overwritten.
    """
    if not os.path.exists(path):
        parent = os.path.dirname(os.path.abspath(path))
        if not os.path.isdir(parent):
            raise ArgumentError(f"out is {path!r}, but there is no folder {parent!r}")
        return False
    try:
        with open_map(path) as there:
            stored = dict(there.attrs)
    except Exception:
        stored = {}
    if "sweep_sha256" not in stored:
        raise ArgumentError(f"{path} exists and is not the map of a sweep; choose another name")
    if restart:
        return False
    if stored["sweep_sha256"] == identity:
        return True
    differ = [what for key, what in COMPARED.items() if stored.get(key) != attributes.get(key)] or ["other arguments"]
    raise ArgumentError(
        f"{path} is the map of another sweep, with {', '.join(differ)}; choose another name, or let it be overwritten "
        "(restart=True, --restart)"
    )


def open_map(path: str) -> xr.Dataset:
    """Open a stored map; its numbers are read on demand."""
    import xarray as xr

    return xr.open_dataset(path, engine=packages_of(path)[0])


@contextlib.contextmanager
def locked(path: str, shared: bool) -> Iterator[None]:
    """Hold the lock of the store of the map ``path``; without a store, its last holder removes the file."""
    name = f"{path}.part.lock"
    if fcntl is None:
        if shared:
            raise KinetostaticsError("part= needs file locks, which this system lacks")
        yield
        return
    with contextlib.ExitStack() as files:
        while True:
            try:
                file = files.enter_context(open(name, "ab"))
                fcntl.flock(file, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
            except OSError as error:
                if shared or error.errno not in (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP):
                    raise KinetostaticsError(f"{name} cannot be locked: {error.strerror}") from None
                break
            with contextlib.suppress(FileNotFoundError):  # just removed by its last holder
                if os.path.samestat(os.stat(name), os.fstat(file.fileno())):
                    break
        try:
            yield
        finally:
            if not os.path.exists(f"{path}.part"):
                with contextlib.suppress(OSError):  # held by another job
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.remove(name)


def save(ds: xr.Dataset, path: str) -> xr.Dataset:
    """Write a complete Dataset to a file, and open it."""
    if packages_of(path)[0] == "zarr":
        ds.to_zarr(path, mode="w", zarr_format=2, consolidated=True)
    else:
        with replacing(path) as file:
            ds.to_netcdf(file, engine="h5netcdf")
    return open_map(path)


class Arrays:
    """The variables of a sweep in memory.

    Attributes:
        arrays: arrays by name, of NumPy or of zarr.
    """

    arrays: Mapping[str, Stored]

    def __init__(self, plan: SweepPlan, labels: Labels, sizes: tuple[int, ...]) -> None:
        self.plan, self.labels, self.sizes = plan, labels, sizes
        self._items = labels.variables
        self._create()

    def _create(self) -> None:
        sizes = shapes(self.plan, self.labels)
        self.arrays = {name: np.empty(sizes[name], variable.dtype) for name, variable in self._items.items()}

    def write(self, block: Block, numbers: Mapping[str, Values]) -> None:
        """Write the variables of a block, its status last."""
        for name in (*(name for name in self._items if name != "status"), "status"):
            self.arrays[name][self._where(name, block)] = numbers[name]

    def read(self, name: str, block: Block) -> Values:
        return np.asarray(self.arrays[name][self._where(name, block)])

    def _where(self, name: str, block: Block) -> Stored:
        kinds = self._items[name].varies
        return tuple(piece for piece, axis in zip(block, self.plan.axes, strict=True) if axis.kind in kinds) or ...

    def is_done(self, block: Block) -> bool:
        """Whether a block was computed before the sweep was interrupted."""
        return False

    def changes(self, region: str) -> dict[str, Any] | None:
        """Return the corrections of a region that :meth:`keep` stored before the sweep was interrupted."""
        return None

    def keep(self, region: str, changes: Mapping[str, Any]) -> None:
        """Store the corrections of a region's poses before they are applied."""


class Store(Arrays):
    """The variables of a sweep in a zarr store, from which the map ``out`` is written."""

    def __init__(self, plan: SweepPlan, labels: Labels, sizes: tuple[int, ...], path: str, restart: bool) -> None:
        self.path, self.folder, self._restart = path, f"{path}.part", restart
        with self.naming_the_file():
            super().__init__(plan, labels, sizes)

    @contextlib.contextmanager
    def naming_the_file(self) -> Iterator[None]:
        """Replace errors of the file system by one error with the name of the file."""
        try:
            yield
        except OSError as error:
            begun = f"; the results so far are in {self.folder}, and the same call continues from there"
            stays = begun if hasattr(self, "arrays") else ""
            raise KinetostaticsError(f"{error.filename or self.folder}: {error.strerror or error}{stays}") from None

    def _create(self) -> None:
        import zarr

        group: Stored = self._interrupted()
        if group is None:
            _check_disk(self.plan, self.labels, self.path)
            new = f"{self.folder}.{secrets.token_hex(4)}.new"
            dataset(self.plan, self.labels, {}, {}).to_zarr(new, mode="w", consolidated=False, zarr_format=2)
            group = zarr.open_group(new, mode="a", zarr_format=2)
            lengths = dict(zip((axis.name for axis in self.plan.axes), self.sizes, strict=True))
            for name, shape in shapes(self.plan, self.labels).items():
                variable = self._items[name]
                dims = [*(axis.name for axis in self.plan.axes if axis.kind in variable.varies), *variable.dims]
                group.create_array(
                    name,
                    shape=shape,
                    dtype=variable.dtype,
                    fill_value=np.nan if np.dtype(variable.dtype).kind == "f" else None,
                    attributes={
                        "_ARRAY_DIMENSIONS": dims,
                        **{key: as_json(value) for key, value in attributes_of(name, self.labels).items()},
                    },
                    chunks=tuple(min(lengths.get(dim, n), n) for dim, n in zip(dims, shape, strict=True)),
                    compressors=None,
                )
            group.attrs[NOTES] = {"sizes": list(self.sizes), "facts": as_json(self.plan.facts)}
            try:
                os.rename(new, self.folder)
            except OSError:
                if not os.path.exists(self.folder):
                    raise
                shutil.rmtree(new)  # another job was faster
            self._restart = False
            group = self._interrupted()
        with zarr.config.set({"array.write_empty_chunks": True}):  # otherwise zarr omits chunks of zeros or NaN
            self._group, self.arrays = group, {name: group[name] for name in self._items}

    def _interrupted(self) -> Stored | None:
        """Return the store of this sweep if it was interrupted.

        Raises:
            ArgumentError: the folder contains another sweep or cannot be read.
        """
        import zarr

        if self._restart:
            shutil.rmtree(self.folder, ignore_errors=True)
        if not os.path.exists(self.folder):
            return None
        try:
            group = zarr.open_group(self.folder, mode="r+", zarr_format=2)
            notes: Any = group.attrs.get(NOTES)
            if notes is None:  # interrupted before the first block
                shutil.rmtree(self.folder)
                return None
            stored, sizes = notes["facts"], tuple(int(size) for size in notes["sizes"])
            readable = len(sizes) == len(self.sizes) and all(name in group for name in self._items)
        except (OSError, ValueError, KeyError, TypeError):
            stored, readable = {}, False
        facts = json.loads(json.dumps(as_json(self.plan.facts)))  # converted through JSON like the stored ones
        differ = sorted(key for key in {*facts, *stored} if facts.get(key) != stored.get(key))
        if differ or not readable:
            robot = "robot, or its file has changed"
            named = dict.fromkeys(robot if key in ("robot", "robot's files") else key for key in differ)
            what = ", with another " + ", ".join(named) if stored else ", which cannot be read"
            raise ArgumentError(
                f"{self.folder} is the unfinished map of another sweep{what}; give its arguments to continue it, choose "
                "another name, or overwrite it (restart=True, --restart)"
            )
        self.sizes = sizes
        return group

    def write(self, block: Block, numbers: Mapping[str, Values]) -> None:
        with self.naming_the_file():
            super().write(block, numbers)

    def is_done(self, block: Block) -> bool:
        return os.path.exists(os.path.join(self.folder, "status", self._chunk(block)))

    def _chunk(self, block: Block) -> str:
        place = tuple(piece.start // size for piece, size in zip(block, self.sizes, strict=True))
        return str(self.arrays["status"].metadata.encode_chunk_key(place))

    def missing_parts(self, count: int) -> list[int]:
        """Return the parts, of ``count``, with missing blocks; see :func:`kinetostatics.workspace.block.compute_part`."""
        there = set(os.listdir(os.path.join(self.folder, "status")))  # unlike single files, listed anew by shared file systems
        return sorted(
            {k % count + 1 for k, block in enumerate(self.plan.every_block(self.sizes)) if self._chunk(block) not in there}
        )

    def changes(self, region: str) -> dict[str, Any] | None:
        path = os.path.join(self.folder, CHANGES + region)
        if not os.path.exists(path):
            return None
        with np.load(path) as file:
            return dict(file)

    def keep(self, region: str, changes: Mapping[str, Any]) -> None:
        path = os.path.join(self.folder, CHANGES + region)
        with self.naming_the_file(), replacing(path) as partial, open(partial, "wb") as file:
            np.savez(file, **changes)

    def publish(self, attributes: Mapping[str, object]) -> None:
        """Convert the complete store to the map, with the attributes of the Dataset."""
        import zarr

        with self.naming_the_file():
            for leftover in glob.glob(f"{glob.escape(self.folder)}.*.new"):  # of jobs that were killed
                shutil.rmtree(leftover, ignore_errors=True)
            if packages_of(self.path)[0] == "zarr":
                unfinished = (*glob.glob(f"{self.folder}/**/*.partial", recursive=True), *glob.glob(f"{self.folder}/{CHANGES}*"))
                for leftover in unfinished:
                    os.remove(leftover)
                self._group.attrs.put(dict(attributes))
                zarr.consolidate_metadata(self.folder, zarr_format=2)
                old = f"{self.path}.old"
                shutil.rmtree(old, ignore_errors=True)
                if os.path.isdir(self.path):
                    os.replace(self.path, old)
                os.replace(self.folder, self.path)
                shutil.rmtree(old, ignore_errors=True)
                return
            disk = shutil.disk_usage(self.folder)
            if disk.total and disk.free < size_of(self.plan, self.labels) + HEADER:  # the HDF5 library crashes on full disks
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            whole = os.path.join(self.folder, "whole.nc")
            self._write_netcdf(whole, attributes)
            os.replace(whole, self.path)
            shutil.rmtree(self.folder, ignore_errors=True)

    def _write_netcdf(self, path: str, attributes: Mapping[str, object]) -> None:
        """Write the map as a netCDF-4 file, block by block."""
        import h5netcdf

        dataset(self.plan, self.labels, {}, attributes).to_netcdf(path, engine="h5netcdf", mode="w")
        with h5netcdf.File(path, "a") as file:
            for name, array in self.arrays.items():
                # netCDF has no truth values: stored by the convention of xarray
                dtype, more = (np.dtype(np.int8), {"dtype": "bool"}) if array.dtype == bool else (array.dtype, {})
                fill = np.nan if dtype.kind == "f" else None
                dims = array.attrs["_ARRAY_DIMENSIONS"]
                made = file.create_variable(name, dims, dtype, fillvalue=fill, chunks=array.chunks or None)
                made.attrs.update({**attributes_of(name, self.labels), **more})
                for where in cut(array.shape, array.chunks):
                    made[where or ...] = array[where or ...].astype(dtype)


def size_of(plan: SweepPlan, labels: Labels) -> int:
    """Return the size of the arrays of a map in bytes."""
    items = labels.variables
    return sum(math.prod(shape) * np.dtype(items[name].dtype).itemsize for name, shape in shapes(plan, labels).items())


def check_memory(plan: SweepPlan, labels: Labels) -> None:
    try:
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):  # not available on this system
        return
    needed = size_of(plan, labels)
    if needed > memory:
        raise ArgumentError(
            f"a map of {plan.size:,} poses takes {_bytes(needed)}, and this machine has {_bytes(memory)} of memory: write it to "
            "a file (out=, --out), make it lazy (chunks= in Python), or use a coarser grid"
        )


def _check_disk(plan: SweepPlan, labels: Labels, path: str) -> None:
    """Check that the disk has space for a map and, for netCDF, for the store from which it is written."""
    disk = shutil.disk_usage(os.path.dirname(os.path.abspath(path)))
    is_store = packages_of(path)[0] == "zarr"
    needed = size_of(plan, labels)
    if disk.total and needed * (1 if is_store else 2) > disk.free:  # total 0: not a disk; writing raises its own error
        raise ArgumentError(
            f"a map of {plan.size:,} poses takes {_bytes(needed)}{'' if is_store else ', twice that while it is written'}, and "
            f"the disk of {path!r} has {_bytes(disk.free)} free: use a coarser grid or another disk"
        )


def _bytes(size: float) -> str:
    """Return a number of bytes as text with a decimal prefix."""
    power = min(int(math.log10(max(size, 1)) / 3), 5)
    return f"{size / 1000**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB', 'PB')[power]}"
