"""Options of commands from the table of arguments, and their values for the functions."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable

from kinetostatics.arguments import Argument, Keyword
from kinetostatics.cli.typed_values import number_of, parse_items, whole_number_of
from kinetostatics.exceptions import ArgumentError

#: Endings of figures.
FIGURES = ("svg", "pdf", "png")


def option_of(name: str, argument: Argument) -> str:
    """Return the option of an argument, such as ``--platform-link``; the name of a positional argument has no dashes."""
    return argument.option or f"--{name.replace('_', '-')}"


class Options:
    """Adds options to a parser; options of one group have a common heading in the help."""

    def __init__(self, parser: argparse.ArgumentParser, grid: bool = False, required: Iterable[str] = ()) -> None:
        self.parser, self.grid, self.required = parser, grid, frozenset(required)
        self._groups: dict[str, argparse._ArgumentGroup] = {}
        self._pose: argparse._MutuallyExclusiveGroup | None = None

    def add(self, name: str, argument: Argument, place: argparse._ActionsContainer | None = None) -> None:
        """Add the option of an argument, to a group if there is one; ``platform`` and ``actuators`` exclude one another."""
        place = place or self.parser
        if argument.group:
            place = self._groups.get(argument.group) or self.parser.add_argument_group(argument.group)
            self._groups[argument.group] = place
        if name in ("platform", "actuators"):
            self._pose = place = self._pose or place.add_mutually_exclusive_group()
        option = option_of(name, argument)
        keywords: dict[str, Keyword] = {"help": argument.help, **_action(argument)}
        if self.grid and name in ("platform", "actuators"):
            keywords["metavar"] += "S"  # NAME=VALUES
        if option.startswith("-"):
            keywords |= {"dest": name, "required": name in self.required}
        elif name not in self.required:
            keywords["nargs"] = "?"
        place.add_argument(option, **keywords)


def _action(argument: Argument) -> dict[str, Keyword]:
    """Return the keywords of an argument for argparse."""
    if argument.kind == "flag":
        return {"action": "store_true"}
    metavar = argument.metavar
    if argument.choices:
        return {"choices": argument.choices}
    if argument.kind == "optional text":
        return {"metavar": metavar, "nargs": "?", "const": ""}
    if argument.kind == "texts or none":
        return {"metavar": metavar, "nargs": "*", "action": "extend"}
    if not argument.kind:
        return {"metavar": metavar, "nargs": "+", "action": "append", "default": []}
    if argument.kind in ("items", "texts"):
        return {"metavar": metavar, "nargs": "+", "action": "extend", "default": []}
    return {"metavar": metavar, "nargs": argument.size or None}


def value_of(name: str, args: argparse.Namespace) -> Keyword:
    """Return the value of an option for the function, None if not given.

    Raises:
        ArgumentError: the value is invalid; the message begins with the option.
    """
    argument, given = args.arguments[name], getattr(args, name)
    option = option_of(name, argument)
    if given is None or given is False or given == []:
        return None
    if argument.kind == "items":
        return parse_items(option, given)
    if argument.kind == "count":
        return whole_number_of(option, given, argument.least)
    if argument.kind in ("", "flag", "text", "optional text", "texts", "names"):
        return given
    if argument.kind == "wrench":
        return [number_of(option, text, "force" if k < 3 else "moment") for k, text in enumerate(given)]
    if argument.size:
        return [number_of(option, text, argument.kind) for text in given]
    return number_of(option, given, argument.kind)


def given_of(names: Iterable[str], args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the values of the given options by argument name."""
    values = {name: value_of(name, args) for name in names}
    return {name: value for name, value in values.items() if value is not None}


# ---- files that are written --------------------------------------------------------------------------------------------


def check_folder(path: str | None) -> None:
    """Check that the folder of a file of ``--out`` exists, before long computations.

    Raises:
        ArgumentError: the folder does not exist.
    """
    folder = os.path.dirname(path or "")
    if folder and not os.path.isdir(folder):
        raise ArgumentError(f"--out: there is no folder {folder}")


def check_files(paths: Iterable[str], endings: Iterable[str]) -> None:
    """Check that files of ``--out`` can be written, before long computations.

    Args:
        paths: paths of the files.
        endings: allowed endings; figures need Matplotlib.

    Raises:
        ArgumentError: a folder does not exist, or an ending is not allowed.
        KinetostaticsError: Matplotlib is missing.
    """
    for path in paths:
        check_folder(path)
        ending = ending_of(path)
        if ending not in endings:
            raise ArgumentError(f"--out: {path} does not end in {' or '.join(f'.{each}' for each in endings)}")
        if ending in FIGURES:
            from kinetostatics.plot.style import format_of  # raises an error if Matplotlib is missing

            format_of(path)


def ending_of(path: str) -> str:
    """Return the ending of a file name, in lower case."""
    return os.path.splitext(path)[1].removeprefix(".").lower()
