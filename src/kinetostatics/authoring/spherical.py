"""Spherical robots: limbs of three revolute joints, with all axes through one point, as in an Agile Eye.

The arc of crank or rod is the angle between the axes at its ends. See C. M. Gosselin, J. Angeles, The optimum kinematic design of
a spherical three-degree-of-freedom parallel manipulator, J. Mech. Transm. Autom. Des. 111 (1989).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.authoring.file_arguments import FileArguments, rounded
from kinetostatics.authoring.limb_parts import Skeleton
from kinetostatics.authoring.notation import Architecture
from kinetostatics.authoring.placement import LimbPlace
from kinetostatics.exceptions import ArgumentError

#: Default half angle of the cones of the axes at base and platform: the three axes of a cone are perpendicular.
CONE = math.acos(1 / math.sqrt(3))
CONE_TEXT = "${acos(1 / sqrt(3))}"


def check_spherical(architecture: Architecture, skeletons: Sequence[Skeleton]) -> None:
    """Raise an ArgumentError unless all limbs are RRR."""
    for skeleton in skeletons:
        if skeleton.group.kinds != ("R", "R", "R"):
            raise ArgumentError(
                f"arrangement 'spherical' is for limbs of three revolute joints, RRR; {architecture.text} has "
                f"{skeleton.group.text}"
            )


def add_spherical_arguments(
    arguments: FileArguments, architecture: Architecture, places: Sequence[LimbPlace], sizes: Mapping[str, float]
) -> dict[str, float]:
    """Add lengths, angles and joint limits to ``arguments``. Return the lengths of crank and rod between their joints [m]."""
    base, platform = sizes["base_radius"], sizes["platform_radius"]
    middle = arguments.length("elbow_radius", rounded((base + platform) / 2))
    cones = arguments.number("base_cone", CONE), arguments.number("platform_cone", CONE)
    arcs = arguments.number("crank_arc", math.pi / 2), arguments.number("rod_arc", math.pi / 2)
    for k, place in enumerate(places):
        _check_arcs(architecture, k, place, cones, arcs)
    arguments.add("base_radius", base, "O to the joints at the base")
    arguments.add("elbow_radius", middle, "O to the elbows")
    arguments.add("platform_radius", platform, "O to the joints at the platform")
    arguments.add("base_cone", CONE_TEXT, "angle of the axes at the base to -Z")
    arguments.add("platform_cone", CONE_TEXT, "angle of the axes at the platform to Z, at zero")
    arguments.add("platform_turn", "${radians(60)}", "of the axes at the platform about Z, at zero")
    arguments.add("crank_arc", "${radians(90)}", "between a limb's first and second axis")
    arguments.add("rod_arc", "${radians(90)}", "between its second and third axis")
    arguments.add("elbow", 1, "side of the bend: 1 or -1")
    arguments.add("joint_angle_max", "${radians(60)}", "of passive joints, either way from zero")
    arguments.add("drive_angle_max", "${radians(60)}", "of actuated joints, either way from zero")
    if "actuator_stiffness" in arguments.given:
        arguments.add("actuator_stiffness", "inf", "of every actuator, N m/rad; inf: rigid")
    return {
        role: math.sqrt(start**2 + end**2 - 2 * start * end * math.cos(arc))
        for role, start, end, arc in (("crank", base, middle, arcs[0]), ("rod", middle, platform, arcs[1]))
    }


def _check_arcs(
    architecture: Architecture, k: int, place: LimbPlace, cones: tuple[float, float], arcs: tuple[float, float]
) -> None:
    """Raise an ArgumentError unless crank and rod with these ``arcs`` [rad] can connect limb k's axes at base and platform."""
    assert place.at_base is not None and place.at_platform is not None  # its azimuths are given or even
    first, last = (
        np.array([math.sin(cone) * math.cos(angle.value), math.sin(cone) * math.sin(angle.value), sign * math.cos(cone)])
        for cone, angle, sign in zip(cones, (place.at_base, place.at_platform), (-1, 1), strict=True)
    )
    between = math.acos(max(-1.0, min(1.0, float(first @ last))))
    if not abs(arcs[0] - arcs[1]) < between < min(sum(arcs), 2 * math.pi - sum(arcs)):
        raise ArgumentError(
            f"{architecture.text}, limb {k + 1}: crank_arc {math.degrees(arcs[0]):.4g} and rod_arc "
            f"{math.degrees(arcs[1]):.4g} degrees do not reach from its first axis to its last, {math.degrees(between):.4g} "
            "degrees apart; change them, the cones or platform_turn"
        )


