"""What counts as closed, and which targets of many poses are followed together."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.kinematics import path_following, zero_pose
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math import arrays


@pytest.mark.parametrize(
    ("gaps", "wrong"),
    [([2e-9, 2e-9], True), ([2e-9, 0.5e-9], False), ([0.1, 0.0, 0.0], False), ([0.1, 0.0, 0.1], True), ([0.5e-9] * 3, False)],
)
def test_one_wrong_frame_opens_several_loops(monkeypatch, gaps, wrong):
    """Of loops that are closed but for rounding none is wrong, and of a single open one any frame could be."""
    moves = [False]
    found = [SimpleNamespace(is_motion_of=lambda mechanism: moves[0])]
    monkeypatch.setattr(zero_pose, "frame_corrections", lambda mechanism, size: found)
    named = {str(k): (gap, 0.0) if k % 2 else (0.0, gap) for k, gap in enumerate(gaps)}
    assert zero_pose.is_one_frame(None, named, 1.0) == wrong
    moves[0] = True
    assert not zero_pose.is_one_frame(None, named, 1.0)
    found.clear()
    assert not zero_pose.is_one_frame(None, named, 1.0)


@pytest.mark.parametrize(("beside", "closed"), [(2e-11, True), (1e-9, False), (1e-5, False)])
def test_how_far_the_loops_of_given_coordinates_may_be_open(beside, closed):
    machine = package_robots.robot("3rps")
    q = np.array(machine.assemble().q)
    q[int(np.argmax(np.abs(q) < 0.9))] += beside  # any joint that is no part of a quaternion
    assert (machine.configuration(q, on_failure="nan").status != ks.Status.UNREACHABLE) == closed
    assert machine.configuration(q, closure_tolerance=1e-3, on_failure="nan").status != ks.Status.UNREACHABLE


@pytest.mark.parametrize("many_starts", [False, True])
@pytest.mark.parametrize("many_origins", [False, True])
def test_every_pose_of_every_chunk_follows_its_own_line(monkeypatch, many_starts, many_origins):
    monkeypatch.setattr(arrays, "AT_ONCE", 4)
    N = 10
    numbers = np.arange(float(N))
    one = slice(0, 1)
    start = SolverState(np.stack([numbers, -numbers]), np.zeros((3, N)))
    if not many_starts:
        start = SolverState(start.x[:, one], start.c[:, one])
    origin = (numbers[None] + 100, numbers[None] + 200)
    if not many_origins:
        origin = (origin[0][:, one], origin[1][:, one])
    seen = []

    def follow(solver, prescribed, mine, target, known):
        seen.append(target.shape[1])
        count = target.shape[1]
        expected = target[0] if many_starts else np.zeros(1)
        np.testing.assert_array_equal(mine.x, [expected, -expected])
        expected = target[0] if many_origins else np.zeros(1)
        np.testing.assert_array_equal(known[0][0], expected + 100)
        np.testing.assert_array_equal(known[1][0], expected + 200)
        return SolverState(np.stack([target[0], 2 * target[0]]), np.ones((3, count))), target[0] > 4, target[0] / 10

    monkeypatch.setattr(path_following, "_follow_chunk", follow)
    poses, arrived, gone = path_following.follow(SimpleNamespace(is_compiled=many_origins), None, start, numbers[None], origin)
    assert len(seen) == 3 and sum(seen) == N and max(seen) <= 4
    np.testing.assert_array_equal(poses.x, [numbers, 2 * numbers])
    np.testing.assert_array_equal(poses.c, np.ones((3, N)))
    assert arrived.tolist() == (numbers > 4).tolist() and gone.tolist() == (numbers / 10).tolist()
