"""Which parameters of a robot's file are best, and how sure that is; :func:`kinetostatics.optimize` finds them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

from kinetostatics.files.writer import save_robot
from kinetostatics.layout.report import Reported
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
        saving: by how much the objective would fall if the limit were one per cent looser, as far as the multiplier tells.
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
    """Where one of several searches began, and what it found.

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
    """What :func:`kinetostatics.optimize` found.

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
