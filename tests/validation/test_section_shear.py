"""Torsion and transverse shear of all sections against closed forms, sectionproperties and elements."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from kinetostatics.sections import Rectangle, RectangularTube, Section, Tube
from kinetostatics.sections.kinds import _rectangle_forms
from kinetostatics.sections.stresses import shear_functions

#: J [mm⁴], τ_xz [MPa] under V_z = 1 N at the outer face, in the middle of the wall and at the inner face of the web at z = 0, and
#: the shear stress under T = 1 N·mm at the outer faces (y = b/2, z = 0) and (y = 0, z = h/2), from sectionproperties 3.10.2:
#: rectangular_hollow_section(d=h, b=b, t=t, r_out=0, n_r=1).create_mesh(area / 2500), Material with ν = 0.3,
#: Section.calculate_warping_properties(), get_ej(), get_stress_at_points(…, vy=1), (…, mzz=1).
SECTION_PROPERTIES = {
    (40, 40, 1): (60031.384, (0.014474232, 0.014416671, 0.014360493), (0.000345195, 0.000345195)),
    (40, 40, 4): (197424.548, (0.003942963, 0.003873264, 0.00381105), (0.000115675, 0.000115675)),
    (40, 40, 8): (302471.864, (0.002188738, 0.002107847, 0.00204705), (8.3997e-05, 8.4002e-05)),
    (40, 40, 12): (347309.001, (0.001543893, 0.001488383, 0.001497283), (7.7104e-05, 7.7103e-05)),
    (40, 40, 16): (359040.797, (0.001191685, 0.001113101, 0.001294671), (7.5211e-05, 7.5194e-05)),
    (40, 40, 19.9): (359877.367, None, (7.5027e-05, 7.5025e-05)),  # its mesh does not see the stress at so small a hole
    (60, 30, 2): (125477.181, (0.009650448, 0.009521848, 0.009397903), (0.000169473, 0.000169474)),
}
NU = 0.3
ALL = (
    Tube.of(0.05),
    Tube.of(0.05, 0.03),
    Tube.of(0.05, 0.049),
    Rectangle.of(0.03, 0.03),
    Rectangle.of(0.06, 0.02),
    RectangularTube.of(0.04, 0.04, 0.001),
    RectangularTube.of(0.03, 0.06, 0.008),
    RectangularTube.of(0.1, 0.02, 0.001),
    Rectangle.of(0.2, 0.01),
)


def unit(k, size=1.0):
    wrench = np.zeros(6)
    wrench[k] = size
    return wrench


@pytest.mark.few(2)
@pytest.mark.parametrize(("size", "expected"), SECTION_PROPERTIES.items())
def test_rectangular_tube_equals_sectionproperties(size, expected):
    b, h, t = size
    J, web, faces = expected
    section = RectangularTube.of(*(1e-3 * x for x in size))
    assert section.J == pytest.approx(J * 1e-12, rel=4e-4)
    y, z = np.array([(b / 2, 0), (b / 2 - t / 2, 0), (b / 2 - t, 0), (0, h / 2)]).T
    stress = shear_functions(b, h, t).stresses(y, z, NU)
    assert stress[1, 2, 0] == pytest.approx(faces[0], rel=3e-3)
    assert -stress[0, 2, 3] == pytest.approx(faces[1], rel=3e-3)
    if web:
        assert_allclose(stress[1, 1, :3], web, rtol=7e-3)


@pytest.mark.slow
def test_rectangular_tube_limits_of_thin_and_full_walls():
    """Bredt's J and modulus, Cowper's thin-walled box; the full square's J and κ; a rise without a step between."""
    kappa = 10 * 1.3 * 16 / (324 + 0.3 * 302 + 10 * (3.3 + 3))

    def twisted(t):  # shear stress in the middle of a face
        return shear_functions(1, 1, t).stresses(np.array([0.5]), np.array([0.0]), NU)[1, 2, 0]

    for t in (1e-4, 1e-5):
        thin = RectangularTube.of(1, 1, t)
        assert thin.J == pytest.approx(t * (1 - t) ** 3, rel=2 * t + 2e-5)
        assert twisted(t) == pytest.approx(1 / (2 * t * (1 - t) ** 2), rel=5 * t)
        assert thin.shear_coefficients(NU) == pytest.approx((kappa, kappa), rel=5e-4)
    square = Rectangle.of(1, 1)
    full = RectangularTube.of(1, 1, 0.4999)
    assert full.J == pytest.approx(square.J, rel=1e-4)
    assert twisted(0.4999) == pytest.approx(float(square.stress(unit(3), NU)) / np.sqrt(3), rel=1e-3)
    assert full.shear_coefficients(NU) == pytest.approx(square.shear_coefficients(NU), rel=1e-5)
    walls = [RectangularTube.of(1, 1, t) for t in np.linspace(0.02, 0.495, 6)]
    assert np.all(np.diff([wall.J for wall in walls]) > 0)
    assert np.all(np.diff([wall.shear_coefficients(NU)[0] for wall in walls]) > 0)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 30)])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_elements_of_full_rectangle_equal_series(size, nu):
    """The elements' J and κ of a full rectangle are the series' and Cowper's."""
    shear = shear_functions(*size, min(size) / 2)
    section = Rectangle.of(*size)
    assert section.J == pytest.approx(shear.J, rel=1e-5)
    assert_allclose(shear.shear_coefficients(nu), section.shear_coefficients(nu), rtol=1e-9)


