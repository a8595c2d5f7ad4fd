"""The blocks of the documentation's pages, and how they are run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from places import ROOT

from kinetostatics.cli.main import main

DOCS = ROOT / "docs"
_BLOCK = re.compile(
    r"(?:<!-- (?P<mark>(?:lift|shows)[^>]*?) -->\n)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE
)


@dataclass(frozen=True)
class Block:
    """A block of a page: where its text begins and ends in it, its language, and the mark above it."""

    kind: str
    mark: str
    text: str
    start: int
    end: int


def blocks(page: str) -> list[Block]:
    """Return all blocks of a page, in order."""
    return [
        Block(found["kind"], found["mark"] or "", found["text"], found.start("text"), found.end("text"))
        for found in _BLOCK.finditer(page)
    ]


def text_of(name: str) -> str:
    """Return the text of a page, by its path below ``docs`` without the ending."""
    return (DOCS / f"{name}.md").read_text(encoding="utf-8")


def between(text: str, name: str) -> str:
    """Return what stands between the markers of a name in a text."""
    found = re.search(rf"<!-- {name}: begin -->\n(.*?)<!-- {name}: end -->", text, re.DOTALL)
    assert found, name
    return found[1]


def python_of(name: str) -> list[str]:
    """Return a page's blocks of Python."""
    return [block.text for block in blocks(text_of(name)) if block.kind == "python"]


def run_python(name: str, swaps: Mapping[str, str] = MappingProxyType({})) -> dict[str, Any]:
    """Run a page's Python, block after block, and return its names; ``swaps`` of its text make it shorter."""
    code = python_of(name)
    assert all(any(old in block for block in code) for old in swaps)
    names: dict[str, Any] = {}
    for block in code:
        for old, new in swaps.items():
            block = block.replace(old, new)
        exec(compile(block, f"{name}.md", "exec"), names)  # the page's own text
    return names


def commands(name: str) -> list[list[str]]:
    """Return the arguments of a page's commands."""
    text = "".join(block.text for block in blocks(text_of(name)) if block.kind == "sh").replace("\\\n", " ")
    return [shlex.split(line, comments=True)[1:] for line in text.splitlines() if line.startswith("kinetostatics ")]


def run_commands(name: str, own: tuple[str, ...] = ()) -> int:
    """Run a page's commands in turn but for those that need a file of the reader's ``own``, and return how many there were."""
    wanted = [command for command in commands(name) if not set(command) & set(own)]
    for command in wanted:
        assert main(command) == 0, shlex.join(command)
    return len(wanted)


def in_a_copy(folder: Path) -> None:
    """Make paths that begin at the repository's root lead there from an empty folder."""
    for part in ("examples", "robots", "tests"):
        (folder / part).symlink_to(ROOT / part)
