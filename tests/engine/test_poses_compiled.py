"""What compiled code says of a pose besides its statics: whether joints are within their limits, by hand."""

import numpy as np
from package_robots import robot as robot_named
from tapes import evaluate

from kinetostatics.engine.pose_record import PoseModel, pose_record
from kinetostatics.kinematics.prescribed import PrescribedCoordinates


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
        record.tape, [x, np.zeros((6, N)), np.zeros((3, N))], model.structure().values, [*record.all_rows(), record.all_hold()]
    )
    np.testing.assert_array_equal(within.astype(bool), wanted)
    assert holds.astype(bool).all()
