"""How fast workspace maps are: beside OpenSeesPy and Pinocchio, by size, with poses out of reach, on two cores.

    python benchmarks/workspace.py [--quick] [--only TOPIC …] [--write docs/benchmarks.md]

Everything that is compared is measured in this one run, in turn, again and again, and the shortest times count. Prints the tables
of ``docs/benchmarks.md``, or writes them there.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import clocks  # noqa: F401  before NumPy, whose libraries are to use one thread
from page import Page, report, write
from topics import FULL, QUICK, TINY, TOPICS, Effort


def measure(effort: Effort, topics: Sequence[str], command: str) -> str:
    """Return what comes between the markers of the page."""
    page, started = Page(), time.time()
    for topic in topics:
        TOPICS[topic](page, effort)
        report(f"{topic}: done after {time.time() - started:.0f} s")
    return page.text(command, started)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions, no map of a million poses")
    parser.add_argument("--tiny", action="store_true", help="hardly any poses: whether it runs at all")
    parser.add_argument("--only", nargs="+", choices=TOPICS, default=list(TOPICS), help="some of the topics")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write the tables between the markers of this page")
    args = parser.parse_args(arguments)
    effort = TINY if args.tiny else QUICK if args.quick else FULL
    given = sys.argv[1:] if arguments is None else arguments
    text = measure(effort, args.only, shlex.join(["python", "benchmarks/workspace.py", *given]))
    if args.write:
        write(args.write, text)
    else:
        print(text)


if __name__ == "__main__":
    main()
