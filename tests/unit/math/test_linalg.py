"""Small dense linear algebra compared with NumPy's, thresholds, and choices that do not depend on rounding."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.math import linalg
from kinetostatics.math.linalg import EQUAL, axis_across, canonical_basis, first_largest, ranked

NOISE = 1e-9


def at_angles(*angles):
    """Return pairs of unit columns (3, 2, N) with these angles between them."""
    angles = np.array(angles)
    first = np.broadcast_to([[1.0], [0], [0]], (3, len(angles)))
    return np.stack([first, np.array([np.cos(angles), np.sin(angles), 0 * angles])], axis=1)


def test_determinant_signs_are_compared_unless_columns_coincide():
    pairs = at_angles(1.0, 1.0, 3e-7, 5e-8)
    swapped = pairs[:, ::-1]
    assert linalg.have_one_sign(pairs, pairs).tolist() == [True] * 4
    assert linalg.have_one_sign(pairs, swapped).tolist() == [False, False, False, True]  # sin² = 9e-14, 2.5e-15


@pytest.mark.parametrize("other", [(0, 1), (1, 0)])
def test_determinant_signs_are_sure_without_small_pivots(other):
    first, second = np.eye(3)[:, :2, None], np.eye(3)[:, list(other), None] * 1.0
    assert linalg.surely_have_one_sign(first, second).item() == (other == (0, 1))
    for cosine, sure in ((1e-7, True), (1e-9, False), (-1e-7, False)):
        turned = np.array([[1.0, 0, 0], [0, cosine, np.sqrt(1 - cosine**2)]]).T[:, :, None]
        for columns in (slice(None), slice(None, None, -1)):
            assert linalg.surely_have_one_sign(first[:, columns], turned[:, columns]).item() == sure


@pytest.mark.parametrize(("pivot", "by_lapack"), [(1e-3, False), (2e-5, False), (5e-6, True), (1e-9, True)])
def test_elimination_uses_lapack_for_small_pivots(monkeypatch, pivot, by_lapack):
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal((4, 4, 3)), rng.standard_normal((4, 2, 3))
    a[0, 0, 1] = pivot * np.max(np.abs(a[0, 1:, 1]))
    wanted = np.moveaxis(np.linalg.solve(np.moveaxis(a, 2, 0), np.moveaxis(b, 2, 0)), 0, 2)
    asked, solve = [], np.linalg.solve
    monkeypatch.setattr(np.linalg, "solve", lambda *given: asked.append(len(given[0])) or solve(*given))
    np.testing.assert_allclose(linalg.solve_by_elimination(a, b), wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())
    assert asked == [1] * by_lapack


@pytest.mark.filterwarnings("error")
def test_elimination_of_poses_beyond_reach_is_silent():
    a = np.stack([np.eye(3), np.full((3, 3), np.nan)], axis=2)
    found = linalg.solve_by_elimination(a, np.ones((3, 2, 2)))
    np.testing.assert_array_equal(np.isfinite(found).all(axis=(0, 1)), [True, False])


@pytest.mark.parametrize("size", [1e-6, 1e-9, 0.0])
def test_step_across_equals_projection_by_singular_values(size):
    """A direction of the other columns that is only rounding has no effect."""
    rng = np.random.default_rng(1)
    for k, m in ((4, 2), (3, 3), (5, 1)):
        basis = np.linalg.qr(rng.standard_normal((6, 6)))[0]
        a = basis[:, : 6 - m] @ rng.standard_normal((6 - m, k))
        a = np.column_stack([a, a[:, 0] + 1e-2 * size * basis[:, -1]])  # dependent but for rounding
        b = basis[:, 6 - m :] @ (np.eye(m) + 0.2 * rng.standard_normal((m, m))) + size * rng.standard_normal((6, m))
        b /= np.linalg.norm(b, axis=0)
        moved = b - linalg.step_across(a[..., None], b[..., None])[..., 0]
        span = np.linalg.svd(a)[0][:, : 6 - m]
        np.testing.assert_allclose(moved, b - span @ (span.T @ b), rtol=0, atol=1e-13 + 30 * size**2)
        assert np.abs(moved - b).max() < 10 * size + 1e-14
        np.testing.assert_allclose(basis[:, : 6 - m].T @ moved, 0, atol=1e-13 + 0.1 * size)


def test_cholesky_solves_inverts_and_bounds_the_smallest_eigenvalue():
    rng = np.random.default_rng(2)
    half = rng.standard_normal((5, 4, 4))
    a = np.moveaxis(half @ half.swapaxes(1, 2) + 0.1 * np.eye(4), 0, 2)
    factor, values = linalg.Cholesky(a), np.linalg.eigvalsh(np.moveaxis(a, 2, 0))
    bound = factor.smallest_eigenvalue()
    assert np.all(bound <= values[:, 0] * (1 + 1e-12)) and np.all(bound >= values[:, 0] / 4 * (1 - 1e-12))
    np.testing.assert_allclose(factor.inverse(), np.moveaxis(np.linalg.inv(np.moveaxis(a, 2, 0)), 0, 2), rtol=1e-9)
    for limit in (0.5, 0.9, 1.1, 4.5):  # the bound decides where the determinant does not
        sure = linalg.definite(a, limit)
        assert not np.any(sure & (values[:, 0] <= limit)) and np.all(sure | (values[:, 0] <= 4 * limit))
    b = rng.standard_normal((4, 2, 5))
    np.testing.assert_allclose(linalg.matmul(a, factor.solve(b)), b, atol=1e-12)
    assert linalg.Cholesky(half[:, :, 0].T[:, None] * half[:, :, 0].T).smallest_eigenvalue().max() < 1e-12  # of rank one
    diagonal = np.einsum("ii...->i...", a)
    pivots = np.array([np.linalg.cholesky(a[..., k]).diagonal() ** 2 for k in range(5)]).T
    np.testing.assert_allclose(factor.smallest_pivot, (pivots / diagonal).min(axis=0))
    assert linalg.Cholesky(-a).smallest_pivot.tolist() == [-np.inf] * 5 and not linalg.Cholesky(-a).smallest_eigenvalue().any()


def test_least_squares_omit_directions_without_influence():
    rng = np.random.default_rng(3)
    a, b = rng.standard_normal((7, 4, 3)), rng.standard_normal((7, 2, 3))
    for k in range(3):
        wanted = np.linalg.lstsq(a[..., k], b[..., k])[0]
        np.testing.assert_allclose(linalg.least_squares(a, b)[..., k], wanted, rtol=0, atol=1e-9)
    a[:, 3] = a[:, 0] - 2 * a[:, 1]
    found = linalg.least_squares(a, b, nullity=1)
    for k in range(3):
        np.testing.assert_allclose(found[..., k], np.linalg.pinv(a[..., k], rcond=1e-8) @ b[..., k], rtol=0, atol=1e-6)


def test_least_squares_with_rod_spins_stay_accurate(monkeypatch):
    """Where a Delta's arm nearly folds upon its rods the columns of its freedoms differ in size by nine orders of magnitude."""
    robot = package_robots.robot("delta")
    systems, least_squares = [], linalg.least_squares

    def seen(a, b, nullity=0):
        x = least_squares(a, b, nullity)
        systems.append((a, b, x))
        return x

    monkeypatch.setattr("kinetostatics.kinematics.solver.least_squares", seen)
    for y in (12.1, 12.0, 11.0):
        robot.assemble(platform={"x": 0.5, "y": y / 43, "z": -0.5})
    assert len(systems) > 20
    for a, b, x in systems:
        assert np.all(np.isfinite(x))
        left = np.abs(np.einsum("ij...,jk...->ik...", a, x) - b).max()
        assert left < 1e-6 * np.abs(b).max() + 1e-12


