"""Gauges that need no description."""

import numpy as np

from kinetostatics.description.loads import COMPONENTS


def test_components_of_the_twist_are_gauges_along_the_worlds_axes():
    assert list(COMPONENTS) == ["dx", "dy", "dz", "drx", "dry", "drz"]
    for k, gauge in enumerate(COMPONENTS.values()):
        np.testing.assert_array_equal(gauge.direction, np.eye(3)[k % 3])
        assert gauge.kind == ("length" if k < 3 else "angle") and gauge.point is None and gauge.frame == "world"
