"""Unit hints of a robot's methods at the caller's line, and the robot of a pose."""

import warnings

import pytest
from simple_machines import arm

import kinetostatics as ks
from kinetostatics.robot import robot_of


@pytest.mark.parametrize("given", [{"actuators": {"shoulder": 100.0, "elbow": 0.1}}, {"platform": {"x": 0.3, "z": 90.0}}])
def test_unit_warnings_point_to_the_calling_line(given):
    machine = arm(kind="continuous")
    with pytest.warns(UserWarning, match="100 rad is|90 m is") as caught:
        machine.assemble(**given, on_failure="nan")
    assert len(caught) == 1 and caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        machine.assemble(actuators={"shoulder": 0.1, "elbow": 0.1})
        machine.assemble()


def test_robot_of_a_pose_must_have_statics():
    machine = arm()
    pose = machine.assemble()
    assert robot_of(pose) is machine
    with pytest.raises(ks.ArgumentError, match="which has no statics"):
        robot_of(type("Pose", (), {"robot": None})())
