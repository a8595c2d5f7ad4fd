"""Extension of a URDF: a small xacro that includes it unchanged and adds platform, loops, actuators, beams and stiffnesses."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

import numpy as np

from kinetostatics.arguments import check_mapping, names_in, path_name
from kinetostatics.authoring.file_arguments import MATERIALS, SHAPES, parse_section
from kinetostatics.authoring.spans import MATERIAL, WALL, LinkSpan, chain_joints, spans
from kinetostatics.description.elements import Beam, BeamEnd, Material, Origin
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Joint
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.description.validation import tree_root
from kinetostatics.exceptions import ArgumentError, KinetostaticsError, near_names
from kinetostatics.files.bundled import read_robot
from kinetostatics.files.foreign_robot import completed, joints_of
from kinetostatics.files.reader import describe, parse_robot_text
from kinetostatics.files.urdf import drivable, first_base
from kinetostatics.files.xacro import include_path, including_text, quoted, read_document, whole_text
from kinetostatics.files.xml import XmlElement, to_text
from kinetostatics.output_files import write_text
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Tube

#: Deflections [rad, m] of suggested stiffnesses under the largest effort of the joint; 5 mrad is usual in gears of arms.
TURN, SLIDE = 5e-3, 5e-4
#: Argument that selects all suggested beams or stiffnesses.
SUGGESTED = "suggested"
#: Smallest rotation of the platform's axes, with all joints at zero, that a comment mentions [degrees].
LEAST_TURN = 0.1


def extend_robot(
    source: str | os.PathLike[str],
    path: str | os.PathLike[str] | None = None,
    *,
    platform_link: str | None = None,
    base_link: str | None = None,
    actuators: Iterable[str] | None = None,
    elastic: Mapping[str, str] | str | None = None,
    joint_stiffness: Mapping[str, float] | str | None = None,
    yaml: str | os.PathLike[str] | None = None,
    types: Mapping[str, str] | str | None = None,
    axes: Mapping[str, object] | None = None,
    parameters: Mapping[str, object] | None = None,
) -> Robot:
    """Extend a URDF without platform, actuators and elastic parts by a small xacro that includes it unchanged.

    Loops in formats of other tools are read, see the page on them. Comments in the xacro suggest further beams (from distances of
    joints and masses of links) and stiffnesses of actuators (from their largest efforts).

    Args:
        source: the URDF or xacro.
        path: path of the new file; None: no file. An existing file is not replaced.
        platform_link: link that is the moving platform; None: the one named in the file.
        base_link: link fixed to the ground; None: the one named in the file, or the root of its tree.
        actuators: joints that are actuated besides those with a ``<transmission>``. In a robot without loops the default is all
            moving joints, and joints outside the chain from base to platform, such as a gripper's, are locked in any case. With
            loops of another tool: all actuated joints and loops, those with a ``<transmission>`` included; an empty list for
            none; default: the joints that the source declares as actuated.
        elastic: sections and materials of links that become beams, such as ``{"upper_arm": "tube 60mm 50mm steel"}``, or
            "suggested" for all suggested beams. A beam is straight between the two moving joints of its link. It has the mass of
            the link's ``<inertial>`` or, without one, of its material.
        joint_stiffness: stiffnesses of actuators [N·m/rad; N/m for prismatic joints], such as ``{"elbow": 3e4}``, or "suggested"
            for all suggested stiffnesses.
        yaml: the YAML file with the loops of the source; None: one beside the source, if there is one.
        types: joint types of loops of another tool, ``{loop: type}`` with the types of ``<loop>``; or one type for all loops
            without a type in the source.
        axes: ``{loop: (x, y, z)}``, axis of the joint in the loop's frame on its predecessor. A universal joint has two axes; the
            second is in the loop's frame on its successor.
        parameters: values of the source's xacro arguments.

    Returns:
        The robot, loaded from the new text.

    Raises:
        ArgumentError: a link, joint, loop, section or stiffness does not fit the source, or required information is missing; the
            message lists all of it.
        RobotFileError: the source or the YAML file is invalid; the message names file and line.
    """
    name = path_name("source", source)
    beside = os.path.join(os.path.dirname(name), f"<extension of {os.path.basename(name)}>")
    out = beside if path is None else path_name("path", path)
    text, includes, warnings = extension(
        name, out, platform_link, base_link, actuators, elastic, joint_stiffness, yaml, types, axes, parameters
    )
    description = parse_robot_text(text, out, parameters if includes else None)
    robot = Robot(replace(description, file_warnings=(*description.file_warnings, *warnings)) if warnings else description)
    if description.beams:
        _ = robot.beams  # raises an error if a beam does not fit between its joints
    if path is not None:
        write_text(path, text, new=True)
    return robot


def extension(
    source: str,
    out: str,
    platform_link: str | None = None,
    base_link: str | None = None,
    actuators: Iterable[str] | None = None,
    elastic: Mapping[str, str] | str | None = None,
    joint_stiffness: Mapping[str, float] | str | None = None,
    yaml: str | os.PathLike[str] | None = None,
    types: Mapping[str, str] | str | None = None,
    axes: Mapping[str, object] | None = None,
    parameters: Mapping[str, object] | None = None,
) -> tuple[str, bool, list[str]]:
    """Return (text that :func:`extend_robot` writes to ``out``, whether it includes the source file, warnings)."""
    named = None if actuators is None else tuple(dict.fromkeys(names_in("actuators", actuators, '["elbow"]')))
    data, name = read_robot(source)
    root, uses_xacro, _ = read_document(data, name, parameters or {})
    for tag, link in (("platform", platform_link), ("base", base_link)):
        if link is not None and root.named(tag):
            raise ArgumentError(f"{tag}_link={link!r}: {name} names its {tag} already; leave the argument out")
    robot = completed(name, root, platform_link, yaml, types, axes, named)
    foreign, closed, warnings = robot.source, robot.loops, list(robot.warnings)
    description = describe(robot.root, name, [], platform_link, base_link)
    actuated, holding = (robot.actuated, list[str]()) if closed else _actuators(robot.root, description, named)
    candidates = spans(description, foreign.zero_frames)
    tree = tree_root(description.links, description.joints)
    floats = description.base != tree and description.base == first_base(tree, description.joints)
    actuated_description = replace(description, actuated=tuple(dict.fromkeys((*description.actuated, *actuated, *holding))))
    parts = [
        "  <!-- results refer to the origin and the axes of this link -->\n",
        _turned_axes(description) if closed else "",
        f"  <platform link={quoted(description.platform)}/>\n" if not root.named("platform") else "",
        f"  <base link={quoted(description.base)}/>\n" if base_link is not None or floats else "",
        *(textwrap.indent(to_text(loop, header=False, indented=True), "  ") + "\n" for loop in closed),
        _actuators_text(actuated, "actuators: the moving joints without a transmission in the file, held by their brakes"),
        _actuators_text(holding, "locked joints outside the chain from base to platform, such as those of a gripper"),
        _beams_text(actuated_description, candidates, elastic),
        _stiffness_text(actuated_description, joint_stiffness),
    ]
    additions = "".join(parts)
    include = include_path(name, root, uses_xacro, additions, out) if foreign.root is root else None
    if include is None:
        return whole_text(foreign.root, additions), False, warnings
    comment = (
        f"{os.path.basename(name)} unchanged, with what it lacks for statics; comments suggest further parts (m, kg, N, rad)"
    )
    return including_text(description.name, include, _comment_text(comment), additions), True, warnings


def _turned_axes(description: RobotDescription) -> str:
    """Return a comment on the platform's rotation from the base with all joints at zero; empty if it is not rotated."""
    robot = Robot(description)
    try:
        rotation = robot.mechanism.platform_pose(robot.zero_frames)[0][..., 0]
    except KinetostaticsError:  # reported by check
        return ""
    angle = float(np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))))
    if angle < LEAST_TURN:
        return ""
    back = description.platform_origin.matrix[:3, :3] @ rotation.T  # the axes that would be parallel, in the platform link
    turned = Origin.of(np.block([[back, np.zeros((3, 1))], [np.eye(4)[3:]]]))
    rpy = " ".join(f"{value if abs(value) > 1e-12 else 0.0:.12g}" for value in turned.rpy)
    return f'  <!-- turned by {angle:.4g}° with all joints at zero; <origin rpy="{rpy}"/> makes them parallel to the base -->\n'


