"""Stiffness under load against an energy model with large rotations (:mod:`energy_model`), for robots of all kinds."""

import pytest
from tangent_cases import CASES, SPRUNG_CASES

import kinetostatics as ks
from kinetostatics.statics.second_order import tangent_of

#: Its tangent differs by 1.3e-6.
LESS_ACCURATE = {"hybrid 57"}
#: Their displacement is far from linear: with one Newton step more it is right.
FAR_FROM_LINEAR = {"tricept", "hybrid 34"}


def but(cases, others):
    return [name for name in cases if name not in others]


@pytest.mark.few(4)
@pytest.mark.parametrize("name", CASES)
def test_linear_theory_equals_energy_model(name):
    case = CASES[name]()
    result, answer = ks.analyze(case.pose, **case.arguments), case.unloaded_geometry
    assert case.difference(result.compliance, answer.linear) < 1e-7
    assert case.difference(result.twist, answer.linear_twist) < 1e-7


@pytest.mark.few(4)
@pytest.mark.parametrize("name", but(CASES, LESS_ACCURATE))
def test_tangent_at_the_unloaded_geometry_equals_second_derivative_of_energy(name):
    """Forces and moments of beams and joints, under loads with moments, some of them on links."""
    case = CASES[name]()
    solution, answer = ks.analyze(case.pose, **case.arguments).solutions[0], case.unloaded_geometry
    found = tangent_of(case.pose.robot.statics, case.pose.robot.members.structure.rotation_groups, solution)
    assert case.difference(found.compliance[..., 0], answer.compliance) < 1e-6
    assert case.difference(found.twist[:, 0], answer.twist) < 1e-6


@pytest.mark.few(4)
@pytest.mark.parametrize("name", but(CASES, FAR_FROM_LINEAR))
def test_second_order_equals_nonlinear_equilibrium(name):
    case = CASES[name]().with_small_motions
    found, answer = ks.analyze(case.pose, **case.arguments).second_order, case.equilibrium
    assert answer.turn < 0.03
    assert case.difference(found.compliance, answer.compliance) < 0.02
    assert case.difference(found.twist, answer.twist) < 0.02


@pytest.mark.few(4)
@pytest.mark.parametrize("name", SPRUNG_CASES)
def test_tangent_of_robots_with_springs_equals_second_derivative_of_energy(name):
    """Elastic robots with springs, two of them unstable; loads on links have no part in their stiffness."""
    case = SPRUNG_CASES[name]()
    result, answer = ks.analyze(case.pose, **case.arguments, on_failure="nan"), case.unloaded_geometry
    assert case.difference(result.compliance, answer.compliance) < 1e-6
    assert case.difference(result.twist, answer.twist) < 1e-6
    assert any("unstable" in warning for warning in result.warnings) == (answer.negative > 0)
