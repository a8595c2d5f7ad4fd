"""Puts together what a source says of its loops and actuators and what the caller adds, and asks for what is still missing.

All that is missing is asked for in one message, which names the exact arguments to give.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from kinetostatics.description.elements import Loop, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.exceptions import ArgumentError, KinetostaticsError, near_names
from kinetostatics.files.importers import onshape
from kinetostatics.files.importers.loop_record import ForeignLoop, SourceRobot

#: How many names a question lists.
MAX_NAMES = 30

Item = TypeVar("Item")


@dataclass(frozen=True)
class Question:
    """One missing fact.

    Attributes:
        argument: of :func:`kinetostatics.import_robot` that takes the answer; the command's option has the same name.
        loop: the loop it is about; empty if it is about the robot.
        python, option: the form of the answer in Python and on the command line.
        what: what is wanted, and what the choice is.
    """

    argument: str
    loop: str
    python: str
    option: str
    what: str


class MissingFactsError(KinetostaticsError):
    """A source does not say everything that a robot file needs; the message lists all of it.

    Attributes:
        source: path of the source.
        questions: what is missing.
    """

    def __init__(self, source: str, questions: Sequence[Question]) -> None:
        self.source, self.questions = source, tuple(questions)
        super().__init__(self._message(_in_python))

    @property
    def for_command_line(self) -> str:
        """The message with the options of ``kinetostatics import`` instead of Python's arguments."""
        return self._message(_as_option)

    def _message(self, spelled: Callable[[Sequence[Question]], str]) -> str:
        lines = [f"{self.source} does not say everything; give also"]
        for argument in dict.fromkeys(question.argument for question in self.questions):
            asked = [question for question in self.questions if question.argument == argument]
            lines.append(f"  {spelled(asked)}")
            lines.extend(f"      {question.what}" for question in asked)
        return "\n".join(lines)


def _in_python(asked: Sequence[Question]) -> str:
    names = [json.dumps(question.loop, ensure_ascii=False) for question in asked]
    entries = ", ".join(f"{name}: {item.python}" if item.loop else item.python for name, item in zip(names, asked, strict=True))
    return f"{asked[0].argument}=" + (f"{{{entries}}}" if asked[0].loop else entries)


def _as_option(asked: Sequence[Question]) -> str:
    entries = " ".join(_quoted(f"{question.loop}={question.option}") if question.loop else question.option for question in asked)
    return f"--{asked[0].argument} {entries}"


def _quoted(item: str) -> str:
    """Return an item of the command line, in quotes if a shell would split or change it."""
    return item if all(character.isalnum() or character in "_-.=,:/" for character in item) else f"'{item}'"


def listed(names: Iterable[str]) -> str:
    """Return names in a row, shortened if there are very many."""
    names = list(names)
    return ", ".join(names[:MAX_NAMES]) + (", …" if len(names) > MAX_NAMES else "")


@dataclass(frozen=True)
class Answers:
    """What the caller says; the arguments of :func:`kinetostatics.import_robot`."""

    platform: str | None = None
    base: str | None = None
    types: Mapping[str, str] | str | None = None
    axes: Mapping[str, object] | None = None
    driven: Iterable[str] | None = None


@dataclass(frozen=True)
class Actuators:
    """What a source says of its actuators.

    Attributes:
        named: joints that its other file says to be driven, or None if there is none that says so.
        transmissions: joints that its ``<transmission>`` elements name; these stay in the file whatever else is said.
        note: what a question about actuators should mention.
    """

    named: tuple[str, ...] | None
    transmissions: tuple[str, ...]
    note: str = ""


def complete(
    source: SourceRobot, found: Sequence[ForeignLoop], actuators: Actuators, answers: Answers
) -> tuple[tuple[Loop, ...], tuple[str, ...], list[str]]:
    """Return what source and caller say together: loops, the driven joints without a ``<transmission>``, and warnings.

    Raises:
        MissingFactsError: something is said by neither.
        ArgumentError: an answer is invalid.
        RobotFileError: two loops have the same name, or a loop and a joint.
    """
    _check_names(source, found)
    warnings: list[str] = []
    questions: list[Question] = []
    _check_links(source, answers, questions)
    types = _types(found, answers.types, questions, warnings)
    axes = _axes(found, types, answers.axes, questions, warnings)
    movable = [joint.name for joint in source.joints.values() if JOINT_TYPES[joint.type].is_single]
    movable += [loop.name for loop in found if types[loop.name] in (*names_of("is_single"), None)]
    driven = _driven(source, movable, actuators, answers.driven, questions, warnings)
    if questions:
        raise MissingFactsError(source.path, questions)
    loops = tuple(_loop(item, types[item.name] or "", axes[item.name]) for item in found)
    warnings.extend(filter(None, (_turned(source, loop) for loop in loops)))
    return loops, driven, warnings


