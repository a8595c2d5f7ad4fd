"""Exact dynamic stiffness of rods against closed forms, and against the general transfer matrix."""

import numpy as np
import pytest

from kinetostatics.elements.rods import Rod

E, NU, RHO, SIDE, LENGTH = 200e9, 0.3, 8000.0, 2.0, 10.0
AREA, INERTIA = SIDE**2, SIDE**4 / 12
SHEAR = 5 / 6 * E / (2 * (1 + NU)) * AREA
TORSION = 0.1406 * SIDE**4 * E / (2 * (1 + NU))
COMPLIANCES = 1 / np.array([E * AREA, SHEAR, SHEAR, TORSION, E * INERTIA, 0.7 * E * INERTIA])
GYRATION = np.array([INERTIA, 0.7 * INERTIA]) / AREA


def rod(eccentricity=None, length=LENGTH):
    return Rod(np.array(length), COMPLIANCES, np.array(RHO * AREA), GYRATION, eccentricity)


@pytest.mark.parametrize("hertz", [0.0, 0.01, 5.0, 30.0, 55.0])
def test_closed_form_equals_matrix_exponential(hertz):
    """Dynamic stiffness of straight rods, and its symmetry, also with eccentric mass."""
    square = np.array((2 * np.pi * hertz) ** 2)
    straight, coupled = rod().dynamic_stiffness(square), rod(np.zeros(3)).dynamic_stiffness(square)
    assert np.abs(straight - coupled).max() < 1e-12 * np.abs(straight).max()
    for found in (straight, rod(np.array([0.3, -0.2, 0.4])).dynamic_stiffness(square)):
        assert np.abs(found - found.T).max() < 1e-12 * np.abs(found).max()


@pytest.mark.parametrize("eccentricity", [None, np.array([0.3, -0.2, 0.4])])
def test_mass_matrix_is_derivative_of_dynamic_stiffness(eccentricity):
    square, item = np.array(3e4), rod(eccentricity)
    K, M = item.pencil(square)
    h = 1.0
    by_differences = (item.dynamic_stiffness(square - h) - item.dynamic_stiffness(square + h)) / (2 * h)
    assert np.abs(M - by_differences).max() < 1e-6 * np.abs(M).max()
    assert np.abs(K - square * M - item.dynamic_stiffness(square)).max() < 1e-12 * np.abs(K).max()


@pytest.mark.parametrize("eccentricity", [None, np.array([0.3, -0.2, 0.4])])
def test_two_half_rods_equal_the_whole_rod(eccentricity):
    """Two halves, the point between them eliminated, have the dynamic stiffness of the whole."""
    square = np.array(4e4)
    whole, half = rod(eccentricity).dynamic_stiffness(square), rod(eccentricity, LENGTH / 2).dynamic_stiffness(square)
    both = np.zeros((18, 18))
    both[:12, :12] += half
    both[6:, 6:] += half
    outer, inner = [*range(6), *range(12, 18)], range(6, 12)
    left = both[np.ix_(outer, outer)] - both[np.ix_(outer, inner)] @ np.linalg.solve(
        both[np.ix_(inner, inner)], both[np.ix_(inner, outer)]
    )
    assert np.abs(left - whole).max() < 1e-11 * np.abs(whole).max()


def test_inertia_of_rigid_motion_is_that_of_a_prism():
    """At λ = 0 a rod that moves as a rigid body has its mass and, about its start, the moments of inertia of a prism."""
    eccentricity, carried = np.array([0.3, -0.2, 0.4]), np.zeros((12, 6))
    carried[:6] = carried[6:] = np.eye(6)
    carried[7, 5], carried[8, 4] = LENGTH, -LENGTH
    M = carried.T @ rod(eccentricity).pencil(np.array(0.0))[1] @ carried
    mass, centre = RHO * AREA * LENGTH, np.array([LENGTH / 2, 0, 0]) + eccentricity
    own = mass * np.diag([GYRATION.sum(), GYRATION[0] + LENGTH**2 / 12, GYRATION[1] + LENGTH**2 / 12])
    expected = np.zeros((6, 6))
    expected[:3, :3] = mass * np.eye(3)
    skew = np.cross(np.eye(3), centre).T
    expected[:3, 3:], expected[3:, :3] = mass * skew, mass * skew.T
    expected[3:, 3:] = own + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    assert np.abs(M - expected).max() < 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("eccentricity", [None, np.array([0.0, 0.5, 0.0]), np.array([0.0, 20.0, -30.0])])
