"""Encoding of arrays as text, and number formats, for pages."""

from __future__ import annotations

import base64
import gzip
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.layout.numbers import NumberFormat

#: Smallest scale for the rounding of a component, as a part of the largest component.
SMALL = 0.05
#: Number of frames on which predictions are compared.
TRIED = 96


def packed(array: ArrayLike, dtype: str) -> str:
    """Return an array's numbers as base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")


def zipped(text: str) -> str:
    """Return a text compressed by gzip, as base64; equal texts give equal results."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


@dataclass(frozen=True)
class Packing:
    """Encoding of numbers along a path as prediction errors, which are small and compress well.

    Attributes:
        bits: rounding step, relative to the largest number, is 2^-bits; None: no rounding, single precision.
    """

    bits: int | None = None

    def path(self, values: ArrayLike, width: int = 1) -> str | dict[str, object]:
        """Return encoded numbers of all frames; numbers of a single frame are plain base64.

        Args:
            values: (F, …) numbers.
            width: number of components of an item (3 for vectors), each rounded and predicted separately.
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
        predictions, rest = _shortest(whole, width)
        folded = ((rest << 1) ^ (rest >> 31)).T.astype("<u4")  # zigzag code: small numbers of either sign become small ones
        planes = np.ascontiguousarray(np.moveaxis(np.ascontiguousarray(folded)[..., None].view(np.uint8), -1, 0))
        used = 4 if not np.any(planes) else int(np.max(np.flatnonzero(planes.any(axis=(1, 2))))) + 1
        return {
            "frames": len(table), "width": width, "step": None if step is None else step.tolist(),
            "data": base64.b64encode(predictions.tobytes() + planes[:used].tobytes()).decode("ascii"), "planes": used,
        }  # fmt: skip


#: Encoding without rounding.
EXACT = Packing()


def _shortest(whole: NDArray[np.int32], width: int) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
    """Return for each column (F,) of integers the prediction with the smallest errors, as a number 0 to 8, and these errors.

    Prediction 3 a + b subtracts from a number: nothing (a = 0), the previous item (1), or the linear extrapolation of the two
    previous items (2); then takes b = 0, 1 or 2 differences along the frames. Numbers wrap at 32 bits, as in the page.
    """
    before = np.zeros_like(whole)
    before[:, width:] = whole[:, :-width]
    further = before.copy()
    further[:, 2 * width :] += whole[:, width:-width] - whole[:, : -2 * width]
    guesses = (np.zeros_like(whole), before, further)
    some = slice(len(whole) // 2 - TRIED // 2 if len(whole) > TRIED else 0, len(whole) // 2 + TRIED // 2)
    tried = [_less(whole[some] - guess[some], n)[2:].astype(np.float32) for guess in guesses for n in range(3)]
    predictions = np.array([np.log2(1 + np.abs(numbers)).sum(axis=0) for numbers in tried]).argmin(axis=0)
    rest = np.empty_like(whole)
    for prediction in np.unique(predictions):
        mine = predictions == prediction
        rest[:, mine] = _less((whole - guesses[prediction // 3])[:, mine], prediction % 3)
    return predictions.astype(np.uint8), rest


def _less(numbers: NDArray[np.int32], times: int) -> NDArray[np.int32]:
    """Return the differences (F, …) to the previous frame, taken ``times`` times."""
    for _ in range(times):
        numbers = np.concatenate([numbers[:1], numbers[1:] - numbers[:-1]])
    return numbers


def plain_scale(scale: NumberFormat) -> dict[str, object]:
    """Return a number format as JSON data."""
    return {"unit": scale.unit, "factor": scale.factor, "decimals": scale.decimals, "noise": scale.noise}
