"""Polynomials between poses: exact for polynomials, whatever the boxes."""

from dataclasses import replace

import numpy as np
import pytest

from kinetostatics.kinematics.chebyshev import Cells


def polynomials(x, y):
    """Of degree 3 in x and 2 in y, as the nodes allow."""
    return np.stack([1 + 2 * x - x**3 + x * y**2, 0 * x + 5, x**2 * y - 3 * y])


def test_polynomials_are_interpolated_exactly():
    """Two of three requested coordinates vary, in 2 by 3 boxes."""
    targets = np.random.default_rng(2).uniform([[-1], [0.7], [3]], [[2], [0.7], [4]], (3, 400))
    cells = Cells.sampling(targets)
    assert cells.varying.tolist() == [0, 2] and cells.targets == 400 and cells.nodes == (6, 6)
    np.testing.assert_allclose(cells.low, targets[[0, 2]].min(axis=1))
    np.testing.assert_allclose(cells.low + cells.size, targets[[0, 2]].max(axis=1))
    count = np.array([2, 3])
    cells = replace(cells, count=count, size=cells.size / count, nodes=(4, 3))
    numbers = cells.number(targets)
    assert set(numbers.tolist()) == set(range(6))
    for box in range(6):
        mine = targets[:, numbers == box]
        nodes = cells.node_targets(box, targets[:, 0])
        assert nodes.shape == (3, 12) and np.all(nodes[1] == 0.7)
        corner = cells.low + cells.size * np.array(np.unravel_index(box, count))
        assert np.all(nodes[[0, 2]].T > corner) and np.all(nodes[[0, 2]].T < corner + cells.size)
        places = cells.local(box, mine)
        np.testing.assert_allclose(places, 2 * (mine[[0, 2]] - corner[:, None]) / cells.size[:, None] - 1, atol=1e-12)
        assert np.abs(places).max() <= 1 + 1e-12
        found = cells.interpolated(polynomials(nodes[0], nodes[2]), places)
        np.testing.assert_allclose(found, polynomials(mine[0], mine[2]), rtol=1e-12, atol=1e-11)


def test_few_or_odd_targets_have_no_boxes():
    line = np.linspace(0, 1, 100)[None]
    assert Cells.sampling(line) is not None and Cells.sampling(line[:, :71]) is None and Cells.sampling(line[:, :72]) is not None
    assert Cells.sampling(np.zeros((1, 100))) is None and Cells.sampling(np.where(line > 0.5, np.nan, line)) is None
    assert Cells.sampling(np.random.default_rng(0).uniform(0, 1, (5, 9000))) is None


@pytest.mark.parametrize(("function", "most"), [(np.exp, 9), (lambda x: 1 / (x + 0.05), 60)])
def test_nodes_are_as_many_as_smoothness_needs(function, most):
    targets = np.linspace(0, 1, 3000)[None]
    cells = Cells.sampling(targets)
    nodes = cells.node_targets(0, targets[:, 0])
    refined = cells.refined(function(nodes))
    assert refined is not None and refined.count[0] * refined.nodes[0] <= most
    worst = 0.0
    for box in range(refined.count[0]):
        mine = targets[:, refined.number(targets) == box]
        values = function(refined.node_targets(box, targets[:, 0]))
        worst = max(worst, np.abs(refined.interpolated(values, refined.local(box, mine)) - function(mine)).max())
    assert worst < 1e-3
    assert cells.refined(np.random.default_rng(1).standard_normal((1, 9))) is None  # noise
