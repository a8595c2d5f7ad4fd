"""Encoding of arrays as text, for pages; ``unpacking.js`` decodes it."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Least rounding step of a component, as a part of the step of the largest component.
SMALL = 0.05


def packed(array: ArrayLike, dtype: str) -> str:
    """Return base64 of the bytes of an array."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")


def packed_indices(indices: ArrayLike) -> str:
    """Encode whole numbers (n,) by their distances from the next new one, which are zero where each appears in turn."""
    index = np.asarray(indices, dtype=np.int32)
    following = np.concatenate([[0], np.maximum.accumulate(index)[:-1] + 1])
    return packed(np.frombuffer(_planes(following - index), np.uint8), "u1")


#: Section of a WebAssembly module with its code; instructions with an operand, those of the memory behind their alignment.
_CODE, _INDEXED, _MEMORY = 10, (0x10, 0x20, 0x21, 0x41), (0x2B, 0x39)
#: Instruction with 8 bytes, all of them zero; the last one of a function; the stream of functions' heads: sizes and variables.
_NUMBER, _END, _HEADS = 0x44, 0x0B, 0
#: Distances within a stream at which operands may have a constant difference.
_LAGS = range(1, 13)


def packed_code(modules: Iterable[bytes]) -> dict[str, object]:
    """Encode modules of WebAssembly as streams, which compress better: instructions, and the operands of each kind."""
    parts, sizes = list[bytes](), list[dict[str, object]]()
    for module in modules:
        start, end, instructions, operands = _streams(module)
        streams = {kind: _differences(np.array(numbers, dtype=np.int64)) for kind, numbers in operands.items()}
        parts += [module[:start], instructions, *(data for _, data in streams.values()), module[end:]]
        counts = [[kind, lag, len(operands[kind])] for kind, (lag, _) in streams.items()]
        sizes.append({"size": len(module), "start": start, "instructions": len(instructions), "operands": counts})
    return {"modules": sizes, "zipped": base64.b64encode(gzip.compress(b"".join(parts), 6, mtime=0)).decode("ascii")}


def _streams(module: bytes) -> tuple[int, int, bytes, dict[int, list[int]]]:
    """Return the place of the first function, the one behind the last, the instructions, and operands by kind."""
    at, instructions, operands = 8, bytearray(), {kind: list[int]() for kind in (_HEADS, *_INDEXED, *_MEMORY)}

    def take(kind: int | None = None) -> int:
        nonlocal at
        number, shift = module[at] & 127, 0
        while module[at] > 127:
            at, shift = at + 1, shift + 7
            number |= (module[at] & 127) << shift
        at += 1
        if kind is not None:
            operands[kind].append(number)
        return number

    while module[at] != _CODE:
        at += 1
        size = take()
        at += size
    at += 1
    _, functions = take(), take()
    start = at
    for _ in range(functions):
        take(_HEADS)
        for _ in range(2 * take(_HEADS)):
            take(_HEADS)
        kind = _HEADS
        while kind != _END:
            kind = module[at]
            instructions.append(kind)
            at += 9 if kind == _NUMBER else 2 if kind in _MEMORY else 1
            if kind in operands:
                take(kind)
    return start, at, bytes(instructions), operands


def _differences(numbers: NDArray[np.int64]) -> tuple[int, bytes]:
    """Return the distance at which most numbers (n,) repeat or grow evenly, and the differences at this distance."""
    shifted = {lag: np.concatenate([numbers[:lag], numbers[lag:] - numbers[:-lag]]) for lag in _LAGS}
    lag = max(_LAGS, key=lambda lag: np.bincount(np.abs(shifted[lag])).max(initial=0))
    return lag, _planes((shifted[lag] << 1) ^ (shifted[lag] >> 63))


def _planes(numbers: ArrayLike) -> bytes:
    """Return the bytes of integers (n,) of 32 bits, all lowest bytes first."""
    return np.asarray(numbers).astype("<i8").astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()


def zipped(text: str) -> str:
    """Return base64 of a text compressed by gzip; equal texts give equal results."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


@dataclass(frozen=True)
class Packing:
    """Encoding of numbers along a path: second differences from pose to pose, which are small and compress well.

    Attributes:
        bits: numbers are rounded to steps of 2^-bits of the largest number; None: single precision.
    """

    bits: int | None = None

    def path(self, values: ArrayLike, width: int = 1) -> str | dict[str, object]:
        """Encode numbers (F, …) at F poses; for one pose, the result is base64.

        Args:
            width: number of components of an item (3 for vectors); each component is rounded with a step of its own.
        """
        table = np.asarray(values, dtype=np.float64).reshape(len(np.asarray(values)), -1)
        if len(table) < 2 or not table.size:
            return packed(table, "<f4")
        step = None
        if self.bits is not None and np.all(np.isfinite(table)):
            most = np.abs(table.reshape(-1, width)).max(axis=0)
            most = np.maximum(most, SMALL * most.max())
            step = np.where(most > 0, most, 1.0) * 2.0**-self.bits
            whole = np.rint(table / np.tile(step, table.shape[1] // width)).astype(np.int32)
        else:
            whole = table.astype(np.float32).view(np.int32)
        for _ in range(2):  # differences wrap at 32 bits, as in the page
            whole = np.concatenate([whole[:1], whole[1:] - whole[:-1]])
        folded = (whole << 1) ^ (whole >> 31)  # zigzag code: small numbers of either sign become small ones
        planes = np.ascontiguousarray(folded.T, dtype="<u4").view(np.uint8).reshape(-1, 4).T  # all lowest bytes first
        return {
            "frames": len(table), "width": width, "step": None if step is None else step.tolist(), "data": packed(planes, "u1")
        }  # fmt: skip


#: Encoding without rounding.
EXACT = Packing()
