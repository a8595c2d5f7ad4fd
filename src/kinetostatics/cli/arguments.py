"""Arguments that the commands share: the robot, its parameters, the pose, load and gravity."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, TypedDict

from kinetostatics.argument_checks import Keyword
from kinetostatics.description.units import KINDS, KNOWN, Unit, article, find_unit, typed_number
from kinetostatics.exceptions import ArgumentError

if TYPE_CHECKING:
    from kinetostatics.description.loads import LinkLoad
    from kinetostatics.robot import Robot

VALUES_HELP = """\
values:
  Numbers are SI: m, rad, N, N·m. They may carry units, with SI prefixes: z=500mm rx=-2deg, 1.5kN, 20Nm, 70GPa, 7.8g/cm3.
"""

#: Values along one dimension, and poses, at most.
MOST = 1_000_000


class _Several(TypedDict):
    nargs: str
    action: str
    default: list[str]


#: How options are declared that take several values, and may be given several times.
SEVERAL: _Several = {"nargs": "+", "action": "extend", "default": []}


# ---- reading values ------------------------------------------------------------------------------------------------


def parse_quantity(text: str, kind: str | None = None) -> float:
    """Return a number with an optional unit in SI.

    Args:
        text: such as ``500mm``, ``-2deg``, ``1.5kN`` or ``-1e-3``.
        kind: one of :data:`kinetostatics.description.units.KINDS` if only units of that kind make sense, "number" if none does.

    Raises:
        ArgumentError: it is not a number, or the unit is unknown or of the wrong kind.
    """
    found = typed_number(text)
    if found is None:
        raise ArgumentError(f"{text.strip()!r} is not a number, with or without a unit; units are {KNOWN}")
    value, name = found
    if not math.isfinite(value):
        raise ArgumentError(f"{text.strip()!r} is too large")
    if not name:
        return value
    unit = find_unit(name)
    if unit is None:
        raise ArgumentError(f"{text.strip()!r} has the unknown unit {name!r}; units are {KNOWN}")
    if kind is not None and (kind == "number" or unit.kind != kind):
        wanted = "a plain number" if kind == "number" else article(kind)
        given = article(unit.kind) if unit.kind else "another quantity"
        raise ArgumentError(f"{text.strip()!r} is {given}, but {wanted} is needed")
    return unit.in_si(value)


def unit_of(text: str) -> Unit | None:
    """Return the unit that a number carries, None if the text is no number with a unit."""
    found = typed_number(text)
    return find_unit(found[1]) if found and found[1] else None


def check_folder(out: str | None, option: str = "--out") -> None:
    """Complain before anything that takes long if there is no folder for the file of an option.

    Raises:
        ArgumentError: there is none.
    """
    folder = os.path.dirname(out or "")
    if folder and not os.path.isdir(folder):
        raise ArgumentError(f"{option}: there is no folder {folder}")


def check_figure(path: str | None, option: str = "--plot") -> None:
    """Complain before anything that takes long if a figure cannot be written to the file of an option.

    Raises:
        ArgumentError: there is no such folder, or the name ends in what is no format of figures.
        KinetostaticsError: Matplotlib is missing.
    """
    check_folder(path, option)
    if path is not None:
        from kinetostatics.plot.style import format_of

        format_of(path)


def parse_range(option: str, name: str, text: str, kind: str | None = None) -> tuple[float, float, int | None]:
    """Return first, last and number of values of ``FROM:TO[:COUNT]``, the number None if it is not given.

    Args:
        option: the option's name, for messages.
        name: of what has these values.
        text: the range.
        kind: as in :func:`parse_quantity`.

    Raises:
        ArgumentError: it is not of that form.
    """
    parts = text.split(":")
    if len(parts) not in (2, 3):
        raise ArgumentError(f"{option}: {name}={text} is not of the form {name}=FROM:TO or {name}=FROM:TO:COUNT")
    first, last = parse_coordinates(option, name, parts[:2], kind)
    if len(parts) == 2:
        return first, last, None
    if not parts[2].strip().isdecimal() or int(parts[2]) < 2:
        raise ArgumentError(f"{option}: {name}: {parts[2]!r} is not a number of values, which must be at least 2")
    if int(parts[2]) > MOST:
        count = parts[2].strip()
        raise ArgumentError(f"{option}: {name}: {count} values are too many; at most {MOST:,} go along a dimension")
    return first, last, int(parts[2])


def parse_values(option: str, name: str, text: str, kind: str | None = None) -> float | list[float]:
    """Return one value, or those of ``FROM:TO:COUNT`` or of a list ``A,B,C``.

    Raises:
        ArgumentError: it is none of these.
    """
    if ":" in text:
        first, last, count = parse_range(option, name, text, kind)
        if count is None:
            raise ArgumentError(f"{option}: {name}={text} does not say how many values: {name}={text}:11")
        step = (last - first) / (count - 1)
        return [*(first + step * k for k in range(count - 1)), last]
    if "," in text:
        return parse_coordinates(option, name, text.split(","), kind)
    return parse_coordinates(option, name, [text], kind)[0]


def parse_coordinates(option: str, name: str, texts: Sequence[str], kind: str | None) -> list[float]:
    """Return values of one coordinate or parameter, which are of one kind."""
    try:
        found = [parse_quantity(text, kind) for text in texts]
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {name}: {error}") from None
    kinds = {unit.dimension: text.strip() for text in texts if (unit := unit_of(text)) is not None}
    if len(kinds) > 1:
        raise ArgumentError(f"{option}: {name}: {' and '.join(map(repr, kinds.values()))} are not of one kind")
    return found


def parse_items(option: str, items: Iterable[str]) -> dict[str, str]:
    """Return items ``name=value`` as a dict.

    Raises:
        ArgumentError: one has no ``=``, no name or no value, or a name comes twice.
    """
    found: dict[str, str] = {}
    for item in items:
        name, sign, value = (part.strip() for part in item.partition("="))
        if not (name and sign and value):
            raise ArgumentError(f"{option}: {item.strip()!r} is not of the form name=value")
        if name in found:
            raise ArgumentError(f"{option}: {name!r} is given twice")
        found[name] = value
    return found


def parse_parameters(items: Iterable[str]) -> dict[str, Keyword]:
    """Return the values of ``--set``; numbers with a unit are turned to SI, everything else is passed on as it stands."""
    values = parse_items("--set", items)
    return {name: value if unit_of(value) is None else parse_quantity(value) for name, value in values.items()}


def typed_units(items: Iterable[str]) -> dict[str, str]:
    """Return the SI units of the values of ``--set`` that carry some."""
    found: dict[str, str] = {}
    for name, value in parse_items("--set", items).items():
        kinds = [typed.kind for part in re.split("[:,]", value) if (typed := unit_of(part)) is not None]
        if kinds and kinds[0]:
            found[name] = KINDS[kinds[0]].replace("·", " ")
    return found


def number_of(option: str, text: str, kind: str | None = "number") -> float:
    """Return the number that an option has, of a kind as in :func:`parse_quantity`."""
    try:
        return parse_quantity(text, kind)
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {error}") from None


def whole_number_of(option: str, text: str, least: int = 1) -> int:
    """Return the whole number from ``least`` on that an option has."""
    from kinetostatics.argument_checks import whole_number

    number = None
    with contextlib.suppress(ArgumentError):
        number = parse_quantity(text, "number")
    return whole_number(option, int(number) if number is not None and number.is_integer() else None, least, shown=text.strip())


# ---- the robot -----------------------------------------------------------------------------------------------------


def add_robot_arguments(parser: argparse.ArgumentParser, value: str = "VALUE") -> None:
    """Add ROBOT and ``--set``; ``value`` is what help calls the values."""
    parser.add_argument(
        "robot", metavar="ROBOT", help="a URDF or xacro file, or the name of a robot that comes with the package: 3rps, 2pru_upr"
    )
    parser.add_argument(
        "--set",
        dest="parameters",
        metavar=f"NAME={value}",
        **SEVERAL,
        help="values of the file's xacro arguments, such as rod_diameter=80mm",
    )
    parser.add_argument(
        "--platform-link",
        metavar="LINK",
        help="the link that is the moving platform, of a URDF that does not say it, or another one",
    )
    parser.add_argument(
        "--base-link", metavar="LINK", help="the link that stands still (default: as the file says, or the root of its tree)"
    )


def load(args: argparse.Namespace) -> Robot:
    """Load the robot that the arguments name."""
    from kinetostatics.files.bundled import robot_path
    from kinetostatics.parametric.robot import ParametricRobot
    from kinetostatics.robot import load_robot

    path, parameters = os.fspath(robot_path(args.robot)), parse_parameters(args.parameters)
    links = {"platform": args.platform_link, "base": args.base_link}
    robot = load_robot(path, parameters, **links)
    ParametricRobot(robot, links).check_units(typed_units(args.parameters), "parameters")
    return robot


# ---- load and gravity ----------------------------------------------------------------------------------------------


def add_load_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--load``, ``--point``, ``--frame``, ``--load-on``, ``--payload…`` and ``--gravity``."""
    group = parser.add_argument_group("load")
    group.add_argument(
        "--load",
        nargs=6,
        metavar=("FX", "FY", "FZ", "MX", "MY", "MZ"),
        default=["0"] * 6,
        help="external force [N] and moment [N·m] on the platform (default: none)",
    )
    group.add_argument("--point", nargs=3, metavar=("X", "Y", "Z"), help="where the force acts (default: at o)")
    group.add_argument(
        "--frame",
        choices=("world", "platform"),
        default="world",
        help="axes of load and point; a point in the platform's frame counts from o (default: %(default)s)",
    )
    group.add_argument(
        "--load-on",
        nargs="+",
        action="append",
        metavar=("LINK", "FX FY FZ MX MY MZ [X Y Z] [link|world]"),
        default=[],
        help="force [N] and moment [N·m] on a link, at the point X Y Z of the link's frame (default: its origin), in the axes of "
        "the link or the world (default); may be given several times",
    )
    group.add_argument("--payload", metavar="MASS", help="mass of what the robot carries [kg]")
    group.add_argument(
        "--payload-center",
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="its centre of mass, in the platform's frame from o, or in that of its link (default: 0 0 0)",
    )
    group.add_argument("--payload-link", metavar="LINK", help="the link that carries it (default: the platform)")
    group.add_argument(
        "--gravity",
        nargs=3,
        metavar=("GX", "GY", "GZ"),
        default=["0", "0", "-9.81"],
        help="in world axes [m/s²] (default: 0 0 -9.81)",
    )


