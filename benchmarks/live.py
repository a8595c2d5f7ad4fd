"""How long a live page waits for an answer: a slider moves the platform back and forth.

    python benchmarks/live.py [ROBOT …]

Processor times of one core from question to answer, both as texts; of many answers the median and, because other processes can
only make them longer, the shortest.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import time

import numpy as np

import kinetostatics as ks
from kinetostatics.viewer.live import LiveRobot

#: How many answers are timed, and by which part of its way the slider moves.
TIMES, STEP = 60, 0.02

#: The arrows that a page shows at first.
SEEN = ["external load", "actuator forces"]


def answers(name: str, engine: str, told: bool) -> str:
    """Return times and size of a robot's answers, with notes and cards if they are told."""
    os.environ["KINETOSTATICS_ENGINE"] = engine
    robot = ks.load_robot(name)
    live = LiveRobot(robot.assemble(), lambda pose, load: ks.analyze(pose, load=load), load=[0, 0, -500, 0, 0, 0])
    live.compile(lambda: True)
    kind = "platform" if live.coordinates else "actuators"
    values = {item["coordinate"]: item["value"] for item in live.controls if item["kind"] == kind}
    first = next(item for item in live.controls if item["kind"] == kind)
    start, way = first["value"], STEP * (first["max"] - first["min"])
    seconds, text = [], ""
    for k in range(TIMES):
        values[first["coordinate"]] = start + way * (1 - 2 * (k % 2))
        question = json.dumps({"kind": kind, "values": values, "told": told, "groups": None if told else SEEN})
        before = time.process_time()
        text = json.dumps(live.answer(json.loads(question)))
        seconds.append(time.process_time() - before)
    return f"{1e3 * np.median(seconds):.1f} ({1e3 * min(seconds):.1f}) ms, {len(text) / 1e3:.0f} kB"


def main() -> None:
    """Print a line for every robot."""
    parser = argparse.ArgumentParser(description="Time the answers to a live page.")
    parser.add_argument("robots", nargs="*", default=["3rps", "2pru_upr", "delta", "gough_stewart", "ur10"])
    print("| robot | NumPy, everything | NumPy, what is seen | compiled |\n|---|---:|---:|---:|")
    for name in parser.parse_args().robots:
        cells = [answers(name, *way) for way in (("numpy", True), ("numpy", False), ("compiled", False))]
        print(f"| `{name}` | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
