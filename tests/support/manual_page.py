"""Write the manual page docs/reference/kinetostatics.1 from the command line's own parsers.

    python tests/support/manual_page.py

The wheel installs it into share/man/man1.
"""

from __future__ import annotations

import argparse
import importlib
import re
from collections.abc import Iterable, Iterator

from places import ROOT

from kinetostatics.cli import main

PAGE = ROOT / "docs" / "reference" / "kinetostatics.1"


def manual_page() -> str:
    """Return the page in roff."""
    modules = [importlib.import_module(f"kinetostatics.cli.{name}") for name in main.COMMANDS]
    parser = main.make_parser(modules)
    about = str(parser.description).rstrip(".")
    lines = ['.TH KINETOSTATICS 1 "" kinetostatics "User Commands"', ".SH NAME", f"kinetostatics \\- {_plain(_lower(about))}"]
    lines += [".SH SYNOPSIS", *_usage(parser)]
    lines += [".SH DESCRIPTION", _plain(f"{about}, by screw theory. Every command has a page of its own below.")]
    commands: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            commands = action.choices
    lines += [".SH OPTIONS", *_options(action for action in parser._actions if action.option_strings)]
    lines += [".SH COMMANDS"]
    for name, command in commands.items():
        lines += [f".SS {_plain(name)}", *_usage(command), ".PP", _plain(" ".join(str(command.description).split()))]
        for group in command._action_groups:
            shown = [action for action in group._group_actions if not isinstance(action, argparse._HelpAction)]
            if shown:
                standard = group.title in ("positional arguments", "options")
                lines += [] if standard else [".PP", f".I {_plain(group.title or '')}", *_sentence(group.description)]
                lines += _options(shown)
        lines += _epilog(command.epilog)
    lines += [".SH EXIT STATUS"]
    lines += ["0 after success, 1 after bad news that a command tells of, 2 after an error, 130 after an interruption."]
    lines += _epilog(parser.epilog, ".SH ")
    return "\n".join(lines) + "\n"


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _sentence(text: str | None) -> list[str]:
    return [".br", _plain(" ".join(text.split()))] if text else []


def _usage(parser: argparse.ArgumentParser) -> list[str]:
    """Return how a program or command is called; what argparse makes up itself differs from one Python to the next."""
    positional = [str(action.metavar or action.dest) for action in parser._actions if not action.option_strings]
    usage = parser.usage or f"{parser.prog} {' '.join(positional)} [options]"
    program, _, rest = " ".join(usage.split()).partition(" ")
    first, _, more = rest.partition(" ")
    if parser.prog != program:  # a command: its name is written boldly too
        return [f"\\fB{_plain(program)} {_plain(first)}\\fR {_plain(more)}".rstrip()]
    return [f"\\fB{_plain(program)}\\fR {_plain(rest)}"]


def _options(actions: Iterable[argparse.Action]) -> Iterator[str]:
    formatter = argparse.HelpFormatter("kinetostatics")
    for action in actions:
        values = "" if action.nargs == 0 else formatter._format_args(action, formatter._get_default_metavar_for_optional(action))
        names = ", ".join(f"\\fB{_plain(name)}\\fR" for name in action.option_strings)
        yield ".TP"
        yield f"{names} \\fI{_plain(values)}\\fR" if names and values else names or f"\\fI{_plain(values)}\\fR"
        yield _plain(" ".join(formatter._expand_help(action).split()))


def _epilog(text: str | None, heading: str = ".PP\n.I ") -> Iterator[str]:
    """Return paragraphs of an epilog: titles that end with a colon, and lines that stand as they are below them."""
    inside = False
    for line in (text or "").splitlines():
        title = re.fullmatch(r"(\w[\w ]*):", line)
        if title or (inside and line and not line.startswith(" ")):
            yield from [".EE"] * inside
            inside = False
        if title:
            yield heading + _plain(title[1].upper() if heading.startswith(".SH") else title[1])
        elif line.startswith(" "):
            yield from [".EX"] * (not inside)
            inside = True
            yield _plain(line)
        elif line:
            yield ".PP"
            yield _plain(line)
    yield from [".EE"] * inside


def _plain(text: str) -> str:
    """Return a text whose characters mean nothing to roff; its hyphens can be copied to a shell."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{escaped}" if escaped.startswith((".", "'")) else escaped


if __name__ == "__main__":
    PAGE.write_text(manual_page(), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")
