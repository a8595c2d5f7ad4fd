"""Colour on terminals that want it: headings, warnings and statuses of a report stand out. The text itself stays what it is."""

from __future__ import annotations

import os
import re
from typing import TextIO

from kinetostatics.status import FACTS, WITHOUT_NUMBERS, Status

BOLD, RED, GREEN, YELLOW = "1", "31", "32", "33"

#: What is true of a pose, and what a comparison says: words that reports write like this and nothing else.
_COLOURS = {
    Status.OK.name: GREEN,
    **{fact.title: YELLOW if fact.status is not None else RED for fact in FACTS.values()},
    **{status.name: RED for status in WITHOUT_NUMBERS},
    "DIFFERS": RED,
    "NOT verified": RED,
    "Not verified": YELLOW,
    "Verified": GREEN,
}
_WORDS = re.compile(rf"(?<![\w'])(?:{'|'.join(_COLOURS)})(?![\w'])")
#: A warning of a report, or of standard error.
_WARNING = re.compile(r"\s*! |kinetostatics: warning: ")
_ERROR = "kinetostatics: error:"


def wants_colour(stream: TextIO | None) -> bool:
    """Return whether a stream is to be written in colour.

    It is where the stream is a terminal that can show colours; ``NO_COLOR`` forbids it, ``FORCE_COLOR`` demands it
    (https://no-color.org, https://force-color.org), if they are not empty.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return os.environ.get("TERM") != "dumb" and stream is not None and bool(stream.isatty())


def for_stream(text: str, stream: TextIO | None) -> str:
    """Return a text as a stream is to show it: in colour where that is wanted, else as it stands."""
    return coloured(text) if wants_colour(stream) else text


def coloured(text: str) -> str:
    """Return a report with its headings in bold type, its warnings in yellow, and its statuses in what they mean.

    Without the codes for colours it is the text that was given, to the byte.
    """
    lines: list[str] = []
    before, indent = "", None  # indent: of the warning that goes on
    for line in text.split("\n"):
        depth = len(line) - len(line.lstrip())
        goes_on = indent is not None and depth > indent and bool(line.strip())
        if _WARNING.match(line) or goes_on:
            indent = indent if goes_on else depth
            lines.append(_in(YELLOW, line))
        else:
            indent = None
            is_heading = bool(line) and depth == 0 and not before
            if line.startswith(_ERROR):
                lines.append(_in(f"{BOLD};{RED}", _ERROR) + line.removeprefix(_ERROR))
            else:
                status = _WORDS.search(line)
                start = (status.start() if status else len(line)) if is_heading else 0
                words = _WORDS.sub(lambda found: _in(_COLOURS[found[0]], found[0]), line[start:])
                lines.append((_in(BOLD, line[:start]) if start else "") + words)
        before = line
    return "\n".join(lines)


def _in(code: str, text: str) -> str:
    """Return a text in a colour, its indentation without it."""
    bare = text.lstrip()
    return f"{text[: len(text) - len(bare)]}\033[{code}m{bare}\033[0m"
