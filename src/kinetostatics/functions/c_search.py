"""The search for corrected actuator positions in C: what :func:`kinetostatics.compensate` does at one pose, recorded."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from kinetostatics.compensation.search import Coordinates, Search, enough, led_there
from kinetostatics.engine.c_code import CProgram, c_program
from kinetostatics.engine.loop_record import held, recorded_rows
from kinetostatics.engine.pose_outputs import limits_record
from kinetostatics.engine.record import recorded_input
from kinetostatics.engine.scalars import Tape
from kinetostatics.math.arrays import Array
from kinetostatics.math.orientation import Orientation
from kinetostatics.mechanism.tree import Frames
from kinetostatics.results.compensation import loaded, pose_error, shift_of
from kinetostatics.robot import Robot

#: A twist [m, rad], nothing in particular, of which the search is recorded.
_TWIST = (1e-3, -2e-3, 3e-3, -4e-3, 5e-3, 6e-3)


@dataclass(frozen=True)
class SearchPrograms:
    """All programs of a search.

    ``platform`` takes frames and gives where the platform stands, 12 numbers; ``begin``, ``learn`` and ``remains`` take these
    and the twist; ``correct`` takes the actuators' coordinates at the wanted and at the corrected pose; ``limits`` tells whether
    a pose is within all limits. Truth values that tell whether a record holds stand last.

    Attributes:
        numbers: how many numbers a search has; the coordinates that are commanded stand first.
        enough: deviation [m] that counts as corrected; ``led``: the same where the actuators' coordinates are given.
        error, count: where the deviations of the coordinates stand, and how many these are.
        size, going: where the largest of them stands, and whether the search goes on.
    """

    platform: CProgram
    begin: CProgram
    learn: CProgram
    remains: CProgram
    correct: CProgram
    limits: CProgram
    numbers: int
    enough: float
    led: float
    error: int
    count: int
    size: int
    going: int

    @property
    def programs(self) -> tuple[CProgram, ...]:
        """All of them."""
        return self.platform, self.begin, self.learn, self.remains, self.correct, self.limits


def search_programs(robot: Robot, names: Sequence[str], orientation: Orientation, actuators: Sequence[str]) -> SearchPrograms:
    """Record a search.

    Args:
        robot: the robot.
        names: of the coordinates that are to come out as wanted.
        orientation: what its angles mean.
        actuators: names of the actuators in their order.
    """
    wanted, least = Coordinates(names, orientation, robot.length), enough(robot.length)
    frames = robot.statics.example
    platform = _platform(frames.rotation, frames.position, robot)
    twist, n = np.array([_TWIST]).T, len(names)

    def begun(stands: Array, twist: Array) -> list[Array]:
        pose = _pose(stands)
        asked, angles = wanted.of(pose), orientation.coordinates(pose[0])
        error = wanted.of(loaded(*pose, twist), angles) - asked
        return _flat(wanted, asked, angles, Search.begun(asked, np.eye(n)[:, :, None], error))

    def learnt(now: Array, stands: Array, twist: Array) -> list[Array]:
        asked, angles, search = _unflat(now, n)
        error = wanted.of(loaded(*_pose(stands), twist), angles) - asked
        return _flat(wanted, asked, angles, search.learnt(error, least))

    def remains(asked: Array, stands: Array, twist: Array) -> list[Array]:
        return [pose_error(_pose(asked), loaded(*_pose(stands), twist))]

    def corrected(before: Array, found: Array) -> list[Array]:
        slides = [robot.mechanism.connections[name].type.is_slide for name in actuators]
        return [before[k] + shift_of(before[k], found[k], slide) for k, slide in enumerate(slides)]

    first = np.concatenate([np.reshape(array, (-1, 1)) for array in begun(platform, twist)])
    drives = np.zeros((len(actuators), 1))
    limits, numbers = limits_record(robot)
    return SearchPrograms(
        _program(
            "platform",
            {"frames": np.concatenate([frames.rotation.reshape(-1, 1), frames.position.reshape(-1, 1)])},
            lambda array: [_platform(*_frames(array), robot)],
        ),
        _program("begin", {"stands": platform, "twist": twist}, begun),
        _program("learn", {"now": first, "stands": platform, "twist": twist}, learnt),
        _program("remains", {"asked": platform, "stands": platform, "twist": twist}, remains),
        _program("correct", {"wanted": drives, "found": drives}, corrected),
        c_program("limits", limits.tape, limits.truths, numbers, ("x",)),
        len(first),
        least,
        led_there(robot),
        len(first) - 3 - n,
        n,
        len(first) - 3,
        len(first) - 1,
    )


def _program(name: str, examples: Mapping[str, Array], computed: Callable[..., Sequence[Array]]) -> CProgram:
    """Record what is computed from columns of numbers; the last result is whether the record holds."""
    tape, names = Tape(), tuple(examples)
    inputs = [recorded_input(tape, number, array) for number, array in enumerate(examples.values())]

    def rows() -> list[Array]:
        return [*(row for array in computed(*inputs) for row in array.reshape(-1, 1)), held(tape)]

    wanted = recorded_rows(tape, rows)
    return c_program(name, tape, wanted, np.array([]), names)


def _frames(array: Array) -> tuple[Array, Array]:
    bodies = len(array) // 12
    return array[: 9 * bodies].reshape(3, 3, bodies, 1), array[9 * bodies :].reshape(3, bodies, 1)


def _platform(rotation: Array, position: Array, robot: Robot) -> Array:
    """Return the platform's rotation and position as a column (12, 1)."""
    R, o = robot.mechanism.platform_pose(Frames(rotation, position))
    return np.concatenate([R.reshape(-1, 1), o])


def _pose(stands: Array) -> tuple[Array, Array]:
    return stands[:9].reshape(3, 3, 1), stands[9:]


def _flat(wanted: Coordinates, asked: Array, angles: Array, search: Search) -> list[Array]:
    """Return the coordinates that are commanded, those that are wanted, all angles, and the search, as numbers."""
    parts = [getattr(search, field.name) for field in fields(search)]
    return [search.u / wanted.scale, asked, angles, *parts[:-1], np.where(search.going, 1.0, 0.0)]


def _unflat(numbers: Array, n: int) -> tuple[Array, Array, Search]:
    """Return the wanted coordinates, the angles and the search from numbers."""
    _, asked, angles, u, step, inverse, error, size, stale, going = np.split(numbers, np.cumsum([n, n, 3, n, n, n * n, n, 1, 1]))
    search = Search(u, step, inverse.reshape(n, n, 1), error, size[0], stale[0], going[0] != 0)
    return asked, angles, search
