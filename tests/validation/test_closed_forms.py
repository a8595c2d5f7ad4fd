"""Closed forms of cantilevers, struts, portals and rods; bent lines against integration."""

from dataclasses import replace

import numpy as np
import pytest
import small_robots as sr
from small_robots import NU, RHO, E

import kinetostatics as ks

G = E / (2 * (1 + NU))


def analyze(spec, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, 0), **options):
    return ks.analyze(sr.robot_of(spec, **options).assemble(), load=load, gravity=gravity)


def close(found, expected, rtol=1e-11, scale=None):
    expected = np.asarray(expected, dtype=float)
    atol = rtol * (np.abs(expected).max() if scale is None else scale)
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=atol)


RECTANGLE = sr.Section(2e-3, 4e-7, 9e-7, 6e-7)


def tip_compliance(L, s, kappa):
    """End compliance of a cantilever along x: order d_x d_y d_z r_x r_y r_z."""
    GA = kappa * G * s.area
    C = np.diag([
        L / (E * s.area), L**3 / (3 * E * s.I_z) + L / GA, L**3 / (3 * E * s.I_y) + L / GA,
        L / (G * s.J), L / (E * s.I_y), L / (E * s.I_z),
    ])  # fmt: skip
    C[1, 5] = C[5, 1] = L**2 / (2 * E * s.I_z)
    C[2, 4] = C[4, 2] = -(L**2) / (2 * E * s.I_y)
    return C


# ---- one beam ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kappa", [1.0, 0.85, np.inf])
@pytest.mark.parametrize("component", range(6))
def test_cantilever_under_every_load(component, kappa):
    L, size = 0.9, [300.0, 200.0, -150.0, 20.0, 30.0, -40.0][component]
    spec = sr.cantilever(L, section=RECTANGLE, y_axis=(0, 1, 0), kappa=kappa)
    load = np.zeros(6)
    load[component] = size
    found = analyze(spec, load)
    C = tip_compliance(L, RECTANGLE, kappa)
    close(found.twist, C[:, component] * size)
    close(found.compliance, C, scale=1e-12)
    close(found.stiffness @ C, np.eye(6), rtol=1e-9)


def test_cantilever_under_its_own_weight_across_and_along():
    L, s, kappa = 1.3, sr.circle(0.04), 0.9
    q = RHO * s.area * 9.81
    spec = sr.cantilever(L, section=s, kappa=kappa)
    down = analyze(spec, gravity=(0, 0, -9.81)).twist
    EI = E * s.I_y
    close(down, [0, 0, -q * L**4 / (8 * EI) - q * L**2 / (2 * kappa * G * s.area), 0, q * L**3 / (6 * EI), 0])
    along = analyze(spec, gravity=(9.81, 0, 0)).twist
    close(along, [q * L**2 / (2 * E * s.area), 0, 0, 0, 0, 0])


def test_weight_beside_the_middle_of_a_cantilever():
    """The mass of the link lies along a line through its own centre of mass, beyond the beam's middle and beside it."""
    L, s, kappa, m, beyond, beside = 1.3, sr.circle(0.04), 0.9, 5.0, 0.4, 0.07
    spec = sr.cantilever(L, section=s, kappa=kappa, density=None)
    arm = sr.Link("arm", m, (L / 2 + beyond, beside, 0.11))
    found = analyze(replace(spec, limbs=(replace(spec.limbs[0], links=(arm,)),)), gravity=(0, 0, -9.81))
    q, EI = m * 9.81 / L, E * s.I_y
    down = q * L**4 / (8 * EI) + q * L**2 / (2 * kappa * G * s.area) + q * beyond * L**3 / (3 * EI)
    tilt = q * L**3 / (6 * EI) + q * beyond * L**2 / (2 * EI)
    close(found.twist, [0, 0, -down, -q * beside * L**2 / (2 * G * s.J), tilt, 0])
    weight = np.array([0, 0, -m * 9.81])
    close(found.base_wrench, [*-weight, *-np.cross(arm.com, weight)])
    # the work of the weight along the bent line is twice the strain energy
    beam, x = found.beams["arm"], np.linspace(0, 1, len(found.beams["arm"].stations))
    moved = beam.deflections + np.cross(beam.rotations, [beyond, beside, 0.11])
    work = np.polynomial.Polynomial.fit(x, moved @ weight, 6, domain=[0, 1], window=[0, 1]).integ()(1)
    assert work == pytest.approx(2 * beam.strain_energy, rel=1e-11)


