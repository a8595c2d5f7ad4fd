"""Objective and requirements of an optimization, such as ``sag < 20um``, as functions of the parameters of a robot.

The objective is the worst value of a quantity over all poses of a workspace. The margin of a requirement at a pose is the
distance of the value from its limit, relative to the limit, and negative if violated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check_mapping
from kinetostatics.exceptions import ArgumentError, RobotFileError, StaticsError, near_names
from kinetostatics.kinematics.assembly import assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array
from kinetostatics.measures import MEASURES, Measure
from kinetostatics.parametric.variables import VariedNumbers
from kinetostatics.results.optimum import BROKEN
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.units import KINDS, parse_number, sized_example, sized_name

_REQUIREMENT = re.compile(r"\s*([A-Za-z_]\w*)\s*(\([^()]*\)|:[^<>=≤≥]*)?\s*(<=|>=|<|>|≤|≥)\s*(.+)")


@dataclass(frozen=True)
class Requirable:
    """A quantity of poses that may be required or minimized.

    Attributes:
        kind: kind of its values, see :data:`kinetostatics.units.KINDS`; "number": dimensionless.
        function: computes its values (P, …, k) from an analysis, the same analysis at the tool's tip, and the argument; NaN at
            poses without results.
        argument: kind of the argument in brackets, if any.
        words: definition in words.
        better: whether "small" or "large" values are better.
    """

    kind: str
    function: Callable[[Result, Result, float], Array]
    argument: str | None
    words: str
    better: str = "small"


def _measured(measure: Measure) -> Requirable:
    """Return a measure of the twist or compliance at the tool's tip as a quantity that may be required or minimized."""

    def values_of(result: Result, tip: Result, size: float) -> Array:
        array = np.asarray(getattr(tip, measure.of))
        block = array[..., measure.part, measure.part] if measure.of != "twist" else array[..., measure.part]
        return measure.function(block, size or 1.0)[..., None]

    return Requirable(measure.kind, values_of, measure.argument, measure.definition, measure.better)


def _actuators(slides: bool) -> Callable[[Result, object, float], Array]:
    def largest_forces(result: Result, _: object, __: float) -> Array:
        connections = result.robot.mechanism.connections
        forces = [abs(f) for name, f in result.actuator_forces.items() if connections[name].type.is_slide == slides]
        if not forces:
            motion, alternative = ("slides", "turn: actuator_torque") if slides else ("turns", "slide: actuator_force")
            hint = f"; its actuators {alternative}" if result.actuator_forces else ""
            raise ArgumentError(f"{result.robot.name!r} has no actuator that {motion}{hint}")
        return np.stack(forces, axis=-1)

    return largest_forces


def _utilization(result: Result, _: object, __: float) -> Array:
    if not result.robot.description.actuator_limits("effort"):
        raise ArgumentError(f"no actuator of {result.robot.name!r} has an effort in its <limit>, and so no utilization")
    return np.fmax.reduce(np.stack([*result.utilization.values()], axis=-1), axis=-1)[..., None]


def _beams(attribute: str) -> Callable[[Result, object, float], Array]:
    def beam_values(result: Result, _: object, __: float) -> Array:
        if not result.beams:
            raise ArgumentError(f"{result.robot.name!r} has no beams, and so no {attribute}")
        return np.stack([getattr(beam, attribute) for beam in result.beams.values()], axis=-1)

    return beam_values


def mass_of(result: Result) -> Array:
    """Return the total mass (P,) [kg], independent of the loads."""
    configuration = result.configuration
    masses = configuration.robot.weights.masses(configuration.frames).sum(axis=0)
    pose_masses = np.where(configuration.reached, masses, np.nan).reshape(configuration.shape)
    return np.broadcast_to(pose_masses, result.shape)


