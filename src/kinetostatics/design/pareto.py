"""Pareto fronts of two quantities.

The method of ε-constraints (Y. Y. Haimes, L. S. Lasdon, D. A. Wismer, 1971): the first quantity is minimized under decreasing
limits of the second; each search begins at the previous optimum.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import whole_number
from kinetostatics.design.optimize import parse_objective, prepare
from kinetostatics.design.problem import REQUIRABLE, Problem, Requirement
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.load_case import LoadKeywords, load_case_of
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.parametric.variables import Vary, combinations
from kinetostatics.results.optimum import Optimum, ParetoFront
from kinetostatics.units import KINDS

#: Relative difference below which two points count as equal.
SAME = 1e-7
#: Largest number of points of a front.
MOST = 200


def pareto(
    robot: str | os.PathLike[str],
    vary: Vary,
    minimize: Sequence[str] = ("mass", "sag"),
    subject_to: Sequence[str] = (),
    platform: Mapping[str, ArrayLike] | None = None,
    actuators: Mapping[str, ArrayLike] | None = None,
    *,
    points: int = 10,
    orientation: str | None = None,
    parameters: Mapping[str, object] | None = None,
    platform_link: str | None = None,
    base_link: str | None = None,
    starts: int = 2,
    tool: ArrayLike | None = None,
    closure_tolerance: float = 1e-10,
    **analysis: Unpack[LoadKeywords],
) -> ParetoFront:
    """Find the Pareto front of two quantities.

    Args:
        robot, vary, subject_to, platform, actuators, orientation, parameters: see :func:`kinetostatics.optimize`.
        platform_link, base_link, tool, closure_tolerance, analysis: see :func:`kinetostatics.optimize`.
        minimize: two quantities, each with its worst value over all poses.
        points: number of designs; between the two ends, the limits of the second quantity are spaced geometrically. Without
            ranges, all values of lists and catalogues are enumerated, and all Pareto-optimal designs are returned.
        starts: number of searches for each end of the front.

    Returns:
        The designs, from the minimum of the first quantity to the minimum of the second.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        StaticsError: no parameters meet all requirements.
        KinetostaticsError: SciPy is missing; the message says how to install it.

    Examples:
        Mass of a tripod against its largest deflection:

        >>> import kinetostatics as ks
        >>> front = ks.pareto("3rps", {"rod_diameter": "60mm,80mm,100mm,120mm"}, ("mass", "deflection_any_direction(500 N)"),
        ...     platform={"z": 0.55, "rx": 0.0, "ry": 0.0})
        >>> [round(float(mass)) for mass, _ in front.objectives]  # [kg]
        [57, 86, 123, 168]
    """
    case = load_case_of(pareto, LoadKeywords, analysis)
    if isinstance(minimize, str) or not isinstance(minimize, Sequence) or len(minimize) != 2:
        raise ArgumentError(f'minimize is {minimize!r}; a front has two quantities, such as ("mass", "sag")')
    points = whole_number("points", points, 2, MOST)
    links: dict[str, str | None] = {"platform_link": platform_link, "base_link": base_link}
    workspace = platform, actuators
    first = prepare(
        robot, vary, minimize[0], subject_to, workspace, orientation, parameters, links, starts, tool, closure_tolerance, case
    )
    measured = parse_objective(minimize[1])
    if measured == first.problem.objective:
        raise ArgumentError(f'minimize is {minimize!r}; a front has two different quantities, such as ("mass", "sag")')
    second = replace(first, problem=replace(first.problem, objective=measured, evaluations={}, count=0), minimize=minimize[1])
    unit = KINDS.get(REQUIRABLE[measured[0]].kind, "")
    name = " ".join(minimize[1].split())

    solved = [first.problem, second.problem]

    def limited(limit: float) -> Problem:
        text = f"{name} < {limit:.6g} {unit}".rstrip()
        requirement = Requirement(text, *measured, True, limit)
        limited_problem = replace(first.problem, requirements=[*first.problem.requirements, requirement], evaluations={}, count=0)
        solved.append(limited_problem)
        return limited_problem

    if not first.ranges:
        problem, every = limited(1e300), combinations(first.choices)
        optima = [first.described(problem, design) for design in _undominated_designs(problem, every)]
        searched = f"all {len(every)} combinations of the listed values were tried"
    else:
        ends = []
        for search_for in (first, second):
            ends.append(search_for.optimum(search_for.problem, search_for.file_values, starts))
            if not ends[-1].feasible:
                raise StaticsError("no parameters within the bounds meet all requirements: see the report of optimize")
        most, least = _worst_second_quantity(limited(1e300), ends[0]), ends[1].objective
        problems = [limited(float(limit)) for limit in _limits(most, least, points)]
        optima = [first.described(problems[0], dict(ends[0].parameters))]
        for problem in problems[1:-1]:
            optima.append(first.optimum(problem, optima[-1].parameters, 1))
        optima.append(first.described(problems[-1], dict(ends[1].parameters)))
        if len(file_values := first.file_values) > 1:  # other designs may have the same second quantity and a smaller first one
            other = first.optimum(problems[-1], {**file_values, **ends[1].parameters}, 1)
            optima[-1] = other if other.feasible and other.objective < optima[-1].objective else optima[-1]
        searched = f"SLSQP under {points} limits of {name}, from {starts} start{'s' * (starts > 1)} at each end"
    optima = [optimum for optimum in optima if optimum.feasible]
    both = np.array([[optimum.objective, optimum.requirements[-1].worst] for optimum in optima]).reshape(-1, 2)
    kept = _undominated(both)
    units = KINDS.get(REQUIRABLE[first.problem.objective[0]].kind, ""), unit
    names = " ".join(minimize[0].split()), name
    return ParetoFront(
        tuple(optima[k] for k in kept), frozen(both[kept]), names, units, searched, sum(problem.count for problem in solved)
    )


def _worst_second_quantity(problem: Problem, optimum: Optimum) -> float:
    """Return the worst value of the second quantity of a design; the last requirement of ``problem`` limits this quantity."""
    return float(np.nanmax(problem.at(optimum.parameters).values[-1]))


def _limits(most: float, least: float, points: int) -> Array:
    """Return the limits of the second quantity, from ``most`` down to ``least``, spaced geometrically."""
    if not (0 < least < most):
        return np.full(2, max(least, most)) * (1 + SAME)
    return np.geomspace(most, least, points) * (1 + SAME / 10)


def _undominated_designs(problem: Problem, every: Sequence[dict[str, float]]) -> list[dict[str, float]]:
    """Return the feasible designs that no other design dominates."""
    feasible = [design for design in every if problem.at(design).feasible]
    if not feasible:
        raise StaticsError("none of the listed values meet all requirements: see the report of optimize")
    both = np.array([[problem.at(design).objective, float(np.nanmax(problem.at(design).values[-1]))] for design in feasible])
    return [feasible[k] for k in _undominated(both)]


def _undominated(both: Array) -> list[int]:
    """Return the indices of rows (n, 2) that no other row dominates, by increasing first column."""
    kept: list[int] = []
    for k in np.lexsort((both[:, 1], both[:, 0])).tolist():
        if not kept or both[k, 1] < both[kept[-1], 1] * (1 - SAME):
            kept.append(k)
    return kept
