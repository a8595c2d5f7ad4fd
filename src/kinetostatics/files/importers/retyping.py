"""Joints of a URDF that another file declares to be of another type, written as runs of revolutes with massless links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from kinetostatics.files.importers.gepetto import Retyped
from kinetostatics.files.importers.loop_record import SourceRobot
from kinetostatics.files.xml import Element

_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def retype(source: SourceRobot, retyped: Sequence[Retyped]) -> Element:
    """Return the source's ``<robot>`` with these joints replaced; each is named as before, with ``_X``, ``_Y`` and ``_Z`` added.

    Raises:
        RobotFileError: a name that a new joint or link needs is taken.
    """
    changes = {item.joint: item for item in retyped}
    content: list[Element | str] = []
    for item in source.root.content:
        name = item.attributes.get("name") if isinstance(item, Element) and item.tag == "joint" else None
        if isinstance(item, Element) and name in changes:
            content.extend(_run(source, item, changes[name]))
        else:
            content.append(item)
    return replace(source.root, content=tuple(content))


def driven_after(driven: Sequence[str], retyped: Sequence[Retyped]) -> tuple[str, ...]:
    """Return the driven joints by their names after retyping; a joint that is fixed now is driven no more.

    Raises:
        RobotFileError: a spherical joint is driven.
    """
    changes = {item.joint: item for item in retyped}
    names: list[str] = []
    for name in driven:
        item = changes.get(name)
        if item is None:
            names.append(name)
        elif len(item.axes) == 3:
            reason = f"the joint {name!r} is spherical, and name_mot drives it; only joints with one freedom can be driven"
            raise item.place.error(reason)
        else:
            names.extend(_names(item))
    return tuple(names)


def _names(item: Retyped) -> list[str]:
    return [f"{item.joint}_{axis.upper()}" for axis in item.axes]


def _run(source: SourceRobot, joint: Element, item: Retyped) -> list[Element | str]:
    """Return the elements that stand for one joint."""
    place = joint.place
    parts = [part for part in joint.children if part.tag in ("origin", "parent", "child")]
    if not item.axes:
        return [Element("joint", {"name": item.joint, "type": "fixed"}, tuple(parts), place)]
    names = _names(item)
    result: list[Element | str] = []
    for index, (name, axis) in enumerate(zip(names, item.axes, strict=True)):
        link = f"{name}_link"
        for taken, what, where in ((name, "joint", source.joints), (link, "link", source.links)):
            if taken in where:
                made = ", ".join(names)
                raise item.place.error(
                    f"the joint {item.joint!r} becomes {made}, but there is a {what} {taken!r} already; rename it"
                )
        content: list[Element | str] = [part for part in parts if part.tag != "child"]
        if index:
            content = [Element("parent", {"link": f"{names[index - 1]}_link"}, (), place)]
        if index < len(names) - 1:
            content.append(Element("child", {"link": link}, (), place))
            result += [Element("link", {"name": link}, (), place), "\n  "]
        else:
            content += [part for part in parts if part.tag == "child"]
        content.append(Element("axis", {"xyz": _AXES[axis]}, (), place))
        result += [Element("joint", {"name": name, "type": "continuous"}, tuple(content), place), "\n  "]
    return result[:-1]
