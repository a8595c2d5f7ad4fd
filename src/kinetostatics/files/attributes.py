"""Functions that read attributes of XML elements, and tables by which whole elements are read and written.

Each row of a table describes an attribute: the kind of its value, its default, and its field in the description. Errors name the
element, the attribute and the valid form.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Cone, Material, Mimic, Origin, Place, Vector
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.xml import XmlElement
from kinetostatics.units import find_unit

# float() alone would also accept "1_0", "infinity" and digits of other scripts, which URDF tools reject.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_SPACE = " \t\r\n"
#: Limits of numbers in SI units: largest number, largest length, smallest positive number. Beyond them results would overflow.
LARGEST, LONGEST, SMALLEST = 1e30, 1e9, 1e-30
_TOO_SMALL = f"is too small to compute with; it is in SI units, and at least {SMALLEST:g}"


def allow(element: XmlElement, attributes: Iterable[str], children: Iterable[str] = ()) -> None:
    """Raise an error for an unknown attribute or child of the element; all names with a namespace are allowed."""
    attributes, children = tuple(attributes), tuple(children)
    for name in element.attributes:
        if name not in attributes and name != "xmlns" and ":" not in name:
            raise element.error(_unknown(f"{name!r} is not an attribute of {element.label}", name, attributes))
    for child in element.children:
        if child.tag not in children and ":" not in child.tag:
            raise child.error(_unknown(f"<{child.tag}> does not belong in {element.label}", child.tag, children))


def _unknown(reason: str, name: str, right: Collection[str]) -> str:
    if not right:
        return f"{reason}, which has none"
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
    """Return a required attribute, all of whose characters must be printable."""
    value = text(element, name)
    if not value.isprintable():
        raise element.error(f"the name {value!r} of <{element.tag}> has line breaks, tabs or characters that cannot be printed")
    return value


def reference(element: XmlElement, name: str, known: Collection[str], kind: str) -> str:
    """Return a required attribute that must be one of the names ``known``; ``kind`` says in the error what they name."""
    value = text(element, name)
    if value not in known:
        # the label of <parent link> and of a transmission's <joint name> would contain the unknown name
        label = f"<{element.tag}>" if element.attributes.get("name", value) == value else element.label
        near = near_names(value, known)
        raise element.error(f"{label} refers to the {kind} {value!r}, which does not exist; {near}")
    return value


def _invalid(element: XmlElement, name: str, reason: str) -> RobotFileError:
    return element.error(f"{name}={element.attributes[name]!r} of {element.label} {reason}")


def _parse(element: XmlElement, name: str, item: str, largest: float = LARGEST) -> float:
    """Return the number in ``item``, which is the whole text of an attribute or a part of it."""
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
        reason = what + si_hint(item)
    raise _invalid(element, name, reason)


def si_hint(item: str) -> str:
    """Return a hint with the SI value of a number that has a unit; empty for other texts."""
    typed = re.match(_NUMBER, item)
    unit = None if typed is None else find_unit(item[typed.end() :])
    if typed is None or unit is None or not unit.kind:
        return ""
    return f"; numbers in a file are in SI units, without the unit: {float(typed[0]) * unit.size:.12g}"


def number(element: XmlElement, name: str, default: float | None = None) -> float:
    """Return a finite number; without a default the attribute is required."""
    if default is not None and name not in element.attributes:
        return default
    return _parse(element, name, text(element, name).strip(_SPACE))


def positive(element: XmlElement, name: str) -> float:
    value = number(element, name)
    if value <= 0:
        raise _invalid(element, name, "must be greater than zero")
    if value < SMALLEST:
        raise _invalid(element, name, _TOO_SMALL)
    return value


def not_negative(element: XmlElement, name: str, default: float | None = None) -> float:
    value = number(element, name, default)
    if value < 0:
        raise _invalid(element, name, "must be zero or greater")
    return value


def vector(element: XmlElement, name: str, largest: float = LARGEST) -> Vector:
    """Return three required numbers with magnitudes up to ``largest``."""
    value = element.attributes.get(name)
    if value is None:
        raise element.error(f"{element.label} lacks the attribute {name!r}")
    return _three(element, name, re.split(f"[{_SPACE}]+", value), lambda item: _parse(element, name, item, largest))


def point(element: XmlElement, name: str) -> Vector:
    return vector(element, name, LONGEST)


def _three(element: XmlElement, name: str, items: Iterable[str], read: Callable[[str], float]) -> Vector:
    items = list(filter(None, items))
    if len(items) != 3:
        raise _invalid(element, name, f"must be three numbers, not {len(items)}")
    x, y, z = map(read, items)
    return x, y, z


def positive_or_inf(element: XmlElement, name: str) -> float:
    return math.inf if text(element, name).strip(_SPACE) == "inf" else positive(element, name)


def stiffnesses(element: XmlElement, name: str) -> Vector:
    """Return three required numbers, each zero or greater, or "inf"."""

    def read(item: str) -> float:
        value = math.inf if item == "inf" else _parse(element, name, item)
        if value < 0:
            raise _invalid(element, name, "must be three numbers that are zero or greater, or inf")
        if 0 < value < SMALLEST:
            raise _invalid(element, name, _TOO_SMALL)
        return value

    return _three(element, name, text(element, name).split(), read)


def direction(element: XmlElement, name: str) -> Vector:
    """Return the unit vector along a required vector that is not zero."""
    value = vector(element, name, sys.float_info.max)
    if abs(math.hypot(*value) - 1) < 1e-15:  # unchanged, so that numbers that were written are read exactly
        return value
    largest = max(map(abs, value))
    if largest == 0:
        raise element.error(f"{name} of {element.label} is zero; it must have a direction")
    x, y, z = (item / largest for item in value)  # scaled, because squares may overflow
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


# ---- tables of elements -------------------------------------------------------------------------------------------------

#: Default of required attributes of required elements.
NEEDED = object()


@dataclass(frozen=True)
class Kind:
    """Kind of a value: the function that reads it, and its ``form`` in the file: "text", "number" or "numbers"."""

    read: Callable[[XmlElement, str], Keyword]
    form: str = "number"


NAME, TEXT = Kind(new_name, "text"), Kind(text, "text")
NUMBER, POSITIVE, NOT_NEGATIVE = Kind(number), Kind(positive), Kind(not_negative)
POSITIVE_OR_INF = Kind(positive_or_inf)
VECTOR, POINT, DIRECTION = (Kind(read, "numbers") for read in (vector, point, direction))
STIFFNESSES = Kind(stiffnesses, "numbers")


@dataclass(frozen=True)
class Row:
    """An attribute of an XML element.

    Attributes:
        kind: kind of its value.
        default: value if the attribute or its element is missing; NEEDED: required.
        name: field in the description, such as ``axis`` or ``cone.angle``; empty: name of the attribute.
        must: whether an optional element, if present, must have the attribute.
    """

    attribute: str
    kind: Kind
    default: Keyword = NEEDED
    name: str = ""
    must: bool = False

    @cached_property
    def field(self) -> str:
        return self.name or self.attribute

    @cached_property
    def default_text(self) -> str | None:
        """The default as text of a file; None if the attribute has no default."""
        return None if self.default is NEEDED or self.default is None else written(self.kind.form, self.default)


#: Classes of fields that combine several attributes.
PARTS: dict[str, Callable[..., Keyword]] = {
    **dict.fromkeys(("origin", "predecessor_origin", "successor_origin", "platform_origin"), Origin),
    **{"cone": Cone, "mimic": Mimic, "material": Material},
}


@dataclass(frozen=True)
class ElementTable:
    """An XML element of robot files.

    Attributes:
        rows: the attributes, by path of the element: "" for the element itself, ``predecessor/origin`` for a child element.
        children: tags of further allowed child elements.
        open: paths of elements in which unknown attributes and children are ignored.
    """

    tag: str
    rows: Mapping[str, tuple[Row, ...]]
    children: Collection[str] = ()
    open: Collection[str] = ()

    @cached_property
    def _inner(self) -> dict[str, list[str]]:
        """Tags of the allowed child elements, by path."""
        found: dict[str, list[str]] = {path: [] for path in self.rows}
        for head, _, tag in (path.rpartition("/") for path in self.rows if path):
            found[head].append(tag)
        found[""] += self.children
        return found

    def read(self, element: XmlElement, without: Collection[str] = ()) -> dict[str, Keyword]:
        """Return the values of an element by field; fields listed in :data:`PARTS` are objects of the classes listed.

        Child elements with paths in ``without`` are skipped.

        Raises:
            RobotFileError: an attribute or child is unknown or missing, or a value is invalid.
        """
        found: dict[str, Keyword] = {}
        parts: dict[str, dict[str, Keyword]] = {}
        at: dict[str, XmlElement | None] = {"": element}
        for path, rows in self.rows.items():
            head, _, tag = path.rpartition("/")
            here = at[head]
            if path in without:
                here = None
            elif path and here is not None:
                here = here.required_child(tag) if rows[0].default is NEEDED else here.child(tag)
            at[path] = here
            if here is not None and path not in self.open:
                allow(here, [row.attribute for row in rows], self._inner[path])
            for row in rows:
                given = here is not None and (row.must or row.default is NEEDED or row.attribute in here.attributes)
                value = row.kind.read(here, row.attribute) if here is not None and given else row.default
                part, dot, name = row.field.partition(".")
                if dot:
                    parts.setdefault(part, {})[name] = value
                else:
                    found[part] = value
        for part, items in parts.items():
            found[part] = PARTS[part](**items) if next(iter(items.values())) is not None else None
        return found

    def write(
        self,
        item: object,
        place: Place,
        label: str = "",
        *,
        given: Mapping[str, Keyword] | None = None,
        always: Collection[str] = (),
        more: Iterable[XmlElement] = (),
    ) -> XmlElement:
        """Return the XML element of a part of the description.

        Args:
            item: object with the fields of the rows.
            place: file and line of the element.
            label: name of the part in errors.
            given: values by field, which replace the item's values.
            always: paths of child elements that are written even if all values are defaults.
            more: further child elements.

        Raises:
            RobotFileError: a value is not of the expected type.
        """
        given = given or {}
        inside: dict[str, list[XmlElement]] = {path: [] for path in self.rows}
        inside[""] += more
        for path, rows in reversed(list(self.rows.items())):
            texts: dict[str, str] = {}
            is_written = path in always or bool(inside[path]) or not path
            for row in rows:
                value = given.get(row.field, NEEDED)
                if value is NEEDED:
                    value = item
                    for name in row.field.split("."):
                        value = None if value is None else getattr(value, name)
                if value is None:
                    continue
                try:
                    text = written(row.kind.form, value)
                except ArgumentError as error:
                    raise place.error(f"{row.field.rpartition('.')[2]} of {label} {error}") from None
                if text != row.default_text:
                    is_written = True
                elif not (row.must or row.default is NEEDED):
                    continue
                texts[row.attribute] = text
            if is_written:
                head, _, tag = path.rpartition("/")
                element = XmlElement(tag or self.tag, texts, tuple(inside[path]), place, label)
                if not path:
                    return element
                inside[head].insert(0, element)
        raise AssertionError(self.tag)


def written(form: str, value: Keyword) -> str:
    """Return a value as text, in the form of its :class:`Kind`; numbers have all digits, so that they are read exactly."""
    if form == "text":
        if not isinstance(value, str):
            raise ArgumentError(f"is {value!r}; it must be a text")
        return value
    try:
        items = [value] if form == "number" else list(value)
    except TypeError:
        raise ArgumentError(f"is {value!r}; it must be three numbers") from None
    texts = []
    for item in items:
        try:
            texts.append(repr(float(item)).removesuffix(".0"))
        except (TypeError, ValueError, OverflowError):
            raise ArgumentError(f"is {item!r}; it must be a number") from None
    return " ".join(texts)
