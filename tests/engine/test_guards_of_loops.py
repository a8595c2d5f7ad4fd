"""Guards of loop records: without them a platform half a turn off or a hinge turned over counts as closed.

Sines vanish at half a turn as at zero. NumPy takes another branch there; the recorded branch finds no error.
"""

import numpy as np
import pytest
from loop_robots import floating, frame
from package_robots import robot as robot_named
from tapes import prescribed_of

from kinetostatics.engine.loops import CompiledSolver
from kinetostatics.engine.scalars import Tape
from kinetostatics.kinematics.coordinates import PrescribedCoordinates


@pytest.fixture(autouse=True)
def own_folder(monkeypatch, tmp_path):
    """Code without guards has the same keys as correct code."""
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path))


def compiled(robot, convention):
    return CompiledSolver(robot.solver, prescribed_of(robot, convention), robot.generic_poses.take(np.array([0])))


def drop_guards(monkeypatch, folder):
    """Make records hold everywhere."""
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(folder))
    monkeypatch.setattr(Tape, "holds", lambda tape: True)


def test_platform_half_a_turn_off_has_not_converged(monkeypatch, tmp_path):
    """The remaining rotation is π about z, whose sine is 0. Such poses, and one that is NaN, lie among others that the same
    instructions correct."""
    robot = robot_named("planar_3rrr")
    solver = compiled(robot, "rotation_vector")
    start = robot.zero_poses.take(np.zeros(9, dtype=np.intp))
    target = np.repeat(robot.solver.values(solver._own, robot.zero_poses), 9, axis=1)
    target[-1] += [0.05, 0.02, np.pi, -0.03, -np.pi, 0.01, 3.1, np.nan, -0.05]
    wanted, good = robot.solver.newton(solver._own, start, target)
    assert good.tolist() == [True, True, False, True, False, True, False, False, True]
    found, reached = solver.newton(solver._own, start, target)
    np.testing.assert_array_equal(reached, good)
    np.testing.assert_allclose(found.x, wanted.x, rtol=0, atol=1e-12)
    for k in range(9):  # and each by itself
        one = solver.in_one_go(solver._own, robot.zero_poses, target[:, k : k + 1])
        assert (one is not None) == good[k]
        if one is not None:
            np.testing.assert_allclose(one.x, wanted.x[:, k : k + 1], rtol=0, atol=1e-12)

    drop_guards(monkeypatch, tmp_path / "dropped")
    heedless = compiled(robot, "rotation_vector")
    found, reached = heedless.newton(heedless._own, start, target)
    assert reached.tolist() == [True, True, True, True, True, True, False, False, True]
    off = robot.solver.values(heedless._own, found) - target
    np.testing.assert_allclose(np.abs(off[-1, [2, 4]]), np.pi)  # though they count as reached


def test_side_of_a_singular_pose_equals_numpy():
    """Random pairs, some of them in doubt, against NumPy's determinants."""
    robot = robot_named("planar_3rrr")
    solver, random = compiled(robot, "rotation_vector"), np.random.default_rng(0)
    start = robot.zero_poses.take(np.zeros(60, dtype=np.intp))
    first, second = start.take(np.arange(60)), start.take(np.arange(60))
    for poses in (first, second):
        moved = random.uniform(-1.5, 1.5, (robot.solver.tree.nv, 60))
        poses.x[:] = robot.solver.tree.integrate(start.x, moved)
    target = np.zeros((solver._own.size, 60))
    wanted = robot.solver.on_one_side(solver._own, first, second, target)
    assert 5 < wanted.sum() < 55 and not np.all(solver._surely(solver._side, first, second)[wanted])
    np.testing.assert_array_equal(solver.on_one_side(solver._own, first, second, target), wanted)
    assert solver.on_one_side(solver._own, first.take(np.arange(0)), second.take(np.arange(0)), target[:, :0]).shape == (0,)
    actuated = robot.solver.on_one_side(robot.actuator_coordinates, first, second, target)
    assert np.any(actuated != wanted)
    np.testing.assert_array_equal(solver.on_one_side(robot.actuator_coordinates, first, second, target), actuated)


