"""What pages take from elsewhere: the command line's help and parts of README.md.

``<!-- help: COMMAND -->`` stands for what ``kinetostatics COMMAND --help`` prints, ``<!-- readme: NAME -->`` for what stands in
README.md between ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->``.
"""

from __future__ import annotations

import contextlib
import io
import os
import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from kinetostatics.cli.main import main

README = Path(__file__).resolve().parents[2] / "README.md"
HELP = re.compile(r"^<!-- help:(.*) -->$", re.MULTILINE)
PART = re.compile(r"^<!-- readme: (.*) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put them in."""
    folder = posixpath.dirname(page.file.src_uri)
    text = HELP.sub(lambda found: f"```text\n{help_of(found[1].split())}```", markdown)
    return PART.sub(lambda found: part_of_readme(found[1], folder), text)


def help_of(command: list[str]) -> str:
    """Return the help of a command."""
    os.environ["COLUMNS"] = "100"  # argparse asks for the terminal's width
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        main([*command, "--help"])
    return output.getvalue()


def part_of_readme(name: str, folder: str) -> str:
    """Return a part of README.md with its links as seen from a folder of ``docs/``."""
    text = README.read_text(encoding="utf-8").partition(f"<!-- {name}: begin -->\n")[2].partition(f"<!-- {name}: end -->")[0]
    if not text:
        raise ValueError(f"README.md has no part {name!r}")
    return re.sub(r"\]\(docs/([^)#]+)", lambda found: f"]({posixpath.relpath(found[1], folder)}", text)
