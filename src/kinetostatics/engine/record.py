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

#: Load [N, N·m] and gravity [m/s²] of the example: nothing in particular, so that nothing vanishes.
_EXAMPLE_LOAD = (31.0, -17.0, -53.0, 7.0, 11.0, -3.0)
_EXAMPLE_GRAVITY = (0.7, -1.3, -9.1)
#: Why a robot with rigid limbs or springs that nothing holds is not recorded, and one whose rigid parts leave forces open.
SINGULAR = "the platform can move at generic poses, which singular values tell"
INDETERMINATE = "rigid limbs or rings overconstrain one another, so that singular values tell how their forces may change"
#: Why one is not of which NumPy solves already the example with more care than other poses.
CAREFUL = "a limb takes eigenvectors at generic poses already, as where self-stress is almost rigid"


@contextmanager
def recording_equilibrium(robot: RobotStatics) -> Iterator[None]:
    """Record the equilibrium of a robot inside.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    try:
        with recording():
            yield
    except NotRecordedError as error:
        found = solve_with_springs(robot, *example_of(robot))
        if found.singular[0] or found.indeterminate[0]:
            raise NotRecordedError(SINGULAR if found.singular[0] else INDETERMINATE) from error
        if isinstance(error.__cause__, IndexError):  # poses are picked out by what is recorded
            raise NotRecordedError(CAREFUL) from error
        raise


def recorded_input(tape: Tape, number: int, array: Array) -> Number:
    """Return what records an input array of one pose, whose values there are the example's."""
    scalars = np.empty(array.size, dtype=object)
    for k, value in enumerate(array.ravel().tolist()):
        scalars[k] = tape.write(("input", number, k), value)
    return scalars.reshape(array.shape).view(Recorded)


def example_of(robot: RobotStatics, places: LoadedPlaces | None = None) -> tuple[Number, ...]:
    """Return the example: frames of one generic pose, load (6, 1), gravity (3, 1), and what acts at ``places`` (6 P, 1)."""
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
    """Solve as :func:`solve_with_springs`, also of one pose by the operations of many: what is recorded."""
    _, o = robot.mechanism.platform_pose(frames)
    weights = robot.weights.wrenches_of_many(frames, o, gravity)
    applied = () if places is None or wrenches is None else _loads_at(places, wrenches)
    return solve_with_springs(robot, frames, load, gravity, applied=applied, weights=weights)


def _loads_at(places: LoadedPlaces, wrenches: Array) -> tuple[AppliedLoad, ...]:
    """Return loads whose wrenches (6 P, N) are one behind the other."""
    rows = iter(wrenches.reshape(-1, 6, wrenches.shape[1]))
    return tuple(AppliedLoad(name, {place: next(rows) for place in where}) for name, where in places.loads)
