"""The energy model with large rotations (:mod:`energy_model`) against closed forms; it judges the package in ``test_tangent``."""

from dataclasses import replace

import energy_model as em
import numpy as np
import package_robots
import pytest
import small_robots as sr
from energy_structure import structure_of
from mechanisms import Beam, Edge, Joint, Link, Mechanism, Section, write_mechanism
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc, jv

E, NU, L = 200e9, 0.3, 1.3
G = E / (2 * (1 + NU))
#: Weak about z, without shear unless given.
STRIP = Section(1e-3, 4e-7, 1e-7, 2e-7)
EI_Y, EI_Z, GJ = E * STRIP.I_y, E * STRIP.I_z, G * STRIP.J
X, Y, Z = np.eye(3)


def strut(foot="F", guide=None, section=STRIP, kappa=np.inf, density=0.0, elastic=None):
    """Return the pose of a beam along x: its foot a joint of the base, the platform at its end.

    ``guide`` holds the platform: "x": it slides along x; "ball": its end stays on the line; "shaft": it slides and turns about x.
    """
    tip = (L, 0, 0)
    edges = [Edge(Joint("foot", foot, (0, 0, 0), (0, 1, 0), (0, 0, 1), stiffness=elastic), "base", "arm")]
    edges += [Edge(Joint("head", "F", tip), "arm", "platform")]
    links, cuts = [Link("arm")], set()
    if guide in ("x", "shaft"):
        edges += [Edge(Joint("guide", "P" if guide == "x" else "C", tip, (1, 0, 0)), "base", "platform")]
        cuts = {"guide"}
    elif guide is not None:
        edges += [Edge(Joint("guide", "P", tip, (1, 0, 0)), "base", "block")]
        edges += [Edge(Joint("end", "S" if guide == "ball" else "U", tip, (0, 1, 0), (0, 0, 1)), "block", "platform")]
        links, cuts = [Link("arm"), Link("block")], {"end"}
    beams = (Beam("arm", "arm", "foot", "head", section, E, NU, density, kappa, (0, 1, 0)),)
    return write_mechanism(Mechanism(tuple(edges), tuple(links), beams, tip), cuts=cuts).robot().assemble()


def factor(pose, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, 0), **more):
    return float(em.load_factors(structure_of(pose, load, gravity, degree=12, **more), 1)[0])


def tangent_length():
    """Return the first positive x with tan x = x."""
    return brentq(lambda x: np.tan(x) - x, np.pi + 0.1, 1.5 * np.pi - 1e-6)


@pytest.mark.parametrize(
    ("foot", "guide", "ratio"),
    [("F", None, np.pi**2 / 4), ("U", "ball", np.pi**2), ("F", "ball", tangent_length() ** 2), ("F", "x", 4 * np.pi**2)],
)
def test_columns_buckle_at_eulers_loads(foot, guide, ratio):
    assert factor(strut(foot, guide), (-1, 0, 0, 0, 0, 0)) == pytest.approx(ratio * EI_Z / L**2, rel=1e-8)


def test_column_with_shear_buckles_at_haringx_load():
    """P (1 + P / κGA) = π² EI / 4L² (J. A. Haringx, 1948)."""
    stocky = Section(3e-6, 4e-7, 1e-7, 2e-7)
    stiffness, euler = 0.85 * G * stocky.area, np.pi**2 * EI_Z / (4 * L**2)
    load = stiffness / 2 * (np.sqrt(1 + 4 * euler / stiffness) - 1)
    assert load < 0.9 * euler
    assert factor(strut(section=stocky, kappa=0.85), (-1, 0, 0, 0, 0, 0)) == pytest.approx(load, rel=1e-8)


def test_column_under_own_weight_buckles_at_greenhills_height():
    """q L³ / EI = (9/4) z² with J_{−1/3}(z) = 0: 7.837 (A. G. Greenhill, 1881)."""
    z = brentq(lambda x: jv(-1 / 3, x), 1.5, 2.2)
    density = 100.0
    found = factor(strut(density=density), gravity=(-1, 0, 0))
    assert found == pytest.approx(2.25 * z**2 * EI_Z / L**3 / (density * STRIP.area), rel=1e-8)


def test_cantilever_under_tip_force_buckles_laterally():
    """P = 4.0126 √(EI_z GJ) / L² (A. G. M. Michell, L. Prandtl, 1899): J_{−1/4}(2.0063) = 0."""
    wanted = 2 * brentq(lambda x: jv(-0.25, x), 1.5, 2.5) * np.sqrt(EI_Z * GJ) / L**2
    assert wanted * L**2 / np.sqrt(EI_Z * GJ) == pytest.approx(4.0126, abs=1e-4)
    for sign in (1, -1):
        assert factor(strut(), (0, 0, sign, 0, 0, 0)) == pytest.approx(wanted, rel=1e-8)


