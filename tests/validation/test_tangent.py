"""Stiffness under load against the second derivatives of the energy (:mod:`energy_model`), for robots of all kinds."""

import pytest
from tangent_cases import CASES

import kinetostatics as ks


@pytest.mark.few(6)
@pytest.mark.parametrize("name", CASES)
def test_linear_theory_equals_energy_model(name):
    case = CASES[name]()
    result, answer = ks.analyze(case.pose, **case.arguments), case.unloaded_geometry
    assert case.difference(result.compliance, answer.linear) < 1e-7
    assert case.difference(result.twist, answer.linear_twist) < 1e-7
