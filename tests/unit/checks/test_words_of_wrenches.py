"""Wrenches of self-stresses in words, and how their space is divided into independent parts."""

import numpy as np
import pytest

from kinetostatics.checks.local_freedoms import eliminated, groups_of
from kinetostatics.checks.redundancy import describe_wrenches

FX, FY, FZ, MX, MY, MZ = np.eye(6)


def tilted(angle, first=0, second=2):
    """A force or couple along one axis, tilted towards another."""
    return np.cos(angle) * np.eye(6)[first] + np.sin(angle) * np.eye(6)[second]


@pytest.mark.parametrize(
    ("wrenches", "words"),
    [
        ([FX], ("a force along x",)), ([FX, FZ], ("forces along x and z",)), ([FX, FY, FZ], ("forces in all directions",)),
        ([MY], ("a couple about y",)), ([MX, MY, MZ, FZ], ("a force along z", "couples in all directions")),
        ([tilted(0.6)], ("a force along (0.8253, 0, 0.5646)",)), ([-tilted(0.6)], ("a force along (0.8253, 0, 0.5646)",)),
        ([tilted(-0.6, 3, 5)], ("a couple about (0.8253, 0, -0.5646)",)),
        ([tilted(0.6), FY], ("forces across (0.5646, 0, -0.8253)",)),
        ([tilted(0.6), tilted(0.6 + np.pi / 2), FY], ("forces in all directions",)),
        ([tilted(3e-5)], ("a force along x",)), ([tilted(1e-3)], ("a force along (1, 0, 0.001)",)),
        ([tilted(0.6), MY], ("a force along (0.8253, 0, 0.5646)", "a couple about y")),
        ([tilted(0.6), tilted(0.2, 3, 4)], ("a force along (0.8253, 0, 0.5646)", "a couple about (0.9801, 0.1987, 0)")),
    ],
)  # fmt: skip
def test_directions_of_forces_and_couples_in_words(wrenches, words):
    """World axes by name up to 1e-4 rad, other directions by components, the first one positive."""
    assert describe_wrenches(np.array(wrenches).T, 0.5) == words


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_forces_through_a_point(sign):
    """The moments of all three about o are those of forces at (0.1, −0.2, 0.3) m; the length is 0.5 m."""
    point = sign * np.array([0.1, -0.2, 0.3]) / 0.5
    wrenches = np.array([[*f, *np.cross(point, f)] for f in np.eye(3)]).T
    basis, _ = np.linalg.qr(wrenches)
    words = "(0.1, -0.2, 0.3)" if sign > 0 else "(-0.1, 0.2, -0.3)"
    assert describe_wrenches(basis, 0.5) == (f"forces through o + {words} m",)
    apart = wrenches.copy()
    apart[3, 0] += 1e-3  # no common point
    assert "through" not in describe_wrenches(np.linalg.qr(apart)[0], 0.5)[0]


def test_elimination_finds_parts_without_common_rows():
    """Mixed combinations of two independent parts become a basis of each part."""
    rng = np.random.default_rng(0)
    parts = np.zeros((7, 3))
    parts[:4, :2], parts[4:, 2] = rng.uniform(-1, 1, (4, 2)), rng.uniform(-1, 1, 3)
    mixed = parts @ np.linalg.qr(rng.standard_normal((3, 3)))[0]
    reduced = mixed @ eliminated(mixed)
    assert np.linalg.matrix_rank(reduced, 1e-9) == reduced.shape[1] == 3
    loaded = np.abs(reduced) > 1e-9
    assert sorted(map(len, groups_of(loaded.T))) == [1, 2]
    assert sorted((bool(column[:4].any()), bool(column[4:].any())) for column in loaded.T) == [
        (False, True),
        (True, False),
        (True, False),
    ]
    dependent = np.column_stack([mixed, mixed[:, 0] + 1e-9 * mixed[:, 1]])
    assert (dependent @ eliminated(dependent)).shape[1] == 3
    assert eliminated(np.zeros((4, 2))).shape[1] == 0 and eliminated(np.zeros((0, 2))).shape[1] == 0
