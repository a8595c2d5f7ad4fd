"""Parsing of XML text to a tree of :class:`XmlElement` with file and line of each.

The text is first parsed to a minidom document, which xacro requires. File and line of an element are DOM user data: xacro's
clones of the element inherit them, and they do not appear in the XML text.
"""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from xml.dom import expatbuilder, minidom
from xml.parsers import expat

from kinetostatics.description.fields import Place
from kinetostatics.exceptions import RobotFileError

_PLACE = "kinetostatics place"
_NO_ELEMENT_FOUND, _TAG_MISMATCH, _UNBOUND_PREFIX = 3, 7, 27


@dataclass(frozen=True)
class XmlElement:
    """An XML element after expansion of xacro.

    Attributes:
        content: child elements and texts, in order.
        place: file and line.
        owner: for elements without a line, the part of the robot that contains them, such as ``joint 'j1'``.
    """

    tag: str
    attributes: Mapping[str, str]
    content: tuple[XmlElement | str, ...]
    place: Place
    owner: str = ""

    @cached_property
    def children(self) -> tuple[XmlElement, ...]:
        return tuple(child for child in self.content if isinstance(child, XmlElement))

    @cached_property
    def part_place(self) -> Place:
        """The place with those of the child elements, by tag."""
        return replace(self.place, inner={child.tag: child.place for child in reversed(self.children)})

    @property
    def label(self) -> str:
        """Name of the element in messages: ``<joint> 'j1'``, ``<beam> of link 'rod'`` or ``<origin>``."""
        if self.attributes.get("name"):
            return f"<{self.tag}> {self.attributes['name']!r}"
        for what in ("link", "joint"):
            if self.attributes.get(what):
                return f"<{self.tag}> of {what} {self.attributes[what]!r}"
        return f"<{self.tag}>"

    def error(self, reason: str) -> RobotFileError:
        if self.owner and self.place.line is None and self.owner.partition(" ")[2] not in reason:
            reason = f"{self.owner}: {reason}"
        return self.place.error(reason)

    def named(self, tag: str) -> list[XmlElement]:
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> XmlElement | None:
        """Return the child element ``tag``, or None; several are an error."""
        elements = self.named(tag)
        if len(elements) > 1:
            raise elements[1].error(f"{self.label} has two <{tag}>; leave one of them")
        return elements[0] if elements else None

    def required_child(self, tag: str) -> XmlElement:
        child = self.child(tag)
        if child is None:
            raise self.error(f"{self.label} has no <{tag}>")
        return child


def read_file(path: str | os.PathLike[str]) -> bytes:
    """Return the content of an ordinary file; pipes and devices raise an OSError."""
    mode = os.stat(path).st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise OSError(errno.EINVAL, "it is not an ordinary file")
    with open(path, "rb") as stream:
        return stream.read()


class _KeepPlace:
    """Handler of DOM user data that copies the place of a node to its clone."""

    def handle(self, operation: int, key: str, data: object, src: minidom.Node, dst: minidom.Node | None) -> None:
        if dst is not None:
            dst.setUserData(key, data, self)  # type: ignore[arg-type]


_KEEP_PLACE = _KeepPlace()


#: Largest depth of nested elements; functions of minidom are recursive.
DEEPEST = 200


class _DocumentBuilder(expatbuilder.ExpatBuilder):
    """Builds a document, records the line of each element, and rejects entities and deep nesting."""

    file = ""
    uses_xacro = False
    depth = 0

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        node, line = self.curNode, self.getParser().CurrentLineNumber
        self.depth += 1
        if self.depth > DEEPEST:
            raise RobotFileError(f"<{name}> is nested in {DEEPEST} elements, and more are not allowed", self.file, line)
        assert isinstance(node, minidom.Element)
        node.setUserData(_PLACE, Place(self.file, line), _KEEP_PLACE)
        if node.tagName.startswith("xacro:") or node.hasAttribute("xmlns:xacro"):
            self.uses_xacro = True

    def end_element_handler(self, name: str) -> None:
        super().end_element_handler(name)
        self.depth -= 1

    def start_doctype_decl_handler(self, *_declaration: object) -> None:
        reason = "a DOCTYPE, with the entities it may declare, is not allowed in a robot file; delete it"
        raise RobotFileError(reason, self.file, self.getParser().CurrentLineNumber)


class _NamespaceBuilder(_DocumentBuilder, expatbuilder.ExpatBuilderNS):
    """A :class:`_DocumentBuilder` with XML namespaces, for documents that use xacro."""


