"""Design of a robot from its notation and sizes. The role of a link is "crank" (from the base to an elbow) or "rod"."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.arguments import Keyword, check_choice, warn
from kinetostatics.authoring.file_arguments import (
    SHAPES,
    FileArguments,
    SectionText,
    add_mass_arguments,
    add_section_arguments,
    chosen_sections,
    odd_lengths,
    rounded,
)
from kinetostatics.authoring.limb_parts import Skeleton, skeleton_of
from kinetostatics.authoring.limb_text import LimbOptions
from kinetostatics.authoring.notation import Architecture
from kinetostatics.authoring.placement import (
    CARTESIAN,
    DIRECTIONS,
    PLANAR,
    SPHERICAL,
    SYMMETRIC,
    LimbPlace,
    limb_line,
    place_by_arrangement,
    place_by_table,
)
from kinetostatics.authoring.spherical import add_spherical_arguments, check_spherical
from kinetostatics.exceptions import ArgumentError


@dataclass(frozen=True)
class Design:
    """What the text of a robot file is made of.

    Attributes:
        skeletons, places, options: for each limb, its parts, its placement and the options of its macro.
        sections: sections of beams by prefix, such as "rod" in the name of the argument ``rod_outer_diameter``.
        shared_material: whether all beams have the same material.
    """

    name: str
    architecture: Architecture
    skeletons: tuple[Skeleton, ...]
    places: tuple[LimbPlace, ...]
    options: tuple[LimbOptions, ...]
    sections: dict[str, SectionText]
    shared_material: bool
    arguments: FileArguments


#: Default sizes [m].
BASE_RADIUS, PLATFORM_RADIUS, HEIGHT = 0.3, 0.2, 0.5


def design_robot(
    parsed: Architecture,
    /,
    *,
    arrangement: str = SYMMETRIC,
    azimuths: Sequence[float] | None = None,
    placements: object = None,
    guide: str | None = None,
    axis: str | None = None,
    sections: Mapping[str, str] | None = None,
    name: str | None = None,
    **given: Keyword,
) -> Design:
    """Return the design for the arguments of :func:`new_robot`, of which ``given`` are arguments of the file."""
    by_group = {group: skeleton_of(parsed, group) for group in parsed.groups}
    skeletons = tuple(by_group[group] for group in parsed.limbs)
    for what, word in (("guide", guide), ("axis", axis)):
        if word is not None:
            check_choice(what, word, DIRECTIONS)
    arguments = FileArguments(given)
    for words in odd_lengths(given):
        warn(words)
    planar, spherical = arrangement == PLANAR, arrangement == SPHERICAL and placements is None
    if spherical:
        check_spherical(parsed, skeletons)
    sizes = {
        "base_radius": arguments.length("base_radius", BASE_RADIUS),
        "platform_radius": arguments.length("platform_radius", PLATFORM_RADIUS),
        "height": arguments.number("height", 0.0 if planar or arrangement == CARTESIAN else HEIGHT),
        "base_height": arguments.number("base_height", 0.0),
        "base_spread": arguments.number("base_spread", math.radians(15)),
        "platform_spread": arguments.number("platform_spread", math.radians(15)),
    }
    turn = 60 if spherical else 30 if _needs_turn(skeletons, planar=planar) else 0
    if turn or "platform_turn" in given:
        sizes["platform_turn"] = arguments.number("platform_turn", math.radians(turn))
    word = guide or ("tangential" if planar else "vertical")
    if placements is not None:
        places = place_by_table(len(skeletons), placements, word)
    else:
        places = place_by_arrangement(parsed, skeletons, arrangement, azimuths, sizes, word, axis)
    spans = [limb_line(place, sizes["height"]) for place in places]
    if spherical:
        lengths = add_spherical_arguments(arguments, parsed, places, sizes)
    else:
        _place_arguments(arguments, places, sizes)
        lengths = _geometry_arguments(arguments, parsed, skeletons, places, spans)
    chosen, prefixes = chosen_sections(parsed, skeletons, sections or {}, lengths)
    shared = add_section_arguments(arguments, chosen)
    add_mass_arguments(arguments, skeletons, sizes)
    arguments.check_all_used(_why_missing(skeletons))
    options = tuple(
        _limb_options(k, parsed, skeletons, places, spans, prefixes[k], chosen, arguments.texts) for k in range(len(skeletons))
    )
    name = name if name is not None else re.sub(r"\W+", "_", parsed.text.lower()).strip("_")
    return Design(name, parsed, skeletons, tuple(places), options, chosen, shared, arguments)


def _needs_turn(skeletons: Sequence[Skeleton], *, planar: bool) -> bool:
    """Whether the platform could rotate about Z if the platform points had the azimuths of the base points."""
    straight = not any(skeleton.has_elbow for skeleton in skeletons)
    pivoted = any(skeleton.group.kinds == ("S",) for skeleton in skeletons)
    return straight and (planar or pivoted)


# ---- the arguments of the file --------------------------------------------------------------------------------------


def _place_arguments(arguments: FileArguments, places: Sequence[LimbPlace], sizes: Mapping[str, float]) -> None:
    polar = any(place.at_base is not None for place in places)
    texts = "".join(place.base_text + place.platform_text for place in places)
    spread = any("spread" in place.at_base.text for place in places if place.at_base is not None)
    if polar or "base_radius" in texts:
        arguments.add("base_radius", sizes["base_radius"], "O to the limbs' base points B_i")
    if places[0].platform_text and "platform_radius" not in texts:  # a table: the radius is that of the platform's disc
        radius = rounded(max(math.hypot(*place.platform[:2]) for place in places) or 0.1)
        arguments.add("platform_radius", radius, "of the disc whose inertia the platform has")
    else:
        arguments.add("platform_radius", sizes["platform_radius"], "o to their platform points A_i")
    arguments.add("height", sizes["height"], "of o above O where all joints read zero")
    if polar or "base_height" in texts:
        arguments.add("base_height", 0, "of the B_i above O")
    if "platform_turn" in sizes:
        arguments.add("platform_turn", "${radians(30)}", "of the A_i about Z, relative to the B_i")
    if spread:
        arguments.add("base_spread", "${radians(15)}", "azimuth of B_i from the middle of its pair")
        arguments.add("platform_spread", "${radians(15)}", "azimuth of A_i from the middle of its pair")


def _geometry_arguments(
    arguments: FileArguments,
    architecture: Architecture,
    skeletons: Sequence[Skeleton],
    places: Sequence[LimbPlace],
    spans: Sequence[np.ndarray],
) -> dict[str, float]:
    """Add lengths and joint limits to ``arguments``. Return the greatest length [m] of the links of each role."""
    longest: dict[str, float] = {}
    elbows = [k for k, skeleton in enumerate(skeletons) if skeleton.has_elbow]
    if elbows:
        reach = max(float(np.linalg.norm(spans[k])) for k in elbows)
        crank = arguments.length("crank_length", rounded(0.6 * reach))
        arguments.add("crank_length", crank, "B_i to the elbow E_i")
        if "crank_angle" in arguments.given:
            if "rod_length" in arguments.given:
                raise ArgumentError("crank_angle and rod_length are both given; give one, the other follows from it")
            arguments.add("crank_angle", 0.0, "of the crank, outwards, above the horizontal, where all joints read zero")
            longest["rod"] = reach
        else:
            rod = arguments.length("rod_length", rounded(0.6 * reach))
            arguments.add("rod_length", rod, "E_i to A_i")
            hanging = all(places[k].axis is None and spans[k][2] < 0 for k in elbows)
            arguments.add("elbow", -1 if hanging else 1, "side of the bend: 1 or -1, about the revolute axis")
            for k in elbows:
                _check_triangle(architecture, k, spans[k], crank, rod)
            longest["rod"] = rod
        longest["crank"] = crank
    for skeleton, span in zip(skeletons, spans, strict=True):
        if skeleton.spans and not skeleton.has_elbow:
            length = float(np.linalg.norm(span))
            if length < 1e-6:
                raise ArgumentError(
                    f"{architecture.text}: base and platform point of {skeleton.group.text} coincide; change height or radii"
                )
            longest["rod"] = max(longest.get("rod", 0.0), length)
    if any(span.kind in ("rods", "parallelogram") for skeleton in skeletons for span in skeleton.spans):
        arguments.add("pair_width", rounded(0.15 * longest["rod"]), "between the two rods of a pair")
    if any(skeleton.guide or any(span.slide for span in skeleton.spans) for skeleton in skeletons):
        arguments.add("stroke", rounded(0.4 * longest.get("rod", 0.5)), "of prismatic joints, either way from zero")
    arguments.add("joint_angle_max", "${radians(60)}", "of passive joints, either way from zero")
    if any(point.symbol and point.symbol.actuated and point.kind == "R" for skeleton in skeletons for point in skeleton.points):
        arguments.add("drive_angle_max", "${radians(90)}", "of actuated revolute joints, either way from zero")
    if "actuator_stiffness" in arguments.given:
        arguments.add("actuator_stiffness", "inf", "of every actuator, N/m or N m/rad; inf: rigid")
    return longest


def _check_triangle(architecture: Architecture, k: int, span: np.ndarray, crank: float, rod: float) -> None:
    line, out = math.hypot(span[0], span[2]), abs(float(span[1]))
    if rod <= out or not abs(crank - math.sqrt(rod**2 - out**2)) < line < crank + math.sqrt(rod**2 - out**2):
        raise ArgumentError(
            f"{architecture.text}, limb {k + 1}: crank_length {crank:g} and rod_length {rod:g} form no triangle with the "
            f"{np.linalg.norm(span):.4g} m from base point to platform point; their sum must be larger, their difference smaller"
        )


def _why_missing(skeletons: Sequence[Skeleton]) -> dict[str, str]:
    """Return, by name, the reasons why this robot's file lacks arguments that files of other robots have."""
    reasons = dict.fromkeys(("base_radius", "base_height"), "its placements come from a table")
    if any(skeleton.has_elbow for skeleton in skeletons):
        reasons["rod_length"] = "it follows from crank_angle"
        reasons["elbow"] = "crank_angle determines the elbow"
    else:
        reasons["rod_length"] = "it follows from height and radii"
        for name in ("crank_length", "crank_angle", "elbow"):
            reasons[name] = "no limb has an elbow"
    return reasons


