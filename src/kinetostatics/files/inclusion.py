"""Text of a xacro that includes another file unchanged and adds elements."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import escape

from kinetostatics.arguments import check
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.bundled import INDEX, PackageNotFound, package_folder, read_robot
from kinetostatics.files.xacro import expand
from kinetostatics.files.xml import XmlElement, parse, to_elements, to_text

XACRO = "http://www.ros.org/wiki/xacro"


def read_root(path: str | os.PathLike[str], parameters: Mapping[str, object]) -> tuple[XmlElement, str, bool]:
    """Return the ``<robot>`` of a file, xacro expanded, the file's path, and whether it uses xacro.

    Raises:
        RobotFileError: the file cannot be read, or has another outermost element.
        ArgumentError: parameters are given for a file without xacro.
    """
    data, name = read_robot(path)
    check("parameters", parameters)
    document, uses_xacro = parse(data, name)
    if uses_xacro:
        expand(document, name, parameters)
    elif parameters:
        raise ArgumentError(f"{name} does not use xacro and has no parameters, but was given {', '.join(map(repr, parameters))}")
    root = to_elements(document)
    if root.tag != "robot":
        raise root.error(f"the outermost element is <{root.tag}>; in a URDF it is <robot>")
    return root, name, uses_xacro


def include_path(source: str, root: XmlElement, uses_xacro: bool, additions: str, out: str) -> str | None:
    """Return the path for the inclusion of a source, or None if xacro would change its content.

    Args:
        source: path of the source.
        root: its expanded content.
        uses_xacro: whether the source uses xacro.
        additions: text of the additional elements.
        out: the including file; the path is relative to its folder, unless the source is in an installed package.
    """
    try:
        path = os.path.relpath(source, os.path.dirname(out) or ".")
    except ValueError:  # on another drive
        path = os.path.abspath(source)
    path = path.replace(os.sep, "/")
    if "$" in path or not path.isprintable() or "$" in additions:
        return None
    if not uses_xacro and "$" in to_text(root):
        return None
    return _in_package(source) or path


def _in_package(source: str) -> str | None:
    """Return ``$(find NAME)/…`` for a file of an installed package."""
    path = Path(source).absolute()
    for folder in path.parents:
        if folder.parent.name == "share" and (folder.parents[1] / INDEX / folder.name).is_file():
            try:
                same = package_folder(folder.name).samefile(folder)
            except (PackageNotFound, OSError):
                same = False
            return f"$(find {folder.name})/{path.relative_to(folder).as_posix()}" if same else None
    return None


def including_text(name: str, include: str, comment: str, additions: str) -> str:
    """Return the text of a xacro that includes a file and has additional elements."""
    return (
        f'<?xml version="1.0"?>\n<robot name={quoted(name)} xmlns:xacro="{XACRO}">\n'
        f"  <!-- {comment} -->\n"
        f"  <xacro:include filename={quoted(include)}/>\n\n{additions}</robot>\n"
    )


def whole_text(root: XmlElement, additions: str) -> str:
    """Return the text of a plain URDF: a source with additional elements."""
    attributes = {name: value for name, value in root.attributes.items() if name != "xmlns:xacro"}
    head, closing, tail = to_text(replace(root, attributes=attributes), indented=True).rpartition("</robot>")
    return f"{head.rstrip()}\n\n{additions}{closing}{tail}"


def quoted(value: str) -> str:
    """Return a value as a quoted attribute value."""
    return '"' + escape(value, {'"': "&quot;"}) + '"'
