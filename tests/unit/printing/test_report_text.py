"""Numbers as reports write them: units, digits, noise; tables and lines."""

from dataclasses import astuple

import numpy as np
import pytest

from kinetostatics.printing import text as report_text
from kinetostatics.printing.text import (
    Column,
    Magnitudes,
    Scale,
    column_table,
    largest,
    listing,
    once,
    quantity,
    section,
    table,
    vector,
    warning_lines,
    wide_table,
    wrapped,
)  # fmt: skip

pytestmark = pytest.mark.smoke


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [
        ("LENGTHS", 2.5, "2.5000 m"),
        ("LENGTHS", 2.5e-3, "2.5000 mm"),
        ("LENGTHS", 2.5e-6, "2.5000 µm"),
        ("LENGTHS", 2.5e-9, "2.5000 nm"),
        ("LENGTHS", 2.5e-12, "0.0025000 nm"),
        ("ANGLES", 2.5, "2.5000 rad"),
        ("ANGLES", 2.5e-3, "2.5000 mrad"),
        ("ANGLES", 2.5e-6, "2.5000 µrad"),
        ("ANGLES", 2.5e-9, "2.5000 nrad"),
        ("FORCES", 25.0, "25.000 N"),
        ("MOMENTS", 25.0, "25.000 N·m"),
        ("STRESSES", 25e6, "25.000 MPa"),
        ("MASSES", 25.0, "25.000 kg"),
        ("STIFFNESSES", 2.5e3, "2.5000 N/mm"),
        ("STIFFNESSES", 2.5e6, "2.5000 N/µm"),
        ("TURNING_STIFFNESSES", 2.5, "2.5000 N·m/rad"),
        ("TURNING_STIFFNESSES", 2.5e3, "2.5000 N·m/mrad"),
        ("TURNING_STIFFNESSES", 2.5e6, "2.5000 kN·m/mrad"),
        ("ENERGIES", 2.5, "2.5000 J"),
        ("ENERGIES", 2.5e-3, "2.5000 mJ"),
        ("ENERGIES", 2.5e-6, "2.5000 µJ"),
    ],
)
def test_every_unit_stands_for_its_number(kind, value, text):
    assert quantity(value, getattr(report_text, kind)) == text


def test_a_unit_is_taken_from_its_own_size_on():
    assert quantity(0.99e-3, report_text.LENGTHS) == "990.00 µm"
    assert quantity(1e-3, report_text.LENGTHS) == "1.0000 mm"
    assert quantity(1e-3 * (1 - 1e-8), report_text.LENGTHS) == "1.00000 mm"  # 1 all but rounding
    assert quantity(1e-3 * (1 - 1e-6), report_text.LENGTHS) == "1000.00 µm"  # 999.999


def test_a_column_has_one_unit_and_as_many_digits_as_its_largest_number_needs():
    scale = Scale.of([1.0, -1234.5678, np.nan, np.inf], report_text.FORCES)
    assert (scale.unit, scale.decimals) == ("N", 1)
    assert [scale(value) for value in (-1234.5678, 12.34, 0.5, np.nan, np.inf, -np.inf)] == [
        "-1234.6", "12.3", "5.00e-01", "–", "∞", "-∞",
    ]  # fmt: skip
    assert Scale.of(123456.7, report_text.FORCES)(123456.7) == "123457"
    assert Scale.of(1234.5, report_text.FORCES, digits=3)(1234.5) == "1235"  # halves go up
    assert vector([1.0, 0.0, -1e-3], Scale.of(1.0, report_text.LENGTHS)) == "(1.0000, 0, -0.0010) m"


def test_noise_is_shown_as_zero():
    scale = Scale.of([1.0], report_text.FORCES)
    assert scale(0.9e-9) == "0" and scale(1.1e-9) == "1.10e-09" and scale(-0.9e-9) == "0"
    assert Scale.of([1.0], report_text.FORCES, noise=0.1)(0.09) == "0"
    assert quantity(1e-3, report_text.LENGTHS, noise=2e-3) == "0 µm"
    assert quantity(1e-3, report_text.FORCES, noise=2e-3) == "0 N"


def test_the_largest_of_many():
    assert largest([[1.0, -3.0], 2.0, [np.nan, -np.inf]]) == 3.0 and largest([]) == 0.0


def test_noise_of_twists_and_wrenches():
    """Linear and angular quantities are of one kind: the larger one tells what is noise in both."""
    twist, wrench = np.array([3.0, 0, 0, 0.1, 0, 0]), np.array([0, 0, 10.0, 0, 8.0, 0])
    found = Magnitudes.of([twist], [wrench], 2.0)
    assert astuple(found) == pytest.approx((3e-9, 1.5e-9, 10e-9, 20e-9))
    found = Magnitudes.of([np.roll(twist, 3)], [np.roll(wrench, 3)], 2.0)
    assert astuple(found) == pytest.approx((6e-9, 3e-9, 8e-9, 16e-9))


def test_tables_and_lines():
    assert table(("a", "bb", "c"), [("left", "1", "22"), ("x", "333", "4")], "lrl") == [
        "a      bb  c",
        "left    1  22",
        "x     333  4",
    ]
    wide = wide_table(("name", *(f"column_{k:02}" for k in range(12))), [("row", *(str(k) for k in range(12)))])
    assert max(map(len, wide)) <= report_text.WIDTH and wide[0].split()[0] == wide[3].split()[0] == "name" and wide[2] == ""
    assert len(wide) == 5 and wide[0].split()[1:] + wide[3].split()[1:] == [f"column_{k:02}" for k in range(12)]
    assert len(wide[0].split()) - 1 == (report_text.WIDTH - 6) // 11
    assert wrapped("one two three", "- ", 9) == ["- one two", "  three"] and wrapped("", "- ") == ["-"]
    assert listing(["a"]) == "a" and listing(["a", "b", "c"]) == "a, b and c"
    assert listing(list("abcdef")) == "a, b, c, d, e and f" and listing(list("abcdefg")) == "a, b, c, d, … g (7)"
    assert once(["a", "a", "b", "a", "a"]) == ["a", "", "b", "a", ""] and once([]) == []
    assert section("Title", ["one", ""]) == ["", "Title", "  one", ""]
    assert warning_lines([]) == ["", "Warnings", "  none"] and warning_lines(["a", "b"])[2:] == ["  ! a", "  ! b"]
    assert table(("a", "b", "c"), [("x", "y", "long")])[1] == "x  y  long"  # the first to the left, the others to the right
    found = Magnitudes(1.0, 2.0, 3.0, 4.0)
    assert [
        found.scale(kind, 0.5 * k + 0.5)(0.5 * k + 0.5) for k, kind in enumerate(("displacement", "rotation", "force", "moment"))
    ] == ["0"] * 4
    assert found.scale("force", 5.0).with_unit(5.0) == "5.0000 N" and found.scale("moment", 5.0, 3).with_unit(5.0) == "5.00 N·m"
    columns = [Column("name", ["x", "y"]), Column.of("force", [1.0, None], Scale.of(1.0, report_text.FORCES))]
    assert column_table(columns) == ["name  force [N]", "x        1.0000", "y"]
    assert Column.of("n", [2.0], Scale.of(2.0, report_text.FORCES), with_unit=False).title == "n"
