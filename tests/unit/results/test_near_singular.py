"""Measures of how nearly singular a pose is, of limbs made by hand."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.results.warnings import NearSingularity, _bases, _joint_forces


def network(**changes):
    """Two chords that share a force along x and a moment about z of 2 m · N: 3 and 4 times the force, and large moments."""
    J_c, cut_wrenches = np.zeros((6, 2, 1, 1)), np.zeros((2, 6, 2, 1, 1))
    J_c[0, 0], J_c[5, 1] = 1.0, 2.0
    cut_wrenches[0, 0, 0], cut_wrenches[1, 1, 0], cut_wrenches[:, 3:] = 3.0, 4.0, 1e3
    return SimpleNamespace(J_c=J_c, cut_wrenches=cut_wrenches, **changes)


def test_forces_in_the_joints_of_a_network_leave_moments_out():
    sizes, wrenches = _joint_forces(network(), 2.0)
    assert sizes == pytest.approx(5.0, rel=1e-12)
    np.testing.assert_allclose(np.abs(wrenches[0, 0]), [1, 0, 0, 0, 0, 0], atol=1e-12)


def test_moments_count_by_the_characteristic_length():
    Q, R = _bases(network(), 4.0)
    np.testing.assert_allclose(np.abs(R[0, 0]), [[1, 0], [0, 0.5]], atol=1e-15)
    np.testing.assert_allclose(np.abs(Q[0, 0]), np.eye(6)[:, [0, 5]], atol=1e-15)


def test_which_poses_are_nearly_singular():
    found = NearSingularity(np.array([0.021, 0.019, 1.0, 1.0, np.nan]), np.array([0.0, 0, 49, 51, np.nan]))
    assert found.where.tolist() == [False, True, False, True, False]
    assert NearSingularity(np.array([0.5, 0.1, 0.3]), np.array([1.0, 2, 11])).worst == 2
    assert NearSingularity(np.array([0.5, 0.05, 0.3]), np.array([1.0, 2, 11])).worst == 1


@pytest.mark.parametrize("name", ["3rps", "2pru_upr", "delta"])
def test_joints_are_not_called_dependent_at_ordinary_poses(name):
    """Which would cost a decision about every pose by itself, and where they are dependent there would be none."""
    found = ks.analyze(package_robots.robot(name).assemble())
    assert not any(item.doubtful.any() for item in found.solutions[0].statics)
