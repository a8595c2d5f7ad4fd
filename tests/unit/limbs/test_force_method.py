"""The force method on both sides of its thresholds: rigid directions, small pivots, ranks."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.limbs.compliance import rigid_counts
from kinetostatics.limbs.force_method import distribute, elimination_order, ranks, remainder, suits
from kinetostatics.limbs.statics import _relaxation, _straining
from kinetostatics.math.linalg import null_space


def alike(difference):
    """Return the compliance of two correlated wrenches, with about the eigenvalues ``difference`` and 2."""
    return np.array([[1.0, 1 - difference], [1 - difference, 1.0]])[:, :, None, None]


@pytest.mark.parametrize(("difference", "count"), [(1e-10, 0), (3e-12, 0), (3e-13, 1), (0.0, 1)])
def test_directions_without_compliance_are_rigid(difference, count):
    assert rigid_counts(alike(difference)) == count
    assert rigid_counts(np.diag([5.0, 7e-20])[:, :, None, None]) == 0  # relative to its own direction, whatever its unit
    assert rigid_counts(np.zeros((2, 2, 1, 1))) == 2 and rigid_counts(np.zeros((0, 0, 1, 1))) == 0
    gain, loose = _relaxation(alike(difference), np.eye(2).reshape(2, 1, 2, 1, 1) * np.ones((1, 6, 1, 1, 1)))
    assert np.any(loose) == bool(count)
    assert (np.max(np.abs(gain)) > 10) == (not count)


@pytest.mark.parametrize(("difference", "rigid"), [(0.0, True), (1e-7, False), (0.1, False)])
def test_relaxation_does_not_depend_on_sizes_of_self_stresses(difference, rigid):
    """The gain is a generalized inverse of the Gram matrix; combinations without elastic parts have no strain."""
    sizes = np.array([0.1, 20.0])
    gram = (sizes[:, None] * sizes)[:, :, None, None] * alike(difference)
    gain, loose = _relaxation(gram, np.eye(2).reshape(2, 1, 2, 1, 1) * np.ones((1, 6, 1, 1, 1)))
    G, answer, combinations = alike(difference)[..., 0, 0], gain[..., 0, 0] * sizes * sizes[:, None], loose[:, 0, :, 0, 0]
    np.testing.assert_allclose(G @ answer @ G, G, atol=1e-8)
    np.testing.assert_allclose(gram[..., 0, 0] @ combinations, 0, atol=1e-14)
    assert (np.linalg.norm(answer @ [1.0, -1.0]) < 1e-9) == rigid
    assert np.any(combinations) == rigid


@pytest.mark.parametrize(("part", "strains"), [(1.0, True), (3e-10, True), (3e-11, False), (1e-16, False)])
@pytest.mark.parametrize("force", [1.0, 1e5])
def test_wrenches_that_reach_elastic_parts_by_rounding_strain_nothing(part, strains, force):
    """Two spring-loaded directions of 2e-6 and 3e-6 m/N, of which a wrench reaches the second with a part of its force."""
    elements = [SimpleNamespace(compliance_sum=lambda length, c=c: np.full((1, 1), c)) for c in (2e-6, 3e-6)]
    group = SimpleNamespace(twist_scale=np.ones((6, 1, 1, 1)), model=SimpleNamespace(length=0.5))
    columns = np.zeros((1, 6, 1, 1, 1))
    columns[0, 2] = force
    compliance = np.full((1, 1, 1, 1), 3e-6 * (part * force) ** 2)
    assert _straining(group, SimpleNamespace(elements=elements, centres=np.zeros((3, 1, 1, 1))), columns, compliance) == strains


@pytest.mark.parametrize(("pivot", "doubtful"), [(1e-5, False), (2e-6, False), (5e-7, True), (0.0, True)])
def test_small_pivots_are_doubtful(pivot, doubtful):
    """x + y = −d and pivot · y = −e; the third unknown acts on the platform."""
    P = np.zeros((6, 3))
    P[0, 2] = 4
    generic = np.array([[1.0, 1, 0], [0, 1, 0]])
    plan = elimination_order(generic[:, :, None], P, 1e-6)
    A = np.array([[1.0, 1, 0], [0, pivot, 0]])
    found = distribute(plan, A[:, :, None, None], generic != 0, P, np.array([3.0, 2 * pivot])[:, None, None])
    assert bool(found.doubtful[0, 0]) == doubtful
    np.testing.assert_allclose(found.particular[:, 0, 0], [-1.0, -2, 0] if pivot else [-1.5, -1.5, 0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(P @ found.spread[:, :, 0, 0], np.diag([1.0, 0, 0, 0, 0, 0]), atol=1e-12)


def test_elimination_order_suits_equal_ranks_and_large_pivots():
    P = np.zeros((6, 3))
    P[0, 2] = 1

    def fits(*rows):
        return suits(plan, np.array(rows, dtype=float)[:, :, None], P, 1e-6)

    plan = elimination_order(np.array([[1.0, 1, 0], [0, 1, 0]])[:, :, None], P, 1e-6)
    assert fits([1, 1, 0], [0, 1, 0]) and fits([1, 0, 0], [1, 1, 0])
    assert not fits([1, 1, 0], [1, 1, 0])  # of another rank
    assert not fits([1, 1, 0], [1, 1 + 1e-5, 0])  # of the same, but a small pivot


def test_rank_tolerance_is_relative_to_largest_value_or_one():
    for values, count in (((1e3, 5e-3), 1), ((1e3, 2e-2), 2), ((1e-3, 2e-5), 2), ((1e-3, 5e-6), 1), ((0.0, 0.0), 0)):
        matrix = np.diag(values)
        assert ranks(matrix[:, :, None], np.zeros((6, 2)), 1e-5) == (count, 0)
        assert null_space(matrix, 1e-5)[1] == count


def test_unbalanced_remainder_does_not_depend_on_pivots():
    """x = −d and x = −e together: each keeps half their difference, whichever of the two is solved."""
    A = np.array([[1.0, 0], [1.0, 0]])[:, :, None, None]
    plan = elimination_order(A[..., 0], np.zeros((6, 2)), 1e-6)
    for demand, particular in (((1.0, 2.0), -1.0), ((1.0, 2.0), -2.0), ((3.0, 3.0), -3.0)):
        found = remainder(plan, A, np.array(demand)[:, None, None], np.array([particular, 0.0])[:, None, None])[:, 0, 0]
        np.testing.assert_allclose(found, np.array([1, -1]) * (demand[0] - demand[1]) / 2, atol=1e-12)
