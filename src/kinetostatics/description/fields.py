"""Kinds of values in a description: which values a field may have, as files give them or Python.

A kind belongs to a field's type: ``mass: NotNegative``. The fields of a part are checked when it is made, by
:func:`check_fields`; the reader of files checks attributes by the same kinds.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from typing import Annotated, ClassVar, get_args, get_type_hints

from kinetostatics.arguments import Keyword
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.layout.mapping import ShortRepr

Vector = tuple[float, float, float]

#: Limits of numbers in SI units: largest number, largest length, smallest positive number. Beyond them results would overflow.
LARGEST, LONGEST, SMALLEST = 1e30, 1e9, 1e-30
_TOO_SMALL = f"is too small to compute with; it is in SI units, and at least {SMALLEST:g}"


@dataclass(frozen=True)
class Place:
    """Position of an element in its file: ``file`` and ``line`` (None if unknown); ``inner``: its child elements, by tag."""

    file: str = "<python>"
    line: int | None = None
    inner: Mapping[str, Place] = field(default_factory=dict, compare=False, repr=False)

    def __str__(self) -> str:
        return self.file if self.line is None else f"{self.file}:{self.line}"

    def of(self, *tags: str) -> Place:
        """Return the place of the first child element that is in the file, or else of the element itself."""
        return next((self.inner[tag] for tag in tags if tag in self.inner), self)

    def error(self, reason: str) -> RobotFileError:
        """Return a :class:`RobotFileError` at this place."""
        return RobotFileError(reason, self.file, self.line)


#: Place of parts that are not from a file.
IN_PYTHON = Place()


@dataclass(frozen=True)
class Kind:
    """Kind of a value.

    Attributes:
        form: "text", "number" or "numbers".
        check: returns a value as it is stored; raises an ArgumentError with the end of a sentence that begins with the value.
    """

    form: str
    check: Callable[[Keyword], Keyword]


def _float(value: Keyword, is_part: bool = False) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"is wrong: {value!r} is not a number" if is_part else "is not a number") from None


def _finite(value: float, largest: float = LARGEST) -> float:
    if not math.isfinite(value):
        raise ArgumentError("is not finite")
    if abs(value) > largest:
        raise ArgumentError(f"is too large to compute with; it is in SI units, and at most {largest:g}")
    return value


def _number(value: Keyword) -> float:
    return _finite(_float(value))


def _positive(value: Keyword) -> float:
    number = _number(value)
    if number <= 0:
        raise ArgumentError("must be greater than zero")
    if number < SMALLEST:
        raise ArgumentError(_TOO_SMALL)
    return number


def _positive_or_inf(value: Keyword) -> float:
    return math.inf if _float(value) == math.inf else _positive(value)


def _not_negative(value: Keyword) -> float:
    number = _number(value)
    if number < 0:
        raise ArgumentError("must be zero or greater")
    return number


def _tuple(size: int, words: str, value: Iterable[Keyword], check: Callable[[float], float] = _finite) -> tuple[float, ...]:
    try:
        given = tuple(value)
    except TypeError:
        raise ArgumentError(f"must be {words}") from None
    if len(given) != size:
        raise ArgumentError(f"must be {words}, not {len(given)}")
    result = tuple(check(_float(entry, is_part=True)) for entry in given)
    return given if all(map(operator.is_, given, result)) else result


def _three(value: Keyword, check: Callable[[float], float] = _finite) -> Vector:
    return _tuple(3, "three numbers", value, check)  # type: ignore[return-value]


def _point(value: Keyword) -> Vector:
    return _three(value, lambda number: _finite(number, LONGEST))


def _direction(value: Keyword) -> Vector:
    """Return the unit vector along a vector that is not zero."""
    vector = _three(value, lambda number: _finite(number, sys.float_info.max))
    if abs(math.hypot(*vector) - 1) < 1e-15:  # unchanged, so that numbers that were written are read exactly
        return vector
    largest = max(map(abs, vector))
    if largest == 0:
        raise ArgumentError("is zero; it must have a direction")
    x, y, z = (number / largest for number in vector)  # scaled, because squares may overflow
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


def _stiffness(value: float) -> float:
    number = value if value == math.inf else _finite(value)
    if number < 0:
        raise ArgumentError("must be three numbers that are zero or greater, or inf")
    if 0 < number < SMALLEST:
        raise ArgumentError(_TOO_SMALL)
    return number


def _limit(value: Keyword) -> float:
    number = _float(value)
    return number if math.isinf(number) else _finite(number)


def _text(value: Keyword) -> str:
    if not isinstance(value, str):
        raise ArgumentError("is not a text")
    if not value.strip():
        raise ArgumentError("is empty")
    return value


def _name(value: Keyword) -> str:
    if not _text(value).isprintable():
        raise ArgumentError("has line breaks, tabs or characters that cannot be printed")
    return str(value)


TEXT, NAME = Kind("text", _text), Kind("text", _name)
NUMBER, POSITIVE, NOT_NEGATIVE = Kind("number", _number), Kind("number", _positive), Kind("number", _not_negative)
PAIR = Kind("numbers", lambda value: _tuple(2, "two numbers", value, lambda number: _finite(number, LONGEST)))
POINT, VECTOR = Kind("numbers", _point), Kind("numbers", _three)
Text = Annotated[str, TEXT]
Name = Annotated[str, NAME]
Number = Annotated[float, NUMBER]
Positive = Annotated[float, POSITIVE]
NotNegative = Annotated[float, NOT_NEGATIVE]
Limit = Annotated[float, Kind("number", _limit)]
PositiveOrInf = Annotated[float, Kind("number", _positive_or_inf)]
Point = Annotated[Vector, POINT]
Angles = Annotated[Vector, VECTOR]
Direction = Annotated[Vector, Kind("numbers", _direction)]
Stiffnesses = Annotated[Vector, Kind("numbers", lambda value: _three(value, _stiffness))]
Moments = Annotated[
    tuple[float, float, float, float, float, float],
    Kind("numbers", lambda value: _tuple(6, "the six moments ixx, ixy, ixz, iyy, iyz, izz", value)),
]


@cache
def kinds(part: type) -> dict[str, tuple[Kind | type, bool]]:
    """Return, by field of a dataclass, the kind of its values or the class of its own fields, and whether it may be None."""
    result: dict[str, tuple[Kind | type, bool]] = {}
    hints = get_type_hints(part, include_extras=True)
    for name in (entry.name for entry in fields(part)):  # type: ignore[arg-type]
        hint = hints[name]
        options = [option for option in get_args(hint) if option is not type(None)]
        optional = type(None) in get_args(hint)
        hint = options[0] if optional else hint
        kind = next((entry for entry in getattr(hint, "__metadata__", ()) if isinstance(entry, Kind)), None)
        if kind is not None or (isinstance(hint, type) and is_dataclass(hint) and issubclass(hint, ShortRepr)):
            result[name] = kind or hint, optional
    return result


def check_fields(part: object, place: Place, label: str, path: str = "") -> dict[str, Keyword]:
    """Return the values of all fields with a kind that differ from those given: floats, and unit vectors.

    Args:
        part: a dataclass; fields that are dataclasses are checked, too.
        place: file and line, for errors.
        label: the part in errors, such as "joint 'a'".
        path: field of the part that is checked, with a dot.

    Raises:
        RobotFileError: a value is invalid.
    """
    changed: dict[str, Keyword] = {}
    for name, (kind, optional) in kinds(type(part)).items():  # type: ignore[arg-type]
        value = getattr(part, name)
        if value is None and optional:
            continue
        if isinstance(kind, Kind):
            try:
                new = kind.check(value)
            except ArgumentError as error:
                raise place.error(f"{path}{name}={shown(value)} of {label} {error}") from None
        elif not isinstance(value, kind):
            raise place.error(f"{path}{name}={value!r} of {label} is not of the type {kind.__name__}")
        else:
            inner = check_fields(value, place, label, f"{path}{name}.")
            new = replace(value, **inner) if inner else value  # type: ignore[type-var]
        if new is not value:
            changed[name] = new
    return changed


def shown(value: Keyword) -> str:
    text = repr(value)
    return text if len(text) <= 120 else f"{text[:60]}…{text[-1]}"


class CheckedPart(ShortRepr):
    """A part of a description, which checks its fields when it is made."""

    KIND: ClassVar[str]
    name: str
    place: Place

    @property
    def label(self) -> str:
        """The part in messages: ``joint 'a'``, or ``<joint> 'a'`` of a file."""
        return f"{self.KIND if self.place.line is None else f'<{self.KIND}>'} {self.name!r}"

    def __post_init__(self) -> None:
        for name, value in check_fields(self, self.place, self.label).items():
            object.__setattr__(self, name, value)
