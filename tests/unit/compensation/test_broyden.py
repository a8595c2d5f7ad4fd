"""Broyden's search, step by step, on numbers that are known by hand."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.compensation.broyden import (
    BroydenSearch,
    ScaledCoordinates,
    _broyden_update,
    arrival_tolerance,
    error_tolerance,
)
from kinetostatics.math.rotations import orientation_named


def test_what_counts_as_corrected_grows_with_robots_above_a_metre():
    assert [error_tolerance(length) for length in (0.2, 1.0, 5.0)] == pytest.approx([1e-12, 1e-12, 5e-12], rel=1e-9, abs=0)
    robots = [SimpleNamespace(length=length, closing_error=error) for length, error in ((0.2, 0.0), (5.0, 0.0), (0.2, 1e-7))]
    assert [arrival_tolerance(robot) for robot in robots] == pytest.approx([1e-9, 5e-9, 1e-9 + 10 * 0.2 * 1e-7], rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("gives", "learns"), [(2.0, True), (0.15, True), (0.05, False), (-0.05, False), (-0.5, True), (np.nan, False)]
)
def test_a_slope_is_learnt_unless_it_says_next_to_nothing(gives, learns):
    """One coordinate, a step of a millimetre, and the change of the error that came of it: the inverse slope is their ratio."""
    step = np.array([[1e-3]])
    found = _broyden_update(np.ones((1, 1, 1)), step, gives * step, np.array([True]))
    assert found[0, 0, 0] == pytest.approx(1 / gives if learns else 1.0)
    assert _broyden_update(np.ones((1, 1, 1)), step, 2 * step, np.array([False]))[0, 0, 0] == 1.0


@pytest.mark.parametrize(
    ("errors", "goes_on"),
    [
        ([0.45, 0.2, 0.09, 0.04, 0.018], True),  # each less than half of the one before
        ([0.55, 0.3, 0.16, 0.09], False),
        ([0.9, 0.8, 0.7, 0.3, 0.29, 0.28, 0.27], True),  # never four in a row
        ([0.9, 0.8, 0.7, 0.3, 0.29, 0.28, 0.27, 0.26], False),
        ([3e-12, 1.1e-12, 0.9e-12], False),  # small enough, and hardly smaller than before
        ([3e-12, 1.1e-12, 0.5e-12], True),  # there is more to gain
        ([3e-12, 1.1e-15], True),
        ([3e-12, 0.9e-15], False),
        ([np.nan], False),
    ],
)
def test_a_search_goes_on_as_long_as_errors_are_halved(errors, goes_on):
    """From 1 on; with 1e-12 enough, and 1e-15 as good as it gets."""
    search = BroydenSearch.started(np.zeros((1, 1)), 1e-9 * np.ones((1, 1, 1)), np.array([[1.0]]))  # which hardly moves
    for number, error in enumerate(errors):
        assert search.going, number
        search = search.updated(np.array([[error]]), 1e-12)
    assert search.going == [goes_on]
    np.testing.assert_array_equal(search.size, errors[-1:])


def test_a_search_that_never_ends_is_given_up(monkeypatch):
    calls = []
    monkeypatch.setattr(BroydenSearch, "updated", lambda self, *_: calls.append(1) or self)
    with pytest.raises(ks.StaticsError, match="the sag changes too much from pose to pose, as beside a singular pose"):
        ks.compensate(package_robots.robot("five_bar").assemble(platform={"x": 0.03, "y": 0.3}), [0, -4, 0, 0, 0, 0])
    assert len(calls) == 40


def test_the_first_step_takes_the_error_away():
    """In the direction against it, by the inverse slope that is known; where nothing is off nothing moves."""
    inverse = np.array([[2.0, 0.0], [0.0, 0.5]])[:, :, None] * np.ones(2)
    search = BroydenSearch.started(np.ones((2, 2)), inverse, np.array([[0.1, 0.0], [-0.2, 0.0]]))
    np.testing.assert_allclose(search.u, [[0.8, 1.0], [1.1, 1.0]])
    assert search.going.tolist() == [True, False]
    assert [
        bool(BroydenSearch.started(np.ones((1, 1)), inverse[:1, :1, :1], np.array([[size]])).going) for size in (9e-16, 2e-15)
    ] == [
        0,
        1,
    ]


def test_coordinates_are_lengths():
    """Angles times the robot's length."""
    found = ScaledCoordinates(("x", "z", "rx"), orientation_named("XYZ"), 5.0)
    turn = np.array([[1, 0, 0], [0, np.cos(0.3), -np.sin(0.3)], [0, np.sin(0.3), np.cos(0.3)]])[:, :, None]
    np.testing.assert_allclose(found.of((turn, np.array([[1.0], [2.0], [3.0]]))), [[1.0], [3.0], [1.5]], rtol=1e-12)


def test_only_coordinates_of_the_platform_are_found():
    with pytest.raises(ValueError, match="not in tuple"):
        ScaledCoordinates(("z", "actuator"), orientation_named(None), 1.0)


def test_without_a_load_there_is_none():
    pose = package_robots.robot("five_bar").assemble(platform={"x": 0.03, "y": 0.3})
    bare, still = ks.compensate(pose), ks.compensate(pose, np.zeros(6), (0, 0, -9.81))
    np.testing.assert_array_equal(bare.uncorrected_error, still.uncorrected_error)
    np.testing.assert_array_equal(list(bare.actuator_forces.values()), list(still.actuator_forces.values()))
