"""The element ``<robot>`` of a description, with all digits of its numbers.

The elements contain file and line of their parts, for errors in validation.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TypeVar

from kinetostatics.description.elements import Place
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.element_tables import (
    BASE,
    PLATFORM,
    write_beam,
    write_joint,
    write_link,
    write_loop,
    write_spring,
    write_stiffness,
)
from kinetostatics.files.xml import XmlElement, parse, shortened, to_elements, to_text

Item = TypeVar("Item")

_ATTRIBUTE = re.compile(r"[A-Za-z_][\w:.-]*")


def robot_text(description: RobotDescription, comment: str = "") -> str:
    """Return a description as the text of a plain URDF file with the additional elements, indented."""
    return to_text(robot_element(description), comment, indented=True)


def robot_element(description: RobotDescription) -> XmlElement:
    """Return a description as the element ``<robot>``.

    Raises:
        RobotFileError: a value is not of the expected type, or the key of a part differs from its name.
    """
    place = Place(description.path)
    extra = _elements_of(description.extra, place, "the description")
    transmissions = [item for item in extra if item.tag == "transmission"]
    links, joints = _values(description.links), _values(description.joints)
    known = {*description.joints, *description.loops}
    if not isinstance(description.name, (str, type(None))):
        raise place.error(shortened(f"name of robot is {description.name!r}; it must be a text"))
    attributes = {name: value for name, value in description.attributes if name != "name"}
    for name, value in attributes.items():
        if not _ATTRIBUTE.fullmatch(name) or not isinstance(value, str) or not value.isprintable():
            raise place.error(shortened(f"{name!r} = {value!r} is no attribute for <robot>"))
    return XmlElement(
        "robot",
        attributes if description.name is None else {"name": description.name, **attributes},
        (
            *(write_link(link, _elements_of(link.extra, link.place, f"link {link.name!r}")) for link in links),
            *(write_joint(joint, _elements_of(joint.extra, joint.place, f"joint {joint.name!r}")) for joint in joints),
            *([BASE.write(description, place, "robot")] if description.base else []),
            PLATFORM.write(description, description.platform_place, "robot"),
            *map(write_loop, _values(description.loops)),
            *(write_beam(beam, known) for beam in _values(description.beams)),
            *map(write_stiffness, _values(description.joint_stiffness, "joint")),
            *map(write_spring, _values(description.springs)),
            *(item for item in extra if item.tag != "transmission"),
            *_transmissions(description.driven, transmissions, place),
        ),
        place,
    )


def plain_transmission(joint: str, place: Place) -> XmlElement:
    """Return a plain transmission, which only marks a joint as driven."""
    entry = XmlElement("joint", {"name": joint}, (), place, "the driven joints")
    return XmlElement("transmission", {"name": f"drive_{joint}"}, (entry,), place)


def extra_of_robot(root: XmlElement, known: Iterable[str]) -> str:
    """Return the text of all elements of ``<robot>``, transmissions last, except ``known`` elements and plain transmissions."""
    kept = [child for child in root.children if child.tag not in (*known, "transmission")]
    for child in root.named("transmission"):
        names = [entry.attributes.get("name", "") for entry in child.named("joint")]
        if len(names) != 1 or to_text(child, header=False) != to_text(plain_transmission(names[0], child.place), header=False):
            kept.append(child)
    return "".join(to_text(child, header=False) for child in kept)


def _values(table: Mapping[str, Item], key: str = "name") -> list[Item]:
    for name, item in table.items():
        own = getattr(item, key, None)
        if own != name:
            place = getattr(item, "place", Place())
            raise place.error(shortened(f"the entry {name!r} has the {key} {own!r}; the two must agree"))
    return list(table.values())


@lru_cache(maxsize=1000)
def _elements_of(extra: str, place: Place, owner: str) -> tuple[XmlElement, ...]:
    """Return elements from their text, with the place of their owner.

    Raises:
        RobotFileError: the text cannot be parsed.
    """
    if not extra:
        return ()
    try:
        root = to_elements(parse(f"<extra>{extra}</extra>", "", plain=True)[0], place, owner)
    except RobotFileError as error:
        raise place.error(shortened(f"extra of {owner} cannot be read: {error.reason}")) from None
    if len(root.children) < len(root.content):
        raise place.error(shortened(f"extra of {owner} has text outside of elements"))
    return root.children


def _transmissions(driven: tuple[str, ...], known: list[XmlElement], place: Place) -> list[XmlElement]:
    """Return the transmissions of the joints ``driven``, in their order, from ``known`` if suitable, otherwise plain."""
    joints = [[entry.attributes.get("name", "") for entry in item.named("joint")] for item in known]
    of_joint = {name: number for number, names in enumerate(joints) for name in names}
    result: list[XmlElement] = []
    position = 0
    while position < len(driven):
        number = of_joint.get(driven[position])
        names = joints[number] if number is not None else []
        if number is not None and tuple(names) == tuple(driven[position : position + len(names)]):
            result.append(known[number])
            position += len(names)
        else:
            result.append(plain_transmission(driven[position], place))
            position += 1
    return result
