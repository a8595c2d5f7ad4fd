"""Broyden's search, step by step, on numbers that are known by hand."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.compensation.search import STALE, Coordinates, Search, _learnt, enough
from kinetostatics.math.orientation import orientation_named


def test_what_counts_as_corrected_grows_with_robots_above_a_metre():
    assert [enough(length) for length in (0.2, 1.0, 5.0)] == pytest.approx([1e-12, 1e-12, 5e-12])


@pytest.mark.parametrize(
    ("gives", "learns"), [(2.0, True), (0.2, True), (0.05, False), (-0.05, False), (-0.5, True), (np.nan, False)]
)
def test_a_slope_is_learnt_unless_it_says_next_to_nothing(gives, learns):
    """One coordinate, a step of a millimetre, and the change of the error that came of it: the inverse slope is their ratio."""
    step = np.array([[1e-3]])
    found = _learnt(np.ones((1, 1, 1)), step, gives * step, np.array([True]))
    assert found[0, 0, 0] == pytest.approx(1 / gives if learns else 1.0)
    assert _learnt(np.ones((1, 1, 1)), step, 2 * step, np.array([False]))[0, 0, 0] == 1.0


def test_a_search_goes_on_as_long_as_errors_are_halved():
    """From the first error each next one is a part of the one before: 0.45 is less than half of it, 0.55 is not."""
    for part, goes_on in ((0.45, True), (0.55, False)):
        error = np.array([[1.0]])
        search = Search.begun(np.zeros((1, 1)), 1e-9 * np.ones((1, 1, 1)), error)  # which hardly moves
        for _ in range(STALE):
            error = part * error
            search = search.learnt(error, 1e-12)
        assert search.going == [goes_on] and search.size == pytest.approx(part**STALE)


def test_the_first_step_takes_the_error_away():
    """In the direction against it, by the inverse slope that is known; where nothing is off nothing moves."""
    inverse = np.array([[2.0, 0.0], [0.0, 0.5]])[:, :, None] * np.ones(2)
    search = Search.begun(np.ones((2, 2)), inverse, np.array([[0.1, 0.0], [-0.2, 0.0]]))
    np.testing.assert_allclose(search.u, [[0.8, 1.0], [1.1, 1.0]])
    assert search.going.tolist() == [True, False]


def test_only_coordinates_of_the_platform_are_found():
    with pytest.raises(ValueError, match="not in tuple"):
        Coordinates(("z", "actuator"), orientation_named(None), 1.0)


def test_without_a_load_there_is_none():
    pose = package_robots.robot("five_bar").assemble(platform={"x": 0.03, "y": 0.3})
    bare, still = ks.compensate(pose), ks.compensate(pose, np.zeros(6), (0, 0, -9.81))
    np.testing.assert_array_equal(bare.deviation, still.deviation)
    np.testing.assert_array_equal(list(bare.actuator_forces.values()), list(still.actuator_forces.values()))
