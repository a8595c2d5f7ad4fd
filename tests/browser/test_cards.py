"""Cards and colours of the page against the result and its report; the tests share a page."""

import re

import numpy as np
import pytest
from browser_pages import settle, vertices

#: Place in the window of a point of the solid or arrow at a path; the part, 0 to 1, chooses the vertex or the point of the arrow.
PLACE = """([path, part]) => { viewer.scene.updateMatrixWorld(true);
  const box = document.getElementById("meshcat-pane").getBoundingClientRect(), at = new MeshCat.THREE.Vector3();
  const solid = robot_page.solids.get(path), arrow = robot_page.arrows.get(path);
  if (solid) {
    const p = solid.mesh.geometry.attributes.position, v = Math.floor(part * p.count);
    at.fromBufferAttribute(p, v).applyMatrix4(solid.mesh.matrixWorld);
  } else { at.set(0, part * arrow.size * arrow.spec.metres_per_unit, 0).applyMatrix4(arrow.object.matrixWorld); }
  at.project(viewer.camera);
  return [box.left + (0.5 + 0.5 * at.x) * box.width, box.top + (0.5 - 0.5 * at.y) * box.height]; }"""


def click(page, path, part):
    page.mouse.click(*page.evaluate(PLACE, [path, part]))
    return page.inner_text("#robot-card").replace("−", "-")


def row_of(report, name, title):
    """Numbers of a row of a table of the report."""
    lines = report.partition(f"\n{title}")[2].splitlines()
    return next(line.split()[1:] for line in lines if line.split()[:1] == [name])


def visible_part(page, path, parts):
    """Return the first of some parts of the solid or arrow at a path that nothing hides."""
    for part in parts:
        x, y = page.evaluate(PLACE, [path, part])
        if page.evaluate("([x, y]) => robot_page.pick(x, y)?.path", [x, y]) == path.removeprefix("Deformed/"):
            return part
    raise AssertionError(f"{path} cannot be seen")


def test_beam_card_equals_the_report(page, result):
    text = click(page, "Deformed/beams/rod_2", visible_part(page, "Deformed/beams/rod_2", np.linspace(0.2, 0.7, 40)))
    assert text.startswith("rod_2") and page.is_visible("#robot-card")
    for number in row_of(str(result.report()), "rod_2", "Beams"):
        assert re.search(rf"(?<![\d.]){re.escape(number)}0? ", text), number
    for words in ("axial force at the base end", "largest von Mises stress", "N/N_Euler", " MPa", " µm"):
        assert words in text
    lines = page.evaluate("[...document.querySelectorAll('#robot-card polyline')].map(line => line.getAttribute('points'))")
    drawn = [np.array([point.split(",") for point in line.split()], dtype=float)[:, 1] for line in lines]
    moments = result.beams["rod_2"].section_wrenches[:, [4, 5, 3]].T
    slope, zero = np.polyfit(moments.ravel(), np.concatenate(drawn[:3]), 1)  # one scale for all three
    assert slope < 0
    np.testing.assert_allclose(np.concatenate(drawn[:3]), slope * moments.ravel() + zero, atol=0.11)
    assert np.ptp(np.concatenate(drawn[:3])) > 50
    beam = result.beams["rod_2"]
    stress = beam.description.section.stress(beam.section_wrenches.T, beam.description.poisson_ratio)
    assert np.corrcoef(drawn[3], -stress)[0, 1] > 0.9999
    page.keyboard.press("Escape")
    assert page.is_hidden("#robot-card")


def test_joint_card_shows_wrench_and_displacement(page, result):
    path = "Deformed/joints/universal_2"
    text = click(page, path, visible_part(page, path, np.linspace(0, 0.99, 60)))
    force, moment = row_of(str(result.report()), "universal_2", "Joints")[-2:]
    assert f"force\t{force} N\n" in text and f"moment\t{moment} N·m\n" in text
    components = [float(x) for x in re.search(r"force: x, y, z\t\((.*?)\)", text)[1].split(", ")]
    np.testing.assert_allclose(components, result.joint_wrenches["universal_2"][:3], atol=0.006)
    shift = float(re.search(r"displacement\t([\d.]+) µm", text)[1])
    assert shift == pytest.approx(1e6 * np.linalg.norm(result.beams["rod_2"].deflections[-1]), abs=0.006)


