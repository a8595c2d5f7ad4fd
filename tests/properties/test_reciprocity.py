"""Constraint wrenches of random robots, many of them almost special ones, do no work on any passive freedom at displaced poses.

Axes are parallel or meet, or are off by 1e-12 to 4e-9, so that some wrenches are only nearly reciprocal.

    KINETOSTATICS_RANDOM_ROBOTS=1000 python -m pytest -q tests/properties/test_reciprocity.py

tries that many.
"""

import os
from dataclasses import replace

import hybrid_robots as hr
import numpy as np
import pinocchio as pin
import pytest
import small_robots as sr
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import kinetostatics as ks

COUNT = int(os.environ.get("KINETOSTATICS_RANDOM_ROBOTS", "3"))


def nudged(spec, size, rng):
    """Return a spec with its joints moved and turned at random by about ``size`` [m, rad]."""

    def joint(j):
        axis, axis2, centre = (np.asarray(v) + size * rng.standard_normal(3) for v in (j.axis, j.axis2, j.centre))
        return replace(j, axis=tuple(sr.unit(axis)), axis2=tuple(sr.unit(axis2)), centre=tuple(centre))

    return replace(spec, limbs=tuple(replace(limb, joints=tuple(map(joint, limb.joints))) for limb in spec.limbs))


def unit(columns):
    return columns / np.sqrt(np.sum(columns**2, axis=0))


def check(result):
    for solution in result.solutions:
        held = ~solution.singular & ~solution.indeterminate
        for number, item in enumerate(solution.statics):
            if not item.group.is_attached and np.any(item.group.passive):
                check_group(solution, number, item, held & ~item.degenerate)


def check_group(solution, number, item, fine):
    """Assert that unit constraint wrenches, and the total wrenches of a group's limbs, do no work on passive unit twists."""
    group, n_c = item.group, item.J_c.shape[1]
    scale = np.repeat([group.model.length, 1.0], 3).reshape(6, 1, 1, 1)
    geometry = group.geometry(solution.frames, solution.o)
    T = unit(geometry.twists[:, group.passive] / scale)
    signs = group.dof_cut_signs[group.passive]
    each = np.einsum("km,miagn->ikagn", signs, item.cut_wrenches * scale)
    size = np.sqrt(np.max(np.sum((item.cut_wrenches * scale) ** 2, axis=1), axis=0))
    carried = solution.total_cut_wrenches(number) * scale[:, 0]
    weights = group.carried(geometry, solution.weights)[0]
    whole = np.einsum("km,mign->ikgn", signs, carried) + weights * scale
    # limbs whose joints are dependent but for the nudge have the rank of those without it
    over = np.zeros(fine.shape)
    if group.is_serial and n_c and T.shape[1] > 6 - n_c:
        over[fine] = 2 * np.linalg.svd(np.moveaxis(T[..., fine], 2, 0), compute_uv=False)[:, 6 - n_c]
    rounding = 1e-13 if group.is_serial else 1e-11  # of an elimination
    own = np.max(np.abs(np.einsum("ikgn,ikagn->kagn", T, each) / size), axis=(0, 1), initial=0.0)
    left = np.max(np.abs(np.einsum("ikgn,ikgn->kgn", T, whole)), axis=0)
    loads = np.max(np.abs(carried), axis=(0, 1)) + 100 * scale[0, 0]
    assert np.all((own <= rounding + over)[fine]), (group.limbs[0].name, own, over)
    assert np.all((left <= (1e-11 + over) * loads)[fine]), (group.limbs[0].name, left / loads, over)


def displaced(robot, rng):
    """Return poses near the zero pose, or that alone if no other can be reached."""
    zero = robot.configuration(pin.neutral(robot.model))
    actuators = {name: 0.05 * rng.standard_normal(4) for name in robot.description.actuated}
    try:
        return robot.assemble(actuators=actuators, on_failure="nan", closure_tolerance=1e-12)
    except ks.KinetostaticsError:
        return zero


@settings(max_examples=COUNT, deadline=None)
@given(
    st.lists(st.sampled_from(sr.LIMBS), min_size=2, max_size=6).filter(lambda limbs: sum(map(sr.wrenches, limbs)) >= 6),
    st.integers(0, 2**31),
    st.sampled_from([0.0, 1e-12, 1e-11, 1e-10, 1e-9, 4e-9]),
)
def test_wrenches_of_serial_limbs_are_reciprocal(kinds, seed, size):
    assume(serial(kinds, seed, size))


def serial(kinds, seed, size):
    rng = np.random.default_rng(seed)
    spec = nudged(sr.on_a_grid(sr.random_spec(kinds, seed), 0.2), size, rng)
    return is_reciprocal(sr.write(spec, twirl=seed), rng)


#: With passive slides, whose twists scale otherwise with the length than those of hinges.
SLIDING = [(["RpU", "CrS", "RpU"], 1735039634), (["rRRR", "rRRR", "PRRr"], 130572831), (["RPr", "rRRR", "CpU"], 1058758870)]


@pytest.mark.few(1)
@pytest.mark.parametrize(("kinds", "seed"), SLIDING)
def test_ranks_and_wrenches_do_not_depend_on_size(kinds, seed):
    labels = []
    for times in (1.0, 1e-4, 1e3, 1e5):
        groups = sr.robot_of(sr.enlarged(sr.random_spec(kinds, seed), times)).statics.groups
        labels.append([(group.numbers, group.labels, group.attached_labels) for group in groups])
    assert labels[1:] == labels[:1] * 3


@settings(max_examples=COUNT, deadline=None)
@given(st.integers(0, 2**31))
def test_wrenches_of_hybrid_limbs_are_reciprocal(seed):
    assume(is_reciprocal(hr.write_randomly(hr.random_hybrid(seed, 0.0), seed)[1], np.random.default_rng(seed)))


def is_reciprocal(file, rng):
    """Check; return whether the robot can be analyzed."""
    try:
        robot = file.robot()
        result = ks.analyze(displaced(robot, rng), rng.standard_normal(6) * 50, on_failure="nan")
    except ks.KinetostaticsError:
        return False
    check(result)
    return True


@pytest.mark.few(1)
@pytest.mark.parametrize("engine", ["numpy", "compiled"])
def test_nearly_reciprocal_wrench_is_made_exactly_reciprocal(request, engine):
    """Beside limbs 400,000 times stiffer, a power of 4e-9 on one joint would change the twist by 1.2e-6 of it."""
    robot = ks.load_robot(request.config.rootpath / "tests/cases/nearly_reciprocal.urdf")
    pose = robot.assemble(actuators={"l1_j2": -0.0008069485108324282, "l3_j1": 0.05673813151780757})
    verified = ks.verify(pose)
    assert max(verified.differences.values()) < 1e-9
    found = ks.analyze(pose, engine=engine)
    np.testing.assert_allclose(found.twist, verified.result.twist, rtol=1e-9)
    check(found)
