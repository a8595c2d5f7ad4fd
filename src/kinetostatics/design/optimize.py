"""The best parameters of a robot's file, under requirements that hold at every pose of a workspace.

Every requirement at every pose is a constraint of a nonlinear program, which SciPy's SLSQP solves (D. Kraft, A software package
for sequential quadratic programming, 1988) from several starts, with central differences of whole analyses as gradients. Values
from lists and catalogues are tried one by one, or, where ranges are varied too, around the optimum that lets them be anything
between.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze
from kinetostatics.argument_checks import check_mapping
from kinetostatics.description.units import KINDS
from kinetostatics.design.requirements import MEASURES, Requirement, parse_measure, parse_requirement
from kinetostatics.design.variables import Choice, Range, combinations, read_variables
from kinetostatics.design.variants import Variants
from kinetostatics.exceptions import ArgumentError, KinetostaticsError, RobotFileError, StaticsError
from kinetostatics.files.bundled import robot_path
from kinetostatics.kinematics.assembly import assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.printing.mappings import Named
from kinetostatics.results.optimum import CheckedRequirement, Optimum, Start
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot

#: Half the distance of central differences, as part of a range.
STEP = 1e-4
#: Broken requirements up to this part of the limit count as rounding, and margins up to the second as none.
BROKEN, ACTIVE = 1e-6, 1e-5
#: Steps of a search, and how well it converges: parts of the objective.
STEPS, CONVERGED = 60, 1e-10
#: Combinations of listed values that are tried, at most.
MOST = 2000
#: How far a point may come from the edge of the unit cube where a search begins.
EDGE = 0.08


@dataclass
class _Point:
    """One robot, analysed at all poses.

    Attributes:
        objective: SI; infinite if there is no robot.
        margins: of all requirements at all poses, flat.
        result: of the analysis, None if there is no robot.
        values: of each requirement (P, k).
    """

    objective: float
    margins: Array
    result: Result | None
    values: list[Array]

    @property
    def violation(self) -> float:
        """By how much the worst requirement is broken, as part of its limit."""
        return max(0.0, -float(self.margins.min(initial=0.0)))

    @property
    def feasible(self) -> bool:
        return self.result is not None and self.violation <= BROKEN


@dataclass
class _Problem:
    """Objective and margins as functions of parameters; what was computed once is kept."""

    variants: Variants
    over: Mapping[str, Array]
    is_platform: bool
    orientation: str | None
    analysis: Mapping[str, Any]
    objective: tuple[str, float]
    requirements: Sequence[Requirement]
    known: dict[tuple[tuple[str, float], ...], _Point] = field(default_factory=dict)
    count: int = 0

    def at(self, parameters: Mapping[str, float]) -> _Point:
        """Return the robot with these parameters."""
        key = tuple(sorted(parameters.items()))
        if key not in self.known:
            self.known[key] = self._evaluate(parameters)
            self.count += 1
        return self.known[key]

    def _evaluate(self, parameters: Mapping[str, float]) -> _Point:
        try:
            robot = self.variants.robot(parameters)
            given: tuple[Any, Any, str | None] = (
                (None, self.over, self.orientation) if self.is_platform else (self.over, None, None)
            )
            pose = assemble(robot, *given, None, 1e-10, "nan")
            result = analyze(pose, on_failure="nan", **self.analysis)
            name, argument = self.objective
            found = MEASURES[name].function(result, argument)
            values = [_rows(MEASURES[item.name].function(result, item.argument)) for item in self.requirements]
        except (RobotFileError, StaticsError):
            return _Point(np.inf, np.array([-1.0]), None, [])
        margins = [item.margins(value).ravel() for item, value in zip(self.requirements, values, strict=True)]
        # poses without numbers break the robot, whatever is asked of it
        margins.append(np.where(np.isnan(result.twist[..., 0]), -1.0, 1.0).ravel())
        worst = float(np.nanmax(found)) if np.any(np.isfinite(found)) else np.inf
        return _Point(worst, np.concatenate(margins), result, values)


def optimize(
    robot: str | os.PathLike[str],
    vary: Mapping[Any, object],
    minimize: str = "mass",
    subject_to: Sequence[str] = (),
    over: Mapping[str, ArrayLike] | None = None,
    *,
    orientation: str | None = None,
    parameters: Mapping[str, object] | None = None,
    platform_link: str | None = None,
    base_link: str | None = None,
    starts: int = 3,
    **analysis: Any,
) -> Optimum:
    """Find the parameters of a robot's file that are best, under requirements that hold at every pose of a workspace.

    Args:
        robot: the robot's file, or the name of one that comes with the package.
        vary: what may change, by the name of a xacro argument: a range ``"20mm:120mm"`` or ``(0.02, 0.12)``; values,
            ``"20mm,25mm"`` or a list; or a catalogue of standard sizes, the path of a CSV file, "standard_bars" or
            "standard_tubes", whose rows may set several arguments: ``{("tube_diameter", "tube_wall"): "standard_tubes"}``.
        minimize: the quantity whose worst pose is minimized: "mass", "sag", "rotation", "deflection_any_direction(500 N)",
            "rotation_any_direction(20 N·m)", "actuator_force", "actuator_torque", "stress" or "buckling".
        subject_to: requirements: one of these quantities, or least_translational_stiffness or least_rotational_stiffness, and
            its limit: ``"sag < 20um"``, ``"least_translational_stiffness > 30 N/um"``.
        over: the workspace: coordinates of the platform, or of all drives, as :func:`kinetostatics.sweep` takes them: arrays span
            a grid; default: the zero pose.
        orientation: what the orientation's coordinates mean, see :meth:`Robot.assemble`.
        parameters: values of other arguments of the file.
        platform_link, base_link: as ``platform`` and ``base`` of :func:`kinetostatics.load_robot`.
        starts: how many searches, from different parameters: the file's own first.
        analysis: whatever :func:`kinetostatics.analyze` takes: ``load``, ``gravity``, ….

    Returns:
        Parameters, objective, whether all requirements hold, which of them decide, and where.

    Raises:
        ArgumentError: an argument makes no sense.
        KinetostaticsError: SciPy is missing; the message says how to install it.
        CoordinatesError: the coordinates do not determine the pose.

    Example:
        The lightest rods with which the tripod gives way by 20 µm at most under 500 N from any direction:

        >>> import kinetostatics as ks
        >>> best = ks.optimize(
        ...     "3rps", {"rod_diameter": "40mm:120mm"}, "mass", ["deflection_any_direction(500 N) < 20um"],
        ...     over={"z": 0.55, "rx": 0.0, "ry": 0.0}, starts=1)
        >>> best.feasible, round(1e3 * best.parameters["rod_diameter"], 2), round(best.objective, 1)  # [mm], [kg]
        (True, 100.1, 122.9)
    """
    try:
        import scipy.optimize  # noqa: F401
    except ModuleNotFoundError:
        raise KinetostaticsError("optimize needs SciPy: pip install 'kinetostatics[optimize]'") from None
    ranges, choices = read_variables(vary)
    if isinstance(subject_to, str) or not isinstance(subject_to, Sequence):
        raise ArgumentError(f'subject_to is {subject_to!r}; it must be a list of requirements, such as ["sag < 20um"]')
    if isinstance(starts, bool) or not isinstance(starts, int) or starts < 1:
        raise ArgumentError(f"starts is {starts!r}; it must be a number of searches, at least 1")
    requirements = [parse_requirement(text) for text in subject_to]
    objective = parse_measure(minimize)
    if objective[0].startswith("least"):
        raise ArgumentError(f"{minimize!r} is not to be minimized; require it: {objective[0]} > …")
    path = os.fspath(robot_path(robot))
    variants = Variants(path, parameters or {}, {"platform": platform_link, "base": base_link})
    names = [item.name for item in ranges] + [name for item in choices for name in item.names]
    variants.check(names)
    first = variants.robot({})
    grid, is_platform = _grid(over, first.description.driven)
    problem = _Problem(variants, grid, is_platform, orientation, analysis, objective, requirements)
    # complaints about coordinates and arguments come before the search
    analyze(_poses(first, grid, is_platform, orientation), on_failure="nan", **analysis)
    own = {name: variants.numbers[name] for name in names}
    ends, searched = _search(problem, ranges, choices, own, starts)
    best = min(ends, key=lambda found: _rank(problem.at(found)))
    return _optimum(problem, ranges, best, ends, searched, own, minimize)


def _poses(robot: Robot, over: Mapping[str, Array], is_platform: bool, orientation: str | None) -> Configuration:
    """Return all poses (P,) of a robot."""
    if is_platform:
        return assemble(robot, None, over, orientation, None, 1e-10, "nan")
    return assemble(robot, over, None, None, None, 1e-10, "nan")


def _rows(values: Array) -> Array:
    """Return the numbers of all poses (P, k)."""
    return values.reshape(-1, values.shape[-1])


def _grid(over: Mapping[str, ArrayLike] | None, driven: Sequence[str]) -> tuple[dict[str, Array], bool]:
    """Return the coordinates (P,) of all poses, and whether they are the platform's."""
    if over is None:
        return {name: np.zeros(1) for name in driven}, False
    check_mapping("over", over, '{"z": [0.4, 0.5]}')
    axes = []
    for name, value in over.items():
        array = np.asarray(value)
        if array.dtype.kind not in "iuf" or array.ndim > 1 or not array.size or not np.all(np.isfinite(array)):
            raise ArgumentError(f"over: {name} is {value!r}; it must be a number or a list of numbers [m, rad]")
        axes.append(np.atleast_1d(array.astype(float)))
    mesh = np.meshgrid(*axes, indexing="ij") if axes else []
    return {name: array.ravel() for name, array in zip(over, mesh, strict=True)}, not set(over) <= set(driven) or not over


