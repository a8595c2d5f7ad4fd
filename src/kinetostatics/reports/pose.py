"""Reports of poses: state, coordinates of platform and actuators, gravity and load."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.blocks import Facts, Number, ReportSection, Table, Word
from kinetostatics.layout.numbers import DEGREES, FORCES, MILLIMETRES, MOMENTS, NOISE, NumberFormat, Units, vector
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.arrays import Array, Values
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

#: A state of poses: title, mask (…) of the poses in this state, and description.
State: TypeAlias = tuple[Word, NDArray[np.bool_], str]
#: A coordinate: values (…), unit, and magnitude below which a value is a rounding error.
Coordinate: TypeAlias = tuple[Array, Units, float]

_ORIENTATIONS = {"rotation_vector": "rotation vector", "tilt_torsion": "tilt and torsion"}


def statuses_of(poses: Configuration | Result, status: NDArray[np.int8] | None = None) -> list[State]:
    """Return the states OK, UNREACHABLE and SINGULAR, in this order; ``status`` as for :func:`state_title`."""
    status = poses.status if status is None else status
    return [(status_word(state), status == state, STATUS_WORDS[state]) for state in (Status.OK, *WITHOUT_NUMBERS)]


def facts_of(poses: Configuration | Result) -> list[State]:
    """Return a state for each of the :data:`FACTS` that the poses have as an attribute; a Configuration has only some."""
    return [
        (Word(fact.title, "bad" if fact.status is None else "doubtful"), getattr(poses, name), fact.words)
        for name, fact in FACTS.items()
        if hasattr(poses, name)
    ]


def status_word(status: Status) -> Word:
    return Word(status.name, "good" if status == Status.OK else "bad" if status in WITHOUT_NUMBERS else "doubtful")


def state_title(poses: Configuration | Result, status: NDArray[np.int8] | None = None) -> list[str]:
    """Return the states of one pose, the most severe first; for a batch, its shape, and the number of poses in each state.

    ``status`` (…): other statuses than those of the poses.
    """
    single, (ok, *worse), facts = poses.shape == (), statuses_of(poses, status), facts_of(poses)
    states = [
        (title, where) for title, where, _ in ((*worse, *reversed(facts)) if single else (ok, *worse, *facts)) if np.any(where)
    ]
    states = states or [ok[:2]] * single
    pieces = [] if single else [f"{count(poses.status.size, 'pose')}, batch shape {poses.shape}" + ": " * bool(states)]
    for k, (title, where) in enumerate(states):
        pieces += [", " * (k > 0) + ("" if single else f"{int(np.sum(where))} "), title]
    return pieces


def count(number: int, noun: str) -> str:
    """Return "1 pose", "2 poses", …."""
    return f"{number} {noun}{'s' * (number != 1)}"


def platform_coordinates(configuration: Configuration) -> dict[str, Coordinate]:
    return {name: _coordinate(configuration, value, name in "xyz") for name, value in configuration.platform.items()}


def actuator_coordinates(configuration: Configuration) -> dict[str, Coordinate]:
    connections, values = configuration.robot.mechanism.connections, configuration.actuators
    return {name: _coordinate(configuration, value, connections[name].type.is_slide) for name, value in values.items()}


def actuator_unit(robot: Robot, name: str) -> str:
    """Return the unit of an actuator's force: N or N·m."""
    return robot.mechanism.connections[name].type.force_unit


def _coordinate(configuration: Configuration, value: Array, is_length: bool) -> Coordinate:
    return (value, MILLIMETRES, NOISE * float(configuration.robot.length)) if is_length else (value, DEGREES, NOISE)


def at_pose(coordinate: Coordinate, with_unit: bool = True) -> Number:
    """Return the coordinate of a single pose, with four decimals in mm or degrees."""
    value, ((unit, factor),), noise = coordinate
    return Number(float(value), NumberFormat(unit, factor, 4, noise), with_unit=with_unit)


def pose_facts(configuration: Configuration, gravity: Array, load: Array, *more: tuple[str, str]) -> Facts:
    """Return lines on coordinates, gravity (3,) and load (6,) of one pose, followed by ``more`` lines (name, text)."""
    coordinates = platform_coordinates(configuration)
    orientation = configuration.orientation
    angles = "  ".join(f"{name} {at_pose(coordinates[name])}" for name in orientation.names)
    force, moment = NumberFormat.of(load[:3], FORCES), NumberFormat.of(load[3:], MOMENTS)
    actuators = ", ".join(f"{name} {at_pose(coordinate)}" for name, coordinate in actuator_coordinates(configuration).items())
    return Facts(
        [
            ("o", "  ".join(f"{name} {at_pose(coordinates[name], False)}" for name in "xyz") + " mm"),
            ("orientation", f"{angles}  ({_ORIENTATIONS.get(orientation.name, f'angles {orientation.name!r}')})"),
            ("actuators", actuators or "none"),
            ("gravity", vector(gravity, NumberFormat.of(gravity, (("m/s²", 1.0),), digits=4))),
            ("load at o", f"force {vector(load[:3], force)}, moment {vector(load[3:], moment)}"),
            *more,
        ]
    )


def configuration_report(configuration: Configuration) -> Report:
    both = {**platform_coordinates(configuration), **actuator_coordinates(configuration)}
    rows = [(name, Number.range_of(*coordinate)) for name, coordinate in both.items()]
    title = [f"Configuration of {configuration.robot.name!r}: ", *state_title(configuration)]
    title.append("; " + ", ".join(f"{name} {number}" for name, number in rows[:6]))
    header = ("coordinate", "value" if configuration.shape == () else "range")
    return Report(title, lambda: [ReportSection("", [Table.of_rows(header, rows)])], lambda: configuration_data(configuration))


def configuration_data(configuration: Configuration) -> dict[str, object]:
    shape = configuration.shape
    return {
        "shape": shape,
        "status": status_names(configuration.status),
        "limit_exceeded": configuration.limit_exceeded,
        "orientation": configuration.orientation.name,
        **attributes(configuration, ("platform", "platform_frame", "actuators", "q", "residual")),
        "loop_gaps": {
            name: {"m": metres.reshape(shape), "rad": radians.reshape(shape)}
            for name, (metres, radians) in configuration.loop_gaps.items()
        },
        "limits_exceeded": configuration.limits_exceeded,
    }


def status_names(status: Values) -> object:
    """Return the name of a status; for a batch, nested lists of names."""
    names = np.array([state.name for state in Status], dtype=object)
    return names[np.asarray(status, dtype=int)].tolist() if np.ndim(status) else Status(int(status)).name
