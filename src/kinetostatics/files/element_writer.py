"""From a description back to the elements of a robot file, numbers with all their digits.

The elements carry the places of what they are made from, so that the reader's complaints about them name these places.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from typing import TypeVar

from kinetostatics.argument_checks import FloatLike
from kinetostatics.description.elements import Beam, BeamEnd, Joint, JointStiffness, Link, Loop, Origin, Place, Spring
from kinetostatics.description.joint_types import names_of
from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.beams import NUMBERS, SECTIONS
from kinetostatics.files.xml import Element, parse, shortened, to_elements, to_text
from kinetostatics.printing.dispatch import urdf_of
from kinetostatics.sections.kinds import Section, Tube

Item = TypeVar("Item")

_ATTRIBUTE = re.compile(r"[A-Za-z_][\w:.-]*")
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
#: No axis: those of joints that move are always written.
_NONE = (float("inf"),) * 3


@urdf_of.register(RobotDescription)
def robot_text(description: RobotDescription, comment: str = "") -> str:
    """Return a description as the text of a plain URDF file with the additional elements, indented."""
    return to_text(robot_element(description), comment, indented=True)


def robot_element(description: RobotDescription) -> Element:
    """Return a description as the element ``<robot>``.

    Raises:
        RobotFileError: something is no number, or is kept under a name that it does not have.
    """
    writer = _Writer(Place(description.path))
    extra = writer.fragment(description.extra, "the description")
    transmissions = [item for item in extra if item.tag == "transmission"]
    content = [_link(link) for link in _values(description.links)]
    content += [_joint(joint) for joint in _values(description.joints)]
    if description.base:
        content.append(writer.element("base", {"link": description.base}))
    platform = _Writer(description.platform_place)
    content.append(platform.element("platform", {"link": description.platform}, platform.origin(description.platform_origin)))
    content += [_loop(loop) for loop in _values(description.loops)]
    known = {*description.joints, *description.loops}
    content += [_beam(beam, known) for beam in _values(description.beams)]
    content += [_stiffness(item) for item in _values(description.joint_stiffness, "joint")]
    content += [_spring(item) for item in _values(description.springs)]
    content += [item for item in extra if item.tag != "transmission"]
    content += _transmissions(description.driven, transmissions, writer)
    attributes = {name: value for name, value in description.attributes if name != "name"}
    for name, value in attributes.items():
        if not _ATTRIBUTE.fullmatch(name) or not str(value).isprintable():
            raise writer.error(f"{name!r} = {value!r} is no attribute for <robot>")
    return writer.element("robot", {"name": description.name, **attributes}, content)


def other_children(element: Element, *children: str) -> str:
    """Return the text of the child elements of ``element`` that are not called one of ``children``; blank text is dropped."""
    return "".join(to_text(_tight(child), header=False) for child in element.children if child.tag not in children)


def plain_transmission(joint: str, place: Place) -> Element:
    """Return the transmission that says no more than that a joint is driven."""
    entry = Element("joint", {"name": joint}, (), place, "the driven joints")
    return Element("transmission", {"name": f"drive_{joint}"}, (entry,), place)


def extra_of_robot(root: Element, known: Iterable[str]) -> str:
    """Return the text of what stands in ``<robot>`` besides ``known`` elements and plain transmissions; transmissions last."""
    kept = [child for child in root.children if child.tag not in (*known, "transmission")]
    for child in root.named("transmission"):
        names = [entry.attributes.get("name", "") for entry in child.named("joint")]
        text = to_text(_tight(child), header=False)
        if len(names) != 1 or text != to_text(plain_transmission(names[0], child.place), header=False):
            kept.append(child)
    return "".join(to_text(_tight(child), header=False) for child in kept)


def _tight(element: Element) -> Element:
    """Return an element without the blank text between its children."""
    content = tuple(_tight(item) if isinstance(item, Element) else item for item in element.content)
    if all(isinstance(item, Element) or not item.strip() for item in content):
        content = tuple(item for item in content if isinstance(item, Element))
    return Element(element.tag, element.attributes, content, element.place)


def _values(table: Mapping[str, Item], key: str = "name") -> list[Item]:
    for name, item in table.items():
        own = getattr(item, key, None)
        if own != name:
            raise getattr(item, "place", Place()).error(f"what is kept as {name!r} has the {key} {own!r}; the two must agree")
    return list(table.values())


class _Writer:
    """Makes elements at one place."""

    def __init__(self, place: Place, label: str = "") -> None:
        self.place, self.label = place, label

    def error(self, reason: str) -> RobotFileError:
        return self.place.error(shortened(reason))

    def element(self, tag: str, attributes: Mapping[str, str | None], content: Iterable[Element | None] = ()) -> Element:
        """Return an element; attributes and children that are None are left out."""
        given = {name: value for name, value in attributes.items() if value is not None}
        for name, value in given.items():
            if not isinstance(value, str):
                raise self.error(f"{name} of {self.label or tag} is {value!r}; it must be a text")
        return Element(tag, given, tuple(child for child in content if child is not None), self.place, self.label)

    def number(self, name: str, value: FloatLike) -> str:
        """Return a number with all digits that it takes to read the same again."""
        try:
            text = repr(float(value))
        except (TypeError, ValueError, OverflowError):
            raise self.error(f"{name} of {self.label} is {value!r}; it must be a number") from None
        return text.removesuffix(".0")

    def optional(self, name: str, value: FloatLike | None) -> str | None:
        """Return a number, or None for None."""
        return None if value is None else self.number(name, value)

    def numbers(self, name: str, values: Iterable[FloatLike]) -> str:
        """Return several numbers."""
        try:
            items = list(values)
        except TypeError:
            raise self.error(f"{name} of {self.label} is {values!r}; it must be three numbers") from None
        return " ".join(self.number(name, item) for item in items)

    def unless(self, name: str, values: Iterable[FloatLike], default: tuple[float, float, float]) -> str | None:
        """Return several numbers, or None where they are the default."""
        text = self.numbers(name, values)
        return None if text == self.numbers(name, default) else text

    def origin(self, origin: Origin) -> list[Element]:
        """Return ``<origin>``, or nothing for the frame itself."""
        zero = (0.0, 0.0, 0.0)
        found = {name: self.unless(name, getattr(origin, name), zero) for name in ("xyz", "rpy")}
        return [self.element("origin", found)] if any(found.values()) else []

    def direction(self, tag: str, axis: Iterable[FloatLike], default: tuple[float, float, float]) -> Element | None:
        """Return ``<axis>`` or ``<axis2>``, or None where it is the default."""
        text = self.unless(tag, axis, default)
        return None if text is None else self.element(tag, {"xyz": text})

    def fragment(self, text: str, owner: str) -> tuple[Element, ...]:
        """Return elements that are kept as text."""
        if not text:
            return ()
        try:
            root = self.placed(_elements_of(text))
        except RobotFileError as error:
            raise self.error(f"extra of {owner} cannot be read: {error.reason}") from None
        if any(isinstance(item, str) and item.strip() for item in root.content):
            raise self.error(f"extra of {owner} has text outside of elements")
        return root.children

    def placed(self, element: Element) -> Element:
        """Return an element as one of this place."""
        content = tuple(self.placed(item) if isinstance(item, Element) else item for item in element.content)
        return Element(element.tag, element.attributes, content, self.place, self.label)


@lru_cache(maxsize=1000)
def _elements_of(extra: str) -> Element:
    """Return the element around elements that are kept as text; links of the same look have the same."""
    return to_elements(parse(f"<extra>{extra}</extra>", "", plain=True)[0])


def _link(link: Link) -> Element:
    write = _Writer(link.place, f"link {link.name!r}")
    content: list[Element] = []
    if link.has_inertial:
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        moments = write.numbers("inertia", link.inertia.moments).split()
        if len(moments) != len(names):
            raise write.error(f"inertia of {write.label} has {len(moments)} moments; it must have six: {', '.join(names)}")
        content.append(
            write.element(
                "inertial",
                {},
                [
                    *write.origin(Origin(link.center_of_mass, link.inertia.rpy)),
                    write.element("mass", {"value": write.number("mass", link.mass)}),
                    write.element("inertia", dict(zip(names, moments, strict=True))),
                ],
            )
        )
    return write.element("link", {"name": link.name}, [*content, *write.fragment(link.extra, write.label)])


def _limit(write: _Writer, item: Joint | Loop, needed: bool) -> Element | None:
    values = {name: write.number(name, getattr(item, name)) for name in ("lower", "upper", "effort", "velocity")}
    unlimited = (values["lower"], values["upper"]) == ("-inf", "inf")
    if unlimited:
        del values["lower"], values["upper"]
        if not needed and values == {"effort": "0", "velocity": "0"}:
            return None
    return write.element("limit", values)


def _joint(joint: Joint) -> Element:
    write = _Writer(joint.place, f"joint {joint.name!r}")
    mimic = None
    if joint.mimic is not None:
        numbers = {name: write.number(name, getattr(joint.mimic, name)) for name in ("multiplier", "offset")}
        mimic = write.element("mimic", {"joint": joint.mimic.joint, **numbers})
    content = [
        write.element("parent", {"link": joint.parent}),
        write.element("child", {"link": joint.child}),
        *write.origin(joint.origin),
        write.direction("axis", joint.axis, _NONE if joint.type in names_of("has_axis") else _X),
        _limit(write, joint, joint.type in names_of("has_limits")),
        mimic,
        *write.fragment(joint.extra, write.label),
    ]
    return write.element("joint", {"name": joint.name, "type": joint.type}, content)


def _loop(loop: Loop) -> Element:
    write = _Writer(loop.place, f"loop {loop.name!r}")
    cone = None
    if loop.cone is not None:
        cone = write.element(
            "cone",
            {
                "angle": write.number("angle", loop.cone.angle),
                "predecessor_axis": write.unless("predecessor_axis", loop.cone.predecessor_axis, _Z),
                "successor_axis": write.unless("successor_axis", loop.cone.successor_axis, _Z),
            },
        )
    content = [
        write.element("predecessor", {"link": loop.predecessor}, write.origin(loop.predecessor_origin)),
        write.element("successor", {"link": loop.successor}, write.origin(loop.successor_origin)),
        write.direction("axis", loop.axis, _NONE if loop.type in names_of("has_axis") else _X),
        write.direction("axis2", loop.axis2, _Y),
        _limit(write, loop, False),
        cone,
    ]
    return write.element("loop", {"name": loop.name, "type": loop.type}, content)


def _beam(beam: Beam, joints: Collection[str]) -> Element:
    write = _Writer(beam.place, f"beam {beam.name!r}")
    numbers = {**vars(beam.material), "shear_coefficient": beam.shear_coefficient}
    numbers["thermal_expansion"] = numbers["thermal_expansion"] or None
    attributes = {
        "name": None if beam.name == beam.link else beam.name,
        "link": beam.link,
        "from": _end(write, beam.start, joints),
        "to": _end(write, beam.end, joints),
        **{name: write.optional(name, numbers.get(name)) for name in NUMBERS},
        "y_axis": None if beam.y_axis is None else write.numbers("y_axis", beam.y_axis),
    }
    return write.element("beam", attributes, [_section(write, beam.section)])


def _end(write: _Writer, end: BeamEnd | None, joints: Collection[str]) -> str | None:
    if end is None or end.side is None:
        return None if end is None else end.joint
    text = f"{end.joint}:{end.side}"
    if text in joints:
        raise write.error(
            f"an end of {write.label} is the {end.side} side of {end.joint!r}, but a joint is called {text!r} as well"
        )
    return text


def _section(write: _Writer, section: Section) -> Element:
    """Return the element of a section, which must be what the section's own numbers follow from."""
    made = {kind: (tag, names) for tag, (kind, names) in SECTIONS.items()}  # of a tube as <tube>
    tag, names = made.get(type(section), ("", ()))
    if not tag:
        raise write.error(f"the section of {write.label} is {section!r}; take one of kinetostatics.sections")
    values = {name: write.optional(name, getattr(section, name)) for name in names}
    if type(section) is not Section:
        try:
            same = type(section).of(*(getattr(section, name) for name in names)) == section  # type: ignore[attr-defined]
        except (ArithmeticError, ArgumentError):
            same = True  # sizes that the reader will refuse
        if not same:
            raise write.error(
                f"the section of {write.label} has other numbers than its sizes give; make it with {type(section).__name__}.of(…)"
            )
    if type(section) is Tube and not section.inner_diameter:
        return write.element("circle", {"diameter": values["outer_diameter"]})
    return write.element(tag, values)


