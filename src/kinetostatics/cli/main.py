# PYTHON_ARGCOMPLETE_OK
"""The command ``kinetostatics``: parses, runs one of the commands, and turns errors into one line and an exit code.

Every command is a module of :mod:`kinetostatics.cli` with ``HELP``, ``DESCRIPTION``, ``EXAMPLES``, ``add_arguments(parser)`` and
``run(args) -> int``; with ``USAGE`` too if that is not ROBOT and options (None: all its options).
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import os
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import NoReturn

from kinetostatics.argument_checks import Keyword
from kinetostatics.exceptions import KinetostaticsError, near_names
from kinetostatics.printing.colour import for_stream

#: Modules of ``kinetostatics.cli``, in the order of the help.
COMMANDS = (
    *("check", "analyze", "compensate", "sweep", "view", "verify", "report", "tolerances", "spread", "sensitivities"),
    *("optimize", "calibrate", "import", "new", "plot", "export", "robots"),
)

#: Exit code of any error; 0 is success and 1 a command's own bad news.
ERROR = 2

DESCRIPTION = "Sag, stiffness and actuator forces of parallel manipulators, straight from a URDF."
EXAMPLES = """\
examples:
  kinetostatics check 3rps
  kinetostatics analyze 3rps --platform z=500mm rx=2deg ry=-10deg
  kinetostatics COMMAND --help

completion:
  pip install argcomplete, and in ~/.bashrc: eval "$(register-python-argcomplete kinetostatics)"

environment:
  NO_COLOR=1     no colours on terminals
  FORCE_COLOR=1  colours also where the output is no terminal, such as for less -R
"""

#: A negative number, which argparse would take for an option if it has an exponent or a unit.
NEGATIVE = re.compile(r"-\.?\d")
#: What looks like a file's name, and not like a number with its unit.
FILE_NAME = re.compile(r"\.[a-z]\w{0,4}$")


class UsageError(Exception):
    """The command line makes no sense."""


class Parser(argparse.ArgumentParser):
    """A parser that raises instead of printing the usage, and that keeps the help's line breaks."""

    def __init__(self, **options: Keyword) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)

    def error(self, message: str) -> NoReturn:
        """Raise what is wrong."""
        if message.endswith("required: ROBOT"):
            message = "ROBOT is missing; it comes before the options"
        raise UsageError(f"{message} (see {self.prog} --help)")


class Version(argparse.Action):
    """Print the version, which is looked up only then."""

    def __init__(self, option_strings: Sequence[str], dest: str, **_more: Keyword) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_more: object) -> NoReturn:
        """Print it, and end."""
        import kinetostatics

        print(f"kinetostatics {kinetostatics.__version__}")
        parser.exit()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: the arguments without the program's name; default: those of the process.

    Returns:
        The exit code: 0, or 2 after an error, of which one line stands on standard error.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if "_ARGCOMPLETE" in os.environ:
        return _complete()
    try:
        _prepare_output()
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except (UsageError, KinetostaticsError) as error:
        return _fail(str(error))
    except BrokenPipeError:  # the reader has seen enough
        _drop_output()
        return 1
    except OSError as error:
        _drop_output()
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}")
    except KeyboardInterrupt:
        return 130


def _complete() -> int:
    """Answer a shell that asks how the line can go on."""
    from kinetostatics.cli.completion import complete

    complete(make_parser([importlib.import_module(f"kinetostatics.cli.{name}") for name in COMMANDS]))
    return 1


