"""``robot.yaml`` beside a URDF, of Gepetto's example-parallel-robots and toolbox-parallel-robots.

.. code-block:: yaml

    closed_loop: [['closedloop1_A', 'closedloop1_B']]
    type: ['3d']
    name_mot: ['mot1', 'mot2']
    joint_name: ['to_rotule_1']
    joint_type: ['SPHERICAL']

The keys are interpreted as by ``loader_tools.py`` (``completeRobotLoader``) of
https://github.com/Gepetto/example-parallel-robots and ``ActuationModel`` of
https://github.com/Gepetto/toolbox-parallel-robots:

- ``closed_loop``: pairs of Pinocchio's frames (links or joints) that coincide when the loops are closed.
- ``type``, one for each pair: ``3d`` constrains the origins of the frames (``CONTACT_3D``: a spherical joint), ``6d`` the whole
  frames (``CONTACT_6D``: a fixed joint).
- ``name_mot``: joints whose names contain one of these texts are actuated.
- ``joint_name``, ``joint_type``: joints of the URDF that are replaced by other types: ``SPHERICAL``; ``UJOINT_XY``, ``UJOINT_YZ``
  and ``UJOINT_ZX``, two turns about these axes of the joint's frame, the first named first; ``FIXED``.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinetostatics.description.fields import Place
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import RobotFileError, near_names
from kinetostatics.files.foreign_loops import ForeignLoop, SourceRobot
from kinetostatics.files.xml import XmlElement, read_file

KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
#: Types of loops by ``type``.
TYPES = {"3d": "spherical", "6d": "fixed"}
#: Axes of rotation of the joint types of ``joint_type``: axes of the joint's frame, in the order of the rotations.
RETYPED = {"SPHERICAL": "xyz", "UJOINT_XY": "xy", "UJOINT_YZ": "yz", "UJOINT_ZX": "zx", "FIXED": ""}


@dataclass(frozen=True)
class Retyped:
    """A joint of the URDF that is replaced by rotations about ``axes`` of its frame, in this order; "" for a fixed joint."""

    joint: str
    axes: str
    place: Place


@dataclass(frozen=True)
class GepettoFile:
    """The content of a ``robot.yaml``.

    Attributes:
        frames: names of the frames that the loops join.
        actuated: names of the actuated joints of the URDF, or None if unknown.
        actuated_note: why the actuated joints are unknown, if ``name_mot`` is ambiguous.
        retyped: joints with another type than in the URDF.
        warnings: warnings, in full sentences.
    """

    loops: tuple[ForeignLoop, ...]
    frames: frozenset[str]
    actuated: tuple[str, ...] | None
    actuated_note: str
    retyped: tuple[Retyped, ...]
    warnings: tuple[str, ...]


# ---- YAML with lines -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Node:
    """A value of a YAML file, a text or a list (None: a mapping), with file and line."""

    value: str | list[Node] | None
    place: Place

    def error(self, reason: str) -> RobotFileError:
        return self.place.error(reason)

    def items(self, what: str) -> list[Node]:
        if not isinstance(self.value, list):
            raise self.error(f"{what} must be a list, not {repr(self.value) if self.value is not None else 'a mapping'}")
        return self.value

    def text(self, what: str) -> str:
        """Return the text of this node, which must be one line and not blank; ``what`` names the node in errors."""
        if not isinstance(self.value, str) or not self.value.strip() or not self.value.isprintable():
            actual = repr(self.value) if isinstance(self.value, str) else "a mapping" if self.value is None else "a list"
            raise self.error(f"{what} must be text in one line, not {actual}")
        return self.value


def _read_yaml(path: str | os.PathLike[str]) -> dict[str, Node]:
    """Return the entries of a YAML mapping; tags are ignored."""
    import yaml

    file = os.fsdecode(path)

    def nodes(node: yaml.Node) -> Node:
        place = Place(file, node.start_mark.line + 1)
        if isinstance(node, yaml.MappingNode):
            return Node(None, place)
        return Node([nodes(child) for child in node.value] if isinstance(node, yaml.SequenceNode) else str(node.value), place)

    try:
        root = yaml.compose(read_file(path).decode("utf-8-sig"), Loader=yaml.SafeLoader)
        if not isinstance(root, yaml.MappingNode):
            line = None if root is None else root.start_mark.line + 1
            raise RobotFileError("robot.yaml is a mapping, which begins with a key such as closed_loop:", file, line)
        keys: dict[str, Node] = {}
        for key_node, node in root.value:
            key = nodes(key_node)
            name = key.text("a key")
            if name in keys:
                raise key.error(f"the key {name!r} comes twice")
            keys[name] = nodes(node)
        return keys
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        reason = " ".join(filter(None, (error.context, error.problem)))
        raise RobotFileError(f"this is not YAML: {reason}", file, mark.line + 1 if mark else None) from None
    except OSError as error:
        raise RobotFileError(f"the file cannot be read: {error.strerror or error}", file) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # characters that YAML does not allow; lists in themselves
        raise RobotFileError(f"this is not YAML: {' '.join(str(error).split())}", file) from None


def yaml_beside(path: str) -> str | None:
    """Return the path of the YAML file with the name and folder of a URDF, if that file has ``closed_loop``; else None."""
    file = f"{os.path.splitext(path)[0]}.yaml"
    try:
        return file if re.search(rb"^closed_loop\s*:", read_file(file), re.MULTILINE) else None
    except (OSError, RobotFileError):
        return None


# ---- meaning of the keys ----------------------------------------------------------------------------------------------------


def read(source: SourceRobot, path: str | os.PathLike[str]) -> GepettoFile:
    keys = _read_yaml(path)
    warnings = [_unknown(key, node) for key, node in keys.items() if key not in KEYS]
    frames, loops = _loops(source, keys)
    actuated, note = _actuated(source, keys)
    return GepettoFile(tuple(loops), frames, actuated, note, _retyped(source, keys), tuple(warnings))


def _unknown(key: str, node: Node) -> str:
    near = near_names(key, KEYS)
    if near.startswith("did"):
        raise node.error(f"the key {key!r} is unknown; {near}")
    return f"{node.place}: the key {key!r} is ignored; known: {', '.join(KEYS)}."


def _loops(source: SourceRobot, keys: Mapping[str, Node]) -> tuple[frozenset[str], list[ForeignLoop]]:
    if "closed_loop" not in keys:
        return frozenset(), []
    pairs = [_pair(node) for node in keys["closed_loop"].items("closed_loop")]
    types = _types(keys, len(pairs))
    loops: list[ForeignLoop] = []
    names: set[str] = {*source.joints}
    for (first, second, at), kind in zip(pairs, types, strict=True):
        (link1, origin1), (link2, origin2) = source.frame(first, at), source.frame(second, at)
        name = _name(first, second, names)
        names.add(name)
        loops.append(ForeignLoop(name, kind, link1, origin1, link2, origin2, None, at))
    return frozenset(name for pair in pairs for name in pair[:2]), loops


def _pair(node: Node) -> tuple[str, str, Place]:
    items = node.items("an entry of closed_loop")
    if len(items) != 2:
        raise node.error(f"an entry of closed_loop must be a pair of frames, not {len(items)} of them")
    first, second = (frame.text("a frame of closed_loop") for frame in items)
    if first == second:
        raise node.error(f"closed_loop pairs {first!r} with itself")
    return first, second, node.place


def _types(keys: Mapping[str, Node], count: int) -> list[str | None]:
    if "type" not in keys:
        return [None] * count  # versions of the loader differ in their default
    nodes = keys["type"].items("type")
    if len(nodes) != count:
        raise keys["type"].error(f"type has {len(nodes)} entries, and closed_loop has {count}; each loop needs one")
    types: list[str | None] = []
    for node in nodes:
        kind = node.text("an entry of type")
        if kind.lower() not in TYPES:
            raise node.error(f"type is {kind!r}; known: 3d (the frames' origins coincide), 6d (the whole frames do)")
        types.append(TYPES[kind.lower()])
    return types


def _name(first: str, second: str, taken: set[str]) -> str:
    """Return a loop's name: the common prefix of the frames' names, or both names if the prefix is empty or taken."""
    shared = os.path.commonprefix((first, second)).rstrip("_-. ")  # noqa: RUF071 names are no paths
    return shared if shared and shared not in taken else f"{first}_{second}"


def _actuated(source: SourceRobot, keys: Mapping[str, Node]) -> tuple[tuple[str, ...] | None, str]:
    """Return the names of the actuated joints and an empty text, or None and the reason if the names are ambiguous.

    They are ambiguous if a text of ``name_mot`` is the name of a joint, and also a part of the names of other joints.
    """
    if "name_mot" not in keys:
        return None, ""
    movable = [joint.name for joint in source.joints.values() if not JOINT_TYPES[joint.type].is_fixed]
    nodes = keys["name_mot"].items("name_mot")
    texts = [node.text("an entry of name_mot") for node in nodes]
    for node, text in zip(nodes, texts, strict=True):
        if not any(text in name for name in movable):
            raise node.error(f"name_mot has {text!r}, which is in no movable joint's name; {near_names(text, movable)}")
    actuated = tuple(name for name in movable if any(text in name for text in texts))
    more = [name for name in actuated if name not in texts and any(text in name for text in texts if text in movable)]
    if not more:
        return actuated, ""
    return None, f"name_mot ({keys['name_mot'].place}) has names of joints that are also parts of the names {', '.join(more)}"


def _retyped(source: SourceRobot, keys: Mapping[str, Node]) -> tuple[Retyped, ...]:
    if "joint_name" not in keys and "joint_type" not in keys:
        return ()
    for key, other in (("joint_name", "joint_type"), ("joint_type", "joint_name")):
        if key not in keys:
            raise keys[other].error(f"there is {other} but no {key}; they are lists of the same length")
    names, types = (keys[key].items(key) for key in ("joint_name", "joint_type"))
    if len(names) != len(types):
        raise keys["joint_type"].error(f"joint_type has {len(types)} entries, and joint_name has {len(names)}")
    retyped: dict[str, Retyped] = {}
    for name_node, type_node in zip(names, types, strict=True):
        name, kind = name_node.text("an entry of joint_name"), type_node.text("an entry of joint_type")
        movable = [joint.name for joint in source.joints.values() if not JOINT_TYPES[joint.type].is_fixed]
        if name not in movable:
            what = "is fixed in the URDF" if name in source.joints else "does not exist"
            raise name_node.error(f"joint_name has {name!r}, which {what}; {near_names(name, movable)}")
        if name in retyped:
            raise name_node.error(f"joint_name has {name!r} twice")
        if kind not in RETYPED:
            reason = f"joint_type of {name!r} is {kind!r}, whose axes are not known here; known: {', '.join(RETYPED)}"
            raise type_node.error(f"{reason}. Write its revolutes into the URDF, and take it out of joint_name")
        retyped[name] = Retyped(name, RETYPED[kind], name_node.place)
    return tuple(retyped.values())


# ---- joints of other types: runs of revolutes with massless links between them ---------------------------------------------


def retype(source: SourceRobot, retyped: Sequence[Retyped]) -> XmlElement:
    """Return the element ``<robot>`` of the source, with joints replaced by runs of revolutes.

    Each revolute has the name of the joint with ``_X``, ``_Y`` or ``_Z`` appended.
    """
    changes = {change.joint: change for change in retyped}
    content: list[XmlElement | str] = []
    for child in source.root.content:
        name = child.attributes.get("name") if isinstance(child, XmlElement) and child.tag == "joint" else None
        if isinstance(child, XmlElement) and name in changes:
            content.extend(_run_of(source, child, changes[name]))
        else:
            content.append(child)
    return replace(source.root, content=tuple(content))


def actuated_after(actuated: Sequence[str], retyped: Sequence[Retyped]) -> tuple[str, ...]:
    """Return the names of the actuated joints after :func:`retype`, which may have made some of them fixed."""
    changes = {change.joint: change for change in retyped}
    names: list[str] = []
    for name in actuated:
        change = changes.get(name)
        if change is None:
            names.append(name)
        elif len(change.axes) == 3:
            reason = f"the joint {name!r} is spherical, but is actuated by name_mot; only joints with one freedom can be actuated"
            raise change.place.error(reason)
        else:
            names.extend(_new_names(change))
    return tuple(names)


def _new_names(change: Retyped) -> list[str]:
    return [f"{change.joint}_{axis.upper()}" for axis in change.axes]


def _run_of(source: SourceRobot, joint: XmlElement, change: Retyped) -> list[XmlElement | str]:
    """Return the elements that replace a joint: revolute joints with massless links between them."""
    place = joint.place
    parts = [part for part in joint.children if part.tag in ("origin", "parent", "child")]
    if not change.axes:
        return [XmlElement("joint", {"name": change.joint, "type": "fixed"}, tuple(parts), place)]
    names = _new_names(change)
    result: list[XmlElement | str] = []
    for index, (name, axis) in enumerate(zip(names, change.axes, strict=True)):
        link = f"{name}_link"
        for taken, what, where in ((name, "joint", source.joints), (link, "link", source.links)):
            if taken in where:
                made = ", ".join(names)
                raise change.place.error(
                    f"the joint {change.joint!r} becomes {made}, but there is a {what} {taken!r} already; rename it"
                )
        content: list[XmlElement | str] = [part for part in parts if part.tag != "child"]
        if index:
            content = [XmlElement("parent", {"link": f"{names[index - 1]}_link"}, (), place)]
        if index < len(names) - 1:
            content.append(XmlElement("child", {"link": link}, (), place))
            result += [XmlElement("link", {"name": link}, (), place), "\n  "]
        else:
            content += [part for part in parts if part.tag == "child"]
        content.append(XmlElement("axis", {"xyz": {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axis]}, (), place))
        result += [XmlElement("joint", {"name": name, "type": "continuous"}, tuple(content), place), "\n  "]
    return result[:-1]
