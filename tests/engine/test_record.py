"""What is recorded is what NumPy computes, of every robot of the package; where it does not hold the record says so."""

import numpy as np
import package_robots
import pytest
import small_robots
from tapes import RANDOM, differences, evaluated, some_poses

from kinetostatics.engine.record import Place, record_of
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.engine.structure import Structure
from kinetostatics.statics.springs import solve_with_springs as solve


@pytest.mark.few(3)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_all_robots_are_recorded_as_numpy_computes_them(name):
    robot = package_robots.robot(name)
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot.statics), *poses)
    assert np.all(holds)
    worst = differences(found, solve(robot.statics, *poses))
    assert max(worst.values()) < 1e-11, max(worst, key=worst.get)
    assert {".twists", ".compliance", ".stiffness", ".intensities.0", ".statics.0.J_c", ".weights"} <= set(worst)


def test_where_a_limb_is_special_the_record_says_so_and_without_guards_it_would_be_wrong():
    """A limb of the Delta whose canonical wrenches degenerate, and one whose passive joints become dependent."""
    robot = package_robots.robot("linear_delta")
    record = record_of(robot.statics)
    q = np.repeat(robot.assemble().model_q, 3, axis=1)
    q[1, 1] += np.pi / 2
    q[7, 2] += np.pi / 2
    poses = robot.mechanism.forward(q), np.ones((6, 3)), np.ones((3, 3))
    found, holds = evaluated(robot, record, *poses)
    assert holds.tolist() == [True, False, False]
    wanted = solve(robot.statics, *poses)
    assert wanted.basis_degenerate.tolist() == [False, True, False] and wanted.statics[0].doubtful[:, 2].any()
    assert not np.array_equal(found.basis_degenerate, wanted.basis_degenerate)
    alone = [array[..., 0] for array in (found.twists, wanted.twists)]
    np.testing.assert_allclose(*alone, rtol=0, atol=1e-12 * np.max(np.abs(alone)))


@pytest.mark.smoke
def test_sections_and_masses_are_inputs():
    """A record made for one robot holds for another of the same structure."""
    thin, thick = (package_robots.robot("3rps", rod_diameter=d) for d in (0.07, 0.09))
    assert Structure(thin.statics).key == Structure(thick.statics).key
    assert Structure(thin.statics).key != Structure(package_robots.robot("3prs").statics).key
    poses = some_poses(thick)
    found, holds = evaluated(thick, record_of(thin.statics), *poses)
    assert np.all(holds) and max(differences(found, solve(thick.statics, *poses)).values()) < 1e-11
    assert np.max(np.abs(found.twists - solve(thin.statics, *poses).twists)) > 0.1 * np.max(np.abs(found.twists))


def test_rounding_is_no_structure(monkeypatch):
    """Sines are 0 in a base of one radius and 1e-17 in another: that is no other code, and its numbers hold for both."""
    robots = [package_robots.robot("gough_stewart", base_radius=r) for r in (0.327, 0.35)]
    first, *others = (Structure(robot.statics) for robot in robots)
    assert all(other.key == first.key for other in others) and not np.allclose(first.values, others[0].values)
    with monkeypatch.context() as exact:
        exact.setattr("kinetostatics.engine.structure.ROUNDING", 0.0)
        assert len({Structure(robot.statics).key for robot in robots}) > 1
    poses = some_poses(robots[1])
    found, holds = evaluated(robots[1], record_of(robots[0].statics), *poses)
    assert np.all(holds) and max(differences(found, solve(robots[1].statics, *poses)).values()) < 1e-11


def test_what_the_structure_leaves_out_cannot_be_recorded(monkeypatch):
    from kinetostatics.engine import record

    statics = package_robots.robot("3rps").statics
    for broken in (lambda robot, *_: robot.joint_table, lambda robot, *_: float(robot.length)):
        monkeypatch.setattr(record, "by_numpy", broken)
        with pytest.raises(NotRecordedError):
            record_of(statics)


def test_constants_have_no_rows():
    place = Place((2,), False, None, [0.0, 1.0])
    assert place.of(np.zeros((0, 3)), np.zeros((1, 3), bool), 3).tolist() == [[0.0] * 3, [1.0] * 3]


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(len(RANDOM)))
def test_random_robots_are_recorded_as_numpy_computes_them(seed):
    """Where the record holds, to what the condition of the stiffness leaves."""
    robot = small_robots.robot_of(small_robots.random_spec(RANDOM[seed], seed))
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot.statics), *poses)
    assert np.mean(holds) > 0.8
    wanted = solve(robot.statics, *poses)
    np.testing.assert_array_equal(found.singular[holds], wanted.singular[holds])
    here = np.flatnonzero(holds & ~wanted.singular)
    if here.size:
        poses = poses[0].take(here), poses[1][:, here], poses[2][:, here]
        found, _ = evaluated(robot, record_of(robot.statics), *poses)
        wanted = solve(robot.statics, *poses)
        worst = differences(found, wanted)
        scale = np.array([1.0] * 3 + [1 / robot.length] * 3)
        K = np.moveaxis(wanted.stiffness, 2, 0) * scale * scale[:, None]
        assert max(worst.values()) < 1e-11 + 1e-15 * np.max(np.linalg.cond(K)), max(worst, key=worst.get)


def test_what_is_plain_but_for_rounding_belongs_to_the_structure():
    """0, 1 and −1 save operations; a part in 10¹⁴ beside them is rounding, more is a number, and zeros go by the largest."""
    plain = np.array([1.0, 0.0, -1.0, 1 + 5e-15, -1 - 5e-15, 5e-15])
    assert Structure([plain]).values.size == 0 and Structure([1.0, -1.0, 0.0]).values.size == 0
    others = np.array([1 + 2e-14, -1 + 2e-14, 2e-14, 0.5])
    np.testing.assert_array_equal(Structure([others]).values, others)
    np.testing.assert_array_equal(Structure([np.array([1e3, 5e-12])]).values, [1e3])
    np.testing.assert_array_equal(Structure([plain], all_vary=True).values, plain)
