"""Formulas of beams against the integrals of their section wrenches, at random loads and sections."""

import numpy as np
import pytest

from kinetostatics.elements import beam_formulas as beams

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def integral(function, upper):
    """Return the integral from 0 to ``upper``, exact for polynomials of degree 11."""
    return sum(weight * upper / 2 * function(upper / 2 * (1 + node)) for node, weight in zip(NODES, WEIGHTS, strict=True))


@pytest.fixture(params=range(3))
def beam(request):
    random = np.random.default_rng(request.param)
    return random.uniform(0.5, 2, 6), random.uniform(0.3, 3), random.standard_normal(6), random.standard_normal(6)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 1.0])
def test_section_wrench_balances_outboard_loads(beam, fraction):
    _, L, wrench, load = beam
    s = fraction * L
    found = beams.section_wrench(L, wrench, load, s)
    load, even = (L - s) * load[:3], (L - s) * load[3:]
    force = wrench[:3] + load
    moment = wrench[3:] + np.cross([L - s, 0, 0], wrench[:3]) + np.cross([(L - s) / 2, 0, 0], load) + even
    np.testing.assert_allclose(found, [*force, *moment], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.8, 1.0])
def test_bent_line_integrates_section_deformations(beam, fraction):
    """Every slice stretches, shears, twists and bends by c w, and its rotation moves everything outboard of it."""
    c, L, wrench, load = beam
    end = fraction * L

    def given(s):
        d = c * beams.section_wrench(L, wrench, load, s)
        return np.concatenate([d[:3] + np.cross(d[3:], [end - s, 0, 0]), d[3:]])

    np.testing.assert_allclose(beams.bent_line(c, L, wrench, load, end), integral(given, end), rtol=1e-11, atol=1e-13)


def test_end_displacement_equals_end_of_bent_line(beam):
    c, L, wrench, load = beam
    line = beams.bent_line(c, L, wrench, load, L)
    np.testing.assert_allclose(beams.end_displacement(c, L, wrench[:, None])[:, 0] + beams.sag(c, L, load), line, rtol=1e-12)


def test_strain_energy_equals_integral_over_sections(beam):
    c, L, wrench, load = beam
    slices = integral(lambda s: float(c @ beams.section_wrench(L, wrench, load, s) ** 2) / 2, L)
    found = beams.strain_energy(c, L, lambda part: beams.section_wrench(L, wrench[:, None], load[:, None], L * part))
    assert found == pytest.approx(slices, rel=1e-12)