def test_clamped_frequencies_are_above_their_bound(eccentricity):
    """Below the bound no rod with clamped ends vibrates: its dynamic stiffness with a clamped end stays positive."""
    item = rod(eccentricity)
    bound = item.clamped_square()
    assert bound > 0
    half = rod(eccentricity, LENGTH / 2)
    for part in (0.2, 0.6, 0.999):
        middle = half.dynamic_stiffness(part * bound)
        assert np.linalg.eigvalsh(middle[6:, 6:] + middle[:6, :6])[0] > 0


def test_pinned_rod_vibrates_at_timoshenko_frequencies():
    """Bending and shearing of a rod between hinges: (EI k⁴/μ − λ(1 + k²(r² + EI/κGA)) + λ² μ r² / κGA) = 0 with k = nπ/L."""
    item, mu = rod(), RHO * AREA
    for n in (1, 2):
        k, EI, r2 = n * np.pi / LENGTH, 0.7 * E * INERTIA, 0.7 * INERTIA / AREA
        square = np.roots([mu * r2 / SHEAR, -(1 + k**2 * (r2 + EI / SHEAR)), EI * k**4 / mu]).min()
        pieces = 3
        D = rod(length=LENGTH / pieces).dynamic_stiffness(np.array(square))[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])]
        whole = np.zeros((2 * pieces + 2, 2 * pieces + 2))
        for p in range(pieces):
            whole[2 * p : 2 * p + 4, 2 * p : 2 * p + 4] += D
        free = np.delete(np.delete(whole, [0, 2 * pieces], 0), [0, 2 * pieces], 1)
        size = np.sqrt(np.abs(np.diag(free)))
        assert np.abs(np.linalg.eigvalsh(free / np.outer(size, size))).min() < 1e-12
        assert item.clamped_square() > 0


@pytest.mark.parametrize("weak", [4, 5])
@pytest.mark.parametrize("eccentricity", [None, np.array([0.0, 0.05, 0.0])])
def test_bound_of_flat_rods_is_that_of_their_weak_direction(weak, eccentricity):
    """A flat bar, clamped, first bends about its weak axis, at (4.730/L)⁴ EI/μ: below the bound nothing vibrates, and the bound
    is no more than the factor of eccentric mass, two, and a few percent below."""
    side, length = np.array([0.01, 0.1])[:: 1 if weak == 4 else -1], 2.0
    area, inertia = 1e-3, 1e-3 * side**2 / 12
    compliances = 1 / np.array([E * area, E * area / 3, E * area / 3, 0.1 * E * inertia.sum(), *(E * inertia)])
    item = Rod(np.array(length), compliances, np.array(RHO * area), inertia / area, eccentricity)
    exact = (4.730040744862704 / length) ** 4 * E * inertia.min() / (RHO * area)
    bound = item.clamped_square()
    assert (0.95 if eccentricity is None else 0.4) * exact < bound < exact
    half = Rod(np.array(length / 2), compliances, np.array(RHO * area), inertia / area, eccentricity)
    middle = half.dynamic_stiffness(0.999 * bound)
    assert np.linalg.eigvalsh(middle[6:, 6:] + middle[:6, :6])[0] > 0


@pytest.mark.parametrize("weak", [4, 5])
def test_bound_of_rods_with_much_rotary_inertia(weak):
    """Where rotary inertia is all that counts, as of a cage of long cross bars, EI w⁗ + λ μ r² w″ = 0 between clamped ends has
    the lowest λ = 4π² EI / (μ r² L²), with r and EI of the same plane."""
    compliances, gyration = np.full(6, 1e-12), np.full(2, 0.5**2)
    compliances[weak], gyration[weak - 4] = 1e-3, 50.0**2
    item = Rod(np.array(1.5), compliances, np.array(7.0), gyration)
    exact = 4 * np.pi**2 / (1e-3 * 7.0 * 50.0**2 * 1.5**2)
    assert 0.99 * exact < item.clamped_square() < exact