def _rank(point: _Point) -> tuple[bool, float]:
    """Return what puts feasible points first, the lightest of them before others, and the least broken before the rest."""
    return (not point.feasible, point.objective if point.feasible else point.violation)


# ---- searching -------------------------------------------------------------------------------------------------------


def _search(
    problem: _Problem, ranges: Sequence[Range], choices: Sequence[Choice], own: Mapping[str, float], starts: int
) -> tuple[list[dict[str, float]], str]:
    """Return where all searches ended, and how was searched."""
    if not choices:
        ends = [_minimize(problem, ranges, {}, place) for place in _places(ranges, own, starts)]
        return ends, f"SLSQP from {starts} start{'s' * (starts > 1)}"
    every = combinations(choices)
    if not ranges:
        if len(every) > MOST:
            raise ArgumentError(f"vary: the lists have {len(every):,} combinations, more than {MOST:,}; give ranges instead")
        return every, f"all {len(every)} combinations of the listed values were tried"
    if any(len(item.names) > 1 for item in choices):
        if len(every) > MOST // 50:
            raise ArgumentError(
                f"vary: {len(every)} combinations from catalogues are too many beside ranges, {MOST // 50} at most: shorten them"
            )
        near = every
    else:  # let the lists be ranges first
        loose = [Range(item.names[0], item.rows[0][0], item.rows[-1][0]) for item in choices]
        relaxed = [_minimize(problem, [*ranges, *loose], {}, place) for place in _places([*ranges, *loose], own, starts)]
        best = min(relaxed, key=lambda found: _rank(problem.at(found)))
        own = {**own, **best}
        near = [
            combination
            for combination in every
            if all(combination[item.names[0]] in _neighbours(item, best[item.names[0]]) for item in choices)
        ]
    ends = []
    for combination in near:
        (place,) = _places(ranges, own, 1)
        ends.append({**_minimize(problem, ranges, combination, place), **combination})
    return ends, f"SLSQP for {len(near)} of {len(every)} combinations of the listed values"


