"""Links by their matrices: statics and mass against closed forms and frames of beams, and what is refused."""

import numpy as np
import pytest
from finite_elements import element
from frame_links import EA, EI_Y, EI_Z, EXPANSION, GA, GJ, LINE_DENSITY, Frame, L, beam_gravity, beam_stiffness

import kinetostatics as ks
from kinetostatics.description import LinkMatrices

ENDS = ("start", "end"), [[0, 0, 0], [L, 0, 0]]
THERMAL = EXPANSION * EA * np.array([-1.0, *[0] * 5, 1.0, *[0] * 5])


def beam(**changes):
    return LinkMatrices(*ENDS, **{"stiffness": beam_stiffness(), **changes})


def changed(matrix, *entries):
    result = np.array(matrix)
    for row, column, value in entries:
        result[row, column] = value
    return result


# ---- statics -------------------------------------------------------------------------------------------------------------


def test_uniform_beam_has_the_closed_forms_of_a_cantilever():
    link = beam(gravity=beam_gravity(), thermal=THERMAL)
    F = np.diag([L / EA, L**3 / (3 * EI_Z) + L / GA, L**3 / (3 * EI_Y) + L / (0.8 * GA), L / GJ, L / EI_Y, L / EI_Z])
    F[1, 5] = F[5, 1] = L**2 / (2 * EI_Z)
    F[2, 4] = F[4, 2] = -(L**2) / (2 * EI_Y)
    scale = np.sqrt(np.outer(np.diag(F), np.diag(F)))
    assert np.abs((link.flexibility("start") - F) / scale).max() < 1e-11
    assert link.interfaces == 2 and link.internal == 0 and link.coordinates[7] == "Ty of end"
    sag, q = link.displacements_by_gravity("start"), LINE_DENSITY
    assert sag[0, 0] == pytest.approx(q * L**2 / (2 * EA)) and np.abs(sag[1:, 0]).max() < 1e-18
    assert sag[[1, 5], 1] == pytest.approx([q * L**4 / (8 * EI_Z) + q * L**2 / (2 * GA), q * L**3 / (6 * EI_Z)])
    assert sag[[2, 4], 2] == pytest.approx([q * L**4 / (8 * EI_Y) + q * L**2 / (1.6 * GA), -q * L**3 / (6 * EI_Y)])
    assert link.displacements_by_heat("start") == pytest.approx([EXPANSION * L, 0, 0, 0, 0, 0], abs=1e-18)
    assert link.displacements_by_heat(1) == pytest.approx([-EXPANSION * L, 0, 0, 0, 0, 0], abs=1e-18)


