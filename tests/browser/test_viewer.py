"""The viewer's pages in headless Chromium: geometry, numbers, arrows and labels while sliders and handles are moved."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from browser_pages import LABELS, LOAD, NAMES, POSES, STAGE, move, rings, settle, value_of, vertices, wait
from scipy.spatial.transform import Rotation

import kinetostatics as ks
from kinetostatics.viewer.page import iframe_html
from kinetostatics.viewer.scene import describe_scene

#: For each visible label: text, anchor and box on the screen, and whether it has a leader line.
ANCHORS = """robot_page.labels.filter(l => l.element.style.visibility === 'visible').map(l => {
  const p = l.anchor.getWorldPosition(new MeshCat.THREE.Vector3()).project(viewer.camera);
  const stage = viewer.dom_element.getBoundingClientRect();
  const r = l.element.getBoundingClientRect();
  return [l.text(), stage.left + (0.5 + 0.5 * p.x) * stage.width, stage.top + (0.5 - 0.5 * p.y) * stage.height,
    r.left, r.top, r.right, r.bottom, l.leader.style.visibility === 'visible'];
})"""
#: Tail and tip of an arrow on the screen; whether a label is visible.
ON_SCREEN = """(path) => { const { object, size, spec } = robot_page.arrows.get(path);
  const stage = viewer.dom_element.getBoundingClientRect();
  return [0, size * spec.metres_per_unit].map((y) => {
    const p = object.localToWorld(new MeshCat.THREE.Vector3(0, y, 0)).project(viewer.camera);
    return [stage.left + (0.5 + 0.5 * p.x) * stage.width, stage.top + (0.5 - 0.5 * p.y) * stage.height]; }); }"""
VISIBLE = "l => l.element.style.visibility === 'visible'"
#: Where all vertices stand on the stage, -1 to 1.
PROJECTED = """[...robot_page.solids.values()].flatMap(({ mesh }) => {
  const out = [], p = mesh.geometry.attributes.position, v = new MeshCat.THREE.Vector3();
  for (let i = 0; i < p.count; i++) {
    v.fromBufferAttribute(p, i).applyMatrix4(mesh.matrixWorld).project(viewer.camera);
    out.push([v.x, v.y]);
  }
  return out; })"""


# ---- one pose ------------------------------------------------------------------------------------------------------


def test_drawn_displacements_follow_exaggeration_and_share_sliders(operated, result):
    """Displacements of platform, beams and joints, against the contributions of the result."""
    page, rest = operated, vertices(operated, "Rest/platform")
    frame = result.configuration.platform_frame
    sources = list(result.contributions)
    for exponent, shares in ((3.0, [1, 1, 1, 1, 1]), (3.5, [1, 0.25, 0, 0.5, 1])):
        move(page, "exaggeration", exponent)
        for name, share in zip(sources, shares, strict=True):
            move(page, f"share: {name}", share)
        e = 10**exponent
        assert page.evaluate("robot_page.state.exaggeration") == pytest.approx(e)

        twist = e * sum(share * result.contributions[name] for name, share in zip(sources, shares, strict=True))
        o = frame[:3, 3]
        expected = o + twist[:3] + (rest - o) @ Rotation.from_rotvec(twist[3:]).as_matrix().T
        np.testing.assert_allclose(vertices(page, "Deformed/platform"), expected, atol=2e-6)
        for name, beam in result.beams.items():
            parts = result.beam_contributions[name]
            bent = beam.points + e * sum(s * parts[k][:, :3] for k, s in zip(sources, shares, strict=True))
            np.testing.assert_allclose(rings(vertices(page, f"Deformed/beams/{name}")), bent, atol=2e-6)
        ball = vertices(page, "Deformed/joints/universal_2")
        parts = result.beam_contributions["rod_2"]
        end = result.beams["rod_2"].points[-1] + e * sum(s * parts[k][-1, :3] for k, s in zip(sources, shares, strict=True))
        np.testing.assert_allclose((ball.max(axis=0) + ball.min(axis=0)) / 2, end, atol=2e-6)


def test_displayed_twist_is_in_micrometres_and_scales_with_shares(operated, result):
    page = operated
    rest = vertices(page, "Rest/platform")
    assert np.abs(vertices(page, "Deformed/platform") - rest).max() > 0.01
    np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), result.twist, rtol=1e-5)
    move(page, "share: load", 0.5)
    changed = result.twist - 0.5 * result.contributions["load"]
    np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), changed, rtol=1e-5, atol=1e-12)
    text = page.inner_text("#robot-total")
    assert "µm" in text and "µrad" in text
    page.locator("summary", has_text="Contributions").click()
    text = page.inner_text("#robot-parts")
    assert all(name in text for name in result.contributions)
    for cells, twist in (("#robot-total tr.total td", changed), ("#robot-parts tr.part td", 0.5 * result.contributions["load"])):
        written = page.locator(cells).all_inner_texts()[:6]
        found = [float(cell.replace("−", "-")) for cell in written]
        np.testing.assert_allclose(found, twist * 1e6, atol=0.006)
    page.locator("summary", has_text="Contributions").click()
    assert "deflection [µm]" in page.inner_text("#robot-legend")

    for name in result.contributions:
        move(page, f"share: {name}", 0)
    np.testing.assert_allclose(vertices(page, "Deformed/platform"), rest, atol=1e-6)
    np.testing.assert_allclose(vertices(page, "Rest/platform"), rest, atol=1e-9)
    assert page.evaluate("robot_page.readout(null)") == [0] * 6
    assert max(page.evaluate("[...robot_page.arrows.values()].map(a => a.size)")) < 1e-3


# ---- arrows and labels ---------------------------------------------------------------------------------------------


def test_arrows_and_labels_are_named_as_in_the_result(page, result):
    assert page.is_hidden(".dg.main")  # meshcat's own tree is folded
    assert page.evaluate(NAMES, "Frames") == ["base", "platform"]
    assert page.evaluate(NAMES, "Labels/limbs") == list(result.limbs)
    groups = set(page.evaluate(NAMES, "Arrows"))
    assert {"external load", "constraint forces", "attached wrenches", "weights", "base reaction", "actuator forces"} <= groups
    assert page.evaluate(NAMES, "Arrows/actuator forces") == list(result.actuator_forces)
    names = set(page.evaluate(NAMES, "Arrows/constraint forces"))
    if "constraint couples" in groups:
        names |= set(page.evaluate(NAMES, "Arrows/constraint couples"))
    assert names == {f"{limb.name}: {label}" for limb in result.limbs.values() for label in limb.labels}
    attached = page.evaluate(NAMES, "Arrows/attached wrenches")
    assert attached == [f"{limb.name}: {label}" for limb in result.limbs.values() for label in limb.attached_labels]
    for name, force in result.actuator_forces.items():
        value = page.evaluate("(path) => robot_page.arrows.get(path).value", f"Arrows/actuator forces/{name}")
        assert value == pytest.approx(float(force), rel=1e-5)


@pytest.mark.slow
def test_labels_do_not_overlap(visit, page):
    page = visit(page.url)
    for group in page.evaluate(NAMES, "Arrows"):
        page.evaluate("(group) => viewer.set_property(['Arrows', group], 'visible', true)", group)
    for size in ((900, 600), (1400, 850)):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.evaluate("viewer.set_dirty()")
        settle(page)
        labels = page.evaluate(LABELS)
        assert len(labels) >= 5
        x0, y0, x1, y1 = page.evaluate(STAGE)
        for k, (text, left, top, right, bottom) in enumerate(labels):
            assert left >= x0 and top >= y0 and right <= x1 and bottom <= y1
            for other, x, y, u, v in labels[k + 1 :]:
                assert not (left < u - 1 and right > x + 1 and top < v - 1 and bottom > y + 1), (text, other)
        for text, x, y, left, top, right, bottom, led in page.evaluate(ANCHORS):  # near its anchor or with a leader line
            gap = np.hypot(max(left - x, 0, x - right), max(top - y, 0, y - bottom))
            assert gap < 62 and (led or gap <= 5), text


@pytest.mark.slow
def test_a_label_without_room_is_shown_when_the_pointer_is_at_its_arrow(visit, page):
    page = visit(page.url, (320, 640))
    page.evaluate("viewer.set_property(['Arrows', 'constraint forces'], 'visible', true)")
    settle(page)
    for path in page.evaluate(f"robot_page.labels.filter(l => l.path && l.shown() && !({VISIBLE})(l)).map(l => l.path)"):
        page.mouse.move(*np.mean(page.evaluate(ON_SCREEN, path), axis=0))
        settle(page)
        if page.evaluate(f"path => robot_page.labels.filter(l => l.path === path).some({VISIBLE})", path):
            return  # the others may be behind other arrows
    raise AssertionError("no further label is shown")


@pytest.mark.slow
def test_rigid_planar_robot_fits_the_window_without_colour_scale(visit, tmp_path):
    """Seen from the side, a flat robot extends far away from the camera and near to it."""
    robot = ks.load_robot("planar_3rrr")
    rigid = ks.Robot(replace(robot.description, beams={}, path="rigid.urdf"))
    ks.save_html(ks.analyze(rigid.assemble()), tmp_path / "rigid.html")
    page = visit((tmp_path / "rigid.html").as_uri(), (390, 800))
    assert page.inner_text("#robot-legend") == "rigid: nothing deforms"
    assert np.abs(page.evaluate(PROJECTED)).max() < 1
    for width, height in ((1400, 900), (800, 600)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_function("width => viewer.renderer.domElement.clientWidth > width - 400", arg=width)
        assert np.abs(page.evaluate(PROJECTED)).max() < 1


def test_pictures_are_not_blank_and_well_framed(page):
    from PIL import Image as image

    settle(page)
    picture = np.asarray(image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)
    left, top, right, bottom = map(round, page.evaluate(STAGE))
    free = picture[top:bottom, left:right]
    inked = (free < 245).any(axis=2)
    assert inked.mean() > 0.1
    assert ((free.max(axis=2) - free.min(axis=2)) > 40).mean() > 0.02  # colours of beams, platform and arrows
    rows, columns = np.flatnonzero(inked.any(axis=1)), np.flatnonzero(inked.any(axis=0))
    assert np.ptp(rows) > 0.6 * len(free) or np.ptp(columns) > 0.8 * free.shape[1]
    assert rows[0] > 3 and rows[-1] < len(free) - 3
    canvas = page.evaluate("viewer.capture_image()")  # what meshcat's own "save image" gives
    pixels = np.asarray(image.open(io.BytesIO(base64.b64decode(canvas.partition(",")[2]))).convert("RGB"))
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 500


# ---- paths ---------------------------------------------------------------------------------------------------------


def test_an_unrounded_path_in_a_notebook_frame_has_all_digits(browser, result, tmp_path):
    """Without network, in single precision: the page adds up the differences of the file."""
    path = result.robot.assemble(platform={"z": [0.55, 0.6, 0.61, 0.58], "rx": 0.1, "ry": -0.1})
    moving = ks.analyze(path, load=LOAD)
    ks.save_html(moving, tmp_path / "path.html")
    framed = iframe_html((tmp_path / "path.html").read_text(encoding="utf-8"))
    (tmp_path / "notebook.html").write_text(f"<!DOCTYPE html><meta charset=utf-8><body>{framed}", encoding="utf-8")
    context = browser.new_context(offline=True)
    notebook = context.new_page()
    notebook.goto((tmp_path / "notebook.html").as_uri())
    frame = notebook.frames[1]
    wait(frame, "window.robot_page && robot_page.ready")
    stations = describe_scene(moving).stations
    for key, expected in (("pose", stations.poses), ("twist", stations.all_twists)):
        found = frame.evaluate("key => [...robot_page.scene.stations[key]]", key)
        np.testing.assert_array_equal(found, expected.astype(np.float32).ravel())
    context.close()


@pytest.mark.slow
def test_poses_of_a_long_rounded_path_equal_the_result(visit, root, tmp_path, monkeypatch):
    """A thousand poses, rounded to twenty bits: geometry and numbers at two of them, and midway between two."""
    monkeypatch.setattr(ks.viewer.page, "ROUNDINGS", ((20, ""),))
    robot = ks.load_robot(root / "robots" / "3rps.urdf.xacro")
    turn = np.linspace(0, 6 * np.pi, 1000)
    path = robot.assemble(platform={"z": 0.5 + 0.05 * np.sin(turn / 2), "rx": 0.15 * np.cos(turn), "ry": 0.15 * np.sin(turn)})
    result = ks.analyze(path, load=LOAD)
    file = tmp_path / "long.html"
    ks.save_html(result, file)
    assert file.stat().st_size < 2e6
    page = visit(file.as_uri(), (1400, 850))
    page.evaluate("robot_page.selectPath('beams/rod_3')")
    e = page.evaluate("robot_page.state.exaggeration")
    for k in (997, 3):
        move(page, "path", k)
        frame, twist, beam = result.configuration.platform_frame[k], result.twist[k], result.beams["rod_3"]
        np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), twist, rtol=0, atol=2e-6 * np.abs(twist).max())
        for name, share in result.contributions.items():
            found = page.evaluate("k => robot_page.readout(k)", list(result.contributions).index(name))
            np.testing.assert_allclose(found, share[k], rtol=0, atol=2e-6 * np.abs(twist).max(), err_msg=name)
        rest = vertices(page, "Rest/platform")
        at = np.concatenate([frame[:3, 3] + e * twist[:3], e * twist[3:]])
        expected = at[:3] + (rest - frame[:3, 3]) @ Rotation.from_rotvec(at[3:]).as_matrix().T
        np.testing.assert_allclose(vertices(page, "Deformed/platform"), expected, atol=1e-5)
        bent = (beam.points + e * beam.deflections)[k, ::5]
        np.testing.assert_allclose(rings(vertices(page, "Deformed/beams/rod_3"), stations=5), bent, atol=1e-5)
        for name, force in result.actuator_forces.items():
            value = page.evaluate("(path) => robot_page.arrows.get(path).value", f"Arrows/actuator forces/{name}")
            assert value == pytest.approx(force[k], rel=1e-5)
        card = page.inner_text("#robot-card").replace("\u2212", "-")
        assert f"largest von Mises stress\t{float(beam.stress[k]) / 1e6:.4g}"[:29] in card
        z = float(path.platform_coordinates()["z"][k])
        assert f"z {1e3 * z:.1f}"[:6] in page.inner_text("#robot-facts")
    move(page, "path", 3.5)  # midway between two poses
    between = (beam.points + e * beam.deflections)[3:5, ::5].mean(axis=0)
    np.testing.assert_allclose(rings(vertices(page, "Deformed/beams/rod_3"), stations=5), between, atol=1e-4)


# ---- pages that compute ----------------------------------------------------------------------------------------------


def test_page_analyses_the_pose_and_load_of_its_sliders(visit, root, tmp_path):
    robot = ks.load_robot(root / "robots" / "3rps.urdf.xacro")
    ks.save_html(ks.analyze(robot.assemble(platform=POSES["3rps"]), load=LOAD), tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri())
    page.evaluate("viewer.set_property(['Rest'], 'visible', false)")
    drives = dict(robot.assemble(platform=POSES["3rps"]).actuators)
    moved = 1e3 * float(drives["prismatic_1"]) + 20
    move(page, "actuator: prismatic_1 [mm]", moved)
    page.wait_for_function("robot_page.answers >= 1")
    drives["prismatic_1"] = value_of(page, "actuator: prismatic_1 [mm]") / 1e3
    pose = robot.assemble(actuators=drives)
    expected = ks.analyze(pose, load=LOAD)
    np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), expected.twist, rtol=1e-4, atol=1e-10)
    np.testing.assert_allclose(rings(vertices(page, "Rest/platform"), 1, len(vertices(page, "Rest/platform"))).shape, (1, 3))
    z = value_of(page, "platform: z [mm]")
    assert z == pytest.approx(1e3 * float(pose.platform["z"]), abs=0.1)
    assert page.evaluate("viewer.scene_tree.children.Rest.object.visible") is False  # switches stay as they were

    for angle in (1.0, 2.0, 3.0, 4.0):  # a drag: the last value wins
        move(page, "platform: rx [°]", angle)
    coordinates = {"z": float(pose.platform["z"]), "rx": np.radians(4), "ry": float(pose.platform["ry"])}
    for load in (LOAD, [*LOAD[:2], -800, *LOAD[3:]]):
        move(page, "load: Fz [N]", load[2])
        page.wait_for_function("!robot_page.busy")
        expected = ks.analyze(robot.assemble(platform=coordinates), load=load).twist
        np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), expected, rtol=1e-4, atol=1e-10)
    assert "load at o (100, 50, −800) N" in page.inner_text("#robot-facts")


@pytest.mark.slow
def test_page_stops_at_joint_limits_and_follows_handles(visit, root, tmp_path):
    robot = ks.load_robot(root / "robots" / "2pru_upr.urdf.xacro")
    start = robot.assemble(platform=POSES["2pru_upr"])
    ks.save_html(ks.analyze(start), tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri(), (900, 600))

    def shows(z):
        pose = robot.assemble(platform={**POSES["2pru_upr"], "z": z}, near=start)
        np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), ks.analyze(pose).twist, rtol=2e-3, atol=1e-8)

    where = "document.querySelector(\"input[name='platform: z [mm]']\").getBoundingClientRect().top"
    before = page.evaluate(where)
    most = float(page.evaluate("document.querySelector(\"input[name='platform: z [mm]']\").max"))
    move(page, "platform: z [mm]", most)  # which is beyond the end of reach
    page.wait_for_function("robot_page.answers >= 1")
    assert page.evaluate(where) == before  # the message pushes no slider
    told, title = (
        page.inner_text("#robot-message"),
        page.evaluate("document.querySelector(\"input[name='platform: z [mm]']\").title"),
    )
    assert "z ends at " in told and "mm: limit of " in told and told.split(": ")[1] in title
    rim = value_of(page, "platform: z [mm]") / 1e3
    assert 0.6 < rim < most / 1e3 and "status OK" in page.inner_text("#robot-facts")
    shows(rim)
    assert robot.assemble(platform={**POSES["2pru_upr"], "z": rim + 1e-3}, near=start).limit_exceeded
    move(page, "platform: z [mm]", 610)
    page.wait_for_function("robot_page.answers >= 2")
    assert not page.is_visible("#robot-message > p") and "status OK" in page.inner_text("#robot-facts")

    # the double arrow along z, dragged downwards: the platform follows, the camera does not turn
    assert page.evaluate("robot_page.handles.map(handle => handle.control)") == [
        "platform: z [mm]", "platform: rx [°]", "platform: ry [°]",
    ]  # fmt: skip
    camera = page.evaluate("viewer.camera.position.toArray()")
    x, y = page.evaluate(
        """() => { viewer.scene.updateMatrixWorld(true);
          const at = new MeshCat.THREE.Vector3();
          robot_page.handles[0].object.children[2].getWorldPosition(at).project(viewer.camera);
          const box = document.getElementById("meshcat-pane").getBoundingClientRect();
          return [box.left + (0.5 + 0.5 * at.x) * box.width, box.top + (0.5 - 0.5 * at.y) * box.height]; }"""
    )
    page.mouse.move(x, y)
    page.mouse.down()
    for step in (8, 16, 24):
        page.mouse.move(x, y + step)
    page.mouse.up()
    page.wait_for_function("robot_page.answers >= 3")
    page.wait_for_function("!robot_page.busy")
    z = value_of(page, "platform: z [mm]") / 1e3
    assert 0.5 < z < 0.6
    shows(z)
    assert page.evaluate("viewer.camera.position.toArray()") == camera

    # the ring about x, dragged along itself
    before = value_of(page, "platform: rx [°]")
    ring = page.evaluate(
        """() => { viewer.scene.updateMatrixWorld(true);
          const { object } = robot_page.handles[1], box = document.getElementById("meshcat-pane").getBoundingClientRect();
          const reach = object.children[0].geometry.parameters.radius;
          return [0, 0.15, 0.3].map(angle => {
            const at = new MeshCat.THREE.Vector3(reach * Math.cos(angle), reach * Math.sin(angle), 0);
            at.applyMatrix4(object.matrixWorld).project(viewer.camera);
            return [box.left + (0.5 + 0.5 * at.x) * box.width, box.top + (0.5 - 0.5 * at.y) * box.height]; }); }"""
    )
    answers = page.evaluate("robot_page.answers")
    page.mouse.move(*ring[0])
    page.mouse.down()
    for place in ring[1:]:
        page.mouse.move(*place)
    page.mouse.up()
    page.wait_for_function("n => robot_page.answers > n", arg=answers)
    page.wait_for_function("!robot_page.busy")
    assert value_of(page, "platform: rx [°]") - before == pytest.approx(np.degrees(0.3), abs=1.0)


def test_the_loads_arrow_is_pulled_and_gravity_and_payload_are_sliders(visit, root, tmp_path):
    """The numbers in the page, and of its function for scripts, are those of Python."""
    robot = ks.load_robot(root / "robots" / "3rps.urdf.xacro")
    pose = robot.assemble(platform=POSES["3rps"])
    ks.save_html(ks.analyze(pose, load=LOAD), tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri(), (1000, 700))
    x, y = page.evaluate(
        """() => { viewer.scene.updateMatrixWorld(true);
          const arrow = robot_page.arrows.get("Arrows/external load/load force"), at = new MeshCat.THREE.Vector3();
          arrow.object.localToWorld(at.set(0, 0.2 * arrow.size * arrow.spec.metres_per_unit, 0)).project(viewer.camera);
          const box = document.getElementById("meshcat-pane").getBoundingClientRect();
          return [box.left + (0.5 + 0.5 * at.x) * box.width, box.top + (0.5 - 0.5 * at.y) * box.height]; }"""
    )
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y - 10, steps=4)
    page.mouse.up()
    page.wait_for_function("robot_page.answers >= 1 && !robot_page.busy")
    load = page.evaluate("robot_page.machine.loads.load")
    assert np.linalg.norm(np.subtract(load, LOAD)[:3]) > 20 and load[3:] == LOAD[3:]
    np.testing.assert_allclose(
        page.evaluate("robot_page.readout(null)"), ks.analyze(pose, load=load).twist, rtol=1e-5, atol=1e-12
    )
    for name, value in (("payload: mass [kg]", 10), ("payload: x [mm]", 200), ("gravity: about x [°]", 90)):
        move(page, name, value)
    page.wait_for_function("!robot_page.busy")
    expected = ks.analyze(pose, load=load, gravity=[0, 9.81, 0], payload=ks.Payload(10, (0.2, 0, 0)))
    np.testing.assert_allclose(page.evaluate("robot_page.readout(null)"), expected.twist, rtol=1e-5, atol=1e-12)
    assert "10 kg at (200, 0, 0) mm" in page.evaluate("robot_page.facts()[0].join()")
    there = robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": 0.0})
    told = page.evaluate("kinetostatics.analyze({ platform: { z: 0.55, rx: 0.1, ry: 0 }, load: [0, 0, -500, 0, 0, 0] })")
    expected = ks.analyze(there, [0, 0, -500, 0, 0, 0], [0, 9.81, 0], payload=ks.Payload(10, (0.2, 0, 0)))
    np.testing.assert_allclose(told["twist"], expected.twist, rtol=0, atol=1e-12 * np.abs(expected.twist).max())
    assert told["status"] == "OK" and list(told["actuator_forces"]) == list(robot.description.actuated)
