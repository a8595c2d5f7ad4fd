"""Readers of YAML files that other tools write beside a URDF, with the joints that close its loops.

``ROBOT.yaml`` with ``closed_loop``: loader_tools.py (completeRobotLoader) of https://github.com/Gepetto/example-parallel-robots,
and ActuationModel of Gepetto/toolbox-parallel-robots. ``closed_loop`` has pairs of Pinocchio's frames (links or joints), ``type``
a type of each: ``3d``, if the origins coincide, or ``6d``, if the frames do. Joints whose names contain a text of ``name_mot``
are actuated. ``joint_name`` and ``joint_type`` replace joints by turns about axes of their frame, in the order of the letters.

``loop_closures.yaml`` with ``closures``: loop_closure.py of https://github.com/iory/scikit-robot, and model.py of
https://github.com/jsk-ros-pkg/solidworks_urdf_exporter2. Hinges, by point and axis in the root frame at the zero pose;
``independent`` joints are actuated. A ``<mimic>`` of ``dependent`` ones, which only approximates the loop, is dropped.

``robot_data.yaml`` with ``closing_joints``: supplementary_export.py of https://github.com/Adriaeik/fusion2URDF. Joints as in
URDF, closed with all joints at zero; those of ``joints`` that are not ``passive`` are actuated.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.elements import AT_LINK, Origin
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, names_of
from kinetostatics.description.joints import X, Y
from kinetostatics.exceptions import RobotFileError, near_names
from kinetostatics.files.foreign_loops import ForeignJoint, SourceRobot, Z, between, tree_elements, unit
from kinetostatics.files.xml import read_file
from kinetostatics.math.arrays import Array

#: Types of Gepetto's loops by ``type``; joint types by ``joint_type``, with the axes of their turns.
TYPES = {"3d": "spherical", "3D": "spherical", "6d": "fixed", "6D": "fixed"}
RETYPED: dict[str, tuple[str, Vector | None, Vector]] = {
    "SPHERICAL": ("spherical", None, Y),
    **{f"UJOINT_{name}": ("universal", *axes) for name, axes in (("XY", (X, Y)), ("YZ", (Y, Z)), ("ZX", (Z, X)), ("ZY", (Z, Y)))},
    "FIXED": ("fixed", None, Y),
}
#: Where files with fixed names may be, relative to the folder of the URDF.
FOLDERS = ("", os.pardir, os.path.join(os.pardir, "config"))


@dataclass(frozen=True)
class YamlFile:
    """A YAML file with loops.

    Attributes:
        frames: names of the frames that the loops join.
        actuated: names of the actuated joints, or None if unknown.
        retyped: joints with another type than in the URDF; ``free``: joints whose ``<mimic>`` is dropped.
    """

    loops: tuple[ForeignJoint, ...]
    frames: frozenset[str] = frozenset()
    actuated: tuple[str, ...] | None = None
    retyped: tuple[ForeignJoint, ...] = ()
    free: frozenset[str] = frozenset()


# ---- YAML with lines -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Node:
    """A value of a YAML file, a text, a list or a mapping, with file and line; tags are ignored."""

    value: str | list[Node] | dict[str, Node]
    place: Place

    def items(self, what: str) -> list[Node]:
        if not isinstance(self.value, list):
            raise self.place.error(f"{what} must be a list")
        return self.value

    def text(self, what: str) -> str:
        """Return the text of this node, which must be one line and not blank; ``what`` names the node in errors."""
        if not isinstance(self.value, str) or not self.value.strip() or not self.value.isprintable():
            raise self.place.error(f"{what} must be text in one line")
        return self.value

    def part(self, key: str) -> Node:
        if not isinstance(self.value, dict) or key not in self.value:
            raise self.place.error(f"an entry here must be a mapping with {key!r}")
        return self.value[key]

    def number(self, what: str) -> float:
        try:
            return float(self.text(what))
        except ValueError:
            raise self.place.error(f"{what} is {self.value!r}, which is not a number") from None

    def vector(self, key: str) -> Vector:
        numbers = [node.number(key) for node in self.part(key).items(key)]
        if len(numbers) != 3:
            raise self.part(key).place.error(f"{key} must be three numbers")
        x, y, z = numbers
        return x, y, z


def _read_yaml(path: str | os.PathLike[str]) -> dict[str, Node]:
    import yaml

    file = os.fsdecode(path)

    def nodes(node: yaml.Node) -> Node:
        place, keys = Place(file, node.start_mark.line + 1), dict[str, Node]()
        if isinstance(node, yaml.SequenceNode):
            return Node([nodes(child) for child in node.value], place)
        if not isinstance(node, yaml.MappingNode):
            return Node(str(node.value), place)
        for key, child in ((nodes(key), child) for key, child in node.value):
            if (name := key.text("a key")) in keys:
                raise key.place.error(f"the key {name!r} comes twice")
            keys[name] = nodes(child)
        return Node(keys, place)

    try:
        root = yaml.compose(read_file(path).decode("utf-8-sig"), Loader=yaml.SafeLoader)
        if not isinstance(root, yaml.MappingNode):
            raise RobotFileError("the file must be a mapping, which begins with a key such as closed_loop:", file)
        return nodes(root).value  # type: ignore[return-value]
    except OSError as error:
        raise RobotFileError(f"the file cannot be read: {error.strerror or error}", file) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # characters that YAML does not allow; lists in themselves
        mark = getattr(error, "problem_mark", None)
        raise RobotFileError(f"this is not YAML: {' '.join(str(error).split())}", file, mark and mark.line + 1) from None


def yaml_beside(path: str) -> str | None:
    """Return the path of a YAML file with loops for a URDF; None if there is none."""
    folder = os.path.dirname(path)
    files = [(f"{os.path.splitext(path)[0]}.yaml", "closed_loop")]
    for name, key in (("loop_closures.yaml", "closures"), ("robot_data.yaml", "closing_joints")):
        files += [(os.path.join(folder, up, name), key) for up in FOLDERS]
    for file, key in files:
        try:
            if re.search(rf"^{key}\s*:(?!\s*\[\])".encode(), read_file(file), re.MULTILINE):
                return os.path.normpath(file)
        except (OSError, RobotFileError):
            continue
    return None


def read(source: SourceRobot, path: str | os.PathLike[str]) -> YamlFile:
    keys = _read_yaml(path)
    reader = next((reader for key, reader in READERS.items() if key in keys), _gepetto)
    return reader(source, keys)


# ---- loop_closures.yaml and robot_data.yaml ---------------------------------------------------------------------------------


def _known(node: Node, what: str, names: Collection[str]) -> str:
    if (name := node.text(what)) not in names:
        raise node.place.error(f"{what} is {name!r}, which is unknown; {near_names(name, names)}")
    return name


def _closed_at_zero(source: SourceRobot, node: Node, ends: tuple[str, str], frame: Array) -> ForeignJoint:
    """Return a hinge from its frame (4, 4) relative to the root link, with all joints at zero, and its axis in this frame."""
    links = [_known(node.part(key), key, source.links) for key in ends]
    axis = np.array(node.vector("axis"))
    if not axis.any():
        raise node.place.error("axis is zero; it must have a direction")
    return between("", "revolute", [(link, source.zero_frames[link], frame) for link in links], unit(axis), node.place)


def _closures(source: SourceRobot, keys: Mapping[str, Node]) -> YamlFile:
    points = [(node, Origin(node.vector("point")).matrix) for node in _list(keys, "closures")]
    actuated, dependent = (
        tuple(_known(node, f"an entry of {key}", source.joints) for node in _list(keys, key))
        for key in ("independent", "dependent")
    )
    loops = tuple(_closed_at_zero(source, node, ("link_a", "link_b"), at) for node, at in points)
    return YamlFile(loops, actuated=actuated or None, free=frozenset(dependent))


def _closing_joints(source: SourceRobot, keys: Mapping[str, Node]) -> YamlFile:
    loops: list[ForeignJoint] = []
    for node in _list(keys, "closing_joints"):
        name, kind = node.part("name").text("name"), _known(node.part("type"), "type", names_of("in_loop"))
        parent = source.zero_frames[_known(node.part("parent"), "parent", source.links)]
        frame = parent @ Origin(node.vector("origin_xyz_m"), node.vector("origin_rpy_rad")).matrix
        joint = _closed_at_zero(source, node, ("parent", "child"), frame)
        limited = JOINT_TYPES[kind].has_limits and "limits" in node.value
        limits = {end: node.part("limits").part(end).number(end) for end in ("lower", "upper")} if limited else {}
        loops.append(replace(joint, name=name, type=kind, limits=limits))
    joints = keys["joints"].value if "joints" in keys else {}
    driven = {name for name, node in joints.items() if node.part("passive").value == "false"} if isinstance(joints, dict) else ()
    single = (name for name, joint in source.joints.items() if JOINT_TYPES[joint.type].is_single)
    return YamlFile(tuple(loops), actuated=tuple(name for name in single if name in driven))


# ---- Gepetto's robot.yaml -----------------------------------------------------------------------------------------------------


def _gepetto(source: SourceRobot, keys: Mapping[str, Node]) -> YamlFile:
    movable = [joint.name for joint in source.joints.values() if not JOINT_TYPES[joint.type].is_fixed]
    (loops, frames), retyped = _loops(source, keys), _retyped(source, keys, movable)
    return YamlFile(tuple(loops), frozenset(frames), _actuated(keys, movable, retyped), tuple(retyped.values()))


def _list(keys: Mapping[str, Node], key: str) -> list[Node]:
    return keys[key].items(key) if key in keys else []


def _loops(source: SourceRobot, keys: Mapping[str, Node]) -> tuple[list[ForeignJoint], set[str]]:
    """Return the loops, and the names of the frames that they join."""
    loops, names, joined = list[ForeignJoint](), {*source.joints}, set[str]()
    pairs, types = _list(keys, "closed_loop"), _list(keys, "type")
    if types and len(types) != len(pairs):
        raise keys["type"].place.error(f"type has {len(types)} entries, and closed_loop has {len(pairs)}; each loop needs one")
    for number, node in enumerate(pairs):  # without types, because versions of the loader differ in their default
        kind = TYPES[_known(types[number], "an entry of type", TYPES)] if types else None
        frames = [frame.text("a frame of closed_loop") for frame in node.items("an entry of closed_loop")]
        if len(frames) != 2:
            raise node.place.error(f"an entry of closed_loop must be a pair of frames, not {len(frames)} of them")
        shared = os.path.commonprefix(frames).rstrip("_-. ")  # noqa: RUF071 names are no paths
        name = shared if shared and shared not in names else "_".join(frames)
        names.add(name)
        joined.update(frames)
        (first, first_end), (second, second_end) = (source.frame(frame, node.place) for frame in frames)
        loops.append(ForeignJoint(name, kind, first, first_end, second, second_end, None, node.place))
    return loops, joined


def _actuated(keys: Mapping[str, Node], movable: Sequence[str], retyped: Mapping[str, ForeignJoint]) -> tuple[str, ...] | None:
    chosen: set[str] = set()
    for node in _list(keys, "name_mot"):
        text = node.text("an entry of name_mot")
        named = [name for name in movable if text in name]
        if not named:
            raise node.place.error(f"name_mot has {text!r}, which is in no movable joint's name; {near_names(text, movable)}")
        chosen.update(named)
    names: list[str] = []
    for name in (name for name in movable if name in chosen):
        parts = [part.attributes for part in tree_elements(retyped[name]) if part.tag == "joint"] if name in retyped else []
        names += [part["name"] for part in parts if not JOINT_TYPES[part["type"]].is_fixed] or [name]
    return tuple(names) if "name_mot" in keys else None


def _retyped(source: SourceRobot, keys: Mapping[str, Node], movable: Sequence[str]) -> dict[str, ForeignJoint]:
    names, types = _list(keys, "joint_name"), _list(keys, "joint_type")
    if len(names) != len(types):
        given = keys.get("joint_type") or keys["joint_name"]
        raise given.place.error(f"joint_type has {len(types)} entries, and joint_name has {len(names)}; each joint needs one")
    retyped: dict[str, ForeignJoint] = {}
    for name_node, type_node in zip(names, types, strict=True):
        name = _known(name_node, "an entry of joint_name", movable)
        kind = _known(type_node, "an entry of joint_type", RETYPED)
        joint, (type_name, axis, axis2) = source.joints[name], RETYPED[kind]
        ends = (joint.parent, joint.origin, joint.child, AT_LINK)
        retyped[name] = ForeignJoint(name, type_name, *ends, axis, name_node.place, axis2=axis2)
    return retyped


#: Readers by a key of their files.
READERS = {"closures": _closures, "closing_joints": _closing_joints}
