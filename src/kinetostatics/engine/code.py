"""Compiled functions, stored on disk, that compute outputs of a robot at many poses. The robot's numbers are parameters; all its
other data are its structure. Outputs are computed in stages; a call computes the outputs up to a given stage.

Code is compiled once per computer and structure. A file has the object code and a table that describes it. Concurrent processes
can use the same files.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import os
import stat
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from kinetostatics.engine import llvm
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.report import Json
from kinetostatics.math.arrays import Array, Mask, chunks, in_threads
from kinetostatics.output_files import replacing

#: Folders and a module with functions that are recorded or generate code: their text is part of the key of stored code.
_SOURCES = (
    "quantities.py buckling description elements engine kinematics layout limbs math mechanism results sections statics viewer"
).split()
#: Poses computed at a time; their results fit into the processor's cache before they are copied to the result arrays.
BLOCK = 256
#: Stage in which all outputs are computed, see :func:`kinetostatics.engine.llvm.module_of`.
LAST = 99
_KIND = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5, *[ctypes.c_int64] * 2)


class Code:
    """A compiled function of many poses; see :func:`kinetostatics.engine.llvm.module_of`.

    Attributes:
        table: the table stored with the code.
    """

    def __init__(self, kept: bytes) -> None:
        """Load the content of a file, as returned by :func:`packed`."""
        start = 8 + int.from_bytes(kept[:8], "little")
        self.table: dict[str, Json] = json.loads(kept[8:start])
        self.lanes = int(self.table["lanes"])
        self._machine = llvm.MachineCode(kept[start:])
        self.function = _KIND(self._machine.address)
        self._calling = threading.Lock()  # calls for one pose share their arrays
        self._bound: dict[int, tuple[list[Array], Bound, Array, Mask]] = {}  # by stage

    def __call__(self, inputs: Sequence[Array], parameters: Array, numbers: Array, truths: Mask, stage: int = LAST) -> None:
        """Compute outputs at n ≥ ``lanes`` poses; in all arrays the poses are contiguous.

        Args:
            inputs: arrays (k, n).
            parameters: (P,) numbers of the robot.
            numbers, truths: result arrays (R, n) and (T, n); ``numbers`` may share the memory of the first input.
            stage: last stage whose outputs are computed.
        """
        n = numbers.shape[1]
        if n <= 2 * BLOCK or inputs[0].ctypes.data == numbers.ctypes.data:
            Bound(self, inputs, parameters, numbers, truths, stage)()
            return
        block, flags = np.empty((len(numbers), BLOCK)), np.empty((len(truths), BLOCK), dtype=bool)
        bound = Bound(self, inputs, parameters, block, flags, stage)
        for first in (*range(0, n - BLOCK, BLOCK), n - BLOCK):  # the last block may overlap the one before it
            bound.move(first)
            bound()
            numbers[:, first : first + BLOCK], truths[:, first : first + BLOCK] = block, flags

    def results(
        self, inputs: Sequence[Array], parameters: Array, numbers: int, truths: int, stage: int = LAST
    ) -> tuple[Array, Mask]:
        """Return the outputs, (``numbers``, N) and (``truths``, N). The last of the ``inputs`` has N poses."""
        N = inputs[-1].shape[1]
        if N == 1:
            return self._at_one_pose(inputs, parameters, numbers, truths, stage)
        n = max(N, llvm.LANES)
        values, flags = np.empty((numbers, n)), np.empty((truths, n), dtype=bool)
        taken = [contiguous(array, max(array.shape[1], llvm.LANES)) for array in inputs]

        def compute(part: slice) -> None:
            self([array[:, part] for array in taken], parameters, values[:, part], flags[:, part], stage)

        in_threads(compute, chunks(n))
        return values[:, :N], flags[:, :N]

    def _at_one_pose(
        self, inputs: Sequence[Array], parameters: Array, numbers: int, truths: int, stage: int
    ) -> tuple[Array, Mask]:
        """Return :meth:`results` at one pose; the arrays of each stage are allocated once."""
        with self._calling:
            if stage not in self._bound:
                taken = [np.empty((len(array), llvm.LANES)) for array in inputs]
                given = np.empty((numbers, llvm.LANES)), np.empty((truths, llvm.LANES), dtype=bool)
                self._bound[stage] = taken, Bound(self, taken, parameters, *given, stage), *given
            taken, call, values, flags = self._bound[stage]
            for buffer, array in zip(taken, inputs, strict=True):
                buffer[:] = array
            call()
            return values[:, :1].copy(), flags[:, :1].copy()


def found_or_made(
    keys: Sequence[str], make: Sequence[Callable[[], bytes]] | None, is_right: Callable[[list[Code]], bool]
) -> list[Code]:
    """Return the stored code; if a file is missing or its code is incorrect, compile and store all of it.

    Args:
        make: functions that return the content of the files, see :func:`packed`; None: nothing is compiled.
        is_right: function that returns whether the results of the code agree with NumPy's.

    Returns:
        The code; an empty list if the compiled code is incorrect, or if nothing is compiled.
    """
    codes = [Code(content) for content in map(read_stored, keys) if content is not None]
    if len(codes) == len(keys) and is_right(codes):
        return codes
    if make is None:
        return []
    made = [function() for function in make]
    codes = [Code(content) for content in made]
    if not is_right(codes):
        return []
    for key, content in zip(keys, made, strict=True):
        store(key, content)
    return codes


class Bound:
    """A compiled function bound to fixed arrays, which saves time in every call."""

    def __init__(
        self, code: Code, inputs: Sequence[Array], parameters: Array, numbers: Array, truths: Mask, stage: int = LAST
    ) -> None:
        """Bind the arrays of :meth:`Code.__call__`. Inputs may have more poses than the results, see :meth:`move`."""
        self._code, n = code, numbers.shape[1]
        self._pointers = (ctypes.c_void_p * len(inputs))(*[array.ctypes.data for array in inputs])
        self._moving = [(k, array.ctypes.data) for k, array in enumerate(inputs) if array.shape[1] > n]
        strides = (ctypes.c_int64 * len(inputs))(*[array.strides[0] // 8 for array in inputs])
        self._kept = strides, tuple(inputs), parameters, numbers, truths
        addresses = ctypes.addressof(self._pointers), ctypes.addressof(strides)
        data = (array.ctypes.data for array in (parameters, numbers, truths))
        pointers = (ctypes.c_void_p(address) for address in (*addresses, *data))
        self._arguments = (*pointers, ctypes.c_int64(n), ctypes.c_int64(stage))

    def move(self, first: int) -> None:
        """Start the next call at pose ``first`` of the inputs that have more poses than the results."""
        for k, address in self._moving:
            self._pointers[k] = address + 8 * first

    def __call__(self) -> None:
        self._code.function(*self._arguments)


def packed(table: Mapping[str, Json], text: str, lanes: int = llvm.LANES, level: int = 1) -> bytes:
    """Return the content of a file: the size of the table, the table as JSON, and the object code.

    Args:
        table: entries of the table besides ``lanes``.
        text: text of the module, see :func:`kinetostatics.engine.llvm.module_of`.
        level: optimization level, see :func:`kinetostatics.engine.llvm.compiled`.
    """
    head = json.dumps({"lanes": lanes, **table}).encode()
    return len(head).to_bytes(8, "little") + head + llvm.compiled(text, level)


def contiguous(array: Array, n: int) -> Array:
    """Return an array (k, N) as an array (k, n ≥ N) with contiguous poses; additional columns repeat the last pose."""
    N = array.shape[1]
    if n > N:
        extended = np.empty((array.shape[0], n))
        extended[:, :N], extended[:, N:] = array, array[:, N - 1 :]
        return extended
    return array if array.strides[-1] == 8 and array.strides[0] % 8 == 0 else np.ascontiguousarray(array)


def code_key(structure: str) -> str:
    """Return the name of a file of code: a digest of the structure, the recorded functions, all versions and the processor."""
    return hashlib.sha256(f"{structure} {_versions()} {llvm.processor()}".encode()).hexdigest()


@cache
def _versions() -> str:
    """Return a digest of the source text in :data:`_SOURCES`, and NumPy's version."""
    root = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for folder in _SOURCES:
        for path in sorted((root / folder).glob("*.py")) or [root / folder]:
            digest.update(path.read_bytes())
    return f"{digest.hexdigest()} {np.__version__}"


