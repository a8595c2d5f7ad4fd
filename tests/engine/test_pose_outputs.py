"""What compiled code says of a pose besides its statics: whether loops are closed and joints within limits, by hand."""

import numpy as np
import pytest
from package_robots import robot as robot_named
from tapes import evaluate

from kinetostatics.engine import pose_outputs
from kinetostatics.engine.pose_record import PoseModel, pose_record
from kinetostatics.kinematics.prescribed import PrescribedCoordinates

#: All links of the five-bar [m].
LENGTH = 0.23


def rows(robot):
    """Return in which row of x the angles of the tree's joints are."""
    of_bodies = {joint.body: joint.first_q for joint in robot.solver.tree.joints}
    return {name: of_bodies[body] for name, body in robot.mechanism.body_of_joint.items() if body in of_bodies}


def test_limits_of_all_joints_are_those_of_the_file():
    """The wrist, a loop, turns by what the arms do together; full turns more or less are the same angle."""
    robot, random, N = robot_named("five_bar"), np.random.default_rng(1), 400
    x = random.uniform(-1.8, 1.8, (4, N))
    turned = {name: x[row] for name, row in rows(robot).items()}
    wrist = turned["shoulder_1"] + turned["elbow_1"] - turned["shoulder_2"] - turned["elbow_2"]
    wrist = np.abs(np.arctan2(np.sin(wrist), np.cos(wrist)))
    most = {"shoulder": np.radians(80), "elbow": np.radians(85)}
    wanted = wrist <= np.radians(170)
    for name, angle in turned.items():
        wanted &= np.abs(angle) <= most[name.partition("_")[0]]
    assert 20 < wanted.sum() < N - 20
    model = PoseModel.of(robot.solver, robot.statics, PrescribedCoordinates())
    record = pose_record(model, ["within"], (x[:, :1], np.zeros((6, 1)), np.zeros((3, 1))))
    within, holds = evaluate(
        record.tape, [x, np.zeros((6, N)), np.zeros((3, N))], model.taken_apart().values, [*record.all_rows(), record.all_hold()]
    )
    np.testing.assert_array_equal(within.astype(bool), wanted)
    assert holds.astype(bool).all()


@pytest.mark.parametrize(("rough", "tolerance"), [(1e-4, 1e-3), (1e-3, 1e-4)])
def test_a_pose_counts_where_its_loops_are_closed(rough, tolerance, monkeypatch):
    """A distal link turned by an angle takes the wrist apart by the chord; the lesser of both limits counts."""
    monkeypatch.setattr(pose_outputs, "rough_residual", lambda robot: rough)
    robot = robot_named("five_bar")
    outputs = pose_outputs.CompiledOutputs(robot, robot.statics, ("actuators",), tolerance)
    opened = 1e-4 * np.array([0.0, 0.5, 0.98, 1.5, 2.0, 5.0])
    x = np.repeat(robot.zero_poses.x, 6, axis=1)
    x[rows(robot)["elbow_2"]] += 2 * np.arcsin(opened / 2 / LENGTH)
    found, fine, within = outputs(x, np.zeros((6, 6)), np.zeros((3, 6)))
    np.testing.assert_allclose(found["residual"], opened, rtol=0, atol=1e-15)
    assert fine.tolist() == [True, True, True, False, False, False] and within.all()
    for k in range(6):
        assert (outputs.bound(x[:, k : k + 1])[2]() is not None) == fine[k]
