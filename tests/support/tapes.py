"""A second way from a record to numbers: operation by operation with NumPy, without LLVM."""

import numpy as np

from kinetostatics.engine.record import arrays_of, sizes_of_applied, solution_of
from kinetostatics.engine.structure import Structure
from kinetostatics.kinematics.coordinate_choices import choices, prescribed_platform
from kinetostatics.math.orientation import orientation_named

ARITHMETIC = {"add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide, "negative": np.negative}
OTHERS = {"square_root": np.sqrt, "absolute": np.abs, "and": np.logical_and, "or": np.logical_or, "not": np.logical_not}
COMPARISONS = {">": np.greater, ">=": np.greater_equal, "<": np.less, "<=": np.less_equal, "==": np.equal, "!=": np.not_equal}
ANGLES = {"sine": np.sin, "cosine": np.cos, "angle": np.arctan2, "whole": np.rint}
FUNCTIONS = {**ARITHMETIC, **OTHERS, **COMPARISONS, **ANGLES, "choose": np.where}


def evaluate(tape, inputs, parameters, wanted):
    """Return the results (N,) of wanted operations for inputs, each (components, N)."""
    found = []
    N = inputs[0].shape[1]
    with np.errstate(all="ignore"):
        for name, *taken in tape.operations:
            if name == "input":
                found.append(inputs[taken[0]][taken[1]])
            elif name == "parameter":
                found.append(parameters[taken[0]])
            elif name == "constant":
                found.append(float.fromhex(taken[0]))
            elif name == "truth":
                found.append(taken[0])
            else:
                found.append(FUNCTIONS[name](*(found[k] for k in taken)))
    return np.array([np.broadcast_to(found[number], N) for number in wanted])


def close(found, wanted, tolerance=1e-11):
    """Arrays are the same to a part of the largest entry, with NaN in the same places."""
    np.testing.assert_array_equal(np.isnan(found), np.isnan(wanted))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * np.nanmax(np.abs(wanted), initial=0.0))


def differences(found, wanted, which=slice(None)):
    """Return by how much arrays of a solution differ at some poses, as parts of the largest entry of each.

    Truth values must be the same.
    """
    found, wanted = ({path: array[..., which] for path, array in arrays_of(one.whole).items()} for one in (found, wanted))
    assert list(found) == list(wanted)
    result, alike = {}, sizes_of_applied(wanted)
    for path, array in wanted.items():
        assert array.shape == found[path].shape, path
        if array.dtype == bool:
            np.testing.assert_array_equal(found[path], array, err_msg=path)
        elif array.size and "unbalanced" not in path:  # which is rounding
            np.testing.assert_array_equal(np.isnan(found[path]), np.isnan(array), err_msg=path)
            size = max(np.nanmax(np.abs(array), initial=0.0), alike.get(path, 0.0))
            result[path] = np.nanmax(np.abs(found[path] - array), initial=0.0) / (size if size > 1e-25 else 1.0)
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
    """Return frames, loads and gravity: the first generic poses and again all of them."""
    N, frames = 6, robot.generic_frames
    sound = np.flatnonzero(np.all(np.isfinite(frames.position), axis=(0, 1)))  # random robots do not reach all
    frames = frames.take(np.resize(sound, N))
    rng = np.random.default_rng(5)
    return frames, 100 * rng.standard_normal((6, N)), 9.81 * rng.standard_normal((3, N))


def evaluated(robot, record, frames, load, gravity):
    """Return the solution that a record gives, and where it holds."""
    N = load.shape[1]
    inputs = [frames.rotation.reshape(-1, N), frames.position.reshape(-1, N), load, gravity]
    found = evaluate(record.tape, inputs, Structure(robot.statics).values, (*record.numbers, *record.truths))
    numbers, truths = found[: len(record.numbers)].astype(float), found[len(record.numbers) :].astype(bool)
    arrays = {path: place.of(numbers, truths, N) for path, place in record.places.items()}
    return solution_of(robot.statics, frames, load, gravity, arrays), truths[0]


def prescribed_of(robot, convention):
    """Return the actuators or the first coordinates of the platform that determine the pose, and how many freedoms are local."""
    prescribed = robot.actuator_coordinates
    if convention is not None:
        orientation = orientation_named(convention)
        prescribed = prescribed_platform(choices(robot, orientation, (), robot.zero_poses)[0], orientation)
    prescribed = robot.mobility_analysis.without_idle_dofs(prescribed)
    return prescribed, robot.mobility_analysis.local_dofs(prescribed)
