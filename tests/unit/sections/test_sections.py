"""Cross-sections against textbook values."""

import numpy as np
import pytest

from kinetostatics.exceptions import ArgumentError
from kinetostatics.sections import Rectangle, RectangularTube, Section, Tube
from kinetostatics.sections.stresses import largest_on_rings, shear_functions


def test_area_and_moments_of_circle_and_tube():
    circle = Tube.of(0.1)
    assert circle.area == pytest.approx(np.pi * 0.05**2)
    assert circle.I_y == circle.I_z == pytest.approx(np.pi * 0.1**4 / 64)
    assert pytest.approx(np.pi * 0.1**4 / 32) == circle.J
    tube = Tube.of(0.1, 0.08)
    assert tube.area == pytest.approx(circle.area - Tube.of(0.08).area)
    assert tube.I_y == pytest.approx(circle.I_y - Tube.of(0.08).I_y)


def test_shear_coefficients_equal_cowper():
    """Cowper 1966: solid circle 6(1+ν)/(7+6ν), thin tube 2(1+ν)/(4+3ν), rectangle 10(1+ν)/(12+11ν)."""
    nu = 0.3
    assert Tube.of(0.1).shear_coefficients(nu) == pytest.approx((6 * 1.3 / 8.8,) * 2)
    assert Tube.of(1.0, 0.9999).shear_coefficients(nu) == pytest.approx((2 * 1.3 / 4.9,) * 2, rel=1e-4)
    assert Rectangle.of(0.1, 0.2).shear_coefficients(nu) == pytest.approx((13 / 15.3,) * 2)
    square = RectangularTube.of(1, 1, 1e-4).shear_coefficients(nu)
    assert square[0] == pytest.approx(square[1])
    # thin square box with m = n = 1: 160(1+ν) / (324 + 303ν + 10(6 + 2ν) − …) evaluated by hand for ν = 0.3
    expected = 10 * 1.3 * 16 / (324 + 0.3 * 302 + 10 * (3.3 + 3))
    assert square[0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("ratio", "J", "stress"), [(1, 0.1406, 0.208), (2, 0.229, 0.246), (10, 0.312, 0.312)])
def test_torsion_of_a_rectangle_equals_timoshenko(ratio, J, stress):
    """Timoshenko and Goodier, table in section 109: J = k1 a b³, largest stress T / (k2 a b²)."""
    b = 0.02
    section = Rectangle.of(ratio * b, b)
    assert pytest.approx(J * ratio * b**4, rel=2e-3) == section.J
    twisted = section.stress(np.array([0, 0, 0, 1.0, 0, 0]))
    assert float(twisted) == pytest.approx(np.sqrt(3) / (stress * ratio * b**3), rel=3e-3)
    assert Rectangle.of(b, ratio * b).J == pytest.approx(section.J)


def test_thin_square_tube_equals_thin_wall_formulas():
    section = RectangularTube.of(0.1, 0.1, 0.001)
    side = 0.099
    assert section.area == pytest.approx(4 * side * 0.001)
    assert pytest.approx(side**3 * 0.001, rel=5e-3) == section.J  # Bredt's formula leaves corners out
    assert section.I_y == pytest.approx(2 / 3 * side**3 * 0.001, rel=1e-3)


def test_section_given_by_numbers_has_nan_stress():
    section = Section(1e-3, 1e-7, 2e-7, 1e-7)
    assert np.isnan(section.stress(np.ones((6, 1)))).all()
    assert section.shear_coefficients(0.3) is None
    assert not section.is_isotropic


def test_largest_stress_equals_the_maximum_over_all_sections():
    """Of 21 sections of a tube only those that may have the largest stress are computed."""
    section = Tube.of(0.05, 0.03)
    random = np.random.default_rng(2)
    wrenches = random.standard_normal((6, 21, 40)) * 10.0 ** random.uniform(-3, 0, (6, 1, 40))
    wrenches[4:, :, :20] = np.sqrt(np.abs(wrenches[4:, :, :20]))
    everywhere = section.stress(wrenches.reshape(6, -1)).reshape(21, 40).max(axis=0)
    np.testing.assert_allclose(section.largest_stress(wrenches), everywhere, rtol=1e-6)


