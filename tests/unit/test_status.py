"""Facts of poses: their status is the worst of them, and maps without facts derive them from it."""

import numpy as np
from small_maps import map_of

from kinetostatics.status import FACTS, Status, in_map, status_of


def test_status_is_the_worst_fact_except_at_failed_poses():
    base = np.array([Status.OK, Status.OK, Status.UNREACHABLE, Status.SINGULAR], dtype=np.int8)
    everywhere, nowhere = np.ones(4, dtype=bool), np.zeros(4, dtype=bool)
    known = {name: fact.status for name, fact in FACTS.items() if fact.status is not None}
    for name, status in known.items():
        assert status_of(base, {name: everywhere}).tolist() == [status, status, Status.UNREACHABLE, Status.SINGULAR]
        assert status_of(base, {name: nowhere}).tolist() == base.tolist()
    # of several the last, as in the table
    assert status_of(base, dict.fromkeys(FACTS, everywhere))[0] == list(known.values())[-1]


def test_maps_without_facts_derive_them_from_status():
    ds = map_of({"x": (np.arange(len(Status)), "m")}, status=list(Status))
    for name, fact in FACTS.items():
        expected = [fact.status is not None and status == fact.status for status in Status]
        assert in_map(ds, name).values.tolist() == expected, name
    ds["limit_exceeded"] = ("x", np.ones(len(Status), dtype=np.int8))
    assert in_map(ds, "limit_exceeded").values.tolist() == [True] * len(Status)


def test_a_status_prints_its_name():
    assert str(Status.OK) == f"{Status.OK}" == "OK" and f"{Status.SINGULAR:>9}" == " SINGULAR"
    assert Status.SINGULAR == 3 and int(Status.SINGULAR) == 3
