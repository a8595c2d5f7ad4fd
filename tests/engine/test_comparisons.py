"""What compiled code is compared by, and how numbers are written in C."""

import numpy as np
import pytest

from kinetostatics.engine.c_code import literal
from kinetostatics.engine.pose_code import agree

NUMBERS = np.array([3.0, -2.0, 0.0, np.nan])


def test_arrays_agree_up_to_1e_7_of_their_largest_number():
    assert agree(NUMBERS, NUMBERS + 2.9e-7) and not agree(NUMBERS, NUMBERS + 3.1e-7)
    assert not agree(NUMBERS, np.nan_to_num(NUMBERS)) and not agree(np.nan_to_num(NUMBERS), NUMBERS)
    assert not agree(NUMBERS, NUMBERS[:, None]) and not agree(NUMBERS, NUMBERS > 0)
    truths = np.array([True, False])
    assert agree(truths, truths.copy()) and not agree(truths, ~truths) and not agree(truths, truths * 1.0)
    assert (
        agree(np.zeros((2, 0)), np.zeros((2, 0)))
        and agree(np.zeros(3), np.zeros(3))
        and not agree(np.zeros(3), np.full(3, 1e-20))
    )


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.nan, "(double)NAN"), (np.inf, "(double)INFINITY"), (-np.inf, "(-(double)INFINITY)"), (2.0, "2.0"), (-0.5, "(-0.5)"),
        (-0.0, "(-0.0)"), (0.1, "0.1"), (1e22, "1e+22"), (1e-7, "1e-07"), (1 / 3, "0.3333333333333333"), (7, "7.0"),
    ],
)  # fmt: skip
def test_numbers_are_literals_of_doubles_with_all_digits(value, text):
    assert literal(value) == text