def _check_names(source: SourceRobot, found: Sequence[ForeignLoop]) -> None:
    places = {joint.name: joint.place for joint in source.joints.values()}
    for loop in found:
        other = places.setdefault(loop.name, loop.place)
        if other is not loop.place:
            raise loop.place.error(f"the loop's name {loop.name!r} is taken already, in {other}; rename one of them")
        if loop.predecessor == loop.successor:
            raise loop.place.error(f"both frames of the loop {loop.name!r} are on the link {loop.predecessor!r}")


def _check_links(source: SourceRobot, answers: Answers, questions: list[Question]) -> None:
    """Check platform and base, which are given where the source itself does not have these elements."""
    for argument, link in (("platform", answers.platform), ("base", answers.base)):
        written = source.root.child(argument)
        if link is not None and written is not None:
            raise ArgumentError(f"{argument} is given as {link!r}, but the source has a <{argument}> already, in {written.place}")
        if link is not None and link not in source.links:
            raise ArgumentError(f"{argument}: there is no link {link!r}; {near_names(link, source.links)}")
    if answers.platform is None and source.root.child("platform") is None:
        bodies = (link for link in source.links if link not in source.made and not onshape.MARK.fullmatch(link))
        links = listed(link for link in bodies if link in source.parent_joints)
        questions.append(Question("platform", "", '"LINK"', "LINK", f"the moving platform, one of the links {links}"))
    root = next((link for link in source.links if link not in source.parent_joints), None)
    if answers.platform is not None and answers.platform == (answers.base or root):
        raise ArgumentError(f"the link {answers.platform!r} cannot be both base and platform")


def _where(loop: ForeignLoop) -> str:
    return f"{loop.name} ({loop.place}), which joins {loop.predecessor} and {loop.successor}"


def _types(
    found: Sequence[ForeignLoop], given: Mapping[str, str] | str | None, questions: list[Question], warnings: list[str]
) -> dict[str, str | None]:
    """Return the loops' types; None where one is asked for."""
    if isinstance(given, str):  # one type for all loops that have none
        given = {loop.name: given for loop in found if loop.type is None}
    given = _by_loop("types", given, found)
    types: dict[str, str | None] = {}
    known = names_of("in_loop")
    for loop in found:
        kind = given.get(loop.name)
        if kind is not None and kind not in known:
            raise ArgumentError(f"types: {loop.name!r} cannot be {kind!r}; {near_names(str(kind), known)}")
        if kind is not None and loop.type not in (None, kind):
            warnings.append(
                f"{loop.place}: the loop {loop.name!r} is taken as {kind}, as asked for; the source says {loop.type}."
            )
        types[loop.name] = kind or loop.type
        if types[loop.name] is None:
            what = f"the type of {_where(loop)}, one of {', '.join(known)}"
            questions.append(Question("types", loop.name, '"TYPE"', "TYPE", what))
    return types


def _axes(
    found: Sequence[ForeignLoop],
    types: Mapping[str, str | None],
    given: Mapping[str, object] | None,
    questions: list[Question],
    warnings: list[str],
) -> dict[str, tuple[Vector, ...]]:
    """Return the axes of the loops that have any, as unit vectors."""
    given = _by_loop("axes", given, found)
    axes: dict[str, tuple[Vector, ...]] = {}
    for loop in found:
        kind, answer = types[loop.name], given.get(loop.name)
        count = 2 if kind is not None and JOINT_TYPES[kind].turns is Axes.BOTH else 1
        if kind is not None and not JOINT_TYPES[kind].has_axis:
            if answer is not None:
                raise ArgumentError(f"axes: the loop {loop.name!r} is {kind} and has no axis")
            axes[loop.name] = ()
        elif answer is not None:
            axes[loop.name] = _unit_vectors(loop.name, answer, count, kind)
            if loop.axis is not None and count == 1 and np.abs(np.subtract(axes[loop.name][0], loop.axis)).max() > 1e-9:
                warnings.append(
                    f"{loop.place}: the loop {loop.name!r} has the axis that was asked for; the source says {loop.axis}."
                )
        elif loop.axis is not None and count == 1:
            axes[loop.name] = (loop.axis,)
        elif kind is not None:
            questions.append(_axis_question(loop, kind, count))
    return axes


