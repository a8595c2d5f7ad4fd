"""The platform's Jacobian against differences of assembled poses and against actuator forces; its condition number."""

import numpy as np
import package_robots
import pinocchio as pin
import pytest

import kinetostatics as ks
from kinetostatics.files.bundled import shipped_robots

ROBOTS = sorted(set(shipped_robots()) - {"anymal_standing"})
STEP = 1e-3


def asymmetric(name):
    """Return a pose whose actuators are a few hundredths [rad, 5 lengths] from those of the zero pose, each by another amount."""
    robot = package_robots.robot(name)
    zero, joints = robot.assemble(), robot.mechanism.connections
    moved = {}
    for k, (actuator, value) in enumerate(zero.actuators.items()):
        by = 0.02 * (1.3, -0.7, 0.4, -1.1, 0.9, 0.6)[k]
        moved[actuator] = value + by * (robot.length if joints[actuator].type.is_slide else 1.0)
    return robot.assemble(actuators=moved, near=zero)


def moved_frame(pose, actuator, by):
    values = {**pose.actuators, actuator: pose.actuators[actuator] + by}
    return pose.robot.assemble(actuators=values, near=pose, closure_tolerance=1e-12).platform_frame


def twist(frame, other):
    return np.r_[other[:3, 3] - frame[:3, 3], pin.log3(other[:3, :3] @ frame[:3, :3].T)]


@pytest.mark.few(5)
@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_equals_differences_of_assembled_poses(name):
    pose = asymmetric(name)
    frame, joints = pose.platform_frame, pose.robot.mechanism.connections
    assert pose.jacobian.shape == (6, len(pose.actuators)) and not pose.jacobian.flags.writeable
    for k, actuator in enumerate(pose.actuators):
        h = STEP * (pose.robot.length if joints[actuator].type.is_slide else 1.0)
        ends = {n: twist(frame, moved_frame(pose, actuator, n * h)) for n in (-2, -1, 1, 2)}
        column = (8 * (ends[1] - ends[-1]) - (ends[2] - ends[-2])) / (12 * h)
        assert pose.jacobian[:, k] == pytest.approx(column, abs=1e-6 * max(1.0, np.abs(column).max())), actuator


@pytest.mark.parametrize("name", ROBOTS)
def test_actuators_do_the_work_of_loads(name):
    """An actuator's force due to a load is minus the load's work on the actuator's column."""
    pose = asymmetric(name)
    load = np.array([30.0, -20.0, 50.0, 2.0, 1.0, -3.0])
    result = ks.analyze(pose, load=load)
    forces = [parts["load"] for parts in result.actuator_contributions.values()]
    assert -pose.jacobian.T @ load == pytest.approx(np.array(forces), rel=1e-7, abs=1e-7)


def test_condition_number_of_known_poses():
    """1 where the Orthoglide and the Tripteron are isotropic; infinite for a stretched arm; no unit of length matters."""
    numbers = {name: package_robots.robot(name).assemble().condition_number for name in ("orthoglide", "tripteron", "ur10")}
    assert numbers["orthoglide"] == pytest.approx(1.0, abs=1e-9) and numbers["tripteron"] == pytest.approx(1.0, abs=1e-9)
    assert np.isinf(numbers["ur10"])
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.2, "ry": 0.1})
    values = np.linalg.svd(np.diag([1, 1, 1, *[robot.length] * 3]) @ pose.jacobian, compute_uv=False)
    assert pose.condition_number == pytest.approx(values[0] / values[-1], rel=1e-12) and values[0] / values[-1] > 1.1
    arm = asymmetric("ur10")
    length = arm.robot.length
    assert arm.condition_number == pytest.approx(np.linalg.cond(np.diag([1, 1, 1, *[length] * 3]) @ arm.jacobian), rel=1e-9)


def test_five_bar_near_its_singular_pose():
    """The condition number grows with the inverse distance from the pose at which the distal links (230 mm) are in one line."""
    robot, y = package_robots.robot("five_bar"), np.sqrt(0.23**2 - (0.23 - 0.1375) ** 2)
    poses = robot.assemble(platform={"x": 0.0, "y": y + np.array([1e-3, 1e-4, 0.0])})
    assert (
        poses.condition_number[1] == pytest.approx(10 * poses.condition_number[0], rel=0.01) and poses.condition_number[0] > 200
    )
    assert np.isnan(poses.condition_number[2]) and np.isnan(poses.jacobian[2]).any()


def test_batch_first_and_nan_without_a_pose_or_with_redundant_actuators():
    robot = package_robots.robot("delta")
    target = {name: robot.assemble().platform[name] for name in "yz"}
    poses = robot.assemble(platform={"x": [[0.0, 0.01, 0.02], [2.0, 2.1, 2.2]], **target}, on_failure="nan")
    assert poses.jacobian.shape == (2, 3, 6, 3) and poses.condition_number.shape == (2, 3)
    single = robot.assemble(platform={"x": 0.02, **target})
    np.testing.assert_allclose(poses.jacobian[0, 2], single.jacobian, rtol=1e-8, atol=1e-10)
    assert np.isnan(poses.jacobian[1]).all() and np.isnan(poses.condition_number[1]).all()
    stand = package_robots.robot("anymal_standing").assemble()
    assert np.isnan(stand.jacobian).all() and np.isnan(stand.condition_number)
