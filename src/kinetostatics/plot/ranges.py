"""From which value to which a figure's colours or heights go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError

#: With fewer values none is told apart as an outlier.
FEW = 20
#: The part of the values at either end that may lie far beyond the others, and how many times their range that is.
PART, FAR = 0.02, 3.0


def main_range(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return smallest and largest value, without the few that lie far beyond all others.

    Beside a singularity there is no largest sag: one pose that happens to be near it would leave one colour for all the rest.
    """
    low, high = float(values.min()), float(values.max())
    if values.size < FEW:
        return low, high
    first = float(np.quantile(values, PART, method="higher"))
    last = float(np.quantile(values, 1 - PART, method="lower"))
    far = FAR * (last - first)
    if far <= 0:
        return low, high
    return (first if first - low > far else low), (last if high - last > far else high)


@dataclass(frozen=True)
class Range:
    """The values that colours or heights show.

    Attributes:
        low, high: from where to where.
        extend: at which ends of a colour bar values lie beyond.
        note: how far they go beyond a range that nobody has asked for, in words: ", up to 70.6".
    """

    low: float
    high: float
    extend: Literal["neither", "both", "min", "max"]
    note: str


def range_of(values: NDArray[np.float64], limits: tuple[float, float] | None) -> Range:
    """Return the range of finite values: what is asked for, or the main one."""
    low, high = limits or main_range(values)
    least, most = float(values.min()), float(values.max())
    words = ([f"from {least:.3g}"] if least < low else []) + ([f"up to {most:.3g}"] if most > high else [])
    note = f", {' '.join(words)}".replace("-", "−") if words and limits is None else ""
    below, above = least < low, most > high
    return Range(low, high, "both" if below and above else "min" if below else "max" if above else "neither", note)


def check_limits(limits: tuple[float, float] | None) -> None:
    """Complain about limits that are no range.

    Raises:
        ArgumentError: the first is not below the second, or one is not a finite number.
    """
    if limits is None:
        return
    try:
        low, high = (float(item) for item in limits)
    except (TypeError, ValueError):
        raise ArgumentError(f"limits are {limits!r}; they must be two numbers, the smaller one first") from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise ArgumentError(f"limits are {low:g} and {high:g}; they must be two numbers, the smaller one first")
