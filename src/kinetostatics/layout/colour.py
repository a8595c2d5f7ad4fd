"""Colours on terminals: bold titles, yellow warnings, states by severity."""

from __future__ import annotations

import os
from typing import TextIO

#: Codes of Select Graphic Rendition (ECMA-48) by meaning.
CODES = {"title": "1", "warning": "33", "error": "1;31", "good": "32", "doubtful": "33", "bad": "31"}


def wants_colour(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal with colours.

    Non-empty environment variables: ``NO_COLOR`` disables colours, ``FORCE_COLOR`` enables them (https://no-color.org,
    https://force-color.org).
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return os.environ.get("TERM") != "dumb" and stream is not None and bool(stream.isatty())


def painted(meaning: str, text: str, colour: bool = True) -> str:
    """Return a text with the colour codes of a meaning, after its indentation."""
    bare = text.lstrip()
    return f"{text[: len(text) - len(bare)]}\033[{CODES[meaning]}m{bare}\033[0m" if colour and bare else text
