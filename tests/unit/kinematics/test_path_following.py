"""Lines of coordinates to distant targets, which unlimited sliding joints can reach; steps, and chunks of poses."""

import numpy as np
import pytest
from package_robots import robot

import kinetostatics as ks
from kinetostatics.kinematics import path_following
from kinetostatics.math import arrays


@pytest.fixture
def corrected(monkeypatch):
    """Return a list to which every call of Newton's method adds one entry."""
    calls, newton = [], path_following.Solver.newton

    def counted(self, *args, **options):
        calls.append(1)
        return newton(self, *args, **options)

    monkeypatch.setattr(path_following.Solver, "newton", counted)
    return calls


@pytest.mark.filterwarnings("ignore:z = 500 m is")
def test_distant_poses_take_few_steps(corrected):
    """Steps of 0.4 m with three corrections each would be thousands."""
    found = robot("3rps").assemble(platform={"z": 500.0, "rx": 0.3, "ry": -0.2}, engine="numpy")
    assert found.status == ks.Status.LIMIT_EXCEEDED and found.residual < 1e-12
    assert [found.platform[name] for name in ("z", "rx", "ry")] == pytest.approx([500.0, 0.3, -0.2], rel=1e-12)
    assert len(corrected) < 150


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:. = .* m is .* times the robot's size")
@pytest.mark.parametrize(
    ("name", "platform"),
    [
        ("3rps", {"z": 30.0, "rx": 0.3, "ry": -0.2}),
        ("gough_stewart", {"x": 20.0, "y": -3.0, "z": 9.0, "rx": 0, "ry": 0.2, "rz": 1.5}),
    ],
)
def test_long_steps_lead_to_the_same_pose(name, platform, corrected, monkeypatch):
    one = robot(name)
    quick = one.assemble(platform=platform, engine="numpy")
    few = len(corrected)
    monkeypatch.setattr(path_following, "_FAR_AWAY", np.inf)
    usual = one.assemble(platform=platform, engine="numpy")
    assert len(corrected) - few > 2 * few
    np.testing.assert_allclose(quick.q, usual.q, rtol=0, atol=1e-11)


@pytest.mark.filterwarnings("ignore:.*times the robot's size|.*turns")
@pytest.mark.parametrize("size", [1e9, 1.7e308])
def test_enormous_targets_are_unreachable_at_once(size, corrected):
    """A single pose is an error; of a batch the other poses are reached."""
    tripod = robot("3rps")
    for wanted in ({"z": size, "rx": 0.1, "ry": 0.0}, {"z": 0.5, "rx": -size, "ry": 0.0}, {"z": 0.5, "rx": 2e3, "ry": 0.0}):
        with pytest.raises(ks.AssemblyError, match=r"lines are followed up to 1e\+08 times the robot's reach and 700 rad"):
            tripod.assemble(platform=wanted, engine="numpy")
    found = tripod.assemble(platform={"z": [0.5, size, 0.55, 0.6], "rx": [0.1, 0.0, size, -0.1], "ry": 0.0}, engine="numpy")
    assert found.status.tolist() == [ks.Status.OK, ks.Status.UNREACHABLE, ks.Status.UNREACHABLE, ks.Status.OK]
    assert len(corrected) <= 2


@pytest.mark.filterwarnings("ignore:.*turns")
def test_serial_arm_reaches_any_angle_in_one_step(corrected):
    """Such lines have no unknowns."""
    arm = robot("ur10")
    first, *others = arm.description.actuated
    found = arm.assemble(actuators={first: 1e6, **dict.fromkeys(others, 0.2)}, engine="numpy")
    near = arm.assemble(actuators={first: 1e6 % (2 * np.pi), **dict.fromkeys(others, 0.2)}, engine="numpy")
    np.testing.assert_allclose(found.platform_frame, near.platform_frame, atol=1e-9)
    assert len(corrected) == 2


@pytest.mark.filterwarnings("ignore:z = 1e")
def test_error_names_loops_left_open_by_rounding():
    with pytest.raises(ks.AssemblyError, match=r"do not close: loop '.*' stays \S+e-10 m open.*, more than the tolerance 1e-10"):
        robot("3rps").assemble(platform={"z": 1e6, "rx": 0.0, "ry": 0.0}, engine="numpy")


@pytest.mark.parametrize("turn", [0.69, 0.72, 1.2, 1.5])
def test_no_step_is_longer_than_0_7_rad(turn, monkeypatch):
    """However well Newton's method converges, for single poses and for the farthest of a batch."""
    goals, newton = [], path_following.Solver.newton

    def watched(self, prescribed, poses, target, *rest):
        goals.append(target[-2])
        return newton(self, prescribed, poses, target, *rest)

    tripod = robot("3rps")
    start = tripod.assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0}, engine="numpy")
    monkeypatch.setattr(path_following.Solver, "newton", watched)
    for rx in (turn, [-turn, 0.1, turn]):
        goals.clear()
        tripod.assemble(platform={"z": 0.5, "rx": rx, "ry": 0.0}, near=start, on_failure="nan", engine="numpy")
        assert np.max(np.abs(goals[0])) == pytest.approx(min(turn, 0.7), rel=1e-12)


@pytest.mark.parametrize("many_starts", [False, True])
def test_poses_in_chunks_equal_poses_assembled_singly(monkeypatch, many_starts):
    z, tilt = np.linspace(0.45, 0.6, 10), {"rx": 0.1, "ry": -0.05}
    near = robot("3rps").assemble(platform={"z": z - 0.03, **tilt}, engine="numpy") if many_starts else None
    whole, *parts = (robot("3rps").assemble(platform={"z": part, **tilt}, engine="numpy") for part in (z, *z))
    monkeypatch.setattr(arrays, "AT_ONCE", 4)
    chunks = robot("3rps").assemble(platform={"z": z, **tilt}, near=near, engine="numpy")
    np.testing.assert_allclose(chunks.q, whole.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(chunks.q, [part.q for part in parts], rtol=0, atol=1e-12)
