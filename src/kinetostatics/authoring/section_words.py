"""Sections and materials written as text: ``"tube 60mm 50mm steel"``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kinetostatics.description.units import KNOWN, find_unit, typed_number
from kinetostatics.exceptions import ArgumentError, near_names

#: Properties of materials: Young's modulus [Pa], Poisson's ratio, density [kg/m³].
MATERIALS: Mapping[str, tuple[float, float, float]] = {
    "steel": (210e9, 0.3, 7850.0),
    "aluminium": (70e9, 0.33, 2700.0),
    "titanium": (114e9, 0.34, 4430.0),
    "carbon": (70e9, 0.3, 1550.0),
}
#: Sizes of sections, in the order in which they are written.
SHAPES: Mapping[str, tuple[str, ...]] = {
    "circle": ("diameter",),
    "tube": ("outer_diameter", "inner_diameter"),
    "rectangle": ("width", "height"),
    "rectangular_tube": ("width", "height", "thickness"),
}
EXAMPLE = "write it as 'tube 60mm 50mm steel', 'circle 20mm', 'rectangle 20mm 60mm' or 'rectangular_tube 90mm 70mm 8mm aluminium'"


@dataclass(frozen=True)
class SectionText:
    """A beam's section and material.

    Attributes:
        shape: a key of ``SHAPES``.
        sizes: its sizes by name [m].
        material: a key of ``MATERIALS``.
    """

    shape: str
    sizes: Mapping[str, float]
    material: str = "steel"


def parse_section(text: str, what: str = "section") -> SectionText:
    """Read a section such as ``"tube 60mm 50mm steel"``: shape, sizes (metres without a unit), material (steel without one).

    Args:
        text: the section.
        what: name for messages.

    Raises:
        ArgumentError: the text is not a section.
    """
    words = text.split() if isinstance(text, str) else []
    if not words:
        raise ArgumentError(f"{what} is {text!r}; {EXAMPLE}")
    shape, *rest = words
    if shape not in SHAPES:
        raise ArgumentError(f"{what}: {shape!r} in {text!r} is no shape; {near_names(shape, SHAPES)}")
    material = rest.pop() if rest and rest[-1][0].isalpha() else "steel"
    if material not in MATERIALS:
        raise ArgumentError(f"{what}: {material!r} in {text!r} is no material; {near_names(material, MATERIALS)}")
    names = SHAPES[shape]
    if len(rest) != len(names):
        raise ArgumentError(f"{what}: {text!r} has {len(rest)} sizes; a {shape} has {len(names)}: {', '.join(names)}")
    sizes = {name: _length(what, text, word) for name, word in zip(names, rest, strict=True)}
    inner = sizes.get("inner_diameter", 0.0)
    if inner and inner >= sizes["outer_diameter"]:
        raise ArgumentError(
            f"{what}: the tube {text!r} has an inner diameter that is not smaller than the outer one, which is first"
        )
    if 2 * sizes.get("thickness", 0.0) >= min(sizes.get("width", 1e30), sizes.get("height", 1e30)):
        raise ArgumentError(
            f"{what}: the wall of {text!r} is thicker than half its width or height; the thickness is the third size"
        )
    return SectionText(shape, sizes, material)


def _length(what: str, text: str, word: str) -> float:
    typed = typed_number(word)
    if typed is None:
        raise ArgumentError(f"{what}: {word!r} in {text!r} is no length; {EXAMPLE}")
    value, unit = typed
    found = find_unit(unit) if unit else None
    if unit and (found is None or found.kind != "length"):
        raise ArgumentError(f"{what}: {unit!r} in {text!r} is no unit of length; units are {KNOWN}")
    length = value if found is None else found.in_si(value)
    if not 0 < length < 1e3:
        raise ArgumentError(f"{what}: {word!r} in {text!r} is {length:g} m; a size is greater than zero and smaller than 1000 m")
    return length
