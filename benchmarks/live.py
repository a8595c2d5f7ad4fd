"""How long a page takes from a moved slider to the numbers of its new scene, beside Python for the same pose.

    python benchmarks/live.py [--write docs/how_to/viewer.md] [ROBOT …]

The page's script runs in Node.js, without the drawing itself. Median of many steps; size of the page with all scripts.
"""

from __future__ import annotations

import json
import subprocess
import time
from importlib.resources import files

import clocks  # noqa: F401 - before NumPy, whose libraries are to use one thread
import numpy as np
from page import measured

import kinetostatics as ks
from kinetostatics.viewer import _page
from kinetostatics.viewer.computing import computing_page
from kinetostatics.viewer.scene import describe_scene

#: How many poses are timed, and by how much the first coordinate moves to and fro [m, rad].
TIMES, STEP = 200, 2e-3

HEAD = ("robot", "page", "Python", "ratio", "size")
ROBOTS = ("3rps", "2pru_upr", "delta", "gough_stewart", "ur10")
_RUN = """
let text = "";
process.stdin.on("data", (part) => { text += part; }).on("end", async () => {
  const { data, kind, name, step, times } = JSON.parse(text), machine = await Machine.load(data), seconds = [];
  const start = machine.closed(machine.pose)[kind][name];
  for (let k = 0; k < times; k++) {
    const before = performance.now();
    machine.move(kind, { [name]: start + step * (k % 2) });
    sceneOf(machine, 1);
    seconds.push(performance.now() - before);
  }
  console.log(seconds.sort((a, b) => a - b)[Math.floor(times / 2)]);
});
"""


def row(name: str) -> list[str]:
    """Return the median times of page and Python, their ratio, and the size of the page."""
    robot = ks.load_robot(name)
    pose = robot.assemble()
    result = ks.analyze(pose, load=[0, 0, -500, 0, 0, 0])
    data = computing_page(result)
    kind = "platform" if "platform" in data["lines"] else "actuators"
    names = data["lines"][kind]["names"]
    question = {"data": data, "kind": kind, "name": names[0], "step": STEP, "times": TIMES}
    assets = files("kinetostatics.viewer") / "assets"
    source = "".join((assets / asset).read_text(encoding="utf-8") for asset in ("unpacking.js", "engine.js")) + _RUN
    run = subprocess.run(["node", "-e", source], input=json.dumps(question), capture_output=True, text=True, check=True)
    present = {coordinate: float(getattr(pose, kind)[coordinate]) for coordinate in names}
    seconds, near = [], pose
    for k in range(TIMES // 10):
        before = time.process_time()
        near = robot.assemble(**{kind: {**present, names[0]: present[names[0]] + STEP * (k % 2)}}, near=near)
        describe_scene(ks.analyze(near, load=[0, 0, -500, 0, 0, 0])).plain()
        seconds.append(time.process_time() - before)
    mine, python = float(run.stdout), 1e3 * float(np.median(seconds))
    page = _page(result, None, None, None, False, None)
    return [f"`{name}`", f"{mine:.2f} ms", f"{python:.0f} ms", f"1 : {python / mine:.0f}", f"{len(page) / 1e3:,.0f} kB"]


if __name__ == "__main__":
    measured(__doc__, HEAD, row, "live", ROBOTS)
