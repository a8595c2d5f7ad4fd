"""By which coordinates the robot is commanded, and how far they move a tool's tip at first, of maps with known slopes."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics.math.rotations import orientation_named

compensate = importlib.import_module("kinetostatics.compensation.compensate")
LENGTH = 5.0  # of the robot [m]
STEP = 1e-5 * LENGTH


@pytest.fixture
def problem(monkeypatch):
    """Return what makes a problem of the slopes (N, 3, 3) of a tip at three zeros, which bends by 0.2 u², up to a reach."""

    def made(slopes, low=-np.inf, high=np.inf):
        def tip(u, _):
            moved = np.einsum("nij,jn->in", slopes, u) + 0.2 * u**2
            return np.where(np.all((low <= u) & (u <= high), axis=0), moved, np.nan)

        monkeypatch.setattr(compensate, "target_frame", tip)
        found = object.__new__(compensate._Problem)
        names = SimpleNamespace(names=("x", "y", "z"), of=lambda frame, near: frame)
        mobility = SimpleNamespace(platform=3)
        found.robot = SimpleNamespace(length=LENGTH, name="crane", mobility=mobility)
        found.tool, found.target, found.controlled, found.commanded = np.ones(3), None, names, names
        found._target, found._angles, found._commanded = np.zeros((3, len(slopes))), None, lambda u, near: u
        return found._first_inverse(np.zeros((3, len(slopes))))

    return made


def test_slopes_are_differences_on_both_sides_or_on_the_one_in_reach(problem):
    """A central difference of what bends is exact; one of one side is off by half of a step's bend."""
    slopes = np.array([[[2.0, 0.3, 0.0], [0.1, 1.0, -0.4], [0.0, 0.2, 3.0]], 7 * np.eye(3)])
    found = np.moveaxis(problem(slopes), 2, 0)
    np.testing.assert_allclose(found, np.linalg.inv(slopes), rtol=1e-9, atol=1e-11)
    for sign, ends in ((1, {"low": 0.0}), (-1, {"high": 0.0})):
        bent = np.linalg.inv(np.moveaxis(problem(slopes, **ends), 2, 0)) - slopes
        np.testing.assert_allclose(bent, sign * 0.2 * STEP * np.tile(np.eye(3), (2, 1, 1)), atol=1e-10)


def test_singular_slopes_have_no_inverse_beside_regular_ones(problem):
    """The least singular value, as part of the largest, on both sides of 1e-6."""
    sizes = np.array([[1, 1, 1], [1, 1, 1e-5], [1, 1, 1e-8], [1, 1e-3, 5e-7], [1e3, 1e3, 1e-4]], dtype=float)
    found = problem(np.stack([np.diag(row) for row in sizes]))
    assert np.all(np.isfinite(found), axis=(0, 1)).tolist() == [True, True, False, False, False]
    assert np.all(np.isnan(found[..., 2:]))
    with pytest.raises(ks.exceptions.CoordinatesError, match="'crane' cannot set x, y and z of the tool's tip, each by itself"):
        problem(np.stack([np.diag(row) for row in sizes[2:]]))
    assert np.all(np.isnan(problem(np.eye(3)[None], low=1.0)))  # out of reach on both sides: nothing is known


@pytest.mark.parametrize(("least", "turns"), [(0.11, True), (0.09, False)])
def test_azimuth_and_tilt_are_commanded_as_two_turns_unless_one_pose_is_nearly_level(least, turns):
    orientation = orientation_named("tilt_torsion")
    wanted = SimpleNamespace(platform={"tilt": np.arccos([0.9, least])}, orientation=orientation)
    other = ("z", "rx", "ry"), orientation_named("XYZ")
    names = ("z", "azimuth", "tilt")
    assert compensate._well_conditioned(wanted, names) == (other if turns else (names, orientation))
    assert compensate._well_conditioned(wanted, ("z", "tilt")) == (("z", "tilt"), orientation)
