"""The units that people read: µm rather than 1e-6 m, degrees for coordinates."""

from __future__ import annotations

import math
import textwrap

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.exceptions import ArgumentError

_DEGREE = math.pi / 180
#: Letters along a colour bar.
BAR = 38

#: For every unit of a map the units it may be shown in, and their size. A figure chooses from those with SI prefixes.
UNITS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9, "um": 1e-6},
    "rad": {
        "rad": 1.0,
        "mrad": 1e-3,
        "µrad": 1e-6,
        "nrad": 1e-9,
        "urad": 1e-6,
        "deg": _DEGREE,
        "°": _DEGREE,
        "mdeg": 1e-3 * _DEGREE,
    },
    "N": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3},
    "N m": {"N·m": 1.0, "kN·m": 1e3, "MN·m": 1e6, "mN·m": 1e-3},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "GN/m": 1e9, "N/mm": 1e3, "N/µm": 1e6, "N/um": 1e6},
    "N m/rad": {"N·m/rad": 1.0, "kN·m/rad": 1e3, "MN·m/rad": 1e6, "GN·m/rad": 1e9},
    "N/rad": {"N/rad": 1.0, "kN/rad": 1e3, "MN/rad": 1e6, "GN/rad": 1e9},
    "N m/m": {"N·m/m": 1.0, "kN·m/m": 1e3, "MN·m/m": 1e6, "GN·m/m": 1e9},
    **{
        f"{motion}/{load if ' ' not in load else f'({load})'}": {
            f"{prefix}{motion}/{load if ' ' not in load else '(N·m)'}": size
            for prefix, size in (("", 1.0), ("m", 1e-3), ("µ", 1e-6), ("n", 1e-9), ("p", 1e-12))
        }
        for motion in ("m", "rad")
        for load in ("N", "N m")
    },
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
}
_SHOWN_AS = {"um": "µm", "urad": "µrad", "deg": "°", "mdeg": "10⁻³ °", "N/um": "N/µm"}
_NOT_CHOSEN = ("um", "urad", "deg", "°", "mdeg", "N/mm", "N/µm", "N/um")


def display_unit(units: str, values: ArrayLike, wanted: str | None = None) -> tuple[float, str]:
    """Return by what to divide values, and the unit's name on the figure.

    Args:
        units: of the map.
        values: all that the figure shows.
        wanted: a unit to use; None: the one in which the largest value is between 1 and 1000.

    Raises:
        ArgumentError: the wanted unit is not one for these values.
    """
    units = units.replace("·", " ")
    known = UNITS.get(units, {units: 1.0})
    if wanted is not None:
        if wanted not in known:
            raise ArgumentError(f"unit {wanted!r} is not one for values in {units}: {', '.join(known)}")
        return known[wanted], _SHOWN_AS.get(wanted, wanted)
    candidates = sorted((size, name) for name, size in known.items() if name not in _NOT_CHOSEN)
    finite = np.asarray(values, dtype=float)
    finite = np.abs(finite[np.isfinite(finite)])
    largest = float(finite.max(initial=0.0))
    if largest == 0:
        return 1.0, next(name for size, name in candidates if size == 1)
    fitting = [item for item in candidates if item[0] <= largest * (1 + 1e-12)]
    return fitting[-1] if fitting else candidates[0]


def coordinate_unit(units: str, values: ArrayLike) -> tuple[float, str]:
    """Return the same for a swept coordinate: angles in degrees, lengths in m or, if all are below 0.1 m, in mm."""
    if units == "rad":
        return _DEGREE, "°"
    if units == "m":
        return (1.0, "m") if np.abs(np.asarray(values, dtype=float)).max(initial=0.0) >= 0.1 else (1e-3, "mm")
    return 1.0, units


def label(name: str, unit: str) -> str:
    """Return the text of an axis."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def typeset(text: str) -> str:
    """Return words with numbers in them with the minus signs that axes have."""
    return text.replace("= -", "= −")


def wrapped(text: str) -> str:
    """Return the name of a colour bar in lines that are not longer than the bar of a figure in three dimensions."""
    return textwrap.fill(text, BAR)
