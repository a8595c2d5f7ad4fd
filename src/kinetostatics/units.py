"""Units: a table of basic units, SI prefixes, products, quotients and powers; units in which reports and figures show numbers.

>>> unit("mm").in_si(80)
0.08
>>> unit("N/mm").in_si(3), unit("N/mm").kind
(3000.0, 'stiffness')
>>> find_unit("furlong") is None
True
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache

from kinetostatics.exceptions import ArgumentError

#: Exponents of m, kg, s, K and rad.
Dimension = tuple[int, ...]

#: Basic units: exponent of ten of the size in SI, and dimension. Degrees have a further factor, see :class:`Unit`.
BASIC: dict[str, tuple[int, Dimension]] = {
    "m": (0, (1, 0, 0, 0, 0)),
    "g": (-3, (0, 1, 0, 0, 0)),
    "s": (0, (0, 0, 1, 0, 0)),
    "K": (0, (0, 0, 0, 1, 0)),
    "rad": (0, (0, 0, 0, 0, 1)),
    "deg": (0, (0, 0, 0, 0, 1)),
    "°": (0, (0, 0, 0, 0, 1)),
    "N": (0, (1, 1, -2, 0, 0)),
    "J": (0, (2, 1, -2, 0, 0)),
    "Pa": (0, (-1, 1, -2, 0, 0)),
    "bar": (5, (-1, 1, -2, 0, 0)),
    "Hz": (0, (0, 0, -1, 0, 0)),
}
#: SI prefixes as powers of ten; u and both Unicode letters µ are micro.
PREFIXES = {
    **{"p": -12, "n": -9, **dict.fromkeys("uµμ", -6), "m": -3, "c": -2, "d": -1},
    **{"": 0, "da": 1, "h": 2, "k": 3, "M": 6, "G": 9},
}

#: Kinds of quantities in messages, with their SI units.
KINDS = {
    "length": "m",
    "angle": "rad",
    "mass": "kg",
    "time": "s",
    "frequency": "Hz",
    "temperature": "K",
    "force": "N",
    "moment": "N·m",
    "stress": "Pa",
    "density": "kg/m³",
    "acceleration": "m/s²",
    "area": "m²",
    "stiffness": "N/m",
    "turning stiffness": "N·m/rad",
}
#: Units in which reports show numbers, by SI unit; smallest first.
IN_REPORTS: dict[str, tuple[str, ...]] = {
    **{name: (f"n{name}", f"µ{name}", f"m{name}", name) for name in ("m", "rad")},
    **{name: (name,) for name in ("kg", "K", "N", "N·m")},
    **{"Pa": ("MPa",), "J": ("µJ", "mJ", "J")},
    **{"N/m": ("N/mm", "N/µm"), "N·m/rad": ("N·m/rad", "N·m/mrad", "kN·m/mrad")},
}
#: Units in which figures show numbers, by unit of a map.
IN_FIGURES: dict[str, tuple[str, ...]] = {
    name: tuple(f"{prefix}{name}" for prefix in prefixes)
    for prefixes, names in (
        (("", "m", "µ", "n"), ("m", "rad")),
        (("",), ("kg", "Hz")),
        (("", "k", "M", "m"), ("N", "N·m")),
        (("", "k", "M", "G"), ("Pa", "N/m", "N·m/rad", "N/rad", "N·m/m")),
        (("", "m", "µ", "n", "p"), ("m/N", "m/(N·m)", "rad/N", "rad/(N·m)")),
    )
    for name in names
}
#: Kinds and SI units of the platform's coordinates.
PLATFORM_KINDS = {
    **dict.fromkeys(("x", "y", "z"), "length"),
    **dict.fromkeys(("rx", "ry", "rz", "azimuth", "tilt", "torsion"), "angle"),
}
PLATFORM_UNITS = {name: KINDS[kind] for name, kind in PLATFORM_KINDS.items()}
#: List of units for messages.
KNOWN = (
    "m, g, s, K, rad, deg, N, J, Pa, bar and Hz, with SI prefixes (mm, cm, µm, kN, MPa, mrad), and combinations: "
    "N·m or Nm, N/mm, kg/m³ or kg/m3, m/s²"
)

_POWER = re.compile(r"(.*?)(?:\^|\*\*)?([²³⁴]|[234])")
_TYPED = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?![eE][-+]?\d)(?:[^\W\d_]|°|(?:1\s*)?/).*?)?\s*")
_SIZED = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\(([^()]*)\)|:(.*))?\s*")
_POWERS = {"²": 2, "³": 3, "⁴": 4}


@dataclass(frozen=True)
class Unit:
    """A unit of measurement.

    Attributes:
        ten, degrees: exponents of 10 and of π/180 in the size of the unit in SI.
        dimension: exponents of m, kg, s, K and rad.
    """

    ten: int = 0
    degrees: int = 0
    dimension: Dimension = (0, 0, 0, 0, 0)

    def __mul__(self, other: Unit) -> Unit:
        dimension = tuple(x + y for x, y in zip(self.dimension, other.dimension, strict=True))
        return Unit(self.ten + other.ten, self.degrees + other.degrees, dimension)

    def __truediv__(self, other: Unit) -> Unit:
        dimension = tuple(x - y for x, y in zip(self.dimension, other.dimension, strict=True))
        return Unit(self.ten - other.ten, self.degrees - other.degrees, dimension)

    @property
    def size(self) -> float:
        """Size of the unit in SI, such as 0.001 for mm."""
        return self.in_si(1.0)

    def in_si(self, value: float) -> float:
        """Return a value of this unit in SI, rounded correctly for decimal units: 80 mm is 0.08."""
        scaled = value / float(f"1e{-self.ten}") if self.ten < 0 else value * float(f"1e{self.ten}")
        return scaled * (math.pi / 180) ** self.degrees

    @property
    def kind(self) -> str:
        """Kind of quantity that this unit measures, a key of :data:`KINDS`; empty if there is none."""
        return next((kind for kind, name in KINDS.items() if unit(name).dimension == self.dimension), "")


@cache
def find_unit(text: str) -> Unit | None:
    """Return the unit of a text such as ``mm``, ``kN·m``, ``N/(µm)`` or ``g/cm3``, or None."""
    first, *under = _split(text.strip(), "/")
    quotient = Unit() if under and first.strip() in ("", "1") else _product(first)
    for factor in under:
        divisor = _product(factor)
        if quotient is None or divisor is None:
            return None
        quotient = quotient / divisor
    return quotient


def unit(name: str) -> Unit:
    """Return the unit of a name that is known to be valid."""
    valid_unit = find_unit(name)
    assert valid_unit is not None, name
    return valid_unit


def typed_number(text: str) -> tuple[float, str] | None:
    """Return the number and the unit of a text such as ``-1.5kN``; None if the text is no number."""
    match = _TYPED.fullmatch(text)
    return None if match is None else (float(match[1]), match[2] or "")


def parse_number(text: str, kind: str, what: str) -> float:
    """Return, in SI, a number that may carry a unit.

    Args:
        text: the text, such as ``-1.5kN``.
        kind: kind of the quantity, a key of :data:`KINDS`; "number": without a unit; "": of any kind.
        what: name of the quantity, for messages.

    Raises:
        ArgumentError: the text is no number, or has a unit of another kind.
    """
    typed = typed_number(text)
    given_unit = find_unit(typed[1]) if typed and typed[1] else None
    expected = {"": "a number", "number": "a plain number"}.get(kind) or f"{article(kind)} such as 1{KINDS[kind]}"
    if typed is None or (typed[1] and given_unit is None):
        raise ArgumentError(f"{what}: {text.strip()!r} is not {expected}")
    if given_unit is None:
        return typed[0]
    if kind and (kind == "number" or given_unit.dimension != unit(KINDS[kind].replace("·", " ")).dimension):
        raise ArgumentError(f"{what}: {text.strip()!r} is not {expected}")
    return given_unit.in_si(typed[0])


def sized_name(text: str) -> tuple[str, str | None]:
    """Return the name and the size of a quantity such as ``deflection_any_direction(500 N)``; the size is None if not given.

    A colon is accepted instead of brackets: ``deflection_any_direction:500N``.
    """
    match = _SIZED.fullmatch(text)
    if match is None:
        return text.strip(), None
    return match[1], next((part.strip() for part in match.groups()[1:] if part is not None), None)


def sized_example(name: str, unit: str) -> str:
    """Return an example of a quantity with a size in ``unit``, such as ``deflection_any_direction(500 N)``."""
    return f"{name}({500 if unit == KINDS['force'] else 20} {unit})"


def article(noun: str) -> str:
    """Return a noun with "a" or "an"."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _split(text: str, sign: str) -> list[str]:
    """Return the parts of a text, divided at every ``sign`` outside brackets."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if letter == sign and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _product(text: str) -> Unit | None:
    text = text.strip()
    if text.startswith("(") and text.endswith(")"):
        text = text[1:-1]
    factors = [_factor(part) for part in re.split(r"(?<!\*)\*(?!\*)|[·⋅ ]", text)]
    units = [factor for factor in factors if factor is not None]
    return math.prod(units, start=Unit()) if len(units) == len(factors) else None


def _factor(text: str) -> Unit | None:
    power = _POWER.fullmatch(text)
    if power is not None:
        base = _prefixed(power[1])
        return base and math.prod([base] * (_POWERS.get(power[2]) or int(power[2])), start=Unit())
    joined = re.fullmatch(r"(.*N)(.*m)", text)  # Nm, kNm, Nmm
    prefixed = _prefixed(text)
    if prefixed is None and joined is not None:
        force, arm = _prefixed(joined[1]), _prefixed(joined[2])
        return force and arm and force * arm
    return prefixed


def _prefixed(text: str) -> Unit | None:
    """Return the unit of a basic unit's name with or without a prefix; None for other texts."""
    for name, (ten, dimension) in BASIC.items():
        prefix = text.removesuffix(name)
        if prefix != text and prefix in PREFIXES:
            return Unit(ten + PREFIXES[prefix], int(name in ("deg", "°")), dimension)
    return None
