"""Groups of dimensions that are reduced together: the first of equal poses, and poses without a value."""

import numpy as np
import pytest

from kinetostatics.workspace.grid import Axis, cut
from kinetostatics.workspace.reduced import combined, partial, read_groups, result_of

AXES = [Axis("a", "coordinate", np.arange(3.0)), Axis("b", "coordinate", np.arange(4.0))]
NOTHING, INFINITE = np.nan, np.inf


def reduced(text, values, sizes):
    """Return value and place of a field over a and b, combined from blocks of these sizes."""
    (group,) = read_groups({"b": text, "a": text}, AXES)
    result = None
    for block in cut(values.shape, sizes):
        part = partial(group, values[block], {}, ["a", "b"], {"a": block[0].start, "b": block[1].start}, "m")
        result = part if result is None else combined(group, result, part)
    return result_of(group, result), tuple(int(result.places[name]) for name in ("a", "b")) if result.places else ()


@pytest.mark.parametrize("sizes", [(3, 4), (3, 1), (1, 4), (2, 3), (1, 1)])
def test_first_of_equal_poses_is_picked_whatever_the_blocks(sizes):
    values = np.array([[NOTHING, 1.0, 2.0, 7.0], [7.0, NOTHING, 0.0, 7.0], [7.0, 0.0, 0.0, 3.0]])
    assert reduced("argmax", values, sizes) == (7.0, (0, 3))
    assert reduced("argmin", values, sizes) == (0.0, (1, 2))
    assert reduced("mean", values, sizes)[0] == pytest.approx(34 / 10, rel=1e-15)
    assert reduced("count >= 3 m", values, sizes)[0] == 5 and reduced("count<3000mm", values, sizes)[0] == 5


@pytest.mark.parametrize("sizes", [(3, 4), (2, 3), (1, 1)])
def test_infinite_and_missing_values(sizes):
    values = np.full((3, 4), NOTHING)
    for text in ("argmax", "max", "mean"):
        value, place = reduced(text, values, sizes)
        assert np.isnan(value) and place in ((), (-1, -1))
    values[2, 1] = INFINITE
    assert reduced("argmin", values, sizes) == (INFINITE, (2, 1)) == reduced("argmax", values, sizes)
