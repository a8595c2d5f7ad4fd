"""Whole random mechanisms with serial limbs, written as files, against finite elements in OpenSees.

Joint types and axes, points, sections, masses, rigid links, loads, cuts and the spelling of universal and spherical joints are
random (``small_robots.random_spec`` and ``write``); those with other limbs are in ``test_random_hybrids.py``. A few by default;

    KINETOSTATICS_RANDOM_ROBOTS=5000 python -m pytest -q tests/properties/test_random_robots.py

tries that many. Every failure found becomes a row of ``KNOWN``.
"""

import os

import finite_elements
import numpy as np
import pinocchio as pin
import pytest
import small_robots as sr
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import kinetostatics as ks

COUNT = int(os.environ.get("KINETOSTATICS_RANDOM_ROBOTS", "2"))

#: Relative: largest difference beside the scatter of finite elements, and largest scatter of a valid reference.
CLOSE, SURE = 1e-8, 2e-7


#: Limbs and seeds of usual robots, and of failures found with larger numbers.
KNOWN = [
    (["RpS", "RpS", "RpS"], 0),
    (["pRU", "pRU", "UpR"], 1),
    (["UpS"] * 6, 2),
    (["rrp"], 3),
    (["pUU", "S", "S", "S"], 12),  # rigid: nothing moves, and finite elements give rounding errors
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("kinds", "seed"), KNOWN)
def test_known_robots_agree_with_finite_elements(kinds, seed):
    assert agrees_with_finite_elements(kinds, seed)


@settings(max_examples=COUNT, deadline=None)
@given(
    st.lists(st.sampled_from(sr.LIMBS), min_size=2, max_size=6).filter(lambda limbs: sum(map(sr.wrenches, limbs)) >= 6),
    st.integers(0, 2**31),
)
def test_random_robots_agree_with_finite_elements(kinds, seed):
    assume(agrees_with_finite_elements(kinds, seed))


def agrees_with_finite_elements(kinds, seed):
    """Compare; return whether a comparison was possible: the robot is neither rigid throughout nor almost singular."""
    rng = np.random.default_rng(seed)
    spec = sr.random_spec(kinds, seed)
    if not spec.beams:
        return False
    file = sr.write_randomly(spec, rng, seed)
    robot = file.robot()
    pose = robot.configuration(pin.neutral(robot.model))
    load, gravity = rng.standard_normal(6) * 50, rng.standard_normal(3) * 5
    try:
        result = ks.analyze(pose, load, gravity)
    except ks.StaticsError:
        answer = finite_elements.solve(spec, file, pose, load, gravity)
        assert answer.gap <= 1e9 or answer.free or answer.unbalanced > 1e-6
        return answer.gap > 1e9
    if np.linalg.cond(scaled(result.compliance, robot.length)) >= 1e10:
        return False
    found = ks.verify(pose, load, gravity)
    if max(found.scatter.values()) < SURE:
        assert max(found.differences.values()) < CLOSE + 5 * max(found.scatter.values()), str(found)
        return True
    answer = finite_elements.solve(spec, file, pose, load, gravity)  # where OpenSees has lost its precision
    if answer.gap <= 1e9:
        return False
    unit = np.repeat([1.0, robot.length], 3)
    softness = max(float(np.linalg.norm(scaled(answer.compliance, robot.length))), 1e-14)  # zero in a rigid robot
    moved = max(float(np.linalg.norm(answer.twist * unit)), 0.1 * softness, 1e-12)
    assert np.linalg.norm((result.twist - answer.twist) * unit) < 100 * CLOSE * moved
    assert np.linalg.norm(scaled(result.compliance - answer.compliance, robot.length)) < 100 * CLOSE * softness
    return True


def scaled(compliance, length):
    unit = np.array([1.0] * 3 + [length] * 3)
    return compliance * np.outer(unit, unit) + 1e-300 * np.eye(6)