def _axis_question(loop: ForeignLoop, kind: str, count: int) -> Question:
    note = f"; {loop.note}" if loop.note else ""
    name = "both axes" if count == 2 else "the normal" if JOINT_TYPES[kind].slides is Axes.ACROSS else "the axis"
    what = f"{name} of the {kind} joint {_where(loop)}: in its frame on {loop.predecessor}"
    if count == 2:
        return Question("axes", loop.name, "((X, Y, Z), (X, Y, Z))", "X,Y,Z/X,Y,Z", f"{what} and on {loop.successor}{note}")
    return Question("axes", loop.name, "(X, Y, Z)", "X,Y,Z", what + note)


def _by_loop(argument: str, given: Mapping[str, Item] | None, found: Sequence[ForeignLoop]) -> Mapping[str, Item]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise ArgumentError(f"{argument} must be a dict with the loops' names as keys, not {type(given).__name__}")
    names = [loop.name for loop in found]
    for name in given:
        if name not in names:
            raise ArgumentError(f"{argument}: there is no loop {name!r}; {near_names(str(name), names)}")
    return given


def _unit_vectors(name: str, value: object, count: int, kind: str | None) -> tuple[Vector, ...]:
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        array = np.zeros(0)
    wanted = "three numbers" if count == 1 else "two axes of three numbers each"
    if array.shape != ((3,) if count == 1 else (2, 3)) or not np.isfinite(array).all():
        raise ArgumentError(f"axes: {name!r}{f' is {kind} and' if kind else ''} needs {wanted}, not {value!r}")
    rows = []
    for row in array.reshape(-1, 3):
        largest = np.abs(row).max()
        if largest == 0:
            raise ArgumentError(f"axes: an axis of {name!r} is zero; it must point somewhere")
        x, y, z = (float(item) for item in row / largest / math.hypot(*(row / largest)))
        rows.append((x, y, z))
    return tuple(rows)


def _driven(
    source: SourceRobot,
    movable: Sequence[str],
    actuators: Actuators,
    given: Iterable[str] | None,
    questions: list[Question],
    warnings: list[str],
) -> tuple[str, ...]:
    if given is not None:
        chosen = _given_actuators(given, movable)
        if actuators.named is not None and set(chosen) != set(actuators.named):
            said = listed(actuators.named) or "none"
            warnings.append(f"{source.path}: the driven joints are those that were asked for; the source says {said}.")
    elif actuators.named is not None:
        chosen = actuators.named
    elif actuators.transmissions:
        chosen = actuators.transmissions
    else:
        note = f"; {actuators.note}" if actuators.note else ""
        what = f"the driven joints, none or some of {listed(movable)}{note}"
        questions.append(Question("driven", "", '["JOINT", …]', "JOINT …", what))
        return ()
    for name in actuators.transmissions:
        if name not in chosen:
            raise ArgumentError(f"driven: {name!r} is not among them, but the source has a <transmission> for it")
    return tuple(name for name in chosen if name not in actuators.transmissions)


def _given_actuators(given: Iterable[str], movable: Sequence[str]) -> tuple[str, ...]:
    if isinstance(given, str):
        raise ArgumentError(f"driven must be a list of joints: [{given!r}]")
    chosen = tuple(given)
    for index, name in enumerate(chosen):
        if name not in movable:
            raise ArgumentError(f"driven: there is no joint {name!r} with one freedom; {near_names(str(name), movable)}")
        if name in chosen[:index]:
            raise ArgumentError(f"driven: {name!r} is given twice")
    return chosen


def _loop(found: ForeignLoop, kind: str, axes: tuple[Vector, ...]) -> Loop:
    origins, default = (found.predecessor_origin, found.successor_origin), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    axes = (*axes, *default[len(axes) :])
    return Loop(found.name, kind, found.predecessor, found.successor, *origins, axes[0], axes[1], place=found.place)


def _turned(source: SourceRobot, loop: Loop) -> str | None:
    """Return a warning if the loop's frames are turned against each other at zero by more than a right angle."""
    frames = source.zero_frames
    first = frames[loop.predecessor] @ loop.predecessor_origin.matrix
    second = frames[loop.successor] @ loop.successor_origin.matrix
    between = first[:3, :3].T @ second[:3, :3]
    kind = JOINT_TYPES[loop.type]
    if kind.has_axis and kind.turns is not Axes.BOTH:
        cosine, what = float(np.dot(loop.axis, between @ loop.axis)), "its axis in one frame and in the other are"
    elif kind.is_fixed:
        cosine, what = float((np.trace(between) - 1) / 2), "its two frames are turned by"
    else:
        return None
    if cosine > -1e-9:
        return None
    angle = math.degrees(math.acos(max(cosine, -1.0)))
    apart = f"{what} {angle:.0f}°" + ("" if kind.is_fixed else " apart")
    return (
        f"{loop.place}: at the zero of all joints the loop {loop.name!r} is far from closed: {apart}; "
        "if the robot is assembled at zero, turn one frame with <origin rpy>."
    )
