"""Objective and requirements of an optimization as functions of the parameters of a robot, over all poses of a workspace."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze
from kinetostatics.arguments import Keyword, check_mapping
from kinetostatics.design.requirements import REQUIRABLE, Requirement
from kinetostatics.design.varied_numbers import VariedNumbers
from kinetostatics.engine.programs import loops_for
from kinetostatics.exceptions import ArgumentError, RobotFileError, StaticsError
from kinetostatics.kinematics.assembly import assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.results.optimum import BROKEN
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class Evaluation:
    """One robot, analysed at all poses under all load cases.

    Attributes:
        objective: value of the objective, SI; infinite if the parameters are invalid.
        margins: margins of all requirements at all poses, as one axis.
        result: the analysis (P, …), None if the parameters are invalid; the axes of load cases follow that of the poses.
        values: values (N, k) of each requirement at the N entries of the result.
    """

    objective: float
    margins: Array
    result: Result | None
    values: list[Array]

    @property
    def violation(self) -> float:
        """Largest violation of a requirement, relative to its limit; infinite if the parameters are invalid."""
        return math.inf if self.result is None else max(0.0, -float(self.margins.min(initial=0.0)))

    @property
    def feasible(self) -> bool:
        """Whether all requirements are met at all poses, within rounding."""
        return self.result is not None and self.violation <= BROKEN


@dataclass
class Problem:
    """Objective and margins as functions of parameters; computed values are cached.

    Attributes:
        sizes: varied numbers and their robots.
        coordinates: (P,) coordinates of all poses.
        is_platform: whether these are platform coordinates, not those of actuators.
        orientation: convention of the orientation coordinates, see :meth:`Robot.assemble`.
        analysis: arguments of :func:`kinetostatics.analyze`, with every load case at every pose.
        cases: shape of the load cases; () for one.
        objective: name and argument of the objective.
        requirements: requirements at every pose.
        tool: reference point of sag, deflections and stiffness against forces; None: o.
        closure_tolerance: largest gap of a closed loop [m, rad].
        known: computed values by parameters.
        count: number of robots analysed.
    """

    sizes: VariedNumbers
    coordinates: Mapping[str, Array]
    is_platform: bool
    orientation: str | None
    analysis: Mapping[str, Keyword]
    cases: tuple[int, ...]
    objective: tuple[str, float]
    requirements: Sequence[Requirement]
    tool: Array | None = None
    closure_tolerance: float = 1e-10
    known: dict[tuple[tuple[str, float], ...], Evaluation] = field(default_factory=dict)
    count: int = 0

    def at(self, parameters: Mapping[str, float]) -> Evaluation:
        """Return the analysis of the robot with these parameters: objective and margins."""
        key = tuple(sorted(parameters.items()))
        if key not in self.known:
            self.known[key] = self._evaluate(parameters)
            self.count += 1
        return self.known[key]

    def analyzed(self, robot: Robot) -> Result:
        """Return the analysis of a robot at all poses, every load case at every pose (P, …)."""
        given = {name: values.reshape(-1, *(1,) * len(self.cases)) for name, values in self.coordinates.items()}
        poses = assembled(robot, given, self.is_platform, self.orientation, self.closure_tolerance, self.analysis)
        return analyze(poses, on_failure="nan", **self.analysis)

    def _evaluate(self, parameters: Mapping[str, float]) -> Evaluation:
        try:
            result = self.analyzed(self.sizes.robot(parameters))
            tip = result.seen_from(self.tool)

            def measured(name: str, argument: float) -> Array:
                return REQUIRABLE[name].function(result, tip, argument)

            found = measured(*self.objective)
            values = [_rows(measured(item.name, item.argument)) for item in self.requirements]
        except (RobotFileError, StaticsError):
            return Evaluation(np.inf, np.array([-1.0]), None, [])
        margins = [item.margins(value).ravel() for item, value in zip(self.requirements, values, strict=True)]
        # poses without results violate every requirement; so do those without the objective
        margins.append(np.where(np.isnan(result.twist[..., 0]) | np.any(np.isnan(found), axis=-1), -1.0, 1.0).ravel())
        worst = float(np.nanmax(found)) if np.any(np.isfinite(found)) else np.inf
        return Evaluation(worst, np.concatenate(margins), result, values)


def _rows(values: Array) -> Array:
    """Return values (P, …, k) as (N, k), with poses and load cases along one axis."""
    return values.reshape(-1, values.shape[-1])


def grid_of(
    platform: Mapping[str, ArrayLike] | None, actuators: Mapping[str, ArrayLike] | None, driven: Sequence[str]
) -> tuple[dict[str, Array], bool]:
    """Return the coordinates (P,) of a grid of poses, and whether they are the platform's; default: actuators at zero.

    Raises:
        ArgumentError: both are given, or a coordinate is neither a number nor a list of numbers.
    """
    if platform is not None and actuators is not None:
        raise ArgumentError("give either platform or actuators, not both")
    what = "actuators" if platform is None else "platform"
    given = actuators if platform is None else platform
    if given is None:
        return {name: np.zeros(1) for name in driven}, False
    check_mapping(what, given, '{"z": [0.4, 0.5]}' if platform is not None else '{"slide": [0.0, 0.1]}')
    axes = []
    for name, value in given.items():
        array = np.asarray(value)
        if array.dtype.kind not in "iuf" or array.ndim > 1 or not array.size or not np.all(np.isfinite(array)):
            raise ArgumentError(f"{what}: {name} is {value!r}; it must be a number or a list of numbers [m, rad]")
        axes.append(np.atleast_1d(array.astype(float)))
    mesh = np.meshgrid(*axes, indexing="ij") if axes else []
    return {name: array.ravel() for name, array in zip(given, mesh, strict=True)}, platform is not None


def assembled(
    robot: Robot,
    coordinates: Mapping[str, Array],
    is_platform: bool,
    orientation: str | None,
    closure_tolerance: float,
    analysis: Mapping[str, object],
) -> Configuration:
    """Return a robot at coordinates of its platform, or else of its actuators, by the engine of an analysis."""
    loops = loops_for(analysis)
    if is_platform:
        return assemble(robot, None, coordinates, orientation, None, closure_tolerance, "nan", loops)
    return assemble(robot, coordinates, None, None, None, closure_tolerance, "nan", loops)


def rank(point: Evaluation) -> tuple[bool, float]:
    """Return the sort key of evaluations: feasible designs first, by objective; then infeasible designs, by violation."""
    return (not point.feasible, point.objective if point.feasible else point.violation)