@pytest.mark.parametrize("section", [Rectangle.of(0.03, 0.05), RectangularTube.of(0.03, 0.05, 0.004)])
def test_the_largest_stress_is_where_tension_and_shear_add(section):
    """M_z < 0 pulls at +y, where torsion and V_z turn the same way; M_y > 0 pulls at +z, where torsion and V_y differ."""
    N, V, T, M = 3e3, 5e3, 40.0, 60.0
    for together, apart in (
        ([N, 0, V, T, 0, -M], [N, 0, V, T, 0, M]),
        ([N, 0, V, -T, 0, M], [N, 0, V, -T, 0, -M]),
        ([N, V, 0, -T, M, 0], [N, V, 0, -T, -M, 0]),
        ([N, V, 0, T, -M, 0], [N, V, 0, T, M, 0]),
    ):
        assert section.stress(np.array(together)) > 1.02 * section.stress(np.array(apart))


@pytest.mark.parametrize(("thickness", "near"), [(0.004, 0.004), (0.012, 0.0015)])
def test_stress_points_keep_their_distance_from_sharp_corners(thickness, near):
    """The distance is the wall's thickness, or half of the hole's half side, 0.003 for the narrow hole."""
    y, z = shear_functions(0.03, 0.05, thickness).points()
    gap = np.hypot(y - (0.015 - thickness), z - (0.025 - thickness))
    assert gap.min() == pytest.approx(near, rel=1e-9)


@pytest.mark.parametrize("sides", [(0.032, 0.032, 0.004), (0.1, 0.05, 0.002)])
def test_torsion_and_shear_of_tubes_have_smooth_derivatives(sides):
    """Differences by 1e-6 of a size equal those by 1e-3 of it."""

    def slopes(h):
        ends = [RectangularTube.of((1 + k) * sides[0], *sides[1:]) for k in (h, -h)]
        numbers = [np.array([tube.J / sides[0] ** 4, *tube.shear_coefficients(0.3)]) for tube in ends]
        return (numbers[0] - numbers[1]) / (2 * h)

    np.testing.assert_allclose(slopes(1e-6), slopes(1e-3), rtol=1e-4)


def test_bending_is_isotropic_up_to_rounding():
    """Then the y axis of a beam is arbitrary; a difference that a drawing could show makes it matter."""
    for difference, isotropic in ((0.0, True), (1e-13, True), (-1e-13, True), (1e-10, False), (-1e-10, False), (0.1, False)):
        assert Section(1e-4, 1e-9, 1e-9 * (1 + difference), 1e-9).is_isotropic == isotropic


@pytest.mark.parametrize("turned", [False, True])
def test_walls_and_holes_thinner_than_the_least_size_are_refused(turned):
    """1e-5 of the larger side: thinner is a mistake in units, and beyond what the shear functions are accurate for."""
    sides = (0.05, 0.1) if turned else (0.1, 0.05)
    for thickness in (0.9e-6, 0.025 - 0.4e-6):
        with pytest.raises(ArgumentError, match="thickness="):
            RectangularTube.of(*sides, thickness)


@pytest.mark.parametrize("thickness", [1.1e-6, 0.025 - 0.6e-6])
def test_walls_and_holes_of_the_least_size_are_accepted(thickness):
    assert RectangularTube.of(0.1, 0.05, thickness).thickness == thickness


@pytest.mark.parametrize("flat", [1.0, 0.999, 1.001, 0.9, 3.0])
def test_largest_stress_on_a_ring_equals_that_of_many_angles(flat):
    """Squares a + b cos θ + d cos 2θ with b = −4 d have a flat top, at which Newton's method has no slope to divide by."""
    theta, eight = np.linspace(0, 2 * np.pi, 200_000), np.linspace(0, 2 * np.pi, 8, endpoint=False)
    for turn in np.linspace(0.01, 0.25, 13):
        square = 3.0 + np.cos(theta - turn) - flat / 4 * np.cos(2 * (theta - turn))
        forms = np.zeros((1, 8, 21))
        forms[0, :, 0] = 3.0 + np.cos(eight - turn) - flat / 4 * np.cos(2 * (eight - turn))
        found = largest_on_rings(forms, np.eye(6)[:, :1])
        assert found[0] ** 2 == pytest.approx(square.max(), rel=2e-7)


@pytest.mark.parametrize("difference", [2e-16, 1e-15, -1e-15, 1e-14, 1e-12])
def test_rectangles_square_but_for_rounding(difference):
    """The hole of a solid rectangle was not quite zero: stresses were wrong by up to 122 %."""
    wrench = np.array([10.8, -19.5, -316.5, 8.7, 92.6, 0.7])
    square = Rectangle.of(0.035, 0.035).stress(wrench)
    assert Rectangle.of(0.035, 0.035 * (1 + difference)).stress(wrench) == pytest.approx(square, rel=1e-9)
    assert Rectangle.of(0.035 * (1 + difference), 0.035).stress(wrench) == pytest.approx(square, rel=1e-9)
