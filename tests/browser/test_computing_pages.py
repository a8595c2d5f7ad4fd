"""Pages that compute, in browsers: dragged at random they show what Python computes, without network, in flat memory."""

import base64
import io
import shutil
import time

import numpy as np
import package_robots
import pytest
from browser_pages import settle, wait
from firefox import FIREFOX, visited
from page_machine import relative
from PIL import Image as image

import kinetostatics as ks
from kinetostatics.viewer.computing import determining_coordinates

QUICK = ("3rps",)
#: Numbers of drags, if not 200; poses of ANYmal take long in Python.
COUNTS = {"3rps": 30, "anymal_standing": 50}
ROBOTS = [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in package_robots.NAMES]
#: Moves a random slider of platform, actuators, load, gravity or payload by a part of its track, n times, without drawing.
DRAG = """([count, seed, part]) => { let state = seed; window.answers = [];
  const random = () => { state = (1103515245 * state + 12345) % 2147483648; return state / 2147483648; };
  const inputs = [...document.querySelectorAll("#robot-controls input[type=range]")].filter(({ name }) => name.includes(": "));
  const next = () => {
    const input = inputs[Math.floor(random() * inputs.length)], [low, high] = [Number(input.min), Number(input.max)];
    input.value = Math.min(Math.max(Number(input.value) + part * (2 * random() - 1) * (high - low), low), high);
    input.dispatchEvent(new Event("input"));
    const shown = () => { if (robot_page.busy) { requestAnimationFrame(shown); return; }
      const { load, gravity, payload } = robot_page.machine.loads;
      window.answers.push({ ...kinetostatics.analyze(), loads: { load: [...load], gravity: [...gravity], payload: [...payload] },
        shown: [0, 1, 2, 3, 4, 5].map((_, c) => robot_page.readout(null)[c]) });
      if (window.answers.length < count) next();
    };
    requestAnimationFrame(shown);
  };
  next(); }"""


def start_of(name):
    """Return a pose from which the platform can move."""
    robot = package_robots.robot(name)
    return robot.assemble(actuators=dict.fromkeys(robot.description.actuated, 0.3)) if name == "ur10" else robot.assemble()


def dragged(page, count, seed=1, part=0.1):
    """Return what the page answers and shows after each of some random drags."""
    page.evaluate(DRAG, [count, seed, part])
    wait(page, f"answers.length === {count}", timeout=20 * count)
    return page.evaluate("answers")


@pytest.mark.parametrize("name", ROBOTS)
def test_random_drags_show_what_python_computes(name, visit, tmp_path):
    """Of the pose that the page has reached, and of its loads; the picture shows single precision."""
    start = start_of(name)
    ks.save_html(ks.analyze(start), tmp_path / "page.html")
    page, robot, compared = visit((tmp_path / "page.html").as_uri()), start.robot, 0
    for answer in dragged(page, COUNTS.get(name, 200)):
        payload = ks.Payload(answer["loads"]["payload"][0], answer["loads"]["payload"][1:])
        at = {key: answer["platform"][key] for key in determining_coordinates(start)}
        pose = robot.assemble(platform=at, near=start, on_failure="nan")
        result = ks.analyze(pose, answer["loads"]["load"], answer["loads"]["gravity"], payload=payload, on_failure="nan")
        if not pose.reached or relative(list(answer["actuators"].values()), list(pose.actuators.values())) > 1e-6:
            continue  # another assembly mode, or branch of turns, than by the drags
        assert answer["status"] == str(ks.Status(int(result.status)))
        if answer["twist"] is None:
            continue
        compared += 1
        # next to a singular pose, where the platform would move by metres, the rounding of the pose matters
        close = 1e-9 if np.linalg.norm(result.twist[:3]) < robot.length else 1e-6
        assert relative(answer["twist"], result.twist) < close
        assert relative(answer["stiffness"], result.stiffness) < close
        assert relative(list(answer["actuator_forces"].values()), list(result.actuator_forces.values())) < close
        assert relative(answer["shown"], result.twist) < 1e-6
    assert compared > COUNTS.get(name, 200) / 2


def heap(page):
    """Memory used by the page after a collection [bytes], and number of geometries and textures in the graphics card."""
    session = page.context.new_cdp_session(page)
    for _ in range(3):
        session.send("HeapProfiler.collectGarbage")
    used = session.send("Runtime.getHeapUsage")["usedSize"]
    session.detach()
    return used, page.evaluate("(({ geometries, textures }) => geometries + textures)(viewer.renderer.info.memory)")


@pytest.mark.slow
def test_memory_is_flat_after_thousands_of_random_drags(visit, tmp_path):
    ks.save_html(ks.analyze(start_of("3rps")), tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri())
    measured = []
    for seed, count in ((1, 200), (2, 1000), (3, 1000)):
        dragged(page, count, seed)
        page.evaluate("window.answers = []")
        settle(page)
        measured.append(heap(page))
    used, objects = zip(*measured, strict=True)
    assert max(used) < used[0] + 1e6, used
    assert len(set(objects)) == 1, objects


@pytest.mark.slow
@pytest.mark.skipif(
    FIREFOX is None or shutil.which("Xvfb") is None, reason="a second browser, which only this test needs, is not installed"
)
def test_firefox_draws_and_computes_the_same(tmp_path):
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.03, "ry": -0.17})
    ks.save_html(ks.analyze(pose), tmp_path / "page.html")
    with visited((tmp_path / "page.html").as_uri(), tmp_path / "profile") as run:
        end = time.monotonic() + 120
        while not run("return !!(window.robot_page && robot_page.ready)"):
            assert time.monotonic() < end
            time.sleep(0.2)
        answer = run("return kinetostatics.analyze({ platform: { z: 0.5, rx: 0.1, ry: 0 }, load: [0, 0, -500, 0, 0, 0] })")
        data = run("return robot_page.picture(1)")
    result = ks.analyze(robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0}), [0, 0, -500, 0, 0, 0])
    assert answer["status"] == "OK" and relative(answer["twist"], result.twist) < 1e-12
    assert relative(answer["stiffness"], result.stiffness) < 1e-12
    seen = np.asarray(image.open(io.BytesIO(base64.b64decode(data.partition(",")[2]))).convert("RGB")).astype(int)
    assert (np.ptp(seen, axis=2) > 40).mean() > 0.02  # the coloured robot
