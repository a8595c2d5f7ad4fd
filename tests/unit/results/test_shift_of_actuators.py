"""How far compensation moves an actuator: what turns goes the shorter way, what slides has only one."""

import numpy as np
import pytest

from kinetostatics.results.compensation import shift_of


@pytest.mark.parametrize(
    ("wanted", "corrected", "turn"),
    [(3.1, -3.1, 2 * np.pi - 6.2), (-3.1, 3.1, 6.2 - 2 * np.pi), (0.1, 0.3, 0.2), (0.0, 12.6, 12.6 - 4 * np.pi)],
)
def test_shifts(wanted, corrected, turn):
    assert shift_of(np.array([wanted]), np.array([corrected]), False) == pytest.approx(turn, abs=1e-12)
    assert shift_of(np.array([wanted]), np.array([corrected]), True) == corrected - wanted
