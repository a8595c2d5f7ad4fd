"""The page of the benchmarks: tables, requirements and what became of them, what it all ran on."""

from __future__ import annotations

import re
import sys
import textwrap
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import clocks

BEGIN, END = "<!-- benchmarks: begin -->", "<!-- benchmarks: end -->"
WIDTH = 128


@dataclass
class Page:
    """What has been measured: topics, each with its tables, and requirements with what became of them."""

    requirements: list[tuple[str, str, str, str]] = field(default_factory=list)
    topics: list[str] = field(default_factory=list)

    def require(self, what: str, wanted: str, found: str, met: bool) -> None:
        """Say what became of a requirement."""
        self.requirements.append((what, wanted, found, "yes" if met else "**no**"))

    def add(self, title: str, *blocks: str) -> None:
        """Add a topic; blocks that are no tables are wrapped."""
        self.topics.append(
            "\n\n".join([f"## {title}", *(block if block.startswith("|") else wrapped(block) for block in blocks)])
        )

    def text(self, command: str, started: float) -> str:
        """Return the page between its markers."""
        took = f"{(time.time() - started) / 60:.1f} minutes, {time.strftime('%Y-%m-%d', time.gmtime())}"
        facts = [*clocks.machine(), f"command: `{command}`, {took}"]
        facts.append(f"load average of the machine at the end, with all that others did on it: {clocks.load_average():.1f}")
        head = "## What it ran on\n\n" + "\n".join(f"- {line}" for line in facts)
        rows = table(("", "wanted", "found", "met"), self.requirements, left=True)
        return "\n\n".join([head, "## What was wanted, and what came of it", rows, *self.topics])


def wrapped(text: str) -> str:
    """Return paragraphs, and lists whose items begin with a dash, in lines that are not too long."""
    found = []
    for paragraph in text.strip().split("\n\n"):
        items = re.split(r"^(?=- )", paragraph, flags=re.MULTILINE)
        lines = [
            textwrap.fill(
                " ".join(item.split()),
                WIDTH,
                subsequent_indent="  " if item.startswith("- ") else "",
                break_long_words=False,
                break_on_hyphens=False,
            )
            for item in items
            if item
        ]
        found.append("\n".join(lines))
    return "\n\n".join(found)


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: bool = False) -> str:
    """Return a Markdown table; its first column to the left, the others to the right unless ``left``."""
    lines = ["| " + " | ".join(head) + " |", "|---|" + ("---|" if left else "---:|") * (len(head) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def micro(value: float) -> str:
    """Return seconds as microseconds, three digits."""
    value *= 1e6
    return f"{value:,.0f}" if value >= 99.5 else f"{value:.1f}" if value >= 9.95 else f"{value:.2f}"


def times(value: float) -> str:
    """Return a ratio, two or three digits."""
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}"


def mebibytes(value: float) -> str:
    """Return bytes as MiB."""
    return f"{value / 2**20:,.0f} MiB"


def report(line: str) -> None:
    """Say how it goes, beside the page."""
    print(line, file=sys.stderr, flush=True)


def write(path: Path, text: str) -> None:
    """Put a text between the markers of a page.

    Raises:
        SystemExit: it has none.
    """
    old = path.read_text(encoding="utf-8")
    pattern = re.compile(f"{re.escape(BEGIN)}\n.*?{re.escape(END)}", re.DOTALL)
    if not pattern.search(old):
        raise SystemExit(f"{path} has no markers {BEGIN} … {END}")
    path.write_text(pattern.sub(lambda _: f"{BEGIN}\n\n{text}\n\n{END}", old), encoding="utf-8")
