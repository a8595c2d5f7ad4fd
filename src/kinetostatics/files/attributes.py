"""Functions that read attributes of XML elements, and tables by which whole elements are read and written.

Each row of a table describes an attribute: the kind of its value, its default, and its field in the description. Errors name the
element, the attribute and the valid form.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Material, Origin
from kinetostatics.description.fields import IN_PYTHON, NAME, TEXT, Kind, kinds, shown
from kinetostatics.description.joints import Cone, Mimic
from kinetostatics.description.validation import check_reference
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files.xml import XmlElement
from kinetostatics.units import find_unit

# float() alone would also accept "1_0", "infinity" and digits of other scripts, which URDF tools reject.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_SPACE = " \t\r\n"
_SPACES = re.compile(f"[{_SPACE}]+")


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


def value_of(element: XmlElement, name: str, kind: Kind) -> Keyword:
    """Return the value of a required attribute, which must be of a ``kind``."""
    given = element.attributes.get(name)
    if given is None:
        raise element.error(f"{element.label} lacks the attribute {name!r}")
    try:
        if kind.form == "numbers":
            return kind.check(tuple(number_of(word, is_part=True) for word in _SPACES.split(given.strip(_SPACE)) if word))
        return kind.check(given if kind.form == "text" else number_of(given.strip(_SPACE)))
    except ArgumentError as error:
        raise element.error(f"{name}={shown(given)} of {element.label} {error}") from None


def number_of(word: str, is_part: bool = False) -> float:
    if _NUMBER.fullmatch(word) or word == "inf":
        return float(word)
    if _NOT_FINITE.fullmatch(word):
        return math.nan
    raise ArgumentError((f"is wrong: {word!r} is not a number" if is_part else "is not a number") + si_hint(word))


def text(element: XmlElement, name: str) -> str:
    """Return a required attribute that is not blank."""
    return str(value_of(element, name, TEXT))


def new_name(element: XmlElement, name: str = "name") -> str:
    """Return a required attribute, all of whose characters must be printable."""
    return str(value_of(element, name, NAME))


def reference(element: XmlElement, name: str, part_names: Collection[str], kind: str) -> str:
    """Return a required attribute that must be one of the ``part_names``; ``kind`` says in the error what they name."""
    value = text(element, name)
    # the label of <parent link> and of a transmission's <joint name> would contain the unknown name
    label = f"<{element.tag}>" if element.attributes.get("name", value) == value else element.label
    check_reference(element, label, kind, value, part_names)
    return value


def si_hint(quantity: str) -> str:
    """Return a hint with the SI value of a number that has a unit; empty for other texts."""
    typed = re.match(_NUMBER, quantity)
    unit = None if typed is None else find_unit(quantity[typed.end() :])
    if typed is None or unit is None or not unit.kind:
        return ""
    return f"; numbers in a file are in SI units, without the unit: {float(typed[0]) * unit.size:.12g}"


# ---- tables of elements -------------------------------------------------------------------------------------------------

#: Default of required attributes of required elements.
NEEDED = object()


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


def row(part: type, attribute: str, path: str = "", **special: Keyword) -> Row:
    """Return the row of an attribute that is a field of a class, at a path such as ``origin.xyz``, by default with its name.

    Kind and default are those of the field.
    """
    *parts, field = (path or attribute).split(".")
    for name in parts:
        part = kinds(part)[name][0]  # type: ignore[assignment]
    default = {entry.name: entry.default for entry in fields(part)}[field]
    field_row = Row(attribute, kinds(part)[field][0], NEEDED if default is MISSING else default, path)  # type: ignore[arg-type]
    return replace(field_row, **special)


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
        tags_by_path: dict[str, list[str]] = {path: [] for path in self.rows}
        for head, _, tag in (path.rpartition("/") for path in self.rows if path):
            tags_by_path[head].append(tag)
        tags_by_path[""] += self.children
        return tags_by_path

    def read(self, element: XmlElement, without: Collection[str] = ()) -> dict[str, Keyword]:
        """Return the values of an element by field; fields listed in :data:`PARTS` are objects of the classes listed.

        Child elements with paths in ``without`` are skipped.

        Raises:
            RobotFileError: an attribute or child is unknown or missing, or a value is invalid.
        """
        values: dict[str, Keyword] = {}
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
                value = value_of(here, row.attribute, row.kind) if here is not None and given else row.default
                part, dot, name = row.field.partition(".")
                if dot:
                    parts.setdefault(part, {})[name] = value
                else:
                    values[part] = value
        for part, items in parts.items():
            values[part] = PARTS[part](**items) if next(iter(items.values())) is not None else None
        return values

    def write(
        self,
        part: object,
        *,
        given: Mapping[str, Keyword] | None = None,
        always: Collection[str] = (),
        more: Iterable[XmlElement] = (),
    ) -> XmlElement:
        """Return the XML element of a part of the description.

        Args:
            part: object with the fields of the rows.
            given: values by field, which replace the part's values.
            always: paths of child elements that are written even if all values are defaults.
            more: further child elements.
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
                    value = part
                    for name in row.field.split("."):
                        value = None if value is None else getattr(value, name)
                if value is None:
                    continue
                text = written(row.kind.form, value)
                if text != row.default_text:
                    is_written = True
                elif not (row.must or row.default is NEEDED):
                    continue
                texts[row.attribute] = text
            if is_written:
                head, _, tag = path.rpartition("/")
                element = XmlElement(tag or self.tag, texts, tuple(inside[path]), getattr(part, "place", IN_PYTHON))
                if not path:
                    return element
                inside[head].insert(0, element)
        raise AssertionError(self.tag)


def written(form: str, value: Keyword) -> str:
    """Return a value as text, in the form of its :class:`.Kind`; numbers have all digits, so that they are read exactly."""
    if form == "text":
        return str(value)
    return " ".join(repr(float(number)).removesuffix(".0") for number in ([value] if form == "number" else value))
