"""Hints at probable errors of units (millimetres, degrees, GPa); for plausible numbers, the functions return no hints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.layout.numbers import join_words

#: Largest plausible ratio of coordinates to the robot's size, and of parameters to their values in the file.
FAR, LONG = 10.0, 30.0
#: Largest plausible ratio of a tolerance to the toleranced length; largest plausible tolerance of an angle [rad].
COARSE = 0.2
#: A full turn with a margin for rounding errors [rad]; limits of joints beyond ``WIDE`` [rad] mean "no limit".
TURN, WIDE = 2 * math.pi * (1 + 1e-9), 720.0
#: Plausible ranges for solids: Young's modulus [Pa] and density [kg/m³].
MODULI, DENSITIES = (1e8, 2e12), (10.0, 25e3)
_RADIANS = "angles are in rad; 90 degrees are ${pi/2} in xacro"


def largest(values: ArrayLike) -> float:
    """Return the finite value of largest magnitude, with its sign; 0 if there is none."""
    if isinstance(values, int | float):
        return float(values) if math.isfinite(values) else 0.0
    numbers = np.nan_to_num(np.asarray(values, dtype=float), posinf=0.0, neginf=0.0).ravel()
    return float(numbers[np.argmax(np.abs(numbers))]) if numbers.size else 0.0


# ---- lengths ---------------------------------------------------------------------------------------------------------


def length_hint(what: str, amount: float, whole: float, of: str = "the robot's size of", most: float = FAR) -> list[str]:
    """Return a hint if a length [m] is more than ``most`` times a reference length.

    Args:
        what: beginning of the sentence, before the ratio: "z = 90 m is".
        amount: the length.
        whole: the reference length; zero or NaN: no hint.
        of: words between the ratio and the reference length.
        most: largest plausible ratio.
    """
    if not abs(amount) > most * abs(whole) > 0:
        return []
    return [
        f"{what} {abs(amount / whole):.3g} times {of} {abs(whole):.3g} m: lengths are in m; write {amount / 1000:.6g} for "
        f"{amount:.6g} mm, or {amount:.6g}mm on the command line"
    ]


def point_hint(what: str, point: ArrayLike, size: float) -> list[str]:
    """Return a hint if a point (3,) of the platform [m], from o, is far from o compared with the robot's size [m]."""
    amount = largest(point)
    return length_hint(f"{what} lies {abs(amount):.6g} m from o,", amount, size)


def tolerance_hint(name: str, amount: float, length: float, size: float) -> list[str]:
    """Return a hint if a tolerance [m] exceeds ``COARSE`` times ``length`` or, if this is zero, the robot's ``size``."""
    whole, of = (length, "the length itself of") if length else (size, "the robot's size of")
    return length_hint(f"the tolerance {name} = {amount:.6g} m is", amount, whole, of, COARSE)


def limit_hints(limits: Mapping[str, float], size: float) -> list[str]:
    """Return hints at limits of more than ``FAR`` times the robot's size [m]; above 1000 ``FAR`` times, they mean "no limit"."""
    names: dict[float, list[str]] = {}
    for name, limit in limits.items():
        if limit <= 1000 * FAR * size:
            names.setdefault(limit, []).append(name)
    groups = (length_hint(f"the limits of {', '.join(some)} go to {limit:.6g} m,", limit, size) for limit, some in names.items())
    return [hint for hints in groups for hint in hints]


# ---- angles ----------------------------------------------------------------------------------------------------------


def looks_like_degrees(*angles: float) -> bool:
    """Whether the largest of angles [rad] exceeds two turns, or exceeds one turn while all are multiples of 5: 90, 10, -180.

    Angles computed by xacro as sums may slightly exceed one turn.
    """
    most = max(map(abs, angles))
    return most > 2 * TURN or (most > TURN and all(angle % 5 == 0 for angle in angles))


def turns_hint(name: str, angle: float, is_usual: bool) -> list[str]:
    """Return a hint if an angle [rad] exceeds a turn; if turns are usual (``is_usual``), only if it looks like degrees."""
    if abs(angle) <= TURN or (is_usual and not looks_like_degrees(angle)):
        return []
    return [
        f"{name} = {angle:.6g} rad is {angle / (2 * math.pi):.3g} turns: angles are in rad; write "
        f"{math.radians(angle):.6g} for {angle:.6g}°, or {angle:.6g}deg on the command line"
    ]


def angular_tolerance_hint(name: str, amount: float) -> list[str]:
    """Return a hint if the tolerance of an angle exceeds ``COARSE`` [rad]."""
    if not amount > COARSE:
        return []
    return [
        f"the tolerance {name} = {amount:.6g} rad is {math.degrees(amount):.3g}°: angles are in rad; write "
        f"{amount / 1000:.6g} for {amount:.6g} mrad, or {amount:.6g}mrad on the command line"
    ]


def rpy_hints(origins: Iterable[tuple[object, str, tuple[float, float, float]]]) -> list[str]:
    """Return hints at frames (place in the file, name, ``rpy`` [rad]) whose ``rpy`` looks like degrees."""
    return [
        f"{place}: rpy={_written(*rpy)!r} of {what} looks like degrees: {_RADIANS}"
        for place, what, rpy in origins
        if looks_like_degrees(*rpy)
    ]


def angular_limit_hints(limits: Iterable[tuple[object, str, float, float]]) -> list[str]:
    """Return hints at limits (place in the file, joint, lower, upper [rad]) that look like degrees."""
    return [
        f"{place}: the limits {_written(lower, upper)} of {name!r} look like degrees: {_RADIANS}"
        for place, name, lower, upper in limits
        if 2 * TURN < max((abs(limit) for limit in (lower, upper) if math.isfinite(limit)), default=0.0) <= WIDE
    ]


def _written(*numbers: float) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)


# ---- materials -------------------------------------------------------------------------------------------------------


def material_hints(materials: Mapping[str, tuple[float, float | None]]) -> list[str]:
    """Return hints at implausible materials (Young's modulus [Pa], density [kg/m³] or None), given by name of the beam."""
    beams: dict[str, list[str]] = {}
    for name, (modulus, density) in materials.items():
        if not MODULI[0] <= modulus <= MODULI[1]:
            meant = _meant(modulus, MODULI, {"GPa": 1e9, "MPa": 1e6})
            beams.setdefault(f"a Young's modulus of {modulus:.4g} Pa; moduli are in Pa (steel: 2.1e11){meant}", []).append(name)
        if density and not DENSITIES[0] <= density <= DENSITIES[1]:
            meant = _meant(density, DENSITIES, {"g/cm³": 1e3, "kg/mm³": 1e9, "t/mm³": 1e12})
            beams.setdefault(f"a density of {density:.4g} kg/m³; densities are in kg/m³ (steel: 7850){meant}", []).append(name)
    return [
        f"beam{'s' * (len(names) > 1)} {join_words(names, 8)} {'have' if names[1:] else 'has'} {words}"
        for words, names in beams.items()
    ]


def _meant(value: float, usual: tuple[float, float], units: Mapping[str, float]) -> str:
    """Write ": 210 GPa is 2.1e+11", with the unit in which the value is in the range ``usual``; empty if there is none."""
    fitting = (unit for unit, size in units.items() if usual[0] <= value * size <= usual[1])
    return next(
        (f": {value:.4g} {unit} is {value * units[unit]:.4g}{', and lengths are in m' * ('/mm' in unit)}" for unit in fitting), ""
    )