# ---- limbs ---------------------------------------------------------------------------------------------------------


def _limb_options(
    k: int,
    architecture: Architecture,
    skeletons: Sequence[Skeleton],
    places: Sequence[LimbPlace],
    spans: Sequence[np.ndarray],
    prefixes: dict[str, str],
    sections: Mapping[str, SectionText],
    names: Collection[str],
) -> LimbOptions:
    skeleton, place = skeletons[k], places[k]
    alike = [n for n, other in enumerate(skeletons) if other.group == skeleton.group]
    oblique = any(places[n].axis is not None and abs(spans[n][1]) > 1e-9 * np.linalg.norm(spans[n]) for n in alike)
    if oblique:
        _check_oblique(architecture, k, skeleton, spans[k])
    by_azimuths = all(places[n].at_base is not None for n in alike)
    parameters, frame_lines, guide_direction = _frame_lines(
        skeleton, place, by_azimuths=by_azimuths, has_axis=any(places[n].axis is not None for n in alike)
    )
    widths = {role: _widths(prefix, sections[prefix].shape) for role, prefix in prefixes.items()}
    kinds = "".join(kind.lower() if kind[0] != "4" else f"_{kind.lower()}" for kind in skeleton.group.kinds)
    same = [group for group in architecture.groups if group.kinds == skeleton.group.kinds]
    letter = "" if len(same) == 1 else f"_{same.index(skeleton.group) + 1}"
    return LimbOptions(f"limb_{kinds}{letter}", frame_lines, parameters, guide_direction, oblique, prefixes, widths, names)