@pytest.mark.parametrize("seed", range(4))
def test_cantilever_in_any_direction(seed):
    rng = np.random.default_rng(seed)
    R = sr.random_rotation(rng)
    L, kappa = 0.7, 1.0
    spec = sr.rotated(sr.cantilever(L, section=RECTANGLE, y_axis=(0, 1, 0), kappa=kappa), R)
    R6 = np.kron(np.eye(2), R)
    load = rng.standard_normal(6) * 30
    found = analyze(spec, load, twirl=seed)
    close(found.twist, R6 @ tip_compliance(L, RECTANGLE, kappa) @ R6.T @ load)


def test_hanging_rod_under_its_own_weight():
    L, s = 2.0, sr.tube(0.05, 0.03)
    found = analyze(sr.cantilever(L, (0, 0, -1), s), gravity=(0, 0, -9.81))
    close(found.twist, [0, 0, -RHO * 9.81 * L**2 / (2 * E), 0, 0, 0])
    beam = found.beams["arm"]
    z = beam.stations * L
    close(beam.section_wrenches[:, 0], RHO * 9.81 * s.area * (L - z))
    close(beam.deflections[:, 2], -RHO * 9.81 / E * (L * z - z**2 / 2))
    assert beam.stress == pytest.approx(RHO * 9.81 * L, rel=1e-12)
    assert beam.strain_energy == pytest.approx((RHO * 9.81) ** 2 * s.area * L**3 / (6 * E), rel=1e-12)
    assert beam.mass == pytest.approx(RHO * s.area * L, rel=1e-14)


def test_stepped_beam_under_tip_load_and_weight():
    a, b = 0.6, 0.4
    one, two = sr.circle(0.06), sr.circle(0.04)
    spec = sr.stepped_beam((a, b), (one, two), kappa=np.inf)
    I1, I2, P = E * one.I_y, E * two.I_y, 100.0
    found = analyze(spec, (0, 0, P, 0, 0, 0)).twist
    # Mohr: curvature P (L − x)/EI, deflection its first moment about the tip
    deflection = P * (((a + b) ** 3 - b**3) / (3 * I1) + b**3 / (3 * I2))
    slope = P * (((a + b) ** 2 - b**2) / (2 * I1) + b**2 / (2 * I2))
    close(found, [0, 0, deflection, 0, -slope, 0])
    q1, q2 = (RHO * s.area * 9.81 for s in (one, two))
    stretched = analyze(spec, gravity=(9.81, 0, 0)).twist
    close(stretched, [q1 * a**2 / 2 / (E * one.area) + q2 * b * a / (E * one.area) + q2 * b**2 / 2 / (E * two.area),
                      0, 0, 0, 0, 0])  # fmt: skip
    bent = analyze(spec, gravity=(0, 0, -9.81)).twist[2]
    # the outer part as a cantilever, carried by slope and deflection of the inner one's end
    inner = q1 * a**4 / 8 + q2 * b * a**3 / 3 + q2 * b**2 / 2 * a**2 / 2
    turn = q1 * a**3 / 6 + q2 * b * a**2 / 2 + q2 * b**2 / 2 * a
    assert bent == pytest.approx(-(inner / I1 + turn / I1 * b + q2 * b**4 / (8 * I2)), rel=1e-11)


# ---- two locked links ----------------------------------------------------------------------------------------------------


def test_two_locked_links_under_every_load():
    a, b, s, kappa = 0.7, 0.5, sr.circle(0.045), 0.9
    EI, EA, GJ, GA = E * s.I_y, E * s.area, G * s.J, kappa * G * s.area
    # an L in the horizontal plane: along x, then along y
    spec = sr.locked_chain([(0, 0, 0), (a, 0, 0), (a, b, 0)], [(0, 0, 1), (0, 0, 1)], s, kappa=kappa)
    C = analyze(spec).compliance
    expected_diagonal = [
        a / EA + b**3 / (3 * EI) + b / GA + a * b**2 / EI,
        a**3 / (3 * EI) + a / GA + b / EA,
        a**3 / (3 * EI) + a / GA + a * b**2 / GJ + b**3 / (3 * EI) + b / GA,
        a / GJ + b / EI, a / EI + b / GJ, a / EI + b / EI,
    ]  # fmt: skip
    close(np.diag(C), expected_diagonal)
    assert C[2, 3] == pytest.approx(a * b / GJ + b**2 / (2 * EI), rel=1e-11)  # a moment about x lifts the tip
    assert C[2, 4] == pytest.approx(-(a**2) / (2 * EI), rel=1e-11)
    assert C[0, 1] == pytest.approx(-b * a**2 / (2 * EI), rel=1e-11)
    assert C[0, 5] == pytest.approx(-(a * b + b**2 / 2) / EI, rel=1e-11)
    assert C[1, 5] == pytest.approx(a**2 / (2 * EI), rel=1e-11)
    np.testing.assert_allclose(C, C.T, rtol=1e-14, atol=1e-22)


# ---- portals -------------------------------------------------------------------------------------------------------------