def test_correlation_has_a_unit_diagonal_except_for_rounding():
    a = np.diag([4.0, 1e-8, 1e-25])
    a[0, 1] = a[1, 0] = 1e-4
    scaled, unit = linalg.correlation(a)
    np.testing.assert_allclose(unit, [0.5, 1e4, 0.5])
    np.testing.assert_allclose(scaled, [[1, 0.5, 0], [0.5, 1, 0], [0, 0, 0]], atol=1e-24)
    for part, own in ((2e-11, True), (0.5e-11, False)):
        assert (linalg.correlation(np.diag([1.0, part**2]))[1][1] > 1.5) == own


def test_null_space_basis_depends_only_on_the_space():
    rng = np.random.default_rng(4)
    matrix = rng.standard_normal((3, 6))
    basis, rank, gap = linalg.null_space(matrix, 1e-5)
    other = linalg.null_space(rng.standard_normal((5, 3)) @ matrix, 1e-5)[0]
    assert rank == 3 and gap == np.inf and basis.shape == (6, 3)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(basis, other, atol=1e-12)
    values = np.array([1.0, 2e-5, 0.5e-5])
    assert linalg.null_space(np.diag(values), 1e-5)[1:] == (2, pytest.approx(4.0))
    assert linalg.null_space(np.zeros((2, 3)), 1e-5)[1] == 0 and linalg.null_space(1e-7 * matrix, 1e-5)[1] == 0