def test_hinge_turned_over_is_not_closed(monkeypatch, tmp_path):
    """A platform that floats and is held by one hinge: turned by π about x its axis z lies in the hinge's, but points down."""
    robot = floating("revolute", frame(p=(0.1, 0.2, 0.3)), frame(p=(0.0, 0.1, 0.0)), axis=(0, 0, 1))
    centre = np.array([0.1, 0.2, 0.3])
    x = np.repeat(robot.zero_poses.x, 3, axis=1)
    place = robot.mechanism.platform_pose(robot.solver.equations.forward(x[:, :1]))[1][:, 0]
    turned = centre + np.diag([1.0, -1.0, -1.0]) @ (place - centre)
    first = next(joint.first_q for joint in robot.solver.tree.joints)
    x[first : first + 3, 1] += turned - place
    x[first + 3 : first + 7, 1] = [1.0, 0.0, 0.0, 0.0]  # half a turn about x
    wanted = np.max(np.abs(robot.solver.place(x).residual), axis=0)
    assert wanted[0] < 1e-12 and wanted[1] == pytest.approx(np.pi)
    np.testing.assert_allclose(np.max(np.abs(compiled(robot, None).place(x).residual), axis=0), wanted, atol=1e-12)

    drop_guards(monkeypatch, tmp_path / "dropped")
    heedless = np.max(np.abs(compiled(robot, None).place(x).residual), axis=0)
    assert heedless[1] < 1e-12  # as if it were closed


@pytest.mark.parametrize("given", [2, 1])
def test_in_one_go_succeeds_where_newton_surely_converges(given):
    """From open loops, some across singular poses; with one actuator given the other is a local freedom."""
    robot, random, N = robot_named("five_bar"), np.random.default_rng(0), 300
    prescribed = PrescribedCoordinates(robot.actuator_coordinates.columns[:given], local_dofs=2 - given)
    solver = CompiledSolver(robot.solver, prescribed, robot.generic_poses.take(np.array([0])))
    start = robot.zero_poses.take(np.zeros(N, dtype=np.intp))
    start.x[:] = robot.solver.tree.integrate(start.x, random.uniform(-0.8, 0.8, (4, N)))
    target = robot.solver.values(prescribed, start) + random.uniform(-0.3, 0.3, (given, N))
    found, good = robot.solver.newton(prescribed, start, target)
    sure = good if given == 1 else good & robot.solver.surely_on_one_side(prescribed, start, found)
    assert 10 < sure.sum() < N - 10 and (given == 1 or np.any(good & ~sure))
    for k in range(N):
        one = solver.in_one_go(prescribed, start.take(np.array([k])), target[:, k : k + 1])
        assert (one is not None) == sure[k]
        if one is not None:
            np.testing.assert_allclose(one.x[:, 0], found.x[:, k], rtol=0, atol=1e-10)


@pytest.mark.parametrize("N", [0, 1, 20])
def test_line_starts_equal_numpy(N):
    """Lines from one pose to many, and each from its own pose."""
    robot, random = robot_named("five_bar"), np.random.default_rng(2)
    solver, poses = compiled(robot, None), robot.zero_poses.take(np.zeros(N, dtype=np.intp))
    poses.x[:] += random.uniform(-0.5, 0.5, poses.x.shape)
    target = random.uniform(-7.0, 7.0, (2, N))
    assert solver._start is not None
    for start in (poses, robot.generic_poses.take(np.array([0]))):
        for found, wanted in zip(
            solver.line(solver._own, start, target), robot.solver.line(solver._own, start, target), strict=True
        ):
            np.testing.assert_allclose(found, np.broadcast_to(wanted, (len(wanted), N)), rtol=0, atol=1e-12)
