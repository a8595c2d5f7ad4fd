"""Two results on one page: a ghost over the first, or side by side with one camera."""

import base64
import io

import numpy as np
import pytest
from browser_pages import LOAD, POSES, packed_in, settle, vertices, visits
from PIL import Image as image

import kinetostatics as ks

NUMBERS = "[...document.querySelectorAll('#robot-total tr.total')].map(row => [...row.cells].map(cell => cell.textContent))"


@pytest.fixture(scope="module")
def pair(result):
    robot = result.robot
    pose = robot.assemble(platform={**POSES["2pru_upr"], "z": 0.65, "ry": -0.1})
    return result, ks.analyze(pose, load=LOAD)


@pytest.fixture(scope="module")
def compared(browser, pair, tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "compare.html"
    ks.save_html(pair[0], file, compare=pair[1])
    with visits(browser) as open_page:
        yield open_page(file.as_uri(), (1000, 600))


@pytest.mark.slow
def test_ghost_has_the_deflections_of_the_second_result(compared, pair):
    e = compared.evaluate("robot_page.state.exaggeration")
    for root, result in zip(("", "Compared/"), pair, strict=True):
        for name, beam in result.beams.items():
            ring = vertices(compared, f"{root}Deformed/beams/{name}")[: 21 * 24].reshape(21, 24, 3).mean(axis=1)
            np.testing.assert_allclose(ring, beam.points + e * beam.deflections, atol=2e-6)
    shown = compared.evaluate("robot_page.robots[1].nodes().map(node => node.visible)")
    assert shown == [False, True, False, False, False, False, False]  # the deformed robot alone: the base is that of the first
    table = np.array([[float(cell.replace("−", "-")) for cell in row] for row in compared.evaluate(NUMBERS)])
    expected = np.array([pair[0].twist, pair[1].twist, pair[1].twist - pair[0].twist]) * 1e6
    np.testing.assert_allclose(table, expected, atol=0.006)
    head = compared.inner_text("#robot-facts")
    assert "z 600 mm" in head and "z 650 mm" in head


@pytest.mark.slow
def test_side_by_side_results_share_one_camera(compared, pair):
    compared.select_option("select[name=compare]", "beside")
    settle(compared)
    assert all(compared.evaluate("robot_page.robots[1].nodes().map(node => node.visible)"))
    picture = np.asarray(image.open(io.BytesIO(base64.b64decode(compared.evaluate("robot_page.picture(1)").partition(",")[2]))))
    robots = picture[60:-60, :, :3].astype(int)
    half = robots.shape[1] // 2
    base = compared.evaluate(
        """() => robot_page.labels.filter(label => label.element.textContent === "base")
          .map(({ robot, leader }) => [robot.root, Number(leader.getAttribute("x1")), Number(leader.getAttribute("y1"))])"""
    )
    (_, x, y), (_, u, v) = base
    assert abs(u - x - half) <= 1 and abs(v - y) <= 1  # one camera
    for side in (robots[:, :half], robots[:, half:]):
        assert ((side.max(axis=2) - side.min(axis=2)) > 40).mean() > 0.02
    path = "Arrows/actuator forces/prismatic_3"
    for k, result in enumerate(pair):
        value = compared.evaluate("([k, path]) => robot_page.robots[k].arrows.get(path).value", [k, path])
        assert value == pytest.approx(float(result.actuator_forces["prismatic_3"]), rel=1e-5)
    scales = compared.evaluate("path => robot_page.robots.map(robot => robot.arrows.get(path).spec.metres_per_unit)", path)
    assert scales[0] == scales[1]
    # a click in the right half picks from the second result
    place = """() => { const box = document.getElementById("meshcat-pane").getBoundingClientRect(), [first] = robot_page.robots;
      const at = first.solids.get("Base/base").mesh.position.clone(); viewer.scene.updateMatrixWorld(true);
      const p = first.solids.get("Base/base").mesh.geometry.attributes.position, out = [];
      for (let k = 0; k < p.count; k += 20) {
        at.fromBufferAttribute(p, k).applyMatrix4(first.solids.get("Base/base").mesh.matrixWorld).project(viewer.camera);
        const x = box.left + box.width * (0.25 + 0.25 * at.x), y = box.top + box.height * (0.5 - 0.5 * at.y);
        const hit = robot_page.pick(x + box.width / 2, y);
        if (hit) out.push(hit.robot.root);
      }
      return out; }"""
    found = compared.evaluate(place)
    assert found and set(found) == {"Compared/"}
    compared.select_option("select[name=compare]", "ghost")


@pytest.mark.slow
def test_url_fragment_sets_comparison_and_colour(compared):
    address = compared.url
    compared.goto(f"{address}#beside&colour=stress&view=top")
    compared.reload()
    compared.wait_for_function("window.robot_page && robot_page.ready")
    chosen = "[...document.querySelectorAll('select')].map(choice => [choice.name, choice.value])"
    assert dict(compared.evaluate(chosen)) == {"compare": "beside", "colour by": "stress"}
    assert all(compared.evaluate("robot_page.robots[1].nodes().map(node => node.visible)"))
    assert "von Mises stress [MPa]" in compared.inner_text("#robot-legend")


@pytest.mark.slow
def test_view_command_compares_poses_and_robots(tmp_path, capsys, monkeypatch, request):
    from kinetostatics.cli import main as cli

    monkeypatch.chdir(request.config.rootpath)
    file = tmp_path / "two.html"
    command = ["view", "3rps", "--platform", "z=500mm", "rx=0", "ry=0", "--html", str(file), "--compare"]
    assert cli.main([*command, "z=550mm", "rx=2deg", "ry=0"]) == 0
    assert packed_in(file.read_text(encoding="utf-8"))["compare"]["title"] == "3rps"
    assert cli.main([*command, "3prs", "z=550mm", "rx=2deg", "ry=0"]) == 0
    assert packed_in(file.read_text(encoding="utf-8"))["compare"]["title"] == "3prs"
    assert cli.main([*command, "3prs", "delta"]) == 2
    assert "names 2 robots" in capsys.readouterr().err
