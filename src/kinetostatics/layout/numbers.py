"""Number formats: a common unit and number of decimals for all numbers of a kind; rounding errors are written as 0."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.math.linalg import EQUAL
from kinetostatics.units import IN_REPORTS, unit

#: Numbers up to this fraction of the largest one of their kind are rounding errors and shown as 0.
NOISE = 1e-9
#: Units to choose from, smallest first: name and size in SI.
Units = tuple[tuple[str, float], ...]

#: Units in which numbers are written, by their SI unit.
UNITS_OF: Mapping[str, Units] = {
    "": (("", 1.0),),
    **{si: tuple((name, unit(name).size) for name in names) for si, names in IN_REPORTS.items()},
}
LENGTHS, ANGLES, MASSES, FORCES, MOMENTS = (UNITS_OF[si] for si in ("m", "rad", "kg", "N", "N·m"))
STRESSES, STIFFNESSES, TURNING_STIFFNESSES, ENERGIES = (UNITS_OF[si] for si in ("Pa", "N/m", "N·m/rad", "J"))
MILLIMETRES: Units = (("mm", unit("mm").size),)
DEGREES: Units = (("°", unit("°").size),)
PER_CENT: Units = (("%", 0.01),)

MISSING = "–"


@dataclass(frozen=True)
class NumberFormat:
    """Format of all numbers of one kind: common unit and number of decimals.

    Attributes:
        unit: name of the unit.
        factor: size of the unit in SI.
        decimals: digits after the point.
        noise: largest magnitude [SI] that is shown as 0.
        units, digits: arguments of :meth:`of`.
    """

    unit: str
    factor: float
    decimals: int
    noise: float
    units: Units = ()
    digits: int = 5

    @classmethod
    def of(cls, values: ArrayLike, units: Units, noise: float = 0.0, digits: int = 5) -> NumberFormat:
        """Choose unit and decimals for values; the largest one has ``digits`` digits.

        Args:
            values: the values [SI]; those that are not finite are ignored.
            units: units to choose from, smallest first.
            noise: largest magnitude [SI] shown as 0; at least :data:`NOISE` times the largest value is used.
            digits: number of digits of the largest value.
        """
        most = largest([values])
        noise = max(noise, NOISE * most)
        if most <= noise:  # zeros only
            name, factor = units[min(1, len(units) - 1)]
            return cls(name, factor, 0, noise, units, digits)
        fitting = [unit for unit in units if most >= 0.9999995 * unit[1]]
        name, factor = fitting[-1] if fitting else units[0]
        before_point = math.floor(math.log10(most / factor * (1 + EQUAL**2))) + 1
        return cls(name, factor, min(max(digits - before_point, 0), 9), noise, units, digits)

    def __call__(self, value: ArrayLike) -> str:
        number = float(np.asarray(value)) * (1 + EQUAL**2)  # avoids ties in the rounding of short decimals
        if math.isnan(number):
            return MISSING
        if math.isinf(number):
            return "∞" if number > 0 else "-∞"
        if abs(number) <= self.noise:
            return "0"
        if abs(number) / self.factor < 9.5 * 10.0**-self.decimals and self.decimals:  # fewer than two digits would remain
            return f"{number / self.factor:.2e}"
        return f"{number / self.factor:.{self.decimals}f}"

    def with_unit(self, value: ArrayLike) -> str:
        """Write one number and the unit."""
        return f"{self(value)}{'' if self.unit == '°' else ' '}{self.unit}"


def largest(values: Iterable[ArrayLike]) -> float:
    """Return the largest finite magnitude in arrays."""
    arrays = (np.abs(np.asarray(value, dtype=float)) for value in values)
    return max((float(np.max(array, initial=0.0, where=np.isfinite(array))) for array in arrays), default=0.0)


#: Units of the kinds of quantities with a noise floor.
KINDS = {"displacement": LENGTHS, "rotation": ANGLES, "force": FORCES, "moment": MOMENTS}
#: The kinds of forces by their units.
FORCE_KINDS = {"N": "force", "N·m": "moment"}


@dataclass(frozen=True)
class NoiseFloor:
    """Displacement, rotation, force and moment [SI] up to which magnitudes are rounding errors.

    A characteristic length relates rotations to displacements, and moments to forces; thus in a pure translation, all rotations
    are recognized as rounding errors.
    """

    displacement: float
    rotation: float
    force: float
    moment: float

    @classmethod
    def of(cls, twists: Iterable[NDArray[np.float64]], wrenches: Iterable[NDArray[np.float64]], length: float) -> NoiseFloor:
        """Return :data:`NOISE` times the largest components of twists (…, 6) and wrenches (…, 6), related by ``length`` [m]."""
        twists, wrenches = list(twists), list(wrenches)
        displacement = max(largest(t[..., :3] for t in twists), length * largest(t[..., 3:] for t in twists))
        force = max(largest(w[..., :3] for w in wrenches), largest(w[..., 3:] for w in wrenches) / length)
        return cls(NOISE * displacement, NOISE * displacement / length, NOISE * force, NOISE * force * length)

    def format(self, kind: str, values: ArrayLike, digits: int = 5) -> NumberFormat:
        """Choose unit and decimals for values [SI] of a kind, which is the name of an attribute."""
        return NumberFormat.of(values, KINDS[kind], getattr(self, kind), digits)


def quantity(value: ArrayLike, units: Units, noise: float = 0.0, digits: int = 5) -> str:
    return NumberFormat.of(value, units, noise, digits).with_unit(value)


def in_unit(value: float, unit: str, digits: int = 6) -> str:
    """Write a number with its unit, such as ``N m``; the unit ``1`` of ratios is not written."""
    return f"{value + 0.0:.{digits}g} {'' if unit == '1' else unit.replace(' ', '·')}".rstrip()


def vector(values: Iterable[ArrayLike], scale: NumberFormat) -> str:
    """Write the components of a vector in parentheses, with the unit."""
    return "(" + ", ".join(scale(value) for value in values) + f") {scale.unit}"


def join_words(names: Sequence[str], limit: int = 6) -> str:
    """Return names as ``a, b and c``; of more than ``limit`` names, only the first ones, the last one, and the number of all."""
    if len(names) > limit:
        return f"{', '.join(names[: limit - 2])}, … {names[-1]} ({len(names)})"
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
