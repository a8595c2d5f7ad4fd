"""Reader of SDFormat files, http://sdformat.org/spec, of its joints in the tag ``<gazebo>`` of a URDF, and of Drake's elements.

Poses are relative to the frame ``relative_to``: by default the model for links and frames, the child for joints. Axes are in the
joint's frame, or in the frame ``expressed_in``; in files before version 1.7 in the model's with ``use_parent_model_frame``, and
before 1.5 always. A link with several joints as child closes loops. Drake's elements, in SDFormat and URDF, are those of
https://github.com/RobotLocomotion/drake, multibody/parsing/detail_common.h and multibody/tree/linear_bushing_roll_pitch_yaw.h.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Inertia, Link, Origin
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.description.joints import X, Y
from kinetostatics.description.validation import check_reference
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files.attributes import number_of
from kinetostatics.files.element_tables import MOMENTS
from kinetostatics.files.foreign_loops import ForeignJoint, Z, between, graph, spring, unit
from kinetostatics.files.xml import XmlElement
from kinetostatics.math.arrays import Array

#: Types of joints of this package by those of SDFormat.
TYPES = {
    **{name: name for name in ("fixed", "revolute", "continuous", "prismatic", "universal")},
    **{"ball": "spherical", "revolute2": "universal"},
}
#: Types of bushings: those whose freedoms are along and about the axes of one frame.
BUSHINGS = [kind for kind in JOINT_TYPES.values() if kind.in_loop and kind.turns is not Axes.BOTH]
#: Limits at and above this number mean none, as in files that Gazebo writes [rad, m].
UNLIMITED = 1e15
#: Versions in which axes are always in the model's frame.
OLD = ("1.0", "1.1", "1.2", "1.3", "1.4")
Frames = dict[str, tuple[str, Array]]


def _word(element: XmlElement | None, tag: str) -> str:
    """Return the text of a child element, which Drake's URDF has as ``name`` or ``value``."""
    child = None if element is None else element.child(tag)
    return "" if child is None else _text(child) or child.attributes.get("name") or child.attributes.get("value", "")


def _text(element: XmlElement) -> str:
    return "".join(part for part in element.content if isinstance(part, str)).strip()


def _numbers(element: XmlElement, text: str, count: int) -> list[float]:
    try:
        numbers = [number_of(word, is_part=True) for word in text.split()]
        if len(numbers) != count:
            raise ArgumentError(f"must be {count} numbers")
        return numbers
    except ArgumentError as error:
        raise element.error(f"{text!r} of {element.label} {error}") from None


def _pose(element: XmlElement) -> Array:
    pose = element.child("pose")
    if pose is not None and pose.attributes.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise pose.error(f"<pose> of {element.label} has a quaternion; write roll, pitch and yaw")
    x, y, z, *angles = _numbers(element, _word(element, "pose") or "0 0 0 0 0 0", 6)
    scale = math.pi / 180 if pose is not None and pose.attributes.get("degrees") == "true" else 1.0
    return _placed((x, y, z), [angle * scale for angle in angles])


