"""Sections, materials and masses of a generated file: given values, or defaults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from kinetostatics.arguments import check_mapping
from kinetostatics.authoring.file_arguments import FileArguments, rounded
from kinetostatics.authoring.limb_parts import Skeleton
from kinetostatics.authoring.notation import Architecture
from kinetostatics.authoring.section_words import MATERIALS, SectionText, parse_section
from kinetostatics.exceptions import ArgumentError, near_names

MATERIAL_NAMES = ("youngs_modulus", "poisson_ratio", "shear_modulus", "density", "shear_coefficient", "thermal_expansion")


def chosen_sections(
    architecture: Architecture, skeletons: Sequence[Skeleton], given: Mapping[str, str], lengths: Mapping[str, float]
) -> tuple[dict[str, SectionText], list[dict[str, str]]]:
    """Return sections by prefix, and for each limb the prefix of each role."""
    check_mapping("sections", given, '{"rod": "tube 60mm 50mm steel"}')
    has_telescope = any(span.kind == "telescope" for skeleton in skeletons for span in skeleton.spans)
    roles = {role for skeleton in skeletons for role in skeleton.roles} | ({"cylinder"} if has_telescope else set())
    known = sorted(roles | {f"{role}_{k + 1}" for role in roles for k in range(len(skeletons))})
    for key in given:
        if key not in known:
            raise ArgumentError(f"sections: {architecture.text} has no {key!r}; {near_names(key, known)}")
    found: dict[str, SectionText] = {}
    prefixes: list[dict[str, str]] = []
    for skeleton in skeletons:
        alike = [k for k, other in enumerate(skeletons, 1) if other.group == skeleton.group]
        mine: dict[str, str] = {}
        for role in (*skeleton.roles, "cylinder"):
            own = next((f"{role}_{k}" for k in alike if f"{role}_{k}" in given), None)
            if role == "cylinder" and (
                (own is None and role not in given) or not any(s.kind == "telescope" for s in skeleton.spans)
            ):
                continue
            prefix = own or role
            paired = role == "rod" and any(span.kind in ("rods", "parallelogram") for span in skeleton.spans)
            mine[role] = prefix
            if prefix not in found:
                found[prefix] = (
                    parse_section(given[prefix], f"sections, {prefix}") if prefix in given else _usual(lengths[role], paired)
                )
        prefixes.append(mine)
    return found, prefixes


def _usual(length: float, paired: bool) -> SectionText:
    """Return the default steel tube: diameter length/15, length/40 in pairs of rods; wall a tenth of the diameter."""
    outer = rounded(length / (40 if paired else 15))
    return SectionText("tube", {"outer_diameter": outer, "inner_diameter": rounded(0.8 * outer)})


def add_section_arguments(arguments: FileArguments, sections: Mapping[str, SectionText]) -> bool:
    """Add sizes and materials; return whether all beams share one material."""
    for prefix, section in sections.items():
        for number, (size, value) in enumerate(section.sizes.items()):
            heading = f"section of {prefix}: {section.shape}" if number == 0 else ""
            comment = {"width": "along the revolute joints' axes", "height": "across them"}.get(size, "")
            if size == "inner_diameter":
                _add_wall(arguments, prefix, section)
            else:
                arguments.add(f"{prefix}_{size}", value, comment, heading)
    if any(prefix.startswith("cylinder") for prefix in sections):
        arguments.add("cylinder_part", 0.5, "the cylinder's part of a telescope's length where all joints read zero")
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
        for key in ("shear_coefficient", "thermal_expansion"):
            if f"{start}{key}" in arguments.given:
                arguments.add(f"{start}{key}", 1.0)
    return shared


def _add_wall(arguments: FileArguments, prefix: str, section: SectionText) -> None:
    """Add a tube's wall thickness, which determines its inner diameter; or the inner diameter if that is given."""
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
    """Add the masses of rigid parts."""
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
