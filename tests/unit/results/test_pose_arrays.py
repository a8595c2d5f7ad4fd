"""Every public array is NaN at a pose that cannot be reached."""

from collections.abc import Mapping

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.results.parts import BeamResult, LimbResult, wrench_units
from kinetostatics.results.pose_arrays import Batch

PUBLIC = (ks.Result, ks.Configuration, LimbResult, BeamResult)
#: Attributes of the robot or of a batch's storage, not of its poses.
INNER = {
    *("solutions", "robot", "poses", "frames", "model_q", "loop_residual", "loop_gaps", "beam", "stations", "model", "data"),
    "by_mechanism",
}
#: Prescribed actuator coordinates and excesses over limits, which failed poses have as well.
PRESCRIBED = ("configuration.actuators", "configuration.limits_exceeded")


def arrays(found, name=""):
    """Yield name and value of every public array of a result, its limbs and beams."""
    if isinstance(found, np.ndarray):
        yield name, found
    elif isinstance(found, Mapping):
        for key, value in found.items():
            yield from arrays(value, f"{name}[{key!r}]")
    elif isinstance(found, tuple):
        for key, value in enumerate(found):
            yield from arrays(value, f"{name}[{key}]")
    elif isinstance(found, PUBLIC):
        for attribute in dir(found):
            if not attribute.startswith("_") and attribute not in INNER:
                value = getattr(found, attribute)
                if not callable(value):
                    yield from arrays(value, f"{name}.{attribute}".lstrip("."))


def far(name):
    """Return poses of which the second is out of reach, of robots with serial limbs, rings, parts and dead branches."""
    robot = package_robots.robot(name)
    zero = {key: float(value) for key, value in robot.assemble().platform.items()}
    return robot.assemble(platform={key: np.array([zero[key], zero[key] + 99.0]) for key in "xyz"})


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["orthoglide", "delta", "tripteron", "linear_delta"])
def test_every_array_is_nan_at_unreached_poses(name):
    poses = far(name)
    result = ks.analyze(poses, load=(0, 0, -5, 0, 0, 0))
    assert result.status.tolist() == [ks.Status.OK, ks.Status.UNREACHABLE]
    seen = set()
    for what, array in arrays(result):
        if what.startswith(PRESCRIBED):
            continue
        assert array.shape[0] == 2, what
        if array.dtype.kind == "f":
            assert np.all(np.isnan(array[1])), f"{what} has numbers where no pose is"
            assert not np.any(np.isnan(array[0])), f"{what} lacks numbers where a pose is"
        seen.add(what.partition("[")[0])
    assert {"twist", "base_wrench", "strain_energy", "limbs", "beams", "joint_wrenches"} <= seen
    assert ("part_contributions" in seen) == any(len(limb.parts) > 1 for limb in poses.robot.topology.limbs)


def test_every_array_of_a_single_unreached_pose_is_nan():
    robot = package_robots.robot("five_bar")
    values = np.linspace(-2.5, 2.5, 41)
    drives = list(robot.description.actuated)
    poses = robot.assemble(actuators={drives[0]: values[:, None], drives[1]: -values[None]})
    status = ks.analyze(poses).status
    assert np.any(status == ks.Status.UNREACHABLE) and np.any(status == ks.Status.OK)
    at = tuple(np.argwhere(status == ks.Status.UNREACHABLE)[0])
    one = robot.configuration(poses.q[at], on_failure="nan")
    for what, array in arrays(ks.analyze(one, on_failure="nan")):
        if array.dtype.kind == "f" and not what.startswith(PRESCRIBED):
            assert np.all(np.isnan(array)), what


@pytest.mark.parametrize("engine", ["numpy", "compiled"])
def test_nan_joint_coordinates_make_a_pose_unreachable(engine):
    robot = package_robots.robot("five_bar")
    here = robot.assemble().q
    for k in range(here.size):
        q = np.repeat(here[None], 3, axis=0)
        q[1, k] = np.nan
        for some in (q, q[1]):
            found = ks.analyze(robot.configuration(some, on_failure="nan"), on_failure="nan", engine=engine)
            assert np.array_equal(found.status != ks.Status.UNREACHABLE, np.all(np.isfinite(some), axis=-1))
            assert np.array_equal(np.isnan(found.twist[..., 0]), found.status == ks.Status.UNREACHABLE)


def test_actuator_positions_of_unreached_poses_are_nan():
    machine = package_robots.robot("orthoglide")
    pose = machine.assemble(platform={"x": [0.0, 9.0], "y": 0.0, "z": 0.0})
    assert pose.status.tolist() == [ks.Status.OK, ks.Status.UNREACHABLE]
    for value in pose.actuators.values():
        assert np.isfinite(value).tolist() == [True, False]
    for value in pose.platform.values():
        assert np.isfinite(value).tolist() == [True, False]
    assert np.isnan(pose.q[1]).all() and np.isnan(pose.residual[1])


def test_intensities_of_wrenches_without_force_are_in_newton_metres():
    """Up to rounding, at all poses at which the wrench is known."""
    wrenches = np.zeros((3, 6, 4))
    wrenches[:, 3] = 1.0
    wrenches[0, 0, 1], wrenches[2, 1, 2], wrenches[1, 2, 3] = np.nan, 1e-13, -1e-11
    assert wrench_units(["along x", "along y", "along z", "force"], wrenches) == ["N·m", "N·m", "N·m", "N"]
    assert wrench_units(["couple along x", "force"], np.full((3, 6, 2), np.nan)) == ["N·m", "N"]


def test_chunks_are_joined_in_the_order_of_their_poses():
    numbers = np.arange(12.0).reshape(2, 6)  # two components at six poses
    valid = np.array([True, True, True, False, True, True])
    found = Batch((3, 2), valid).public([numbers[:, :1], numbers[:, 1:4], numbers[:, 4:]])
    expected = np.where(valid[:, None], numbers.T, np.nan).reshape(3, 2, 2)
    np.testing.assert_array_equal(found, expected)
