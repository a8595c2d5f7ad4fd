"""Modes of vibration on the page: choice, animation and numbers."""

import meshcat
import numpy as np
import pytest
from browser_pages import move, packed_in, rings, vertices

import kinetostatics as ks
from kinetostatics.cli import main as cli
from kinetostatics.exceptions import ArgumentError


@pytest.fixture(scope="module")
def found(root):
    robot = ks.load_robot(root / "robots" / "2pru_upr.urdf.xacro")
    return ks.modes(robot.assemble(platform={"z": [0.55, 0.6], "rx": 0.1, "ry": 0.1}), count=3)


def test_mode_animation_swings_to_both_sides_of_the_pose(found, visit, tmp_path):
    """Beams and platform move by the mode shape times one factor: the largest displacement is a tenth of the robot."""
    ks.save_html(found, tmp_path / "modes.html", pose=1)
    page = visit((tmp_path / "modes.html").as_uri())
    start = page.evaluate("robot_page.state.time")
    page.wait_for_function("start => robot_page.state.time !== start", arg=start)  # it plays
    page.click("#robot-play")
    page.evaluate("() => { const next = requestAnimationFrame; window.requestAnimationFrame = (f) => next((t) => f(t - 1e4)); }")
    page.click("#robot-play")  # the first frame was due before the click
    start = page.evaluate("robot_page.state.time")
    page.wait_for_function("start => robot_page.state.time !== start", arg=start)
    page.click("#robot-play")
    names = list(found.beam_lines)
    mode = 1
    page.select_option("select[name=mode]", index=mode)
    at = []
    for phase in (0, 0.25, 0.75, 1 / 12):
        move(page, "path", phase)
        at.append(np.array([rings(vertices(page, f"Deformed/beams/{name}")) for name in names]))
    rest, plus, minus, half = at
    np.testing.assert_allclose(plus - rest, rest - minus, atol=2e-6)
    np.testing.assert_allclose(half - rest, (plus - rest) / 2, atol=2e-6)
    lines = np.array([found.beam_lines[name][1, mode, :, :3] for name in names])
    factor = np.sum(lines * (plus - rest)) / np.sum(lines**2)
    np.testing.assert_allclose(plus - rest, factor * lines, atol=5e-6)
    move(page, "path", 0.25)
    o = page.evaluate("['deformed', 'rest'].map(key => [...robot_page.stations[key].slice(0, 3)])")
    np.testing.assert_allclose(np.subtract(*o), factor * found.twists[1, mode, :3], atol=5e-6)
    most = np.linalg.norm(plus - rest, axis=-1).max() / page.evaluate("robot_page.scene.size")
    assert 0.05 < most < 0.1 + 1e-6
    told = page.inner_text("#robot-facts")
    assert f"mode {mode + 1} of 3: {found.frequencies[1, mode]:.2f} Hz" in told
    assert page.inner_text("#robot-mode tr:nth-child(2)").split()[0] == f"{100 * found.effective_masses[1, mode, 0]:.1f}"
    shares = {name: share[1, mode] for name, share in found.strain_energy_shares.items()}
    first = max(shares, key=shares.get)
    assert page.inner_text("#robot-mode table.parts td:nth-child(2)") == f"{100 * shares[first]:.1f}"
    assert page.evaluate("robot_page.robots[0].mark.object.children[0].visible") is False
    assert "displacement [% of the largest]" in page.inner_text("#robot-legend")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "choose one by pose="),
        ({"pose": 0, "compare": "result"}, "leave them out"),
        ({"pose": 0, "by_mechanism": True}, "leave them out"),
        ({"pose": 2}, "index into"),
        ({"visualizer": meshcat.Visualizer.__new__(meshcat.Visualizer)}, "shown by a page"),
    ],
)
def test_options_that_modes_do_not_support_are_errors(found, result, options, words):
    with pytest.raises(ArgumentError, match=words):
        ks.show(found, **{name: result if value == "result" else value for name, value in options.items()})


def test_save_image_shows_the_chosen_mode(found, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("kinetostatics.viewer.save_screenshot", lambda html, *_: drawn.append(packed_in(html)["shares"]))
    ks.save_image(found, tmp_path / "x.png", pose=0, mode=3)
    assert drawn == [[0, 0, 1]]
    with pytest.raises(ArgumentError, match="1 to 3"):
        ks.save_image(found, tmp_path / "x.png", pose=0, mode=4)


def test_view_command_writes_a_page_of_modes(tmp_path, capsys):
    page = tmp_path / "modes.html"
    assert cli.main(["view", "delta", "--modes", "2", "--html", str(page)]) == 0
    scene = packed_in(page.read_text(encoding="utf-8"))
    assert [mode["name"] for mode in scene["modes"]] == ["mode 1 of 2", "mode 2 of 2"]
    assert scene["notes"] == ["nothing resists 6 motions, of frequency zero, left out here"]
    assert cli.main(["view", "delta", "--modes", "2", "--load", "0", "0", "-9", "0", "0", "0"]) == 2
    assert "--modes and --load exclude one another" in capsys.readouterr().err
