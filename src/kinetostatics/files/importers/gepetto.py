"""``robot.yaml`` beside a URDF, of Gepetto's example-parallel-robots and toolbox-parallel-robots.

.. code-block:: yaml

    closed_loop: [['closedloop1_A', 'closedloop1_B']]
    type: ['3d']
    name_mot: ['mot1', 'mot2']
    joint_name: ['to_rotule_1']
    joint_type: ['SPHERICAL']

What the keys mean is what ``loader_tools.py`` (``completeRobotLoader``) of
https://github.com/Gepetto/example-parallel-robots and ``ActuationModel`` of
https://github.com/Gepetto/toolbox-parallel-robots do with them:

- ``closed_loop``: pairs of Pinocchio's frames, which are links or joints, that coincide when the loops are closed.
- ``type``, one for each pair: ``3d`` holds the frames' origins together (``CONTACT_3D``: a spherical joint), ``6d`` the whole
  frames (``CONTACT_6D``: a fixed joint).
- ``name_mot``: every joint is driven whose name contains one of these texts.
- ``joint_name``, ``joint_type``: joints of the URDF that are other joints in truth: ``SPHERICAL``; ``UJOINT_XY``, ``UJOINT_YZ``
  and ``UJOINT_ZX``, two turns about these axes of the joint's frame, the first named first; ``FIXED``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

from kinetostatics.description.elements import Place
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import near_names
from kinetostatics.files.importers.loop_record import ForeignLoop, SourceRobot
from kinetostatics.files.importers.yaml_source import fail, place, read_mapping, scalar, sequence
from kinetostatics.files.xml import Element

KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
#: What ``type`` says of a loop.
TYPES = {"3d": "spherical", "6d": "fixed"}
#: The axes of the joint's frame about which a joint of ``joint_type`` turns, one after the other.
RETYPED = {"SPHERICAL": "xyz", "UJOINT_XY": "xy", "UJOINT_YZ": "yz", "UJOINT_ZX": "zx", "FIXED": ""}


@dataclass(frozen=True)
class Retyped:
    """A joint of the URDF that turns about ``axes`` (of ``xyz``, in this order) of its frame; about none: it is fixed."""

    joint: str
    axes: str
    place: Place


@dataclass(frozen=True)
class GepettoFile:
    """What a ``robot.yaml`` says.

    Attributes:
        loops: its loops.
        frames: names of the frames that it pairs.
        driven: names of the driven joints of the URDF, or None if it does not say.
        driven_note: why it is not certain which joints are driven.
        retyped: joints that are of another type than in the URDF.
        warnings: what is suspicious, in full sentences.
    """

    loops: tuple[ForeignLoop, ...]
    frames: frozenset[str]
    driven: tuple[str, ...] | None
    driven_note: str
    retyped: tuple[Retyped, ...]
    warnings: tuple[str, ...]


def read(source: SourceRobot, path: str | os.PathLike[str]) -> GepettoFile:
    """Read a ``robot.yaml``.

    Raises:
        RobotFileError: the file is malformed, or names what the URDF does not have; with the file and the line.
    """
    keys, file = read_mapping(path), os.fsdecode(path)
    warnings = [_unknown(key, node, file) for key, node in keys.items() if key not in KEYS]
    frames, loops = _loops(source, keys, file)
    driven, note = _driven(source, keys, file)
    return GepettoFile(tuple(loops), frames, driven, note, _retyped(source, keys, file), tuple(warnings))


def _unknown(key: str, node: object, file: str) -> str:
    near = near_names(key, KEYS)
    if near.startswith("did"):
        fail(node, file, f"the key {key!r} is unknown; {near}")
    return f"{file}:{place(node, file).line}: the key {key!r} is ignored; known: {', '.join(KEYS)}."


def _loops(source: SourceRobot, keys: Mapping[str, object], file: str) -> tuple[frozenset[str], list[ForeignLoop]]:
    if "closed_loop" not in keys:
        return frozenset(), []
    pairs = [_pair(node, file) for node in sequence(keys["closed_loop"], file, "closed_loop")]
    types = _types(keys, len(pairs), file)
    loops: list[ForeignLoop] = []
    names: set[str] = {*source.joints}
    for (first, second, at), kind in zip(pairs, types, strict=True):
        (link1, origin1), (link2, origin2) = source.frame(first, at), source.frame(second, at)
        name = _name(first, second, names)
        names.add(name)
        loops.append(ForeignLoop(name, kind, link1, origin1, link2, origin2, None, at))
    return frozenset(name for pair in pairs for name in pair[:2]), loops


def _pair(node: object, file: str) -> tuple[str, str, Place]:
    items = sequence(node, file, "an entry of closed_loop")
    if len(items) != 2:
        fail(node, file, f"an entry of closed_loop must be a pair of frames, not {len(items)} of them")
    first, second = (scalar(item, file, "a frame of closed_loop") for item in items)
    if first == second:
        fail(node, file, f"closed_loop pairs {first!r} with itself")
    return first, second, place(node, file)


def _types(keys: Mapping[str, object], count: int, file: str) -> list[str | None]:
    if "type" not in keys:
        return [None] * count  # different versions of the loader make different things of this
    nodes = sequence(keys["type"], file, "type")
    if len(nodes) != count:
        fail(keys["type"], file, f"type has {len(nodes)} entries, and closed_loop has {count}; each loop needs one")
    found: list[str | None] = []
    for node in nodes:
        kind = scalar(node, file, "an entry of type")
        if kind.lower() not in TYPES:
            fail(node, file, f"type says {kind!r}; known: 3d (the frames' origins coincide), 6d (the whole frames do)")
        found.append(TYPES[kind.lower()])
    return found


def _name(first: str, second: str, taken: set[str]) -> str:
    """Return the beginning that both frames' names share, or both names if that is nothing or taken."""
    same = takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    shared = "".join(letter for letter, _ in same).rstrip("_-. ")
    return shared if shared and shared not in taken else f"{first}_{second}"


