"""Results of optimizations: an optimum with its requirements, and Pareto fronts of two quantities."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.files.writer import save_robot, write_text
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot

#: Broken requirements up to this part of the limit count as rounding.
BROKEN = 1e-6


@dataclass(frozen=True)
class CheckedRequirement:
    """A requirement at the parameters that were found.

    Attributes:
        text: as it was written.
        name: of the quantity.
        worst: of all poses and loads, SI; NaN where a pose has no number.
        limit: SI.
        unit: of both.
        margin: how far the worst is from the limit, as part of it; negative: it is broken.
        pose: coordinates of the worst pose [m, rad].
        case: the worst of several loads, by its number from 0 along each axis; () where there is one.
        active: whether it decides: the worst is at the limit.
        saving: the objective saved by relaxing the limit by 1 %, to first order (its Lagrange multiplier).
        is_below: whether the quantity must be below the limit, or above.
    """

    text: str
    name: str
    worst: float
    limit: float
    unit: str
    margin: float
    pose: Mapping[str, float]
    case: tuple[int, ...]
    active: bool
    saving: float
    is_below: bool


@dataclass(frozen=True)
class Start:
    """Start and result of one of several searches.

    Attributes:
        parameters: at its end.
        objective: there.
        feasible: whether all requirements hold there.
    """

    parameters: Mapping[str, float]
    objective: float
    feasible: bool


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Reported, builder="reports.optimum:optimum_report"):
    """Result of :func:`kinetostatics.optimize`.

    Attributes:
        feasible: whether all requirements hold at all poses.
        parameters: by name, SI; where nothing is feasible those that come nearest.
        units: of the parameters, empty where they are not known.
        allowed: what each parameter could be, SI: the two ends of a range, or all values of a list or catalogue.
        objective: what was minimized, SI.
        minimized: its name, and ``unit``.
        unit: see ``minimized``.
        before: the objective with the file's own parameters; NaN where these make no robot.
        requirements: all of them, checked.
        at_bounds: parameters at an end of their range: "rod_diameter at its lower bound".
        no_influence: names of ranges on which neither objective nor requirements depend there.
        starts: what each search from another start found; those that end alike speak for the optimum. Where values of lists are
            tried, the best ten of these instead, ten more for each range.
        alike: how many searches from different starts end at the optimum; None where values of lists were tried.
        searched: how it was searched, in a sentence.
        evaluations: robots that were analysed.
        robot: with these parameters.
        result: its analysis at all poses (P, …); the axes of several loads follow that of the poses.
        poses: number of poses; ``beyond_limits`` of them are beyond a joint's limit.
        beyond_limits: see ``poses``.
    """

    feasible: bool
    parameters: Mapping[str, float]
    units: Mapping[str, str]
    allowed: Mapping[str, tuple[float, ...]]
    objective: float
    minimized: str
    unit: str
    before: float
    requirements: tuple[CheckedRequirement, ...]
    at_bounds: tuple[str, ...]
    starts: tuple[Start, ...]
    searched: str
    evaluations: int
    robot: Robot
    result: Result
    poses: int
    beyond_limits: int
    alike: int | None
    no_influence: tuple[str, ...] = ()

    @property
    def active(self) -> tuple[CheckedRequirement, ...]:
        """The requirements that decide."""
        return tuple(item for item in self.requirements if item.active)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot with these parameters to a plain URDF file that loads, see :func:`kinetostatics.save_robot`."""
        save_robot(self.robot, path)


@dataclass(frozen=True, eq=False, repr=False)
class ParetoFront(Reported, builder="reports.optimum:pareto_report"):
    """Designs of which none is better than another in both of two quantities.

    Attributes:
        points: optima, from the least of the first quantity to the least of the second. Each is one of the first quantity, with a
            limit of the second as its last requirement.
        objectives: (n, 2) both quantities of each, SI.
        minimized: names of both.
        units: of both.
        searched: how it was searched, in a sentence.
        evaluations: robots that were analysed.
    """

    points: tuple[Optimum, ...]
    objectives: Array
    minimized: tuple[str, str]
    units: tuple[str, str]
    searched: str
    evaluations: int

    @property
    def parameters(self) -> dict[str, Array]:
        """The parameters of all points (n,), by name, SI."""
        names = self.points[0].parameters if self.points else ()
        return {name: frozen(np.array([item.parameters[name] for item in self.points])) for name in names}

    def __getitem__(self, number: int) -> Optimum:
        return self.points[number]

    def __iter__(self) -> Iterator[Optimum]:
        return iter(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV file: both quantities and all parameters of each point, with units in the titles; one there is replaced.

        Raises:
            ArgumentError: the file cannot be written.
        """
        names = self.parameters
        units = self.points[0].units if self.points else {}
        titles = [*zip(self.minimized, self.units, strict=True), *((name, units.get(name, "")) for name in names)]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in titles])
        for k, row in enumerate(self.objectives.tolist()):
            writer.writerow([repr(value) for value in (*row, *(float(values[k]) for values in names.values()))])
        write_text(path, text.getvalue())
