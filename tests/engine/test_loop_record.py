"""Records of loop closure against NumPy, for every robot of the package."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from tapes import evaluate, prescribed_of

from kinetostatics.engine.loop_record import newton_record, place_record, start_record
from kinetostatics.engine.recorder import Structure
from kinetostatics.kinematics.solver import SHRINKING, SolverState


def beside(robot, prescribed, poses):
    """Return poses with given coordinates a little beside their own, and these coordinates."""
    c = poses.c
    if prescribed.orientation is not None:
        c = prescribed.orientation.coordinates(robot.mechanism.platform_pose(robot.equations.forward(poses.x))[0])
    state = SolverState(np.array(poses.x), np.array(c))
    target = robot.solver.values(prescribed, state) + 0.01
    robot.solver.impose(prescribed, state, target)
    return state, target


#: Every robot by its actuators and by one convention; one of three coordinates, one of six and one of rotations only by both.
CASES = [
    (name, convention)
    for k, name in enumerate(package_robots.NAMES)
    for convention in (None, "rotation_vector", "XYZ")
    if convention != ("rotation_vector", "XYZ")[k % 2] or name in ("3rps", "gough_stewart", "spherical_3rrr")
]


@pytest.mark.few(5)
@pytest.mark.parametrize(("name", "convention"), CASES)
def test_loop_record_equals_numpy_for_package_robots(name, convention):
    robot = package_robots.robot(name)
    prescribed = prescribed_of(robot, convention)
    state, target = beside(robot, prescribed, robot.generic_poses)
    N, example = target.shape[1], state.take(np.array([0]))
    parameters = Structure((robot.solver, prescribed)).values
    _, gradient = robot.solver.system(prescribed, state, target)
    condition = np.max(np.linalg.cond(np.moveaxis(gradient, 2, 0))) if gradient.size else 1.0

    record = newton_record(robot.solver, prescribed, example)
    before, shrunk = np.full(N, np.inf), np.full(N, SHRINKING)
    wanted = robot.solver.correct(prescribed, state, target, before, shrunk, np.zeros(N, dtype=bool))
    inputs = [
        np.concatenate([state.x, state.c, [before, shrunk, np.ones(N), np.zeros(N), np.ones(N)]]),
        np.append(target, np.zeros((1, N)), axis=0),
    ]
    found = evaluate(record.tape, inputs, parameters, [*record.numbers, *record.truths]).astype(float)
    numbers = np.concatenate([wanted.poses.x, wanted.poses.c, [wanted.size, wanted.shrunk]])
    assert np.max(np.abs(found[: len(numbers)] - numbers)) < 1e-14 * condition**2
    np.testing.assert_array_equal(found[len(numbers) :], [wanted.going, wanted.done, np.ones(N), wanted.going])

    record = place_record(robot.solver, prescribed, example)
    q, frames, residual = robot.solver.place(state.x)
    found = evaluate(record.tape, [state.x], parameters, [*record.numbers, *record.truths]).astype(float)
    numbers = np.concatenate([q, residual, frames.rotation.reshape(-1, N), frames.position.reshape(-1, N), np.ones((1, N))])
    assert np.max(np.abs(found - numbers)) < 1e-13

    record = start_record(robot.solver, prescribed, example)  # also for turns of more than half a turn
    for turned, shorter in ((0.0, True), (4.0, True), *([(4.0, False)] if prescribed.angles else [])):
        first, c = robot.solver.line(prescribed, state, target + turned, shorter)
        inputs = [state.x, state.c, target + turned, np.full((1, N), float(shorter))]
        found = evaluate(record.tape, inputs, parameters, [*record.numbers, *record.truths]).astype(float)
        assert np.max(np.abs(found - np.concatenate([first, c, np.ones((1, N))]))) < 1e-13


def test_placements_are_parameters_of_loop_records():
    """A record made of one robot holds for another of the same structure: other placements."""
    one, other = (package_robots.robot("3rps", home_length=a) for a in (0.55, 0.6))
    prescribed = prescribed_of(one, "XYZ")
    state, _ = beside(other, prescribed, other.generic_poses)
    record = place_record(one.solver, prescribed, one.generic_poses.take(np.array([0])))
    first, second = (Structure((robot.solver, prescribed)) for robot in (one, other))
    assert first.key == second.key and first.values.shape == second.values.shape
    assert first.key != Structure(one.statics).key
    residual = record.numbers[one.solver.tree.nq :][: one.equations.closures]
    found = evaluate(record.tape, [state.x], second.values, residual).astype(float)
    wrong = evaluate(record.tape, [state.x], first.values, residual).astype(float)
    wanted = other.solver.place(state.x).residual
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-14)
    assert np.max(np.abs(wrong - wanted)) > 1e-3


def test_structure_key_ignores_a_remembered_hash():
    """Prescribed coordinates remember their hash, which differs between processes."""
    robot = package_robots.robot("3rps")
    prescribed = prescribed_of(robot, "XYZ")
    plain = Structure((robot.solver, replace(prescribed))).key
    assert hash(prescribed) and Structure((robot.solver, prescribed)).key == plain
