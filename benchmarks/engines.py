"""What compiled code brings to ``analyze``: NumPy and compiled code alternately, in one process and on one core.

    python benchmarks/engines.py [--write docs/how_to/compiled.md] [ROBOT …]

Processor times; the shortest of several counts, because other processes can only make them longer.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import kinetostatics as ks
from kinetostatics.engine.statics import CompiledStatics

ROBOTS = ("3rps", "2pru_upr", "gough_stewart", "delta", "anymal_standing")
#: Poses of a batch.
MANY = 4000
#: How often each is measured.
TIMES = 7


def shortest(*functions: Callable[[], object]) -> list[float]:
    """Return the shortest processor times [s] of functions, called in turn."""
    best = [float("inf")] * len(functions)
    for _ in range(TIMES):
        for k, function in enumerate(functions):
            start = time.process_time()
            function()
            best[k] = min(best[k], time.process_time() - start)
    return best


def row(name: str) -> str:
    """Return a robot's line of the table."""
    robot = ks.load_robot(name)
    start = time.process_time()
    compiled = CompiledStatics(robot.statics)
    making = time.process_time() - start
    one = robot.assemble()
    many = robot.configuration(np.repeat(one.q[None], MANY, axis=0))
    times = []
    for pose in (one, many):
        times += shortest(*(lambda e=e, p=pose: ks.analyze(p, engine=e).twist for e in ("numpy", "compiled")))  # type: ignore[misc]
    found = shortest(lambda: CompiledStatics.kept(robot.statics))[0]
    alone, batch = times[:2], [1e6 * t / MANY for t in times[2:]]
    return (
        f"| `{name}` | {compiled.operations:,} | {1e3 * alone[0]:.2f} → {1e3 * alone[1]:.2f} ms, {alone[0] / alone[1]:.0f} × | "
        f"{batch[0]:.1f} → {batch[1]:.2f} µs, {batch[0] / batch[1]:.1f} × | {making:.1f} s | {1e3 * found:.0f} ms |"
    )


def main() -> None:
    """Measure, and print the table or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--write", type=Path)
    args = parser.parse_args()
    lines = [
        f"| robot | operations | `analyze(pose).twist` | a pose of {MANY:,} | making the code | taking it from the disk |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for name in args.robots:
        lines.append(row(name))
        print(lines[-1], flush=True)
    if args.write:
        table = "\n".join(["<!-- engines: begin -->", "", *lines, "", "<!-- engines: end -->"])
        page = args.write.read_text(encoding="utf-8")
        page = re.sub("<!-- engines: begin -->.*<!-- engines: end -->", lambda _: table, page, flags=re.DOTALL)
        args.write.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
