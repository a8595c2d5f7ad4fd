"""Motions through waypoints: continuity and rest at the ends, the least jerk, times of trapezoids."""

import time
import tracemalloc

import numpy as np
import pytest

from kinetostatics.dynamics.trajectory import minimum_jerk, trapezoid_times, trapezoids

TIMES = np.array([0.5, 0.9, 2.0, 2.3, 3.1])
POINTS = np.random.default_rng(1).normal(size=(2, 5))


def test_minimum_jerk_of_two_points_is_the_known_polynomial():
    tau = np.linspace(0, 1, 11)
    x, v, a = minimum_jerk(np.array([0.0, 2.0]), np.array([[1.0, 4.0]]), 2 * tau)
    assert x[0] == pytest.approx(1 + 3 * (10 * tau**3 - 15 * tau**4 + 6 * tau**5), abs=1e-12)
    assert v[0] == pytest.approx(3 * (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / 2, abs=1e-12)
    assert a[0] == pytest.approx(3 * (60 * tau - 180 * tau**2 + 120 * tau**3) / 4, abs=1e-12)


def test_splines_pass_their_points_and_rest_at_both_ends():
    x, v, a = minimum_jerk(TIMES, POINTS, TIMES)
    assert x == pytest.approx(POINTS, abs=1e-12)
    assert v[:, [0, -1]] == pytest.approx(0, abs=1e-12) and a[:, [0, -1]] == pytest.approx(0, abs=1e-11)
    step = 1e-5
    at = np.linspace(0.6, 3.0, 50)
    (before, *_), (there, v, a), (after, *_) = (minimum_jerk(TIMES, POINTS, at + shift) for shift in (-step, 0, step))
    assert v == pytest.approx((after - before) / (2 * step), rel=1e-6, abs=1e-6)
    assert a == pytest.approx((after - 2 * there + before) / step**2, rel=1e-3, abs=1e-3)


def test_many_points_take_linear_time_and_memory():
    """A sine through 20,000 points at 1 ms: velocities and accelerations away from the ends, where the motion must rest."""
    t = np.arange(20_000) * 1e-3
    tracemalloc.start()
    start = time.process_time()
    x, v, a = minimum_jerk(t, np.sin(t)[None], t)
    seconds, (_, peak) = time.process_time() - start, tracemalloc.get_traced_memory()
    tracemalloc.stop()
    inner = slice(50, -50)
    assert x[0] == pytest.approx(np.sin(t), abs=1e-12)
    assert v[0, inner] == pytest.approx(np.cos(t[inner]), abs=1e-9)
    assert a[0, inner] == pytest.approx(-np.sin(t[inner]), abs=1e-6)
    assert peak < 60e6 and seconds < 30  # dense matrices would take 19 GB


def test_splines_do_not_depend_on_the_unit_of_time():
    one = minimum_jerk(TIMES, POINTS, TIMES)
    scaled = minimum_jerk(1e-4 * TIMES, POINTS, 1e-4 * TIMES)
    for order in range(3):
        assert scaled[order] * 1e-4**order == pytest.approx(one[order], rel=1e-9, abs=1e-9)


def test_no_other_motion_through_the_points_has_less_jerk():
    """The first variation of ∫ jerk² vanishes for every smooth change that keeps the points and the rest at the ends."""
    at, step = np.linspace(TIMES[0], TIMES[-1], 20_001, retstep=True)
    jerk = np.gradient(minimum_jerk(TIMES, POINTS[:1], at)[2][0], step, edge_order=2)
    keeps = np.polynomial.Polynomial.fromroots([*TIMES, *TIMES[[0, -1]], *TIMES[[0, -1]]])
    for power in range(3):
        change = (keeps * np.polynomial.Polynomial([0] * power + [1])).deriv(3)(at)
        assert abs(np.trapezoid(jerk * change, at)) < 1e-5 * np.trapezoid(np.abs(jerk * change), at)


def test_trapezoids_take_the_known_times_and_keep_their_limits():
    """A distance d takes d/v + v/a; if the speed is not reached 2 √(d/a); the slowest coordinate decides."""
    points, speed, acceleration = np.array([[0.0, 3.0, 3.0], [0.0, 0.3, 0.1]]), np.array([2.0, 1.0]), np.array([4.0, 2.0])
    times, _, _ = trapezoid_times(points, speed, acceleration)
    assert times == pytest.approx([0, 3 / 2 + 2 / 4, 2 + 2 * np.sqrt(0.2 / 2)], rel=1e-14)
    at = np.linspace(0, times[-1], 4001)
    x, v, a = trapezoids(points, speed, acceleration, at)
    assert trapezoids(points, speed, acceleration, times)[0] == pytest.approx(points, abs=1e-14)
    assert v[:, [0, -1]] == pytest.approx(0, abs=1e-13)
    for k in range(2):
        assert np.abs(v[k]).max() <= speed[k] + 1e-12 and np.abs(a[k]).max() <= acceleration[k] + 1e-12
    assert np.abs(v[0]).max() == pytest.approx(2.0) and np.abs(a[1][at > times[1]]).max() == pytest.approx(2.0)
    moved = np.concatenate([np.zeros((2, 1)), np.cumsum((v[:, 1:] + v[:, :-1]) / 2 * np.diff(at), axis=1)], axis=1)
    assert x - x[:, :1] == pytest.approx(moved, abs=1e-5)