def _neighbours(choice: Choice, value: float) -> set[float]:
    """Return the listed values on either side of a value, and one more above."""
    values = [row[0] for row in choice.rows]
    k = int(np.searchsorted(values, value * (1 - 1e-9)))
    return set(values[max(0, k - 1) : k + 2])


def _places(ranges: Sequence[Range], own: Mapping[str, float], starts: int) -> list[Array]:
    """Return where searches begin, in the unit cube: at the file's own values, then spread by Halton's sequence."""
    from scipy.stats import qmc

    first = np.array([item.place(own[item.name]) for item in ranges])
    spread = qmc.Halton(len(ranges), scramble=False).random(starts)[1:] if starts > 1 else np.zeros((0, len(ranges)))
    return [np.clip(place, EDGE, 1 - EDGE) for place in (first, *spread)]


def _minimize(problem: _Problem, ranges: Sequence[Range], fixed: Mapping[str, float], place: Array) -> dict[str, float]:
    """Return where a search ends; where nothing is feasible, where the worst requirement is broken least."""
    from scipy.optimize import minimize

    def named(u: Array) -> dict[str, float]:
        return {**fixed, **{item.name: item.value(float(x)) for item, x in zip(ranges, u, strict=True)}}

    begin = problem.at(named(place))
    scale = begin.objective if np.isfinite(begin.objective) and begin.objective > 0 else 1.0
    size = begin.margins.size

    def numbers(u: Array) -> Array:
        """Return the scaled objective, and all margins."""
        point = problem.at(named(np.clip(u, 0, 1)))
        if point.margins.size != size or not np.isfinite(point.objective):
            return np.array([10.0, *np.full(size, -1.0)])
        return np.array([point.objective / scale, *point.margins])

    def slopes(u: Array) -> Array:
        """Return their gradients (1 + m, n)."""
        columns = []
        for k in range(len(u)):
            ends = [np.array(u), np.array(u)]
            for end, sign in zip(ends, (-1, 1), strict=True):
                end[k] = min(max(end[k] + sign * STEP, 0.0), 1.0)
            columns.append((numbers(ends[1]) - numbers(ends[0])) / (ends[1][k] - ends[0][k]))
        return np.stack(columns, axis=1)

    options = {"maxiter": STEPS, "ftol": CONVERGED}
    constraint = {"type": "ineq", "fun": lambda u: numbers(u)[1:], "jac": lambda u: slopes(u)[1:]}
    bounds = [(0.0, 1.0)] * len(ranges)
    found = minimize(
        lambda u: numbers(u)[0],
        place,
        jac=lambda u: slopes(u)[0],
        bounds=bounds,
        constraints=[constraint],
        method="SLSQP",
        options=options,
    )
    u = np.clip(found.x, 0, 1)
    if not problem.at(named(u)).feasible:  # what comes nearest: the largest smallest margin
        slack = {
            "type": "ineq",
            "fun": lambda v: numbers(v[:-1])[1:] + v[-1],
            "jac": lambda v: np.concatenate([slopes(v[:-1])[1:], np.ones((size, 1))], axis=1),
        }
        start = np.array([*u, problem.at(named(u)).violation])
        nearest = minimize(
            lambda v: v[-1],
            start,
            jac=lambda v: np.eye(len(v))[-1],
            bounds=[*bounds, (0.0, 10.0)],
            constraints=[slack],
            method="SLSQP",
            options=options,
        )
        if problem.at(named(np.clip(nearest.x[:-1], 0, 1))).violation < problem.at(named(u)).violation:
            u = np.clip(nearest.x[:-1], 0, 1)
        if problem.at(named(u)).feasible:  # it was only the first search that failed
            return _minimize(problem, ranges, fixed, u) if not np.allclose(u, place) else named(u)
    return named(u)


