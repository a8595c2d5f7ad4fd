"""Display units of figures: µm instead of 1e-6 m, degrees for angles."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.exceptions import ArgumentError
from kinetostatics.units import IN_FIGURES, find_unit, unit


def display_unit(units: str, values: ArrayLike, requested: str | None = None) -> tuple[float, str]:
    """Return size and name of the unit in which values are shown; the values are to be divided by the size.

    Args:
        units: unit of the values in the map.
        values: all values in the figure.
        requested: display unit; None: the largest unit in which the largest value is at least 1.

    Raises:
        ArgumentError: the requested unit has another dimension.
    """
    units = units.replace("N m", "N·m")
    choices = IN_FIGURES.get(units, (units,))
    if requested is not None:
        wanted, given = find_unit(requested), find_unit(units)
        if requested == units:
            return 1.0, requested
        if wanted is None or given is None or wanted.dimension != given.dimension:
            further = ", deg" if units == "rad" else ", N/µm" if units == "N/m" else ""
            raise ArgumentError(f"unit {requested!r} is not one for values in {units}: {', '.join(choices)}{further}")
        return wanted.size / given.size, _typeset_unit(requested)
    sizes = sorted((unit(name).size, name) for name in choices if find_unit(name) is not None) or [(1.0, units)]
    finite = np.asarray(values, dtype=float)
    finite = np.abs(finite[np.isfinite(finite)])
    largest = float(finite.max(initial=0.0))
    if largest == 0:
        return 1.0, units
    fitting = [pair for pair in sizes if pair[0] <= largest * (1 + 1e-12)]
    return fitting[-1] if fitting else sizes[0]


def _typeset_unit(name: str) -> str:
    """Return a unit with µ for u and ° for deg."""
    name = re.sub(r"u(?=m|rad|N|deg)", "µ", name)
    return {"deg": "°", "mdeg": "10⁻³ °"}.get(name, name)


def coordinate_unit(units: str, values: ArrayLike) -> tuple[float, str]:
    """Return size and name of the display unit of a coordinate: degrees for angles; m, or mm if all lengths are below 0.1 m."""
    if units == "rad":
        return unit("deg").size, "°"
    if units == "m":
        largest = np.abs(np.asarray(values, dtype=float)).max(initial=0.0)
        return (1.0, "m") if largest >= 0.1 or largest == 0 else (1e-3, "mm")
    return display_unit(units, values)


def label(name: str, unit: str) -> str:
    """Return "name [unit]"; the unit of a dimensionless quantity is omitted."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def typeset(text: str) -> str:
    """Return a text with typographic minus signs after "="."""
    return text.replace("= -", "= −")
