"""Records evaluated operation by operation with NumPy, without LLVM, beside the analysis."""

import numpy as np

from kinetostatics.engine.pose_code import ANALYSIS, pose_model
from kinetostatics.engine.pose_record import pose_record
from kinetostatics.engine.record_derivatives import _FUNCTIONS, values
from kinetostatics.engine.scalars import _COMPARISONS, Tape, needed_by
from kinetostatics.kinematics.alternatives import choices, prescribed_platform
from kinetostatics.math.rotations import orientation_named
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.springs import solve_with_springs

#: Both numbers of every operation: around all multiples of π/8, large and small ones, equal ones, zeros of both signs.
TURNS = np.arange(-24, 25) * np.pi / 8
FIRST = np.concatenate([TURNS, TURNS + 1e-9, np.sin(TURNS), [0.0, -0.0, 0.0, -0.0, 1e-300, 3e4, -7e5, 2.5, 0.5, -0.5, 1.5]])
SECOND = np.concatenate([TURNS[::-1], TURNS, np.cos(TURNS), [0.0, 0.0, -0.0, -1.0, 1.0, 2.0, 3e-9, 2.5, -0.5, 0.5, -1e300]])


def recorded(kind):
    """Return a tape of all operations on two numbers of a kind and on a truth, and those that give numbers and truths."""
    tape = Tape()
    a, b = (tape.write((kind, *((0, k) if kind == "input" else (k,))), 0.5).number for k in range(2))
    more, less = (tape.write((how, a, b), how == "<").number for how in "><")
    taken = {"and": (more, less), "or": (more, less), "not": (more,), "choose": (more, a, b)}
    numbers, truths = [], [more, less]
    for name in _FUNCTIONS:
        one = name in ("negative", "square_root", "absolute", "sine", "cosine", "whole")
        is_truth = name in _COMPARISONS or name in ("and", "or", "not")
        operation = (name, *taken.get(name, (a,) if one else (a, b)))
        (truths if is_truth else numbers).append(tape.write(operation, False if is_truth else 0.5).number)
    numbers += [tape.number_of(value) for value in (0.1, -0.0)] + [a]
    return tape, numbers, [*truths, tape.number_of(True), tape.number_of(False)]


def evaluate(tape, inputs, parameters, wanted):
    """Return the results (N,) of wanted operations for inputs, each (components, N)."""
    found = values(tape, needed_by(tape, wanted), inputs, parameters)
    return np.array([np.broadcast_to(found[number], inputs[0].shape[1]) for number in wanted])


def close(found, wanted, tolerance=1e-11):
    """Arrays are the same to a part of the largest entry, with NaN in the same places."""
    np.testing.assert_array_equal(np.isnan(found), np.isnan(wanted))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * np.nanmax(np.abs(wanted), initial=0.0))


#: All that compiled code computes of an analysis.
NAMES = tuple(name for stage in ANALYSIS for name in stage)


def solved(robot, x, load, gravity, applied=()):
    """Return the same by NumPy, each (…, N)."""
    solution = solve_with_springs(robot.statics, LoadedPoses(robot.equations.place(x).frames, load, gravity, applied=applied))
    return {name: OF_EQUILIBRIUM[name](robot.statics, solution) for name in NAMES}


def computed(code, *given):
    """Return it by compiled code, and where the record holds."""
    numbers, truths = code.computed(*given)
    return {name: place.of(numbers, truths) for name, place in code.places.items()}, truths[0]


def differences(found, wanted, which=slice(None)):
    """Return by how much arrays differ at some poses, as parts of the largest entry of each; truth values must be the same."""
    assert found.keys() == wanted.keys()
    result = {}
    for name, array in wanted.items():
        array, mine = (np.broadcast_arrays(array, found[name])[k][..., which] for k in (0, 1))
        if array.dtype == bool:
            np.testing.assert_array_equal(mine, array, err_msg=name)
        elif array.size:
            np.testing.assert_array_equal(np.isnan(mine), np.isnan(array), err_msg=name)
            size = np.nanmax(np.abs(array), initial=0.0)
            result[name] = np.nanmax(np.abs(mine - array), initial=0.0) / (size if size > 1e-25 else 1.0)
    return result


#: Limbs of random robots, as in ``tests/properties``; the last ones have more limbs than freedoms, or rigid joints of all kinds.
RANDOM = [
    ("RpS",) * 3,
    ("UpS",) * 6,
    ("pRU", "pRU", "UpR"),
    ("rrp",),
    ("CpU", "rCU", "pUS", "rUS"),
    ("pUU", "SpU", "rUS", "UpU"),
]


def some_poses(robot):
    """Return coordinates, loads and gravity: the first generic poses and again all of them."""
    N, x = 6, robot.generic_poses.x
    sound = np.flatnonzero(np.all(np.isfinite(x), axis=0))  # random robots do not reach all
    rng = np.random.default_rng(5)
    return x[:, np.resize(sound, N)], 100 * rng.standard_normal((6, N)), 9.81 * rng.standard_normal((3, N))


def record_of(robot, stages=ANALYSIS, places=None):
    """Return the record of a robot's poses."""
    model, example = pose_model(robot, robot.statics, stages, places)
    return pose_record(model, [name for stage in stages for name in stage], example)


def evaluated(robot, record, *given, stages=ANALYSIS):
    """Return the outputs that a record gives, and where it holds."""
    model, _ = pose_model(robot, robot.statics, stages)
    found, N = {}, given[0].shape[1]
    for name, rows in record.rows.items():
        found[name] = evaluate(record.tape, given, model.structure().values, rows).reshape(*record.shapes[name], N)
    return found, evaluate(record.tape, given, model.structure().values, [record.all_hold()])[0].astype(bool)


def assert_recorded(robot):
    """Assert that a robot's record gives what NumPy computes; return both."""
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot), *poses)
    wanted = solved(robot, *poses)
    worst = differences(found, wanted)
    assert np.all(holds) and max(worst.values()) < 1e-11, max(worst, key=worst.get)
    return found, wanted


def assert_same_results(found, wanted, tolerance=1e-10):
    """Assert that the results of both engines are the same."""
    np.testing.assert_array_equal(found.status, wanted.status)
    for name in ("twist", "compliance", "stiffness", "base_wrench", "strain_energy"):
        close(getattr(found, name), getattr(wanted, name), tolerance)
    for name in ("contributions", "actuator_forces", "joint_wrenches", "spring_forces"):
        mine, other = getattr(found, name), getattr(wanted, name)
        assert list(mine) == list(other)
        for key, array in other.items():
            np.testing.assert_array_equal(np.isnan(mine[key]), np.isnan(array))
        if other:
            close(np.stack([*mine.values()]), np.stack([*other.values()]), tolerance)


def prescribed_of(robot, convention):
    """Return the actuators or the first coordinates of the platform that determine the pose."""
    prescribed = robot.actuator_coordinates
    if convention is not None:
        orientation = orientation_named(convention)
        prescribed = prescribed_platform(choices(robot, orientation, (), robot.zero_poses)[0], orientation)
    return robot.mobility_analysis.with_dofs(prescribed)
