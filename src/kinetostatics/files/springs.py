"""``<spring>`` between two links, and ``<counterweight>``: what balances gravity."""

from __future__ import annotations

from collections.abc import Mapping

from kinetostatics.description.elements import Joint, Link, Origin, Spring, Vector
from kinetostatics.description.robot import by_name
from kinetostatics.files.xml import Element
from kinetostatics.files.xml_values import allow, new_name, not_negative, number, origin, positive, reference


def read_springs(root: Element, links: Mapping[str, Link]) -> dict[str, Spring]:
    """Read all ``<spring>``."""
    return by_name("spring", [_spring(element, links) for element in root.named("spring")])


def _spring(element: Element, links: Mapping[str, Link]) -> Spring:
    name = new_name(element)
    allow(element, ("name", "stiffness", "free_length", "preload"), ("predecessor", "successor"))
    predecessor, first = _end(element, "predecessor", links)
    successor, second = _end(element, "successor", links)
    if predecessor == successor:
        raise element.error(f"{element.label} joins the link {predecessor!r} to itself")
    stiffness, free_length = (not_negative(element, name) for name in ("stiffness", "free_length"))
    preload = number(element, "preload", 0.0)
    return Spring(name, stiffness, predecessor, successor, first, second, free_length, preload, place=element.place)


def _end(element: Element, tag: str, links: Mapping[str, Link]) -> tuple[str, Vector]:
    side = element.required_child(tag)
    allow(side, ("link",), ("origin",))
    return reference(side, "link", links, "link"), _point(side)


def _point(element: Element) -> Vector:
    """Return where something is on a link, which has no orientation."""
    place = element.child("origin")
    if place is not None:
        allow(place, ("xyz",))
    return origin(element).xyz


def with_counterweights(
    root: Element, links: Mapping[str, Link], joints: Mapping[str, Joint]
) -> tuple[dict[str, Link], dict[str, Joint]]:
    """Return links and joints, and for every ``<counterweight>`` a link that weighs and the fixed joint that holds it."""
    masses: list[Link] = []
    mounts: list[Joint] = []
    for element in root.named("counterweight"):
        name = new_name(element)
        allow(element, ("name", "link", "mass"), ("origin",))
        link = reference(element, "link", links, "link")
        masses.append(Link(name, positive(element, "mass"), place=element.place))
        mounts.append(Joint(f"{name}_mount", "fixed", link, name, Origin(_point(element)), place=element.place))
    return {**links, **by_name("link", masses, links)}, {**joints, **by_name("joint", mounts, joints)}
