"""Which steps between poses of a map are too large for one assembly mode, and where ways to other poses start."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.workspace.assembly_modes.continuity import JointScale, suspect_edges
from kinetostatics.workspace.assembly_modes.repair import LEAST, PROBES, _Look
from kinetostatics.workspace.schema import NO_MODE, OTHER_MODE, ZERO_MODE

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
    labels = SimpleNamespace(said={"joint_coordinate_unit": ((), ["rad"] * 3)}, loose=[False] * 3)
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


def beside(number, shape):
    """Yield the neighbours of a pose with the numbers of the ways from there: axis by axis, from below and from above."""
    place = np.array(np.unravel_index(number, shape))
    for axis, way in ((axis, way) for axis in range(len(shape)) for way in (0, 1)):
        other = place.copy()
        other[axis] += 1 if way else -1
        if 0 <= other[axis] < shape[axis]:
            yield 2 * axis + way, int(np.ravel_multi_index(other, shape))


@pytest.mark.parametrize("shape", [(7,), (4, 5), (3, 1, 4)])
@pytest.mark.parametrize(("mode", "everywhere"), [(ZERO_MODE, True), (ZERO_MODE, False), (OTHER_MODE, True)])
def test_which_neighbours_are_looked_at(shape, mode, everywhere):
    """Grids of random poses, reached and not, against what is said, pose by pose."""
    random, size = np.random.default_rng(1), int(np.prod(shape))
    for _ in range(20):
        look = SimpleNamespace(shape=shape, mode=random.choice([ZERO_MODE, NO_MODE, OTHER_MODE], size))
        look.retracted, look._source = random.random(size) < 0.2, np.where(random.random(size) < 0.3, 0, -1)
        look._tried = {mode: (random.random((2 * len(shape), size)) < 0.3) & (random.random(size) < 0.7)}
        wrong = np.unique(random.integers(0, size, 2))
        found = [k for k in range(size) if look.mode[k] == ZERO_MODE and any(other in wrong for _, other in beside(k, shape))]
        assert _Look._beside(look, wrong).tolist() == found

        expected = []
        for k in range(size):
            near = dict(beside(k, shape))
            there = {way: other for way, other in near.items() if look.mode[other] == mode}
            is_between = mode == ZERO_MODE and any({2 * axis, 2 * axis + 1} <= set(there) for axis in range(len(shape)))
            is_wanted = look.mode[k] == NO_MODE or (look.mode[k] == OTHER_MODE and mode == ZERO_MODE)
            once_more = is_between or (everywhere and (look.retracted[k] or not look._tried[mode][:, k].any()))
            for way, other in there.items():
                again = once_more or (everywhere and look._source[other] >= 0)
                if is_wanted and again and not look._tried[mode][way, k]:
                    expected.append((k, other, way))
                    break
        assert list(zip(*_Look._ring(look, mode, everywhere), strict=True)) == expected


@pytest.mark.parametrize("kind", ["platform", "actuators"])
@pytest.mark.parametrize(("left", "tried"), [(5, False), (6, True)])
def test_where_much_is_left_other_modes_are_sought_from_random_starts(monkeypatch, kind, left, tried):
    """Of 100 poses, which 5 at most may lack; open starts, of the platform closed ones too, reach every second one."""
    place = "kinetostatics.workspace.assembly_modes.repair."
    monkeypatch.setattr(place + "open_starts", lambda robot, units, count, seed: np.full((count, 1), 1.0))
    monkeypatch.setattr(place + "closed_starts", lambda robot, count, tolerance: np.full((count, 1), tolerance))
    look = SimpleNamespace(
        mode=np.full(100, ZERO_MODE), robot=None, units=["rad"], spec=SimpleNamespace(kind=kind, closure_tolerance=2.0)
    )
    look.mode[100 - left :], look._seeds, look._seed_q = NO_MODE, np.array([0]), np.zeros((1, 1))
    look._padded, look.at, spread = lambda starts: starts, lambda which: which, []

    def put(which, q, mode):
        assert mode == OTHER_MODE and np.all(look.mode[which] == NO_MODE)
        look.mode[which] = mode

    def follow(starts, at, to):
        assert starts.ravel().tolist() == [1.0] * left + [2.0] * (left if kind == "platform" else 0)
        return starts, np.arange(len(starts)) % 2 == 1

    look.set, look.follow, look.spread = put, follow, spread.append
    _Look.try_other_modes(look)
    assert spread == ([OTHER_MODE] if tried else []) and np.any(look.mode == OTHER_MODE) == tried
    look.mode[:], look._seeds = NO_MODE, np.array([7])  # what random starts have reached before is enough
    look.follow = None
    _Look.try_other_modes(look)
    assert np.flatnonzero(look.mode == OTHER_MODE).tolist() == [7]


def test_of_many_poses_beside_reached_ones_some_are_tried_first(monkeypatch):
    """Of 1000 poses as many as is said, evenly, and 32 from random starts, which have places for o of a robot with loose rods."""
    monkeypatch.setattr(
        "kinetostatics.workspace.assembly_modes.repair.open_starts", lambda robot, units, count: np.ones((count, 1))
    )
    every, asked = np.arange(1000), []
    look = SimpleNamespace(mode=np.full(1000, NO_MODE), q=np.zeros((1000, 4)), nq=1, robot=None, units=["rad"])
    look._ring, look._tried = lambda mode: (every, every[::-1], every % 2), {ZERO_MODE: np.zeros((2, 1000), dtype=bool)}
    look._padded, look.at, look.set = lambda starts: _Look._padded(look, starts), lambda which: which, lambda *_: None

    def follow(starts, at, to):
        assert starts[:PROBES].any() == 0 and starts[PROBES:].tolist() == [[1, 0, 0, 0]] * LEAST
        asked.extend(to)
        return starts, np.arange(len(to)) == 0

    look.follow = follow
    assert _Look.try_some(look)
    assert asked[0] == 0 and asked[PROBES - 1] == 999 and set(np.diff(asked[:PROBES])) == {5, 6} and len(asked) == PROBES + LEAST
    assert sorted(zip(*np.nonzero(look._tried[ZERO_MODE]), strict=True)) == sorted((k % 2, k) for k in asked[:PROBES])
