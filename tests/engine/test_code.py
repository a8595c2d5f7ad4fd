"""The name under which code is kept."""

import sys
from pathlib import Path

import numpy as np
import package_robots

from kinetostatics.engine import code
from kinetostatics.engine.loop_record import newton_record
from kinetostatics.engine.pose_record import PoseModel, pose_record
from kinetostatics.engine.record import example_of


def test_the_key_of_kept_code_tells_all_that_is_recorded(monkeypatch):
    """Whatever runs while a robot is recorded: a change of its text makes the code anew."""
    robot, folders = package_robots.robot("2pru_upr"), set()
    root = Path(code.__file__).parent.parent
    example, ready = robot.generic_poses.take(np.zeros(1, dtype=int)), robot.statics

    def note(frame, event, _):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(root) and path.parent != root:
            folders.add(path.relative_to(root).parts[0])

    sys.setprofile(note)
    try:
        pose_record(PoseModel.of(robot.solver, ready, robot.actuator_coordinates), ["twist"], (example.x, *example_of(ready)[1:]))
        newton_record(robot.solver, robot.actuator_coordinates, example)
    finally:
        sys.setprofile(None)
    assert {"statics", "kinematics", "limbs"} <= folders <= {*code._SOURCES, "layout"}
    # and what runs not, but is read: the table of joint types
    before, read = code._versions.__wrapped__(), Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" * (path.name == "joint_types.py"))
    assert code._versions.__wrapped__() != before