def _driven(source: SourceRobot, keys: Mapping[str, object], file: str) -> tuple[tuple[str, ...] | None, str]:
    """Return the driven joints, and a remark if exact names and parts of names do not give the same."""
    if "name_mot" not in keys:
        return None, ""
    movable = [joint.name for joint in source.joints.values() if not JOINT_TYPES[joint.type].is_fixed]
    nodes = sequence(keys["name_mot"], file, "name_mot")
    texts = [scalar(node, file, "an entry of name_mot") for node in nodes]
    for node, text in zip(nodes, texts, strict=True):
        if not any(text in name for name in movable):
            fail(node, file, f"name_mot says {text!r}, which is in no movable joint's name; {near_names(text, movable)}")
    driven = tuple(name for name in movable if any(text in name for text in texts))
    more = [name for name in driven if name not in texts and any(text in name for text in texts if text in movable)]
    if not more:
        return driven, ""
    parts = ", ".join(more)
    return (
        None,
        f"name_mot ({file}:{place(keys['name_mot'], file).line}) names joints whose names are also part of those of {parts}",
    )


def _retyped(source: SourceRobot, keys: Mapping[str, object], file: str) -> tuple[Retyped, ...]:
    if "joint_name" not in keys and "joint_type" not in keys:
        return ()
    for key, other in (("joint_name", "joint_type"), ("joint_type", "joint_name")):
        if key not in keys:
            fail(keys[other], file, f"there is {other} but no {key}; they are lists of the same length")
    names, types = (sequence(keys[key], file, key) for key in ("joint_name", "joint_type"))
    if len(names) != len(types):
        fail(keys["joint_type"], file, f"joint_type has {len(types)} entries, and joint_name has {len(names)}")
    found: dict[str, Retyped] = {}
    for name_node, type_node in zip(names, types, strict=True):
        name, kind = scalar(name_node, file, "an entry of joint_name"), scalar(type_node, file, "an entry of joint_type")
        movable = [joint.name for joint in source.joints.values() if not JOINT_TYPES[joint.type].is_fixed]
        if name not in movable:
            what = "is fixed in the URDF" if name in source.joints else "does not exist"
            fail(name_node, file, f"joint_name says {name!r}, which {what}; {near_names(name, movable)}")
        if name in found:
            fail(name_node, file, f"joint_name has {name!r} twice")
        if kind not in RETYPED:
            reason = f"joint_type of {name!r} is {kind!r}, whose axes are not known here; known: {', '.join(RETYPED)}"
            fail(type_node, file, f"{reason}. Write its revolutes into the URDF, and take it out of joint_name")
        found[name] = Retyped(name, RETYPED[kind], place(name_node, file))
    return tuple(found.values())


# ---- joints of another type, written as runs of revolutes with massless links ----------------------------------------------


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
            content.extend(_run_of(source, item, changes[name]))
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
            names.extend(_new_names(item))
    return tuple(names)


def _new_names(item: Retyped) -> list[str]:
    return [f"{item.joint}_{axis.upper()}" for axis in item.axes]


def _run_of(source: SourceRobot, joint: Element, item: Retyped) -> list[Element | str]:
    """Return the elements that stand for one joint."""
    place = joint.place
    parts = [part for part in joint.children if part.tag in ("origin", "parent", "child")]
    if not item.axes:
        return [Element("joint", {"name": item.joint, "type": "fixed"}, tuple(parts), place)]
    names = _new_names(item)
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
        content.append(Element("axis", {"xyz": {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axis]}, (), place))
        result += [Element("joint", {"name": name, "type": "continuous"}, tuple(content), place), "\n  "]
    return result[:-1]
