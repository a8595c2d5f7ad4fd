"""Results do not depend on frames, signs of axes, origins, zeros, roots, cuts, names or order of a description."""

import os
from functools import cache

import hybrid_robots as hr
import numpy as np
import pytest
import rewritings
import small_robots as sr
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from places import ROOT
from small_robots import LIMBS, wrenches

import kinetostatics as ks

ROBOTS = sorted(ROOT.glob("robots/*.xacro"), key=lambda path: path.name)
COUNT = int(os.environ.get("KINETOSTATICS_RANDOM_ROBOTS", "1"))
seeds = st.integers(0, 2**31)
NAMES = [path.name.split(".")[0] for path in ROBOTS]
LOAD = (120.0, -80.0, -200.0, 9.0, 14.0, -6.0)
GRAVITY = (0.6, -1.1, -9.5)


@cache
def original(name):
    """Return a robot and actuators' coordinates of its zero pose and some random poses within its limits."""
    robot = ks.load_robot(dict(zip(NAMES, ROBOTS, strict=True))[name])
    return robot, *poses_of(robot)


def poses_of(robot, wanted=4):
    rng = np.random.default_rng(11)
    drives = {}
    for name in robot.description.actuated:
        item = robot.mechanism.connections[name]
        reach = 0.3 * (robot.length if item.type.name == "prismatic" else 1.0)
        low, high = max(item.lower, -reach), min(item.upper, reach)
        drives[name] = rng.uniform(min(low, high), max(low, high), 12)
        drives[name][0] = 0.0
    pose = robot.assemble(actuators=drives, on_failure="nan")
    status = ks.analyze(pose, LOAD, GRAVITY, on_failure="nan").status
    good = np.flatnonzero(np.isin(status, (ks.Status.OK, ks.Status.LIMIT_EXCEEDED, ks.Status.INDETERMINATE)))[:wanted]
    good = good if good.size else np.array([0])
    drives = {name: values[good] for name, values in drives.items()}
    pose = robot.assemble(actuators=drives, on_failure="nan")
    return drives, ks.analyze(pose, LOAD, GRAVITY, on_failure="nan")


def same(found, expected, what, rtol=1e-9, size=0.0):
    size = max(float(np.nanmax(np.abs(expected), initial=0.0)), size)
    np.testing.assert_allclose(found, expected, rtol=0, atol=rtol * size, err_msg=what)


def assert_same(robot, drives, expected, rewritten, rtol=1e-9, ties=True, signs=True):
    """Compare a robot's results with those of another description of it.

    ``ties``: whether the order of the file, which decides between equals in rings, is the same. ``signs``: whether axes point the
    same way, as they do at the same zero pose.
    """
    other = ks.Robot(rewritten.description)
    name_of = {name: rewritten.names.get(name, name) for name in robot.mechanism.connections}
    pose = other.assemble(actuators=rewritten.drives(drives), on_failure="nan")
    found = ks.analyze(pose, LOAD, GRAVITY, on_failure="nan")
    np.testing.assert_array_equal(found.status, expected.status)
    same(pose.platform_frame, expected.configuration.platform_frame, "platform frame", 1e-10)
    for rows in (slice(0, 3), slice(3, 6)):
        same(found.twist[..., rows], expected.twist[..., rows], "twist", rtol, 1e-9 * np.abs(expected.twist).max(initial=0.0))
    same(found.stiffness, expected.stiffness, "stiffness", rtol)
    same(found.base_wrench, expected.base_wrench, "base wrench", rtol)
    for name, force in expected.actuator_forces.items():
        same(found.actuator_forces[name_of[name]] * rewritten.signs.get(name, 1), force, f"force of {name}", rtol, 100.0)
    without_direction = {edge.joint for limb in robot.topology.all_limbs for edge in limb.edges if edge.both_ways}
    for name, wrench in expected.joint_wrenches.items():
        rows = slice(0, 3) if name in rewritten.moved else slice(0, 6)
        mine, theirs = wrench[..., rows], found.joint_wrenches[name_of[name]][..., rows]
        if name in without_direction:
            theirs = theirs * np.where(np.sum(mine * theirs) < 0, -1.0, 1.0)
        same(theirs, mine, f"wrench at {name}", rtol, 100.0)
    partners = {frozenset(edge.joint for edge in limb.edges if edge.joint): limb.name for limb in other.topology.limbs}
    for mine, limb in zip(robot.topology.limbs, expected.limbs.values(), strict=True):
        theirs = found.limbs[partners[frozenset(name_of[edge.joint] for edge in mine.edges if edge.joint)]]
        same(theirs.wrench, limb.wrench, f"wrench of {limb.name}", rtol, 100.0)
        if not ties and not mine.is_serial:
            continue
        assert [rewritten.word(label) for label in limb.labels] == list(theirs.labels), limb.name
        assert [rewritten.word(label) for label in limb.attached_labels] == list(theirs.attached_labels), limb.name
        turned = {what: np.ones(getattr(limb, what).shape[-1]) for what in ("constraint_wrenches", "attached_wrenches")}
        if not signs:
            for what, values in turned.items():
                products = np.nansum(getattr(limb, what) * getattr(theirs, what), axis=-2)
                values[:] = np.where(np.nansum(products, axis=tuple(range(products.ndim - 1))) < 0, -1.0, 1.0)
        (c, a), of_limb = turned.values(), f"of {limb.name}"
        same(theirs.constraint_wrenches * c, limb.constraint_wrenches, f"constraint wrenches {of_limb}", rtol, 1.0)
        same(theirs.attached_wrenches * a, limb.attached_wrenches, f"attached wrenches {of_limb}", rtol, 1.0)
        same(theirs.compliance * np.outer(c, c), limb.compliance, f"compliance {of_limb}", rtol)
        same(theirs.sag * c, limb.sag, f"sag {of_limb}", rtol)
        same(theirs.intensities * c, limb.intensities, f"intensities {of_limb}", rtol, 100.0)
        same(theirs.attached_intensities * a, limb.attached_intensities, f"attached intensities {of_limb}", rtol, 100.0)