# ---- actuators ------------------------------------------------------------------------------------------------------------


def _actuators(
    root: XmlElement, description: RobotDescription, given: Collection[str] | None
) -> tuple[tuple[str, ...], list[str]]:
    """Return (joints to be actuated, joints outside the chain from base to platform to be locked); all get a transmission."""
    driven = joints_of(root, "transmission")
    free = [] if description.loops else [name for name in drivable(description.joints) if name not in driven]
    if given is None:
        return tuple(free), []
    joints = {**description.joints, **description.loops}
    for name in given:
        if name not in joints:
            raise ArgumentError(f"actuators: no joint {name!r}: {near_names(name, joints)}")
    passed = {joint.name for joint, _ in chain_joints(description)}
    return tuple(name for name in given if name not in driven), [
        name for name in free if name not in passed and name not in given
    ]


def _actuators_text(names: Iterable[str], comment: str) -> str:
    lines = [f"  <transmission name={quoted(f'drive_{name}')}><joint name={quoted(name)}/></transmission>\n" for name in names]
    return f"\n  <!-- {comment} -->\n" + "".join(lines) if lines else ""


# ---- beams -------------------------------------------------------------------------------------------------------------


def _beams_text(
    description: RobotDescription, candidates: Mapping[str, LinkSpan], elastic: Mapping[str, str] | str | None
) -> str:
    texts = {link: _suggested_beam(description, span) for link, span in candidates.items()}
    suggested = {link: text for link, text in texts.items() if text}
    if elastic == SUGGESTED:
        chosen = dict.fromkeys(suggested, "")
        if not chosen:
            raise ArgumentError(
                f"elastic: no link of the file has the data of a beam; {_platform_advice(description) or 'name links'}"
            )
    elif isinstance(elastic, str):
        raise ArgumentError(
            f"elastic is {elastic!r}; it is {SUGGESTED!r}, or sections by link: {{'upper_arm': 'tube 60mm 50mm steel'}}"
        )
    else:
        chosen = dict(elastic or {})
        check_mapping("elastic", chosen, '{"upper_arm": "tube 60mm 50mm steel"}')
    written = [suggested[link] if not text else _beam_text(description, candidates, link, text) for link, text in chosen.items()]
    possible = [link for link in suggested if link not in chosen]
    result = ""
    if written:
        comment = "elastic links: straight beams between two joints; each link keeps its mass and its centre of mass"
        result += f"\n  <!-- {comment} -->\n" + "".join(written)
    if possible:
        result += (
            f"\n  <!-- Possible beams: {MATERIAL} tubes of the link's mass, with walls of {WALL:g} diameters, within the\n"
            "       limits of beam theory. Measure your own, and take the beam out of its comment. -->\n"
        )
        for span in (candidates[link] for link in possible):
            remark = f"{span.link}: {span.length:.3g} m between its joints, {span.mass:.3g} kg"
            result += f"  <!-- {_comment_text(remark)}\n{_comment_text(suggested[span.link])}  -->\n"
    return result


