"""Completion of the command line in shells by argcomplete (extra ``completion``), including names from robot files.

This module is imported only for completion.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.files.bundled import shipped_robots
from kinetostatics.units import PLATFORM_KINDS

#: Endings of robot files and of maps.
ROBOT_FILES, MAPS = ("urdf", "xacro"), ("nc", "zarr")
#: Some of the values of ``--orientation``.
ORIENTATIONS = ("rotation_vector", "tilt_torsion", "XYZ", "ZYX", "ZYZ", "xyz", "zyx")

Names = Callable[[argparse.Namespace], Iterable[str]]


def complete(parser: argparse.ArgumentParser) -> None:
    """Print completions and end the process; return only if argcomplete is not installed."""
    try:
        import argcomplete
    except ImportError:
        return
    attach(parser)
    argcomplete.autocomplete(parser)


def attach(parser: argparse.ArgumentParser) -> None:
    """Set the completers of the arguments of all commands."""
    for action in _actions(parser):
        completer = _completer(action)
        if completer is not None:
            setattr(action, "completer", completer)  # noqa: B010 - the class does not know this attribute


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        else:
            yield action


def _completer(action: argparse.Action) -> Callable[..., Iterable[str]] | None:
    """Return the completer of an argument's values; None: the default completer, which completes file names."""
    from argcomplete.completers import FilesCompleter

    metavar = action.metavar if isinstance(action.metavar, str) else ""
    robot_files, shipped = FilesCompleter(ROBOT_FILES), shipped_robots()
    if metavar.split("|")[0] == "ROBOT":
        return lambda prefix, **_: [*(name for name in shipped if name.startswith(prefix)), *robot_files(prefix)]
    if metavar == "MAP":
        return FilesCompleter(MAPS)
    names = _NAMES.get(metavar) or _NAMES_OF.get(action.dest)
    if names is None:
        return None

    def matching(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
        try:
            return [name for name in names(parsed_args) if name.startswith(prefix)]
        except (KinetostaticsError, OSError):  # errors of files are reported when the command runs
            return []

    return matching


# ---- names -----------------------------------------------------------------------------------------------------------


def _path(args: argparse.Namespace) -> str:
    return str(getattr(args, "robot", None) or getattr(args, "source", None) or "")


def _elements(args: argparse.Namespace, tag: str) -> list[str]:
    """Return the names of all elements with a tag in the robot's file; other parts of the file may be invalid."""
    from kinetostatics.files.bundled import read_robot
    from kinetostatics.files.xml import parse

    document, _ = parse(*read_robot(_path(args)))
    return [name for element in document.getElementsByTagName(tag) if "$" not in (name := element.getAttribute("name")) and name]


def _assignments(names: Iterable[str]) -> list[str]:
    return [f"{name}=" for name in names]


def _coordinates(args: argparse.Namespace) -> list[str]:
    leaning = getattr(args, "orientation", None) == "tilt_torsion"
    left_out = ("rx", "ry", "rz") if leaning else ("azimuth", "tilt", "torsion")
    return _assignments(name for name in PLATFORM_KINDS if name not in left_out)


def _actuators(args: argparse.Namespace) -> list[str]:
    from kinetostatics.files.reader import read_robot_file

    return _assignments(read_robot_file(_path(args)).actuated)


def _unknowns(args: argparse.Namespace) -> list[str]:
    from kinetostatics.files.reader import read_robot_file

    description = read_robot_file(_path(args))
    payload = [f"payload.{what}" for what in ("mass", *"xyz")]
    return [*description.elastic_links, *description.joint_stiffness, *_elements(args, "xacro:arg"), *payload, "offsets"]


def _limbs(args: argparse.Namespace) -> list[str]:
    from kinetostatics.robot import load_robot

    return [f"{limb.name}=x" for limb in load_robot(_path(args)).topology.limbs]


#: Functions that return possible values of an argument, by its metavar and by its name.
_NAMES: dict[str, Names] = {"LINK": lambda args: _elements(args, "link"), "JOINT": lambda args: _elements(args, "joint")}
_NAMES_OF: dict[str, Names] = {
    "platform": _coordinates,
    "actuators": _actuators,
    "sweep": lambda args: [*_coordinates(args), *_actuators(args)],
    "near": lambda args: [*_coordinates(args), *_actuators(args)],
    "parameters": lambda args: _assignments(_elements(args, "xacro:arg")),
    "unknowns": _unknowns,
    "hinge_axis": _limbs,
    "orientation": lambda _: ORIENTATIONS,
    "copy": lambda _: shipped_robots(),
}
