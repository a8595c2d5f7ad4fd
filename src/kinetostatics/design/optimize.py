"""Optimization of the parameters of a robot under requirements at every pose of a workspace.

Every requirement at every pose is a constraint of a nonlinear program; :mod:`kinetostatics.design.search` solves it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import need, warn, whole_number
from kinetostatics.design.problem import (
    REQUIRABLE,
    Evaluation,
    Problem,
    assembled,
    grid_of,
    parse_quantity,
    parse_requirement,
    rank,
)
from kinetostatics.design.search import STEP, search
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.files.bundled import robot_path
from kinetostatics.files.reader import read_robot_file
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import LoadCase, LoadKeywords, load_case_of
from kinetostatics.parametric.parametric_robot import ParametricRobot
from kinetostatics.parametric.variables import Choice, Range, VariedNumbers, Vary, read_variables, typed_units, varied_numbers
from kinetostatics.results.optimum import CheckedRequirement, Optimum, Start
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.robot import Robot
from kinetostatics.unit_hints import LONG, length_hint
from kinetostatics.units import KINDS

#: Margin, relative to the limit, below which a requirement is active.
ACTIVE = 1e-5
#: Relative difference below which values of two robots count as equal.
SAME = 1e-9
#: Relative difference of objectives below which two searches agree.
ALIKE = 1e-6


def optimize(
    robot: str | os.PathLike[str],
    vary: Vary,
    minimize: str = "mass",
    subject_to: Sequence[str] = (),
    platform: Mapping[str, ArrayLike] | None = None,
    actuators: Mapping[str, ArrayLike] | None = None,
    *,
    orientation: str | None = None,
    parameters: Mapping[str, object] | None = None,
    platform_link: str | None = None,
    base_link: str | None = None,
    starts: int = 3,
    tool: ArrayLike | None = None,
    closure_tolerance: float = 1e-10,
    **analysis: Unpack[LoadKeywords],
) -> Optimum:
    """Find the optimal parameters of a robot, under requirements at every pose of a workspace.

    Args:
        robot: the robot's file, or the name of a robot of the package.
        vary: design variables, by name of a xacro argument or of a dimension of a part (see :func:`kinetostatics.tolerances`),
            such as ``"rod_1.outer_diameter"``; with ``"rod_*.outer_diameter"``, all rods have one value. A design variable is a
            range ``"20mm:120mm"`` or ``(0.02, 0.12)``; a list of values, ``"20mm,25mm"``; or a catalogue: the path of a CSV file,
            "standard_bars" or "standard_tubes", whose rows may set several parameters: ``{("tube_diameter", "tube_wall"):
            "standard_tubes"}``.
        minimize: the quantity whose worst value over all poses is minimized: "mass", "sag", "rotation",
            "deflection_any_direction(500 N)", "rotation_any_direction(20 N·m)", "actuator_force", "actuator_torque", "stress" or
            "buckling".
        subject_to: requirements, each a limit of one of these quantities, of least_translational_stiffness or of
            least_rotational_stiffness: ``"sag < 20um"``, ``"least_translational_stiffness > 30 N/um"``.
        platform, actuators: the workspace: coordinates of the platform, or of all actuators; arrays span a grid as in
            :func:`kinetostatics.sweep`; default: the zero pose.
        orientation: convention of the orientation coordinates, see :meth:`Robot.assemble`.
        parameters: values of other arguments of the file.
        platform_link, base_link: see :func:`kinetostatics.load_robot`.
        starts: number of searches; the first begins at the parameters of the file, the others at other parameters.
        tool: (3,) point from o in platform axes [m], such as a tool's tip, to which "sag", "deflection_any_direction" and
            "least_translational_stiffness" refer; default: o. The point of application of ``load`` is ``point``.
        closure_tolerance: largest gap of a closed loop [m, rad], see :meth:`Robot.assemble`.
        analysis: arguments of :func:`kinetostatics.analyze`: ``load``, ``gravity``, …. With several loads (…, 6), each acts at
            every pose, and the requirements must be met under all of them.

    Returns:
        Parameters, objective, requirements with their worst poses, and the active requirements.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        KinetostaticsError: SciPy is missing; the message says how to install it.
        CoordinatesError: the coordinates do not determine the pose.

    Examples:
        The lightest rods for a tripod with at most 20 µm deflection under 500 N from any direction:

        >>> import kinetostatics as ks
        >>> best = ks.optimize(
        ...     "3rps", {"rod_diameter": "40mm:120mm"}, "mass", ["deflection_any_direction(500 N) < 20um"],
        ...     platform={"z": 0.55, "rx": 0.0, "ry": 0.0}, starts=1)
        >>> best.feasible, round(1e3 * best.parameters["rod_diameter"], 2), round(best.objective, 1)  # [mm], [kg]
        (True, 100.1, 122.9)
    """
    case = load_case_of(optimize, LoadKeywords, analysis)
    links: dict[str, str | None] = {"platform_link": platform_link, "base_link": base_link}
    workspace = platform, actuators
    search_for = prepare(
        robot, vary, minimize, subject_to, workspace, orientation, parameters, links, starts, tool, closure_tolerance, case
    )
    return search_for.optimum(search_for.problem, search_for.file_values, starts)


@dataclass(frozen=True)
class Search:
    """A checked optimization problem with its design variables.

    Attributes:
        file_values: values of the design variables in the file.
        minimize: the objective as given.
    """

    problem: Problem
    ranges: Sequence[Range]
    choices: Sequence[Choice]
    file_values: Mapping[str, float]
    minimize: str

    def optimum(self, problem: Problem, begin: Mapping[str, float], starts: int) -> Optimum:
        """Return the optimum; the first of the ``starts`` searches begins at the parameters ``begin``."""
        ends, searched = search(problem, self.ranges, self.choices, begin, starts)
        best = min(ends, key=lambda end: rank(problem.at(end)))
        return self.described(problem, best, ends, searched)

    def described(
        self, problem: Problem, best: dict[str, float], ends: Sequence[dict[str, float]] = (), searched: str = "listed values"
    ) -> Optimum:
        """Return the optimum at the parameters ``best``.

        ``ends`` are the parameters at the ends of all searches, ``searched`` describes the method of search.
        """
        point = problem.at(best)
        if point.result is None:
            raise StaticsError("no parameters within the bounds yield a robot that can be analysed: check the bounds of vary")
        poses = point.result.configuration.reached.size
        no_influence = _without_influence(problem, self.ranges, best, point)
        effective = [variable for variable in self.ranges if variable.name not in no_influence]
        savings, at_bounds = _multipliers(problem, effective, best, point)
        checked = []
        for demand, values, saving in zip(problem.requirements, point.values, savings, strict=True):
            extremes = values.max(axis=-1) if demand.below else values.min(axis=-1)
            # use the quantity itself, because margins are clipped far from the limit
            worst = int(np.argmax(extremes) if demand.below else np.argmin(extremes))  # argmax and argmin return NaN first
            value, margin = float(extremes[worst]), float(demand.margins(values[worst]).min())
            unit = KINDS.get(REQUIRABLE[demand.name].kind, "")
            number, *case = map(int, np.unravel_index(worst, (poses, *problem.cases)))
            pose = ResultMapping({name: float(array[number]) for name, array in problem.coordinates.items()})
            active = abs(margin) <= ACTIVE or margin < 0
            requirement = CheckedRequirement(
                demand.text, demand.name, value, demand.limit, unit, margin, pose, tuple(case), active, saving, demand.below
            )
            checked.append(requirement)
        name = problem.objective[0]
        before = problem.at(self.file_values if problem.sizes.file_is_a_design else {}).objective
        allowed: dict[str, tuple[float, ...]] = {variable.name: (variable.low, variable.high) for variable in self.ranges}
        for choice in self.choices:
            allowed |= {key: tuple(sorted({row[k] for row in choice.rows})) for k, key in enumerate(choice.names)}
        every = sorted(ends or [best], key=lambda end: rank(problem.at(end)))
        starts = [Start(ResultMapping(end), problem.at(end).objective, problem.at(end).feasible) for end in every]
        near = point.objective + ALIKE * abs(point.objective)  # no feasible start has a smaller objective
        alike = None if self.choices else sum(start.feasible and start.objective <= near for start in starts)
        return Optimum(
            point.feasible,
            ResultMapping(best),
            ResultMapping({key: problem.sizes.unit(key) for key in best}),
            ResultMapping({key: allowed[key] for key in best}),
            point.objective,
            " ".join(self.minimize.split()),
            KINDS.get(REQUIRABLE[name].kind, ""),
            before if np.isfinite(before) else float("nan"),
            tuple(checked),
            at_bounds,
            tuple(starts[: max(len(self.ranges), 1) * 10] if self.choices else starts),
            searched,
            problem.count,
            point.result.robot,
            point.result,
            poses,
            int(np.sum(point.result.configuration.limit_exceeded)),
            alike,
            no_influence,
        )


def prepare(
    robot: str | os.PathLike[str],
    vary: Vary,
    minimize: str,
    subject_to: Sequence[str],
    workspace: tuple[Mapping[str, ArrayLike] | None, Mapping[str, ArrayLike] | None],
    orientation: str | None,
    parameters: Mapping[str, object] | None,
    links: Mapping[str, str | None],
    starts: int,
    tool: ArrayLike | None,
    closure_tolerance: float,
    case: LoadCase,
) -> Search:
    """Check the arguments of :func:`optimize`; ``workspace`` is platform and actuators, ``links`` are platform and base."""
    need("optimize", "optimize", "scipy")
    ranges, choices = read_variables(vary)
    if isinstance(subject_to, str) or not isinstance(subject_to, Sequence):
        raise ArgumentError(f'subject_to is {subject_to!r}; it must be a list of requirements, such as ["sag < 20um"]')
    starts = whole_number("starts", starts, 1)
    requirements = [parse_requirement(text) for text in subject_to]
    objective = parse_objective(minimize)
    if not isinstance(robot, (str, bytes, os.PathLike)):
        raise ArgumentError(
            f"optimize needs the path of a robot's file or the name of a robot, not {robot!r}: it reads the file repeatedly"
        )
    path = os.fspath(robot_path(robot))
    first = Robot(read_robot_file(path, parameters, **links))
    names = [variable.name for variable in ranges] + [name for choice in choices for name in choice.names]
    sizes = varied_numbers(ParametricRobot(first, links), names, typed_units(ranges, choices))
    grid, is_platform = grid_of(*workspace, first.description.actuated)
    lengths = [demand for demand in requirements if demand.below and REQUIRABLE[demand.name].kind == "length"]
    limits = [(demand.text, demand.limit) for demand in lengths]
    hints = [hint for text, x in limits for hint in length_hint(f"{text} allows {x:.6g} m,", x, first.zero_size, most=1.0)]
    for hint in (*first.unit_hints(grid), *_unit_hints(sizes, ranges, choices), *hints):
        warn(hint)
    place = tool_on_robot(tool, first)
    # check coordinates and arguments before the search
    poses = assembled(first, grid, is_platform, orientation, closure_tolerance, case)
    first_pose = first.configuration(poses.q if poses.shape == () else poses.q[0], closure_tolerance=math.inf, on_failure="nan")
    cases = analyzed(first_pose, case, "nan").shape
    problem = Problem(sizes, grid, is_platform, orientation, case, cases, objective, requirements, place, closure_tolerance)
    return Search(problem, ranges, choices, {name: sizes.file_value(name) for name in names}, minimize)


def _unit_hints(sizes: VariedNumbers, ranges: Sequence[Range], choices: Sequence[Choice]) -> list[str]:
    """Return hints at ranges of lengths without a unit that are unusually large beside the file's value, as if in millimetres."""
    tried = [(variable.name, variable.low, variable.units) for variable in ranges]
    for choice in choices:
        rows = zip(choice.names, zip(*choice.rows, strict=True), choice.units, strict=False)
        tried += [(name, min(values), units) for name, values, units in rows]
    hints: list[str] = []
    for name, low, units in tried:
        what = f"{name} from {low:.6g} m is"
        if not any(units) and sizes.unit(name) == "m":
            hints += length_hint(what, low, sizes.file_value(name), "the file's own", LONG)
    return hints


