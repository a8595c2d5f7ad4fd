"""Which steps between poses of a map are too large for one assembly mode, and where ways to other poses start."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.workspace.assembly_modes.continuity import JointScale, suspect_edges
from kinetostatics.workspace.assembly_modes.repair import _Look
from kinetostatics.workspace.schema import NO_MODE, ZERO_MODE

pytestmark = pytest.mark.smoke


def steps(*sizes):
    """Poses on a line whose one angle grows by these steps."""
    q = np.cumsum([0.0, *sizes])[:, None]
    return suspect_edges(q, np.ones(len(q), dtype=bool), JointScale(np.ones(1), np.array([True]))).first.tolist()


def test_steps_that_are_too_large():
    assert steps(1e-2, 1.1e-2, 1e-2, 1.1e-2) == []
    assert steps(1e-2, 1e-2, 1.0, 1e-2, 1e-2) == [2]
    assert steps(1e-9, 1e-9, 9e-7, 1e-9, 1e-9) == [] and steps(1e-9, 1e-9, 2e-6, 1e-9, 1e-9) == [2]  # all but the same
    assert steps(1e-2, 1e-2, 1e-2, 3e-2) == [3] and steps(3e-2, 1e-2, 1e-2, 1e-2) == [0]  # at an end, with one neighbour
    # how much more than half of the smaller neighbour, and a fifth of the usual
    assert steps(1e-2, 1e-2, 1.65e-2, 1e-2, 1e-2) == [] and steps(1e-2, 1e-2, 1.75e-2, 1e-2, 1e-2) == [2]


@pytest.mark.parametrize(("size", "suspect"), [(0.039, False), (0.041, True)])
def test_a_step_without_neighbours_may_be_four_times_the_usual(size, suspect):
    lower = 0.01 * np.arange(5.0)
    q = np.stack([lower, lower + np.array([0.01, 0.01, size, 0.01, 0.01])])[:, :, None]
    found = suspect_edges(q, np.ones((2, 5), dtype=bool), JointScale(np.ones(1), np.array([True])))
    assert ((2, 7) in zip(found.first, found.second, strict=True)) == suspect


def test_half_turns_are_short():
    q = np.array([3.12, 3.13, 3.14, -3.1331853, -3.1231853, -3.1131853])[:, None]
    for row in (q, -q):
        assert len(suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([True])))) == 0
        assert 2 in suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([False]))).first


@pytest.mark.parametrize(("tilt", "known"), [(0.0, False), (0.5e-9, False), (2e-9, True), (0.2, True)])
def test_an_untilted_start_has_no_azimuth(tilt, known):
    """Ways from there to tilted poses keep to the azimuth of their ends: that of the start is rounding."""
    start = SimpleNamespace(platform_coordinates=lambda orientation: {"azimuth": 1.5, "tilt": tilt, "torsion": 0.0})
    machine = SimpleNamespace(zero_poses=None, model_q=lambda poses: np.zeros((3, 1)), configuration=lambda *_, **__: start)
    spec = SimpleNamespace(
        kind="platform",
        orientation="tilt_torsion",
        robot=lambda combination: machine,
    )
    labels = SimpleNamespace(q=[("q", "rad")] * 3, loose=[False] * 3)
    found = _Look(spec, labels, None, None, np.zeros((2, 3)), np.ones(2, dtype=bool), 1.0).zero_coordinates()
    assert found == {"tilt": tilt, "torsion": 0.0} | ({"azimuth": 1.5} if known else {})


def test_what_was_tried_in_vain_is_tried_again_from_what_has_been_reached_since():
    """A square of poses: 1 has been reached from 0, so 3, which 2 did not reach, is tried from 1."""
    look = SimpleNamespace(shape=(2, 2), mode=np.array([ZERO_MODE, ZERO_MODE, ZERO_MODE, NO_MODE], dtype=np.int8))
    look.retracted, look._tried = np.zeros(4, dtype=bool), {ZERO_MODE: np.zeros((4, 4), dtype=bool)}
    look._tried[ZERO_MODE][2, 3] = True
    for source, found in ((0, [3]), (-1, [])):
        look._source = np.array([-1, source, -1, -1])
        targets, starts, ways = _Look._ring(look, ZERO_MODE)
        assert targets.tolist() == found and starts.tolist() == [1][: len(found)] and ways.tolist() == [0][: len(found)]


def test_poses_that_random_starts_reach_are_kept_as_starts_for_others(monkeypatch):
    """Pose 3 is tried from pose 2, in vain, and poses out of reach from random starts, of which the second arrives."""
    monkeypatch.setattr(
        "kinetostatics.workspace.assembly_modes.repair.open_starts", lambda robot, units, count: np.zeros((count, 1))
    )
    look = SimpleNamespace(mode=np.array([ZERO_MODE] * 3 + [NO_MODE] * 2), q=np.zeros((5, 1)), robot=None, units=["rad"])
    look._ring, look._tried = lambda mode: tuple(map(np.array, ([3], [2], [0]))), {ZERO_MODE: np.zeros((2, 5), dtype=bool)}
    look._padded, look.at, look.set, asked = lambda starts: starts, lambda which: which, lambda *_: None, []

    def follow(starts, at, to):
        asked.extend(to)
        return 10.0 * np.arange(len(to))[:, None], np.arange(len(to)) == 2

    look.follow = follow
    assert not _Look.try_some(look) and asked[0] == 3
    assert look._seeds.tolist() == [asked[2]] and look._seed_q.tolist() == [[20.0]]
