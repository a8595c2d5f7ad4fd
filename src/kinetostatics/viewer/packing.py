"""Arrays as text, and how numbers are written, as pages want them."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.printing.text import Scale


def packed(array: ArrayLike, dtype: str) -> str:
    """Return an array's numbers as base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode("ascii")


def plain_scale(scale: Scale) -> dict[str, Any]:
    """Return how numbers are written, as JSON wants it."""
    return {"unit": scale.unit, "factor": scale.factor, "decimals": scale.decimals, "noise": scale.noise}