def test_arrow_card_shows_force_and_contributions(page, result):
    text = click(
        page, "Arrows/actuator forces/prismatic_3", visible_part(page, "Arrows/actuator forces/prismatic_3", [0.5, 0.4, 0.6])
    )
    assert text.startswith("prismatic_3\n") and "positive along its joint" in text
    assert float(re.search(r"force\t(\S+) N", text)[1]) == pytest.approx(float(result.actuator_forces["prismatic_3"]), abs=0.6)
    for name, part in result.actuator_contributions["prismatic_3"].items():
        found = re.search(rf"by {name}\t(\S+) N", text)
        assert float(found[1] if found else 0) == pytest.approx(float(part), rel=0.006, abs=1e-3)
    page.keyboard.press("Escape")


def ramp(page, key):
    return np.array([[int(c[n : n + 2], 16) / 255 for n in (1, 3, 5)] for c in page.evaluate(f"robot_page.scene.{key}")])


@pytest.mark.few(1)
@pytest.mark.parametrize("key", ["stress", "axial", "euler"])
def test_beam_colours_match_the_legend(page, result, key):
    page.select_option("select[name='colour by']", key)
    settle(page)
    values = {}
    for name, beam in result.beams.items():
        w = beam.section_wrenches
        values[name] = {
            "stress": beam.description.section.stress(w.T, beam.description.poisson_ratio) / 1e6,
            "axial": w[:, 0],
            "euler": np.full(21, 100 * beam.euler_ratio),
        }[key]
    every = np.concatenate(list(values.values()))
    most = every[np.abs(every).argmax()]
    legend = page.inner_text("#robot-legend").replace("−", "-")
    unit = {"stress": "MPa", "axial": "N", "euler": "%"}[key]
    assert f"[{unit}]" in legend
    ticks = [float(x) for x in page.locator("#robot-legend .ticks span").all_inner_texts() for x in [x.replace("−", "-")]]
    assert ticks[-1] >= abs(most) and abs(ticks[-1]) < 2 * abs(most) and ticks[0] == (-ticks[-1] if key == "axial" else 0)
    assert page.evaluate("robot_page.robots[0].mark.text").replace("−", "-").startswith(f"largest {most:.3g}"[:12])
    table = ramp(page, "signed_ramp" if key == "axial" else "ramp")
    for name, expected in values.items():
        solid = f"robot_page.solids.get('Deformed/beams/{name}')"
        colours = np.array(page.evaluate(f"Array.from({solid}.mesh.geometry.attributes.color.array)")).reshape(-1, 3)
        stations = np.array(page.evaluate(f"Array.from({solid}.spec.station)"))
        at = np.interp(expected, [ticks[0], ticks[-1]], [0, 1])[stations - stations.min()]
        wanted = np.column_stack([np.interp(at, np.linspace(0, 1, len(table)), table[:, c]) for c in range(3)])
        np.testing.assert_allclose(colours, wanted, atol=0.006)
    rigid = "Array.from(robot_page.solids.get('Deformed/platform').mesh.geometry.attributes.color.array.slice(0, 3))"
    np.testing.assert_allclose(page.evaluate(rigid), np.array([0xC3, 0xC9, 0xD1]) / 255, atol=1e-3)
    page.select_option("select[name='colour by']", "deflection")


def test_largest_deflection_is_marked_with_its_value_and_unit(page, result):
    settle(page)
    text = page.evaluate("robot_page.robots[0].mark.text")
    assert text.endswith(" µm") and "[µm]" in page.inner_text("#robot-legend") and "µm" in page.inner_text("#robot-total")
    largest = 1e-6 * float(text.split()[1])
    found = []
    for name, beam in result.beams.items():
        spec = f"robot_page.solids.get('Deformed/beams/{name}').spec"
        local = np.array(page.evaluate(f"Array.from({spec}.vertices)")).reshape(-1, 3) @ beam.axes.T
        at = np.array(page.evaluate(f"Array.from({spec}.station)"))
        at -= at.min()
        found.append(np.linalg.norm(beam.deflections[at] + np.cross(beam.rotations[at], local), axis=1))
    path, v = page.evaluate("[robot_page.robots[0].most.solid.spec.path, robot_page.robots[0].most.v]")
    index = list(result.beams).index(path.removeprefix("beams/"))
    assert max(map(np.max, found)) == pytest.approx(largest, rel=0.003) == pytest.approx(found[index][v], rel=0.003)
    assert largest <= 1e-6 * float(page.locator("#robot-legend .ticks span").last.inner_text())
    mark = page.evaluate("robot_page.robots[0].mark.object.position.toArray()")
    np.testing.assert_allclose(vertices(page, f"Deformed/{path}")[v], mark, atol=1e-6)
