"""``<beam>`` and its section elements. Where a beam lies is worked out later, from the joints at its ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

from kinetostatics.description.elements import Beam, BeamEnd, Material
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files import xml_values
from kinetostatics.files.xml import Element
from kinetostatics.files.xml_values import allow, direction, new_name, reference, text
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube

#: Numbers of a ``<beam>``, by attribute, and how each is read; ``from``, ``to`` and ``y_axis`` are no numbers.
NUMBERS: dict[str, Callable[[Element, str], float]] = {
    "youngs_modulus": xml_values.positive,
    "poisson_ratio": xml_values.number,
    "shear_modulus": xml_values.positive,
    "shear_coefficient": xml_values.positive_or_inf,
    "density": xml_values.not_negative,
    "thermal_expansion": xml_values.number,
}
#: Elements of sections: the class and the attributes that it takes in turn; the last two of a ``<section>`` may be left out.
SECTIONS: dict[str, tuple[type[Section], tuple[str, ...]]] = {
    "circle": (Tube, ("diameter",)),
    "tube": (Tube, ("outer_diameter", "inner_diameter")),
    "rectangle": (Rectangle, ("width", "height")),
    "rectangular_tube": (RectangularTube, ("width", "height", "thickness")),
    "section": (Section, ("area", "I_y", "I_z", "J", "shear_area_y", "shear_area_z")),
}


def read_beams(root: Element, links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]) -> dict[str, Beam]:
    """Read all ``<beam>``.

    Args:
        root: the ``<robot>`` element.
        links: names of all links.
        connections: names of all joints and loops.
        rigid: links that may not carry a beam, and what they are.
    """
    beams: dict[str, Beam] = {}
    for element in root.named("beam"):
        beam = _beam(element, links, connections, rigid)
        _check_against(beam, beams, element)
        beams[beam.name] = beam
    return beams


def _beam(element: Element, links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]) -> Beam:
    allow(element, ("link", "name", "from", "to", "y_axis", *NUMBERS), SECTIONS)
    link = reference(element, "link", links, "link")
    if link in rigid:
        raise element.error(
            f"the link {link!r} is the {rigid[link]} and stays rigid; give the beam a link of its own, joined to "
            f"{link!r} by a fixed joint"
        )
    start, end = _end(element, "from", connections), _end(element, "to", connections)
    if start is not None and start == end:
        raise element.error(f"{element.label} has zero length: it goes from {start.joint!r} to {start.joint!r}")
    section, numbers = _section(element), _numbers(element)
    coefficient = numbers.pop("shear_coefficient", None)
    if coefficient is not None and section.shear_area_y is not None:
        raise element.error(f"{element.label} has a shear_coefficient and shear areas; leave one of them")
    y_axis = direction(element, "y_axis") if "y_axis" in element.attributes else None
    name = new_name(element) if "name" in element.attributes else link
    beam = Beam(link, section, Material(**numbers), start, end, coefficient, y_axis, name, place=element.place)
    try:
        shear_areas = beam.shear_areas
    except ArgumentError as error:
        raise element.error(f"{element.label}: {error}") from None
    if beam.y_axis is None and not (section.is_isotropic and math.isclose(*shear_areas, rel_tol=1e-12)):
        raise element.error(
            f'{element.label} has a section that bends differently about y and z: write y_axis="x y z", the '
            "direction of the section's y (a rectangle's width) in the link's frame"
        )
    return beam


def _check_against(beam: Beam, beams: Mapping[str, Beam], element: Element) -> None:
    """Compare a beam with those before it."""
    for other in beams.values():
        if other.link != beam.link:
            continue
        if (other.start, other.end) == (beam.start, beam.end):
            raise element.error(
                f"two beams on the same span: {element.label} lies where the beam {other.name!r} lies (see {other.place}); give "
                "them different from and to"
            )
        if (other.density is None) != (beam.density is None):
            raise element.error(
                f"the beams of link {beam.link!r} must all give a density or none of them (see {other.place}), because a "
                "density replaces the link's <inertial>"
            )
    if beam.name in beams:
        raise element.error(
            f"the beam name {beam.name!r} is taken already, in {beams[beam.name].place}; give this one its own name"
        )


def _end(element: Element, name: str, connections: Collection[str]) -> BeamEnd | None:
    """Read ``from`` or ``to``: a joint or loop, with ``:parent`` or ``:child`` behind it where the side matters."""
    if name not in element.attributes:
        return None
    value = text(element, name)
    if value in connections:  # names may contain a colon themselves
        return BeamEnd(value)
    joint, colon, side = value.rpartition(":")
    if not colon:
        joint = value
    elif side not in ("parent", "child") and joint in connections:
        raise element.error(f"{name}={value!r} of {element.label} must end in ':parent' or ':child', not {side!r}")
    if joint not in connections:
        raise element.error(
            f"{element.label} goes {name} the joint {joint!r}, which does not exist; {near_names(joint, connections)} "
            "(or is its <joint> or <loop> missing?)"
        )
    return BeamEnd(joint, side)


def _numbers(element: Element) -> dict[str, float]:
    """Return the numbers that are given; those of the material are all its attributes need."""
    given = [name for name in ("poisson_ratio", "shear_modulus") if name in element.attributes]
    if len(given) != 1:
        state = "both poisson_ratio and shear_modulus" if given else "neither poisson_ratio nor shear_modulus"
        raise element.error(f"{element.label} has {state}; give one of them")
    found = {name: read(element, name) for name, read in NUMBERS.items() if name in {"youngs_modulus", *element.attributes}}
    ratio = found.get("poisson_ratio", 0.0)
    if not -1 < ratio <= 0.5:
        raise element.error(f"poisson_ratio={ratio:g} of {element.label} must be above -1 and at most 0.5")
    return found


def _section(beam: Element) -> Section:
    found = beam.children
    if len(found) != 1:
        raise (found[1] if found else beam).error(
            f"{beam.label} has {len(found) or 'no'} sections; give one of " + ", ".join(f"<{tag}>" for tag in SECTIONS)
        )
    element = found[0]
    kind, names = SECTIONS[element.tag]
    allow(element, names)
    given = [name for name in names[4:] if name in element.attributes]
    if len(given) == 1:
        raise element.error(f"<section> has {given[0]} alone; give both shear_area_y and shear_area_z, or neither")
    values = [xml_values.positive(element, name) for name in (*names[:4], *given)]
    try:
        return kind(*values) if kind is Section else kind.of(*values)  # type: ignore[attr-defined]
    except ArgumentError as error:
        raise element.error(f"{element.label}: {error}") from None