def test_shear_coefficient_of_thick_tube_equals_bilinear_elements():
    """κ of a 30 × 50 tube with walls of 10 by bilinear elements, whose errors fall with the square of their size."""
    found = [_kappa_by_squares(15, 25, 10, step, NU) for step in (1, 0.5)]
    found = (4 * found[1] - found[0]) / 3
    assert RectangularTube.of(0.03, 0.05, 0.01).shear_coefficients(NU)[1] == pytest.approx(found, rel=3e-3)


def _kappa_by_squares(half_y, half_z, wall, size, nu):
    """Cowper's κ for a force along z: 2(1+ν) I_y / ((A/I_y) ∫zΨ − ν (I_y − I_z)/2), ∇²Ψ = −2z, ∂Ψ/∂n = ν n·(yz, (z²−y²)/2)."""
    ny, nz = round(half_y / size), round(half_z / size)
    number = np.arange((ny + 1) * (nz + 1)).reshape(ny + 1, nz + 1)
    point = np.array([-1, 1]) / np.sqrt(3)
    stiffness, load = np.zeros((number.size, number.size)), np.zeros(number.size)
    moment, area, I_y, I_z = np.zeros(number.size), 0.0, 0.0, 0.0
    for i, k in np.ndindex(ny, nz):
        if (i + 0.5) * size < half_y - wall and (k + 0.5) * size < half_z - wall:
            continue
        nodes = number[[i, i + 1, i + 1, i], [k, k, k + 1, k + 1]]
        for u in point:
            for v in point:
                f = np.array([(1 - u) * (1 - v), (1 + u) * (1 - v), (1 + u) * (1 + v), (1 - u) * (1 + v)]) / 4
                g = np.array([[v - 1, 1 - v, 1 + v, -1 - v], [u - 1, -1 - u, 1 + u, 1 - u]]) / (2 * size)
                y, z, w = (i + (1 + u) / 2) * size, (k + (1 + v) / 2) * size, size**2 / 4
                stiffness[np.ix_(nodes, nodes)] += w * g.T @ g
                load[nodes] += w * (2 * (1 + nu) * z * f + nu * np.array([y * z, (z**2 - y**2) / 2]) @ g)
                moment[nodes] += w * z * f
                area, I_y, I_z = area + 4 * w, I_y + 4 * w * z**2, I_z + 4 * w * y**2
    free = np.setdiff1d(np.flatnonzero(np.diag(stiffness)), number[:, 0])
    psi = np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
    return 2 * (1 + nu) * I_y / (area / I_y * 4 * moment[free] @ psi - nu * (I_y - I_z) / 2)


def test_shear_stress_of_round_sections():
    """Timoshenko and Goodier, section 117: (3+2ν)/2(1+ν) V/A in the middle of a circle; a thin ring has twice the mean."""
    V = np.array([0, 300.0, 400.0, 0, 0, 0])
    circle = Tube.of(0.05)
    for nu in (0.0, 0.3):
        expected = np.sqrt(3) * (3 + 2 * nu) / (2 * (1 + nu)) * 500 / circle.area
        assert circle.stress(V[:, None], nu)[0] == pytest.approx(expected, rel=1e-12)
    ring = Tube.of(1.0, 0.9998)
    assert ring.stress(V[:, None], NU)[0] == pytest.approx(2 * np.sqrt(3) * 500 / ring.area, rel=3e-4)