def in_pieces(eccentricity, count, square):
    """Return the dynamic stiffness (n, n) of all points of a rod in equal pieces, from its start to its end."""
    piece, found = rod(eccentricity, LENGTH / count).dynamic_stiffness(square), np.zeros((6 * count + 6,) * 2, square.dtype)
    for k in range(count):
        found[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += piece
    return found


@pytest.mark.parametrize("eccentricity", [None, np.array([0.3, -0.2, 0.4])])
@pytest.mark.parametrize("hertz", [90.0, 403.0, 2011.0])
def test_dynamic_stiffness_above_clamped_frequencies_is_that_of_short_pieces(eccentricity, hertz):
    """All pieces at once, short enough for the power series, with their inner points eliminated; λ is real or complex."""
    for square in (np.array([(2 * np.pi * hertz) ** 2]), np.array([(2 * np.pi * hertz) ** 2 / (1 + 0.04j)])):
        assert 1.2 * np.abs(square[0]) > rod(eccentricity).clamped_square()
        assert 1.2 * np.abs(square[0]) < rod(eccentricity, LENGTH / 100).clamped_square()
        every, outer = in_pieces(eccentricity, 100, square[0]), [*range(6), *range(-6, 0)]
        inner = every[6:-6, 6:-6]
        expected = every[np.ix_(outer, outer)] - every[outer, 6:-6] @ np.linalg.solve(inner, every[6:-6][:, outer])
        found = rod(eccentricity).dynamic_stiffness(square)[0]
        size = np.sqrt(np.abs(np.diag(expected)))
        assert np.max(np.abs(found - expected) / np.outer(size, size)) < 1e-8
        if square.dtype == float:
            assert rod(eccentricity).clamped_modes(square)[0] == np.sum(np.linalg.eigvalsh(inner) < 0) > 0


def test_frequencies_of_a_call_do_not_change_one_another():
    square = (2 * np.pi * np.array([1.0, 50.0, 300.0, 1e4])) ** 2
    found = rod(length=np.array([[LENGTH], [LENGTH / 3]])).dynamic_stiffness(np.array([square, square]))
    for k in range(4):
        for pose, length in enumerate((LENGTH, LENGTH / 3)):
            alone = rod(length=length).dynamic_stiffness(square[k])
            assert np.abs(found[pose, k] - alone).max() < 1e-10 * np.abs(alone).max()


@pytest.mark.parametrize("hertz", [10.0, 1e3, 1e6])
def test_response_of_a_cantilever_equals_tangent_of_the_wave_number(hertz):
    """Extension and torsion of a fixed rod with damping: tan(k L) / (k EA), k = ω √(ρ/E), far above the first frequency."""
    square = np.array([(2 * np.pi * hertz) ** 2 / (1 + 0.04j)])
    flexibility = np.linalg.inv(rod().dynamic_stiffness(square)[0, 6:, 6:])
    polar = GYRATION.sum() * RHO * AREA
    for row, c, mass in ((0, COMPLIANCES[0], RHO * AREA), (3, COMPLIANCES[3], polar)):
        k = np.sqrt(square[0] * mass * c)
        assert flexibility[row, row] == pytest.approx(np.tan(k * LENGTH) / k * c, rel=1e-9)


@pytest.mark.parametrize("fraction", [0.001, 0.02, 0.1, 0.5, 1.0])
def test_inside_of_a_cantilever_equals_closed_forms(fraction):
    """Under a force F across the end F (x² (3L − x) / 6EI + x / κGA); extension at a frequency u sin kx / sin kL."""
    x, L, EI, end = fraction * LENGTH, LENGTH, 0.7 * E * INERTIA, np.array([1.0])
    D, force = rod().dynamic_stiffness(np.zeros(1)), np.zeros(6)
    force[1] = 1e9
    ends = np.append(np.zeros(6), np.linalg.solve(D[0, 6:, 6:], force))
    found = rod().inside(ends[None], (D[0] @ ends)[None], np.zeros(1), fraction)[0]
    expected = [0, 1e9 * (x**2 * (3 * L - x) / (6 * EI) + x / SHEAR), 0, 0, 0, 1e9 * x * (2 * L - x) / (2 * EI)]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-16)
    square = (2 * np.pi * 50.0) ** 2 * end
    k, ends = np.sqrt(square[0] * RHO / E), np.zeros(12)
    ends[6] = 1e-3
    found = rod().inside(ends[None], (rod().dynamic_stiffness(square)[0] @ ends)[None], square, fraction)[0]
    np.testing.assert_allclose(found, [1e-3 * np.sin(k * x) / np.sin(k * L), 0, 0, 0, 0, 0], rtol=1e-9, atol=1e-16)