#: All quantities by name.
REQUIRABLE: Mapping[str, Requirable] = {
    "mass": Requirable("mass", lambda result, _, __: mass_of(result)[..., None], None, "mass of the robot"),
    "sag": _measured(MEASURES["linear_sag"]),
    "rotation": _measured(MEASURES["angular_sag"]),
    **{name: _measured(MEASURES[name]) for name in ("deflection_any_direction", "rotation_any_direction")},
    **{name: _measured(MEASURES[name]) for name in ("least_translational_stiffness", "least_rotational_stiffness")},
    "actuator_force": Requirable("force", _actuators(True), None, "force of a sliding actuator"),
    "actuator_torque": Requirable("moment", _actuators(False), None, "torque of a turning actuator"),
    "stress": Requirable("stress", _beams("stress"), None, "largest von Mises stress of a beam"),
    "utilization": Requirable("number", _utilization, None, "ratio of an actuator's force to its limit of effort in the file"),
    "safety_factor": Requirable(
        "number",
        lambda result, _, __: result.margins.smallest[..., None],
        None,
        "smallest safety factor, against efforts of actuators, yield of beams, and buckling",
        "large",
    ),
    "buckling": Requirable("number", _beams("euler_ratio"), None, "ratio of the forces to those at which the robot buckles"),
}


@dataclass(frozen=True)
class Requirement:
    """A limit of a quantity at every pose.

    Attributes:
        argument: argument of the quantity, SI.
        below: True for an upper limit, False for a lower limit.
        limit: SI.
    """

    text: str
    name: str
    argument: float
    below: bool
    limit: float

    def margins(self, values: Array) -> Array:
        """Return the margins of values: negative if violated, −1 for NaN, at most 1000."""
        margins = 1 - values / self.limit if self.below else values / self.limit - 1
        return np.where(np.isnan(margins), -1.0, np.minimum(margins, 1e3))


def _example(name: str) -> str:
    """Return the name of a quantity, with an example of its argument if it has an argument."""
    kind = REQUIRABLE[name].argument
    return sized_example(name, KINDS[kind]) if kind else name


def parse_quantity(text: object) -> tuple[str, float]:
    """Return name and argument of a quantity such as ``deflection_any_direction(500 N)``."""
    if not isinstance(text, str):
        raise ArgumentError(
            f"minimize is {text!r}; it must be one quantity, such as 'mass'; requirements are given by subject_to"
        )
    name, argument = sized_name(text)
    if name not in REQUIRABLE:
        raise ArgumentError(f"no quantity {name!r}: {near_names(name, map(_example, REQUIRABLE))}")
    kind = REQUIRABLE[name].argument
    if (kind is None) != (argument is None):
        raise ArgumentError(f"{text.strip()!r}: write {_example(name)}" + (f", a {kind} in the brackets" if kind else ""))
    return name, parse_number(argument, kind or "", text) if argument is not None else 0.0


def parse_requirement(text: object) -> Requirement:
    match = _REQUIREMENT.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise ArgumentError(f"{text!r} is not of the form QUANTITY < LIMIT or QUANTITY > LIMIT, such as 'sag < 20um'")
    if match[1] in ("actuator_force", "actuator_torque") and match[4].strip() == "limit":
        return Requirement(" ".join(str(text).split()), "utilization", 0.0, match[3] in ("<", "<=", "≤"), 1.0)
    name, argument = parse_quantity(match[1] + (match[2] or ""))
    limit = parse_number(match[4], REQUIRABLE[name].kind, str(text))
    if not limit > 0:
        raise ArgumentError(f"{text!r}: the limit must be greater than zero")
    return Requirement(" ".join(str(text).split()), name, argument, match[3] in ("<", "<=", "≤"), limit)


