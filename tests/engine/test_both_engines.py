"""Compiled code against NumPy on every robot of the package and on random ones: numbers, statuses, poses out of reach.

Each run takes some of them, ``-m slow`` all robots of the package and 300 random ones, thirty of each of :data:`KINDS`. Slow
cases are compiled without optimization, which takes a tenth of the time and changes no number;

    KINETOSTATICS_FIRST_ROBOT=1000 python -m pytest -m slow tests/engine/test_both_engines.py

takes the random ones from that number on.
"""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache

import hybrid_robots
import numpy as np
import package_robots
import pytest
import small_robots
from places import ROOT
from tapes import computed

import kinetostatics as ks
from kinetostatics.description import JointStiffness, Spring
from kinetostatics.engine.pose_code import ANALYSIS, PoseCode
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.statics.link_loads import AppliedLoad, wrenches_of
from kinetostatics.statics.loaded_poses import LoadedAttachments, LoadedPoses
from kinetostatics.statics.springs import solve_with_springs

#: Files of tests that also pass with compiled code: loops, assembly modes of maps, degenerate poses.
FILES = ["properties/test_continuation.py", "maps/test_sweep_modes.py", "unit/statics/test_singularity.py"]

COUNT, FIRST = 300, int(os.environ.get("KINETOSTATICS_FIRST_ROBOT", "0"))
#: Kinds of random robots, by the last digit of their number: three serial limbs, springs, loads on links and a payload,
#: a rigid limb with a spring, limbs elastic in their actuators alone, elastic joints, axes along x, y and z with all joints on a
#: coarse grid, so that many poses are singular or degenerate, and limbs of any shape.
KINDS = ("plain",) * 3 + ("springs", "loads", "rigid limb", "drives", "joints", "grid", "hybrid")
#: Numbers of random robots; all but two of each kind are slow.
SEEDS = [
    *range(FIRST, FIRST + 2 * len(KINDS)),
    *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(FIRST + 2 * len(KINDS), FIRST + COUNT)),
]
#: Numbers of closed poses, of poses near them with slightly open loops, of poses with random joint coordinates, and of poses with
#: joints turned by right angles. An unreached pose comes last.
CLOSED, NEAR, ANYWHERE, QUARTERS = 3, 4, 4, 4


