"""Corrections of single actuators, and twists that the actuators cannot produce."""

import numpy as np
import pytest
from swinging_plate import parallelogram

import kinetostatics as ks
from kinetostatics.results.compensation import shift_of, uncorrectable_directions


def test_basis_of_uncorrectable_twists_changes_with_the_pose():
    """A plate on a circular path moves along x with upright rods, so that y and z are left, and along z with flat ones."""
    robot = ks.Robot(parallelogram())
    angles = np.array([0.0, 1.5, 1.52])
    batch = uncorrectable_directions(robot.assemble(actuators={"a": angles}), None)
    alone = uncorrectable_directions(robot.assemble(actuators={"a": 1.5}), None)
    np.testing.assert_allclose(batch[..., 1], alone[..., 0], atol=1e-9)
    np.testing.assert_allclose(batch[..., 2], batch[..., 1], atol=0.02 * robot.length)
    free = np.array([np.cos(angles), 0 * angles, -np.sin(angles), *np.zeros((3, 3))])
    np.testing.assert_allclose(np.einsum("in,ikn->kn", free, batch), 0, atol=1e-9)


@pytest.mark.parametrize(
    ("wanted", "corrected", "turn"),
    [(3.1, -3.1, 2 * np.pi - 6.2), (-3.1, 3.1, 6.2 - 2 * np.pi), (0.1, 0.3, 0.2), (0.0, 12.6, 12.6 - 4 * np.pi)],
)
def test_hinge_corrections_are_taken_within_half_a_turn(wanted, corrected, turn):
    assert shift_of(np.array([wanted]), np.array([corrected]), False) == pytest.approx(turn, abs=1e-12)
    assert shift_of(np.array([wanted]), np.array([corrected]), True) == corrected - wanted
