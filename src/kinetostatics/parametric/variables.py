"""Design variables: their ranges, lists and catalogues of values, and the robots with these values."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import TypeAlias

import numpy as np

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import read_csv
from kinetostatics.parametric.parametric_robot import ParametricRobot, check_unit
from kinetostatics.parametric.robot_numbers import RobotNumber
from kinetostatics.robot import Robot
from kinetostatics.units import parse_number, typed_number

#: Largest number of combinations of listed values.
MOST = 2000
#: Catalogues of the package.
CATALOGUES = ("standard_bars", "standard_tubes")

#: Ranges, lists and catalogues by name of the parameter; a catalogue by the names of all parameters that its rows set.
Vary: TypeAlias = "Mapping[str, object] | Mapping[tuple[str, ...], object] | Mapping[str | tuple[str, ...], object]"


@dataclass(frozen=True)
class Range:
    """A parameter between two values, SI; its logarithm is varied if both values are positive.

    ``units`` are the units given with both values.
    """

    name: str
    low: float
    high: float
    units: tuple[str, ...] = ()

    def value(self, u: float) -> float:
        """Return the value at a relative position from 0 to 1."""
        u = min(max(u, 0.0), 1.0)
        if self.low > 0:
            return math.exp(math.log(self.low) + u * (math.log(self.high) - math.log(self.low)))
        return self.low + u * (self.high - self.low)

    def place(self, value: float) -> float:
        """Return the relative position of a value, clipped to 0 … 1."""
        value = min(max(value, self.low), self.high)
        if self.low > 0:
            return (math.log(value) - math.log(self.low)) / (math.log(self.high) - math.log(self.low))
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class Choice:
    """Parameters ``names`` that take their values from one of several ``rows``, SI; ``units`` are given with the values."""

    names: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]
    units: tuple[tuple[str, ...], ...] = ()


def typed_unit(text: str) -> str:
    """Return the unit given with a number; empty without a unit."""
    return (typed_number(text) or (0.0, ""))[1]


def read_variables(vary: object) -> tuple[list[Range], list[Choice]]:
    """Return the design variables: ranges, and lists or catalogues.

    Args:
        vary: by name of a parameter, or tuple of names: a range ``"20mm:120mm"`` or ``(0.02, 0.12)``; a list of values or
            ``"20mm,25mm"``; or a catalogue: the path of a CSV file or the name of a catalogue of the package.
    """
    if not isinstance(vary, Mapping) or not vary:
        raise ArgumentError(f'vary is {vary!r}; it must be a mapping such as {{"rod_diameter": "20mm:120mm"}}')
    ranges: list[Range] = []
    choices: list[Choice] = []
    for key, value in vary.items():
        names = (key,) if isinstance(key, str) else tuple(key) if isinstance(key, tuple) else ()
        names = tuple(name for joined in names for name in str(joined).split("+"))
        if not names or not all(names):
            raise ArgumentError(f"vary has the key {key!r}; it must be the name of a parameter, or a tuple of names")
        what = "+".join(names)
        if isinstance(value, str) and (value in CATALOGUES or value.endswith(".csv")):
            choices.append(_read_catalogue(value, names))
        elif len(names) > 1:
            raise ArgumentError(f"vary: {what} takes rows of a catalogue, a CSV file, not {value!r}")
        elif (isinstance(value, str) and ":" in value) or isinstance(value, tuple):
            ranges.append(_range(what, value))
        else:
            choices.append(_values(what, value))
    every = [variable.name for variable in ranges] + [name for choice in choices for name in choice.names]
    if twice := next((name for name in every if every.count(name) > 1), None):
        raise ArgumentError(f"vary: {twice!r} is varied twice")
    count = math.prod(len(choice.rows) for choice in choices)
    if not ranges and count > MOST:
        raise ArgumentError(f"vary: the lists have {count:,} combinations, more than {MOST:,}; give ranges instead")
    return ranges, choices


def typed_units(ranges: Sequence[Range], choices: Sequence[Choice]) -> list[tuple[str, str]]:
    """Return pairs of a parameter and a unit given with one of its values."""
    named = [(variable.name, variable.units) for variable in ranges]
    named += [pair for choice in choices for pair in zip(choice.names, choice.units, strict=False)]
    return [(name, unit) for name, units in named for unit in dict.fromkeys(units) if unit]


def _range(what: str, value: str | Iterable[object]) -> Range:
    parts = value.split(":") if isinstance(value, str) else list(value)
    numbers = [parse_number(str(part), "", f"vary: {what}") for part in parts]
    if len(numbers) != 2 or not numbers[0] < numbers[1] or not all(map(math.isfinite, numbers)):
        raise ArgumentError(f"vary: {what} is {value!r}; a range goes from a smaller to a larger value: '20mm:120mm'")
    return Range(what, numbers[0], numbers[1], tuple(typed_unit(str(part)) for part in parts))


def _values(what: str, value: object) -> Choice:
    parts: Sequence[object] = value.split(",") if isinstance(value, str) else list(np.atleast_1d(np.asarray(value)))
    try:
        numbers = [parse_number(str(part), "", f"vary: {what}") for part in parts]
    except ArgumentError as error:
        raise ArgumentError(f"{error}; a range is written 20mm:120mm, values 20mm,25mm") from None
    if len(set(numbers)) < max(len(numbers), 2):
        raise ArgumentError(f"vary: {what} is {value!r}; give at least two different values, or a range '20mm:120mm'")
    units = tuple(typed_unit(str(part)) for part in parts)
    return Choice((what,), tuple((number,) for number in sorted(numbers)), (units,))


def _read_catalogue(name: str, names: tuple[str, ...]) -> Choice:
    """Return the rows of a catalogue.

    A column's title is the name of a parameter, or the dimension at the end of this name, such as ``outer_diameter``.
    """
    path = str(files("kinetostatics.parametric") / f"{name}.csv") if name in CATALOGUES else name
    example = "a catalogue has a line of titles, such as outer_diameter [mm], and two rows at least"
    table = read_csv(path, example, least=2)
    titles = table.names
    keys = [full_name.rpartition(".")[2] for full_name in names]  # dimensions without the names of their parts
    sizes = [_size(title) for title in titles]
    hole = None
    if "inner_diameter" not in sizes and {"outer_diameter", "wall"} <= set(sizes):
        hole = next((k for k, key in enumerate(keys) if key not in titles and _size(key) == "inner_diameter"), None)
    columns: list[int] = []
    for k, key in enumerate(keys):
        size = "wall" if k == hole else _size(key)
        candidates = [titles.index(key)] if key in titles else [j for j, title_size in enumerate(sizes) if title_size == size]
        if len(candidates) != 1 or candidates[0] in columns:
            titled = ", ".join(title for title in titles if title)
            raise ArgumentError(f"{table.place}: the titles {titled} do not determine the column of {key!r}: give it this title")
        columns += candidates
    rows = []
    typed: list[list[str]] = [[] for _ in columns]
    for line, row in table.rows:
        values = []
        for units, column in zip(typed, columns, strict=True):
            values.append(parse_number(row[column], "", table.where(line)))
            units.append(typed_unit(row[column]))
        if hole is not None:
            values[hole] = parse_number(row[sizes.index("outer_diameter")], "", table.where(line)) - 2 * values[hole]
        rows.append(tuple(values))
    return Choice(names, tuple(dict.fromkeys(rows)), tuple(map(tuple, typed)))


def _size(name: str) -> str:
    """Return the dimension at the end of a name, such as outer_diameter for tube_diameter; without a dimension, the name."""
    for size in ("inner_diameter", "outer_diameter", "diameter", "wall"):
        if f"_{name}".endswith(f"_{size}"):
            return "outer_diameter" if size == "diameter" else size
    return name


def combinations(choices: Sequence[Choice]) -> list[dict[str, float]]:
    """Return all combinations of one row of each choice, as values of the parameters by name."""
    combined = []
    for rows in itertools.product(*(choice.rows for choice in choices)):
        pairs = zip(choices, rows, strict=True)
        combined.append({name: value for choice, row in pairs for name, value in zip(choice.names, row, strict=True)})
    return combined


@dataclass(frozen=True)
class VariedNumbers:
    """Varied numbers of a robot, and the robots with other values of these numbers.

    Attributes:
        alike: numbers by name, or by a pattern such as ``rod_*.outer_diameter``, whose numbers have one common value.
    """

    robots: ParametricRobot
    alike: Mapping[str, Sequence[RobotNumber]]

    def file_value(self, name: str) -> float:
        """Return the value in the file; for several numbers, their mean."""
        return float(np.mean([number.value for number in self.alike[name]]))

    @property
    def file_is_a_design(self) -> bool:
        """Whether the file gives all numbers of a pattern the same value, for each pattern."""
        return all(len({number.value for number in several}) == 1 for several in self.alike.values())

    def unit(self, name: str) -> str:
        """Return the SI unit of a number; empty if the unit is unknown or the number is dimensionless."""
        unit = self.alike[name][0].unit
        return "" if unit == "1" else unit

    def description(self, values: Mapping[str, float]) -> RobotDescription:
        """Return the description with these values; expressions of the file are evaluated again."""
        return self.robots.description({number.name: value for name, value in values.items() for number in self.alike[name]})

    def robot(self, values: Mapping[str, float]) -> Robot:
        return Robot(self.description(values))


def varied_numbers(robots: ParametricRobot, names: Sequence[str], typed: Sequence[tuple[str, str]]) -> VariedNumbers:
    """Select the varied numbers of a robot, and check their units.

    Args:
        names: names of numbers, or patterns.
        typed: pairs of a name and the unit given with its values.
    """
    alike: dict[str, list[RobotNumber]] = {}
    for name, number in robots.select(names, "vary"):
        alike.setdefault(name, []).append(number)
    for name, several in alike.items():
        if len(units := {number.unit for number in several}) > 1:
            kinds = ", ".join(sorted(units))
            raise ArgumentError(
                f"vary: {name} stands for numbers in several units, {kinds}; all numbers of a pattern have the same value"
            )
    for name, unit in typed:
        check_unit(alike[name][0], unit, "vary")
    return VariedNumbers(robots, alike)
