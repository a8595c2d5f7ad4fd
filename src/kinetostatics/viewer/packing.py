"""Arrays as text."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import ArrayLike


def packed(array: ArrayLike, dtype: str) -> str:
    """Return an array's numbers as base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")
