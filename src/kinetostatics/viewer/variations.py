"""Robots with other numbers, analysed for the sliders of a page that vary them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.kinematics.assembly import by_numpy
from kinetostatics.layout.numbers import DEGREES, MILLIMETRES, in_unit
from kinetostatics.parametric.parametric_robot import ParametricRobot, same_pose
from kinetostatics.parametric.variables import VariedNumbers, read_variables, typed_units, varied_numbers
from kinetostatics.progress import waiting
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.statics.robot_statics import statics_on

#: Number of values of a range, by the number of sliders.
COUNTS = {1: 21, 2: 11, 3: 5}
_UNITS = {"m": MILLIMETRES, "rad": DEGREES}


@dataclass(frozen=True)
class Slider:
    """A slider that varies numbers of a robot.

    Attributes:
        names: names of the numbers, see :func:`kinetostatics.tolerances`.
        rows: their values [SI] at each place of the slider, among them those of the given robot.
        texts: the rows with units.
        at: place of the given robot.
    """

    names: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]
    texts: tuple[str, ...]
    at: int


@dataclass(frozen=True)
class Variations:
    """Results for all combinations of places of sliders.

    Attributes:
        results: in the order of :func:`itertools.product`; None where the robot becomes another mechanism, or cannot be analysed
            at the coordinates of the given pose.
        given: index of the given result.
    """

    sliders: tuple[Slider, ...]
    results: tuple[Result | None, ...]
    given: int


def vary_result(result: Result, vary: Mapping[str, object]) -> Variations:
    """Analyse robots with other numbers at the pose and under the loads of a result of one pose.

    Args:
        vary: see :func:`kinetostatics.show`.

    Raises:
        ArgumentError: a name or value is invalid.
    """
    robots = ParametricRobot(result.robot)
    if isinstance(vary, Mapping):
        unset = [name for name, values in vary.items() if values is None and isinstance(name, str) and "+" not in name]
        vary = {**vary, **{name: _around(robots, name) for name in unset}}
    ranges, choices = read_variables(vary)
    if len(vary) > max(COUNTS):
        raise ArgumentError(f"vary names {len(vary)} parameters; a page has sliders for {max(COUNTS)} at most")
    rows: dict[tuple[str, ...], list[tuple[float, ...]]] = {choice.names: list(choice.rows) for choice in choices}
    for each in ranges:
        rows[each.name,] = [(x,) for x in np.linspace(each.low, each.high, COUNTS[len(vary)]).tolist()]
    numbers = varied_numbers(robots, list(itertools.chain(*rows)), typed_units(ranges, choices))
    if not numbers.file_is_a_design:
        raise ArgumentError(f"vary: numbers of {' or '.join(numbers.alike)} differ in the file; a slider has one value for them")
    sliders = tuple(_slider(numbers, names, values) for names, values in rows.items())
    places = list(itertools.product(*(range(len(slider.rows)) for slider in sliders)))
    given = places.index(tuple(slider.at for slider in sliders))
    results: list[Result | None] = []
    with waiting(lambda: f"analysing variation {len(results) + 1} of {len(places)}"):
        for k, place in enumerate(places):
            pairs = [pair for s, at in zip(sliders, place, strict=True) for pair in zip(s.names, s.rows[at], strict=True)]
            results.append(result if k == given else _varied(result, numbers, dict(pairs)))
    return Variations(sliders, tuple(results), given)


def _around(robots: ParametricRobot, name: str) -> tuple[float, float]:
    """Return the range from half to one and a half times the file's value."""
    value = varied_numbers(robots, [name], []).file_value(name)
    if not value:
        raise ArgumentError(f"vary: {name} is zero in the file: give its range, {name}=FROM:TO")
    low, high = sorted((0.5 * value, 1.5 * value))
    return low, high


def _slider(numbers: VariedNumbers, names: tuple[str, ...], values: Sequence[tuple[float, ...]]) -> Slider:
    own = tuple(map(numbers.file_value, names))
    rows = sorted([*(row for row in values if not np.allclose(row, own, rtol=1e-9, atol=0.0)), own])
    units = [_UNITS.get(unit, ((unit, 1.0),))[0] for unit in map(numbers.unit, names)]
    texts = [", ".join(in_unit(x / size, unit) for x, (unit, size) in zip(row, units, strict=True)) for row in rows]
    return Slider(names, tuple(rows), tuple(text.replace(" ", "\u00a0") for text in texts), rows.index(own))


def _varied(result: Result, numbers: VariedNumbers, values: Mapping[str, float]) -> Result | None:
    try:
        robot = Robot(numbers.description(values))
        vars(robot)["statics"] = statics_on(result.robot.statics, robot.statics)  # with the same ranks and wrench bases
        pose = same_pose(result.configuration, robot, by_numpy)
        return analyze(pose, result.load, result.gravity, loads=result.loads, payload=result.payload)
    except KinetostaticsError:
        return None