@dataclass(frozen=True)
class Evaluation:
    """One robot, analysed at all poses under all load cases.

    Attributes:
        objective: value of the objective, SI; infinite if the parameters are invalid.
        margins: (m,) margins of all requirements at all poses; then, for each pose and load, −1 if the twist or the objective is
            NaN, else 1.
        result: the analysis (P, …), None if the parameters are invalid; the axes of load cases follow the axis of poses.
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
        sizes: varied numbers, and the robots with these numbers.
        coordinates: (P,) coordinates of all poses.
        is_platform: whether ``coordinates`` belong to the platform; otherwise to the actuators.
        orientation: convention of the orientation coordinates, see :meth:`Robot.assemble`.
        case: the loads, with every load case at every pose.
        cases: shape of the load cases; () for one.
        objective: name and argument of the objective.
        tool: reference point of sag, deflections and stiffness against forces; None: o.
        closure_tolerance: largest gap of a closed loop [m, rad].
        evaluations: evaluations computed so far, by parameters.
        count: number of robots analysed.
    """

    sizes: VariedNumbers
    coordinates: Mapping[str, Array]
    is_platform: bool
    orientation: str | None
    case: LoadCase
    cases: tuple[int, ...]
    objective: tuple[str, float]
    requirements: Sequence[Requirement]
    tool: Array | None = None
    closure_tolerance: float = 1e-10
    evaluations: dict[tuple[tuple[str, float], ...], Evaluation] = field(default_factory=dict)
    count: int = 0

    def at(self, parameters: Mapping[str, float]) -> Evaluation:
        key = tuple(sorted(parameters.items()))
        if key not in self.evaluations:
            self.evaluations[key] = self._evaluate(parameters)
            self.count += 1
        return self.evaluations[key]

    def analyzed(self, robot: Robot) -> Result:
        """Return the analysis (P, …) of a robot at all poses, every load case at every pose."""
        given = {name: values.reshape(-1, *(1,) * len(self.cases)) for name, values in self.coordinates.items()}
        poses = assembled(robot, given, self.is_platform, self.orientation, self.closure_tolerance, self.case)
        return analyzed(poses, self.case, "nan")

    def _evaluate(self, parameters: Mapping[str, float]) -> Evaluation:
        try:
            result = self.analyzed(self.sizes.robot(parameters))
            tip = result.seen_from(self.tool)

            def measured(name: str, argument: float) -> Array:
                quantity = REQUIRABLE[name].function(result, tip, argument)
                return quantity.reshape(-1, quantity.shape[-1])  # poses and load cases along one axis

            objective = measured(*self.objective)
            values = [measured(requirement.name, requirement.argument) for requirement in self.requirements]
        except (RobotFileError, StaticsError):
            return Evaluation(np.inf, np.array([-1.0]), None, [])
        margins = [requirement.margins(value).ravel() for requirement, value in zip(self.requirements, values, strict=True)]
        # a pose without results, or without the objective, violates all requirements
        margins.append(np.where(np.isnan(result.twist[..., 0].ravel()) | np.any(np.isnan(objective), axis=-1), -1.0, 1.0))
        worst = float(np.nanmax(objective)) if np.any(np.isfinite(objective)) else np.inf
        return Evaluation(worst, np.concatenate(margins), result, values)


def grid_of(
    platform: Mapping[str, ArrayLike] | None, actuators: Mapping[str, ArrayLike] | None, actuated: Sequence[str]
) -> tuple[dict[str, Array], bool]:
    """Return the coordinates (P,) of a grid of poses, and whether they belong to the platform.

    Without ``platform`` and ``actuators``, the coordinates of the ``actuated`` joints are zero.
    """
    if platform is not None and actuators is not None:
        raise ArgumentError("give either platform or actuators, not both")
    what = "actuators" if platform is None else "platform"
    given = actuators if platform is None else platform
    if given is None:
        return {name: np.zeros(1) for name in actuated}, False
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
    case: LoadCase,
    near: Configuration | None = None,
    on_failure: str = "nan",
) -> Configuration:
    """Return the poses of a robot at coordinates of platform or actuators; ``case``: the later analysis."""
    actuators, platform = (None, coordinates) if is_platform else (coordinates, None)
    convention = orientation if is_platform else None
    return assemble(robot, actuators, platform, convention, near, closure_tolerance, on_failure, case.loops)


def rank(point: Evaluation) -> tuple[bool, float]:
    """Return the sort key of evaluations: feasible designs first, by objective; then infeasible designs, by violation."""
    return (not point.feasible, point.objective if point.feasible else point.violation)