# ---- the verdict -----------------------------------------------------------------------------------------------------


def _optimum(
    problem: _Problem,
    ranges: Sequence[Range],
    best: dict[str, float],
    ends: Sequence[dict[str, float]],
    searched: str,
    own: Mapping[str, float],
    minimize: str,
) -> Optimum:
    point = problem.at(best)
    if point.result is None:
        raise StaticsError("no parameters within the bounds make a robot that can be analysed: look at the bounds of vary")
    savings, at_bounds = _multipliers(problem, ranges, best, point)
    checked = []
    for item, values, saving in zip(problem.requirements, point.values, savings, strict=True):
        margins = item.margins(values).min(axis=-1)
        worst = int(np.argmin(margins))
        row = values[worst]
        value = float(np.nan if np.any(np.isnan(row)) else row.max() if item.below else row.min())
        margin = float(margins[worst])
        unit = KINDS.get(MEASURES[item.name].kind, "")
        pose = {name: float(array[worst]) for name, array in problem.over.items()}
        active = abs(margin) <= ACTIVE or margin < 0
        checked.append(CheckedRequirement(item.text, item.name, value, item.limit, unit, margin, Named(pose), active, saving))
    name = problem.objective[0]
    before = problem.at(own).objective
    every = sorted(ends, key=lambda found: _rank(problem.at(found)))[: max(len(ranges), 1) * 10]
    return Optimum(
        point.feasible,
        Named(best),
        Named({key: problem.variants.unit(key) for key in best}),
        point.objective,
        " ".join(minimize.split()),
        KINDS.get(MEASURES[name].kind, ""),
        before if np.isfinite(before) else float("nan"),
        tuple(checked),
        at_bounds,
        tuple(Start(Named(end), problem.at(end).objective, problem.at(end).feasible) for end in every),
        searched,
        problem.count,
        point.result.robot,
        point.result,
        int(point.result.status.size),
        int(np.sum(point.result.limit_exceeded)),
    )


