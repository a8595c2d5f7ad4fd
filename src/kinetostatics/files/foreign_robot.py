"""A URDF with loops or actuators in formats of other tools as a robot of this package.

Information comes from the source's files and from arguments; what is missing is listed in one error, with a whole command.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinetostatics.arguments import finite_numbers
from kinetostatics.description.fields import Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.validation import tree_root
from kinetostatics.exceptions import ArgumentError, PlatformMissingError, RobotFileError, near_names
from kinetostatics.files import foreign_yaml
from kinetostatics.files.foreign_loops import ForeignJoint, SourceRobot, tree_elements, unit, with_names
from kinetostatics.files.foreign_xml import MARK, couplings, read_elements
from kinetostatics.files.rules import read_loops
from kinetostatics.files.urdf import OFFERED, connected_links, plain_transmission, read_joints, read_links
from kinetostatics.files.xml import XmlElement

#: Missing information: options of ``kinetostatics new``, examples of their values, and descriptions.
Missing = list[tuple[str, str, str]]


@dataclass(frozen=True)
class Completed:
    """A robot in the elements of this package.

    Attributes:
        source: the robot of the file, with the joint types of its YAML file.
        loops: elements of the loops of another tool.
        actuated: actuated joints without a ``<transmission>`` in the source.
        warnings: warnings, in full sentences.
    """

    source: SourceRobot
    loops: tuple[XmlElement, ...] = ()
    actuated: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def root(self) -> XmlElement:
        root = self.source.root
        drives = (plain_transmission(joint, root.place) for joint in self.actuated)
        return replace(root, content=(*root.content, *self.loops, *drives))


def completed(
    path: str,
    root: XmlElement,
    platform_link: str | None = None,
    yaml: str | os.PathLike[str] | None = None,
    types: Mapping[str, str] | str | None = None,
    axes: Mapping[str, object] | None = None,
    actuators: tuple[str, ...] | None = None,
) -> Completed:
    """Return a robot with its loops and actuators; loops with the name of a ``<loop>`` of the file are not read again.

    Raises:
        PlatformMissingError: only the platform is missing.
        ArgumentError: information is missing both in the source and in the arguments of :func:`kinetostatics.extend_robot`; or an
            argument does not fit the source.
        RobotFileError: two loops have the same name, or a loop and a joint; or a file is invalid.
    """
    source, warnings, record = _source(path, root), list[str](), foreign_yaml.YamlFile(())
    if yaml is None and not root.named("loop") and (yaml := foreign_yaml.yaml_beside(path)):
        warnings = [f"{yaml}: the loops are read from this file, which lies beside the URDF."]
    if yaml is not None:
        record = foreign_yaml.read(source, yaml)
    named = with_names([*record.loops, *read_elements(source, record.frames)], source.joints)
    written = [element.attributes.get("name") for element in root.named("loop")]
    joints = [joint for joint in named if joint.name not in written]
    if yaml is not None and not joints:
        raise RobotFileError("there is no closed_loop, and the URDF has no loops either", os.fsdecode(yaml))
    if (types or axes) and not joints:
        raise ArgumentError(f"types= and axes= are for loops of another tool, and {path} has none")
    mimics = {**{name: None for name in record.free if source.joints[name].mimic}, **couplings(source)}
    if record.retyped or mimics:
        source = _source(path, _with_changes(source, record.retyped, mimics))
    driven = root.named("transmission")
    declared = _declared(root) if written and not driven else ()
    if not joints and (not written or driven or declared or root.named("platform") or actuators is not None):
        return Completed(source, actuated=declared if actuators is None else ())
    loops, actuated = _complete(source, joints, record, platform_link, types, axes, actuators)
    elements = tuple(element for loop in loops for element in loop.elements())
    return Completed(source, elements, actuated, tuple(warnings))


def _source(path: str, root: XmlElement) -> SourceRobot:
    links, joints = read_links(root, [], []), read_joints(root, [])  # their warnings are repeated when the new file is read
    tree_root(links, joints)
    return SourceRobot(path, root, links, joints)


def _with_changes(source: SourceRobot, retyped: Sequence[ForeignJoint], mimics: Mapping[str, XmlElement | None]) -> XmlElement:
    """Return the element ``<robot>`` with the ``retyped`` joints, and with ``mimics`` (None: without) in the joints named."""
    changes = {joint.name: joint for joint in retyped}
    content: list[XmlElement | str] = []
    for child in source.root.content:
        name = child.attributes.get("name", "") if isinstance(child, XmlElement) and child.tag == "joint" else ""
        if name in changes:
            content += tree_elements(changes[name])
        elif isinstance(child, XmlElement) and name in mimics:
            kept = (part for part in child.content if getattr(part, "tag", "") != "mimic")
            content.append(replace(child, content=(*kept, *filter(None, [mimics[name]]))))
        elif getattr(child, "tag", "") != "coupling":
            content.append(child)
    return replace(source.root, content=tuple(content))


def _complete(
    source: SourceRobot,
    foreign_joints: Sequence[ForeignJoint],
    record: foreign_yaml.YamlFile,
    platform_link: str | None,
    types: Mapping[str, str] | str | None,
    axes: Mapping[str, object] | None,
    actuators: tuple[str, ...] | None,
) -> tuple[list[ForeignJoint], tuple[str, ...]]:
    """Return the loops with types and axes, and the actuated joints without a ``<transmission>``."""
    names = [joint.name for joint in foreign_joints]
    if clash := next((joint for joint in foreign_joints if joint.name in source.joints), None):
        raise clash.place.error(f"the loop's name {clash.name!r} is taken already by a joint; rename one of them")
    if isinstance(types, str):  # of all loops without a type in the source
        types = {joint.name: types for joint in foreign_joints if joint.type is None}
    for argument, given in (("types", types), ("axes", axes)):
        if not isinstance(given, Mapping | None):
            raise ArgumentError(f"{argument} must be a dict with the loops' names as keys, not {type(given).__name__}")
        if unknown := next((name for name in given or () if name not in names), None):
            raise ArgumentError(f"{argument}: there is no loop {unknown!r}; {near_names(str(unknown), names)}")
    missing: Missing = []
    written = read_loops(source.root, source.joints, [])
    platforms = [
        link for link in connected_links(source.joints, [*written.values(), *foreign_joints]) if not MARK.fullmatch(link)
    ]
    if platform_link is None and source.root.child("platform") is None:
        listed = ", ".join(link for link in source.links if link in source.parent_joints and not MARK.fullmatch(link))
        missing.append(("--platform-link", platforms[0], f"platform_link, one of {listed}"))
    given_types, given_axes = types or {}, axes or {}
    loops = [_loop(joint, given_types.get(joint.name), given_axes.get(joint.name), missing) for joint in foreign_joints]
    movable = [joint.name for joint in source.joints.values() if JOINT_TYPES[joint.type].is_single]
    movable += [loop.name for loop in loops if loop.type is None or JOINT_TYPES[loop.type].is_single]
    actuated = _actuated(source, movable, record.actuated, actuators, missing)
    if [option for option, _, _ in missing] == ["--platform-link"]:
        raise PlatformMissingError(source.path, source.root.place.line, platforms[:OFFERED])
    if missing:
        options = {option: [example for other, example, _ in missing if other == option] for option, _, _ in missing}
        words = [word for option, examples in options.items() for word in (option, *" ".join(examples).split())]
        out = f"{os.path.basename(source.path).partition('.')[0]}_robot.urdf.xacro"
        command = shlex.join(["kinetostatics", "new", "--from", source.path, *words, "--out", out])
        asked = "; ".join(text for _, _, text in missing)
        raise ArgumentError(f"{source.path} lacks information; give also {asked}. For example: {command}")
    return loops, actuated


def _loop(loop: ForeignJoint, given: str | None, axis: object, missing: Missing) -> ForeignJoint:
    """Return a loop with its type and axis; what is unknown is added to ``missing``."""
    name, allowed_types = loop.name, names_of("in_loop")
    where = f"{name} ({loop.place}), which joins {loop.predecessor} and {loop.successor}"
    if given is not None and given not in allowed_types:
        raise ArgumentError(f"types: {name!r} cannot be {given!r}; {near_names(str(given), allowed_types)}")
    kind = given or loop.type
    if kind is None:
        missing.append(("--types", f"{name}=revolute", f"types: of {where}, one of {', '.join(allowed_types)}"))
        return loop
    of_kind, axes = JOINT_TYPES[kind], [loop.axis, loop.axis2]
    count = 2 if of_kind.turns is Axes.BOTH else int(of_kind.has_axis)
    if axis is not None and not count:
        raise ArgumentError(f"axes: the loop {name!r} is {kind} and has no axis")
    if axis is not None:
        axes[:count] = _unit_vectors(name, axis, count, kind)
    elif count and (loop.axis is None or (count == 2 and loop.type != kind)):
        what = "both axes" if count == 2 else "the normal" if of_kind.slides is Axes.ACROSS else "the axis"
        second = f" and on {loop.successor}" if count == 2 else ""
        text = f"axes: {what} of the {kind} joint {where}, in its frame on {loop.predecessor}{second}"
        missing.append(("--axes", f"{name}={'0,0,1/1,0,0' if count == 2 else '0,0,1'}", text))
    return replace(loop, type=kind, axis=axes[0] if count else None, axis2=axes[1] or loop.axis2)


def _unit_vectors(name: str, value: object, count: int, kind: str) -> list[Vector]:
    array = finite_numbers(f"axes: {name!r}", value)
    if array.shape != ((3,) if count == 1 else (2, 3)):
        needed = "three numbers" if count == 1 else "two axes of three numbers each"
        raise ArgumentError(f"axes: {name!r} is {kind} and needs {needed}, not {value!r}")
    if not (rows := array.reshape(-1, 3)).any(axis=1).all():
        raise ArgumentError(f"axes: an axis of {name!r} is zero; it must have a direction")
    return [unit(row) for row in rows]


def _actuated(
    source: SourceRobot,
    movable: Sequence[str],
    named: tuple[str, ...] | None,
    given: tuple[str, ...] | None,
    missing: Missing,
) -> tuple[str, ...]:
    """Return the actuated joints without a ``<transmission>``: the ``given`` ones, those of the YAML file, or those declared."""
    transmissions = joints_of(source.root, "transmission")
    if unknown := next((name for name in given or () if name not in movable), None):
        raise ArgumentError(f"actuators: there is no joint {unknown!r} with one freedom; {near_names(unknown, movable)}")
    chosen = next((names for names in (given, named) if names is not None), _declared(source.root))
    if not chosen and given is None and named is None:
        at_base = [joint.name for joint in source.joints.values() if joint.parent not in source.parent_joints]
        example = " ".join(name for name in at_base if name in movable) or movable[0]
        missing.append(("--actuators", example, f"actuators, none or some of {', '.join(movable)}"))
    elif left_out := next((name for name in transmissions if name not in chosen), None):
        raise ArgumentError(f"actuators: {left_out!r} is not among them, but the source has a <transmission> for it")
    return tuple(name for name in chosen if name not in transmissions)


def joints_of(root: XmlElement, tag: str, child: str | None = None) -> tuple[str, ...]:
    """Return the joints named in elements ``<tag>``, with a certain child element if one is given."""
    entries = (entry for element in root.named(tag) for entry in element.named("joint"))
    return tuple(dict.fromkeys(entry.attributes.get("name", "") for entry in entries if child is None or entry.named(child)))


def _declared(root: XmlElement) -> tuple[str, ...]:
    """Return the joints of ``<transmission>``, or else those with a ``<command_interface>`` in ``<ros2_control>``."""
    return joints_of(root, "transmission") or joints_of(root, "ros2_control", "command_interface")
