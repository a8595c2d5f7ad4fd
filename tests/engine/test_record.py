"""Records of poses against NumPy, for every robot of the package; guards tell where a record does not hold."""

import numpy as np
import package_robots
import pytest
import small_robots
from tapes import RANDOM, assert_recorded, differences, evaluate, evaluated, record_of, solved, some_poses

from kinetostatics.engine.pose_code import STABILITY, pose_model
from kinetostatics.engine.pose_record import Pose, PoseModel, pose_record
from kinetostatics.engine.recorder import Structure
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.kinematics.coordinates import PrescribedCoordinates


@pytest.mark.few(1)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_pose_record_equals_numpy_for_package_robots(name):
    robot = package_robots.robot(name)
    found, _ = assert_recorded(robot)
    assert {"contributions", "compliance", "stiffness", "intensities", "actuator_forces"} <= set(found)


def test_sections_and_masses_are_parameters_of_records():
    """A record made for one robot holds for another of the same structure."""
    thin, thick = (package_robots.robot("3rps", rod_diameter=d) for d in (0.07, 0.09))
    assert Structure(thin.statics).key == Structure(thick.statics).key
    assert Structure(thin.statics).key != Structure(package_robots.robot("3prs").statics).key
    poses = some_poses(thick)
    found, holds = evaluated(thick, record_of(thin), *poses)
    assert np.all(holds) and max(differences(found, solved(thick, *poses)).values()) < 1e-11
    twists = [item["contributions"].sum(axis=0) for item in (found, solved(thin, *poses))]
    assert np.max(np.abs(twists[0] - twists[1])) > 0.1 * np.max(np.abs(twists[0]))


def test_values_outside_the_structure_cannot_be_recorded(monkeypatch):
    robot = package_robots.robot("3rps")
    for broken in (lambda pose: pose.statics.example, lambda pose: float(pose.statics.length)):
        monkeypatch.setattr(Pose, "solution", property(broken))
        with pytest.raises(NotRecordedError):
            record_of(robot)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_stability_record_equals_numpy(name):
    """Under loads that grow until every robot buckles."""
    robot = package_robots.robot(name)
    if not robot.members.names:
        return
    x, load, gravity = some_poses(robot)
    force = 10.0 ** np.arange(-1, 11)
    x, load, gravity = (np.repeat(array, force.size, axis=1) for array in (x, load, gravity))
    load *= np.tile(force, load.shape[1] // force.size) / np.linalg.norm(load, axis=0)
    found, holds = evaluated(robot, record_of(robot, STABILITY), x, load, gravity, stages=STABILITY)
    wanted = Pose(pose_model(robot, robot.statics, STABILITY)[0], x, load, gravity).is_stable()
    assert holds.all() and wanted.any() and not wanted.all()
    np.testing.assert_array_equal(found["is_stable"], wanted)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(len(RANDOM)))
def test_pose_record_equals_numpy_for_random_robots(seed):
    """Where the record holds, within a tolerance that grows with the condition number of the stiffness."""
    robot = small_robots.robot_of(small_robots.random_spec(RANDOM[seed], seed))
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot), *poses)
    assert np.mean(holds) > 0.8
    wanted = solved(robot, *poses)
    np.testing.assert_array_equal(found["singular"][holds], wanted["singular"][holds])
    here = np.flatnonzero(holds & ~wanted["singular"])
    if here.size:
        poses = tuple(array[:, here] for array in poses)
        found, _ = evaluated(robot, record_of(robot), *poses)
        wanted = solved(robot, *poses)
        worst = differences(found, wanted)
        scale = np.array([1.0] * 3 + [1 / robot.length] * 3)
        K = np.moveaxis(wanted["stiffness"], 2, 0) * scale * scale[:, None]
        assert max(worst.values()) < 1e-11 + 1e-15 * np.max(np.linalg.cond(K)), max(worst, key=worst.get)


def test_values_within_rounding_of_constants_belong_to_structure():
    """0, 1 and −1 save operations; a difference of 1e-14 from them is rounding, for zeros relative to the largest entry."""
    plain = np.array([1.0, 0.0, -1.0, 1 + 5e-15, -1 - 5e-15, 5e-15])
    assert Structure([plain]).values.size == 0 and Structure([1.0, -1.0, 0.0]).values.size == 0
    others = np.array([1 + 2e-14, -1 + 2e-14, 2e-14, 0.5])
    np.testing.assert_array_equal(Structure([others]).values, others)
    np.testing.assert_array_equal(Structure([np.array([1e3, 5e-12])]).values, [1e3])
    np.testing.assert_array_equal(Structure([plain], all_vary=True).values, plain)


def rows(robot):
    """Return in which row of x the angles of the tree's joints are."""
    of_bodies = {joint.body: joint.first_q for joint in robot.solver.tree.joints}
    return {name: of_bodies[body] for name, body in robot.mechanism.body_of_joint.items() if body in of_bodies}


def test_recorded_joint_limits_equal_the_file():
    """The wrist, a loop joint, turns by the sum of the arms' angles, up to full turns."""
    robot, random, N = package_robots.robot("five_bar"), np.random.default_rng(1), 400
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
