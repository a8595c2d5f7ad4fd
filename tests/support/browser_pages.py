"""Pages of the viewer in headless Chromium: opened, operated and looked at."""

import base64
import gzip
import json
import time
from contextlib import contextmanager
from functools import partial

import numpy as np

LOAD = [100, 50, -500, 10, 20, -5]
POSES = {"3rps": {"z": 0.5, "rx": 0.03, "ry": -0.17}, "2pru_upr": {"z": 0.6, "rx": 0.1, "ry": 0.1}}

#: Vertices of the object at a path of meshcat's tree, in world axes; null if there is none (``find()`` would make it).
VERTICES = """(path) => {
  let node = viewer.scene_tree;
  for (const name of [...path.split("/"), "<object>"]) { node = node.children[name]; if (!node) return null; }
  viewer.scene.updateMatrixWorld(true);
  const toWorld = viewer.scene.matrixWorld.clone().invert().multiply(node.object.matrixWorld), out = [];
  const p = node.object.geometry.attributes.position, v = new MeshCat.THREE.Vector3();
  for (let i = 0; i < p.count; i++) out.push(v.fromBufferAttribute(p, i).applyMatrix4(toWorld).toArray());
  return out;
}"""
LABELS = """[...document.querySelectorAll('.robot-label')].filter(e => e.style.visibility === 'visible')
  .map(e => [e.textContent, ...((r) => [r.left, r.top, r.right, r.bottom])(e.getBoundingClientRect())])"""
STAGE = "(r => [r.left, r.top, r.right, r.bottom])(document.querySelector('#robot-stage').getBoundingClientRect())"
#: Tail and tip of an arrow of the page, in world axes.
ENDS = """(path) => { const { object, size, spec } = robot_page.arrows.get(path), start = object.position.clone();
  const along = new MeshCat.THREE.Vector3(0, size * spec.metres_per_unit, 0).applyQuaternion(object.quaternion);
  return [start.toArray(), start.clone().add(along).toArray()]; }"""
NAMES = """(path) => { let node = viewer.scene_tree;
  for (const name of path.split("/")) node = node.children[name];
  return Object.keys(node.children).filter(name => name !== "<object>"); }"""


def wait(page, expression, arg=None, timeout=90):
    """Wait until an expression is true; Playwright's own function evaluates a text, which the pages' policy forbids."""
    end = time.monotonic() + timeout
    while not page.evaluate(expression, arg):
        assert time.monotonic() < end, expression
        page.wait_for_timeout(20)


@contextmanager
def visits(browser):
    """Open pages; in the end nothing may have been logged and, for a file, nothing asked of the network."""
    contexts = []

    def open_page(url, size=(640, 480), offline=True):
        context = browser.new_context(viewport={"width": size[0], "height": size[1]}, offline=offline)
        page = context.new_page()
        page.set_default_timeout(90_000)  # a busy machine draws slowly
        problems, requests = [], []
        page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.wait_for_function = partial(wait, page)
        page.goto(url)
        page.wait_for_function("window.robot_page && robot_page.ready && (robot_page.state.playing || !viewer.needs_render)")
        contexts.append((context, problems, requests if offline else []))
        return page

    yield open_page
    for context, problems, requests in contexts:
        assert problems == []
        assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
        context.close()


def packed_in(html):
    """The scene that the text of a page holds, compressed."""
    data = html.partition('<script id="robot-packed" type="text/plain">')[2].partition("</script>")[0]
    return json.loads(gzip.decompress(base64.b64decode(data)))["scene"]


def vertices(page, path):
    found = page.evaluate(VERTICES, path)
    return None if found is None else np.array(found)


def rings(points, stations=21, sides=24):
    """Centres of a swept round beam's rings."""
    return points[: stations * sides].reshape(stations, sides, 3).mean(axis=1)


def move(page, name, value):
    """Drag the slider of this name to a value."""
    page.evaluate(
        """([name, value]) => { const input = document.querySelector(`input[type=range][name="${name}"]`);
          input.value = value; input.dispatchEvent(new Event("input")); }""",
        [name, value],
    )


def value_of(page, name):
    """Where the slider of this name stands."""
    return float(page.evaluate('name => document.querySelector(`input[type=range][name="${name}"]`).value', name))


def settle(page):
    """Wait until the page has drawn twice; an awaited promise would wait without end for a browser that hangs."""
    page.wait_for_function("!viewer.needs_render")
    page.evaluate("() => { window.drawn = false; requestAnimationFrame(() => requestAnimationFrame(() => { drawn = true; })); }")
    page.wait_for_function("drawn")
