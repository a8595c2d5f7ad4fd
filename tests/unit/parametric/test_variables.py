"""Ranges of design variables: relative positions and values, linear and logarithmic."""

import numpy as np
import pytest

from kinetostatics.parametric.variables import Range, read_variables

RANGES = [Range("diameter", 0.02, 0.12), Range("angle", -0.5, 1.5), Range("offset", 0.0, 0.3)]


@pytest.mark.parametrize("varied", RANGES, ids=lambda item: item.name)
def test_positions_and_values_stay_in_the_range(varied):
    """Searches step beyond 0 and 1 by rounding and by their differences; a value of the file may lie outside the range."""
    low, high = varied.low, varied.high
    assert [varied.value(u) for u in (-0.3, -1e-12)] == [varied.value(0.0)] * 2
    assert [varied.value(u) for u in (1.0 + 1e-12, 1.7)] == [varied.value(1.0)] * 2
    assert (varied.value(0.0), varied.value(1.0)) == pytest.approx((low, high), rel=1e-15)
    assert varied.place(low - 0.01) == varied.place(low) == 0 and varied.place(high + 0.01) == varied.place(high) == 1
    assert varied.place(low - 5.0) == 0 and varied.place(high + 5.0) == 1


@pytest.mark.parametrize("varied", RANGES, ids=lambda item: item.name)
def test_place_is_the_inverse_of_value(varied):
    positions = np.linspace(0, 1, 9)
    assert [varied.place(varied.value(u)) for u in positions] == pytest.approx(positions.tolist(), abs=1e-14)


def test_positive_ranges_are_divided_in_equal_ratios_others_in_equal_steps():
    values = [[varied.value(u) for u in (0.25, 0.5, 0.75)] for varied in RANGES]
    assert values[0] == pytest.approx(0.02 * 6 ** np.array([0.25, 0.5, 0.75]), rel=1e-14)
    assert values[1] == pytest.approx([0.0, 0.5, 1.0], abs=1e-15) and values[2] == pytest.approx([0.075, 0.15, 0.225], rel=1e-14)


@pytest.mark.parametrize("given", ["20mm:120mm", (0.02, 0.12), ("20mm", "120mm")])
def test_ranges_are_texts_with_a_colon_or_pairs(given):
    (ranges, choices) = read_variables({"diameter": given})
    assert [(item.name, item.low, item.high) for item in ranges] == [("diameter", 0.02, 0.12)] and not choices


@pytest.mark.parametrize("given", ["20mm,120mm", [0.02, 0.12], np.array([0.12, 0.02])])
def test_lists_are_texts_with_commas_lists_or_arrays(given):
    (ranges, (choice,)) = read_variables({"diameter": given})
    assert not ranges and choice.names == ("diameter",) and choice.rows == ((0.02,), (0.12,))
