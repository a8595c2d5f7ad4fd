"""Times of workspace maps: compared with OpenSeesPy, and by the number of poses.

    python benchmarks/workspace.py [--quick] [--only TOPIC …] [--write docs/explanation/benchmarks.md]

Everything that is compared is measured in this one run, in turn, again and again, and the shortest times count. Prints the tables
of ``docs/explanation/benchmarks.md``, or writes them there.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import clocks  # before NumPy, whose libraries are to use one thread
from page import Page, report, write
from topics import FULL, QUICK, TINY, TOPICS


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions, no map of a million poses")
    parser.add_argument("--tiny", action="store_true", help="hardly any poses: whether it runs at all")
    parser.add_argument("--only", nargs="+", choices=TOPICS, default=list(TOPICS), help="some of the topics")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write the tables between the markers of this page")
    args = parser.parse_args(arguments)
    effort = TINY if args.tiny else QUICK if args.quick else FULL
    page, started = Page(), time.time()
    os.environ["KINETOSTATICS_ENGINE"] = "numpy"  # what the page is about; benchmarks/engines.py has compiled code
    for topic in args.only:
        TOPICS[topic](page, effort)
        report(f"{topic}: done after {time.time() - started:.0f} s")
    command = shlex.join(["python", "benchmarks/workspace.py", *(sys.argv[1:] if arguments is None else arguments)])
    facts = [
        *clocks.machine(),
        f"command: `{command}`, {(time.time() - started) / 60:.1f} minutes, {clocks.today()}",
        f"load average of the machine at the end: {os.getloadavg()[0]:.1f}",
    ]
    found = {"machine": "\n".join(f"- {line}" for line in facts), **page.topics}
    if args.write:
        write(args.write, found)
    else:
        print("\n\n".join(f"## {topic}\n\n{numbers}" for topic, numbers in found.items()))


if __name__ == "__main__":
    main()
