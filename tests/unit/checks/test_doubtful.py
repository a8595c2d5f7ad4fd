"""Counts that hang on the tolerance: said on one side of the threshold, not on the other."""

import pytest
from odd_robots import parsed, written

from kinetostatics.checks.check import robot_facts


def three_hinges_in_a_row(tilt):
    """A rod on three hinges with a common centre, of which the second is tilted, the third by rounding only, and a post."""
    edges = [
        ("one", "R", (0, 0, 0), "base", "first", {"axis": (0.0, 1.0, 0.0)}),
        ("two", "R", (0, 0, 0), "first", "second", {"axis": (tilt, 1.0, 0.0)}),
        ("three", "R", (0, 0, 0), "second", "rod", {"axis": (0.0, 1.0, 5e-6)}),
        ("top", "F", (0, 0, 0.5), "rod", "platform", {}),
        ("foot", "F", (0.3, 0, 0), "base", "post", {}),
        ("head", "F", (0.3, 0, 0.5), "post", "platform", {}),
    ]
    return parsed(written(edges, [("rod", "three", "top", {}), ("post", "foot", "head", {})], {"head"}, o=(0.1, 0, 0.5)))


@pytest.mark.parametrize(("tilt", "doubtful"), [(3e-4, True), (3e-3, True), (3e-2, False), (0.3, False)])
def test_a_mobility_that_hangs_on_rounding_is_called_doubtful(tilt, doubtful):
    robot = three_hinges_in_a_row(tilt)
    assert (robot.mobility.gap < 1e4) == doubtful
    assert any("the mobility is doubtful" in warning for warning in robot_facts(robot).warnings) == doubtful
