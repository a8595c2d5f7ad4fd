"""Lines that lead far away from the robot, where sliding joints without end get that far."""

import numpy as np
import pytest
from package_robots import robot

import kinetostatics as ks
from kinetostatics.kinematics import lines


@pytest.fixture
def corrected(monkeypatch):
    """Return a list to which every call of Newton's method adds one entry."""
    calls, newton = [], lines.Solver.newton

    def counted(self, *args, **options):
        calls.append(1)
        return newton(self, *args, **options)

    monkeypatch.setattr(lines.Solver, "newton", counted)
    return calls


@pytest.mark.filterwarnings("ignore:z = 500 m is")
def test_poses_a_long_way_off_take_few_steps(corrected):
    """Some three corrections for each 0.4 m would be thousands."""
    found = robot("3rps").assemble(platform={"z": 500.0, "rx": 0.3, "ry": -0.2}, engine="numpy")
    assert found.status == ks.Status.LIMIT_EXCEEDED and found.residual < 1e-12
    assert [found.platform[name] for name in ("z", "rx", "ry")] == pytest.approx([500.0, 0.3, -0.2], rel=1e-12)
    assert len(corrected) < 150


@pytest.mark.few(1)
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
    monkeypatch.setattr(lines, "_FAR_AWAY", np.inf)
    usual = one.assemble(platform=platform, engine="numpy")
    assert len(corrected) - few > 2 * few
    np.testing.assert_allclose(quick.q, usual.q, rtol=0, atol=1e-11)