def test_shear_stress_of_rectangles():
    """Timoshenko and Goodier, section 121, ν = 1/4: times 3V/2A in the middle of the sides, by depth over width; ν = 0: 3V/2A."""
    for ratio, factor in ((2, 1.033), (1, 1.126), (0.5, 1.396), (0.25, 1.988)):
        section = Rectangle.of(0.02, 0.02 * ratio)
        mean = 1.5 * 100 / section.area * np.sqrt(3)
        assert section.stress(unit(2, 100.0)[:, None], 0.25)[0] == pytest.approx(factor * mean, rel=1e-3)
        assert section.stress(unit(2, 100.0)[:, None], 0.0)[0] == pytest.approx(mean, rel=1e-5)


@pytest.mark.parametrize("section", ALL, ids=str)
def test_stress_under_single_forces_equals_elementary_formulas(section):
    """Axial force, bending, and torsion of round sections."""
    y, z = section.extent
    assert section.stress(unit(0, -7.0)[:, None], NU)[0] == pytest.approx(7 / section.area, rel=1e-12)
    assert section.stress(unit(4, 3.0)[:, None], NU)[0] == pytest.approx(3 * z / section.I_y, rel=1e-12)
    assert section.stress(unit(5, -3.0)[:, None], NU)[0] == pytest.approx(3 * y / section.I_z, rel=1e-12)
    if isinstance(section, Tube):
        assert section.stress(unit(3, 2.0)[:, None], NU)[0] == pytest.approx(2 * np.sqrt(3) * y / section.J, rel=5e-3)


@pytest.mark.few(2)
@pytest.mark.parametrize("section", ALL, ids=str)
def test_stress_equals_maximum_over_the_section(section):
    """Against points all over the section, for forces of all kinds mixed; mirrored wrenches give the same."""
    rng = np.random.default_rng(3)
    rows = _round_rows(section) if isinstance(section, Tube) else _square_rows(section)
    sizes = np.sqrt((rows**2).sum(axis=1).max(axis=0))
    wrenches = rng.normal(size=(6, 300)) * rng.choice([0.0, 0.3, 1.0], size=(6, 300)) / sizes[:, None]
    found = section.stress(wrenches, NU)
    everywhere = np.sqrt(np.einsum("k,pkn->pn", [1, 3, 3], np.einsum("pki,in->pkn", rows, wrenches) ** 2).max(axis=0))
    keep = everywhere > 0
    ratio = found[keep] / everywhere[keep]
    assert ratio.min() > (0.99 if isinstance(section, Tube) else 0.98)
    assert ratio.max() < 1 + 2e-3
    for signs in ((1, -1, 1, -1, 1, -1), (1, 1, -1, -1, -1, 1), (-1, -1, -1, 1, 1, 1)):
        assert_allclose(section.stress(np.array(signs)[:, None] * wrenches, NU), found, rtol=1e-12)
    if isinstance(section, Tube):  # the stress of a round section does not depend on its y axis
        turn = np.array([[np.cos(1.1), -np.sin(1.1)], [np.sin(1.1), np.cos(1.1)]])
        turned = wrenches.copy()
        turned[1:3], turned[4:] = turn @ wrenches[1:3], turn @ wrenches[4:]
        assert_allclose(section.stress(turned, NU), found, rtol=1e-10)
    grid = section.stress(wrenches.reshape(6, 3, 10, 10), NU)
    assert_allclose(grid.ravel(), found, rtol=1e-14)
    along = section.largest_stress(wrenches.reshape(6, 3, 10, 10), NU)
    assert_allclose(along, grid.max(axis=0), rtol=1e-10)
    line = (
        np.linspace(-1, 1, 21)[:, None]
        * sizes.reshape(6, 1, 1) ** -1
        * rng.normal(size=(6, 1, 50))
        * [[[1]], [[0.1]], [[0.1]], [[0.1]], [[1]], [[1]]]
    )
    assert_allclose(section.largest_stress(line, NU), section.stress(line, NU).max(axis=0), rtol=1e-10)
    assert np.isnan(section.largest_stress(np.full((6, 21, 2), np.nan), NU)).all()


def _square_rows(section):
    """Stresses (P, 3, 6) under unit wrenches at a fine mesh, the inner corners' surroundings left out."""
    t = getattr(section, "thickness", 0) or min(section.width, section.height) / 2
    a, c = section.width / 2 - t, section.height / 2 - t
    near = min(t, a / 2, c / 2) if min(a, c) > 0 else 0
    axes = [
        np.unique([*np.linspace(0, x, 31), *(x - np.linspace(0, 1, 11) * min(x, 2 * t)), *(x + np.linspace(0, 1, 21) * t)])
        for x in (a, c)
    ]
    y, z = (v.ravel() for v in np.meshgrid(*axes))
    inside = ((y >= a) | (z >= c)) & (np.hypot(y - a, z - c) >= near)
    return _rows_at(section, y[inside], z[inside])


