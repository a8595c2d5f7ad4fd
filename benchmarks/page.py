"""The page of the benchmarks: what is measured is put between the markers of its topics."""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Page:
    """What has been measured: tables of topics."""

    topics: dict[str, str] = field(default_factory=dict)

    def add(self, topic: str, *blocks: str) -> None:
        """Add tables and sentences of a topic."""
        self.topics[topic] = "\n\n".join(blocks)


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


def markers(topic: str) -> tuple[str, str]:
    """Return what stands on the page before and behind the numbers of a topic."""
    return f"<!-- {topic}: begin -->", f"<!-- {topic}: end -->"


def write(path: Path, topics: dict[str, str]) -> None:
    """Put topics between their markers on a page; others stay as they are.

    Raises:
        SystemExit: markers are missing.
    """
    text = path.read_text(encoding="utf-8")
    for topic, numbers in topics.items():
        begin, end = markers(topic)
        text, count = re.subn(f"{begin}\n.*?{end}", lambda _: f"{begin}\n\n{numbers}\n\n{end}", text, flags=re.DOTALL)  # noqa: B023
        if count != 1:
            raise SystemExit(f"{path} has no markers {begin} … {end}")
    path.write_text(text, encoding="utf-8")


def measured(
    description: str | None, head: Sequence[str], row: Callable[[str], Sequence[str]], topic: str, robots: Sequence[str] = ()
) -> None:
    """Run a benchmark that has one line for each robot: print its table and what it ran on, or write both into a page.

    Args:
        description: of the command.
        head: of the table.
        row: measures a robot, whose code is compiled anew.
        topic: between whose markers the table goes.
        robots: which are measured, if the command does not say; none: all that come with the package.
    """
    import clocks

    import kinetostatics as ks

    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=robots or [str(robot) for robot in ks.robots()])
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write both between the markers of this page")
    args, rows = parser.parse_args(), []
    with tempfile.TemporaryDirectory() as folder:
        os.environ["KINETOSTATICS_CACHE"] = folder
        for name in args.robots:
            rows.append(row(name))
            report(" | ".join(rows[-1]))
    found = f"{table(head, rows)}\n\n{clocks.origin()}"
    if args.write:
        write(args.write, {topic: found})
    else:
        print(found)
