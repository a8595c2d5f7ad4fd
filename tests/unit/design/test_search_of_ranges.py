"""Searches over ranges: optima of smooth problems with closed forms, and the least violation where nothing is feasible."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.design.search import search
from kinetostatics.parametric.variables import Range


def problem(objective, *margins):
    """Return a problem with an objective and margins that are functions of the parameters a and b."""

    def at(parameters):
        values = np.array([margin(**parameters) for margin in margins])
        violation = max(0.0, -float(values.min(initial=0.0)))
        return SimpleNamespace(objective=objective(**parameters), margins=values, violation=violation, feasible=violation == 0.0)

    return SimpleNamespace(at=at)


def end_of_search(given):
    ends, _ = search(given, [Range("a", -1.0, 1.0), Range("b", -1.0, 1.0)], [], {"a": -0.5, "b": 0.5}, 1)
    return ends[0]


@pytest.mark.parametrize("power", [1, 2])
def test_search_ends_at_the_minimum_of_a_curved_valley(power):
    """Two terms that vanish at (0.4, 0.16), with b = a² in the valley between steep walls."""
    found = end_of_search(problem(lambda a, b: 1 + (a - 0.4) ** 2 + 10**power * (b - a**2) ** 2))
    assert found == pytest.approx({"a": 0.4, "b": 0.16}, abs=2e-5)


def test_search_leaves_a_start_whose_objective_is_infinite():
    """As of a quantity that has no finite value in the file's robot alone; the search has no scale by it."""
    found = end_of_search(
        problem(lambda a, b: np.inf if np.hypot(a + 0.5, b - 0.5) < 1e-9 else 1 + (a - 0.4) ** 2 + 2 * (b - 0.1) ** 2)
    )
    assert found == pytest.approx({"a": 0.4, "b": 0.1}, abs=2e-5)


def test_least_violation_is_found_in_all_parameters():
    """Two margins −0.5 − (a − 0.4)² ∓ (b + 0.3): the larger violation is least, 0.5, where both are equal."""
    found = end_of_search(
        problem(
            lambda a, b: 2 + a - b,
            lambda a, b: -0.5 - (a - 0.4) ** 2 - (b + 0.3),
            lambda a, b: -0.5 - (a - 0.4) ** 2 + (b + 0.3),
        )
    )
    assert found == pytest.approx({"a": 0.4, "b": -0.3}, abs=1e-3)