REWRITINGS = {
    "turned about axes": lambda robot, seed: rewritings.turned(robot.description, seed, about_axes=True),
    "turned": lambda robot, seed: rewritings.turned(robot.description, seed),
    "slid": lambda robot, seed: rewritings.slid(robot.description, seed),
    "flipped": lambda robot, seed: rewritings.flipped(robot.description, seed),
    "regrown": lambda robot, seed: rewritings.regrown(robot.description, seed),
    "renamed": lambda robot, seed: rewritings.renamed(robot.description, seed),
    "reordered": lambda robot, seed: rewritings.reordered(robot.description, seed),
}


#: Each rewriting for four robots; for each robot one or two rewritings.
PAIRS = [(name, what) for k, name in enumerate(NAMES) for j, what in enumerate(REWRITINGS) if (k + j) % 4 == 0]


@pytest.mark.few(4)
@pytest.mark.parametrize(("name", "what"), PAIRS)
def test_rewritten_package_robot_has_the_same_results(name, what):
    robot, drives, expected = original(name)
    redundant = len(drives) > robot.mobility.platform  # its actuators are not independent
    assert expected.status.size >= (1 if redundant else 3)
    assert_same(robot, drives, expected, REWRITINGS[what](robot, 5), ties=what != "reordered")


@pytest.mark.few(3)
@pytest.mark.parametrize("name", NAMES[::3])
def test_package_robot_with_other_zeros_has_the_same_results(name):
    robot, drives, expected = original(name)
    pose = robot.assemble(actuators={joint: values[-1] for joint, values in drives.items()})
    assert_same(robot, drives, expected, rewritings.with_zeros_at(robot, pose), signs=False)


# ---- random machines -----------------------------------------------------------------------------------------------------


def assert_rewriting_agrees(robot, seed):
    """Compare a random robot with another description of it."""
    assume(not robot.description.actuated or robot.mobility_analysis.fixes_platform(robot.actuator_coordinates))
    drives, expected = poses_of(robot, wanted=2)
    assume(np.any(expected.status != ks.Status.SINGULAR))
    what = list(REWRITINGS)[seed % len(REWRITINGS)]
    assert_same(robot, drives, expected, REWRITINGS[what](robot, seed), rtol=1e-8, ties=what != "reordered")


@settings(max_examples=COUNT, deadline=None)
@given(st.lists(st.sampled_from(LIMBS), min_size=2, max_size=5).filter(lambda kinds: sum(map(wrenches, kinds)) >= 6), seeds)
@example(["rUU", "pUS", "UpU", "UpR", "RRpU"], 2)  # a complement of a canonical wrench turned over with another tree
@example(["RpU", "pRRR", "rUU", "UpU", "UpS"], 100)  # the characteristic length slid along axes
def test_rewritten_random_robot_has_the_same_results(kinds, seed):
    assert_rewriting_agrees(sr.write(sr.random_spec(kinds, seed)).robot(), seed)


@pytest.mark.slow
@settings(max_examples=COUNT, deadline=None)
@given(seeds)
@example(4)
@example(11)
def test_rewritten_random_robot_with_rings_has_the_same_results(seed):
    _, file = hr.write_randomly(hr.random_hybrid(seed), seed)
    assert_rewriting_agrees(file.robot(), seed)
