"""The xacro arguments of a generated file.

The names of a section's arguments begin with its prefix: the role of its beam (rod, crank or cylinder), or "rod_4" in limb 4.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real

from kinetostatics.arguments import check_mapping
from kinetostatics.authoring.limb_parts import Skeleton
from kinetostatics.authoring.notation import Architecture
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.units import parse_number

#: Largest plausible lengths [m], by the last part of an argument's name; larger ones are probably in mm.
LARGEST = {
    **dict.fromkeys(("radius", "height", "length", "stroke"), 20.0),
    **dict.fromkeys(("width", "diameter", "thickness"), 4.0),
}
_LENGTH = re.compile(f"({'|'.join(LARGEST)})$")


@dataclass
class FileArguments:
    """Arguments of a file.

    Attributes:
        given: values that replace defaults, by name.
        texts: texts of the values by name, in the order of the file.
        comments: comments behind the arguments, by name.
        headings: comments on a line before an argument, by name of the argument.
    """

    given: Mapping[str, object]
    texts: dict[str, str] = field(default_factory=dict)
    comments: dict[str, str] = field(default_factory=dict)
    headings: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, default: object, comment: str = "", heading: str = "") -> None:
        """Add an argument, unless it exists."""
        if name in self.texts:
            return
        self.texts[name] = text_of_value(name, self.given.get(name, default))
        self.comments[name] = comment
        if heading:
            self.headings[name] = heading

    def number(self, name: str, default: float) -> float:
        value = self.given.get(name, default)
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise ArgumentError(f"{name} is {value!r}; it must be a number, in SI units") from None
        if not math.isfinite(number):
            raise ArgumentError(f"{name} is {value!r}; it must be a finite number")
        return number

    def length(self, name: str, default: float) -> float:
        """Return a given or default length [m], which must be positive."""
        number = self.number(name, default)
        if number <= 0:
            raise ArgumentError(f"{name} is {self.given.get(name)!r}; it must be greater than zero, in metres")
        return number

    def check_all_used(self, reasons: Mapping[str, str]) -> None:
        """Raise an ArgumentError if a given value has no argument; the message has its entry in ``reasons`` or similar names."""
        for name in self.given:
            if name not in self.texts:
                reason = reasons.get(name, near_names(name, self.texts))
                raise ArgumentError(f"this robot has no value {name!r}: {reason}")

    def lines(self, used_in: str) -> list[str]:
        """Return the lines that declare the arguments.

        An argument that occurs in an expression ``${…}`` of ``used_in`` or of another argument is also declared as a property.
        """
        expressions = "".join(re.findall(r"\$\{[^}]*\}", "\n".join((used_in, *self.texts.values()))))
        used = set(re.findall(r"\w+", expressions))
        first: list[str] = []
        properties: list[str] = []
        late: list[str] = []
        for name, text in self.texts.items():
            argument = f'  <xacro:arg name="{name}" default="{text}"/>'
            if self.comments[name]:
                argument = f"{argument:<58} <!-- {self.comments[name]} -->"
            value = [f'  <xacro:property name="{name}" value="$(arg {name})"/>'] if name in used else []
            if "${" in text and any(other in re.findall(r"\w+", text) for other in self.texts):
                late += [argument, *value]
                continue
            first += ["", f"  <!-- {self.headings[name]} -->"] if name in self.headings else []
            first.append(argument)
            properties += value
        note = ["", "  <!-- computed from these values, unless given -->"] if late else []
        return [*first, "", *properties, *note, *late]


def odd_lengths(values: Mapping[str, object]) -> list[str]:
    """Return a hint for each length [m] above the bounds of ``LARGEST``."""
    hints = []
    for name, value in values.items():
        match = _LENGTH.search(name)
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            continue
        if match is not None and LARGEST[match[1]] < abs(number) < math.inf:
            hints.append(
                f"{name} = {number:g} m: lengths are in m; write {number / 1000:g} for {number:g} mm, or {number:g}mm on the "
                "command line"
            )
    return hints


def text_of_value(name: str, value: object) -> str:
    """Return a number, a text or a list of numbers as the text of an argument."""
    if isinstance(value, str):
        if any(sign in value for sign in '<>&"'):
            raise ArgumentError(f"{name} is {value!r}; it must be a number or a plain text")
        return value
    if isinstance(value, bool) or not isinstance(value, Real):
        if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
            return " ".join(text_of_value(name, element) for element in value)  # type: ignore[attr-defined]
        raise ArgumentError(f"{name} is {value!r}; it must be a number")
    number = float(value)
    short = f"{number:g}".replace("e+", "e")
    return short if float(short) == number else repr(number)


def rounded(value: float) -> float:
    """Round to two significant digits."""
    return float(f"{value:.2g}")


# ---- sections and materials as text -----------------------------------------------------------------------------------

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
    """Section and material of a beam: a key of ``SHAPES``, sizes by name [m], and a key of ``MATERIALS``."""

    shape: str
    sizes: Mapping[str, float]
    material: str = "steel"


def parse_section(text: str, what: str = "section") -> SectionText:
    """Read a section such as ``"tube 60mm 50mm steel"``. The default unit of sizes is m, the default material steel."""
    words = text.split() if isinstance(text, str) else []
    if not words:
        raise ArgumentError(f"{what} is {text!r}; {EXAMPLE}")
    shape, *size_words = words
    if shape not in SHAPES:
        raise ArgumentError(f"{what}: {shape!r} in {text!r} is no shape; {near_names(shape, SHAPES)}")
    material = size_words.pop() if size_words and size_words[-1][0].isalpha() else "steel"
    if material not in MATERIALS:
        raise ArgumentError(f"{what}: {material!r} in {text!r} is no material; {near_names(material, MATERIALS)}")
    names = SHAPES[shape]
    if len(size_words) != len(names):
        raise ArgumentError(f"{what}: {text!r} has {len(size_words)} sizes; a {shape} has {len(names)}: {', '.join(names)}")
    sizes = {name: parse_number(word, "length", f"{what}, {text!r}") for name, word in zip(names, size_words, strict=True)}
    for name, size in sizes.items():
        if not 0 < size < 1e3:
            raise ArgumentError(f"{what}: the {name} of {text!r} is {size:g} m; it must be between 0 and 1000 m")
    inner = sizes.get("inner_diameter", 0.0)
    if inner and inner >= sizes["outer_diameter"]:
        raise ArgumentError(f"{what}: the inner diameter of {text!r}, its second size, is not smaller than the outer one")
    if 2 * sizes.get("thickness", 0.0) >= min(sizes.get("width", 1e30), sizes.get("height", 1e30)):
        raise ArgumentError(
            f"{what}: the wall thickness of {text!r}, its third size, must be less than half its width and height"
        )
    return SectionText(shape, sizes, material)


# ---- arguments of sections and masses ---------------------------------------------------------------------------------

MATERIAL_NAMES = (
    *("youngs_modulus", "poisson_ratio", "shear_modulus", "density"),
    *("shear_coefficient", "thermal_expansion", "yield_strength"),
)


def chosen_sections(
    architecture: Architecture, skeletons: Sequence[Skeleton], given: Mapping[str, str], lengths: Mapping[str, float]
) -> tuple[dict[str, SectionText], list[dict[str, str]]]:
    """Return (sections by prefix, for each limb its prefixes by role); ``lengths``: greatest length of each role [m]."""
    check_mapping("sections", given, '{"rod": "tube 60mm 50mm steel"}')
    has_telescope = any(span.kind == "telescope" for skeleton in skeletons for span in skeleton.spans)
    roles = {role for skeleton in skeletons for role in skeleton.roles} | ({"cylinder"} if has_telescope else set())
    names = sorted(roles | {f"{role}_{k + 1}" for role in roles for k in range(len(skeletons))})
    for key in given:
        if key not in names:
            raise ArgumentError(f"sections: {architecture.text} has no {key!r}; {near_names(key, names)}")
    sections: dict[str, SectionText] = {}
    prefixes: list[dict[str, str]] = []
    for skeleton in skeletons:
        alike = [k for k, other in enumerate(skeletons, 1) if other.group == skeleton.group]
        kinds = {span.kind for span in skeleton.spans}
        prefix_by_role: dict[str, str] = {}
        for role in (*skeleton.roles, "cylinder"):
            prefix = next((f"{role}_{k}" for k in alike if f"{role}_{k}" in given), role)
            if role == "cylinder" and (prefix not in given or "telescope" not in kinds):
                continue
            prefix_by_role[role] = prefix
            paired = role == "rod" and ("rods" in kinds or "parallelogram" in kinds)
            if prefix in given:
                sections[prefix] = parse_section(given[prefix], f"sections, {prefix}")
            elif prefix not in sections:
                sections[prefix] = _default_section(lengths[role], paired)
        prefixes.append(prefix_by_role)
    return sections, prefixes


def _default_section(length: float, paired: bool) -> SectionText:
    """Return a steel tube with the diameter length/15, or length/40 in pairs of rods, and a wall of a tenth of the diameter."""
    outer = rounded(length / (40 if paired else 15))
    return SectionText("tube", {"outer_diameter": outer, "inner_diameter": rounded(0.8 * outer)})


def add_section_arguments(arguments: FileArguments, sections: Mapping[str, SectionText]) -> bool:
    """Add sizes and materials of all sections. Return whether all beams have the same material."""
    for prefix, section in sections.items():
        heading = f"section of {prefix}: {section.shape}"
        for size, value in section.sizes.items():
            comment = {"width": "along the revolute joints' axes", "height": "across them"}.get(size, "")
            if size == "inner_diameter":
                _add_wall(arguments, prefix, section)
            else:
                arguments.add(f"{prefix}_{size}", value, comment, heading)
            heading = ""
    if any(prefix.startswith("cylinder") for prefix in sections):
        arguments.add("cylinder_part", 0.5, "length of the cylinder / telescope where all joints read zero")
    shared = len({section.material for section in sections.values()}) <= 1 and not any(
        f"{prefix}_{key}" in arguments.given for prefix in sections for key in MATERIAL_NAMES
    )
    for prefix, section in sections.items():
        start = "" if shared else f"{prefix}_"
        modulus, ratio, density = MATERIALS[section.material]
        arguments.add(f"{start}youngs_modulus", modulus, "Pa", f"material{'' if shared else f' of {prefix}'}: {section.material}")
        if f"{start}shear_modulus" in arguments.given:
            arguments.add(f"{start}shear_modulus", 0.0, "Pa")
        else:
            arguments.add(f"{start}poisson_ratio", ratio)
        arguments.add(f"{start}density", density, "kg/m3")
        for key in ("shear_coefficient", "thermal_expansion", "yield_strength"):
            if f"{start}{key}" in arguments.given:
                arguments.add(f"{start}{key}", 1.0)
    return shared


def _add_wall(arguments: FileArguments, prefix: str, section: SectionText) -> None:
    """Add the inner diameter of a tube if it is given; else the wall thickness, and the inner diameter computed from it."""
    inner, wall = f"{prefix}_inner_diameter", f"{prefix}_wall_thickness"
    if inner in arguments.given:
        if wall in arguments.given:
            raise ArgumentError(f"{inner} and {wall} are both given; give one, the other follows from it")
        arguments.add(inner, section.sizes["inner_diameter"])
        return
    thickness = (section.sizes["outer_diameter"] - section.sizes["inner_diameter"]) / 2
    arguments.add(wall, float(f"{thickness:.10g}"))
    arguments.add(inner, f"${{{prefix}_outer_diameter - 2 * {wall}}}")


def add_mass_arguments(arguments: FileArguments, skeletons: Sequence[Skeleton], sizes: Mapping[str, float]) -> None:
    heading = "masses"
    if any(skeleton.guide for skeleton in skeletons):
        arguments.add("carriage_mass", 2.0, "of each carriage, at B_i", heading)
        heading = ""
    if any(point.kind == "4S" for skeleton in skeletons if skeleton.has_elbow for point in skeleton.points):
        arguments.add("elbow_mass", 0.2, "of each elbow, which holds a pair of rods", heading)
        heading = ""
    if any(span.kind == "parallelogram" for skeleton in skeletons for span in skeleton.spans):
        arguments.add("head_mass", 0.2, "of each end of a parallelogram", heading)
        heading = ""
    arguments.add(
        "platform_thickness", rounded(arguments.number("platform_radius", sizes["platform_radius"]) / 8), "a solid disc", heading
    )
    arguments.add("platform_center", "0 0 0", "its centre of mass from o")
    arguments.add("platform_mass", "${pi * platform_radius**2 * platform_thickness * 2700}", "aluminium")
