"""Nonlinear programming over ranges, and enumeration of listed values.

Ranges are searched by SciPy's SLSQP (D. Kraft, A software package for sequential quadratic programming, 1988) from several
starts. Gradients are central differences of whole analyses, which agree with exact derivatives to 4e-8 and take a third of the
time (one parameter, two dozen poses). Values from lists and catalogues are enumerated. If there are ranges and lists, the listed
values are first treated as continuous; only listed values near the resulting optimum are tried. In a search, the position u of
each parameter in its range is between 0 and 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.design.problem import Problem, rank
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.parametric.variables import Choice, Range, combinations

#: Step of central differences, relative to a range.
STEP = 1e-4
#: Largest number of steps of a search, and its relative tolerance of the objective.
STEPS, CONVERGED = 60, 1e-10
#: Largest number of combinations of catalogues beside ranges.
MOST = 40
#: Distance of starting points from the edge of the unit cube.
EDGE = 0.08
#: Largest initial violation, relative to the limit, in the search for the smallest violation.
_MOST_BROKEN = 10.0


def search(
    problem: Problem, ranges: Sequence[Range], choices: Sequence[Choice], begin: Mapping[str, float], starts: int
) -> tuple[list[dict[str, float]], str]:
    """Return the parameters at the ends of all searches, and a description of the method.

    ``begin`` are the parameters at which the first search begins.
    """
    if not choices:
        ends = [_minimize(problem, ranges, {}, place) for place in _places(ranges, begin, starts)]
        return ends, f"SLSQP from {starts} start{'s' * (starts > 1)}"
    every = combinations(choices)
    if not ranges:
        return every, f"all {len(every)} combinations of the listed values were tried"
    if any(len(choice.names) > 1 for choice in choices):
        if len(every) > MOST:
            raise ArgumentError(
                f"vary: {len(every)} combinations from catalogues are too many beside ranges, {MOST} at most: shorten them"
            )
        near = every
    else:  # relaxed problem: lists as ranges
        of_lists = [Range(choice.names[0], choice.rows[0][0], choice.rows[-1][0]) for choice in choices]
        relaxed = [_minimize(problem, [*ranges, *of_lists], {}, place) for place in _places([*ranges, *of_lists], begin, starts)]
        best = min(relaxed, key=lambda end: rank(problem.at(end)))
        begin = {**begin, **best}
        near = [
            combination
            for combination in every
            if all(combination[choice.names[0]] in _neighbours(choice, best[choice.names[0]]) for choice in choices)
        ]
    ends = []
    for combination in near:
        (place,) = _places(ranges, begin, 1)
        ends.append({**_minimize(problem, ranges, combination, place), **combination})
    return ends, f"SLSQP for {len(near)} of {len(every)} combinations of the listed values"


def _neighbours(choice: Choice, value: float) -> set[float]:
    """Return three neighbouring listed values: the last below ``value`` and the first two from ``value`` on."""
    values = [row[0] for row in choice.rows]
    k = int(np.searchsorted(values, value * (1 - 1e-9)))
    return set(values[max(0, k - 1) : k + 2])


def _places(ranges: Sequence[Range], begin: Mapping[str, float], starts: int) -> list[Array]:
    """Return the starts u: the parameters ``begin``, then Halton's sequence."""
    from scipy.stats import qmc

    first = np.array([variable.place(begin[variable.name]) for variable in ranges])
    spread = qmc.Halton(len(ranges), scramble=False).random(starts)[1:] if starts > 1 else np.zeros((0, len(ranges)))
    return [np.clip(place, EDGE, 1 - EDGE) for place in (first, *spread)]


def _minimize(problem: Problem, ranges: Sequence[Range], fixed: Mapping[str, float], place: Array) -> dict[str, float]:
    """Return the parameters at the end of a search from ``place``: the optimum, or the least violation if none is feasible."""
    from scipy.optimize import minimize

    def named(u: Array) -> dict[str, float]:
        return {**fixed, **{variable.name: variable.value(float(x)) for variable, x in zip(ranges, u, strict=True)}}

    begin = problem.at(named(place))
    scale = begin.objective if np.isfinite(begin.objective) and begin.objective > 0 else 1.0
    size = begin.margins.size

    def numbers(u: Array) -> Array:
        """Return the scaled objective, and all margins."""
        point = problem.at(named(u))
        if point.margins.size != size or not np.isfinite(point.objective):
            return np.array([10.0, *np.full(size, -1.0)])
        return np.array([point.objective / scale, *point.margins])

    def slopes(u: Array) -> Array:
        """Return the gradients (1 + m, n) of the scaled objective and the m margins with respect to u (n,)."""
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
    solution = minimize(
        lambda u: numbers(u)[0],
        place,
        jac=lambda u: slopes(u)[0],
        bounds=bounds,
        constraints=[constraint],
        method="SLSQP",
        options=options,
    )
    u = np.clip(solution.x, 0, 1)
    if not problem.at(named(u)).feasible:  # closest design: maximize the smallest margin
        if begin.violation < problem.at(named(u)).violation:  # the search has increased the violation
            u = place
        slack = {
            "type": "ineq",
            "fun": lambda v: numbers(v[:-1])[1:] + v[-1],
            "jac": lambda v: np.concatenate([slopes(v[:-1])[1:], np.ones((size, 1))], axis=1),
        }
        start = np.array([*u, min(problem.at(named(u)).violation, _MOST_BROKEN)])
        nearest = minimize(
            lambda v: v[-1],
            start,
            jac=lambda v: np.eye(len(v))[-1],
            bounds=[*bounds, (0.0, _MOST_BROKEN)],
            constraints=[slack],
            method="SLSQP",
            options=options,
        )
        if problem.at(named(np.clip(nearest.x[:-1], 0, 1))).violation < problem.at(named(u)).violation:
            u = np.clip(nearest.x[:-1], 0, 1)
        if problem.at(named(u)).feasible:  # a feasible point exists
            return _minimize(problem, ranges, fixed, u) if not np.allclose(u, place) else named(u)
    return named(u)
