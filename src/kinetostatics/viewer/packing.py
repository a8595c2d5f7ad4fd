"""Encoding of arrays as text, and number formats, for pages."""

from __future__ import annotations

import base64
import gzip
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.layout.numbers import NumberFormat

#: Numbers that stand beside larger ones are kept to a part of their own size only if they have at least this part of the largest.
SMALL = 0.05
#: Frames on which ways to write a number are tried.
TRIED = 96


def packed(array: ArrayLike, dtype: str) -> str:
    """Return an array's numbers as base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")


def zipped(text: str) -> str:
    """Return a text compressed by gzip, as base64; alike whenever it is made."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


@dataclass(frozen=True)
class Packing:
    """How numbers that change along a path are written: as differences, most of which are small and compress well.

    Attributes:
        bits: of the largest number, to which all are rounded; None: single precision, nothing is lost.
    """

    bits: int | None = None

    def path(self, values: ArrayLike, width: int = 1) -> str | dict[str, object]:
        """Return numbers of every frame; those of one frame alone are plain base64.

        Args:
            values: (F, …) numbers.
            width: how many numbers make one thing, as the three of a vector: they are rounded and followed each for itself.
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
        ways, rest = _shortest(whole, width)
        folded = ((rest << 1) ^ (rest >> 31)).T.astype("<u4")  # small numbers of either sign become small ones
        planes = np.ascontiguousarray(np.moveaxis(np.ascontiguousarray(folded)[..., None].view(np.uint8), -1, 0))
        used = 4 if not np.any(planes) else int(np.max(np.flatnonzero(planes.any(axis=(1, 2))))) + 1
        return {
            "frames": len(table), "width": width, "step": None if step is None else step.tolist(),
            "data": base64.b64encode(ways.tobytes() + planes[:used].tobytes()).decode("ascii"), "planes": used,
        }  # fmt: skip


#: Single precision, as numbers of one pose are written anyhow.
EXACT = Packing()


def _shortest(whole: NDArray[np.int32], width: int) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
    """Return for each column (F,) of whole numbers the way that leaves the smallest differences, and these.

    Ways count three by three: a number as it is, less that of the thing before, less what the two things before continue to; and
    each of these as it is, less that of the frame before, and less that once more. All wraps around at 32 bits, as in the page.
    """
    before = np.zeros_like(whole)
    before[:, width:] = whole[:, :-width]
    further = before.copy()
    further[:, 2 * width :] += whole[:, width:-width] - whole[:, : -2 * width]
    guesses = (np.zeros_like(whole), before, further)
    some = slice(len(whole) // 2 - TRIED // 2 if len(whole) > TRIED else 0, len(whole) // 2 + TRIED // 2)
    tried = [_less(whole[some] - guess[some], n)[2:].astype(np.float32) for guess in guesses for n in range(3)]
    ways = np.array([np.log2(1 + np.abs(numbers)).sum(axis=0) for numbers in tried]).argmin(axis=0)
    rest = np.empty_like(whole)
    for way in np.unique(ways):
        mine = ways == way
        rest[:, mine] = _less((whole - guesses[way // 3])[:, mine], way % 3)
    return ways.astype(np.uint8), rest


def _less(numbers: NDArray[np.int32], times: int) -> NDArray[np.int32]:
    """Return differences (F, …) to the frame before, so many times over."""
    for _ in range(times):
        numbers = np.concatenate([numbers[:1], numbers[1:] - numbers[:-1]])
    return numbers


def plain_scale(scale: NumberFormat) -> dict[str, object]:
    """Return how numbers are written, as JSON wants it."""
    return {"unit": scale.unit, "factor": scale.factor, "decimals": scale.decimals, "noise": scale.noise}