def test_first_of_equal_values_counts_as_the_largest():
    assert first_largest([1.0, 3.0, 3.0 + NOISE, 2.0]) == 1
    assert first_largest([1.0, 3.0, 3.0 * (1 + 2 * EQUAL), 2.0]) == 2
    assert first_largest([0.0, 0.0]) == 0
    assert first_largest([1 - 5e-7, 1.0]) == 0 and first_largest([1 - 2e-6, 1.0]) == 1


def test_ranking_keeps_the_order_of_equal_values():
    assert ranked([1.0, 3.0, 3.0 + NOISE, 5.0, 1.0 + NOISE, 0.0]) == [3, 1, 2, 0, 4, 5]
    assert ranked([]) == [] and ranked([0.0, 0.0]) == [0, 1]
    assert ranked([1.0, 1.0 + 2 * EQUAL]) == [1, 0]
    assert ranked([1 - 5e-7, 1.0, 1 - 2e-6]) == [0, 1, 2] and ranked([0.5e-9, 0.9e-9, 1.0]) == [2, 0, 1]
    assert ranked([1e-17, 3e-17, 1.0, 2e-17]) == [2, 0, 1, 3] and ranked([1e-17, 3e-17]) == [1, 0]


@pytest.mark.parametrize("noise", [0.0, NOISE, -NOISE])
def test_axis_across_does_not_depend_on_rounding(noise):
    assert axis_across([noise, 1, -noise]).tolist() == [1, 0, 0]
    assert axis_across([1, 0, noise]).tolist() == [0, 1, 0]
    assert axis_across([0.6, 0.5, 0.5 + noise]).tolist() == [0, 1, 0]
    several = axis_across(np.array([[1, 0], [noise, noise], [0, 1]]))
    assert several.T.tolist() == [[0, 1, 0], [1, 0, 0]]


@pytest.mark.parametrize("k", range(6))
def test_canonical_basis_depends_only_on_its_space(k):
    random = np.random.default_rng(k)
    basis = np.linalg.qr(random.standard_normal((6, 6)))[0][:, :k]
    turned = basis @ np.linalg.qr(random.standard_normal((k, k)))[0]
    found = canonical_basis(basis)
    assert canonical_basis(turned) == pytest.approx(found, abs=1e-13)
    assert found.T @ found == pytest.approx(np.eye(k), abs=1e-13)
    assert found @ (found.T @ basis) == pytest.approx(basis, abs=1e-13)


@pytest.mark.parametrize(
    "name, softest, stiffest",
    [
        ("gough_stewart", "in every direction of the xy plane", "along (0, 0, 1.000)"),
        ("tripteron", "along (0.577, 0.577, 0.577)", "in every direction across (0.577, 0.577, 0.577)"),
    ],
)
def test_report_gives_a_plane_for_equal_stiffnesses(name, softest, stiffest):
    text = str(ks.analyze(package_robots.robot(name).assemble()).report())
    for word, where in (("softest", softest), ("stiffest", stiffest)):
        (line,) = (line for line in text.splitlines() if f"{word} against a force" in line)
        assert line.endswith(f"/mm {where}") or line.endswith(f"/µm {where}")
