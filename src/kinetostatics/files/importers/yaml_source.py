"""YAML text as nodes that know their lines; nothing is constructed from it.

Only what a list of names needs is let through: mappings, sequences and plain text. Tags, which could name Python objects,
are refused, and aliases stay shared nodes, so that no file grows when it is read.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NoReturn

from kinetostatics.description.elements import Place
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.xml import read_file, shortened

if TYPE_CHECKING:
    import yaml

#: Larger files [bytes] are refused; the largest of Gepetto's has 2 kB.
MAX_YAML = 100_000

_TAG = "tag:yaml.org,2002:"
_TEXT, _LIST, _MAPPING = f"{_TAG}str", f"{_TAG}seq", f"{_TAG}map"
_PLAIN = {
    f"{_TAG}{kind}": meaning
    for kind, meaning in {
        "bool": "a truth value",
        "int": "a number",
        "float": "a number",
        "null": "nothing",
        "timestamp": "a date",
        "merge": "a sign of its own",
        "value": "a sign of its own",
    }.items()
}


def read_mapping(path: str | os.PathLike[str]) -> dict[str, object]:
    """Return the nodes of a YAML file's top-level mapping, by key.

    Raises:
        RobotFileError: the file cannot be read, is not YAML, or is not a mapping with distinct keys.
    """
    import yaml

    name = os.fsdecode(path)
    text = _text(path, name)
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        reason = " ".join(filter(None, (error.context, error.problem)))
        raise RobotFileError(f"this is not YAML: {shortened(reason)}", name, mark.line + 1 if mark else None) from None
    except (yaml.YAMLError, ValueError) as error:  # characters that YAML does not allow
        raise RobotFileError(f"this is not YAML: {shortened(' '.join(str(error).split()))}", name) from None
    except RecursionError:
        raise RobotFileError("this is nested too deep", name) from None
    if root is None:
        raise RobotFileError("the file is empty", name)
    if root.id != "mapping" or root.tag != _MAPPING:
        fail(root, name, f"the file is a {_kind(root)}; robot.yaml is a mapping, which begins with a key such as closed_loop:")
    found: dict[str, object] = {}
    for key_node, node in root.value:
        key = scalar(key_node, name, "a key")
        if key in found:
            fail(key_node, name, f"the key {key!r} comes twice")
        found[key] = node
    return found


def sequence(node: yaml.Node, file: str, what: str) -> list[yaml.Node]:
    """Return the nodes of a sequence."""
    if node.id != "sequence" or node.tag != _LIST:
        fail(node, file, f"{what} must be a list, not a {_kind(node)}")
    return list(node.value)


def scalar(node: yaml.Node, file: str, what: str) -> str:
    """Return a text that is not empty and is in one line."""
    if node.id != "scalar" or node.tag not in (_TEXT, *_PLAIN):
        fail(node, file, f"{what} must be text, not a {_kind(node)}")
    value = str(node.value)
    if node.tag in _PLAIN and value.strip():
        fail(node, file, f"{what} must be text, and YAML takes {shortened(repr(value))} for {_PLAIN[node.tag]}; put it in quotes")
    if not value.strip() or not value.isprintable():
        fail(node, file, f"{what} must be text in one line, not {shortened(repr(value))}")
    return value


def place(node: yaml.Node, file: str) -> Place:
    """Return where a node is written."""
    return Place(file, node.start_mark.line + 1)


def fail(node: yaml.Node, file: str, reason: str) -> NoReturn:
    """Raise the error that says ``reason`` at a node's place."""
    raise place(node, file).error(shortened(reason))


def _text(path: str | os.PathLike[str], name: str) -> str:
    try:
        data = read_file(path)
    except OSError as error:
        raise RobotFileError(f"the file cannot be read: {error.strerror or error}", name) from None
    except ValueError as error:  # a path with a null character
        raise RobotFileError(f"the file cannot be read: {error}", name) from None
    if len(data) > MAX_YAML:
        raise RobotFileError(f"the file is larger than {MAX_YAML // 1000} kB, and robot.yaml is a few lines", name)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RobotFileError(f"the text cannot be decoded: {error}", name) from None


def _kind(node: yaml.Node) -> str:
    if node.tag not in (_TEXT, _LIST, _MAPPING, *_PLAIN):
        return f"{shortened(node.tag.removeprefix(_TAG))} object, which is not read"
    return {"mapping": "mapping", "sequence": "list"}.get(node.id, "single value")