def test_portal_stiffness():
    h, w, s = 1.1, 0.8, sr.circle(0.05)
    found = analyze(sr.portal(h, w, s, kappa=np.inf), (100, 0, 0, 0, 0, 0))
    # columns clamped at both ends as long as the beam does not turn; K about the head's centre
    K = found.stiffness
    assert K[0, 0] == pytest.approx(2 * 12 * E * s.I_y / h**3, rel=1e-11)
    assert K[1, 1] == pytest.approx(2 * 12 * E * s.I_y / h**3, rel=1e-11)
    assert K[2, 2] == pytest.approx(2 * E * s.area / h, rel=1e-11)
    assert K[0, 4] == pytest.approx(-2 * 6 * E * s.I_y / h**2, rel=1e-11)
    assert K[4, 4] == pytest.approx(2 * 4 * E * s.I_y / h + 2 * E * s.area / h * (w / 2) ** 2, rel=1e-11)
    assert K[5, 5] == pytest.approx(2 * G * s.J / h + 2 * 12 * E * s.I_y / h**3 * (w / 2) ** 2, rel=1e-11)


@pytest.mark.parametrize("kappa", [1.0, np.inf])
def test_portal_under_gravity_and_a_load_on_top(kappa):
    h, w, s, m = 1.1, 0.8, sr.circle(0.05), 40.0
    found = analyze(sr.portal(h, w, s, mass=m, kappa=kappa), (0, 0, -1000, 0, 0, 0), (0, 0, -9.81))
    q = RHO * s.area * 9.81
    close(found.twist, [0, 0, -(q * h**2 / 2 + (1000 + m * 9.81) * h / 2) / (E * s.area), 0, 0, 0], scale=1e-6)
    beam = found.beams["column_1"]
    close(beam.section_wrenches[:, 0], -(q * h * (1 - beam.stations) + (1000 + m * 9.81) / 2))
    # sideways gravity: the head gets half of a clamped column's weight, and its fixed-end moment
    side = analyze(sr.portal(h, w, s, mass=m, kappa=kappa), gravity=(0, 9.81, 0))
    EI, GA = E * s.I_y, kappa * G * s.area
    phi = 0.0 if np.isinf(kappa) else 12 * EI / (GA * h**2)
    a = 2 * EI / ((1 + phi) * h**3)
    K = np.array([[12 * a, 6 * a * h], [6 * a * h, (4 + phi) * a * h**2]])  # d_y and r_x at the head
    d = np.linalg.solve(K, [q * h + m * 9.81, q * h**2 / 6])
    close(side.twist, [0, d[0], 0, d[1], 0, 0], rtol=1e-10)


# ---- struts --------------------------------------------------------------------------------------------------------------


@pytest.mark.few(3)
@pytest.mark.parametrize("inner", ["U", "S"])
@pytest.mark.parametrize("telescopic", [True, False])
@pytest.mark.parametrize("density", [0.0, RHO])
def test_gough_platform_with_axial_struts(inner, telescopic, density):
    s = sr.circle(0.03)
    spec = sr.gough(inner, telescopic, s, density=density)
    found = analyze(spec, (10, -20, 30, 4, 5, -6), (0, 0, -9.81))
    base, top, o = sr.gough_points()
    K, columns = np.zeros((6, 6)), []
    for b, t in zip(base, top, strict=True):
        L = np.linalg.norm(t - b)
        along = (t - b) / L
        screw = np.concatenate([along, np.cross(t - o, along)])
        K += E * s.area / L * np.outer(screw, screw)
        columns.append(screw)
    np.testing.assert_allclose(found.stiffness, K, rtol=1e-10, atol=1e-10 * np.abs(K).max())
    if density == 0.0:
        W = np.array([10, -20, 30, 4, 5, -6]) + np.concatenate(
            [[0, 0, -12 * 9.81], np.cross([0.03, 0.02, 0.01], [0, 0, -12 * 9.81])]
        )
        close(found.twist, np.linalg.solve(K, W), rtol=1e-9)
        forces = np.linalg.solve(np.array(columns).T, -W)  # a strut pushes with its actuator's force
        close([found.actuator_forces[f"slide_{k}"] for k in range(1, 7)], forces, rtol=1e-9)


# ---- bent lines, stresses ------------------------------------------------------------------------------------------------


def integrate(values, x):
    """Integrate polynomials of degree ≤ 5 from stations exactly: cumulative, zero at the start."""
    fit = np.polynomial.Polynomial.fit(x, values, 5)
    integral = fit.integ()
    return integral(x) - integral(x[0])