def _comment_text(text: str) -> str:
    """Separate double hyphens, which XML comments must not contain."""
    return text.replace("--", "- -")


def _suggested_beam(description: RobotDescription, span: LinkSpan) -> str:
    """Return the ``<beam>`` suggested for a link; empty if the link has a beam, or if no tube of its mass is a valid beam."""
    tube = span.tube
    if tube is None or span.link in description.beams:
        return ""
    modulus, ratio, _ = MATERIALS[MATERIAL]
    start, end = (BeamEnd(name) if name else None for name in (span.start, span.end))
    beam = Beam(span.link, Tube.of(*tube), Material(modulus, ratio), start, end)
    try:
        _ = Robot(description.with_part(beam)).beams
    except KinetostaticsError:
        return ""
    sizes = f'outer_diameter="{tube[0]:g}" inner_diameter="{tube[1]:g}"'
    return _beam_element(span, MATERIAL, f"<tube {sizes}/>")


def _beam_text(description: RobotDescription, candidates: Mapping[str, LinkSpan], link: str, text: str) -> str:
    if link not in description.links:
        raise ArgumentError(f"elastic: no link {link!r}: {near_names(link, description.links)}")
    if link == description.platform and (tip := _platform_advice(description)):
        raise ArgumentError(f"elastic: {tip}")
    if link not in candidates:
        between = ", ".join(map(repr, candidates)) or "none"
        raise ArgumentError(
            f"elastic: {link!r} is not between two moving joints of the chain from base to platform; these are: {between}"
        )
    section = parse_section(text, f"elastic, {link}")
    span = candidates[link]
    sizes = " ".join(f'{name}="{value:g}"' for name, value in zip(SHAPES[section.shape], section.sizes.values(), strict=True))
    more = ""
    if section.shape.startswith("rect"):
        more += f' y_axis="{" ".join(f"{value + 0.0:.12g}" for value in span.y_axis)}"'
    if span.mass <= 0:
        more += f' density="{MATERIALS[section.material][2]:g}"'
    return _beam_element(span, section.material, f"<{section.shape} {sizes}/>", more)


