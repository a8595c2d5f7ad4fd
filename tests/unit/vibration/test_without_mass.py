"""Rods without mass vibrate by the masses on them; what has no mass has no modes, and no warning of NumPy tells of it."""

import warnings

import numpy as np
import pytest
from simple_machines import joint, link, robot

import kinetostatics as ks


@pytest.fixture(autouse=True)
def warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def mast(mass, foot="fixed"):
    """An upright rod without mass, and a mass at its top with moments of inertia of 1 kg·m²."""
    beam = '<beam link="rod" from="foot" to="head" density="0" youngs_modulus="2e11" poisson_ratio="0.3" shear_coefficient="0.9">'
    parts = link("base"), link("rod"), link("platform", mass), joint("foot", foot, "base", "rod")
    return robot(*parts, joint("head", "fixed", "rod", "platform", "0 0 0.8"), f'{beam}<circle diameter="0.03"/></beam>')


def test_body_on_a_rod_without_mass_has_six_modes():
    """Those of its own mass on the compliance of the rod; no others exist."""
    pose, mass = mast(3.0).assemble(), np.diag([3.0] * 3 + [1.0] * 3)
    found = ks.modes(pose, 8)
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, ks.analyze(pose).stiffness)).real)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies[:6], expected, rtol=1e-9)
    assert np.isinf(found.frequencies[6:]).all() and found.zero_frequencies == 0
    shares = found.kinetic_energy_shares
    np.testing.assert_allclose(shares["platform"][:6], 1.0, rtol=1e-12)
    np.testing.assert_allclose(shares["beam rod"][:6], 0.0, atol=1e-12)
    assert all(np.isnan(share[6:]).all() for share in shares.values())


@pytest.mark.parametrize("foot", ["fixed", "continuous"])
def test_robots_without_mass_have_no_modes(foot):
    found = ks.modes(mast(0.0, foot).assemble(), 3)
    assert np.isinf(found.frequencies).all() and found.zero_frequencies == 0
    assert all(np.isnan(share).all() for share in found.kinetic_energy_shares.values())
