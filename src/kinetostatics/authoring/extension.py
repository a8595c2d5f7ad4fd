"""A plain URDF extended: a small xacro that includes it as it is and adds platform, actuators and what is elastic."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace

from kinetostatics.argument_checks import check_mapping, path_name
from kinetostatics.authoring.materials import MATERIALS, SHAPES, parse_section
from kinetostatics.authoring.robot_by_name import write_new
from kinetostatics.authoring.spans import MATERIAL, WALL, Span, spans, way
from kinetostatics.description.elements import Beam, BeamEnd, Joint, Material
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import ArgumentError, KinetostaticsError, near_names
from kinetostatics.files.importers.loop_record import SourceRobot
from kinetostatics.files.inclusion import include_path, including_text, quoted, read_root, whole_text
from kinetostatics.files.plain_urdf import drivable, first_base
from kinetostatics.files.reader import parse_robot_text, read_robot_file
from kinetostatics.files.xml import Element
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Tube

#: How far a suggested actuator gives under its largest force: 5 mrad, as the gears of arms do, or 0.5 mm.
TURN, SLIDE = 5e-3, 5e-4
#: Stands for all that the file suggests.
SUGGESTED = "suggested"


def extend_robot(
    source: str | os.PathLike[str],
    path: str | os.PathLike[str] | None = None,
    *,
    platform: str | None = None,
    base: str | None = None,
    driven: Iterable[str] | None = None,
    elastic: Mapping[str, str] | str | None = None,
    joint_stiffness: Mapping[str, float] | str | None = None,
    parameters: Mapping[str, object] | None = None,
) -> Robot:
    """Extend a URDF that says nothing of platform, actuators and elastic parts, by a small xacro that includes it as it is.

    The xacro suggests, in comments and with numbers from the file, which other links could be beams (the distance of their joints
    and their mass) and how stiff actuators could be (their largest effort).

    Args:
        source: the URDF or xacro, without loops of other tools.
        path: where the new file is written; None: nowhere. A file that is there is not replaced.
        platform: the link that is the moving platform; None if the file says it.
        base: the link that stands still; None: as the file says, or the root of its tree.
        driven: joints that are driven besides those with a ``<transmission>``; None: all others that move, if the file has no
            loops. Joints that hang beside the way from base to platform, as a gripper's, are held all the same.
        elastic: sections and materials of links that are beams, such as ``{"upper_arm": "tube 60mm 50mm steel"}``; each is a
            straight beam between the two joints that move beside it. "suggested": all that the file suggests. A beam weighs what
            the link's ``<inertial>`` says; if it says nothing, what its material weighs.
        joint_stiffness: stiffnesses of actuators [N·m/rad, or N/m of slides], such as ``{"elbow": 3e4}``. "suggested": as in
            the comments.
        parameters: values of the source's xacro arguments.

    Returns:
        The robot, loaded from the new text. :func:`extension_text` returns the text itself.

    Raises:
        ArgumentError: a link, joint, section or stiffness is invalid.
        RobotFileError: the source is wrong.
    """
    name = os.fspath(source)
    beside = os.path.join(os.path.dirname(name), f"<extension of {os.path.basename(name)}>")
    out = beside if path is None else path_name("path", path)
    text, includes = _extension(name, out, platform, base, driven, elastic, joint_stiffness, parameters or {})
    robot = Robot(parse_robot_text(text, out, parameters if includes else None))
    _ = robot.beams  # which complain where one cannot lie between its joints
    if path is not None:
        write_new(text, path)
    return robot


def extension_text(
    source: str | os.PathLike[str],
    *,
    platform: str | None = None,
    base: str | None = None,
    driven: Iterable[str] | None = None,
    elastic: Mapping[str, str] | str | None = None,
    joint_stiffness: Mapping[str, float] | str | None = None,
    parameters: Mapping[str, object] | None = None,
) -> str:
    """Return the text that :func:`extend_robot` writes, for a file in the working folder; the arguments are the same."""
    return _extension(os.fspath(source), "", platform, base, driven, elastic, joint_stiffness, parameters or {})[0]


def _extension(
    source: str,
    out: str,
    platform: str | None,
    base: str | None,
    driven: Iterable[str] | None,
    elastic: Mapping[str, str] | str | None,
    joint_stiffness: Mapping[str, float] | str | None,
    parameters: Mapping[str, object],
) -> tuple[str, bool]:
    """Return the text, and whether it includes the source."""
    root, name, uses_xacro = read_root(source, parameters)
    has_platform = bool(root.named("platform"))
    if has_platform and platform is not None:
        raise ArgumentError(f"platform={platform!r}: {name} names its platform already; leave the argument out")
    if base is not None and root.named("base"):
        raise ArgumentError(f"base={base!r}: {name} names its base already; leave the argument out")
    description = read_robot_file(name, parameters, platform=platform, base=base)
    held = SourceRobot(name, root, description.links, description.joints)
    candidates = spans(description, held.zero_frames)
    actuators, holding = _actuators(root, description, driven)
    known = replace(description, driven=tuple(dict.fromkeys((*description.driven, *actuators, *holding))))
    parts = [
        "  <!-- results refer to the origin and the axes of this link -->\n",
        "" if has_platform else f"  <platform link={quoted(description.platform)}/>\n",
        f"  <base link={quoted(description.base)}/>\n" if base is not None or _floats(description) else "",
        _actuators_text(actuators, "actuators: joints that move and have no transmission in the file; their brakes hold"),
        _actuators_text(holding, "joints beside the way from base to platform, as a gripper's: they hold what hangs there"),
        _beams_text(known, candidates, elastic),
        _stiffness_text(known, joint_stiffness),
    ]
    additions = "".join(parts)
    include = include_path(name, root, uses_xacro, additions, out)
    if include is None:
        return whole_text(root, additions), False
    comment = f"{os.path.basename(name)} as it is, and what the statics need; comments suggest the rest, in m, kg, N and rad"
    return including_text(description.name, include, _safe(comment), additions), True


def _floats(description: RobotDescription) -> bool:
    """Return whether the base is not the root of the tree, but hangs on it by a joint that holds nothing."""
    children = {joint.child for joint in description.joints.values()}
    tree = next(name for name in description.links if name not in children)
    return description.base != tree and description.base == first_base(tree, description.joints)


# ---- actuators ------------------------------------------------------------------------------------------------------------


def _actuators(root: Element, description: RobotDescription, driven: Iterable[str] | None) -> tuple[list[str], list[str]]:
    """Return the joints that get a transmission, and those that get one because nothing else would hold what hangs on them."""
    there = {entry.attributes.get("name", "") for item in root.named("transmission") for entry in item.named("joint")}
    if driven is None:
        return [] if description.loops else [name for name in drivable(description.joints) if name not in there], []
    if isinstance(driven, str) or not isinstance(driven, Iterable):
        raise ArgumentError(f"driven is {driven!r}; it must be a list of joints")
    names = list(dict.fromkeys(driven))
    known = {**description.joints, **description.loops}
    for name in names:
        if name not in known:
            raise ArgumentError(f"driven: no joint {name!r}: {near_names(str(name), known)}")
    passed = {joint.name for joint, _ in way(description)}
    beside = [] if description.loops else [name for name in drivable(description.joints) if name not in passed]
    holding = [name for name in beside if name not in there and name not in names]
    return [name for name in names if name not in there], holding


def _actuators_text(names: list[str], comment: str) -> str:
    if not names:
        return ""
    lines = [f"  <transmission name={quoted(f'drive_{name}')}><joint name={quoted(name)}/></transmission>\n" for name in names]
    return f"\n  <!-- {comment} -->\n" + "".join(lines)


# ---- beams -------------------------------------------------------------------------------------------------------------


def _beams_text(description: RobotDescription, candidates: Mapping[str, Span], elastic: Mapping[str, str] | str | None) -> str:
    suggested = {link: text for link, span in candidates.items() if (text := _suggestion(description, span))}
    if elastic == SUGGESTED:
        wanted = {link: "" for link in suggested}
        if not wanted:
            raise ArgumentError("elastic: no link of the file could be a beam as far as its numbers tell; name some yourself")
    elif isinstance(elastic, str):
        raise ArgumentError(
            f"elastic is {elastic!r}; it is {SUGGESTED!r}, or sections by link: {{'upper_arm': 'tube 60mm 50mm steel'}}"
        )
    else:
        wanted = dict(elastic or {})
        check_mapping("elastic", wanted, '{"upper_arm": "tube 60mm 50mm steel"}')
    written = [suggested[link] if not text else _beam_text(description, candidates, link, text) for link, text in wanted.items()]
    rest = [link for link in suggested if link not in wanted]
    result = ""
    if written:
        result += (
            "\n  <!-- elastic links: straight beams between two joints; each link keeps its mass and its centre of mass -->\n"
        )
        result += "".join(written)
    if rest:
        result += (
            f"\n  <!-- Links that could be beams, as tubes of {MATERIAL} with the link's mass and a wall of {WALL:g} of their\n"
            "       diameter: measure your own, and take the beam out of its comment. -->\n"
        )
        for span in (candidates[link] for link in rest):
            remark = f"{span.link}: {span.length:.3g} m between its joints, {span.mass:.3g} kg"
            result += f"  <!-- {_safe(remark)}\n{_safe(suggested[span.link])}  -->\n"
    return result


def _safe(text: str) -> str:
    """Return a text that may stand in a comment."""
    return text.replace("--", "- -")


def _suggestion(description: RobotDescription, span: Span) -> str:
    """Return the beam that a link could be; nothing where it could not."""
    tube = span.tube
    if tube is None or span.link in description.beams:
        return ""
    modulus, ratio, _ = MATERIALS[MATERIAL]
    beam = Beam(span.link, Tube.of(*tube), Material(modulus, ratio), BeamEnd(span.start), BeamEnd(span.end))
    try:
        _ = Robot(description.with_part(beam)).beams
    except KinetostaticsError:
        return ""
    sizes = f'outer_diameter="{tube[0]:g}" inner_diameter="{tube[1]:g}"'
    return _element(span, MATERIAL, f"<tube {sizes}/>")


def _beam_text(description: RobotDescription, candidates: Mapping[str, Span], link: str, text: str) -> str:
    """Return the beam that was asked for."""
    if link not in description.links:
        raise ArgumentError(f"elastic: no link {link!r}: {near_names(link, description.links)}")
    if link not in candidates:
        between = ", ".join(map(repr, candidates)) or "none"
        raise ArgumentError(
            f"elastic: {link!r} does not lie between two joints that move on the way from base to platform; these do: {between}"
        )
    section = parse_section(text, f"elastic, {link}")
    span = candidates[link]
    sizes = " ".join(f'{name}="{value:g}"' for name, value in zip(SHAPES[section.shape], section.sizes.values(), strict=True))
    more = ""
    if section.shape.startswith("rect"):
        more += f' y_axis="{" ".join(f"{value + 0.0:.12g}" for value in span.y_axis)}"'
    if span.mass <= 0:
        more += f' density="{MATERIALS[section.material][2]:g}"'
    return _element(span, section.material, f"<{section.shape} {sizes}/>", more)


def _element(span: Span, material: str, section: str, more: str = "") -> str:
    modulus, ratio, _ = MATERIALS[material]
    return (
        f"  <beam link={quoted(span.link)} from={quoted(span.start)} to={quoted(span.end)}"
        f' youngs_modulus="{modulus / 1e9:g}e9" poisson_ratio="{ratio:g}"{more}>\n'
        f"    {section}\n  </beam>\n"
    )


# ---- joint stiffness ---------------------------------------------------------------------------------------------------


def _stiffness_text(description: RobotDescription, given: Mapping[str, float] | str | None) -> str:
    actuators = [description.joints[name] for name in description.driven if name in description.joints]
    there = description.joint_stiffness
    suggested = {joint.name: _actuator_stiffness(joint) for joint in actuators if joint.effort > 0 and joint.name not in there}
    if given == SUGGESTED:
        wanted = dict(suggested)
        if not wanted:
            raise ArgumentError(
                "joint_stiffness: no actuator of the file has an effort that would tell how stiff it may be; give numbers"
            )
    elif isinstance(given, str):
        raise ArgumentError(f"joint_stiffness is {given!r}; it is {SUGGESTED!r}, or numbers by joint: {{'elbow': 3e4}}")
    else:
        wanted = {str(name): _positive(description, name, value) for name, value in (given or {}).items()}
    result = ""
    if wanted:
        result += "\n  <!-- elastic actuators and gears, in N m/rad, slides in N/m -->\n"
        result += "".join(_stiffness(name, value) + "\n" for name, value in wanted.items())
    rest = [joint for joint in actuators if joint.name in suggested and joint.name not in wanted]
    if rest:
        result += (
            "\n  <!-- How stiff actuators could be, in N m/rad, slides in N/m: as if their effort, the largest force\n"
            f"       that the file has, moved them by {TURN * 1e3:g} mrad or {SLIDE * 1e3:g} mm. Makers of gears say more. -->\n"
        )
        result += "".join(
            f"  <!-- {_safe(_stiffness(joint.name, suggested[joint.name]).strip())} effort {joint.effort:g} {_unit(joint)} -->\n"
            for joint in rest
        )
    return result


def _unit(joint: Joint) -> str:
    return JOINT_TYPES[joint.type].force_unit.replace("·", " ")


def _actuator_stiffness(joint: Joint) -> float:
    return float(f"{joint.effort / (SLIDE if JOINT_TYPES[joint.type].is_slide else TURN):.2g}")


def _positive(description: RobotDescription, name: str, value: object) -> float:
    if name not in description.driven:
        raise ArgumentError(f"joint_stiffness: no actuator {name!r}: {near_names(str(name), description.driven)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < float("inf"):
        raise ArgumentError(f"joint_stiffness of {name!r} is {value!r}; it must be a number greater than zero, in N·m/rad or N/m")
    return float(value)


def _stiffness(name: str, value: float) -> str:
    return f'  <joint_stiffness joint={quoted(name)} drive="{value:.12g}"/>'
