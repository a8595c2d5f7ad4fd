"""What a robot file says of joints from outside: ``<transmission>``, ``<mimic>`` and ``<joint_stiffness>``; and missing axes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

from kinetostatics.description.elements import Joint, JointStiffness, Loop, Mimic, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.xml import Element
from kinetostatics.files.xml_values import LONGEST, allow, number, positive_or_inf, reference, stiffnesses, text

#: How far an axis may lie beside an axis of the joint's frame.
_ALIGNED = 1e-9


#: The names of the types with one freedom.
_SINGLE = ", ".join(names_of("is_single"))


def read_driven(root: Element, joints: Mapping[str, Joint], loops: Mapping[str, Loop], warnings: list[str]) -> tuple[str, ...]:
    """Return the joints and loops that the ``<transmission>`` name.

    Without loops there is only a warning of one that cannot drive anything; in a closed loop it matters which joints are driven.
    """
    connections: list[Joint | Loop] = [*joints.values(), *loops.values()]
    types = {item.name: item.type for item in connections}
    driven: list[str] = []
    for transmission in root.named("transmission"):
        entries = transmission.named("joint")
        try:
            if not entries:
                raise transmission.error(f"{transmission.label} names no joint: write <joint name=…/> inside it")
            for entry in entries:
                name = reference(entry, "name", types, "joint")
                if name in joints and JOINT_TYPES[types[name]].is_fixed:
                    warnings.append(f"{entry.place}: the <transmission> of {name!r} is ignored, because this joint is fixed.")
                else:
                    driven.append(_drivable(entry, name, types[name], joints, driven))
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <transmission> is ignored.")
    return tuple(driven)


def _drivable(entry: Element, name: str, kind: str, joints: Mapping[str, Joint], driven: Collection[str]) -> str:
    """Return the name of a joint that a transmission drives.

    Raises:
        RobotFileError: the joint cannot be driven, or is so already.
    """
    if not JOINT_TYPES[kind].is_single:
        raise entry.error(f"{name!r} is {kind} and cannot be driven; only joints with one freedom can: {_SINGLE}")
    if name in driven:
        raise entry.error(f"{name!r} is driven by two <transmission>; name it once")
    mimic = joints[name].mimic if name in joints else None
    if mimic is not None:
        raise entry.error(f"{name!r} mimics {mimic.joint!r} and cannot be driven as well; drop one of the two")
    return name


# ---- <axis> ------------------------------------------------------------------------------------------------------------


def lacks_axis(element: Element) -> bool:
    """Whether a joint or loop leaves out the ``<axis>`` it has; the axes of a universal joint may well be left out."""
    kind = JOINT_TYPES.get(element.attributes.get("type", ""))
    return kind is not None and kind.has_axis and kind.turns is not Axes.BOTH and element.child("axis") is None


def axis_warning(element: Element) -> str:
    """Return the warning of an ``<axis>`` that is left out."""
    kind = JOINT_TYPES[text(element, "type")]
    slides = {Axes.AXIS: "slides along ", Axes.ACROSS: "slides across "}.get(kind.slides, "")
    moves = f"{slides}{'and ' * bool(slides)}turns about" if kind.turns is Axes.AXIS else slides.rstrip()
    frame = "its predecessor's <origin>" if element.tag == "loop" else "its frame"
    return f"{element.place}: {element.label} has no <axis>: it {moves} x of {frame}, as URDF has it; write the axis."


# ---- <mimic> -----------------------------------------------------------------------------------------------------------


def read_mimic(joint: Element, warnings: list[str]) -> Mimic | None:
    """Read the ``<mimic>`` of a joint; what it refers to is looked at by :func:`with_right_mimics`."""
    element = joint.child("mimic")
    if element is None:
        return None
    allow(element, ("joint", "multiplier", "offset"))
    kind = text(joint, "type")
    if JOINT_TYPES[kind].is_fixed:
        warnings.append(f"{element.place}: <mimic> of {joint.label} is ignored, because this joint is fixed.")
        return None
    if not JOINT_TYPES[kind].is_single:
        raise element.error(f"{joint.label} is {kind} and cannot mimic; only joints with one freedom can: {_SINGLE}")
    multiplier, offset = number(element, "multiplier", 1.0), number(element, "offset", 0.0)
    if not 1 / LONGEST <= abs(multiplier) <= LONGEST:
        raise element.error(
            f"multiplier={multiplier:g} of <mimic> in {joint.label} must be of a size between {1 / LONGEST:g} and "
            f"{LONGEST:g}: the joint's coordinate is multiplier times the other's, in m and rad, plus offset"
        )
    if abs(offset) > LONGEST:
        raise element.error(f"offset={offset:g} of <mimic> in {joint.label} is too large; it is in m or rad, at most {LONGEST:g}")
    return Mimic(text(element, "joint"), multiplier, offset)


_MASTERS = "a joint can mimic a driven revolute, continuous or prismatic <joint>"


def with_right_mimics(
    root: Element, joints: Mapping[str, Joint], loops: Collection[str], warnings: list[str]
) -> dict[str, Joint]:
    """Return the joints; without loops those that mimic what they cannot do so no more, and there is a warning.

    Raises:
        RobotFileError: there are loops, in which it matters.
    """
    result = dict(joints)
    for element in root.named("joint"):
        joint = joints[element.attributes["name"]]
        try:
            if joint.mimic is not None:
                _check_mimic(element, joint.mimic, joints, loops)
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <mimic> is ignored.")
            result[joint.name] = replace(joint, mimic=None)
    return result


def _check_mimic(element: Element, mimic: Mimic, joints: Mapping[str, Joint], loops: Collection[str]) -> None:
    found = element.required_child("mimic")
    if mimic.joint in loops:
        raise found.error(
            f"{element.label} mimics the loop {mimic.joint!r}; {_MASTERS} of the tree: cut the loop at another joint"
        )
    master = joints[reference(found, "joint", joints, "joint")]
    if master.name == element.attributes["name"]:
        raise found.error(f"{element.label} mimics itself; {_MASTERS}")
    if master.mimic is not None:
        raise found.error(f"{element.label} mimics {master.name!r}, which mimics {master.mimic.joint!r}; name the last of them")
    if not JOINT_TYPES[master.type].is_single:
        raise found.error(f"{element.label} mimics {master.name!r}, which is {master.type}; {_MASTERS}")


def check_masters(root: Element, joints: Mapping[str, Joint], driven: Collection[str]) -> None:
    """Raise an error unless every joint that mimics follows a driven one."""
    for element in root.named("joint"):
        mimic = joints[element.attributes["name"]].mimic
        if mimic is not None and mimic.joint not in driven:
            raise element.required_child("mimic").error(
                f"{element.label} mimics {mimic.joint!r}, which is not driven by a <transmission>; {_MASTERS}"
            )


# ---- <joint_stiffness> ---------------------------------------------------------------------------------------------------


def read_joint_stiffness(
    root: Element, joints: Mapping[str, Joint], loops: Mapping[str, Loop], driven: Collection[str]
) -> dict[str, JointStiffness]:
    """Read all ``<joint_stiffness>``.

    Args:
        root: the ``<robot>`` element.
        joints, loops: all of them.
        driven: the joints and loops with a transmission.

    Returns:
        What is elastic, by the joint's name; a group whose three values are infinite is the same as none.
    """
    result: dict[str, JointStiffness] = {}
    for element in root.named("joint_stiffness"):
        allow(element, ("joint", "linear", "angular", "drive"))
        name = reference(element, "joint", {**joints, **loops}, "joint")
        if name in result:
            raise element.error(f"the joint {name!r} has a <joint_stiffness> already, in {result[name].place}")
        given = [group for group in ("linear", "angular", "drive") if group in element.attributes]
        if not given:
            raise element.error(f"{element.label} says nothing: give linear, angular or drive")
        joint = joints.get(name) or loops[name]
        locked = name in driven or (isinstance(joint, Joint) and joint.mimic is not None)
        groups = {group: _group(element, group, joint, locked) for group in ("linear", "angular")}
        drive = _drive(element, name, driven)
        result[name] = JointStiffness(name, groups["linear"], groups["angular"], drive, place=element.place)
    return result


def _drive(element: Element, name: str, driven: Collection[str]) -> float | None:
    if "drive" not in element.attributes:
        return None
    if name not in driven:
        raise element.error(
            f"{element.label} has the attribute drive, but {name!r} is not driven; name it in a <transmission>, or drop drive"
        )
    return positive_or_inf(element, "drive")


def _group(element: Element, group: str, joint: Joint | Loop, locked: bool) -> Vector | None:
    """Return three stiffnesses; all of them if the joint's freedoms cannot be told apart from what it blocks."""
    if group not in element.attributes:
        return None
    values = stiffnesses(element, group)
    if all(math.isinf(value) for value in values):
        return None
    kind = JOINT_TYPES[joint.type]
    axes = kind.slides if group == "linear" else kind.turns
    free = 0 if locked else axes.count
    elastic = [0 < value < math.inf for value in values]
    if free == 3 or (free and all(elastic)):
        return values
    if free and axes is Axes.BOTH:
        raise element.error(
            f"angular of {element.label} must be three finite numbers greater than zero, or be left out, because a {joint.type} "
            "joint's axes are not those of one frame"
        )
    blocked, where = {0, 1, 2}, {"linear": "along", "angular": "about"}
    if free:
        along = _along(joint.axis)
        if along is None:
            motion = "slides along" if group == "linear" else "turns about"
            raise element.error(
                f"{joint.name!r} {motion} an axis that is none of its frame's axes, so that {group} of "
                f"{element.label} cannot tell its freedom from what it blocks: turn the joint's frame (<origin rpy>) so that "
                "its axis is one of the frame's axes, or give three finite numbers greater than zero"
            )
        # of a plane's directions its normal is the one that is blocked
        blocked = {along} if free == 2 else blocked - {along}
    for index in sorted(blocked):
        if values[index] == 0:
            raise element.error(
                f"{group} of {element.label} is 0 {where[group]} {'xyz'[index]}, which {joint.name!r} blocks; give a number "
                "greater than zero, or inf for rigid"
            )
    return values


def _along(axis: Vector) -> int | None:
    """Return the number of the frame's axis along which a unit vector lies, or None."""
    beside = [math.hypot(*(value for k, value in enumerate(axis) if k != index)) for index in range(3)]
    return next((index for index in range(3) if beside[index] <= _ALIGNED), None)
