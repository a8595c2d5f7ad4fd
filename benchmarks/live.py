"""How long a page takes for a pose, beside Python: loops, statics and everything that is drawn, from coordinates to numbers.

    python benchmarks/live.py [--write docs/how_to/viewer.md] [ROBOT …]

A slider moves the platform back and forth. The page runs in headless Chromium: time of its script per motion, with all numbers of
the picture, and of the equilibrium alone. Python closes the loops and analyses the same poses, one by one, by compiled code.
Times are medians; the ratio is that of page to Python.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from pathlib import Path

import clocks  # noqa: F401 - before NumPy, whose libraries are to use one thread
import numpy as np
from page import measured, times
from playwright.sync_api import sync_playwright

import kinetostatics as ks
from kinetostatics.viewer.computing import determining_coordinates

#: How many motions are timed, and by which part of the robot's length, or of a radian, the platform moves.
TIMES, STEP = 60, 0.02
LOAD = [0, 0, -500, 0, 0, 0]
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
#: Times [ms] of motions with all numbers of the picture, and of the equilibrium alone.
IN_PAGE = """([name, step, times]) => { const { machine } = robot_page, size = robot_page.scene.size, whole = [], alone = [];
  const start = machine.present("platform")[machine.lines.platform.names.indexOf(name)];
  for (let k = 0; k < times; k++) {
    const before = performance.now();
    machine.move("platform", { [name]: start + (k % 2 ? step : 0) });
    robot_page.sceneOf(machine, size);
    const between = performance.now();
    machine.solved();
    whole.push(between - before);
    alone.push(performance.now() - between);
  }
  return [whole, alone]; }"""

HEAD = ("robot", "page, a motion", "its equilibrium", "Python, a pose", "page / Python", "size of the page")
ROBOTS = ("3rps", "2pru_upr", "delta", "gough_stewart")


def in_python(pose: ks.Configuration, name: str, step: float) -> float:
    """Return the median time of a pose in Python [s]."""
    names, seconds = determining_coordinates(pose), []
    start = {key: float(pose.platform[key]) for key in names}
    for k in range(TIMES):
        before = time.process_time()
        moved = pose.robot.assemble(platform={**start, name: start[name] + step * (k % 2)}, near=pose)
        ks.analyze(moved, LOAD)
        seconds.append(time.process_time() - before)
    return float(np.median(seconds))


def row(name: str) -> list[str]:
    """Return the times of a robot and the size of its page."""
    pose = ks.load_robot(name).assemble()
    coordinate = determining_coordinates(pose)[0]
    step = STEP * (pose.robot.length if coordinate in "xyz" else 1.0)
    ks.analyze(pose.robot.assemble(near=pose), LOAD)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "page.html"
        ks.save_html(ks.analyze(pose, LOAD), file)
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        page = browser.new_page(bypass_csp=True)
        page.goto(file.as_uri())
        page.wait_for_function("window.robot_page && robot_page.ready", timeout=120_000)
        whole, alone = (float(np.median(part)) for part in page.evaluate(IN_PAGE, [coordinate, step, TIMES]))
        browser.close()
        size = file.stat().st_size
    python = 1e3 * in_python(pose, coordinate, step)
    return [f"`{name}`", f"{whole:.1f} ms", f"{alone:.2f} ms", f"{python:.1f} ms", times(whole / python), f"{size / 1e6:.2f} MB"]


if __name__ == "__main__":
    measured(__doc__, HEAD, row, "live", ROBOTS)