def _multipliers(
    problem: _Problem, ranges: Sequence[Range], best: Mapping[str, float], point: _Point
) -> tuple[list[float], tuple[str, ...]]:
    """Return what one per cent looser saves of the objective, for each requirement, and which parameters are at a bound.

    At the optimum the objective's gradient is a sum of those of the active margins with multipliers ≥ 0: least squares.
    """
    from scipy.optimize import nnls

    places = {item.name: item.place(best[item.name]) for item in ranges}
    at_bounds = tuple(
        f"{name} at its {'lower' if u < 0.5 else 'upper'} bound" for name, u in places.items() if min(u, 1 - u) < 1e-6
    )
    sizes = [values.size for values in point.values]
    owner = np.repeat(np.arange(len(sizes)), sizes)
    active = np.flatnonzero(point.margins[: owner.size] <= ACTIVE)
    if not ranges or not active.size:
        return [0.0] * len(sizes), at_bounds
    columns, bounds = [], []
    for k, item in enumerate(ranges):
        low, high = (min(max(places[item.name] + sign * STEP, 0.0), 1.0) for sign in (-1, 1))
        below, above = (problem.at({**best, item.name: item.value(u)}) for u in (low, high))
        if below.margins.size != point.margins.size or above.margins.size != point.margins.size:
            return [0.0] * len(sizes), at_bounds
        change = [above.objective - below.objective, *(above.margins - below.margins)[active]]
        columns.append(np.array(change) / (high - low))
        if min(places[item.name], 1 - places[item.name]) < 1e-6:
            bounds.append(np.eye(len(ranges))[k] * (1.0 if places[item.name] < 0.5 else -1.0))
    gradient = np.array([column[0] for column in columns])
    normals = np.stack([column[1:] for column in columns])
    if bounds:
        normals = np.concatenate([normals, np.array(bounds).T], axis=1)
    multipliers, _ = nnls(normals, gradient)
    found = [0.01 * float(multipliers[: active.size][owner[active] == k].sum()) for k in range(len(sizes))]
    return found, at_bounds