@pytest.mark.parametrize("modal", [False, True])
@pytest.mark.parametrize(("ports", "inner"), [(2, 1), (3, 2), (4, 3), (3, 0)])
def test_frames_of_beams_deform_as_when_solved_as_a_whole(modal, ports, inner):
    frame = Frame(seed=10 * ports + inner, ports=ports, inner=inner)
    names, origins, matrices = frame.link(modal)
    link = LinkMatrices(names, origins, **matrices)
    assert link.internal == 6 * inner
    for held in range(ports):
        free = [k for k in range(len(frame.K)) if k // 6 != held]
        others = [k for k in range(6 * ports) if k // 6 != held]
        inverse = np.zeros_like(frame.K)
        inverse[np.ix_(free, free)] = np.linalg.inv(frame.K[np.ix_(free, free)])
        whole = (frame.turn.T @ inverse @ frame.turn)[np.ix_(others, others)]
        scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
        assert np.abs((link.flexibility(names[held]) - whole) / scale).max() < 1e-8
        sag = (frame.turn.T @ inverse @ frame.M @ frame.rigid[:, :3])[others]
        assert np.abs(link.displacements_by_gravity(held) - sag).max() < 1e-8 * np.abs(sag).max()
    ports_only = (frame.turn.T @ frame.rigid)[: 6 * ports]
    assert np.abs(link.rigid_motions[: 6 * ports] - ports_only).max() < 1e-14
    assert np.abs(link.mean_motion @ link.rigid_motions - np.eye(6)).max() < 1e-14


def test_modes_of_a_frame_are_those_of_the_whole_frame():
    frame = Frame()
    names, origins, matrices = frame.link(modal=True)
    link = LinkMatrices(names, origins, **matrices)

    def squares(K, M):
        root = np.linalg.inv(np.linalg.cholesky(M))
        return np.linalg.eigvalsh(root @ K @ root.T)

    assert squares(link.stiffness, link.mass)[6:] == pytest.approx(squares(frame.K, frame.M)[6:], rel=1e-8)


# ---- mass ----------------------------------------------------------------------------------------------------------------


def test_body_is_that_of_the_frame_and_differences_are_named():
    frame = Frame(seed=3)
    names, origins, matrices = frame.link()
    link, (mass, centre, inertia) = LinkMatrices(names, origins, **matrices), frame.body()
    own = link.body
    assert own[0] == pytest.approx(mass) and own[1] == pytest.approx(centre) and own[2] == pytest.approx(inertia)
    assert link.differences(mass, centre, inertia) == []
    assert "kg is given" in link.differences(1.02 * mass, centre, inertia)[0]
    (words,) = link.differences(mass, centre + np.array([0, 0, 0.02]), inertia)
    assert words.startswith("the centre of mass is at (") and words.endswith(" m is given")
    off = np.array(inertia)
    off[0, 2] = off[2, 0] = off[0, 2] + 0.1 * inertia.max()
    (words,) = link.differences(mass, centre, off)
    assert words.startswith("ixz about the centre of mass is ")


def test_body_rides_on_the_mean_of_the_interfaces():
    mass, centre, inertia = 2.5, np.array([0.2, -0.05, 0.03]), np.diag([0.01, 0.02, 0.025])
    link = beam().with_body(mass, centre, inertia)
    assert link.body[0] == pytest.approx(mass) and link.body[1] == pytest.approx(centre)
    assert link.body[2] == pytest.approx(inertia, abs=1e-12)
    # half of its weight and of its moment about the mean point at each end
    loads = np.zeros(12)
    for node, x in ((0, 0.0), (6, L)):
        loads[node : node + 3] = [0, 0, mass / 2]
        loads[node + 3 : node + 6] = mass / 2 * np.cross(centre - [x, 0, 0], [0, 0, 1])
    assert link.gravity_loads[:, 2] == pytest.approx(loads, abs=1e-14)
    assert (
        beam().with_body(0, centre, inertia).mass is None and beam().body is None and beam().differences(1, centre, inertia) == []
    )
    assert not beam().gravity_loads.any()
    assert link.with_body(7, centre, inertia) is link


# ---- construction --------------------------------------------------------------------------------------------------------


def test_arrays_are_read_only_copies_and_links_compare():
    given = beam_stiffness()
    link = beam(stiffness=given, thermal=THERMAL)
    given[:] = 0
    assert link.stiffness[0, 0] == pytest.approx(EA / L) and link.rotations.shape == (2, 3, 3)
    for array in (link.stiffness, link.origins, link.condensed, link.flexibility(0), link.rigid_motions, link.thermal):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert link == beam(thermal=THERMAL) != beam() and hash(link) == hash(beam()) and link != 3


def test_rounding_errors_of_thermal_loads_are_accepted():
    noise = THERMAL[6] * 1e-9 * np.random.default_rng(0).normal(size=12)
    assert beam(thermal=THERMAL + noise).displacements_by_heat(0)[0] == pytest.approx(EXPANSION * L, rel=1e-6)


def test_rounded_entries_are_accepted_and_their_forces_in_rigid_motions_removed():
    rounded = np.vectorize(lambda number: float(f"{number:.6g}"))(beam_stiffness())
    link = beam(stiffness=rounded)
    residual = link.stiffness @ link.rigid_motions
    assert np.abs(rounded @ link.rigid_motions).max() > 1 and np.abs(residual).max() < 1e-6
    assert link.flexibility(0) == pytest.approx(beam().flexibility(0), rel=1e-4, abs=1e-15)
    assert beam(stiffness=link.stiffness) == link


def test_forces_in_rigid_motions_are_removed_once_and_rounding_stays():
    """A stiffness whose forces in rigid-body motions are rounding is kept, digit for digit, however often a link is made."""
    frame = Frame(seed=3, ports=4, inner=2)
    names, origins, matrices = frame.link()
    given = (matrices["stiffness"] + matrices["stiffness"].T) / 2
    made = LinkMatrices(names, origins, **{**matrices, "stiffness": given})
    scales = np.sqrt(np.diag(given))
    sums = np.outer(scales, np.abs(scales[:, None] * made.rigid_motions).max(0))
    assert np.abs(given @ made.rigid_motions / sums).max() > 1e-17
    np.testing.assert_array_equal(made.stiffness, given)
    # larger ones are removed
    noise = np.random.default_rng(0).normal(size=given.shape)
    noisy = given + 1e-11 * np.outer(scales, scales) * (noise + noise.T)
    made = LinkMatrices(names, origins, **{**matrices, "stiffness": noisy})
    before, after = (np.abs(stiffness @ made.rigid_motions / sums).max() for stiffness in (noisy, made.stiffness))
    assert before > 1e-12 and after < 1e-14
    assert LinkMatrices(names, origins, **{**matrices, "stiffness": made.stiffness}) == made


def test_coupling_whose_interfaces_coincide_is_the_inverse_of_its_stiffness():
    """A bush without length: its forces are those of the difference of its ends, and it has no arm."""
    own = np.diag([2e7, 3e7, 4e7, 5e3, 6e3, 7e3])
    own[0, 4] = own[4, 0] = 1e5
    link = LinkMatrices(("in", "out"), np.full((2, 3), 0.3), stiffness=np.block([[own, -own], [-own, own]]), thermal=np.zeros(12))
    scale = np.sqrt(np.outer(np.diag(own), np.diag(own)))
    assert np.abs(link.flexibility("in") * scale - np.linalg.inv(own / scale)).max() < 1e-12


def test_link_without_mass_in_its_matrix_is_refused_without_warnings():
    with np.errstate(all="raise"), pytest.raises(ks.ArgumentError, match="mass: the link has a mass of 0 kg; a positive one"):
        beam(mass=np.zeros((12, 12)))


K = beam_stiffness()
HINGE = K - np.outer(K[:, 11], K[11]) / K[11, 11] + np.diag([*[0] * 11, 1e-9])
TURNED = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURNED *= np.linalg.det(TURNED)
WITHOUT_TORSION = np.kron(np.eye(4), TURNED.T) @ element(L, EA, GA, GA, 1e-9, EI_Y, EI_Z) @ np.kron(np.eye(4), TURNED)
#: Of two bodies at the ends, which have 2 kg at (0.3, 0, 0) together.
MASS = np.diag([2 * (1 - 0.3 / L)] * 3 + [1.0] * 3 + [2 * 0.3 / L] * 3 + [1.0] * 3)


def surface():
    """Three points that move with the start of the beam."""
    points = np.array([[0, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    turned = np.stack([np.cross(axis, points) for axis in np.eye(3)], axis=2)
    recovery = np.concatenate([np.tile(np.eye(3), (3, 1, 1)), turned, np.zeros((3, 3, 6))], axis=2)
    return {"points": points, "triangles": [[0, 1, 2]], "recovery": recovery}


SURFACE = surface()


def test_surface_follows_rigid_motions_and_is_compared():
    link = beam(**SURFACE)
    assert link.triangles.dtype == np.int64 and link != beam() and link.digest != beam().digest and link == beam(**SURFACE)
    np.testing.assert_allclose(link.recovery @ link.rigid_motions, link.recovery[:, :, :6], atol=1e-15)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"names": ("start",)}, "names: start; two or more interfaces with different names would be right"),
        ({"names": ("a", "a")}, "names: a, a; two or more"),
        ({"origins": [[0, 0, 0]]}, r"origins has the shape \(1, 3\); \(2, 3\) would be right for 2 interfaces"),
        ({"stiffness": K[:9, :9]}, r"stiffness has the shape \(9, 9\); \(12, 12\) would be right"),
        ({"stiffness": 3.0}, r"stiffness has the shape \(\); \(12, 12\) would be right"),
        ({"mass": np.eye(18)}, r"mass has the shape \(18, 18\); \(12, 12\) would be right"),
        ({"gravity": np.zeros(12)}, r"gravity has the shape \(12,\); \(12, 3\) would be right"),
        ({"stiffness": "hard"}, "stiffness is no array of numbers"),
        ({"stiffness": changed(K, (2, 3, np.nan))}, r"stiffness: the entry \[2, 3\] is nan; a finite number would be right"),
        ({"rotations": np.diag([1, 1, -1])}, r"rotations: that of start is no rotation \(left-handed\)"),
        ({"rotations": 2 * np.eye(3)}, r"rotations: that of start is no rotation \(residual 3\)"),
        (
            {"stiffness": changed(K, (1, 5, 7.0))},
            r"stiffness is not symmetric: the entry in row Ty of start, column Rz of start, is 7, but 2\d+\.?\d* with row and "
            r"column exchanged \(residual 0\.\d+\)",
        ),
        ({"stiffness": changed(K, (3, 3, 0.0))}, "stiffness: the entry on the diagonal at Rx of start is 0; a positive"),
        (
            {"origins": [[0, 0, 0], [1000 * L, 0, 0]]},
            r"a rigid rotation about [yz] of the link causes a force along .* \(residual .*origins are in metres",
        ),
        (
            {"stiffness": K + np.diag([*[0] * 6, EA / L, *[0] * 5])},
            "rigid translation along x of the link causes a force along Tx of end",
        ),
        (
            {"stiffness": changed(K, (0, 0, 1.0001 * K[0, 0]))},
            r"translation along x of .* force along Tx of start \(residual 5e-05",
        ),
        ({"stiffness": HINGE}, r"rigid rotation about z of the link causes a force along Rz of end \(residual 1\)"),
        (
            {"stiffness": WITHOUT_TORSION, "rotations": TURNED},
            r"the link has no stiffness against a motion that is no rigid-body motion, most along R\w of \w+ \(eigenvalue",
        ),
        ({"stiffness": K - 2 * np.outer(THERMAL, THERMAL) / (EXPANSION**2 * EA * L)}, "on the diagonal at Tx of start"),
        ({"mass": -MASS}, "mass: the link has a negative mass in a motion, most along"),
        ({"mass": changed(MASS, (0, 1, 5.0))}, "mass is not symmetric: the entry in row Tx of start, column Ty of start, is 5"),
        (
            {"mass": MASS + np.diag([1.0, *[0] * 11])},
            r"mass: in sum, a rigid translation along x has 3 for an acceleration along x .*2\.33333 kg",
        ),
        ({"gravity": -beam_gravity()}, "gravity: the link has a mass of -6.58 kg; a positive one would be right"),
        (
            {"gravity": beam_gravity(), "mass": MASS},
            r"loads are those of 6\.58 kg at \(0\.35, 0, 0\) m, but mass has 2 kg at \(0\.3, 0",
        ),
        ({"points": [[0, 0, 0]]}, "points, triangles, recovery: all of them, or none, would be right"),
        (SURFACE | {"triangles": [[0, 1, 3]]}, "triangles: numbers of points, 0 to 2, would be right"),
        (SURFACE | {"recovery": np.zeros((2, 3, 12))}, r"recovery has the shape \(2, 3, 12\); \(3, 3, 12\) would be right"),
        (
            SURFACE | {"points": [[0, 0, 0], [0, 0.1, 0], [0, 0, 100.0]]},
            r"recovery: in a rigid rotation about [xy] of the link the point 2 moves otherwise \(residual .*, by unit",
        ),
        ({"thermal": np.abs(THERMAL)}, r"thermal: its loads do work in a rigid translation along x of the link \(residual 1\)"),
    ],
)
def test_wrong_data_are_refused_with_one_sentence(changes, said):
    names, origins = changes.pop("names", ENDS[0]), changes.pop("origins", ENDS[1])
    with pytest.raises(ks.ArgumentError, match=said) as refused:
        LinkMatrices(names, origins, **{"stiffness": K, **changes})
    assert "\n" not in str(refused.value)


def test_negative_stiffness_of_a_motion_is_refused():
    frame = Frame(seed=5)
    names, origins, matrices = frame.link(modal=True)
    stiffness = matrices.pop("stiffness")
    stiffness[18:20, 18:20] += 2 * stiffness[18, 18] * np.array([[0, 1], [1, 0]])
    with pytest.raises(ks.ArgumentError, match=r"negative stiffness against a motion .*, most along internal [12]"):
        LinkMatrices(names, origins, stiffness=stiffness, **matrices)


def test_unknown_interfaces_are_named():
    with pytest.raises(ks.ArgumentError, match="no interface 'middle'; it has start, end"):
        beam().flexibility("middle")
