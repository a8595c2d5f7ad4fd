"""Panel, views and keys of a page, operated by mouse and keyboard; all tests share a page and restore it."""

import numpy as np
import pytest
from browser_pages import STAGE, settle

import kinetostatics as ks

#: Window sizes of a desktop, a laptop, a notebook's cell, and a phone upright and on its side.
WINDOWS = [(1400, 850), (1024, 600), (760, 640), (390, 780), (740, 360)]
#: Least and greatest place of anything drawn of the robot, in pixels of its part of the page.
EXTENT = """() => { const box = [Infinity, Infinity, -Infinity, -Infinity], pane = document.getElementById("meshcat-pane");
  const v = new MeshCat.THREE.Vector3();
  viewer.scene.updateMatrixWorld(true);
  for (const { mesh } of robot_page.solids.values()) {
    const p = mesh.geometry.attributes.position;
    for (let k = 0; k < p.count; k++) {
      v.fromBufferAttribute(p, k).applyMatrix4(mesh.matrixWorld).project(viewer.camera);
      const x = (0.5 + 0.5 * v.x) * pane.offsetWidth, y = (0.5 - 0.5 * v.y) * pane.offsetHeight;
      box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y); box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], y);
    }
  }
  return box; }"""
#: Direction from the robot to the camera, in world axes.
FROM = """() => { const d = viewer.camera.position.clone().sub(viewer.controls.target).normalize(); return [d.x, -d.z, d.y]; }"""


@pytest.mark.slow
def test_robot_and_panels_do_not_overlap_in_any_window(page):
    for width, height in WINDOWS:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_function(
            "pane => pane.offsetWidth === viewer.renderer.domElement.clientWidth", arg=page.query_selector("#meshcat-pane")
        )
        settle(page)
        left, top, right, bottom = page.evaluate(STAGE)
        found = page.evaluate(EXTENT)
        assert found[0] >= 0 and found[1] >= 0 and found[2] <= right - left and found[3] <= bottom - top, (width, height)
        assert found[2] - found[0] > 0.5 * (right - left) or found[3] - found[1] > 0.5 * (bottom - top), (width, height)
        boxes = page.evaluate(
            """['panel', 'head', 'stage', 'legend'].map(name => document.getElementById(`robot-${name}`).getBoundingClientRect())
               .map(r => [r.left, r.top, r.right, r.bottom])"""
        )
        for k, (a, b, c, d) in enumerate(boxes):
            assert a >= 0 and b >= 0 and c <= width and d <= height and c - a > 100 and d - b > 10, (width, height)
            for x, y, u, v in boxes[k + 1 :]:
                assert a >= u - 1 or c <= x + 1 or b >= v - 1 or d <= y + 1, (width, height)
        assert bottom - top > 0.25 * height
        head = page.inner_text("#robot-head")
        for words in (
            "z 600 mm",
            "ry 5.73°",
            "gravity (0, 0, −9.81) m/s²",
            "load at o (100, 50, −500) N, (10, 20, −5) N·m",
            "drawn × ",
        ):
            assert words in head
    page.set_viewport_size({"width": 1000, "height": 640})


def test_views_have_their_direction_and_show_the_whole_robot(page):
    home = page.evaluate(FROM)
    for name, direction in (("top", [0, 0, 1]), ("front", [0, -1, 0]), ("side", [1, 0, 0])):
        page.click(f"#robot-tools button:text-is('{name}')")
        np.testing.assert_allclose(page.evaluate(FROM), direction, atol=2e-3)
        left, top, right, bottom = page.evaluate(STAGE)
        found = page.evaluate(EXTENT)
        assert found[0] >= 0 and found[1] >= 0 and found[2] <= right - left and found[3] <= bottom - top
    page.evaluate("viewer.controls.target.x += 5; viewer.controls.update()")
    moved = page.evaluate(FROM)
    page.keyboard.press("f")
    np.testing.assert_allclose(page.evaluate(FROM), moved, atol=1e-6)
    found = page.evaluate(EXTENT)
    assert found[0] >= 0 and found[2] <= right - left
    page.keyboard.press("0")
    np.testing.assert_allclose(page.evaluate(FROM), home, atol=1e-6)


def test_keyboard_shortcuts_work_as_listed_in_the_help(page):
    page.keyboard.press("?")
    assert "these keys" in page.inner_text("#robot-help")
    page.keyboard.press("Escape")
    assert page.is_hidden("#robot-help")
    before = page.evaluate("robot_page.state.exaggeration")
    page.keyboard.press("+")
    assert page.evaluate("robot_page.state.exaggeration") == pytest.approx(1.25 * before)
    page.keyboard.press("-")
    assert page.evaluate("robot_page.state.exaggeration") == pytest.approx(before)
    for key, root, name in (("r", "Rest", "robot at rest (pale)"), ("a", "Arrows", "all of these"), ("l", "Labels", "names")):
        for seen in (False, True):
            page.keyboard.press(key)
            assert page.evaluate("root => viewer.scene_tree.children[root].object.visible", root) is seen
            settle(page)
            assert page.evaluate("name => document.querySelector(`input[name='${name}']`).checked", name) is seen
    page.keyboard.press("p")
    assert page.is_hidden("#robot-panel")
    page.keyboard.press("p")
    assert page.is_visible("#robot-panel")
    page.locator("summary", has_text="Contributions").click()
    page.focus("input[name='share: load']")
    page.keyboard.press("1")  # a digit typed into a field chooses no view
    assert page.evaluate(FROM)[0] != 0
    page.locator("summary", has_text="Contributions").click()


def test_dark_mode_follows_preference_and_key(page):
    def ground():
        return page.evaluate("getComputedStyle(document.body).backgroundColor")

    light = ground()
    page.emulate_media(color_scheme="dark")
    page.wait_for_function("robot_page.dark")
    dark = ground()
    assert sum(map(int, light[4:-1].split(","))) > 700 and sum(map(int, dark[4:-1].split(","))) < 120
    top = page.evaluate("viewer.scene_tree.find(['Background']).object.top_color")
    assert max(top) < 40  # of 255
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("d")
    assert ground() == light
    page.emulate_media(color_scheme="light")
    settle(page)
    assert ground() == light


def test_a_message_covers_neither_the_picture_nor_the_legend(visit, result, tmp_path):
    """It has a place of its own on pages that move, as long as it is one line."""
    ks.save_html(result, tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri(), (1000, 640))
    page.evaluate("""() => { const place = document.getElementById("robot-message");
      document.body.classList.add("live"); place.hidden = false; place.children[0].textContent = "z ends at 600 mm";
      place.children[1].hidden = true; }""")
    for width, height in WINDOWS:
        page.set_viewport_size({"width": width, "height": height})
        settle(page)
        stage, message, legend = page.evaluate(
            """["stage", "message", "legend"].map(name => document.getElementById(`robot-${name}`).getBoundingClientRect())
               .map(box => [box.top, box.bottom])"""
        )
        assert stage[1] <= message[0] < message[1] <= legend[0], (width, height)