def _placed(point: Sequence[float], angles: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
    (x, y, z), (roll, pitch, yaw) = point, angles
    return Origin((x, y, z), (roll, pitch, yaw)).matrix


def _base_of(element: XmlElement, default: str) -> str:
    """Return the frame to which the pose of an element is relative; ``frame`` is its name in old versions."""
    pose = element.child("pose")
    given = {} if pose is None else pose.attributes
    return given.get("relative_to") or given.get("frame") or default


def _known(element: XmlElement, name: str, frames: Frames) -> tuple[str, Array, Array]:
    """Return the link of a frame, the pose of this link, and the pose of the frame."""
    check_reference(element, element.label, "frame", name, frames)
    link, pose = frames[name]
    return link, frames[link][1], pose


def read_joint(element: XmlElement, frames: Frames, version: str) -> ForeignJoint:
    """Return a joint from the link and the pose (4, 4), relative to the model, of each frame."""
    kind = element.attributes.get("type", "")
    if kind not in TYPES:
        raise element.error(f"{element.label} has the type {kind!r}, which is not read; {near_names(kind, TYPES)}")
    links = [_known(element, _word(element, side), frames)[:2] for side in ("parent", "child")]
    frame = _known(element, _base_of(element, _word(element, "child")), frames)[2] @ _pose(element)
    axes: list[Vector] = []
    limits: dict[str, float] = {}
    stiffness = 0.0
    for axis in filter(None, (element.child("axis"), element.child("axis2"))):
        vector = np.array(_numbers(axis, _word(axis, "xyz") or "0 0 1", 3))
        in_model = _word(axis, "use_parent_model_frame") in ("1", "true") or version in OLD
        seen_from = axis.required_child("xyz").attributes.get("expressed_in", "__model__" if in_model else "")
        if seen_from:
            turn = np.eye(3) if seen_from == "__model__" else _known(element, seen_from, frames)[2][:3, :3]
            vector = frame[:3, :3].T @ turn @ vector
        if not vector.any():
            raise axis.error(f"the axis of {element.label} is zero")
        axes.append(unit(vector))
        limits = limits or _limits(axis)
        (stiffness,) = _numbers(axis, _word(axis.child("dynamics"), "spring_stiffness") or "0", 1)
    of_kind = JOINT_TYPES[TYPES[kind]]
    if of_kind.is_hinge and "lower" not in limits:
        of_kind = JOINT_TYPES["continuous"]
    first, second, *_ = (*axes, Z, Z)
    ends = [(*link, frame) for link in links]
    limits, springs = limits if of_kind.is_single else {}, spring(of_kind, first, stiffness)
    return _between(element, of_kind, first, ends, axis2=second, limits=limits, stiffness=springs)


def read_drake(model: XmlElement, frames: Frames) -> Iterator[ForeignJoint]:
    """Yield the joints of ``<drake:ball_constraint>`` and ``<drake:linear_bushing_rpy>``, without their damping.

    A bushing is an elastic joint, free in the directions without stiffness; its two frames coincide where it is relaxed.
    """
    for element in model.named("drake:ball_constraint"):
        links = [_known(element, _word(element, f"drake:ball_constraint_body_{side}"), frames) for side in "AB"]
        words = [_word(element, f"drake:ball_constraint_p_{point}") for point in ("AP", "BQ")]
        first = links[0][2] @ _placed(_numbers(element, words[0], 3))
        second = links[1][2] @ _placed(_numbers(element, words[1], 3)) if words[1] else first  # the same with all joints at zero
        ends = [(*link[:2], point) for link, point in zip(links, (first, second), strict=True)]
        yield _between(element, JOINT_TYPES["spherical"], X, ends)
    for element in model.named("drake:linear_bushing_rpy"):
        ends = [_known(element, _word(element, f"drake:bushing_frame{side}"), frames) for side in "AC"]
        words = [_word(element, f"drake:bushing_{what}_stiffness") for what in ("force", "torque")]
        stiffness = tuple(number for word in words for number in _numbers(element, word, 3))
        free = [number == 0 for number in stiffness]
        fitting = [(kind, axis) for kind in BUSHINGS for axis in (X, Y, Z) if _free(kind, axis) == free]
        if not fitting:
            raise element.error(f"{element.label} has no stiffness in directions that are together the freedoms of no joint type")
        kind, axis = fitting[-1]  # without limits, if there are types with and without
        yield _between(element, kind, axis, ends, stiffness=stiffness)


def _free(kind: JointType, axis: Vector) -> list[bool]:
    """Return whether each translation and rotation of the frame of a joint is a freedom."""
    return [bool(direction.any()) for directions in kind.axes(np.array(axis)) for direction in directions]


def _between(
    element: XmlElement, kind: JointType, axis: Vector, ends: Iterable[tuple[str, Array, Array]], **more: Keyword
) -> ForeignJoint:
    name = element.attributes.get("name", "")
    return between(name, kind.name, ends, axis if kind.has_axis else None, element.place, **more)


def _limits(axis: XmlElement) -> dict[str, float]:
    words = {name: _word(axis.child("limit"), name) for name in ("lower", "upper", "effort", "velocity")}
    numbers = {name: _numbers(axis, word, 1)[0] for name, word in words.items() if word}
    limits = {name: number for name, number in numbers.items() if abs(number) < UNLIMITED}
    rates = {name: limits[name] for name in ("effort", "velocity") if limits.get(name, -1) >= 0}
    return {"lower": limits["lower"], "upper": limits["upper"], **rates} if {"lower", "upper"} <= set(limits) else rates


def robot_element(root: XmlElement, warnings: list[str]) -> XmlElement:
    """Return the element ``<robot>`` of a file with one model; joints that close loops become ``<loop>``.

    Raises:
        RobotFileError: there are several or nested models, a gearbox or screw, or frames that do not exist.
    """
    models = [model for holder in (root, *root.named("world")) for model in holder.named("model")]
    if len(models) != 1:
        raise root.error(f"the file has {len(models)} models; a robot file has one")
    (model,) = models
    for nested in (*model.named("model"), *model.named("include")):
        raise nested.error(f"the model contains a <{nested.tag}>; write it as one model by: gz sdf -p {root.place.file}")
    version = root.attributes.get("version", "1.8")
    holders = {element.attributes.get("name", ""): element for tag in ("link", "frame", "joint") for element in model.named(tag)}
    frames = {name: (name, np.eye(4)) for name in ("world", "__model__") if name not in holders}
    for name in holders:
        _resolve(name, holders, frames, ())
    links = [_link(element) for element in model.named("link")]
    joints = [replace(read_joint(element, frames, version), closes=False) for element in model.named("joint")]
    joints += read_drake(model, frames)
    if "world" not in holders and any("world" in (joint.predecessor, joint.successor) for joint in joints):
        links.insert(0, Link("world", place=model.place))
    if not links:
        raise model.error("the model has no links")
    return graph(model.attributes.get("name", "robot"), links, joints, _driven(model), Place(root.place.file), warnings)


def _resolve(name: str, holders: Mapping[str, XmlElement], frames: Frames, below: tuple[str, ...]) -> None:
    """Add the frame of a link, frame or joint to ``frames``, after those to which its pose is relative."""
    if name in frames:
        return
    element = holders[name]
    attached = _word(element, "child") if element.tag == "joint" else element.attributes.get("attached_to", "")
    base = _base_of(element, attached or "__model__")
    for needed in filter(None, (attached, base)):
        check_reference(element, element.label, "frame", needed, dict.fromkeys([*holders, *frames]))
        if needed in below:
            raise element.error(f"{element.label} refers to the frame {needed!r}, which depends on it")
        _resolve(needed, holders, frames, (*below, name))
    frames[name] = (name if element.tag == "link" else frames[attached or base][0], frames[base][1] @ _pose(element))


def _link(element: XmlElement) -> Link:
    name, inertial = element.attributes.get("name", ""), element.child("inertial")
    if inertial is None:
        return Link(name, place=element.place)
    origin = Origin.of(_pose(inertial))
    (mass,) = _numbers(inertial, _word(inertial, "mass") or "1", 1)
    tensor = inertial.child("inertia")
    moments = [_numbers(inertial, _word(tensor, part) or str(float(part[1] == part[2])), 1)[0] for part in MOMENTS]
    inertia = Inertia(tuple(moments), origin.rpy)  # type: ignore[arg-type]
    return Link(name, mass, origin.xyz, inertia, has_inertial=True, place=element.place)


def _driven(model: XmlElement) -> Iterator[str]:
    """Yield the joints that a controller of Gazebo commands: ``<joint_name>`` of plugins, except the publisher of states."""
    for plugin in model.named("plugin"):
        if "state-publisher" not in plugin.attributes.get("filename", ""):
            yield from map(_text, plugin.named("joint_name"))