def parse(data: bytes | str, file: str, plain: bool = False) -> tuple[minidom.Document, bool]:
    """Parse XML, and return the document, with the place of each element, and whether it uses xacro.

    Args:
        data: the contents of the file, as bytes or decoded.
        file: name of the file for messages.
        plain: whether undeclared prefixes are accepted, even with xacro.

    Raises:
        RobotFileError: the text is not well-formed, or has a DOCTYPE.
    """
    if not data.strip():
        raise RobotFileError("the file is empty", file)
    # Plain URDF of old simulators may use undeclared prefixes, which URDF tools accept.
    mentions_xacro = "xacro" in data if isinstance(data, str) else b"xacro" in data
    builder = _NamespaceBuilder() if mentions_xacro and not plain else _DocumentBuilder()
    builder.file = file
    try:
        document = builder.parseString(data)
    except expat.ExpatError as error:
        raise RobotFileError(_parse_failure(error, builder), file, error.lineno) from None
    except (ValueError, LookupError) as error:  # unknown or wrong encoding
        raise RobotFileError(f"the text cannot be decoded: {error}", file, 1) from None
    return document, builder.uses_xacro


def _parse_failure(error: expat.ExpatError, builder: _DocumentBuilder) -> str:
    """Return the reason of a parse error, with the element whose end tag is missing."""
    reason = f"this is not well-formed XML: {expat.ErrorString(error.code)}"
    if error.code == _UNBOUND_PREFIX:
        return f'{reason}; declare it, as in <robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
    node = builder.curNode
    place = place_of(node)
    if error.code in (_TAG_MISMATCH, _NO_ELEMENT_FOUND) and place is not None and isinstance(node, minidom.Element):
        return f"{reason}; <{node.tagName}> of line {place.line} is not closed"
    return reason


def place_of(node: object) -> Place | None:
    """Return the place of a node, or of the nearest element around it with a known place; None without such an element."""
    while isinstance(node, minidom.Node):
        place = node.getUserData(_PLACE)
        if isinstance(place, Place):
            return place
        node = node.parentNode
    return None


_NO_NAME = re.compile(r"[\s<>&\"'/=]|^[-.\d]|^$")
_NO_CHARACTER = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def to_elements(document: minidom.Document, place: Place | None = None, owner: str = "") -> XmlElement:
    """Convert a document to elements, without comments, processing instructions and blank text between elements.

    A ``place`` and an ``owner`` are given to all elements.

    Raises:
        RobotFileError: the output of xacro is not XML.
    """
    # loops instead of recursion, because expanded macros may be deeply nested
    order = [root for root in document.childNodes if isinstance(root, minidom.Element)]
    for node in order:  # grows during the loop: parents come before their children
        order.extend(child for child in node.childNodes if isinstance(child, minidom.Element))
    built: dict[int, XmlElement] = {}
    for node in reversed(order):
        here = place or node.getUserData(_PLACE) or place_of(node) or Place("")
        attributes = {str(name): str(value) for name, value in node.attributes.items()}
        content: list[XmlElement | str] = []
        for child in node.childNodes:
            if isinstance(child, minidom.Element):
                content.append(built.pop(id(child)))
            elif isinstance(child, minidom.Text):  # CDATA sections too
                content.append(str(child.data))
        texts = [part for part in content if isinstance(part, str)]
        if wrong := next((name for name in (node.tagName, *attributes) if _NO_NAME.search(name)), None):
            raise here.error(f"{wrong!r} is not a name for an element or attribute")
        if _NO_CHARACTER.search("".join((node.tagName, *attributes, *attributes.values(), *texts))):
            raise here.error(f"<{node.tagName}> has a character that XML does not allow")
        if not any(text.strip() for text in texts):
            content = [part for part in content if isinstance(part, XmlElement)]
        built[id(node)] = XmlElement(node.tagName, attributes, tuple(content), here, owner)
    return built[id(order[0])]


_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
# The URDF parser behind Pinocchio splits vectors at spaces only.
_ATTRIBUTE_ESCAPES = {**_ESCAPES, **str.maketrans({'"': "&quot;", "\n": " ", "\t": " ", "\r": " "})}


def to_text(root: XmlElement, comment: str = "", header: bool = True, indented: bool = False) -> str:
    """Return an element as XML text; if ``indented``, child elements are on separate lines, except beside text."""
    parts = ['<?xml version="1.0"?>\n'] if header else []
    if comment:
        parts.append(f"<!-- {comment.replace('--', '- -')} -->\n")
    stack: list[tuple[XmlElement | str, int | None]] = [(root, 0 if indented else None)]  # strings are finished text
    while stack:
        node, depth = stack.pop()
        if isinstance(node, str):
            parts.append(node)
            continue
        written = (f' {name}="{value.translate(_ATTRIBUTE_ESCAPES)}"' for name, value in node.attributes.items())
        head = f"<{node.tag}{''.join(written)}"
        if not node.content:
            parts.append(f"{head}/>")
            continue
        parts.append(f"{head}>")
        if depth is None or not all(isinstance(part, XmlElement) for part in node.content):
            stack.append((f"</{node.tag}>", None))
            content = reversed(node.content)
            stack.extend((part.translate(_ESCAPES), None) if isinstance(part, str) else (part, None) for part in content)
            continue
        stack.append((f"\n{'  ' * depth}</{node.tag}>", None))
        for part in reversed(node.content):
            stack.extend(((part, depth + 1), (f"\n{'  ' * (depth + 1)}", None)))
    return "".join(parts) + ("\n" if header else "")
