"""Properties of triangle meshes."""

import numpy as np


def enclosed(vertices, faces):
    """Volume that a closed surface encloses, positive if its faces look outwards; fails if it has a hole."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    np.testing.assert_allclose(area.sum(axis=0), 0, atol=1e-12 * np.abs(area).sum() + 1e-15)
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
