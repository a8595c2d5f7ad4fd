"""When a result warns of members that buckle: once for each member, from a twentieth of its Euler load on."""

from types import SimpleNamespace

import numpy as np

from kinetostatics.results.warnings import _buckling, _slender


def result(**ratios):
    """Beams of which ``a`` and ``b`` are one member, with the ratio of each to its Euler load."""
    member = {"a": ("a", "b"), "b": ("a", "b")}
    beams = {
        name: SimpleNamespace(name=name, member=member.get(name, (name,)), ends="pinned-pinned", euler_ratio=np.array(ratio))
        for name, ratio in ratios.items()
    }
    return SimpleNamespace(beams=beams)


def test_every_member_is_warned_of_once():
    found = result(a=[0.2, 1.5], b=[0.2, 1.5], c=0.3, d=[np.nan, 0.0])
    assert _buckling(found) == ["the member a, b (pinned-pinned) buckles: its axial force is 150 % of its Euler load"]
    assert _slender(found) == [
        "the axial force of beam c (pinned-pinned) reaches 30 % of its Euler load; linear theory underestimates its deflection"
    ]


def test_from_which_part_of_the_euler_load_on():
    assert [len(_slender(result(c=part))) for part in (0.049, 0.051, 0.999, 1.0)] == [0, 1, 1, 0]
    assert [len(_buckling(result(c=part))) for part in (0.049, 0.999, 1.0, 1.001)] == [0, 0, 1, 1]
