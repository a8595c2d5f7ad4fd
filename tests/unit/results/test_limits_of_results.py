"""Results where nothing is known, or where a value is at its limit: NaN, no warning, and rounding that breaks no requirement."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest
from places import CASES

import kinetostatics as ks
from kinetostatics.design.problem import Evaluation
from kinetostatics.results.compensation import _units


@pytest.mark.parametrize(("violation", "feasible"), [(0.0, True), (0.9e-6, True), (1.1e-6, False), (1.0, False)])
def test_requirements_are_broken_by_more_than_a_millionth_of_the_limit(violation, feasible):
    found = Evaluation(1.0, np.array([1.0, 0.3, -violation]), SimpleNamespace(), [])
    assert found.violation == violation and found.feasible == feasible
    assert not Evaluation(1.0, np.array([1.0]), None, []).feasible


def test_wrenches_of_indeterminate_limbs_are_nan():
    """Two rigid limbs share the load in an unknown ratio; of a robot whose forces are determinate nothing is NaN."""
    result = ks.analyze(ks.load_robot(CASES / "two_rigid.urdf").assemble(), load=[1, 2, 3, 0.1, 0.2, 0.3])
    assert result.indeterminate and all(np.isnan(limb.wrench).all() for limb in result.limbs.values())
    result = ks.analyze(package_robots.robot("3rps").assemble(), load=[1, 2, 3, 0.1, 0.2, 0.3])
    assert not result.indeterminate and all(np.isfinite(limb.wrench).all() for limb in result.limbs.values())


def test_pose_out_of_reach_has_no_warning_of_buckling():
    with pytest.warns(UserWarning, match="lengths are in m"):
        pose = package_robots.robot("five_bar").assemble(platform={"x": 9.0, "y": 0.0}, on_failure="nan")
    result = ks.analyze(pose)
    assert np.isnan(result.twist).all() and not any("buckl" in text or "stiffness" in text for text in result.warnings)


def test_coordinates_of_compensations_are_in_metres_or_radians():
    found = ks.compensate(package_robots.robot("3rps").assemble(), load=[0, 0, -500, 0, 0, 0])
    units = _units(found)
    assert {units[name] for name in "xyz"} == {"m"} and {units[name] for name in ("rx", "ry", "rz")} == {"rad"}
    assert {units[name] for name in found.actuators} == {"m"}


def test_frequency_responses_of_several_poses_are_not_written_as_one_table(tmp_path):
    robot = package_robots.robot("five_bar")
    zero = robot.assemble().platform
    poses = robot.assemble(platform={"x": float(zero["x"]) + np.array([0.0, 0.01]), "y": float(zero["y"])})
    several, one = (ks.frequency_response(pose, [1.0, 5.0]) for pose in (poses, robot.assemble()))
    for found, name in ((several, "response.csv"), (one, "response.txt")):
        with pytest.raises(ks.ArgumentError, match="cannot be written: the frequency response of one pose"):
            found.save(tmp_path / name)
    one.save(tmp_path / "response.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["response.csv"]
