"""Reading of loops, springs, counterweights, beams, actuated joints and joint stiffnesses."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, BeamEnd, JointStiffness, Link, Origin, Spring
from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.description.joints import Joint, Loop
from kinetostatics.description.robot_description import by_name
from kinetostatics.description.stiffness_matrix import MATRIX
from kinetostatics.description.validation import check_pairs, valid_actuated
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.attributes import number_of, reference, text
from kinetostatics.files.element_tables import BEAM, COUNTERWEIGHT, JOINT_STIFFNESS, LOOP, SPRING, limits, read_section
from kinetostatics.files.xml import XmlElement

# ---- axes ----------------------------------------------------------------------------------------------------------------


def lacks_axis(element: XmlElement) -> bool:
    """Whether the ``<axis>`` of a joint or loop is missing; a universal joint needs none, because its default axes are usual."""
    kind = JOINT_TYPES.get(element.attributes.get("type", ""))
    return kind is not None and kind.has_axis and kind.turns is not Axes.BOTH and element.child("axis") is None


def axis_warning(element: XmlElement) -> str:
    kind = JOINT_TYPES[text(element, "type")]
    slides = {Axes.AXIS: "slides along ", Axes.ACROSS: "slides across "}.get(kind.slides, "")
    moves = f"{slides}{'and ' * bool(slides)}turns about" if kind.turns is Axes.AXIS else slides.rstrip()
    frame = "its predecessor's <origin>" if element.tag == "loop" else "its frame"
    return f"{element.place}: {element.label} has no <axis>: by URDF's default it {moves} x of {frame}; write the axis."


# ---- <loop>, <spring>, <counterweight> -----------------------------------------------------------------------------------


def read_loops(root: XmlElement, joints: Mapping[str, Joint], warnings: list[str]) -> dict[str, Loop]:
    return by_name("joint or loop", [_loop(element, warnings) for element in root.named("loop")], joints)


def _loop(element: XmlElement, warnings: list[str]) -> Loop:
    values = LOOP.read(element)
    limits(values)
    loop = Loop(**values, place=element.part_place)
    loop.check_given(child.tag for child in element.children)
    if lacks_axis(element):
        warnings.append(axis_warning(element))
    return loop


def read_springs(root: XmlElement) -> dict[str, Spring]:
    return by_name("spring", [Spring(**SPRING.read(element), place=element.part_place) for element in root.named("spring")])


def with_counterweights(
    root: XmlElement, links: Mapping[str, Link], joints: Mapping[str, Joint]
) -> tuple[dict[str, Link], dict[str, Joint]]:
    """Return links and joints, including a link with mass and its fixed joint for every ``<counterweight>``."""
    masses: list[Link] = []
    mounts: list[Joint] = []
    for element in root.named("counterweight"):
        values, place = COUNTERWEIGHT.read(element), element.place
        name, link = values["name"], reference(element, "link", links, "link")
        masses.append(Link(name, values["mass"], place=place))
        mounts.append(Joint(f"{name}_mount", "fixed", link, name, Origin(values["point"]), place=place))
    return {**links, **by_name("link", masses, links)}, {**joints, **by_name("joint", mounts, joints)}


# ---- <beam>, <transmission>, <joint_stiffness> -----------------------------------------------------------------------------


def read_beams(root: XmlElement, connections: Collection[str]) -> dict[str, Beam]:
    beams = [_beam(element, connections) for element in root.named("beam")]
    check_pairs(beams)
    return by_name("beam", beams)


def _beam(element: XmlElement, connections: Collection[str]) -> Beam:
    attributes = BEAM.read(element)
    values: dict[str, Keyword] = {
        **attributes,
        "name": attributes["name"] or attributes["link"],
        **{name: None if attributes[name] is None else _end(attributes[name], connections) for name in ("start", "end")},
    }
    return Beam(**values, section=read_section(element), place=element.place)


def _end(value: str, connections: Collection[str]) -> BeamEnd:
    """Return an end: the name of a joint or loop, optionally followed by a side, ``:parent`` or ``:child``."""
    joint, colon, side = value.rpartition(":")
    return BeamEnd(joint, side) if colon and value not in connections else BeamEnd(value)  # names may have colons themselves


def read_actuated(
    root: XmlElement, joints: Mapping[str, Joint], loops: Mapping[str, Loop], warnings: list[str]
) -> tuple[str, ...]:
    """Return the names of the joints and loops with a ``<transmission>``."""
    transmissions = [
        (element, element.label, [(entry.attributes.get("name", ""), entry.place) for entry in element.named("joint")])
        for element in root.named("transmission")
    ]
    return valid_actuated(transmissions, joints, loops, warnings)


def read_joint_stiffness(root: XmlElement, folder: str) -> dict[str, JointStiffness]:
    """Return the stiffnesses of joints, by joint; ``folder`` is that of the robot file."""
    result: dict[str, JointStiffness] = {}
    for element in root.named("joint_stiffness"):
        values = JOINT_STIFFNESS.read(element)
        if values["file"] and values["matrix"]:
            raise element.error(f"{element.label} has a matrix and a file; give either")
        values["file"] = os.path.join(folder, values["file"]) if values["file"] else ""
        if values["file"]:
            values["matrix"] = _read_matrix(element, values["file"])
        stiffness = JointStiffness(**values, place=element.place)
        joint = stiffness.joint
        if joint in result:
            raise element.error(f"the joint {joint!r} has a <joint_stiffness> already, in {result[joint].place}")
        if not any((stiffness.linear, stiffness.angular, stiffness.drive, stiffness.matrix)):
            raise element.error(f"{element.label} has no stiffness: give linear, angular or drive, a matrix or a file")
        result[joint] = stiffness
    return result


def _read_matrix(element: XmlElement, name: str) -> tuple[float, ...]:
    """Return the matrix in a file of numbers, separated by commas, semicolons or spaces."""
    numbers, place = list[float](), name
    try:
        with open(name, encoding="utf-8-sig") as file:
            for line, row in enumerate(file, 1):
                place = f"{name}:{line}"
                numbers += [number_of(word, is_part=True) for word in re.split(r"[,;\s]+", row) if word]
        place = f"the matrix in {name}"
        return tuple(MATRIX.check(numbers))
    except ArgumentError as error:
        reason = f"{place} {error}"
    except (OSError, ValueError) as error:
        reason = f"{name} is not readable: {getattr(error, 'strerror', None) or error}"
    raise element.error(f"{element.label}: {reason}")