def _stiffness(item: JointStiffness) -> Element:
    write = _Writer(item.place, f"stiffness {item.joint!r}")
    values = {
        name: None if (group := getattr(item, name)) is None else write.numbers(name, group) for name in ("linear", "angular")
    }
    values["drive"] = write.optional("drive", item.drive)
    if not any(values.values()):  # rigid after all, and says so
        values["linear"] = write.numbers("linear", (math.inf,) * 3)
    return write.element("joint_stiffness", {"joint": item.joint, **values})


def _spring(item: Spring) -> Element:
    write = _Writer(item.place, f"spring {item.name!r}")
    ends = [
        write.element(tag, {"link": getattr(item, tag)}, write.origin(Origin(getattr(item, f"{tag}_point"))))
        for tag in ("predecessor", "successor")
    ]
    numbers = {name: write.number(name, getattr(item, name)) for name in ("stiffness", "free_length", "preload")}
    return write.element("spring", {"name": item.name, **numbers}, ends)


def _transmissions(driven: tuple[str, ...], known: list[Element], writer: _Writer) -> list[Element]:
    """Return the transmissions that drive ``driven`` in this order: those already ``known`` where they fit, else plain ones."""
    joints = [[entry.attributes.get("name", "") for entry in item.named("joint")] for item in known]
    of_joint = {name: number for number, names in enumerate(joints) for name in names}
    result: list[Element] = []
    position = 0
    while position < len(driven):
        number = of_joint.get(driven[position])
        names = joints[number] if number is not None else []
        if number is not None and tuple(names) == tuple(driven[position : position + len(names)]):
            result.append(known[number])
            position += len(names)
        else:
            result.append(plain_transmission(driven[position], writer.place))
            position += 1
    return result
