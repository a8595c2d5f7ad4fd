"""From a URDF with another tool's loops to a robot file of this package, and to its description."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from kinetostatics.argument_checks import path_name
from kinetostatics.description.elements import Loop, Origin, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.importers import gepetto, isaac, onshape
from kinetostatics.files.importers.answers import Actuators, Answers, complete
from kinetostatics.files.importers.loop_record import ForeignLoop, SourceRobot
from kinetostatics.files.inclusion import include_path, including_text, quoted, read_root, whole_text
from kinetostatics.files.plain_urdf import drivable
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.files.urdf import read_joints, read_links, tree_root
from kinetostatics.files.xml import Element


@dataclass(frozen=True)
class Conversion:
    """A robot file made from another tool's.

    Attributes:
        text: the file: a xacro that includes the source, or a whole URDF where that is not possible.
        loops: the loops in it.
        includes_source: whether it includes the source.
        warnings: what is suspicious, in full sentences.
        path: where it was taken to lie, which is what its paths are relative to.
    """

    text: str
    loops: tuple[Loop, ...]
    includes_source: bool
    warnings: tuple[str, ...]
    path: str


def import_robot(
    path: str | os.PathLike[str],
    yaml: str | os.PathLike[str] | None = None,
    *,
    platform: str | None = None,
    base: str | None = None,
    types: Mapping[str, str] | str | None = None,
    axes: Mapping[str, object] | None = None,
    driven: Iterable[str] | None = None,
    parameters: Mapping[str, object] | None = None,
) -> RobotDescription:
    """Read a URDF whose loops another tool has described: onshape-to-robot, Gepetto's ``robot.yaml``, or Isaac Sim.

    Nothing is guessed: what neither the source nor an argument says is asked for, all of it in one error.
    ``kinetostatics.Robot(description)`` makes a robot of the result.

    Args:
        path: the URDF (or xacro), which may have closing frames of onshape-to-robot and ``<loop_joint>``.
        yaml: a ``robot.yaml`` of Gepetto's.
        platform: the link that is the moving platform.
        base: the base link, if it is not the root of the tree.
        types: the joints that close the loops, ``{loop: type}`` with the types of ``<loop>``, or one type for all loops of
            which the source does not say it.
        axes: ``{loop: (x, y, z)}``, the joint's axis in the loop's frame on its predecessor; for universal two of them, the
            second in the frame on the successor.
        driven: the driven joints and loops; an empty list for none.
        parameters: values of the source's xacro arguments.

    Returns:
        The description of the robot.

    Raises:
        MissingFactsError: something more must be said; a ``KinetostaticsError`` whose message lists all of it.
        RobotFileError: the source or the YAML is wrong; the message names file and line.
        ArgumentError: an argument has an invalid value or shape.
    """
    name = path_name("path", path)
    beside = os.path.join(os.path.dirname(name), f"<import of {os.path.basename(name)}>")
    answers = Answers(platform, base, types, axes, driven)
    made = convert(name, yaml, answers, parameters=parameters, out=beside)
    description = describe(made, parameters)
    # there is no file between the source and the description, so that messages about a loop name the source
    places = {loop.name: loop.place for loop in made.loops}
    loops = {key: replace(loop, place=places.get(key, loop.place)) for key, loop in description.loops.items()}
    return replace(description, loops=loops)


def describe(made: Conversion, parameters: Mapping[str, object] | None = None) -> RobotDescription:
    """Return the description of a converted robot, with the warnings of the conversion."""
    description = parse_robot_text(made.text, made.path, parameters if made.includes_source else None)
    return replace(description, file_warnings=(*description.file_warnings, *made.warnings))


def convert(
    path: str | os.PathLike[str],
    yaml: str | os.PathLike[str] | None,
    answers: Answers,
    *,
    parameters: Mapping[str, object] | None = None,
    out: str | os.PathLike[str],
) -> Conversion:
    """Return the robot file for a source, see :func:`import_robot`.

    Args:
        path, yaml, parameters: as there.
        answers: what the caller says.
        out: where the file will lie.

    Raises:
        As :func:`import_robot`.
    """
    source, uses_xacro = _read_source(path, {} if parameters is None else parameters)
    loops, actuators, retyped, warnings = _find(source, yaml)
    if retyped:
        before, source = source, _tables(source.path, gepetto.retype(source, retyped))
        source = replace(source, made=frozenset(source.links) - frozenset(before.links))
    closed, driven, more = complete(source, loops, actuators, answers)
    additions = _additions(answers, closed, driven)
    include = None if retyped else include_path(source.path, source.root, uses_xacro, additions, os.fsdecode(out))
    if include is not None:
        comment = "a URDF as it is, and what it does not say in a form that we read"
        text = including_text(source.root.attributes.get("name", ""), include, comment, additions)
    else:
        text = whole_text(source.root, additions)
    return Conversion(text, closed, include is not None, (*warnings, *more), os.fsdecode(out))


def _read_source(path: str | os.PathLike[str], parameters: Mapping[str, object]) -> tuple[SourceRobot, bool]:
    root, name, uses_xacro = read_root(path, parameters)
    return _tables(name, root), uses_xacro


def _tables(path: str, root: Element) -> SourceRobot:
    warnings: list[str] = []  # the same will come up when the new file is read
    links = read_links(root, warnings)
    joints = read_joints(root, links, warnings)
    tree_root(links, joints)
    return SourceRobot(path, root, links, joints)


def _find(
    source: SourceRobot, yaml: str | os.PathLike[str] | None
) -> tuple[list[ForeignLoop], Actuators, tuple[gepetto.Retyped, ...], tuple[str, ...]]:
    """Return all loops that the three readers find, and what else the YAML says."""
    entries = [entry for element in source.root.named("transmission") for entry in element.named("joint")]
    transmissions = tuple(dict.fromkeys(entry.attributes.get("name", "") for entry in entries))
    if yaml is None:
        loops = [*onshape.read(source), *isaac.read(source)]
        if not loops:  # nothing else than an actuator could hold a joint
            driven = tuple(dict.fromkeys((*transmissions, *drivable(source.joints))))
            return [], Actuators(driven, transmissions), (), (_without_loops(source),)
        return loops, Actuators(None, transmissions), (), ()
    said = gepetto.read(source, yaml)
    loops = [*said.loops, *onshape.read(source, said.frames), *isaac.read(source)]
    if not loops:
        raise RobotFileError("there is no closed_loop, and the URDF has no loops either", os.fsdecode(yaml))
    named = None if said.driven is None else gepetto.driven_after(said.driven, said.retyped)
    return loops, Actuators(named, transmissions, said.driven_note), said.retyped, said.warnings


def _without_loops(source: SourceRobot) -> str:
    """Return what to say of a source without loops.

    Raises:
        RobotFileError: it has loops of this package, or a robot.yaml beside it that may have some.
    """
    if source.root.named("loop"):
        raise RobotFileError("its loops are in this package's format already; load it as it is", source.path)
    reason = "there are no loops to import: no links closing_…_1 and closing_…_2, no <loop_joint>, and no robot.yaml was given"
    beside = os.path.join(os.path.dirname(source.path), "robot.yaml")
    if os.path.isfile(beside):
        raise RobotFileError(f"{reason}; is {beside!r} meant as well?", source.path)
    return (
        f"{source.path}: {reason}. It is taken as a robot without loops, all of whose joints are driven; "
        "`kinetostatics new --from` makes the same file and suggests beams and stiffnesses, too."
    )


def _additions(answers: Answers, loops: Iterable[Loop], driven: Iterable[str]) -> str:
    """Return the elements that the source lacks."""
    links = {"platform": answers.platform, "base": answers.base}
    lines = [f"  <{tag} link={quoted(link)}/>\n" for tag, link in links.items() if link is not None]
    for loop in loops:
        lines.append(f"  <loop name={quoted(loop.name)} type={quoted(loop.type)}>\n")
        lines.append(_side("predecessor", loop.predecessor, loop.predecessor_origin))
        lines.append(_side("successor", loop.successor, loop.successor_origin))
        if JOINT_TYPES[loop.type].has_axis:
            lines.append(f'    <axis xyz="{_numbers(loop.axis)}"/>\n')
        if JOINT_TYPES[loop.type].turns is Axes.BOTH:
            lines.append(f'    <axis2 xyz="{_numbers(loop.axis2)}"/>\n')
        lines.append("  </loop>\n")
    for name in driven:
        lines.append(f"  <transmission name={quoted(f'drive_{name}')}><joint name={quoted(name)}/></transmission>\n")
    return "".join(lines)


def _side(tag: str, link: str, origin: Origin) -> str:
    where = "" if origin == Origin() else f'<origin xyz="{_numbers(origin.xyz)}" rpy="{_numbers(origin.rpy)}"/>'
    head = f"    <{tag} link={quoted(link)}"
    return f"{head}>{where}</{tag}>\n" if where else f"{head}/>\n"


def _numbers(vector: Vector) -> str:
    return " ".join(repr(float(item) + 0.0) for item in vector)
