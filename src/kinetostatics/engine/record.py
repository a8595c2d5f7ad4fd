"""Records of the functions that assemble and analyse a robot's poses, made at one example pose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from kinetostatics.engine.recorder import Recorded, recording
from kinetostatics.engine.scalars import NotRecordedError, Number, Tape
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, LoadedPlaces
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import solve_with_springs

#: Load [N, N·m] and gravity [m/s²] of the example, without zeros, so that no term vanishes.
_EXAMPLE_LOAD = (31.0, -17.0, -53.0, 7.0, 11.0, -3.0)
_EXAMPLE_GRAVITY = (0.7, -1.3, -9.1)
#: Reasons why a robot is not recorded: a singular platform at generic poses, and internal forces that equilibrium leaves
#: undefined.
SINGULAR = "the platform is singular at generic poses, which needs singular values"
INDETERMINATE = "rigid limbs or rings overconstrain one another, so that their internal forces need singular values"
#: Reason why a robot is not recorded if its example already needs eigenvectors.
CAREFUL = "a limb needs eigenvectors even at generic poses, for instance because its self-stress is almost rigid"


@contextmanager
def recording_equilibrium(robot: RobotStatics) -> Iterator[None]:
    """Record the equilibrium of a robot, as context manager.

    Raises:
        NotRecordedError: a function is not a sequence of operations on scalars.
    """
    try:
        with recording():
            yield
    except NotRecordedError as error:
        found = solve_with_springs(robot, *example_of(robot))
        if found.singular[0] or found.indeterminate[0]:
            raise NotRecordedError(SINGULAR if found.singular[0] else INDETERMINATE) from error
        if isinstance(error.__cause__, IndexError):  # a recorded mask selects poses
            raise NotRecordedError(CAREFUL) from error
        raise


def recorded_input(tape: Tape, number: int, array: Array) -> Number:
    """Return an input array of recorded scalars, with the values of the example."""
    scalars = np.empty(array.size, dtype=object)
    for k, value in enumerate(array.ravel().tolist()):
        scalars[k] = tape.write(("input", number, k), value)
    return scalars.reshape(array.shape).view(Recorded)


def example_of(robot: RobotStatics, places: LoadedPlaces | None = None) -> tuple[Number, ...]:
    """Return the example: frames of one generic pose, load (6, 1), gravity (3, 1), and wrenches at ``places`` (6 P, 1)."""
    plain = robot.example, np.array([_EXAMPLE_LOAD]).T, np.array([_EXAMPLE_GRAVITY]).T
    if places is None:
        return plain
    count = 6 * sum(len(where) for _, where in places.loads)
    return *plain, (np.resize(_EXAMPLE_LOAD, count) * (1 + 0.1 * np.arange(count)))[:, None]


def by_numpy(
    robot: RobotStatics,
    frames: Frames,
    load: Array,
    gravity: Array,
    wrenches: Array | None = None,
    places: LoadedPlaces | None = None,
) -> Solution:
    """Solve the equilibrium as :func:`solve_with_springs` does for many poses; this function is recorded."""
    _, o = robot.mechanism.platform_pose(frames)
    weights = robot.weights.wrenches_of_many(frames, o, gravity)
    applied = () if places is None or wrenches is None else _loads_at(places, wrenches)
    return solve_with_springs(robot, frames, load, gravity, applied=applied, weights=weights)


def _loads_at(places: LoadedPlaces, wrenches: Array) -> tuple[AppliedLoad, ...]:
    """Return loads on links from their stacked wrenches (6 P, N)."""
    rows = iter(wrenches.reshape(-1, 6, wrenches.shape[1]))
    return tuple(AppliedLoad(name, {place: next(rows) for place in where}) for name, where in places.loads)
