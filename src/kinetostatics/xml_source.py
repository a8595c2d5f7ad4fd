"""XML text to a tree of :class:`Element`, each of which knows the file and line it was written in.

The tree passes through minidom, because xacro works on minidom documents. The place of an element is kept as DOM
user data, not as an attribute: cloning (which is how xacro expands macros) carries it along, and neither xacro nor
the text that comes out ever sees it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.dom import expatbuilder, minidom
from xml.parsers import expat

from kinetostatics.description import Place
from kinetostatics.exceptions import RobotFileError

#: Deeper documents are refused, so that nothing downstream can run out of stack.
MAX_DEPTH = 100

_PLACE = "kinetostatics place"
_NO_ELEMENT_FOUND, _TAG_MISMATCH, _UNBOUND_PREFIX = 3, 7, 27


@dataclass(frozen=True)
class Element:
    """An XML element of the expanded file: its ``content`` is child elements and text in order."""

    tag: str
    attributes: Mapping[str, str]
    content: tuple[Element | str, ...]
    place: Place

    @property
    def children(self) -> tuple[Element, ...]:
        """The child elements."""
        return tuple(item for item in self.content if isinstance(item, Element))

    @property
    def label(self) -> str:
        """How messages call the element: ``<joint> 'j1'``, ``<beam> of link 'rod'`` or ``<origin>``."""
        if self.attributes.get("name"):
            return f"<{self.tag}> {self.attributes['name']!r}"
        if self.attributes.get("link"):
            return f"<{self.tag}> of link {self.attributes['link']!r}"
        return f"<{self.tag}>"

    def error(self, reason: str) -> RobotFileError:
        """Return the error that says ``reason`` at this element's place."""
        return RobotFileError(reason, self.place.file, self.place.line)

    def named(self, tag: str) -> list[Element]:
        """Return the child elements called ``tag``."""
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> Element | None:
        """Return the child element called ``tag``, or None; two of them are an error."""
        found = self.named(tag)
        if len(found) > 1:
            raise found[1].error(f"{self.label} has two <{tag}>; leave one of them")
        return found[0] if found else None

    def required_child(self, tag: str) -> Element:
        """Return the child element called ``tag``; none or two of them are an error."""
        found = self.child(tag)
        if found is None:
            raise self.error(f"{self.label} has no <{tag}>")
        return found


class _KeepPlace:
    """User data handler that gives the clone of a node the node's place."""

    def handle(self, operation: int, key: str, data: object, src: minidom.Node, dst: minidom.Node | None) -> None:
        if dst is not None:
            dst.setUserData(key, data, self)  # type: ignore[arg-type]


_KEEP_PLACE = _KeepPlace()


class _Builder(expatbuilder.ExpatBuilder):
    """Builds a document, notes each element's line and refuses what has no business in a robot file."""

    file = ""
    depth = 0
    uses_xacro = False

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        node, line = self.curNode, self.getParser().CurrentLineNumber
        assert isinstance(node, minidom.Element)
        node.setUserData(_PLACE, Place(self.file, line), _KEEP_PLACE)
        if node.tagName.startswith("xacro:") or node.hasAttribute("xmlns:xacro"):
            self.uses_xacro = True
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise RobotFileError(f"elements are nested more than {MAX_DEPTH} deep", self.file, line)

    def end_element_handler(self, name: str) -> None:
        super().end_element_handler(name)
        self.depth -= 1

    def start_doctype_decl_handler(self, *_declaration: Any) -> None:
        reason = "a DOCTYPE, with the entities it may declare, is not allowed in a robot file; delete it"
        raise RobotFileError(reason, self.file, self.getParser().CurrentLineNumber)


class _NamespaceBuilder(_Builder, expatbuilder.ExpatBuilderNS):
    """The same with XML namespaces, which xacro's documents have."""


def parse(data: bytes | str, file: str) -> tuple[minidom.Document, bool]:
    """Parse XML.

    Args:
        data: the text as it lies in the file, or decoded.
        file: its name for messages.

    Returns:
        The document with the place of each element, and whether it uses xacro.

    Raises:
        RobotFileError: if it is not well-formed, too deep, or has a DOCTYPE.
    """
    if not data.strip():
        raise RobotFileError("the file is empty", file)
    # Plain URDF of old simulators may use prefixes that nobody declared, which URDF tools accept.
    builder = _NamespaceBuilder() if _mentions_xacro(data) else _Builder()
    builder.file = file
    try:
        document = builder.parseString(data)
    except expat.ExpatError as error:
        raise RobotFileError(_parse_failure(error, builder), file, error.lineno) from None
    except (ValueError, LookupError) as error:  # an encoding that does not exist, or does not fit
        raise RobotFileError(f"the text cannot be decoded: {error}", file, 1) from None
    return document, builder.uses_xacro


def _mentions_xacro(data: str | bytes) -> bool:
    return "xacro" in data if isinstance(data, str) else b"xacro" in data


def _parse_failure(error: expat.ExpatError, builder: _Builder) -> str:
    """Say what does not parse, and which element was open."""
    reason = f"this is not well-formed XML: {expat.ErrorString(error.code)}"
    if error.code == _UNBOUND_PREFIX:
        return f'{reason}; declare it, as in <robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
    node = builder.curNode
    place = place_of(node)
    if error.code in (_TAG_MISMATCH, _NO_ELEMENT_FOUND) and place is not None and isinstance(node, minidom.Element):
        return f"{reason}; <{node.tagName}> of line {place.line} is not closed"
    return reason


def place_of(node: Any) -> Place | None:
    """Return where the nearest element around a node of a document was written, if that is known."""
    while isinstance(node, minidom.Node):
        place = node.getUserData(_PLACE)
        if isinstance(place, Place):
            return place
        node = node.parentNode
    return None


def to_elements(document: minidom.Document) -> Element:
    """Turn a document into elements; comments and processing instructions are dropped."""
    # Expanded macros may be nested to any depth, hence loops instead of recursion.
    order: list[Any] = [document.documentElement]
    for node in order:  # grows on the way: parents come before their children
        order.extend(child for child in node.childNodes if child.nodeType == minidom.Node.ELEMENT_NODE)
    built: dict[int, Element] = {}
    for node in reversed(order):
        content: list[Element | str] = []
        for child in node.childNodes:
            if child.nodeType == minidom.Node.ELEMENT_NODE:
                content.append(built.pop(id(child)))
            elif child.nodeType in (minidom.Node.TEXT_NODE, minidom.Node.CDATA_SECTION_NODE):
                content.append(child.data)
        place = place_of(node) or Place("", None)
        built[id(node)] = Element(node.tagName, dict(node.attributes.items()), tuple(content), place)
    return built[id(document.documentElement)]


_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
# The URDF parser behind Pinocchio splits vectors at spaces only.
_ATTRIBUTE_ESCAPES = {**_ESCAPES, **str.maketrans({'"': "&quot;", "\n": " ", "\t": " ", "\r": " "})}


def to_text(root: Element) -> str:
    """Write elements as XML text."""
    parts = ['<?xml version="1.0"?>\n']
    stack: list[Element | str] = [root]  # strings are text that is ready
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            parts.append(item)
            continue
        written = (f' {name}="{value.translate(_ATTRIBUTE_ESCAPES)}"' for name, value in item.attributes.items())
        head = f"<{item.tag}{''.join(written)}"
        if not item.content:
            parts.append(f"{head}/>")
            continue
        parts.append(f"{head}>")
        stack.append(f"</{item.tag}>")
        stack.extend(part.translate(_ESCAPES) if isinstance(part, str) else part for part in reversed(item.content))
    return "".join(parts) + "\n"
