"""Robots with other numbers for the sliders of a page: their values, and which of them are left out; the sliders in Chromium."""

import itertools

import numpy as np
import package_robots
import pytest
from browser_pages import move, packed_in, settle, vertices
from page_machine import relative

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.viewer.computing import computing_page
from kinetostatics.viewer.variations import vary_result


@pytest.fixture(scope="module")
def five_bar():
    return ks.analyze(package_robots.robot("five_bar").assemble())


def test_rows_contain_the_values_of_the_robot(five_bar):
    """21 values of one range, 11 of each of two; a list as it is; without values half to one and a half times the file's."""
    one = vary_result(five_bar, {"tube_width": (0.02, 0.1)})
    assert len(one.results) == 21 and one.results[one.given] is five_bar
    assert one.sliders[0].texts[:2] == ("20\u00a0mm", "24\u00a0mm")
    two = vary_result(five_bar, {"tube_width": [0.03, 0.06], "shoulder_angle_max": None})
    assert [len(slider.rows) for slider in two.sliders] == [3, 11]
    assert two.sliders[1].texts == ("40\u00a0°", *(f"{k}\u00a0°" for k in range(48, 121, 8)))
    assert two.given == 1 * 11 + two.sliders[1].at
    values = [beam.section.width for result in two.results[::11] for beam in result.robot.beams.values()]
    assert values == [0.03] * 4 + [0.04] * 4 + [0.06] * 4


def test_robots_that_cannot_be_assembled_at_the_pose_are_left_out(five_bar):
    short = vary_result(five_bar, {"distal_length": [0.02, 0.2]})
    assert [result is None for result in short.results] == [True, False, False]


def test_robots_for_which_other_formulas_apply_are_left_out(five_bar):
    """Without mass the tool has no weight, so that the program has other operations."""
    page = computing_page(five_bar, vary={"tool_mass": [0, 2.0]})
    assert [robot is not None for robot in page["robots"]] == [False, True, True]


@pytest.mark.parametrize(
    ("vary", "text"),
    [
        (
            dict.fromkeys(("tube_width", "tube_height", "density", "tool_mass")),
            "vary names 4 parameters; a page has sliders for 3",
        ),
        ({"tube_with": None}, "no parameter 'tube_with'"),
        ({"joint_1.error.x": None}, "no parameter"),
        ({"tube_width": "20mm"}, "at least two different values"),
        ({"tube_width": "20kg:30kg"}, "tube_width is given in kg"),
        (["tube_width"], "must be a mapping"),
        ({3: None}, "vary has the key 3"),
        ({("tube_width", "tube_height"): None}, "rows of a catalogue"),
        ({"distal_length": [0.02, 0.03]}, "with all other values of distal_length"),
    ],
)
def test_wrong_variations_are_refused(five_bar, vary, text):
    with pytest.raises(ks.ArgumentError, match=text):
        ks.save_html(five_bar, "unused.html", vary=vary)


def test_only_pages_that_compute_have_sliders(five_bar, tmp_path, capsys):
    robot, page = five_bar.robot, tmp_path / "page.html"
    with pytest.raises(ks.ArgumentError, match="vary= needs one result of one pose"):
        ks.save_html(robot, page, vary={"tube_width": None})
    stored = ks.analyze(robot.assemble(), assembly_errors={"shoulder_1": [1e-4, 0, 0, 0, 0, 0]})
    with pytest.raises(
        ks.ArgumentError, match="vary= needs a page that computes, and this one does not: the result has assembly"
    ):
        ks.save_html(stored, page, vary={"tube_width": None})
    ks.save_html(stored, page)
    assert packed_in(page.read_text())["notes"][-1] == (
        "this page shows one pose and computes no others: the result has assembly errors or a motion"
    )
    with pytest.raises(ks.ArgumentError, match="vary= varies one robot, and compare= shows two"):
        ks.save_html(five_bar, tmp_path / "page.html", vary={"tube_width": None}, compare=five_bar)
    assert main(["view", "five_bar", "--vary", "tube_width", "--screenshot", "a.png"]) == 2
    assert "--screenshot and --vary exclude one another" in capsys.readouterr().err
    assert main(["view", "five_bar", "--vary", "tube_width", "tube_width=20mm:30mm", "--html", str(page)]) == 2
    assert "'tube_width' is given twice" in capsys.readouterr().err
    assert main(["view", "five_bar", "--platform", "x=2", "y=0", "--vary", "tube_width", "--html", str(page)]) == 2
    assert "cannot reach x = 2" in capsys.readouterr().err
    assert (
        main(["view", "five_bar", "--vary", "tube_width=3cm,5cm", "tool_mass=1kg,2kg", "--html", str(tmp_path / "page.html")])
        == 0
    )


def test_sliders_change_numbers_and_picture(visit, tmp_path):
    """Numbers are those of the robot loaded with these arguments; rods are drawn with their diameters, also on the way back."""
    robot, at = package_robots.robot("3rps"), {"z": 0.5, "rx": 0.05, "ry": -0.1}
    vary = {"rod_diameter": [0.06, 0.14], "base_radius": [0.27, 0.33]}
    ks.save_html(ks.analyze(robot.assemble(platform=at)), tmp_path / "page.html", vary=vary)
    page = visit((tmp_path / "page.html").as_uri())
    for (d, diameter), (r, radius) in itertools.product(enumerate((0.06, 0.1, 0.14)), enumerate((0.27, 0.3, 0.33))):
        move(page, "parameters: rod_diameter", d)
        move(page, "parameters: base_radius", r)
        page.wait_for_function("!robot_page.busy")
        settle(page)
        other = ks.load_robot("3rps", {"rod_diameter": diameter, "base_radius": radius})
        result, answer = ks.analyze(other.assemble(platform=at)), page.evaluate("kinetostatics.analyze()")
        assert relative(answer["twist"], result.twist) < 1e-12
        assert relative(answer["stiffness"], result.stiffness) < 1e-12
        points = vertices(page, "Deformed/beams/rod_1")[:24]
        assert np.linalg.norm(points - points.mean(axis=0), axis=1) == pytest.approx(np.full(24, diameter / 2), rel=1e-5)