# ---- files ---------------------------------------------------------------------------------------------------------

#: First bytes of a file.
_MAGIC = b"kinetostatics object code 1\n"


def cache_folder() -> Path:
    """Return the folder of compiled code: ``KINETOSTATICS_CACHE``, or the user's cache folder of this system."""
    if given := os.environ.get("KINETOSTATICS_CACHE"):
        return Path(given)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "kinetostatics"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "kinetostatics" / "Cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "kinetostatics"


def read_stored(key: str) -> bytes | None:
    """Return the content of a file; None if there is no file or it is damaged. A damaged file is removed."""
    folder = _if_private(cache_folder())
    if folder is None:
        return None
    path = folder / f"{key}.code"
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, kept = content[len(_MAGIC) : len(_MAGIC) + 32], content[len(_MAGIC) + 32 :]
    if content.startswith(_MAGIC) and hashlib.sha256(kept).digest() == digest:
        return kept
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def store(key: str, content: bytes) -> None:
    """Store the content of a file, unless the folder cannot be created or others may write there too."""
    with contextlib.suppress(OSError, ArgumentError):
        cache_folder().mkdir(parents=True, exist_ok=True, mode=0o700)
        folder = _if_private(cache_folder())
        if folder is None:
            return
        with replacing(folder / f"{key}.code") as partial:
            partial.write_bytes(_MAGIC + hashlib.sha256(content).digest() + content)


def _if_private(folder: Path) -> Path | None:
    """Return a folder if only the user may write there, else None: code in the folder is executed."""
    try:
        facts = folder.stat()
    except OSError:
        return None
    if not stat.S_ISDIR(facts.st_mode):
        return None
    if hasattr(os, "getuid") and (facts.st_uid != os.getuid() or facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        return None
    return folder
