"""Table of the commands, and their common structure.

Each command is a :class:`Command` in the module that the table names; its object is the name in capitals, with _ for -.
Its options are arguments of :mod:`kinetostatics.arguments`; their defaults are those of the function that the command calls.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from kinetostatics.arguments import Keyword
from kinetostatics.cli.inputs import option_of
from kinetostatics.cli.options import ARGUMENTS, Argument

#: Arguments with the coordinates of the pose; only one of them may be given.
COORDINATES = ("platform", "actuators")

#: Module of each command, in the order of the help.
COMMANDS: Mapping[str, str] = {
    "check": "robots",
    "analyze": "analyses",
    "compensate": "analyses",
    "capacity": "designs",
    "modes": "analyses",
    "response": "analyses",
    "sweep": "maps",
    "view": "view",
    "verify": "analyses",
    "report": "robots",
    "tolerances": "designs",
    "sensitivities": "designs",
    "optimize": "designs",
    "calibrate": "designs",
    "new": "new",
    "import-link": "links",
    "condense": "links",
    "plot": "maps",
    "export": "robots",
    "robots": "robots",
}


def _action(argument: Argument) -> dict[str, Keyword]:
    """Return the keywords for an argument of ``add_argument`` of argparse."""
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


@dataclass(frozen=True)
class Command:
    """A command.

    Attributes:
        run: function that executes the command with its options, and returns the exit code.
        help: description of one line.
        arguments: names of its arguments in :data:`kinetostatics.cli.options.ARGUMENTS`.
        examples: command lines without the program's name.
        function: the function of the package that it calls, as "module:name".
        own_arguments: arguments that only this command has, or that have another meaning in it.
        description: longer description than ``help``.
        required: names of required arguments.
        usage: usage line instead of a list of all options.
        notes: text above the examples.
        grid: whether coordinates may be ranges or lists.
        exclusive: names of options that exclude one another.
    """

    run: Callable[[argparse.Namespace], int]
    help: str
    arguments: tuple[str, ...]
    examples: str
    function: str = ""
    own_arguments: Mapping[str, Argument] = field(default_factory=dict)
    description: str = ""
    required: tuple[str, ...] = ("robot",)
    usage: str = "ROBOT [options]"
    notes: str = ""
    grid: bool = False
    exclusive: tuple[str, ...] = ()

    @property
    def options(self) -> dict[str, Argument]:
        return {**{name: self.own_arguments.get(name) or ARGUMENTS[name] for name in self.arguments}, **self.own_arguments}

    def called(self) -> Callable[..., Keyword]:
        module, _, name = self.function.partition(":")
        return getattr(importlib.import_module(f"kinetostatics.{module}"), name)

    def add_to(self, commands: argparse._SubParsersAction[Keyword], name: str) -> None:
        examples = "".join(f"  kinetostatics {line}\n" for line in self.examples.strip().splitlines())
        parser = commands.add_parser(
            name,
            usage=f"kinetostatics {name} {self.usage}",
            help=self.help,
            description=self.description or f"{self.help[0].upper()}{self.help[1:]}.",
            epilog=f"{self.notes}\nexamples:\n{examples}".lstrip("\n"),
        )
        groups: dict[str, argparse._ActionsContainer] = {"": parser}
        alternatives: dict[tuple[str, ...], argparse._ActionsContainer] = {}  # groups of options that exclude one another
        for key, argument in self.options.items():
            if argument.group not in groups:
                groups[argument.group] = parser.add_argument_group(argument.group)
            place = groups[argument.group]
            for names in (COORDINATES, self.exclusive):
                if key in names:
                    if names not in alternatives:
                        alternatives[names] = place.add_mutually_exclusive_group()
                    place = alternatives[names]
            option = option_of(key, argument)
            keywords: dict[str, Keyword] = {"help": argument.help, **_action(argument)}
            if self.grid and key in COORDINATES:
                keywords["metavar"] += "S"  # NAME=VALUES
            short = ["-o"] if key == "out" else []
            if option.startswith("-"):
                keywords |= {"dest": key, "required": key in self.required}
            elif key not in self.required:
                keywords["nargs"] = "?"
            place.add_argument(option, *short, **keywords)
        parser.set_defaults(run=self.run, arguments=self.options)


def command(name: str) -> Command:
    chosen = getattr(importlib.import_module(f"kinetostatics.cli.{COMMANDS[name]}"), name.upper().replace("-", "_"))
    assert isinstance(chosen, Command)
    return chosen