def test_beam_under_end_moments_buckles_laterally():
    """M = π √(EI_z GJ) / L between forks (Prandtl, Michell), and of a cantilever under a semitangential moment."""
    wanted = np.pi * np.sqrt(EI_Z * GJ) / L
    assert factor(strut(), (0, 0, 0, 0, 1, 0)) == pytest.approx(wanted, rel=1e-8)
    forks = factor(strut("U", "fork"), (0, 0, 0, 0, 1, 0), loads={"arm": (0, 0, 0, 0, -1, 0)})
    assert forks == pytest.approx(wanted, rel=1e-8)


ROUND = replace(STRIP, I_y=1e-7)


def test_shaft_buckles_under_torque():
    """Greenhill's shaft (1883) with clamped ends, T L / EI = 8.987, of which 2 tan x = 2 x; T = π EI / L of a cantilever and
    tan ½φ = −φ/6 between balls, φ = T L / EI, both under semitangential torque (the latter two from η‴ − i T/EI η″ = 0)."""
    torque = (0, 0, 0, 1, 0, 0)
    assert factor(strut("F", "shaft", ROUND), torque) == pytest.approx(2 * tangent_length() * EI_Z / L, rel=1e-8)
    assert factor(strut(section=ROUND), torque) == pytest.approx(np.pi * EI_Z / L, rel=1e-8)
    balls = factor(strut("S", "ball", ROUND), torque, loads={"arm": (0, 0, 0, -1, 0, 0)})
    phi = 2 * brentq(lambda x: 3 * np.sin(x) + x * np.cos(x), 2, 3)
    assert balls == pytest.approx(phi * EI_Z / L, rel=1e-8)


@pytest.mark.parametrize("part", [0.3, 0.95, -0.5])
def test_column_under_side_load_equals_closed_form(part):
    """3 (tan kL − kL) / (kL)³ times the linear deflection."""
    pressure = part * np.pi**2 * EI_Z / (2 * L) ** 2
    kl = np.sqrt(complex(pressure / EI_Z)) * L
    wanted = L**3 / (3 * EI_Z) * (3 * (np.tan(kl) - kl) / kl**3).real
    found = em.at_the_pose(structure_of(strut(), (-pressure, 0, 0, 0, 0, 0), (0, 0, 0)))
    assert found.compliance[1, 1] == pytest.approx(wanted, rel=1e-8)
    assert found.negative == 0
    loaded = em.at_the_pose(structure_of(strut(), (-pressure, 10, 0, 0, 0, 0), (0, 0, 0)))
    assert loaded.twist[1] == pytest.approx(10 * wanted, rel=2 * abs(pressure) / (E * STRIP.area) / (1 - part))  # it gets shorter


def test_negative_stiffnesses_are_counted():
    for ratio, count in ((0.99, 0), (1.01, 2), (8.99, 2), (9.01, 4)):
        load = (-ratio * np.pi**2 * EI_Z / (4 * L**2), 0, 0, 0, 0, 0)
        found = em.at_the_pose(structure_of(strut(section=ROUND), load, (0, 0, 0)))
        assert found.negative == count


@pytest.mark.parametrize("load", [1.0, 4.0, 10.0])
def test_cantilever_bends_to_the_elastica(load):
    """Bisshopp and Drucker (1945): with k² = (1 + sin θ)/2 for the slope θ at the end, √(P L²/EI) = K(k) − F(φ, k)."""

    def arc(slope):
        k2 = (1 + np.sin(slope)) / 2
        return ellipk(k2) - ellipkinc(np.arcsin(1 / np.sqrt(2 * k2)), k2)

    slope = brentq(lambda s: arc(s) - np.sqrt(load), 1e-3, np.pi / 2 - 1e-9)
    k2 = (1 + np.sin(slope)) / 2
    phi = np.arcsin(1 / np.sqrt(2 * k2))
    down = 1 - 2 * (ellipe(k2) - ellipeinc(phi, k2)) / np.sqrt(load)
    along = np.sqrt(2 * np.sin(slope) / load)
    if load == 1.0:
        assert (down, 1 - along) == pytest.approx((0.30172, 0.05643), abs=1e-5)  # K. Mattiasson (1981)
    if load == 10.0:
        assert (down, 1 - along) == pytest.approx((0.81061, 0.55500), abs=1e-5)
    structure = structure_of(strut(section=replace(STRIP, area=1.0)), (0, load * EI_Z / L**2, 0, 0, 0, 0), (0, 0, 0))
    found = em.in_equilibrium(structure)
    np.testing.assert_allclose(found.twist[[0, 1, 5]], [L * (along - 1), L * down, slope], rtol=1e-5)
    assert found.turn == pytest.approx(slope, rel=1e-5)


