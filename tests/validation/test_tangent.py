"""Stiffness under load against the second derivatives of the energy (:mod:`energy_model`), for robots of all kinds."""

import pytest
from tangent_cases import CASES, SPRUNG_CASES

import kinetostatics as ks


@pytest.mark.few(6)
@pytest.mark.parametrize("name", CASES)
def test_linear_theory_equals_energy_model(name):
    case = CASES[name]()
    result, answer = ks.analyze(case.pose, **case.arguments), case.unloaded_geometry
    assert case.difference(result.compliance, answer.linear) < 1e-7
    assert case.difference(result.twist, answer.linear_twist) < 1e-7


#: Of 3e-1 by which forces change its compliance, 7e-6 are missing.
NOT_YET = {"sprung 19"}


@pytest.mark.few(4)
@pytest.mark.parametrize("name", [name for name in SPRUNG_CASES if name not in NOT_YET])
def test_tangent_of_robots_with_springs_equals_second_derivative_of_energy(name):
    """Elastic robots with springs, two of them unstable; loads on links have no part in their stiffness."""
    case = SPRUNG_CASES[name]()
    result, answer = ks.analyze(case.pose, **case.arguments, on_failure="nan"), case.unloaded_geometry
    assert case.difference(result.compliance, answer.compliance) < 1e-6
    assert case.difference(result.twist, answer.twist) < 1e-6
    assert any("unstable" in warning for warning in result.warnings) == (answer.negative > 0)
