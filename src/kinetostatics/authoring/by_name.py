"""Robots from the notation of parallel mechanisms: ``new_robot`` and the text of its file."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence

from kinetostatics.analysis import analyze
from kinetostatics.arguments import Keyword, path_name
from kinetostatics.authoring.designing import Design, design_robot
from kinetostatics.authoring.file_arguments import MATERIAL_NAMES, SectionText
from kinetostatics.authoring.known_names import options_of
from kinetostatics.authoring.limb_text import limb_macro
from kinetostatics.authoring.notation import JOINTS, parse_architecture
from kinetostatics.authoring.placement import direction, vector_text
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.output_files import write_text
from kinetostatics.robot import Robot


def new_robot(
    architecture: str,
    path: str | os.PathLike[str] | None = None,
    *,
    base_radius: float | None = None,
    platform_radius: float | None = None,
    height: float | None = None,
    arrangement: str | None = None,
    azimuths: Sequence[float] | None = None,
    placements: object = None,
    guide: str | None = None,
    axis: str | None = None,
    sections: Mapping[str, str] | None = None,
    name: str | None = None,
    **values: Keyword,
) -> Robot:
    """Create a robot from a common name, such as ``"Delta"``, or from the notation of its limbs, ``"3-R[P]S"``.

    The base frame has the origin O and the axes X, Y, Z; the platform's reference point is o. A limb leads from its base point to
    its platform point. For further conventions see ``docs/start/robot_by_name.md``. Common names may have other default sizes.

    Args:
        architecture: a common name, such as "Delta" (``kinetostatics new --list``), or limbs joined by +: ``"2-[P]RU+U[P]R"``,
            ``"3-[R](4S)"``. A limb is a string of the joints R, P, U, S, C from base to platform. Actuated joints are in brackets
            or underlined; if none is marked, the first prismatic joint of each limb is actuated, or else its first revolute or
            cylindrical joint.
        path: path of the new xacro file; None: no file. An existing file is not replaced.
        base_radius: distance of the base points from Z [m]; default: 0.3.
        platform_radius: distance of the platform points from o [m]; default: 0.2.
        height: height of o above O at the zero pose [m]; default: 0.5. It is negative for a suspended platform.
        arrangement: "symmetric" (evenly around Z), "planar" (evenly around Z, all revolute axes along Z, height 0 unless given),
            "cartesian" (three limbs along X, Y and Z) or "spherical" (limbs RRR whose axes all pass through O). Default: the
            arrangement of the mechanism with a common name that has these limbs; symmetric if there is none.
        azimuths: azimuths of the limbs [rad]; default: evenly spaced.
        placements: in place of radii and azimuths, a list with ``{"base": (x, y, z), "platform": (x, y, z)}`` for each limb: its
            base point in the base frame, its platform point in the platform frame [m], and optionally "axis" (direction of its
            revolute axes) and "guide" (direction of its carriage's guide). Or the path of a CSV file with the columns base_x …
            platform_z, and optionally axis_x …, guide_x ….
        guide: direction of the guides of limbs that begin with P: "vertical", "radial" or "tangential"; default: vertical, or
            tangential if planar.
        axis: direction of revolute axes: "radial", "tangential" or "vertical"; default: horizontal and perpendicular to the limb.
        sections: sections of beams by role, such as ``{"rod": "tube 60mm 50mm steel"}``. Roles are rod, crank (in limbs with an
            elbow) and cylinder (in telescopes of two pieces). "rod_4" is the rod of limb 4 and of the limbs equal to it.
        name: name of the robot; default: the file's name, or the architecture.
        values: other arguments of the file, SI units, such as ``rod_density=7820``, ``stroke=0.1`` or ``platform_mass=12``.

    Returns:
        The robot, loaded from the new text.

    Raises:
        ArgumentError: the notation or a value is invalid, or the platform is movable with locked actuators.
    """
    if name is None and path is not None:
        name = os.path.basename(os.fsdecode(path)).split(".")[0]
    text = robot_text(
        architecture,
        base_radius=base_radius,
        platform_radius=platform_radius,
        height=height,
        arrangement=arrangement,
        azimuths=azimuths,
        placements=placements,
        guide=guide,
        axis=axis,
        sections=sections,
        name=name,
        **values,
    )
    limbs = parse_architecture(architecture).text
    robot = Robot(parse_robot_text(text, f"<{limbs}>" if path is None else path_name("path", path)))
    _check_held(robot, limbs)
    if path is not None:
        write_text(path, text, new=True)
    return robot


def robot_text(architecture: str, **options: Keyword) -> str:
    """Return the text that :func:`new_robot` writes, from the same arguments except ``path``."""
    parsed = parse_architecture(architecture)
    given = {key: value for key, value in options.items() if value is not None}
    return file_text(design_robot(parsed, **(options_of(architecture, parsed.text, given) | given)))


def _check_held(robot: Robot, architecture: str) -> None:
    """Raise an ArgumentError unless the locked actuators hold the platform at the zero pose."""
    actuators, mobility = len(robot.description.actuated), robot.mobility.platform
    if actuators < mobility:
        raise ArgumentError(f"{architecture} has {mobility} freedoms in this placement and only {actuators} actuators")
    try:
        analyze(robot.assemble())
    except StaticsError as error:
        raise ArgumentError(f"{architecture}, in this placement: {error}") from None


# ---- text of the file -------------------------------------------------------------------------------------------------

#: Largest length of lines [letters].
WIDTH = 125


def _ruler(title: str) -> str:
    return f"  <!-- {'=' * 44} {title} {'=' * (60 - len(title))} -->"


def _wrapped(line: str) -> list[str]:
    """Break an XML element between attributes into lines of at most ``WIDTH`` letters; the attributes are aligned."""
    lines = []
    element = re.match(r"\s*<[\w:]+ ", line)
    while element is not None and len(line) > WIDTH:
        breaks = [match.start() for match in re.finditer(r' (?=\w+="[^"]*")', line[:WIDTH]) if match.start() > element.end()]
        if not breaks:
            break
        lines.append(line[: breaks[-1]])
        line = " " * element.end() + line[breaks[-1] + 1 :]
    return [*lines, line]


def file_text(design: Design) -> str:
    macros = dict.fromkeys(
        limb_macro(skeleton, options) for skeleton, options in zip(design.skeletons, design.options, strict=True)
    )
    beams = [
        _beam(prefix, section, design.shared_material, design.arguments.texts) for prefix, section in design.sections.items()
    ]
    calls = "\n".join(_call(design, k) for k in range(len(design.skeletons)))
    limbs = "\n".join(part for line in "\n\n".join((*macros, calls)).split("\n") for part in _wrapped(line))
    base = _BASE.replace("BASE_RADIUS", "base_radius" if "base_radius" in design.arguments.texts else "1.5 * platform_radius")
    height = design.arguments.texts.get("height", "")
    lowest = min(place.base[2] for place in design.places)
    if not height:
        below = "0.8"
    elif float(height):
        below = "0.06"
    else:
        below = "1.3" if lowest < 0 else "0.3"
    plate = 'length="${platform_thickness}"'
    if not height:  # a spherical robot: the joints at its platform are above o
        plate += ' xyz="0 0 ${platform_radius * cos(platform_cone)}"'
    elif "platform_radius" in design.places[-1].platform_text:  # a cartesian robot: they are on X, Y and Z
        plate = 'length="${2 * platform_radius}"'
    base = base.replace("BELOW", below).replace("HEIGHT", "${height}" if height else "0").replace("PLATE", plate)
    body = [_ruler("base and platform"), base, _ruler("beams"), *beams, _ruler("limbs"), limbs]
    head = [
        '<?xml version="1.0"?>',
        _about(design),
        f'<robot name="{design.name}" xmlns:xacro="http://www.ros.org/wiki/xacro">',
        '  <xacro:include filename="$(find kinetostatics)/library/limbs.xacro"/>',
        "",
        _ruler("values to choose"),
        "",
        *design.arguments.lines("\n".join(body)),
    ]
    return "\n\n".join(("\n".join(head), *body)) + "\n</robot>\n"


_BASE = """\
  <!-- frame at O: X to the right, Z up -->
  <link name="base">
    <xacro:draw_cylinder diameter="${2.3 * BASE_RADIUS}" length="0.01" material="graphite" xyz="0 0 ${-BELOW * BASE_RADIUS}"/>
  </link>

  <!-- leaves the platform all freedoms; each limb ends in a loop at the platform -->
  <joint name="platform_pose" type="floating">
    <parent link="base"/>
    <child link="platform"/>
    <origin xyz="0 0 HEIGHT"/>
  </joint>

  <!-- frame at o, parallel to the base's where all joints read zero -->
  <link name="platform">
    <xacro:disc_inertial mass="${platform_mass}" radius="${platform_radius}" thickness="${platform_thickness}"
                         xyz="$(arg platform_center)"/>
    <xacro:draw_cylinder diameter="${2 * platform_radius}" PLATE material="teal"/>
  </link>

  <!-- results refer to o and the axes of this link -->
  <platform link="platform"/>"""


def _about(design: Design) -> str:
    architecture = design.architecture
    limbs = []
    number = 1
    for group in architecture.groups:
        numbers = f"limb {number}" if group.count == 1 else f"limbs {number} to {number + group.count - 1}"
        names = ", ".join(
            JOINTS[joint.kind][0]
            + (" (actuated)" if joint.actuated and joint.kind != "C" else " (slide actuated)" if joint.actuated else "")
            for joint in group.joints
        )
        limbs.append(f"    {numbers}, {group.text}: {names}, from base to platform")
        number += group.count
    note = "  The notation has no marks of actuators: these are the usual ones.\n" if architecture.actuators_chosen else ""
    return (
        "<!--\n"
        f"  {architecture.text}, built by name. Actuators stand in brackets.\n" + "\n".join(limbs) + "\n" + note + "\n"
        "  Units: m, kg, N, rad. The loops close with all joints at zero, also after changes of values.\n"
        "  Change a value here, or without editing the file: ks.load_robot(FILE, parameters={'platform_mass': 5})\n"
        "-->"
    )


def _beam(prefix: str, section: SectionText, shared: bool, names: Mapping[str, str]) -> str:
    start = "" if shared else f"{prefix}_"
    attributes = [key for key in dict.fromkeys(("density", *MATERIAL_NAMES)) if start + key in names]
    values = [f'{key}="$(arg {start}{key})"' for key in attributes]
    sizes = " ".join(f'{size}="${{{prefix}_{size}}}"' for size in section.sizes)
    flat = section.shape.startswith("rect")
    parameter, y_axis = (" y_axis:='0 1 0'", ' y_axis="${y_axis}"') if flat else ("", "")
    return (
        f'  <xacro:macro name="{prefix}_beam" params="link start end{parameter}">\n'
        f'    <beam link="${{link}}" from="${{start}}" to="${{end}}"{y_axis}\n'
        f"          {' '.join(values)}>\n"
        f"      <{section.shape} {sizes}/>\n"
        "    </beam>\n"
        "  </xacro:macro>"
    )


def _call(design: Design, k: int) -> str:
    options, place = design.options[k], design.places[k]
    values = {"i": str(k + 1)}
    azimuth = math.atan2(place.base[1], place.base[0])
    if place.at_base is not None and place.at_platform is not None:
        values |= {"at_base": f"${{{place.at_base.text}}}", "at_platform": f"${{{place.at_platform.text}}}"}
    values |= {"base_point": f"${{{place.base_text}}}", "platform_point": f"${{{place.platform_text}}}"}
    values["axis"] = "across" if place.axis is None else f"${{{vector_text(direction(place.axis, azimuth))}}}"
    values["guide_direction"] = f"${{{vector_text(direction(place.guide, azimuth))}}}"
    names = options.parameters.split()
    return f"  <xacro:{options.macro} " + " ".join(f'{key}="{values[key]}"' for key in names) + "/>"
