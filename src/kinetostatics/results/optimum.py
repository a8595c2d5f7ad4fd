"""Results of optimizations: an optimum with its requirements, and Pareto fronts of two quantities."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.files.writer import save_robot, write_table
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot

#: Violations of a requirement up to this fraction of the limit count as rounding.
BROKEN = 1e-6


@dataclass(frozen=True)
class CheckedRequirement:
    """A requirement, evaluated at the optimal parameters.

    Attributes:
        text: the requirement as given.
        name: name of the quantity.
        worst: worst value over all poses and loads, SI; NaN if a pose has no result.
        limit: limit, SI.
        unit: unit of ``worst`` and ``limit``.
        margin: distance of the worst value from the limit, relative to the limit; negative: violated.
        pose: coordinates of the worst pose [m, rad].
        case: index of the worst load along each axis; () for a single load.
        active: whether the worst value is at the limit.
        saving: decrease of the objective if the limit is relaxed by 1 %, to first order (from its Lagrange multiplier).
        is_below: True for an upper limit, False for a lower limit.
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
    """The end of one of several searches, which begin at different parameters.

    Attributes:
        parameters: final parameters.
        objective: objective at these parameters.
        feasible: whether all requirements are met there.
    """

    parameters: Mapping[str, float]
    objective: float
    feasible: bool


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Reported):
    """Result of :func:`kinetostatics.optimize`.

    Attributes:
        feasible: whether all requirements are met at all poses.
        parameters: optimal parameters by name, SI; if no design is feasible, parameters of the design nearest to feasibility.
        units: units of the parameters, empty if unknown.
        allowed: allowed values of each parameter, SI: the two ends of a range, or all values of a list or catalogue.
        objective: value of the objective, SI.
        minimized: name of the objective.
        unit: unit of the objective.
        before: the objective with the parameters of the file; NaN if these yield no robot.
        requirements: all requirements, evaluated.
        at_bounds: parameters at an end of their range, as text: "rod_diameter at its lower bound".
        no_influence: names of parameters whose ranges affect neither objective nor requirements at the optimum.
        starts: the ends of all searches; agreement suggests a global optimum. If parameters have lists of values: the best
            combinations, at most ten times the number of ranges (without ranges, ten).
        alike: number of searches that end at the optimum; None if parameters have lists of values.
        searched: description of the search.
        evaluations: number of robots analysed.
        robot: the robot with the optimal parameters.
        result: the analysis of this robot at all poses (P, …); the axes of several loads follow the axis of poses.
        poses: number of poses.
        beyond_limits: number of these poses at which a joint limit is exceeded.
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
        """The requirements whose worst value is at the limit."""
        return tuple(requirement for requirement in self.requirements if requirement.active)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot with these parameters to a plain URDF file, see :func:`kinetostatics.save_robot`."""
        save_robot(self.robot, path)


@dataclass(frozen=True, eq=False, repr=False)
class ParetoFront(Reported):
    """Pareto-optimal designs for two quantities.

    Attributes:
        points: optima, from the minimum of the first quantity to the minimum of the second. Each minimizes the first quantity
            under an upper limit of the second; this limit is the last requirement of the optimum.
        objectives: (n, 2) both quantities of each design, SI.
        minimized: names of the two quantities.
        units: units of the two quantities.
        searched: description of the search.
        evaluations: number of robots analysed.
    """

    points: tuple[Optimum, ...]
    objectives: Array
    minimized: tuple[str, str]
    units: tuple[str, str]
    searched: str
    evaluations: int

    @property
    def parameters(self) -> dict[str, Array]:
        """The parameters (n,) of all points, by name, SI."""
        names = self.points[0].parameters if self.points else ()
        return {name: frozen(np.array([point.parameters[name] for point in self.points])) for name in names}

    def __getitem__(self, number: int) -> Optimum:
        return self.points[number]

    def __iter__(self) -> Iterator[Optimum]:
        return iter(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write both quantities and all parameters of each point to a CSV file, with units in the titles.

        Raises:
            ArgumentError: the file cannot be written.
        """
        units = self.points[0].units if self.points else {}
        quantities = list(zip(self.minimized, self.units, self.objectives.T, strict=True))
        quantities += [(name, units.get(name, ""), values) for name, values in self.parameters.items()]
        columns: dict[str, list[str]] = {}
        for name, unit, values in quantities:
            title = f"{name} [{unit}]" if unit else name
            if title in columns:  # a parameter with the name of a minimized quantity
                title = f"parameter {title}"
            columns[title] = [repr(value) for value in values.tolist()]
        write_table(path, columns)
