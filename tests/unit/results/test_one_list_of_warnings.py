"""What is to be careful about in a robot is told wherever its results are: one list, which no number waits for."""

import pytest
from odd_robots import beyond_limits
from places import TESTS

import kinetostatics as ks
from kinetostatics.checks import check
from kinetostatics.cli.main import main
from kinetostatics.viewer.scene import describe_scene

CASE = TESTS / "cases" / "wrong_motor_axis.urdf.xacro"
WORDS = "3 actuators for 0 freedoms"


def told(text):
    """Return a text without its line ends and signs of warnings."""
    return " ".join(text.replace("! ", " ").split())


def test_what_check_warns_of_every_result_warns_of():
    robot = ks.load_robot(CASE)
    result, batch = ks.analyze(robot.assemble()), ks.analyze(robot.configuration([robot.assemble().q] * 2))
    (warning,) = robot.warnings
    assert WORDS in warning
    assert check.robot_facts(robot).warnings[0] == warning
    assert result.warnings[0] == result.to_dict()["warnings"][0] == batch.warnings[0] == warning
    assert warning in describe_scene(result).plain()["notes"]
    for text in (str(robot), str(result), str(batch)):  # a report page has the first two as chapters
        assert told(text).count(WORDS) == 1
    assert told(str(result)).endswith(f"Warnings {warning}")


def test_the_command_says_it_where_the_result_stands_and_once(capsys):
    assert main(["analyze", "3rps", "--set", "rod_diameter=80"]) == 0
    out, err = capsys.readouterr()
    assert (
        told(out).partition(" Warnings ")[2]
        == "beams rod_1, rod_2 and rod_3 are thicker (80.00 m) than long (550.0 mm): sizes are in m"
    )
    assert "thicker" not in err


def test_numbers_do_not_wait_for_it(monkeypatch):
    monkeypatch.setattr(check, "robot_facts", lambda robot: pytest.fail("asked for before anybody reads it"))
    result = ks.analyze(ks.load_robot("3rps").assemble())
    assert result.twist.shape == (6,) and result.beams and result.status == ks.Status.OK


def test_what_is_true_of_the_zero_pose_alone_is_not_said_of_others():
    robot = beyond_limits()
    (warning,) = check.robot_facts(robot).warnings
    assert warning == "at the zero pose foot (0°) is beyond its limits" and robot.warnings == ()
    assert ks.analyze(robot.assemble(actuators={"foot": 0.3})).warnings == ()
    (warning,) = ks.analyze(robot.assemble()).warnings
    assert warning.startswith("foot is beyond its limits of ") and warning.endswith("°: 0°")
