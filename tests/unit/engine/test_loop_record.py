"""What is recorded of the loops is what NumPy computes, of every robot of the package."""

import numpy as np
import package_robots
import pytest
from tapes import evaluate

from kinetostatics.engine.loop_record import loop_record
from kinetostatics.engine.structure import Structure
from kinetostatics.kinematics.coordinate_choices import choices, prescribed_platform
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.linalg import least_squares
from kinetostatics.math.orientation import orientation_named


def prescribed_of(robot, convention):
    """Return the drives or the first coordinates of the platform that determine the pose, and how many freedoms are local."""
    prescribed = robot.actuator_coordinates
    if convention is not None:
        orientation = orientation_named(convention)
        prescribed = prescribed_platform(choices(robot, orientation, (), robot.zero_poses)[0], orientation)
    prescribed = robot.mobility_analysis.without_idle_dofs(prescribed)
    return prescribed, robot.mobility_analysis.local_dofs(prescribed)


def beside(robot, prescribed, poses):
    """Return poses with given coordinates a little beside their own, and these coordinates."""
    c = poses.c
    if prescribed.orientation is not None:
        c = prescribed.orientation.coordinates(robot.mechanism.platform_pose(robot.equations.forward(poses.x))[0])
    state = SolverState(np.array(poses.x), np.array(c))
    target = robot.solver.values(prescribed, state) + 0.01
    robot.solver.impose(prescribed, state, target)
    return state, target


@pytest.mark.parametrize("name", package_robots.NAMES)
@pytest.mark.parametrize("convention", [None, "rotation_vector", "XYZ"])
def test_all_robots_loops_are_recorded_as_numpy_computes_them(name, convention):
    robot = package_robots.robot(name)
    prescribed, local = prescribed_of(robot, convention)
    state, target = beside(robot, prescribed, robot.generic_poses)
    record = loop_record(robot.solver, prescribed, state.take(np.array([0])), local)
    residual, gradient = robot.solver.system(prescribed, state, target)
    step = -least_squares(gradient, residual[:, None], local)[:, 0]
    moved = robot.solver.advance(prescribed, state, step)
    frames = robot.frames_of(state)
    wanted = {
        **{"residual": residual, "gradient": gradient, "step": step, "x": moved.x, "c": moved.c},
        **{"q": robot.model_q(state), "rotation": frames.rotation, "position": frames.position},
    }
    inputs = [state.x, state.c, target]
    guards = evaluate(record.tape, inputs, record.parameters, list(record.tape.guards))
    assert all(np.all(found == said) for found, said in zip(guards, record.tape.guards.values(), strict=True))
    condition = np.max(np.linalg.cond(np.moveaxis(gradient, 2, 0))) if gradient.size else 1.0
    assert record.arrays.keys() == wanted.keys()
    for what, array in wanted.items():
        found = evaluate(record.tape, inputs, record.parameters, record.arrays[what].ravel().tolist()).astype(float)
        error = np.max(np.abs(found.reshape(array.shape) - array), initial=0.0)
        assert error < 1e-14 * (condition**2 if what in ("step", "x", "c") else 10.0), what


def test_placements_are_parameters_of_the_loops():
    """A record made of one robot holds for another of the same structure: other placements."""
    one, other = (package_robots.robot("3rps", home_length=a) for a in (0.55, 0.6))
    prescribed, local = prescribed_of(one, "XYZ")
    state, target = beside(other, prescribed, other.generic_poses)
    first, second = (loop_record(r.solver, prescribed, r.generic_poses.take(np.array([0])), local) for r in (one, other))
    assert first.key == second.key and first.parameters.shape == second.parameters.shape
    assert first.key != Structure(one.statics).key
    numbers = first.arrays["residual"].ravel().tolist()
    found = evaluate(first.tape, [state.x, state.c, target], second.parameters, numbers)
    wrong = evaluate(first.tape, [state.x, state.c, target], first.parameters, numbers)
    wanted, _ = other.solver.system(prescribed, state, target)
    np.testing.assert_allclose(found.astype(float), wanted, rtol=0, atol=1e-14)
    assert np.max(np.abs(wrong - wanted)) > 1e-3
