"""Broyden's search and its first Jacobian, on numbers that are known by hand."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics import compensation
from kinetostatics.compensation import BroydenSearch, ScaledCoordinates, _broyden_update, arrival_tolerance, error_tolerance
from kinetostatics.math.rotations import orientation_named

LENGTH = 5.0  # of the robot [m]
STEP = 1e-5 * LENGTH


def test_tolerances_grow_with_robots_above_a_metre():
    assert [error_tolerance(length) for length in (0.2, 1.0, 5.0)] == pytest.approx([1e-12, 1e-12, 5e-12], rel=1e-9, abs=0)
    robots = [SimpleNamespace(length=length, closing_error=error) for length, error in ((0.2, 0.0), (5.0, 0.0), (0.2, 1e-7))]
    assert [arrival_tolerance(robot) for robot in robots] == pytest.approx([1e-9, 5e-9, 1e-9 + 10 * 0.2 * 1e-7], rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("slope", "used"), [(2.0, True), (0.15, True), (0.05, False), (-0.05, False), (-0.5, True), (np.nan, False)]
)
def test_slopes_are_updated_unless_they_nearly_vanish(slope, used):
    step = np.array([[1e-3]])
    found = _broyden_update(np.ones((1, 1, 1)), step, slope * step, np.array([True]))
    assert found[0, 0, 0] == pytest.approx(1 / slope if used else 1.0)
    assert _broyden_update(np.ones((1, 1, 1)), step, 2 * step, np.array([False]))[0, 0, 0] == 1.0


@pytest.mark.parametrize(
    ("errors", "continues"),
    [
        ([0.45, 0.2, 0.09, 0.04, 0.018], True),  # each less than half of the one before
        ([0.55, 0.3, 0.16, 0.09], False),
        ([0.9, 0.8, 0.7, 0.3, 0.29, 0.28, 0.27], True),  # never four in a row
        ([0.9, 0.8, 0.7, 0.3, 0.29, 0.28, 0.27, 0.26], False),
        ([3e-12, 1.1e-12, 0.9e-12], False),  # within tolerance, and hardly smaller than before
        ([3e-12, 1.1e-12, 0.5e-12], True),
        ([3e-12, 1.1e-15], True),
        ([3e-12, 0.9e-15], False),
        ([np.nan], False),
    ],
)
def test_a_search_continues_while_errors_are_halved(errors, continues):
    """The first error is 1, the tolerance 1e-12, the goal 1e-15; steps are negligible."""
    search = BroydenSearch.started(np.zeros((1, 1)), 1e-9 * np.ones((1, 1, 1)), np.array([[1.0]]))
    for number, error in enumerate(errors):
        assert search.going, number
        search = search.updated(np.array([[error]]), 1e-12)
    assert search.going == [continues]
    np.testing.assert_array_equal(search.size, errors[-1:])


def test_a_search_ends_after_40_steps(monkeypatch):
    calls = []
    monkeypatch.setattr(BroydenSearch, "updated", lambda self, *_: calls.append(1) or self)
    with pytest.raises(ks.StaticsError, match="the sag changes too much from pose to pose, as beside a singular pose"):
        ks.compensate(package_robots.robot("five_bar").assemble(platform={"x": 0.03, "y": 0.3}), [0, -4, 0, 0, 0, 0])
    assert len(calls) == 40


def test_the_first_step_subtracts_the_error():
    inverse = np.array([[2.0, 0.0], [0.0, 0.5]])[:, :, None] * np.ones(2)
    search = BroydenSearch.started(np.ones((2, 2)), inverse, np.array([[0.1, 0.0], [-0.2, 0.0]]))
    np.testing.assert_allclose(search.u, [[0.8, 1.0], [1.1, 1.0]])
    assert search.going.tolist() == [True, False]
    small = [BroydenSearch.started(np.ones((1, 1)), inverse[:1, :1, :1], np.array([[size]])) for size in (9e-16, 2e-15)]
    assert [bool(item.going) for item in small] == [False, True]


def test_coordinates_are_scaled_to_lengths():
    found = ScaledCoordinates(("x", "z", "rx"), orientation_named("XYZ"), LENGTH)
    turn = np.array([[1, 0, 0], [0, np.cos(0.3), -np.sin(0.3)], [0, np.sin(0.3), np.cos(0.3)]])[:, :, None]
    np.testing.assert_allclose(found.of((turn, np.array([[1.0], [2.0], [3.0]]))), [[1.0], [3.0], [1.5]], rtol=1e-12)


@pytest.fixture
def first_inverse(monkeypatch):
    """Return the inverse Jacobian of a tip with slopes (N, 3, 3) at zero and curvature, within limits of its coordinates."""

    def made(slopes, low=-np.inf, high=np.inf):
        def tip(u, _):
            moved = np.einsum("nij,jn->in", slopes, u) + 0.2 * u**2
            return np.where(np.all((low <= u) & (u <= high), axis=0), moved, np.nan)

        monkeypatch.setattr(compensation, "target_frame", tip)
        found = object.__new__(compensation._Problem)
        names = SimpleNamespace(names=("x", "y", "z"), of=lambda frame, near: frame)
        found.robot = SimpleNamespace(length=LENGTH, name="crane", mobility=SimpleNamespace(platform=3))
        found.tool, found.target, found.controlled, found.commanded = np.ones(3), None, names, names
        found._target, found._angles, found._commanded = np.zeros((3, len(slopes))), None, lambda u, near: u
        return found._first_inverse(np.zeros((3, len(slopes))))

    return made


def test_slopes_are_central_or_one_sided_differences(first_inverse):
    slopes = np.array([[[2.0, 0.3, 0.0], [0.1, 1.0, -0.4], [0.0, 0.2, 3.0]], 7 * np.eye(3)])
    found = np.moveaxis(first_inverse(slopes), 2, 0)
    np.testing.assert_allclose(found, np.linalg.inv(slopes), rtol=1e-9, atol=1e-11)
    for sign, ends in ((1, {"low": 0.0}), (-1, {"high": 0.0})):
        bent = np.linalg.inv(np.moveaxis(first_inverse(slopes, **ends), 2, 0)) - slopes
        np.testing.assert_allclose(bent, sign * 0.2 * STEP * np.tile(np.eye(3), (2, 1, 1)), atol=1e-10)


def test_singular_slopes_have_no_inverse(first_inverse):
    """The ratio of the singular values is on both sides of 1e-6."""
    sizes = np.array([[1, 1, 1], [1, 1, 1e-5], [1, 1, 1e-8], [1, 1e-3, 5e-7], [1e3, 1e3, 1e-4]], dtype=float)
    found = first_inverse(np.stack([np.diag(row) for row in sizes]))
    assert np.all(np.isfinite(found), axis=(0, 1)).tolist() == [True, True, False, False, False]
    assert np.all(np.isnan(found[..., 2:]))
    with pytest.raises(ks.exceptions.CoordinatesError, match="'crane' cannot set x, y and z of the tool's tip independently"):
        first_inverse(np.stack([np.diag(row) for row in sizes[2:]]))
    assert np.all(np.isnan(first_inverse(np.eye(3)[None], low=1.0)))  # out of reach on both sides


@pytest.mark.parametrize(("cosine", "is_upright"), [(0.11, True), (0.09, False)])
def test_azimuth_and_tilt_become_rotations_at_upright_poses(cosine, is_upright):
    orientation = orientation_named("tilt_torsion")
    target = SimpleNamespace(platform={"tilt": np.arccos([0.9, cosine])}, orientation=orientation)
    other = ("z", "rx", "ry"), orientation_named("XYZ")
    names = ("z", "azimuth", "tilt")
    assert compensation._well_conditioned(target, names) == (other if is_upright else (names, orientation))
    assert compensation._well_conditioned(target, ("z", "tilt")) == (("z", "tilt"), orientation)
