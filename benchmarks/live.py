"""How long a live page waits for an answer: a slider moves the platform back and forth.

    python benchmarks/live.py [--write docs/how_to/viewer.md] [ROBOT …]

Processor times of one core from question to answer, both as texts; of many answers the median and, because other processes can
only make them longer, the shortest.
"""

from __future__ import annotations

import json
import time

import clocks  # noqa: F401 - before NumPy, whose libraries are to use one thread
import numpy as np
from page import measured

import kinetostatics as ks
from kinetostatics.viewer.live import LiveRobot

#: How many answers are timed, and by which part of its way the slider moves.
TIMES, STEP = 60, 0.02

HEAD = ("robot", "median", "shortest", "size")
ROBOTS = ("3rps", "2pru_upr", "delta", "gough_stewart", "ur10")


def row(name: str) -> list[str]:
    """Return median and shortest time and the size of a robot's answers."""
    robot = ks.load_robot(name)
    live = LiveRobot(robot.assemble(), lambda pose, load: ks.analyze(pose, load=load), load=[0, 0, -500, 0, 0, 0])
    live.compile(lambda: True)
    kind = "platform" if live.sliders.coordinates else "actuators"
    controls = [item for item in live.first["live"]["controls"] if item["kind"] == kind]
    values, first = {item["coordinate"]: item["value"] for item in controls}, controls[0]
    start, way = first["value"], STEP * (first["max"] - first["min"])
    seconds, text = [], ""
    for k in range(TIMES):
        values[first["coordinate"]] = start + way * (1 - 2 * (k % 2))
        question = json.dumps({"kind": kind, "values": values})
        before = time.process_time()
        text = json.dumps(live.answer(json.loads(question)))
        seconds.append(time.process_time() - before)
    return [f"`{name}`", f"{1e3 * np.median(seconds):.1f} ms", f"{1e3 * min(seconds):.1f} ms", f"{len(text) / 1e3:.0f} kB"]


if __name__ == "__main__":
    measured(__doc__, HEAD, row, "live", ROBOTS)
