"""Options of commands, made from the table of arguments, and their values as functions take them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable

from kinetostatics.argument_checks import Keyword
from kinetostatics.arguments import Argument
from kinetostatics.cli.typed_values import number_of, parse_items, whole_number_of
from kinetostatics.exceptions import ArgumentError

#: Endings of figures.
FIGURES = ("svg", "pdf", "png")


def option_of(name: str, argument: Argument) -> str:
    """Return how the command line gives an argument: ``--platform-link``; without dashes it is positional."""
    return argument.option or f"--{name.replace('_', '-')}"


class Options:
    """Adds options to a parser: those of one group under a common heading."""

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
    """Return how argparse reads an argument."""
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
    """Return the value of an option as a function takes it, None if it is not given.

    Raises:
        ArgumentError: it is no such value; the message begins with the option.
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
    """Return the values of those options that are given, by the names of the function's arguments."""
    values = {name: value_of(name, args) for name in names}
    return {name: value for name, value in values.items() if value is not None}


# ---- files that are written --------------------------------------------------------------------------------------------


def check_folder(path: str | None) -> None:
    """Refuse a file of ``--out`` in a folder that does not exist, before anything that takes long.

    Raises:
        ArgumentError: there is none.
    """
    folder = os.path.dirname(path or "")
    if folder and not os.path.isdir(folder):
        raise ArgumentError(f"--out: there is no folder {folder}")


def check_files(paths: Iterable[str], endings: Iterable[str]) -> None:
    """Refuse files of ``--out`` that cannot be written, before anything that takes long.

    Args:
        paths: of the files.
        endings: that tell what is written; figures need Matplotlib.

    Raises:
        ArgumentError: there is no such folder, or the ending of a file is none of these.
        KinetostaticsError: Matplotlib is missing.
    """
    for path in paths:
        check_folder(path)
        ending = ending_of(path)
        if ending not in endings:
            raise ArgumentError(f"--out: {path} does not end in {' or '.join(f'.{each}' for each in endings)}")
        if ending in FIGURES:
            from kinetostatics.plot.style import format_of  # which says what to install where Matplotlib is missing

            format_of(path)


def ending_of(path: str) -> str:
    """Return how a file's name ends, in small letters."""
    return os.path.splitext(path)[1].removeprefix(".").lower()
