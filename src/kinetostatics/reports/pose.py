"""Poses in words, as all reports tell them: what is true of them, where platform and actuators are, what loads them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.printing.text import DEGREES, FORCES, MILLIMETRES, MOMENTS, NOISE, Scale, Units, vector, wrapped
from kinetostatics.results.result import Result
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

#: What may be true of poses: title, of which poses (…), and words.
Truth: TypeAlias = tuple[str, NDArray[np.bool_], str]
#: Values (…), the unit they are written in, and what is rounding noise.
Coordinate: TypeAlias = tuple[Array, Units, float]

_ORIENTATIONS = {"rotation_vector": "rotation vector", "tilt_torsion": "tilt and torsion"}


def statuses_of(poses: Configuration | Result) -> list[Truth]:
    """Return which poses are OK, and which have no numbers."""
    return [(item.name, poses.status == item, STATUS_WORDS[item]) for item in (Status.OK, *WITHOUT_NUMBERS)]


def facts_of(poses: Configuration | Result) -> list[Truth]:
    """Return of which poses each fact is true."""
    return [(fact.title, getattr(poses, name), fact.words) for name, fact in FACTS.items() if hasattr(poses, name)]


def platform_coordinates(configuration: Configuration) -> dict[str, Coordinate]:
    """Return the platform's coordinates."""
    return {name: _coordinate(configuration, value, name in "xyz") for name, value in configuration.platform.items()}


def actuator_coordinates(configuration: Configuration) -> dict[str, Coordinate]:
    """Return the coordinates of the driven joints."""
    connections, values = configuration.robot.mechanism.connections, configuration.actuators
    return {name: _coordinate(configuration, value, connections[name].type.is_slide) for name, value in values.items()}


def _coordinate(configuration: Configuration, value: Array, is_length: bool) -> Coordinate:
    return (value, MILLIMETRES, NOISE * configuration.robot.length) if is_length else (value, DEGREES, NOISE)


def written(coordinate: Coordinate, with_unit: bool = True) -> str:
    """Write a coordinate of one pose with four decimals."""
    value, ((unit, factor),), noise = coordinate
    scale = Scale(unit, factor, 4, noise)
    return scale.with_unit(value) if with_unit else scale(value)


def pose_lines(configuration: Configuration, gravity: Array, load: Array, *more: tuple[str, str]) -> list[str]:
    """Return where one pose is and what loads it, and ``more`` names with texts."""
    found = platform_coordinates(configuration)
    orientation = configuration.orientation
    angles = "  ".join(f"{name} {written(found[name])}" for name in orientation.names)
    force, moment = Scale.of(load[:3], FORCES), Scale.of(load[3:], MOMENTS)
    rows = [
        ("o", "  ".join(f"{name} {written(found[name], False)}" for name in "xyz") + " mm"),
        ("orientation", f"{angles}  ({_ORIENTATIONS.get(orientation.name, f'angles {orientation.name!r}')})"),
        (
            "actuators",
            ", ".join(f"{name} {written(item)}" for name, item in actuator_coordinates(configuration).items()) or "none",
        ),
        ("gravity", vector(gravity, Scale.of(gravity, (("m/s²", 1.0),), digits=4))),
        ("load at o", f"force {vector(load[:3], force)}, moment {vector(load[3:], moment)}"),
        *more,
    ]
    return [line for name, text in rows for line in wrapped(text, f"{name:13}")]
