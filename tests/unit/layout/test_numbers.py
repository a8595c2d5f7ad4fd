"""Numbers with units: digits, noise, and names in words."""

from dataclasses import astuple

import numpy as np
import pytest

from kinetostatics.layout import numbers
from kinetostatics.layout.numbers import NoiseFloor, NumberFormat, join_words, largest, quantity, vector


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [
        ("LENGTHS", 2.5, "2.5000 m"),
        ("LENGTHS", 2.5e-3, "2.5000 mm"),
        ("LENGTHS", 2.5e-12, "0.0025000 nm"),
        ("ANGLES", 2.5e-6, "2.5000 µrad"),
        ("FORCES", 25.0, "25.000 N"),
        ("STRESSES", 25e6, "25.000 MPa"),
        ("STIFFNESSES", 2.5e6, "2.5000 N/µm"),
        ("TURNING_STIFFNESSES", 2.5e6, "2.5000 kN·m/mrad"),
        ("ENERGIES", 2.5e-6, "2.5000 µJ"),
    ],
)
def test_numbers_are_written_in_the_suitable_unit(kind, value, text):
    assert quantity(value, getattr(numbers, kind)) == text


def test_larger_unit_is_used_from_one_upwards():
    assert quantity(0.99e-3, numbers.LENGTHS) == "990.00 µm"
    assert quantity(1e-3, numbers.LENGTHS) == "1.0000 mm"
    assert quantity(1e-3 * (1 - 1e-8), numbers.LENGTHS) == "1.00000 mm"  # 1 all but rounding
    assert quantity(1e-3 * (1 - 1e-6), numbers.LENGTHS) == "1000.00 µm"  # 999.999


def test_column_format_follows_its_largest_number():
    form = NumberFormat.of([1.0, -1234.5678, np.nan, np.inf], numbers.FORCES)
    assert (form.unit, form.decimals) == ("N", 1)
    assert [form(value) for value in (-1234.5678, 12.34, 0.5, np.nan, np.inf, -np.inf)] == [
        "-1234.6", "12.3", "5.00e-01", "–", "∞", "-∞",
    ]  # fmt: skip
    assert NumberFormat.of(123456.7, numbers.FORCES)(123456.7) == "123457"
    assert NumberFormat.of(1234.5, numbers.FORCES, digits=3)(1234.5) == "1235"  # halves go up
    assert vector([1.0, 0.0, -1e-3], NumberFormat.of(1.0, numbers.LENGTHS)) == "(1.0000, 0, -0.0010) m"


def test_noise_is_shown_as_zero():
    form = NumberFormat.of([1.0], numbers.FORCES)
    assert form(0.9e-9) == "0" and form(1.1e-9) == "1.10e-09" and form(-0.9e-9) == "0"
    assert NumberFormat.of([1.0], numbers.FORCES, noise=0.1)(0.09) == "0"
    assert quantity(1e-3, numbers.LENGTHS, noise=2e-3) == "0 µm"
    assert quantity(1e-3, numbers.FORCES, noise=2e-3) == "0 N"


def test_largest_ignores_nan_and_infinity():
    assert largest([[1.0, -3.0], 2.0, [np.nan, -np.inf]]) == 3.0 and largest([]) == 0.0


def test_noise_floor_follows_the_larger_part():
    """The larger part, compared by the characteristic length, determines the noise of both."""
    twist, wrench = np.array([3.0, 0, 0, 0.1, 0, 0]), np.array([0, 0, 10.0, 0, 8.0, 0])
    found = NoiseFloor.of([twist], [wrench], 2.0)
    assert astuple(found) == pytest.approx((3e-9, 1.5e-9, 10e-9, 20e-9))
    found = NoiseFloor.of([np.roll(twist, 3)], [np.roll(wrench, 3)], 2.0)
    assert astuple(found) == pytest.approx((6e-9, 3e-9, 8e-9, 16e-9))


def test_noise_floor_formats_show_noise_as_zero():
    found = NoiseFloor(1.0, 2.0, 3.0, 4.0)
    for size, kind in ((0.5, "displacement"), (1.0, "rotation"), (1.5, "force"), (2.0, "moment")):
        assert found.format(kind, size)(size) == "0"
    assert found.format("force", 5.0).with_unit(5.0) == "5.0000 N" and found.format("moment", 5.0, 3).with_unit(5.0) == "5.00 N·m"


def test_joined_names_are_shortened_beyond_six():
    assert join_words(["a"]) == "a" and join_words(["a", "b", "c"]) == "a, b and c"
    assert join_words(list("abcdef")) == "a, b, c, d, e and f" and join_words(list("abcdefg")) == "a, b, c, d, … g (7)"