def _check_oblique(architecture: Architecture, k: int, skeleton: Skeleton, span: np.ndarray) -> None:
    """Raise an ArgumentError unless the joints of a limb's last link let it leave the plane normal to the revolute axes."""
    ends = skeleton.points[-2:]
    if len(ends) < 2 or any(point.kind not in ("U", "S") for point in ends) or (ends[0].axes == "xn" or ends[1].axes == "nx"):
        raise ArgumentError(
            f"{architecture.text}, limb {k + 1}: its platform point lies {abs(span[1]):.4g} m outside the plane through its "
            "base point normal to its revolute axes; move it into this plane, or give the axes another direction"
        )


def _frame_lines(skeleton: Skeleton, place: LimbPlace, *, by_azimuths: bool, has_axis: bool) -> tuple[str, tuple[str, ...], str]:
    """Return (parameters of a limb's macro, lines that call ``limb_frame``, expression of the guide's direction)."""
    vectors = {
        "vertical": "[0, 0, 1]",
        "radial": "[cos(at_base), sin(at_base), 0]",
        "tangential": "[-sin(at_base), cos(at_base), 0]",
    }
    if by_azimuths and all(isinstance(direction, str) for direction in (place.axis or "", place.guide)):
        axis = "" if place.axis is None else f' axis="${{{vectors[str(place.axis)]}}}"'
        lines = (
            f'<xacro:limb_frame i="${{i}}" height="${{height}}"{axis}',
            '                   base_point="${[base_radius * cos(at_base), base_radius * sin(at_base), base_height]}"',
            '                   platform_point="${[platform_radius * cos(at_platform), platform_radius * sin(at_platform),',
            '                                      0]}"/>',
        )
        return "i at_base at_platform", lines, vectors[str(place.guide)]
    axis = ' axis="${axis}"' if has_axis else ""
    placed = (
        f'<xacro:limb_frame i="${{i}}" height="${{height}}"{axis} base_point="${{base_point}}"',
        '                   platform_point="${platform_point}"/>',
    )
    more = (" axis" if has_axis else "") + (" guide_direction" if skeleton.guide is not None and not skeleton.guide_turns else "")
    return f"i base_point platform_point{more}", placed, "guide_direction"


def _widths(prefix: str, shape: str) -> tuple[str, ...]:
    return (f"{prefix}_width", f"{prefix}_height") if shape.startswith("rect") else (f"{prefix}_{SHAPES[shape][0]}",)
