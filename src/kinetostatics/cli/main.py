# PYTHON_ARGCOMPLETE_OK
"""The program ``kinetostatics``: parses the command line and runs one of the commands. An error is one line and an exit code."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import NoReturn

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import COMMANDS, command
from kinetostatics.cli.output import print_message
from kinetostatics.exceptions import KinetostaticsError, PlatformMissingError, near_names

#: Exit code of errors; 0 is success, and 1 the negative answer of a command.
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
  FORCE_COLOR=1  colours also in output to files and pipes, such as for less -R
"""

#: Beginning of a negative number; argparse treats numbers such as -1e3 and -5mm as options.
NEGATIVE = re.compile(r"-\.?\d")


class UsageError(Exception):
    """The command line is invalid."""


class Parser(argparse.ArgumentParser):
    """A parser that raises errors instead of printing the usage, and preserves line breaks of the help."""

    def __init__(self, **options: Keyword) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)

    def error(self, message: str) -> NoReturn:
        """Raise a :class:`UsageError` in place of argparse's exit."""
        if message.endswith("required: ROBOT"):
            message = "ROBOT is missing; it comes before the options"
        raise UsageError(f"{message} (see {self.prog} --help)")


class Version(argparse.Action):
    """Action of ``--version``; the version is determined only if this option is given."""

    def __init__(self, option_strings: Sequence[str], dest: str, **_more: Keyword) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_more: object) -> NoReturn:
        import kinetostatics

        print(f"kinetostatics {kinetostatics.__version__}")
        parser.exit()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: the arguments without the program's name; default: those of the process.

    Returns:
        The exit code: 0, 1 for a negative answer, or 2 after an error, with one line on standard error.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if "_ARGCOMPLETE" in os.environ:
        return _complete()
    try:
        _prepare_output()
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except PlatformMissingError as error:
        return _suggest_platform_links(error, arguments)
    except (UsageError, KinetostaticsError) as error:
        return _fail(str(error))
    except BrokenPipeError:  # the reader has closed the pipe
        _drop_output()
        return 1
    except OSError as error:
        _drop_output()
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}")
    except KeyboardInterrupt as interruption:
        print("; ".join(["kinetostatics: interrupted", *map(str, interruption.args)]), file=sys.stderr)
        return 130


def _complete() -> int:
    from kinetostatics.cli.completion import complete

    complete(make_parser(COMMANDS))
    return 1


def _run(arguments: list[str]) -> int:
    given = arguments[0] if arguments else "--help"
    if not given.startswith("-") and given not in COMMANDS:
        near = near_names(given, COMMANDS)
        hint = f"commands are {', '.join(COMMANDS)}" if near.startswith("known") else near
        raise UsageError(f"there is no command {given!r}; {hint}")
    # only the module of the command is imported; the help of the program needs all of them
    names = [given] if given in COMMANDS else [] if given == "--version" else COMMANDS
    # argparse never treats an argument with a space as an option
    guarded = [f" {argument}" if NEGATIVE.match(argument) else argument for argument in arguments]
    try:
        args, unparsed = make_parser(names).parse_known_args(guarded)
    except SystemExit as stop:  # --help and --version
        sys.stdout.flush()
        return int(stop.code or 0)
    if unparsed:
        unknown = " ".join(argument.strip() for argument in unparsed)
        raise UsageError(f"unrecognized arguments: {unknown} (see kinetostatics {given} --help)")
    args.command_line = ["kinetostatics", *arguments]
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = lambda message, *_where, **_more: print_message("warning", str(message))
        return int(args.run(args))


def make_parser(names: Iterable[str]) -> argparse.ArgumentParser:
    parser = Parser(prog="kinetostatics", description=DESCRIPTION, epilog=EXAMPLES)
    parser.add_argument("--version", action=Version)
    commands = parser.add_subparsers(metavar="COMMAND", required=True, title="commands")
    for name in names:
        command(name).add_to(commands, name)
    return parser


def _prepare_output() -> None:
    if sys.stdout is None:
        raise UsageError("standard output is closed")
    for stream in (sys.stdout, sys.stderr):
        # terminals without µ or ⟂ show ? instead
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def _fail(message: str) -> int:
    print_message("error", message)
    return ERROR


def _suggest_platform_links(error: PlatformMissingError, arguments: list[str]) -> int:
    """Print the error that a file does not name its platform, and return the exit code.

    If the file is the command's ROBOT, also print the command with each probable platform link.
    """
    place = arguments.index(error.file) if error.file in arguments else None
    if place is None or "--compare" in arguments[:place] or "--platform-link" in arguments:
        return _fail(str(error))
    commands = [shlex.join(["kinetostatics", *arguments, "--platform-link", link]) for link in error.likely]
    print_message("error", f"{error.file}: the file does not say which link is the platform; likely ones:", commands)
    return ERROR


def _drop_output() -> None:
    """Redirect standard output to the null device, so that the interpreter can close it without another error."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError, AttributeError):
        pass