@pytest.mark.few(3)
@pytest.mark.parametrize("robot", ["cantilever", "chain", "portal", "rps3", "pru2_upr", "planar_3rrr"])
def test_bent_lines_solve_the_beams_differential_equations(robot):
    rng = np.random.default_rng(5)
    specs = {
        "cantilever": sr.cantilever(0.9, (1, 2, 2), RECTANGLE, y_axis=(2, -1, 0), kappa=0.8),
        "chain": sr.locked_chain([(0, 0, 0), (0.5, 0.1, 0), (0.7, 0.2, 0.5)], [(0, 0, 1), (1, 0, 0)], mass=2.0),
        "portal": sr.portal(mass=10.0), "rps3": sr.rps3(), "pru2_upr": sr.pru2_upr(), "planar_3rrr": sr.planar_3rrr(),
    }  # fmt: skip
    spec = specs[robot]
    g = np.array([1.0, -2.0, -9.0])
    found = analyze(spec, rng.standard_normal(6) * 50, g)
    for described in spec.beams:
        beam, s = found.beams[described.name], described.section
        R, x = beam.axes, beam.stations * beam.length
        w = beam.section_wrenches
        q = R.T @ g * float(beam.mass / beam.length)
        size = np.abs(w).max(axis=0) + 1e-9
        # equilibrium: N' = −q_x, V' = −q, M_y' = V_z, M_z' = −V_y, T' = 0
        for k in range(3):
            np.testing.assert_allclose(w[:, k] - w[0, k], -q[k] * x, atol=1e-11 * size[:3].max())
        np.testing.assert_allclose(w[:, 4] - w[0, 4], integrate(w[:, 2], x), atol=1e-11 * size.max())
        np.testing.assert_allclose(w[:, 5] - w[0, 5], -integrate(w[:, 1], x), atol=1e-11 * size.max())
        np.testing.assert_allclose(w[:, 3], w[0, 3], atol=1e-11 * size.max())
        # the line: rotations integrate the curvatures, displacements the strains and rotations
        GA = described.kappa * G * s.area
        turn = np.column_stack([w[:, 3] / (G * s.J), w[:, 4] / (E * s.I_y), w[:, 5] / (E * s.I_z)])
        r, d = beam.rotations @ R, beam.deflections @ R
        grown = np.column_stack([integrate(turn[:, k], x) for k in range(3)])
        np.testing.assert_allclose(r - r[0], grown, atol=1e-10 * np.abs(grown).max() + 1e-18)
        slope = np.column_stack([w[:, 0] / (E * s.area), w[:, 1] / GA + r[:, 2], w[:, 2] / GA - r[:, 1]])
        grown = np.column_stack([integrate(slope[:, k], x) for k in range(3)])
        np.testing.assert_allclose(d - d[0], grown, atol=1e-10 * np.abs(grown).max() + 1e-18)
        np.testing.assert_allclose(np.diff(beam.points, axis=0), np.diff(x)[:, None] * R[:, 0], atol=1e-13)
        assert np.linalg.det(R) == pytest.approx(1)
        # strain energy
        c = np.array([1 / (E * s.area), 1 / GA, 1 / GA, 1 / (G * s.J), 1 / (E * s.I_y), 1 / (E * s.I_z)])
        assert beam.strain_energy == pytest.approx(integrate((w**2 @ c) / 2, x)[-1], rel=1e-10)


@pytest.mark.parametrize("section", [sr.circle(0.05), sr.tube(0.05, 0.03)])
def test_stress_of_round_sections(section):
    L, d = 0.8, 0.05
    spec = sr.cantilever(L, section=section, density=0.0)
    bend = analyze(spec, (0, 0, 100, 0, 0, 0)).beams["arm"]
    assert bend.stress == pytest.approx(100 * L * d / 2 / section.I_y, rel=0.02)  # shear at the neutral line is less
    pull = analyze(spec, (5e3, 0, 0, 0, 0, 0)).beams["arm"]
    assert pull.stress == pytest.approx(5e3 / section.area, rel=1e-12)
    twist = analyze(spec, (0, 0, 0, 70, 0, 0)).beams["arm"]
    assert twist.stress == pytest.approx(np.sqrt(3) * 70 * d / 2 / section.J, rel=1e-12)
    # moments about y and z add as vectors in a round section; with tension and torsion by von Mises
    both = analyze(spec, (5e3, 0, 0, 70, 30, 40)).beams["arm"]
    normal, shear = 5e3 / section.area + 50 * d / 2 / section.I_y, 70 * d / 2 / section.J
    assert both.stress == pytest.approx(np.hypot(normal, np.sqrt(3) * shear), rel=1e-12)


def test_stress_of_a_section_given_by_numbers_is_nan():
    found = analyze(sr.cantilever(section=RECTANGLE, y_axis=(0, 1, 0)), (1, 2, 3, 4, 5, 6))
    assert np.isnan(found.beams["arm"].stress)