def test_cantilever_rolls_up_under_a_moment():
    angle = 2.0
    found = em.in_equilibrium(structure_of(strut(), (0, 0, 0, 0, 0, angle * EI_Z / L), (0, 0, 0)))
    end = L * np.array([np.sin(angle) / angle - 1, (1 - np.cos(angle)) / angle])
    np.testing.assert_allclose(found.twist[[0, 1, 5]], [*end, angle], rtol=1e-8)


def test_linear_delta_under_torque_equals_a_corotational_model():
    """0.5 N·m about y: 10.77 N·m/rad without load become 9.15 and 12.53, by another model."""
    pose = package_robots.robot("linear_delta").assemble()
    structure = structure_of(pose, (0, 0, 0, 0, 0.5, 0), (0, 0, 0))
    found = em.in_equilibrium(structure)
    np.testing.assert_allclose(1 / np.diag(found.linear)[3:5], 10.766, rtol=1e-4)
    np.testing.assert_allclose(1 / np.linalg.eigvalsh(found.compliance[3:, 3:])[:0:-1], [9.15, 12.53], rtol=1e-3)


# ---- properties ----------------------------------------------------------------------------------------------------------------

SPECS = {
    "6-UPS": sr.gough(), "3-PUU": sr.puu3(), "four-bar": sr.four_bar(), "2-PRU+UPR": sr.pru2_upr(),
    "random": sr.with_beams(sr.random_spec(["rCU", "pCU", "SpU", "rUS"], 1), density=2700.0),
}  # fmt: skip
LOAD, GRAVITY = np.array([300.0, -200.0, -4000.0, 20.0, -30.0, 50.0]), (0.5, 1.0, -9.81)


def tangent(spec, load=LOAD, gravity=GRAVITY, **writing):
    return em.at_the_pose(structure_of(sr.write(spec, **writing).robot().assemble(), load, gravity))


@pytest.mark.few(2)
@pytest.mark.parametrize("name", SPECS)
def test_hessian_is_the_derivative_of_the_gradient(name):
    """At random motions and forces, by differences."""
    structure = structure_of(sr.write(SPECS[name]).robot().assemble(), LOAD, GRAVITY)
    rng = np.random.default_rng(1)
    rest = em.at_rest(structure)
    state = em.State(*(0.2 * rng.standard_normal(part.shape) for part in (rest.x, rest.forces, rest.inner)))
    way = em.State(*(rng.standard_normal(part.shape) for part in (rest.x, rest.forces, rest.inner)))
    found = em.equations(structure, state, condense=False)

    def gradient(h):
        moved = em.State(*(getattr(state, key) + h * getattr(way, key) for key in ("x", "forces", "inner")))
        return em.equations(structure, moved, condense=False).gradient

    h = 1e-3
    slope = (8 * (gradient(h) - gradient(-h)) - gradient(2 * h) + gradient(-2 * h)) / (12 * h)
    wanted = found.hessian @ np.concatenate([way.x, way.forces, way.inner.ravel()])
    np.testing.assert_allclose(slope, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())
    np.testing.assert_allclose(found.hessian, found.hessian.T, rtol=0, atol=1e-12 * np.abs(found.hessian).max())


@pytest.mark.few(2)
@pytest.mark.parametrize("name", SPECS)
def test_tangent_does_not_depend_on_the_spelling(name):
    """Loops cut elsewhere, universal and spherical joints as runs, predecessor and successor exchanged; beams in parts."""
    spec = SPECS[name]
    found = tangent(spec)
    others = [tangent(spec, whole=False, piece=1, twirl=3), tangent(spec, flip=True, twirl=5)]
    if name not in ("6-UPS", "2-PRU+UPR"):  # their telescopes have slides inside
        others.append(tangent(sr.split(spec, 2)))
    size = np.abs(found.compliance).max()
    for other in others:
        np.testing.assert_allclose(other.compliance, found.compliance, rtol=0, atol=1e-7 * size)
        assert other.negative == found.negative


@pytest.mark.few(2)
@pytest.mark.parametrize("name", SPECS)
def test_motion_and_tangent_in_equilibrium_tend_to_those_of_the_pose(name):
    """With half of the load half of the difference is left."""
    pose = sr.write(SPECS[name]).robot().assemble()
    unit = np.repeat([1.0, pose.robot.length], 3)
    left = []
    for part in (0.02, 0.01):
        structure = structure_of(pose, part * LOAD, part * np.array(GRAVITY))
        here, there = em.at_the_pose(structure), em.in_equilibrium(structure)
        size = np.linalg.norm(here.linear * np.outer(unit, unit))
        left.append(
            [
                np.linalg.norm((there.twist - here.linear_twist) * unit) / np.linalg.norm(here.linear_twist * unit),
                np.linalg.norm((there.compliance - here.linear) * np.outer(unit, unit)) / size,
            ]
        )
    assert np.max(left) < 0.05
    np.testing.assert_allclose(np.divide(*left), 2, rtol=0.1)
