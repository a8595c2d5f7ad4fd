"""Groups of bodies that rotate alike."""

import numpy as np
import pytest

from kinetostatics.statics.rotation_groups import _orthonormal


@pytest.mark.parametrize(("angle", "count"), [(1.0, 2), (1e-7, 2), (3e-9, 2), (3e-10, 1), (1e-11, 1), (0.0, 1)])
def test_directions_of_slides_span_a_plane_unless_they_are_parallel_but_for_rounding(angle, count):
    axes = np.array([[0.6, 0.0, 0.8], [0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    axes[1] = np.cos(angle) * axes[0] + np.sin(angle) * axes[2]
    found = np.array(_orthonormal(list(axes[:2])))
    assert len(found) == count
    np.testing.assert_allclose(found @ found.T, np.eye(count), atol=1e-15)
    np.testing.assert_allclose(found.T @ (found @ axes[:2].T), axes[:2].T, atol=1e-9)
    assert len(_orthonormal(list(axes))) == 2
