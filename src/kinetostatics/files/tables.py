"""Tables of elements: each row has an attribute, the kind of its value, its default and its field in the description.

The same rows read an element and write it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Cone, Material, Mimic, Origin, Place
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files import attribute_values as values
from kinetostatics.files.attribute_values import allow
from kinetostatics.files.xml import XmlElement, shortened

#: Default of a required attribute of a required element.
NEEDED = object()


@dataclass(frozen=True)
class Kind:
    """Kind of a value: a function that reads it, and the ``form`` of its text (a string, a number or several numbers)."""

    read: Callable[[XmlElement, str], Keyword]
    form: str = "number"


NAME, TEXT = Kind(values.new_name, "text"), Kind(values.text, "text")
NUMBER, POSITIVE, NOT_NEGATIVE = Kind(values.number), Kind(values.positive), Kind(values.not_negative)
POSITIVE_OR_INF = Kind(values.positive_or_inf)
VECTOR, POINT, DIRECTION = (Kind(read, "numbers") for read in (values.vector, values.point, values.direction))
STIFFNESSES = Kind(values.stiffnesses, "numbers")


@dataclass(frozen=True)
class Row:
    """An attribute of an XML element.

    Attributes:
        attribute: name of the attribute.
        kind: kind of its value.
        default: value if the attribute or its element is missing; NEEDED: required.
        name: field in the description, such as ``axis`` or ``cone.angle``; empty: name of the attribute.
        must: whether it is required in an optional element.
    """

    attribute: str
    kind: Kind
    default: Keyword = NEEDED
    name: str = ""
    must: bool = False

    @cached_property
    def field(self) -> str:
        """Name of the attribute's field in the description."""
        return self.name or self.attribute

    @cached_property
    def default_text(self) -> str | None:
        """Default value of the attribute, as text of a file."""
        return None if self.default is NEEDED or self.default is None else written(self.kind.form, self.default)


#: Classes of fields with several attributes.
PARTS: dict[str, Callable[..., Keyword]] = {
    **dict.fromkeys(("origin", "predecessor_origin", "successor_origin", "platform_origin"), Origin),
    **{"cone": Cone, "mimic": Mimic, "material": Material},
}


@dataclass(frozen=True)
class ElementTable:
    """An XML element of robot files.

    Attributes:
        tag: name of the element.
        rows: its attributes, and those of its child elements, by their path, such as ``predecessor/origin``.
        children: further allowed child elements.
        open: paths of elements in which unknown attributes and children are ignored.
    """

    tag: str
    rows: Mapping[str, tuple[Row, ...]]
    children: Collection[str] = ()
    open: Collection[str] = ()
    _inner: dict[str, tuple[str, ...]] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for path in self.rows:
            beneath = (other.rpartition("/") for other in self.rows if other)
            inside = tuple(tag for head, _, tag in beneath if head == path)
            self._inner[path] = (*inside, *self.children) if not path else inside

    def read(self, element: XmlElement, without: Collection[str] = ()) -> dict[str, Keyword]:
        """Return the values of an element by field, parts of it as objects.

        Args:
            element: the element.
            without: paths of child elements to be skipped.

        Raises:
            RobotFileError: an attribute or child is unknown or missing, or a value is invalid.
        """
        found: dict[str, Keyword] = {}
        parts: dict[str, dict[str, Keyword]] = {}
        at: dict[str, XmlElement | None] = {"": element}
        for path, rows in self.rows.items():
            head, _, tag = path.rpartition("/")
            here = at[head]
            if path and here is not None:
                here = None if path in without else (here.required_child if rows[0].default is NEEDED else here.child)(tag)
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
        """Return the element of an item of the description.

        Args:
            item: object with the fields of the rows.
            place: place of the element.
            label: name of the item in errors.
            given: values of fields instead of the item's.
            always: paths of child elements that are written even with default values only.
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
                    raise place.error(shortened(f"{row.field.rpartition('.')[2]} of {label} {error}")) from None
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
    """Return a value as text, numbers with all digits needed for exact reading.

    Raises:
        ArgumentError: the value has another form.
    """
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
