"""Values of XML attributes: numbers, vectors, names, references; errors name the element, the attribute and the valid form."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Collection, Iterable
from typing import NoReturn

from kinetostatics.description.elements import Vector
from kinetostatics.description.units import find_unit
from kinetostatics.exceptions import near_names
from kinetostatics.files.xml import XmlElement

# float() alone would also take "1_0", "infinity" and digits of other scripts, which URDF tools do not.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_SPACE = " \t\r\n"
#: Largest number, largest length [m] and smallest size, SI: beyond them numbers are input errors that would overflow later.
LARGEST, LONGEST, SMALLEST = 1e30, 1e9, 1e-30


def allow(element: XmlElement, attributes: Iterable[str], children: Iterable[str] = ()) -> None:
    """Raise an error for an unknown attribute or child of the element; those with a namespace are ignored."""
    attributes, children = tuple(attributes), tuple(children)
    for name in element.attributes:
        if name not in attributes and name != "xmlns" and ":" not in name:
            raise element.error(_unknown(f"{name!r} is not an attribute of {element.label}", name, attributes))
    for child in element.children:
        if child.tag not in children and ":" not in child.tag:
            raise child.error(_unknown(f"<{child.tag}> does not belong in {element.label}", child.tag, children))


def _unknown(reason: str, name: str, right: Collection[str]) -> str:
    if not right:
        return f"{reason}, which takes none"
    near = near_names(name, right)
    return f"{reason}; {near}" + ("" if near.startswith("known") else f" (known: {', '.join(sorted(right))})")


def text(element: XmlElement, name: str) -> str:
    """Return a required attribute that is not blank."""
    value = element.attributes.get(name)
    if value is None:
        raise element.error(f"{element.label} lacks the attribute {name!r}")
    if not value.strip():
        raise element.error(f"the attribute {name!r} of {element.label} is empty")
    return value


def new_name(element: XmlElement, name: str = "name") -> str:
    """Return a required name of one line."""
    value = text(element, name)
    if not value.isprintable():
        raise element.error(f"the name {value!r} of <{element.tag}> has line breaks, tabs or characters that cannot be printed")
    return value


def reference(element: XmlElement, name: str, known: Collection[str], kind: str) -> str:
    """Return an attribute that must be the name of an existing item."""
    value = text(element, name)
    if value not in known:
        # The label of a <parent link> or a transmission's <joint name> would contain the unknown name.
        label = f"<{element.tag}>" if element.attributes.get("name", value) == value else element.label
        near = near_names(value, known)
        raise element.error(f"{label} refers to the {kind} {value!r}, which does not exist; {near}")
    return value


def _parse(element: XmlElement, name: str, item: str, largest: float = LARGEST) -> float:
    """Return one number of an attribute."""
    if _NUMBER.fullmatch(item):
        value = float(item)
        if abs(value) <= largest:
            return value
        reason = f"is too large to compute with; it is in SI units, and at most {largest:g}"
        reason = reason if math.isfinite(value) else "is not finite"
    elif _NOT_FINITE.fullmatch(item):
        reason = "is not finite"
    else:
        what = "is not a number" if item == element.attributes[name] else f"is wrong: {item!r} is not a number"
        reason = f"{what}{_without_unit(item)}"
    raise element.error(f"{name}={element.attributes[name]!r} of {element.label} {reason}")


def _without_unit(item: str) -> str:
    """Return a hint for a number with a unit: its value in SI."""
    typed = re.match(_NUMBER, item)
    unit = None if typed is None else find_unit(item[typed.end() :])
    if typed is None or unit is None or not unit.kind:
        return ""
    return f"; numbers in a file are in SI units, which are not written: {float(typed[0]) * unit.size:.12g}"


def number(element: XmlElement, name: str, default: float | None = None) -> float:
    """Return a finite number; without a default the attribute is required."""
    if default is not None and name not in element.attributes:
        return default
    return _parse(element, name, text(element, name).strip(_SPACE))


def positive(element: XmlElement, name: str) -> float:
    """Return a required number greater than zero."""
    value = number(element, name)
    if value <= 0:
        _wrong_sign(element, name, "greater than zero")
    if value < SMALLEST:
        _too_small(element, name)
    return value


def not_negative(element: XmlElement, name: str, default: float | None = None) -> float:
    """Return a number of zero or more."""
    value = number(element, name, default)
    if value < 0:
        _wrong_sign(element, name, "zero or greater")
    return value


def _wrong_sign(element: XmlElement, name: str, right: str) -> NoReturn:
    raise element.error(f"{name}={element.attributes[name]!r} of {element.label} must be {right}")


def _too_small(element: XmlElement, name: str) -> NoReturn:
    where = f"{name}={element.attributes[name]!r} of {element.label}"
    raise element.error(f"{where} is too small to compute with; it is in SI units, and at least {SMALLEST:g}")


def vector(element: XmlElement, name: str, largest: float = LARGEST) -> Vector:
    """Return three required numbers of at most ``largest``."""
    value = element.attributes.get(name)
    if value is None:
        raise element.error(f"{element.label} lacks the attribute {name!r}")
    return _three(element, name, re.split(f"[{_SPACE}]+", value), lambda item: _parse(element, name, item, largest))


def point(element: XmlElement, name: str) -> Vector:
    """Return the three required coordinates [m] of a point."""
    return vector(element, name, LONGEST)


def _three(element: XmlElement, name: str, items: Iterable[str], read: Callable[[str], float]) -> Vector:
    items = list(filter(None, items))
    if len(items) != 3:
        raise element.error(f"{name}={element.attributes[name]!r} of {element.label} must be three numbers, not {len(items)}")
    x, y, z = map(read, items)
    return x, y, z


def positive_or_inf(element: XmlElement, name: str) -> float:
    """Return a required number greater than zero, or "inf"."""
    return math.inf if text(element, name).strip(_SPACE) == "inf" else positive(element, name)


def stiffnesses(element: XmlElement, name: str) -> Vector:
    """Return three required numbers of zero or more, or "inf"."""

    def read(item: str) -> float:
        value = math.inf if item == "inf" else _parse(element, name, item)
        if value < 0:
            _wrong_sign(element, name, "three numbers that are zero or greater, or inf")
        if 0 < value < SMALLEST:
            _too_small(element, name)
        return value

    return _three(element, name, text(element, name).split(), read)


def direction(element: XmlElement, name: str) -> Vector:
    """Return a unit vector along three numbers that are not all zero."""
    value = vector(element, name, sys.float_info.max)
    if abs(math.hypot(*value) - 1) < 1e-15:  # unchanged, so that written files are read with equal numbers
        return value
    largest = max(map(abs, value))
    if largest == 0:
        raise element.error(f"{name} of {element.label} is zero; it must have a direction")
    x, y, z = (item / largest for item in value)  # scaled, because squares may overflow
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length
