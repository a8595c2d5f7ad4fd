"""Maps by compiled code are computed in threads: numbers depend neither on how many there are nor on the chunks."""

import sys
import threading

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.math import arrays
from kinetostatics.math.arrays import TURN, in_threads, threads


def test_numbers_depend_neither_on_threads_nor_on_chunks(monkeypatch):
    robot = package_robots.robot("five_bar")
    random = np.random.default_rng(0)
    grid = {name: random.uniform(-1.5, 1.5, 3000) for name in robot.description.actuated}  # some are out of reach
    load = 100 * random.standard_normal((3000, 6))

    def found(number, at_once):
        monkeypatch.setenv("OMP_NUM_THREADS", str(number))
        monkeypatch.setattr(arrays, "AT_ONCE", at_once)
        poses = robot.assemble(actuators=grid, engine="compiled", on_failure="nan")
        result = ks.analyze(poses, load, engine="compiled", on_failure="nan")
        return poses.q, poses.platform_frame, result.twist, result.stiffness, result.status

    alone = found(1, 5500)
    assert len(np.unique(alone[-1])) > 1 and (alone[-1] == 0).sum() > 100
    for number, at_once in ((4, 600), (3, 1000), (1, 700)):
        for one, other in zip(alone, found(number, at_once), strict=True):
            np.testing.assert_array_equal(one, other)


def test_number_of_threads_follows_omp_num_threads(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert threads() == 3
    monkeypatch.setenv("OMP_NUM_THREADS", "many")
    assert threads() >= 1
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    meeting = threading.Barrier(2, timeout=20)
    assert sorted(in_threads(lambda part: meeting.wait(), range(2))) == [0, 1]  # both at a time
    assert in_threads(lambda part: threading.get_ident(), range(2), enabled=False) == 2 * [threading.get_ident()]
    assert in_threads(lambda part: threading.get_ident(), range(2), most=1) == 2 * [threading.get_ident()]
    inner = in_threads(lambda part: (threading.get_ident(), in_threads(lambda _: threading.get_ident(), range(2))), range(2))
    assert all(idents == 2 * [outer] for outer, idents in inner)  # threads start no further ones


def test_threads_shorten_the_switch_interval_and_restore_it(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    usual = sys.getswitchinterval()
    assert in_threads(lambda part: sys.getswitchinterval(), range(2)) == pytest.approx(2 * [TURN])
    with pytest.raises(ZeroDivisionError):
        in_threads(lambda part: 1 / part, range(2))
    assert sys.getswitchinterval() == usual