@pytest.mark.few(1)
@pytest.mark.parametrize("sides", [(0.06, 0.04, 0.01), (0.05, 0.05, 0.01)])
def test_stress_includes_the_arc_around_an_inner_corner(sides):
    """Against every degree of the arc at the distance from the corner at which stresses are evaluated."""
    section, rng = RectangularTube.of(*sides), np.random.default_rng(0)
    hole, angle = np.array(sides[:2]) / 2 - sides[2], np.radians(np.arange(-90, 181))
    near = min(sides[2], *(hole / 2))
    wrenches = rng.normal(size=(6, 5000)) * [[1e3]] * np.repeat([[1.0], [0.02]], 3, axis=0) * rng.integers(0, 2, (6, 5000))
    sigma, tau, other = np.einsum(
        "pki,in->kpn", _rows_at(section, *(hole[:, None] + near * np.array([np.cos(angle), np.sin(angle)]))), wrenches
    )
    arc = np.sqrt(sigma**2 + 3 * (tau**2 + other**2)).max(axis=0)
    assert np.all(section.stress(wrenches, NU) >= 0.985 * arc)


def _rows_at(section, y, z):
    """Stresses (P, 3, 6) under unit wrenches at points of the first quarter and their mirror images."""
    t = getattr(section, "thickness", 0) or min(section.width, section.height) / 2
    stress = shear_functions(section.width, section.height, t).stresses(y, z, NU)
    rows = []
    for p in (1, -1):
        for q in (1, -1):
            new = np.zeros((len(y), 3, 6))
            new[:, 0, 0], new[:, 0, 4], new[:, 0, 5] = 1 / section.area, q * z / section.I_y, -p * y / section.I_z
            new[:, 1, 1:4] = (stress[0] * np.array([[1], [p * q], [q]])).T
            new[:, 2, 1:4] = (stress[1] * np.array([[p * q], [1], [p]])).T
            rows.append(new)
    return np.concatenate(rows)


def _round_rows(tube):
    """The same of a round section, from the flexure function (a r + b/r − r³/4) sin θ by differences of its polar stresses."""
    R, m = tube.outer_diameter / 2, tube.inner_diameter / 2
    r, angle = (v.ravel() for v in np.meshgrid(np.linspace(max(m, 1e-9), R, 41), np.linspace(0, 2 * np.pi, 181)))
    k = (3 + 2 * NU) / 4
    a, b = k * (R**2 + m**2), k * R**2 * m**2
    factor = 1 / (2 * (1 + NU) * tube.I_y)
    rows = np.zeros((len(r), 3, 6))
    rows[:, 0, 0] = 1 / tube.area
    rows[:, 0, 4], rows[:, 0, 5] = r * np.sin(angle) / tube.I_y, -r * np.cos(angle) / tube.I_y
    for column, psi in ((2, angle), (1, angle + np.pi / 2)):
        rows[:, 1, column] = factor * np.sin(psi) * (a - b / r**2 - 0.75 * r**2 - NU * r**2 / 2)
        rows[:, 2, column] = factor * np.cos(psi) * (a + b / r**2 - r**2 / 4 + NU * r**2 / 2)
    rows[:, 2, 3] = r / tube.J
    return rows


def test_shear_flow_balances_the_shear_force():
    """Through every cut z = const. of a wall the shear flow of V_z is V S / I, and signs suit M_y' = V_z."""
    b, h, t = 0.06, 0.04, 0.004
    section = RectangularTube.of(b, h, t)
    shear = shear_functions(b, h, t)
    points, weights = np.polynomial.legendre.leggauss(12)
    y = b / 2 - t / 2 + points * t / 2
    for z in (0.0, 0.3 * h):
        flow = 2 * np.sum(weights * t / 2 * shear.stresses(y, np.full(12, z), NU)[1, 1])
        outside = b * t * (h - t) / 2 + 2 * t * ((h / 2 - t) ** 2 - z**2) / 2
        assert flow == pytest.approx(outside / section.I_y, rel=1e-3)


def test_stress_of_unknown_outline_is_nan():
    assert np.isnan(Section(1e-3, 1e-7, 2e-7, 1e-7).stress(np.ones((6, 2)))).all()


def test_shear_functions_are_cached():
    _rectangle_forms.cache_clear()
    shear_functions.cache_clear()
    for _ in range(3):
        RectangularTube.of(0.04, 0.03, 0.002).stress(np.ones((6, 1)))
    assert shear_functions.cache_info().misses == 1
    assert _rectangle_forms.cache_info().misses == 1
