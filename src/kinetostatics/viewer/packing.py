"""Encoding of arrays as text, for pages; ``unpacking.js`` decodes it."""

from __future__ import annotations

import base64
import gzip
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

#: Least rounding step of a component, as a part of the step of the largest component.
SMALL = 0.05


def packed(array: ArrayLike, dtype: str) -> str:
    """Return base64 of the bytes of an array."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")


def packed_indices(indices: ArrayLike) -> str:
    """Encode whole numbers (n,) by their distances from the next new one, which are zero where each appears in turn."""
    index = np.asarray(indices, dtype=np.int32)
    following = np.concatenate([[0], np.maximum.accumulate(index)[:-1] + 1])
    return packed((following - index).astype("<i4").view(np.uint8).reshape(-1, 4).T, "u1")  # all lowest bytes first


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