def spherical_limb(skeleton: Skeleton, prefixes: Mapping[str, str], flat: Mapping[str, bool]) -> tuple[list[str], list[str]]:
    """Return (lines of a limb's macro, names of its actuated joints); ``flat``: by role, whether the section needs a y axis."""
    names = [f"revolute_${{i}}{point.letter}" for point in skeleton.points]
    actuated = [point.symbol is not None and point.symbol.actuated for point in skeleton.points]
    limit = ["drive_angle_max" if is_actuated else "joint_angle_max" for is_actuated in actuated]

    def joint(k: int, parent: str, child: str, place: str, axis: str) -> list[str]:
        effort = ' effort="200"' if actuated[k] else ""
        return [
            f'<xacro:revolute name="{names[k]}" parent="{parent}" child="{child}" xyz="{place}" axis="{axis}"',
            f'                lower="${{-{limit[k]}}}" upper="${{{limit[k]}}}"{effort}/>',
            f'<link name="{child}"/>',
        ]

    def beam(role: str, k: int, first: str, second: str) -> str:
        y = f' y_axis="{_vector(f"{first}_{second}_normal")}"' if flat[role] else ""
        return f'<xacro:{prefixes[role]}_beam link="{role}_${{i}}" start="{names[k]}" end="{names[k + 1]}"{y}/>'

    lines = [
        "<!-- the axes of the joints at base and platform and, from the arcs, of the elbow, through O where all joints read",
        "     zero; all frames are then parallel to the base's -->",
        '<xacro:property name="u" value="${[sin(base_cone) * cos(at_base), sin(base_cone) * sin(at_base), -cos(base_cone)]}"/>',
        '<xacro:property name="v" value="${[sin(platform_cone) * cos(at_platform), sin(platform_cone) * sin(at_platform),',
        '                                   cos(platform_cone)]}"/>',
        '<xacro:axis_between u="${u}" v="${v}" from_u="${crank_arc}" from_v="${rod_arc}" side="${elbow}"/>',
        '<xacro:property name="crank_line" value="${[elbow_radius * w[j] - base_radius * u[j] for j in (0, 1, 2)]}"/>',
        '<xacro:property name="rod_line" value="${[platform_radius * v[j] - elbow_radius * w[j] for j in (0, 1, 2)]}"/>',
        "",
        *joint(0, "base", "crank_${i}", _vector("u", "base_radius * {}"), _vector("u")),
        *joint(1, "crank_${i}", "rod_${i}", _vector("crank_line"), _vector("w")),
        f'<xacro:revolute_loop name="{names[2]}" link="rod_${{i}}" platform="platform" axis="{_vector("v")}"',
        f'                     xyz="{_vector("rod_line")}"',
        f'                     xyz2="{_vector("v", "platform_radius * {}")}" angle_max="${{{limit[2]}}}"/>',
        beam("crank", 0, "u", "w"),
        beam("rod", 1, "w", "v"),
    ]
    return lines, [name for name, is_actuated in zip(names, actuated, strict=True) if is_actuated]


def _vector(name: str, form: str = "{}") -> str:
    """Return the three components of a vector as expressions; ``{}`` in ``form`` stands for a component."""
    return " ".join("${" + form.replace("{}", f"{name}[{k}]") + "}" for k in range(3))
