"""Inner coordinates of beams in second order."""

import numpy as np

from kinetostatics.elements.turned_forces import EACH, INNER, without_inner


def test_inner_coordinates_are_those_of_least_energy():
    """Of ½ xᵀ K x + ½ (y − y₀)ᵀ (y − y₀), with inner coordinates y in x; also where a pivot is zero, and NaN where singular."""
    rng, S, N = np.random.default_rng(1), 3, 4
    K = 0.05 * rng.standard_normal((9 + INNER, 9 + INNER, N))
    K += np.swapaxes(K, 0, 1)
    strain = 9 + 3 * EACH
    K[strain, strain, 2:] = -1.0
    K[strain, :strain, 3] = K[:strain, strain, 3] = K[strain, strain + 1 :, 3] = K[strain + 1 :, strain, 3] = 0.0
    given = rng.standard_normal((INNER, S, N))
    found = without_inner(K, given)
    assert found.shape == (9, 9 + S, N) and np.isnan(found[..., 3]).all()
    for pose in range(N - 1):
        energy = K[..., pose] + np.diag([0.0] * 9 + [1.0] * INNER)
        outer = rng.standard_normal(9)
        for k in range(S):  # x = (outer, y), with the least energy and no load on y but that of y₀
            y = np.linalg.solve(energy[9:, 9:], given[:, k, pose] - energy[9:, :9] @ outer)
            wanted = energy[:9, :9] @ outer + energy[:9, 9:] @ y
            np.testing.assert_allclose(found[:, :9, pose] @ outer + found[:, 9 + k, pose], wanted, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found[:, :9, pose], found[:, :9, pose].T, rtol=0, atol=1e-13)