@cache
def random_robot(seed):
    """Return a robot by its number; see :data:`KINDS`. Of four serial ones three have as many actuators as freedoms."""
    kind = KINDS[seed % len(KINDS)]
    if kind == "hybrid":
        return next(small_hybrids(100 * seed))
    rng = np.random.default_rng(seed)
    while True:
        limbs = [str(limb) for limb in rng.choice(small_robots.LIMBS, rng.choice([2, 3, 4], p=[0.5, 0.4, 0.1]))]
        spec = small_robots.random_spec(limbs, seed)
        drives = sum(letter.islower() for limb in limbs for letter in limb)
        free = 6 - sum(small_robots.wrenches(limb.upper()) for limb in limbs)
        if sum(map(small_robots.wrenches, limbs)) < 6 or not spec.beams or (drives != free and seed // len(KINDS) % 4 != 3):
            continue
        if kind == "joints":
            mechanism = small_robots.mechanism_of(spec)
            edges = (replace(edge, joint=hybrid_robots.with_springs(edge.joint, rng)) for edge in mechanism.edges)
            return hybrid_robots.write_randomly(replace(mechanism, edges=tuple(edges)), seed)[1].robot()
        try:
            robot = small_robots.robot_of(small_robots.on_a_grid(spec, 0.2) if kind == "grid" else spec)
        except ks.RobotFileError:  # joints of a beam have fallen together
            continue
        description = robot.description
        if kind in ("rigid limb", "drives"):
            links = robot.topology.limbs[0].links if kind == "rigid limb" else {beam.link for beam in description.beams.values()}
            for name, beam in description.beams.items():
                description = description.without_beam(name) if beam.link in links else description
        if kind == "drives":
            for joint in description.actuated:
                description = description.with_part(JointStiffness(joint, drive=float(10 ** rng.uniform(5, 7))))
        for number in range({"springs": 2, "rigid limb": 1}.get(kind, 0)):
            ends = tuple(rng.standard_normal(3)), tuple(0.1 * rng.standard_normal(3))
            pull = dict(free_length=float(rng.choice([0.0, 0.2])), preload=10.0 * number)
            links = description.base, description.platform
            description = description.with_part(Spring(f"spring_{number}", 10 ** rng.uniform(2, 5), *links, *ends, **pull))
        return ks.Robot(description)


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
    """Return coordinates, loads and gravity of random poses; see ``CLOSED``."""
    rng, tree = np.random.default_rng(seed), robot.solver.tree
    sizes = np.repeat([0.0, 0.05, 1.5, np.nan], [CLOSED, NEAR, ANYWHERE, 1])
    example = robot.generic_poses.take(np.resize(np.arange(3), sizes.size))
    x = tree.integrate(example.x, sizes * rng.standard_normal((tree.nv, sizes.size)))
    zero = robot.zero_poses.take(np.zeros(QUARTERS, dtype=int))
    quarters = tree.integrate(zero.x, np.pi / 2 * rng.integers(-1, 2, (tree.nv, QUARTERS)) * (np.arange(QUARTERS) > 0))
    x, N = np.concatenate([quarters, x], axis=1), QUARTERS + sizes.size
    return x, 100 * rng.standard_normal((6, N)), 9.81 * rng.standard_normal((3, N))


def loads_on(robot, rng, N):
    """Return a load at each of two places of limbs, and one that is carried by the platform."""
    places = [place for group in robot.statics.groups for limb in group.limbs for place in limb.attachments]
    some = [*rng.choice(places, min(2, len(places)), replace=False), robot.description.platform]
    return tuple(AppliedLoad(f"load on {place}", {str(place): 50 * rng.standard_normal((6, N))}) for place in some)


def axes_apart(robot, frames, o):
    """Return where (N,) axes of joints at the platform are independent; where loops are open, a universal joint's may not be."""
    fine = np.ones(o.shape[1], dtype=bool)
    for group in robot.statics.groups:
        twists = (group.geometry(frames, o).twists / group.twist_scale[::-1])[:, list(group.basis.carried)]
        if twists.size:
            sizes = np.linalg.svd(np.nan_to_num(np.moveaxis(twists, (0, 1), (-2, -1))), compute_uv=False)
            fine &= np.all(sizes[..., -1] > 1e-6 * sizes[..., 0], axis=0)
    return fine


def conditions(solution, length):
    """Return the condition number (N,) of the stiffness of each pose, infinite where it is singular."""
    scale = np.array([1.0] * 3 + [1 / length] * 3)
    K = np.moveaxis(solution.stiffness, 2, 0) * scale * scale[:, None]
    regular = np.all(np.isfinite(K), axis=(1, 2)) & ~solution.singular
    found = np.full(len(K), np.inf)
    found[regular] = np.linalg.cond(K[regular])
    return found


def assert_same(robot, compiled, poses, applied=()):
    """Compare all outputs where the record holds, to 1e-11 of the largest entry at each pose and an allowance for rounding.

    The allowance follows from the condition number of the stiffness, and from NumPy's results at positions changed by rounding.
    Where the record does not hold, or a limb may be degenerate, NumPy computes.
    """
    x, *loads = poses
    frames, reached = robot.equations.place(x).frames, np.all(np.isfinite(x), axis=0)
    wanted = solve_with_springs(robot.statics, LoadedPoses(frames, *loads, applied=applied))
    rng = np.random.default_rng(5)
    jittered = [
        solve_with_springs(
            robot.statics, LoadedPoses(replace(frames, position=frames.position * off_by), *loads, applied=applied)
        )
        for off_by in 1 + 1e-15 * rng.uniform(-1, 1, (3, *frames.position.shape))
    ]
    solved, holds = computed(compiled, *poses, *wrenches_of(applied))
    settled = holds & ~wanted.doubtful  # NumPy computes doubtful poses
    np.testing.assert_array_equal(solved["singular"][settled], wanted.singular[settled])
    # unreached and singular poses are not compared
    compared = reached & settled & ~wanted.singular & axes_apart(robot, frames, wanted.o)
    assert not (holds & wanted.doubtful & ~solved["doubtful"]).any()
    found = {name: array[..., compared] for name, array in solved.items()}
    expected, *shaken = (
        {name: np.broadcast_to(OF_EQUILIBRIUM[name](robot.statics, item), solved[name].shape)[..., compared] for name in solved}
        for item in (wanted, *jittered)
    )
    assert CLOSED <= reached.sum() < reached.size and not holds[~reached].any()
    allowed = 1e-11 + 1e-15 * conditions(wanted, robot.length)[compared]
    for path, array in expected.items():
        if array.dtype == bool:
            np.testing.assert_array_equal(found[path], array, err_msg=path)
        elif array.size:
            np.testing.assert_array_equal(np.isnan(found[path]), np.isnan(array), err_msg=path)
            flat = [
                np.nan_to_num(item).reshape(-1, item.shape[-1]) for item in (array, found[path], *(some[path] for some in shaken))
            ]
            size = np.max(np.abs(flat[0]), axis=0)
            off, *others = (np.max(np.abs(item - flat[0]), axis=0) / np.where(size > 1e-25, size, 1.0) for item in flat[1:])
            rounding = np.max(others, axis=0)
            most = allowed + 10 * rounding
            assert np.all(off[np.isfinite(allowed)] <= most[np.isfinite(allowed)]), (path, off, most)


@pytest.fixture(autouse=True)
def slow_ones_without_optimization(request, compiling):
    if request.node.get_closest_marker("slow"):
        compiling(0)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", [0, 1, 2, 233, 4, 135, 6, 7, 8, 9])
def test_optimization_changes_no_number(seed, compiling):
    """For a robot of each kind, of those with springs small ones."""
    robot, found = random_robot(seed), []
    for level in (0, 1):
        compiling(level)
        found.append(PoseCode(robot, robot.statics, ANALYSIS).computed(*some_poses(robot, seed)))
    numbers, truths = zip(*found, strict=True)
    assert np.isfinite(numbers[0]).any() and truths[0].any()
    np.testing.assert_array_equal(*numbers)
    np.testing.assert_array_equal(*truths)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_compiled_statics_equals_numpy_for_package_robots(name):
    robot = package_robots.robot(name)
    assert_same(robot, PoseCode(robot, robot.statics, ANALYSIS), some_poses(robot, 1))


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_compiled_statics_equals_numpy_for_random_robots(seed):
    """Robots that cannot be recorded are computed by NumPy with either engine."""
    robot = random_robot(seed)
    poses = some_poses(robot, seed)
    loaded = KINDS[seed % len(KINDS)] == "loads"
    applied = loads_on(robot, np.random.default_rng(seed), poses[1].shape[1]) if loaded else ()
    try:
        assert_same(robot, PoseCode(robot, robot.statics, ANALYSIS, LoadedAttachments.of(applied)), poses, applied)
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
        for name in robot.description.actuated
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
def test_engines_agree_in_and_out_of_reach_for_package_robots(name):
    assert_same_results(package_robots.robot(name), 3)


#: The last one is elastic along an actuator that one limb hardly loads, which rounding took for two elastic directions.
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [*SEEDS, 1016])
def test_engines_agree_in_and_out_of_reach_for_random_robots(seed):
    assert_same_results(random_robot(seed), seed)


@pytest.mark.slow
def test_tests_of_loops_and_degenerate_poses_pass_compiled(cache):
    """Except for tests with the fixture ``by_numpy``, which are valid for NumPy only."""
    files = [f"tests/{name}" for name in FILES]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "slow or not slow", *files]
    environment = {**os.environ, "KINETOSTATICS_ENGINE": "compiled", "KINETOSTATICS_CACHE": str(cache), "CI": "true"}
    environment = {name: value for name, value in environment.items() if not name.startswith("PYTEST")}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    # compiled code was used
    assert len(list(cache.glob("*.code"))) > 50
