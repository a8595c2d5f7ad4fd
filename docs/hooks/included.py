"""The command line's help in pages: ``<!-- help: COMMAND -->`` stands for what ``kinetostatics COMMAND --help`` prints."""

from __future__ import annotations

import contextlib
import io
import os
import re

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from kinetostatics.cli.main import main

HELP = re.compile(r"^<!-- help:(.*) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the help of commands in."""
    return HELP.sub(lambda found: f"```text\n{help_of(found[1].split())}```", markdown)


def help_of(command: list[str]) -> str:
    """Return the help of a command."""
    os.environ["COLUMNS"] = "100"  # argparse asks for the terminal's width
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        main([*command, "--help"])
    return output.getvalue()