def add_tool_argument(parser: argparse._ActionsContainer, what: str) -> None:
    """Add ``--tool``; ``what`` is done with the point."""
    parser.add_argument("--tool", metavar=("X", "Y", "Z"), nargs=3, help=f"{what}: a tool's tip, from o in the platform's axes")


def tool(args: argparse.Namespace) -> list[float] | None:
    """Return the point of ``--tool`` [m], None if there is none."""
    return None if args.tool is None else [number_of("--tool", text, "length") for text in args.tool]


def load_options(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return load, point, frame and gravity as :func:`kinetostatics.analyze` takes them."""
    load = [number_of("--load", text, "force" if k < 3 else "moment") for k, text in enumerate(args.load)]
    point = None if args.point is None else [number_of("--point", text, "length") for text in args.point]
    gravity = [number_of("--gravity", text, "acceleration") for text in args.gravity]
    return {"load": load, "point": point, "frame": args.frame, "gravity": gravity, **_options_of_links(args)}


def _options_of_links(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return loads on links and the payload, as far as they are given."""
    loads: dict[str, list[LinkLoad]] = {}
    for link, *texts in args.load_on:
        loads.setdefault(link, []).append(_link_load(link, texts))
    found: dict[str, object] = {"loads": loads} if loads else {}
    center, link = args.payload_center, args.payload_link
    if args.payload is not None:
        from kinetostatics.description.loads import Payload

        mass = number_of("--payload", args.payload, "mass")
        point = [number_of("--payload-center", text, "length") for text in center or "000"]
        found["payload"] = Payload(mass, tuple(point), link=link)
    elif center is not None or link is not None:
        option = "--payload-link" if center is None else "--payload-center"
        raise ArgumentError(f"{option} says where a payload is, but --payload does not say its mass: --payload 5kg")
    return found


def _link_load(link: str, texts: list[str]) -> LinkLoad:
    """Return one load of ``--load-on``."""
    from kinetostatics.description.loads import LinkLoad

    frame = texts.pop() if texts[-1:] in (["link"], ["world"]) else "world"
    if len(texts) not in (6, 9):
        raise ArgumentError(
            f"--load-on {link}: there are {len(texts)} numbers; give FX FY FZ MX MY MZ, and after them X Y Z if it does not act "
            "at the link's origin"
        )
    option = f"--load-on {link}"
    kinds = ["force"] * 3 + ["moment"] * 3 + ["length"] * 3
    numbers = [number_of(option, text, kind) for text, kind in zip(texts, kinds, strict=False)]
    return LinkLoad(tuple(numbers[:6]), tuple(numbers[6:]) or (0.0, 0.0, 0.0), frame)


# ---- output --------------------------------------------------------------------------------------------------------


def add_engine_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine``."""
    parser.add_argument(
        "--engine",
        choices=("auto", "numpy", "compiled"),
        default="auto",
        help="what computes: NumPy or compiled code (default: %(default)s, compiled where the poses are many)",
    )


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``."""
    parser.add_argument("--json", action="store_true", help="print JSON, all numbers in SI; warnings go to standard error")
