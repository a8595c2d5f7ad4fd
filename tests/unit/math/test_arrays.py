"""Arrays of numbers and of recorded numbers, and threads."""

import threading

import numpy as np
import pytest

from kinetostatics.engine.scalars import Tape
from kinetostatics.math.arrays import in_threads, is_filled


def test_recorded_numbers_count_as_filled_zeros_do_not():
    assert is_filled(np.array([0.0, -0.0, 1e-300, np.nan])).tolist() == [False, False, True, True]
    recorded = Tape().write(("input", 0), 0.0)
    mixed = np.array([[0, 0.0, 2], [1e-300, recorded, recorded * 0.5]], dtype=object)
    assert is_filled(mixed).tolist() == [[False, False, True], [True, True, True]]


@pytest.mark.parametrize(("enabled", "most", "several"), [(True, 3, True), (True, 1, False), (False, 3, False)])
def test_parts_are_computed_in_order_and_in_threads_if_enabled(enabled, most, several):
    """Calls within a thread use no further threads; those within a call without threads may, unless there is one thread only."""

    def inner(part):
        return threading.get_ident()

    def outer(part):
        assert len(set(in_threads(inner, range(4), most=4))) == 1 or not several
        return part, threading.get_ident()

    found = in_threads(outer, range(8), enabled, most)
    assert [part for part, _ in found] == list(range(8))
    assert all((thread != threading.get_ident()) == several for _, thread in found)
    assert in_threads(outer, [], enabled, most) == []
