"""How a grid is cut into blocks."""

import numpy as np
import pytest

from kinetostatics.workspace.grid import Axis, block_sizes


@pytest.mark.parametrize(
    ("poses", "sizes"), [(0, (1, 1, 1)), (1, (1, 1, 1)), (3, (1, 1, 3)), (5, (1, 1, 5)), (12, (1, 2, 5)), (99, (1, 4, 5))]
)
def test_blocks_have_about_the_requested_poses_of_one_robot(poses, sizes):
    kinds = (("rod", "parameter", 2), ("x", "coordinate", 4), ("y", "coordinate", 5))
    assert block_sizes([Axis(name, kind, np.arange(float(n))) for name, kind, n in kinds], poses) == sizes
