"""Steps between poses of a map that are too large for one assembly mode, and neighbours from which poses are tried."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.workspace.continuity import JointScale, _RegionPoses, suspect_edges


def steps(*sizes):
    """Poses on a line whose one angle grows by these steps."""
    q = np.cumsum([0.0, *sizes])[:, None]
    return suspect_edges(q, np.ones(len(q), dtype=bool), JointScale(np.ones(1), np.array([True]))).first.tolist()


def test_steps_larger_than_their_neighbours_are_suspect():
    assert steps(1e-2, 1.1e-2, 1e-2, 1.1e-2) == []
    assert steps(1e-2, 1e-2, 1.0, 1e-2, 1e-2) == [2]
    assert steps(1e-9, 1e-9, 9e-7, 1e-9, 1e-9) == [] and steps(1e-9, 1e-9, 2e-6, 1e-9, 1e-9) == [2]  # all but the same
    assert steps(1e-2, 1e-2, 1e-2, 3e-2) == [3] and steps(3e-2, 1e-2, 1e-2, 1e-2) == [0]  # at an end, with one neighbour
    # how much more than half of the smaller neighbour, and a fifth of the usual
    assert steps(1e-2, 1e-2, 1.65e-2, 1e-2, 1e-2) == [] and steps(1e-2, 1e-2, 1.75e-2, 1e-2, 1e-2) == [2]


@pytest.mark.parametrize(("size", "suspect"), [(0.039, False), (0.041, True)])
def test_steps_without_neighbours_are_suspect_above_four_times_usual(size, suspect):
    lower = 0.01 * np.arange(5.0)
    q = np.stack([lower, lower + np.array([0.01, 0.01, size, 0.01, 0.01])])[:, :, None]
    found = suspect_edges(q, np.ones((2, 5), dtype=bool), JointScale(np.ones(1), np.array([True])))
    assert ((2, 7) in zip(found.first, found.second, strict=True)) == suspect


def test_steps_across_half_a_turn_are_wrapped():
    q = np.array([3.12, 3.13, 3.14, -3.1331853, -3.1231853, -3.1131853])[:, None]
    for row in (q, -q):
        assert len(suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([True])))) == 0
        assert 2 in suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([False]))).first


@pytest.mark.parametrize(("tilt", "known"), [(0.0, False), (0.5e-9, False), (2e-9, True), (0.2, True)])
def test_an_untilted_start_has_no_azimuth(tilt, known):
    """Ways from there to tilted poses keep to the azimuth of their ends: that of the start is rounding."""
    start = SimpleNamespace(platform_coordinates=lambda orientation: {"azimuth": 1.5, "tilt": tilt, "torsion": 0.0})
    robot = SimpleNamespace(zero_poses=None, model_q=lambda poses: np.zeros((3, 1)), configuration=lambda *_, **__: start)
    front = SimpleNamespace(robot=robot, plan=SimpleNamespace(kind="platform", orientation="tilt_torsion"))
    found = _RegionPoses.zero_coordinates(front)
    assert found == {"tilt": tilt, "torsion": 0.0} | ({"azimuth": 1.5} if known else {})


def beside(number, shape):
    """Yield the neighbours of a pose with the numbers of the ways from there: axis by axis, from below and from above."""
    place = np.array(np.unravel_index(number, shape))
    for axis, way in ((axis, way) for axis in range(len(shape)) for way in (0, 1)):
        other = place.copy()
        other[axis] += 1 if way else -1
        if 0 <= other[axis] < shape[axis]:
            yield 2 * axis + way, int(np.ravel_multi_index(other, shape))


@pytest.mark.parametrize("shape", [(7,), (4, 5), (3, 1, 4)])
@pytest.mark.parametrize("everywhere", [True, False])
def test_neighbours_tried_equal_a_pose_by_pose_search(shape, everywhere):
    """Grids of poses that are reached at random."""
    random, size = np.random.default_rng(1), int(np.prod(shape))
    for _ in range(20):
        front = SimpleNamespace(shape=shape, reached=random.random(size) < 0.5)
        front.retracted, front._source = random.random(size) < 0.2, np.where(random.random(size) < 0.3, 0, -1)
        front._tried = (random.random((2 * len(shape), size)) < 0.3) & (random.random(size) < 0.7)
        wrong = np.unique(random.integers(0, size, 2))
        found = [k for k in range(size) if front.reached[k] and any(other in wrong for _, other in beside(k, shape))]
        assert _RegionPoses._reached_neighbours(front, wrong).tolist() == found

        expected = []
        for k in np.flatnonzero(~front.reached):
            there = {way: other for way, other in beside(k, shape) if front.reached[other]}
            is_between = any({2 * axis, 2 * axis + 1} <= set(there) for axis in range(len(shape)))
            once_more = is_between or (everywhere and (front.retracted[k] or not front._tried[:, k].any()))
            for way, other in there.items():
                again = once_more or (everywhere and front._source[other] >= 0)
                if again and not front._tried[way, k]:
                    expected.append((k, other, way))
                    break
        assert list(zip(*_RegionPoses._next_poses(front, everywhere), strict=True)) == expected
