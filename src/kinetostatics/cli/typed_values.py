"""Values typed on the command line: numbers with units, NAME=VALUE items, ranges and lists, in SI."""

from __future__ import annotations

import argparse
import contextlib
import math
import re
from collections.abc import Iterable, Sequence

from kinetostatics.arguments import Argument, Keyword, whole_number
from kinetostatics.description.units import KINDS, KNOWN, Unit, article, find_unit, typed_number
from kinetostatics.exceptions import ArgumentError

VALUES_HELP = """\
values:
  Numbers are SI: m, rad, N, N·m. They may carry units, with SI prefixes: z=500mm rx=-2deg, 1.5kN, 20Nm, 70GPa, 7.8g/cm3.
"""
GRID_HELP = """\
  FROM:TO:COUNT and A,B,C make a grid, whose poses are all combinations of their values.
"""

#: Largest numbers of values along one dimension, and of poses.
MOST = 1_000_000


def parse_quantity(text: str, kind: str | None = None) -> float:
    """Return a number with an optional unit in SI.

    Args:
        text: such as ``500mm``, ``-2deg``, ``1.5kN`` or ``-1e-3``.
        kind: one of :data:`kinetostatics.description.units.KINDS` if units must be of that kind, "number" if none is allowed.
    """
    found = typed_number(text)
    if found is None:
        raise ArgumentError(f"{text.strip()!r} is not a number, with or without a unit; units are {KNOWN}")
    value, name = found
    if not math.isfinite(value):
        raise ArgumentError(f"{text.strip()!r} is too large")
    if not name:
        return value
    unit = find_unit(name)
    if unit is None:
        raise ArgumentError(f"{text.strip()!r} has the unknown unit {name!r}; units are {KNOWN}")
    if kind is not None and (kind == "number" or unit.kind != kind):
        expected = "a plain number" if kind == "number" else article(kind)
        given = article(unit.kind) if unit.kind else "another quantity"
        raise ArgumentError(f"{text.strip()!r} is {given}, but {expected} is needed")
    return unit.in_si(value)


def unit_of(text: str) -> Unit | None:
    """Return the unit of a number, None if the text is no number with a unit."""
    found = typed_number(text)
    return find_unit(found[1]) if found and found[1] else None


def parse_range(option: str, name: str, text: str, kind: str | None = None) -> tuple[float, float, int | None]:
    """Return first, last and number of values of ``FROM:TO[:COUNT]``; the number is None if not given.

    Args:
        option: the option, for messages.
        name: name of the coordinate or parameter.
        text: the range.
        kind: see :func:`parse_quantity`.
    """
    parts = text.split(":")
    if len(parts) not in (2, 3):
        raise ArgumentError(f"{option}: {name}={text} is not of the form {name}=FROM:TO or {name}=FROM:TO:COUNT")
    first, last = parse_coordinates(option, name, parts[:2], kind)
    if len(parts) == 2:
        return first, last, None
    if not parts[2].strip().isdecimal() or int(parts[2]) < 2:
        raise ArgumentError(f"{option}: {name}: {parts[2]!r} is not a number of values, which must be at least 2")
    if int(parts[2]) > MOST:
        count = parts[2].strip()
        raise ArgumentError(f"{option}: {name}: {count} values are too many; at most {MOST:,} go along a dimension")
    return first, last, int(parts[2])


def parse_values(option: str, name: str, text: str, kind: str | None = None) -> float | list[float]:
    """Return one value, or the values of ``FROM:TO:COUNT`` or of a list ``A,B,C``, SI."""
    if ":" in text:
        first, last, count = parse_range(option, name, text, kind)
        if count is None:
            raise ArgumentError(f"{option}: {name}={text} does not give the number of values: {name}={text}:11")
        step = (last - first) / (count - 1)
        return [*(first + step * k for k in range(count - 1)), last]
    if "," in text:
        return parse_coordinates(option, name, text.split(","), kind)
    return parse_coordinates(option, name, [text], kind)[0]


def parse_coordinates(option: str, name: str, texts: Sequence[str], kind: str | None) -> list[float]:
    """Return values of one coordinate or parameter, which are of one kind."""
    try:
        found = [parse_quantity(text, kind) for text in texts]
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {name}: {error}") from None
    kinds = {unit.dimension: text.strip() for text in texts if (unit := unit_of(text)) is not None}
    if len(kinds) > 1:
        raise ArgumentError(f"{option}: {name}: {' and '.join(map(repr, kinds.values()))} are not of one kind")
    return found


def parse_items(option: str, items: Iterable[str]) -> dict[str, str]:
    """Return items ``name=value`` as a dict."""
    found: dict[str, str] = {}
    for item in items:
        name, sign, value = (part.strip() for part in item.partition("="))
        if not (name and sign and value):
            raise ArgumentError(f"{option}: {item.strip()!r} is not of the form name=value")
        if name in found:
            raise ArgumentError(f"{option}: {name!r} is given twice")
        found[name] = value
    return found


def parse_parameters(items: Iterable[str]) -> dict[str, Keyword]:
    """Return the values of ``--set``; numbers with a unit are converted to SI, other texts are unchanged."""
    values = parse_items("--set", items)
    return {name: value if unit_of(value) is None else parse_quantity(value) for name, value in values.items()}


def typed_units(items: Iterable[str]) -> dict[str, str]:
    """Return the SI units of the values of ``--set`` with units."""
    found: dict[str, str] = {}
    for name, value in parse_items("--set", items).items():
        kinds = [typed.kind for part in re.split("[:,]", value) if (typed := unit_of(part)) is not None]
        if kinds and kinds[0]:
            found[name] = KINDS[kinds[0]].replace("·", " ")
    return found


def number_of(option: str, text: str, kind: str | None = "number") -> float:
    """Return the number of an option, of a kind as in :func:`parse_quantity`."""
    try:
        return parse_quantity(text, kind)
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {error}") from None


# ---- values of options ------------------------------------------------------------------------------------------------


def option_of(name: str, argument: Argument) -> str:
    """Return the option of an argument, such as ``--platform-link``; the name of a positional argument has no dashes."""
    return argument.option or f"--{name.replace('_', '-')}"


def value_of(name: str, args: argparse.Namespace) -> Keyword:
    """Return the value of an option for the function, None if not given."""
    argument, given = args.arguments[name], getattr(args, name)
    option = option_of(name, argument)
    if given is None or given is False or given == []:
        return None
    if argument.kind == "items":
        return parse_items(option, given)
    if argument.kind == "count":
        return _whole_number_of(option, given, argument.least)
    if argument.kind in ("", "flag", "text", "optional text", "texts", "names"):
        return given
    if argument.kind == "wrench":
        return [number_of(option, text, "force" if k < 3 else "moment") for k, text in enumerate(given)]
    if argument.size:
        return [number_of(option, text, argument.kind) for text in given]
    return number_of(option, given, argument.kind)


def _whole_number_of(option: str, text: str, least: int) -> int:
    """Return the integer of an option, at least ``least``."""
    number = math.nan
    with contextlib.suppress(ArgumentError):
        number = parse_quantity(text, "number")
    return whole_number(option, int(number) if number.is_integer() else None, least, shown=text.strip())


def given_of(names: Iterable[str], args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the values of the given options by argument name."""
    values = {name: value_of(name, args) for name in names}
    return {name: value for name, value in values.items() if value is not None}