def _run(arguments: list[str]) -> int:
    # Only the wanted command is imported; help and misspelled commands need all of them.
    wanted = arguments[:1] if arguments[:1] and arguments[0] in COMMANDS else list(COMMANDS)
    if arguments[:1] and not arguments[0].startswith("-") and arguments[0] not in COMMANDS:
        raise UsageError(f"there is no command {arguments[0]!r}: {near_names(arguments[0], COMMANDS)}")
    if arguments[:1] == ["--version"]:
        wanted = []
    modules = [importlib.import_module(f"kinetostatics.cli.{name}") for name in wanted]
    # argparse never takes an argument with a space for an option
    guarded = [f" {item}" if NEGATIVE.match(item) else item for item in arguments]
    try:
        parser = make_parser(modules)
        args, rest = parser.parse_known_args(guarded)
        if rest:
            raise UsageError(_unrecognized(parser, arguments[0], rest))
    except SystemExit as stop:  # --help and --version
        sys.stdout.flush()
        return int(stop.code or 0)
    args.command_line = ["kinetostatics", *arguments]
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = _warn
        return int(args.run(args))


def _unrecognized(parser: argparse.ArgumentParser, command: str, rest: Sequence[str]) -> str:
    """Say which arguments a command does not have, and which are like them."""
    text = f"unrecognized arguments: {' '.join(item.strip() for item in rest)}"
    name, _, value = next((item for item in rest if item.startswith("--")), "").partition("=")
    known: dict[str, argparse.Action] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction) and command in action.choices:
            known = action.choices[command]._option_string_actions
    if name:
        following = rest[rest.index(name) + 1 :] if name in rest else []
        value = value or next((item for item in following if not item.startswith("--")), "VALUE").strip()
        files = [option for option, action in known.items() if str(action.metavar).startswith("FILE") and len(option) > 2]
        names_file = bool(files) and FILE_NAME.search(value) is not None
        near = difflib.get_close_matches(name, files if names_file else known, n=2, cutoff=0.75)
        if names_file and not near:
            text += f"; a file is given by {' or '.join(files)}"
        elif near:
            text += f"; did you mean {' or '.join(near)}?"
        elif others := [item for item in COMMANDS if item != command and name in _options(item)]:
            text += f"; {name} belongs to {', '.join(others[:4])}{', …' * (len(others) > 4)}"
        elif "--set" in known:
            text += f"; values of a robot's file are given by --set {name[2:].replace('-', '_')}={value}"
    return f"{text} (see kinetostatics {f'{command} ' if known else ''}--help)"


def _options(command: str) -> Mapping[str, argparse.Action]:
    """Return the options of a command, by their names."""
    parser = argparse.ArgumentParser()
    importlib.import_module(f"kinetostatics.cli.{command}").add_arguments(parser)
    return parser._option_string_actions


def make_parser(modules: Sequence[ModuleType]) -> argparse.ArgumentParser:
    """Return the parser of the command line with the commands of these modules."""
    parser = Parser(prog="kinetostatics", description=DESCRIPTION, epilog=EXAMPLES)
    parser.add_argument("--version", action=Version)
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, title="commands")
    for module in modules:
        name, usage = module.__name__.rpartition(".")[2], getattr(module, "USAGE", "ROBOT [options]")
        whole = None if usage is None else f"kinetostatics {name} {usage}"
        command = subparsers.add_parser(
            name, usage=whole, help=module.HELP, description=module.DESCRIPTION, epilog=module.EXAMPLES
        )
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser


def _prepare_output() -> None:
    if sys.stdout is None:
        raise UsageError("standard output is closed")
    for stream in (sys.stdout, sys.stderr):
        # a terminal that lacks µ or ⟂ must not end in a traceback
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def _warn(message: Warning | str, *_where: object, **_more: Keyword) -> None:
    """Print a warning in one line, at once."""
    if sys.stderr is not None:
        print(for_stream(f"kinetostatics: warning: {' '.join(str(message).split())}", sys.stderr), file=sys.stderr)


def _fail(message: str) -> int:
    line = " ".join(message.split())
    if sys.stderr is not None:
        print(for_stream(f"kinetostatics: error: {line}", sys.stderr), file=sys.stderr)
    return ERROR


def _drop_output() -> None:
    """Keep the interpreter from complaining once more when it closes standard output."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError, AttributeError):
        pass
