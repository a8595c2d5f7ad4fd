# PYTHON_ARGCOMPLETE_OK
"""The command ``kinetostatics``: parses, runs one of the commands, and turns errors into one line and an exit code.

Every command is a module of :mod:`kinetostatics.cli` with ``HELP``, ``DESCRIPTION``, ``EXAMPLES``, ``add_arguments(parser)`` and
``run(args) -> int``; with ``USAGE`` too if that is not ROBOT and options (None: all its options).
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
import warnings
from collections.abc import Sequence
from types import ModuleType
from typing import NoReturn

from kinetostatics.argument_checks import Keyword
from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.printing.colour import for_stream

#: Modules of ``kinetostatics.cli``, in the order of the help.
COMMANDS = (
    *("check", "analyze", "compensate", "sweep", "view", "verify", "report", "tolerances", "sensitivities"),
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
        raise UsageError(f"there is no command {arguments[0]!r}; commands are {', '.join(COMMANDS)}")
    if arguments[:1] == ["--version"]:
        wanted = []
    modules = [importlib.import_module(f"kinetostatics.cli.{name}") for name in wanted]
    # argparse never takes an argument with a space for an option
    guarded = [f" {item}" if NEGATIVE.match(item) else item for item in arguments]
    try:
        parser = make_parser(modules)
        args, rest = parser.parse_known_args(guarded)
        if rest:
            given = " ".join(item.strip() for item in rest)
            raise UsageError(f"unrecognized arguments: {given} (see kinetostatics {arguments[0]} --help)")
    except SystemExit as stop:  # --help and --version
        sys.stdout.flush()
        return int(stop.code or 0)
    args.command_line = ["kinetostatics", *arguments]
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = _warn
        return int(args.run(args))


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
