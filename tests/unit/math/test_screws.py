"""A twist told in words: its axis, and its pitch."""

import numpy as np
import pytest

from kinetostatics.math.screws import describe_twist

pytestmark = pytest.mark.smoke


def test_a_pitch_is_the_way_per_turn():
    """A screw about z through (2, 0, 0) that rises by 0.3 m/rad, at half a rad/s."""
    twist = np.array([0, -2 * 0.5, 0.3 * 0.5, 0, 0, 0.5])
    assert describe_twist(twist, 1.0) == "a rotation about the axis (0, 0, 1) through o + (2, 0, 0) m with a pitch of 0.3 m/rad"
    for factor in (2, -1):
        assert describe_twist(factor * twist, 1.0) == describe_twist(twist, 1.0)
    level = "a rotation about the axis (0, 0, 1) through o + (0, 0, 0) m"
    for pitch, said in ((1.9e-6, False), (2.1e-6, True), (-2.1e-6, True)):
        assert describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0).startswith(level)
        assert ("pitch" in describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0)) == said
    for sign in (1.0, -1.0):
        assert describe_twist(sign * np.array([0, 3.0, 4.0, 0, 0, 0]), 1.0) == "a translation along (0, 0.6, 0.8)"
    for turn, words in ((2e-6, "translation"), (3e-6, "rotation")):  # 5 · 1e-6 / 2 m
        assert describe_twist(np.array([3.0, 4.0, 0, 0, 0, turn]), 2.0).startswith(f"a {words}")
