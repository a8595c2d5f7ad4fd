"""Loops and actuators of a source, a URDF with loops of another tool, from the source's files and from arguments.

All missing information is listed in one error.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.arguments import finite_numbers
from kinetostatics.description.fields import Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.joints import Loop
from kinetostatics.description.validation import tree_root
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files import gepetto
from kinetostatics.files.foreign_loops import FRAME, MARK, ForeignLoop, SourceRobot, read_closing_frames, read_loop_joints
from kinetostatics.files.urdf import read_joints, read_links
from kinetostatics.files.xml import XmlElement

_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


@dataclass(frozen=True)
class DeclaredActuators:
    """Actuators of a source: joints named by its YAML file (None without names), and joints with a ``<transmission>``."""

    named: tuple[str, ...] | None
    transmissions: tuple[str, ...]
    note: str = ""


def foreign_robot(
    path: str, root: XmlElement, yaml: str | os.PathLike[str] | None
) -> tuple[SourceRobot, list[ForeignLoop], DeclaredActuators, list[str]]:
    """Return the source with the joint types of a YAML file, the loops, the actuators, and warnings."""
    source = _source(path, root)
    entries = [entry for element in root.named("transmission") for entry in element.named("joint")]
    transmissions = tuple(dict.fromkeys(entry.attributes.get("name", "") for entry in entries))
    warnings: list[str] = []
    if yaml is None:
        yaml = None if root.named("loop") else gepetto.yaml_beside(path)
        if yaml is None:
            return source, [*read_closing_frames(source), *read_loop_joints(source)], DeclaredActuators(None, transmissions), []
        warnings = [f"{yaml}: the loops are read from this file, which lies beside the URDF."]
    record = gepetto.read(source, yaml)
    loops = [*record.loops, *read_closing_frames(source, record.frames), *read_loop_joints(source)]
    if not loops:
        raise RobotFileError("there is no closed_loop, and the URDF has no loops either", os.fsdecode(yaml))
    named = None if record.actuated is None else gepetto.actuated_after(record.actuated, record.retyped)
    if record.retyped:
        retyped = _source(path, gepetto.retype(source, record.retyped))
        source = replace(retyped, made=frozenset(retyped.links) - frozenset(source.links))
    return source, loops, DeclaredActuators(named, transmissions, record.actuated_note), [*warnings, *record.warnings]


def _source(path: str, root: XmlElement) -> SourceRobot:
    warnings: list[str] = []  # repeated when the new file is read
    links = read_links(root, warnings, [])
    joints = read_joints(root, warnings)
    tree_root(links, joints)
    return SourceRobot(path, root, links, joints)


def complete(
    source: SourceRobot,
    foreign_loops: Sequence[ForeignLoop],
    declared: DeclaredActuators,
    platform_link: str | None,
    types: Mapping[str, str] | str | None,
    axes: Mapping[str, object] | None,
    actuators: tuple[str, ...] | None,
) -> tuple[tuple[Loop, ...], tuple[str, ...], list[str]]:
    """Return the loops, the actuated joints without a ``<transmission>``, and warnings.

    Raises:
        ArgumentError: information is missing both in the source and in the arguments of :func:`kinetostatics.extend_robot`; or an
            argument does not fit the source.
        RobotFileError: two loops have the same name, or a loop and a joint.
    """
    _check_names(source, foreign_loops)
    warnings: list[str] = []
    missing: list[str] = []
    if platform_link is None and source.root.child("platform") is None:
        links = [link for link in source.links if link in source.parent_joints and not MARK.fullmatch(link)]
        missing.append(f"platform_link, one of {', '.join(link for link in links if link not in source.made)}")
    if isinstance(types, str):  # one type for all loops that have none
        types = {loop.name: types for loop in foreign_loops if loop.type is None}
    names = [loop.name for loop in foreign_loops]
    for argument, given in (("types", types), ("axes", axes)):
        if not isinstance(given, Mapping | None):
            raise ArgumentError(f"{argument} must be a dict with the loops' names as keys, not {type(given).__name__}")
        for name in given or ():
            if name not in names:
                raise ArgumentError(f"{argument}: there is no loop {name!r}; {near_names(str(name), names)}")
    loops = [_loop(loop, (types or {}).get(loop.name), (axes or {}).get(loop.name), missing, warnings) for loop in foreign_loops]
    closed = [loop for loop in loops if loop is not None]
    movable = [joint.name for joint in source.joints.values() if JOINT_TYPES[joint.type].is_single]
    untyped = {loop.name for loop in closed if not JOINT_TYPES[loop.type].is_single}
    drivable = [*movable, *(name for name in names if name not in untyped)]
    actuated = _actuated(source, drivable, declared, actuators, missing, warnings)
    if missing:
        raise ArgumentError(f"{source.path} lacks information; give also {'; '.join(missing)}")
    return tuple(closed), actuated, [*warnings, *filter(None, (_rotation_warning(source, loop) for loop in closed))]


def unread_loops(path: str, root: XmlElement, links: Iterable[str]) -> str:
    """Return, as text, the file, XML element or link in which another tool defines loops; "" if there is none."""
    if yaml := gepetto.yaml_beside(path):
        return yaml
    if root.named("loop_joint"):
        return "<loop_joint>"
    return next((f"the link {link!r}" for link in links if FRAME.fullmatch(link)), "")


def _check_names(source: SourceRobot, foreign_loops: Sequence[ForeignLoop]) -> None:
    places = {joint.name: joint.place for joint in source.joints.values()}
    for loop in foreign_loops:
        other = places.setdefault(loop.name, loop.place)
        if other is not loop.place:
            raise loop.place.error(f"the loop's name {loop.name!r} is taken already, in {other}; rename one of them")
        if loop.predecessor == loop.successor:
            raise loop.place.error(f"both frames of the loop {loop.name!r} are on the link {loop.predecessor!r}")


def _loop(loop: ForeignLoop, given: str | None, axis: object, missing: list[str], warnings: list[str]) -> Loop | None:
    """Return a loop; if its type or axis is unknown, add this to ``missing`` and return None."""
    name, allowed_types = loop.name, names_of("in_loop")
    where = f"{name} ({loop.place}), which joins {loop.predecessor} and {loop.successor}"
    if given is not None and given not in allowed_types:
        raise ArgumentError(f"types: {name!r} cannot be {given!r}; {near_names(str(given), allowed_types)}")
    if given is not None and loop.type not in (None, given):
        warnings.append(f"{loop.place}: the loop {name!r} has the given type {given}; the source has {loop.type}.")
    kind = given or loop.type
    if kind is None:
        missing.append(f"types: of {where}, one of {', '.join(allowed_types)}")
        return None
    of_kind = JOINT_TYPES[kind]
    count = 2 if of_kind.turns is Axes.BOTH else 1
    vectors: tuple[Vector, ...] = ()
    if not of_kind.has_axis:
        if axis is not None:
            raise ArgumentError(f"axes: the loop {name!r} is {kind} and has no axis")
    elif axis is not None:
        vectors = _unit_vectors(name, axis, count, kind)
        if loop.axis is not None and count == 1 and np.abs(np.subtract(vectors[0], loop.axis)).max() > 1e-9:
            warnings.append(f"{loop.place}: the loop {name!r} has the given axis; the source has {loop.axis}.")
    elif loop.axis is not None and count == 1:
        vectors = (loop.axis,)
    else:
        what = "both axes" if count == 2 else "the normal" if of_kind.slides is Axes.ACROSS else "the axis"
        second = f" and on {loop.successor}" if count == 2 else ""
        note = f"; {loop.note}" if loop.note else ""
        missing.append(f"axes: {what} of the {kind} joint {where}, in its frame on {loop.predecessor}{second}{note}")
        return None
    ends = (loop.predecessor, loop.successor, loop.predecessor_origin, loop.successor_origin)
    filled = [*vectors, *(_X, _Y)[len(vectors) :]]
    return Loop(name, kind, *ends, axis=filled[0], axis2=filled[1], place=loop.place)


def _unit_vectors(name: str, value: object, count: int, kind: str) -> tuple[Vector, ...]:
    array = finite_numbers(f"axes: {name!r}", value)
    if array.shape != ((3,) if count == 1 else (2, 3)):
        needed = "three numbers" if count == 1 else "two axes of three numbers each"
        raise ArgumentError(f"axes: {name!r} is {kind} and needs {needed}, not {value!r}")
    rows = array.reshape(-1, 3)
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    if not lengths.all():
        raise ArgumentError(f"axes: an axis of {name!r} is zero; it must have a direction")
    return tuple((x, y, z) for x, y, z in (rows / lengths).tolist())


def _actuated(
    source: SourceRobot,
    movable: Sequence[str],
    declared: DeclaredActuators,
    given: tuple[str, ...] | None,
    missing: list[str],
    warnings: list[str],
) -> tuple[str, ...]:
    """Return the actuated joints without a ``<transmission>``."""
    if given is not None:
        chosen = given
        for name in chosen:
            if name not in movable:
                raise ArgumentError(f"actuators: there is no joint {name!r} with one freedom; {near_names(name, movable)}")
        if declared.named is not None and set(chosen) != set(declared.named):
            listed = ", ".join(declared.named) or "none"
            warnings.append(f"{source.path}: the actuated joints are the given ones; the source lists {listed}.")
    elif declared.named is not None or declared.transmissions:
        chosen = declared.transmissions if declared.named is None else declared.named
    else:
        missing.append(f"actuators, none or some of {', '.join(movable)}{f'; {declared.note}' if declared.note else ''}")
        return ()
    for name in declared.transmissions:
        if name not in chosen:
            raise ArgumentError(f"actuators: {name!r} is not among them, but the source has a <transmission> for it")
    return tuple(name for name in chosen if name not in declared.transmissions)


def _rotation_warning(source: SourceRobot, loop: Loop) -> str | None:
    """Return a warning if, with all joints at zero, the loop's two frames differ by a rotation of more than a right angle."""
    frames, kind = source.zero_frames, JOINT_TYPES[loop.type]
    first = frames[loop.predecessor] @ loop.predecessor_origin.matrix
    second = frames[loop.successor] @ loop.successor_origin.matrix
    between = first[:3, :3].T @ second[:3, :3]
    if kind.has_axis and kind.turns is not Axes.BOTH:
        cosine, what = float(np.dot(loop.axis, between @ loop.axis)), "its axes in the two frames"
    elif kind.is_fixed:
        cosine, what = float((np.trace(between) - 1) / 2), "its two frames"
    else:
        return None
    if cosine > -1e-9:
        return None
    angle = math.degrees(math.acos(max(cosine, -1.0)))
    return (
        f"{loop.place}: with all joints at zero the loop {loop.name!r} is far from closed: the angle between {what} is "
        f"{angle:.0f}°; if the loop is meant to be closed there, turn one frame with <origin rpy>."
    )