def parse_objective(text: str) -> tuple[str, float]:
    objective = parse_quantity(text)
    if REQUIRABLE[objective[0]].better == "large":
        raise ArgumentError(f"{text!r} is not to be minimized; require it: {objective[0]} > …")
    return objective


def _without_influence(
    problem: Problem, ranges: Sequence[Range], best: Mapping[str, float], point: Evaluation
) -> tuple[str, ...]:
    """Return the names of ranges at both ends of which objective and margins are the same as at the optimum."""

    def same(variable: Range, u: float) -> bool:
        other = problem.at({**best, variable.name: variable.value(u)})
        return other.margins.size == point.margins.size and np.allclose(
            [other.objective, *other.margins], [point.objective, *point.margins], rtol=SAME, atol=SAME
        )

    names = []
    for variable in ranges:
        u = variable.place(best[variable.name])
        # nearby values first, which are cached or needed later
        if all(same(variable, place) for place in (max(u - STEP, 0.0), min(u + STEP, 1.0), 0.0, 1.0)):
            names.append(variable.name)
    return tuple(names)


def _multipliers(
    problem: Problem, ranges: Sequence[Range], best: Mapping[str, float], point: Evaluation
) -> tuple[list[float], tuple[str, ...]]:
    """Return the objective saved by relaxing each requirement by 1 %, and texts that name the parameters at a bound.

    At the optimum, the gradient of the objective is a combination of the gradients of the active margins. The multipliers are the
    coefficients of this combination, found by least squares as numbers ≥ 0.
    """
    from scipy.optimize import nnls

    places = {variable.name: variable.place(best[variable.name]) for variable in ranges}
    is_low = {name: u < 0.5 for name, u in places.items() if min(u, 1 - u) < 1e-6}
    at_bounds = tuple(f"{name} at its {'lower' if low else 'upper'} bound" for name, low in is_low.items())
    sizes = [values.size for values in point.values]
    owner = np.repeat(np.arange(len(sizes)), sizes)
    active = np.flatnonzero(point.margins[: owner.size] <= ACTIVE)
    if not ranges or not active.size:
        return [0.0] * len(sizes), at_bounds
    columns, bounds = [], []
    for k, variable in enumerate(ranges):
        low, high = (min(max(places[variable.name] + sign * STEP, 0.0), 1.0) for sign in (-1, 1))
        below, above = (problem.at({**best, variable.name: variable.value(u)}) for u in (low, high))
        if below.margins.size != point.margins.size or above.margins.size != point.margins.size:
            return [0.0] * len(sizes), at_bounds
        change = [above.objective - below.objective, *(above.margins - below.margins)[active]]
        columns.append(np.array(change) / (high - low))
        if variable.name in is_low:
            bounds.append(np.eye(len(ranges))[k] * (1.0 if is_low[variable.name] else -1.0))
    gradient = np.array([column[0] for column in columns])
    normals = np.stack([column[1:] for column in columns])
    if bounds:
        normals = np.concatenate([normals, np.array(bounds).T], axis=1)
    multipliers, _ = nnls(normals, gradient)
    savings = [0.01 * float(multipliers[: active.size][owner[active] == k].sum()) for k in range(len(sizes))]
    return savings, at_bounds