def _platform_advice(description: RobotDescription) -> str:
    """Return advice on making the platform's link elastic; empty unless a moving joint carries this link."""
    joint = next((joint for joint in description.joints.values() if joint.child == description.platform), None)
    if joint is None or JOINT_TYPES[joint.type].is_fixed or description.loops:
        return ""
    link = quoted(description.platform)
    return (
        f"{description.platform!r} is the platform, which is rigid; end it in a link of its own, which then is the platform: "
        f'<link name="tool"/><joint name="tool_joint" type="fixed"><parent link={link}/><child link="tool"/>'
        '<origin xyz="X Y Z"/></joint>'
    )


def _beam_element(span: LinkSpan, material: str, section: str, more: str = "") -> str:
    modulus, ratio, _ = MATERIALS[material]
    ends = f" from={quoted(span.start)} to={quoted(span.end)}" if span.start else ""
    return (
        f"  <beam link={quoted(span.link)}{ends}"
        f' youngs_modulus="{modulus / 1e9:g}e9" poisson_ratio="{ratio:g}"{more}>\n'
        f"    {section}\n  </beam>\n"
    )


# ---- joint stiffness ---------------------------------------------------------------------------------------------------


def _stiffness_text(description: RobotDescription, given: Mapping[str, float] | str | None) -> str:
    actuators = [description.joints[name] for name in description.actuated if name in description.joints]
    there = description.joint_stiffness
    suggested = {joint.name: _suggested_stiffness(joint) for joint in actuators if joint.effort > 0 and joint.name not in there}
    if given == SUGGESTED:
        chosen = dict(suggested)
        if not chosen:
            raise ArgumentError("joint_stiffness: stiffnesses are estimated from efforts, which the file lacks; give numbers")
    elif isinstance(given, str):
        raise ArgumentError(f"joint_stiffness is {given!r}; it is {SUGGESTED!r}, or numbers by joint: {{'elbow': 3e4}}")
    else:
        chosen = {str(name): _checked_stiffness(description, name, value) for name, value in (given or {}).items()}
    result = ""
    if chosen:
        result += "\n  <!-- elastic actuators and gears [N m/rad, N/m] -->\n"
        result += "".join(f"  {_stiffness_element(name, value)}\n" for name, value in chosen.items())
    possible = [joint for joint in actuators if joint.name in suggested and joint.name not in chosen]
    if possible:
        result += (
            "\n  <!-- Possible stiffnesses of actuators [N m/rad, N/m]: their largest effort in the file deflects them by\n"
            f"       {TURN * 1e3:g} mrad or {SLIDE * 1e3:g} mm. Data sheets of gears are more precise. -->\n"
        )
        result += "".join(
            f"  <!-- {_comment_text(_stiffness_element(joint.name, suggested[joint.name]))} effort {joint.effort:g} "
            f"{JOINT_TYPES[joint.type].force_unit.replace('·', ' ')} -->\n"
            for joint in possible
        )
    return result


def _suggested_stiffness(joint: Joint) -> float:
    """Return the stiffness [N/m, N·m/rad], to two digits, that the joint's effort deflects by ``SLIDE`` or ``TURN``."""
    moved = SLIDE if JOINT_TYPES[joint.type].is_slide else TURN
    return float(f"{joint.effort / moved:.2g}")


def _checked_stiffness(description: RobotDescription, name: str, value: object) -> float:
    if name not in description.actuated:
        raise ArgumentError(f"joint_stiffness: no actuator {name!r}: {near_names(str(name), description.actuated)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < float("inf"):
        raise ArgumentError(f"joint_stiffness of {name!r} is {value!r}; it must be a number greater than zero, in N·m/rad or N/m")
    return float(value)


def _stiffness_element(name: str, value: float) -> str:
    return f'<joint_stiffness joint={quoted(name)} drive="{value:.12g}"/>'
