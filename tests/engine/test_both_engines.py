"""Compiled code against NumPy on every robot of the package and on random ones: numbers, statuses, what is not reached.

Each run has some of them, ``-m slow`` all robots of the package and 120 random ones, 12 of them with limbs of any shape;

    KINETOSTATICS_RANDOM_ROBOTS=300 python -m pytest -m slow tests/engine/test_both_engines.py

tries as many random ones as that.
"""

import os
from dataclasses import replace

import hybrid_robots
import numpy as np
import package_robots
import pytest
import small_robots

import kinetostatics as ks
from kinetostatics.engine.record import arrays_of, sizes_of_applied
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.engine.statics import CompiledStatics
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.statics.springs import solve_with_springs

pytest.importorskip("llvmlite")

COUNT = int(os.environ.get("KINETOSTATICS_RANDOM_ROBOTS", "120"))
#: Closed poses, poses near them, whose loops are a little open, and joints anywhere; one that is not reached comes last.
CLOSED, NEAR, ANYWHERE = 3, 4, 4


@pytest.fixture(autouse=True)
def one_folder(cache):
    """Code is kept for all tests here."""


def random_robot(seed):
    """Return a robot by its number; one of ten has limbs of any shape, elastic joints and mimics."""
    rng = np.random.default_rng(seed)
    if seed % 10 == 9:
        return next(small_hybrids(100 * seed))
    while True:
        kinds = [str(kind) for kind in rng.choice(small_robots.LIMBS, rng.choice([2, 3, 4], p=[0.5, 0.4, 0.1]))]
        spec = small_robots.random_spec(kinds, seed)
        if sum(map(small_robots.wrenches, kinds)) >= 6 and spec.beams:
            return small_robots.robot_of(spec)


def small_hybrids(seed):
    """Yield robots of few joints, which compile quickly."""
    for number in range(seed, seed + 100):
        mechanism = hybrid_robots.random_hybrid(number)
        if len(mechanism.edges) <= 8:
            try:
                yield hybrid_robots.write_randomly(mechanism, number)[1].robot()
            except ks.RobotFileError:  # its platform is welded to its base
                continue


def some_poses(robot, seed):
    """Return frames, loads and gravity of random poses; see ``CLOSED``."""
    rng, tree = np.random.default_rng(seed), robot.solver.tree
    sizes = np.repeat([0.0, 0.05, 1.5, np.nan], [CLOSED, NEAR, ANYWHERE, 1])
    example = robot.generic_poses.take(np.resize(np.arange(3), sizes.size))
    x = tree.integrate(example.x, sizes * rng.standard_normal((tree.nv, sizes.size)))
    return (
        robot.frames_of(SolverState(x, example.c)),
        100 * rng.standard_normal((6, sizes.size)),
        9.81 * rng.standard_normal((3, sizes.size)),
    )


def conditions(solution, length):
    """Return the condition number (N,) of the stiffness of each pose, infinite where it is singular."""
    scale = np.array([1.0] * 3 + [1 / length] * 3)
    K = np.moveaxis(solution.stiffness, 2, 0) * scale * scale[:, None]
    regular = np.all(np.isfinite(K), axis=(1, 2)) & ~solution.singular
    found = np.full(len(K), np.inf)
    found[regular] = np.linalg.cond(K[regular])
    return found


def assert_same(robot, compiled, poses):
    """All arrays of all poses, each to 1e-11 of its largest entry at that pose, and what its condition leaves.

    That is told by the stiffness, and by what NumPy makes of positions that are off by some units of the last place.
    """
    frames, *loads = poses
    reached = np.all(np.isfinite(frames.position), axis=(0, 1))
    wanted = solve_with_springs(robot.statics, *poses)
    off_by = 1 + 1e-15 * np.random.default_rng(5).uniform(-1, 1, frames.position.shape)
    jittered = solve_with_springs(robot.statics, replace(frames, position=frames.position * off_by), *loads)
    # nothing is told of what is not reached
    found, expected, shaken = (
        {path: array[..., reached] for path, array in arrays_of(item).items()}
        for item in (compiled.solve(*poses), wanted, jittered)
    )
    assert list(found) == list(expected) and CLOSED <= reached.sum() < reached.size
    allowed = 1e-11 + 1e-15 * conditions(wanted, robot.length)[reached]
    alike = {".o": robot.length, **sizes_of_applied(expected)}
    for path, array in expected.items():
        if array.dtype == bool:
            np.testing.assert_array_equal(found[path], array, err_msg=path)
        elif array.size and "unbalanced" not in path:  # which is rounding
            np.testing.assert_array_equal(np.isnan(found[path]), np.isnan(array), err_msg=path)
            flat = [np.nan_to_num(item).reshape(-1, item.shape[-1]) for item in (found[path], array, shaken[path])]
            size = np.maximum(np.max(np.abs(flat[1]), axis=0), alike.get(path, 0.0))
            off, rounding = (np.max(np.abs(item - flat[1]), axis=0) / np.where(size > 1e-25, size, 1.0) for item in flat[::2])
            most = allowed + 10 * rounding
            assert np.all(off[np.isfinite(allowed)] <= most[np.isfinite(allowed)]), (path, off, most)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_compiled_statics_of_all_robots(name):
    robot = package_robots.robot(name)
    assert_same(robot, CompiledStatics(robot.statics), some_poses(robot, 1))


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(COUNT))
def test_compiled_statics_of_random_robots(seed):
    """Those that cannot be recorded are NumPy's for both engines."""
    robot = random_robot(seed)
    poses = some_poses(robot, seed)
    try:
        assert_same(robot, CompiledStatics(robot.statics), poses)
    except NotRecordedError:
        pose = robot.assemble()
        found, wanted = (ks.analyze(pose, on_failure="nan", engine=engine) for engine in ("compiled", "numpy"))
        np.testing.assert_array_equal(found.twist, wanted.twist)


def targets(robot, rng, n=24):
    """Return values of all actuators, from near zero to far beyond reach."""
    sizes = np.geomspace(0.01, 3, n)
    types = robot.mechanism.connections
    return {
        name: sizes * rng.standard_normal(n) * (robot.length if types[name].type.is_slide else 1.0)
        for name in robot.description.driven
    }


def assert_same_results(robot, seed):
    rng = np.random.default_rng(seed)
    drives, load = targets(robot, rng), 50 * rng.standard_normal((24, 6))
    poses = [robot.assemble(actuators=drives, on_failure="nan", engine=engine) for engine in ("compiled", "numpy")]
    np.testing.assert_array_equal(*(pose.reached for pose in poses))
    np.testing.assert_allclose(*(pose.q for pose in poses), rtol=0, atol=1e-10)
    found, wanted = (
        ks.analyze(pose, load, on_failure="nan", engine=engine) for pose, engine in zip(poses, ("compiled", "numpy"), strict=True)
    )
    np.testing.assert_array_equal(found.status, wanted.status)
    for name, part in wanted.contributions.items():
        np.testing.assert_array_equal(np.isnan(found.contributions[name]), np.isnan(part), err_msg=name)
    for name in ("limit_exceeded", "indeterminate", "basis_degenerate", "buckles"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    return wanted


@pytest.mark.few(1)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_both_engines_say_the_same_of_poses_near_and_out_of_reach(name):
    assert_same_results(package_robots.robot(name), 3)
