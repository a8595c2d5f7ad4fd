"""Natural frequencies against a published benchmark, closed forms, and finite elements on random robots."""

from dataclasses import replace

import hybrid_robots
import numpy as np
import package_robots
import pinocchio as pin
import pytest
import small_robots as sr
import vibration_elements
from mechanisms import Beam, Joint, Link, Stiffness
from places import CASES as FILES
from small_robots import Limb
from threadpoolctl import threadpool_info, threadpool_limits

import kinetostatics as ks
from kinetostatics.description import JointStiffness
from kinetostatics.dynamics import vibrations

#: NAFEMS, Selected Benchmarks for Natural Frequency Analysis, FV5: deep simply supported beam [Hz].
FV5 = [42.650, 42.650, 71.20, 125.00, 148.15, 148.15, 213.61, 283.47, 283.47]


def lowest(spec, count=6, **options):
    return ks.modes(sr.write(spec).robot().assemble(), count, **options)


def test_deep_simply_supported_beam_equals_nafems_fv5():
    """FV5; shear coefficient 10(1 + ν)/(12 + 11ν). The first frequency of the exact equation of such beams is 42.645 Hz."""
    end, section = (10.0, 0.0, 0.0), sr.Section(4.0, 4 / 3, 4 / 3, 0.1406 * 16)
    rod = Limb((Joint("a", "U", (0, 0, 0), (0, 1, 0), (0, 0, 1)), Joint("b", "F", end)), (Link("beam"),))
    support = Limb((Joint("rail", "P", end, (1, 0, 0)), Joint("ball", "S", end)), (Link("slide"),))
    beam = Beam("beam", "beam", "a", "b", section, E=200e9, nu=0.3, density=8000.0, kappa=13 / 15.3)
    found = lowest(sr.Spec((rod, support), (beam,), o=end), 9)
    assert found.frequencies == pytest.approx(FV5, rel=1.3e-4)
    assert found.frequencies[3:] == pytest.approx(FV5[3:], abs=6e-3)
    for k, frequency in enumerate(found.frequencies):
        assert found.count_below(frequency * (1 + 1e-9)) == found.count_below(frequency * (1 - 1e-9)) + (
            1 + (k in (0, 1, 4, 5, 7, 8))
        )


@pytest.mark.parametrize("direction", [(1, 0, 0), (1, 2, -0.5)])
def test_cantilever_with_a_mass_at_its_tip(direction):
    """1 + cos β cosh β + m β (cos β sinh β − sin β cosh β) = 0, of a rod so slender that only bending matters."""
    d, L, mass_ratio = 2e-3, 1.0, 0.7
    spec = sr.cantilever(L, direction, sr.circle(d), kappa=np.inf)
    rod_mass = sr.RHO * np.pi * d**2 / 4 * L
    found = lowest(replace(spec, mass=0.0), 4)
    payload = ks.modes(found.configuration, 4, payload=ks.Payload(mass_ratio * rod_mass))

    def equation(beta, m):
        return 1 + np.cos(beta) * np.cosh(beta) + m * beta * (np.cos(beta) * np.sinh(beta) - np.sin(beta) * np.cosh(beta))

    for modes, m in ((found, 0.0), (payload, mass_ratio)):
        for k in range(2):
            beta = np.linspace(0.5 + 3 * k, 2 + 3 * k, 400_001)
            values = equation(beta, m)
            root = beta[np.flatnonzero(values[:-1] * values[1:] < 0)[0]]
            expected = root**2 / (2 * np.pi * L**2) * np.sqrt(sr.E * np.pi * d**4 / 64 / (rod_mass / L))
            assert modes.frequencies[2 * k : 2 * k + 2] == pytest.approx([expected] * 2, rel=2e-5)


ROBOTS = {
    "gough": sr.gough(),
    "struts between balls": sr.gough("S"),
    "puu3": sr.puu3(),
    "pru2_upr": sr.pru2_upr(),
    "four_bar": sr.four_bar(),
    "planar_3rrr": sr.planar_3rrr(),
    "portal": sr.portal(mass=20.0),
    "link masses": sr.with_link_masses(sr.puu3()),
}


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_frequencies_equal_finite_elements(name):
    spec = ROBOTS[name]
    written = sr.write(spec)
    found = ks.modes(written.robot().assemble(), 5)
    expected, free = vibration_elements.frequencies(sr.mechanism_of(spec), written, found.configuration, 5)
    assert found.zero_frequencies == free
    assert found.frequencies == pytest.approx(expected, rel=3e-6)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(60))
def test_frequencies_of_random_robots_equal_finite_elements(seed):
    """Rings, overconstraint, elastic joints, telescopes, massless parts, masses beside the beams, joints that close loops."""
    mechanism, written = hybrid_robots.write_randomly(hybrid_robots.random_hybrid(seed), seed)
    robot = written.robot()
    found = ks.modes(robot.configuration(pin.neutral(robot.model)), 3)
    expected, free = vibration_elements.frequencies(mechanism, written, found.configuration, 3)
    assert found.zero_frequencies == free
    assert found.frequencies == pytest.approx(expected, rel=2e-5)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["gough", "pru2_upr", "four_bar", "portal"])
def test_massless_limbs_vibrate_with_the_static_stiffness(name):
    """K u = ω² M u of a rigid platform with the stiffness of the analysis."""
    spec = sr.with_beams(ROBOTS[name], density=0.0)
    configuration = sr.write(spec).robot().assemble()
    found = ks.modes(configuration, 6)
    arm = np.array(spec.com) - np.array(spec.o)
    cross = np.cross(np.eye(3), arm).T
    M = np.block([[spec.mass * np.eye(3), spec.mass * cross], [spec.mass * cross.T, np.eye(3) + spec.mass * cross.T @ cross]])
    L = np.linalg.cholesky(M)
    inverse = np.linalg.inv(L)
    squares = np.linalg.eigvalsh(inverse @ ks.analyze(configuration).stiffness @ inverse.T)
    assert found.frequencies == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-9)
    assert found.effective_masses.sum(axis=0) == pytest.approx(1, rel=1e-9)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["gough", "four_bar", "puu3"])
def test_payload_equals_a_heavier_platform(name):
    spec, more = ROBOTS[name], 7.0
    heavy = replace(spec, mass=spec.mass + more)
    payload = ks.Payload(more, center=np.subtract(spec.com, spec.o))
    found, expected = lowest(spec, payload=payload), lowest(heavy)
    assert found.frequencies == pytest.approx(expected.frequencies, rel=1e-12)
    assert found.kinetic_energy_shares["payload"] + found.kinetic_energy_shares["platform"] == pytest.approx(
        expected.kinetic_energy_shares["platform"], rel=1e-9
    )


def test_payload_beside_a_link_named_payload():
    """Two equal masses at the same place move alike, whatever carries them."""
    at = package_robots.robot("delta").assemble()
    link = at.robot.description.links["payload"]
    centre = at.frame("payload")[:3, :3] @ link.center_of_mass + at.frame("payload")[:3, 3] - at.platform_frame[:3, 3]
    shares = ks.modes(at, 3, payload=ks.Payload(link.mass, centre, link.inertia)).kinetic_energy_shares
    assert shares["payload on platform"] == pytest.approx(shares["payload"], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("seed", [2, 4, 18])
def test_motions_without_stiffness_and_mass_are_not_counted(seed):
    """As the spin of a link without moment of inertia between ball joints; their number changed with rounding."""
    found = ks.modes(hybrid_robots.write_randomly(hybrid_robots.random_hybrid(seed), seed)[1].robot().assemble(), 12)
    assert found.count_below(1e-3) == 0
    for k, (below, above) in enumerate(zip(found.frequencies[:-1], found.frequencies[1:], strict=True)):
        assert found.count_below(np.sqrt(below * above)) == k + 1


@pytest.mark.few(3)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_modes_of_package_robots_are_complete_and_orthogonal(name):
    """No mode is missed, modes are orthogonal, energies are equal, and the motions of parts fit together."""
    robot = package_robots.robot(name)
    found = ks.modes(robot.assemble(), 5)
    squares = (2 * np.pi * found.frequencies) ** 2
    for k in range(5):
        below = int(np.sum(found.frequencies < found.frequencies[k] * (1 - 1e-7)))
        assert found.count_below(found.frequencies[k] * (1 - 1e-7)) == below
    chunk = found.chunks[0]
    shapes, model = chunk.pairs.shapes[0], chunk.pairs.model
    K, M = (matrix[0] for matrix in model.pencil(squares[None]))
    for i in range(5):
        assert shapes[i] @ M[i] @ shapes[i] == pytest.approx(1, rel=1e-9)
        assert shapes[i] @ K[i] @ shapes[i] == pytest.approx(squares[i], rel=1e-8)
        for j in range(i):
            if squares[i] - squares[j] > 1e-6 * squares[i]:
                D = [K[n] - squares[n] * M[n] for n in (i, j)]
                mass = shapes[i] @ (D[1] - D[0]) @ shapes[j] / (squares[i] - squares[j])
            else:
                mass = shapes[i] @ M[i] @ shapes[j]
            assert abs(mass) < 1e-7
    for shares in (found.strain_energy_shares, found.kinetic_energy_shares):
        assert sum(shares.values()) == pytest.approx(1, rel=1e-9)
        assert min(float(share.min()) for share in shares.values()) > -1e-9
    masses = chunk.participation[0] ** 2 / np.diagonal(chunk.inertia[0])
    assert masses.sum(axis=0).max() < 1 + 1e-9
    for name, lines in found.beam_lines.items():
        ends = next(item for item in chunk.motions.structure.beams if item.name == name)
        beam = robot.beams[name]
        for body, point, line in zip(
            (ends.inner, ends.outer), beam.ends(chunk.motions.frames), (lines[:, 0], lines[:, -1]), strict=True
        ):
            expected = chunk.of_body(body, point)[0]
            assert np.abs(line - expected).max() < 1e-7 * np.abs(found.twists).max()


def test_free_drives_add_one_zero_frequency_per_freedom():
    for name in ("3rps", "five_bar", "ur10", "tripteron"):
        robot = package_robots.robot(name)
        locked, free = (ks.modes(robot.assemble(), 3, drives=drives) for drives in ("locked", "free"))
        assert free.zero_frequencies - locked.zero_frequencies == robot.mobility.platform
        assert np.all(free.frequencies > locked.frequencies * (1 - 1e-9))


def test_elastic_drives_are_softer_than_locked_ones():
    robot = package_robots.robot("3rps")
    description = robot.description
    for drive in description.actuated:
        description = description.with_part(JointStiffness(drive, drive=1e12))
    stiff, locked = ks.modes(ks.Robot(description).assemble(), 3), ks.modes(robot.assemble(), 3)
    assert stiff.frequencies == pytest.approx(locked.frequencies, rel=1e-3)
    assert np.all(stiff.frequencies[:2] < locked.frequencies[:2])


def test_modes_of_batches_equal_single_poses():
    robot = package_robots.robot("linear_delta")
    z = float(robot.assemble().platform["z"])
    pose = robot.assemble(platform={"x": [0.0, 0.02, 5.0], "y": 0.01, "z": z})
    found = ks.modes(pose, 3)
    for k in range(2):
        single = ks.modes(robot.assemble(platform={"x": [0.0, 0.02][k], "y": 0.01, "z": z}), 3)
        assert found.frequencies[k] == pytest.approx(single.frequencies, rel=1e-10)
        assert found.twists[k] == pytest.approx(single.twists, rel=1e-6, abs=1e-9)
    assert np.all(np.isnan(found.frequencies[2])) and ks.Status(found.status[2]) is ks.Status.UNREACHABLE
    assert np.isnan(found.count_below(100.0)[2]) and found.zero_frequencies[0] == 0
    assert "mode 3" in str(found) and found.to_dict()["frequencies"][2] == [None] * 3


# ---- frequency response --------------------------------------------------------------------------------------------------


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["3rps", "delta", "ur10", "five_bar"])
def test_response_near_zero_frequency_equals_statics(name):
    pose = package_robots.robot(name).assemble()
    found = ks.frequency_response(pose, [1e-3], tool=(0.1, 0, 0.2), damping=0.03)
    C = ks.analyze(pose).at_point((0.1, 0, 0.2)).compliance
    assert np.abs(found.compliance[0] * (1 + 0.06j) - C).max() < 1e-8 * np.abs(C).max()
    arm = found.configuration.platform_frame[:3, :3] @ (0.1, 0, 0.2)
    carried = np.eye(6)
    carried[:3, 3:] = np.cross(np.eye(3), arm).T
    assert np.abs(found.transmissibility[0] - carried).max() < 1e-6


def test_response_far_above_the_first_frequency():
    """Of a fixed rod along x with a mass at its tip: 1 / (k EA cot(k L) − ω² m), k = ω √(ρ/E), up to 1 GHz in a moment."""
    mass, L, area = 3.0, 1.3, np.pi * 0.05**2 / 4
    pose = sr.write(replace(sr.cantilever(L), mass=mass)).robot().assemble()
    frequencies = np.geomspace(1.0, 1e9, 40)
    found = ks.frequency_response(pose, frequencies, damping=0.05)
    omega, s = 2 * np.pi * frequencies, 1 + 0.1j
    k = omega * np.sqrt(sr.RHO / (sr.E * s))
    wave = np.exp(-2j * k * L)  # decays: Im k < 0
    rod = s * k * sr.E * area * 1j * (1 + wave) / (1 - wave)
    assert found.compliance[:, 0, 0] == pytest.approx(1 / (rod - omega**2 * mass), rel=1e-8)
    counted = ks.modes(pose, 2).count_below(1e6)
    assert counted > 1000


@pytest.mark.few(1)
@pytest.mark.parametrize("damping", [0.02, {"mass": 3.0, "stiffness": 2e-5}])
@pytest.mark.parametrize("name", ["3rps", "2pru_upr"])
def test_response_equals_sum_over_modes(name, damping):
    """φ φᵀ / (ω_k² s − ω² c) of forty modes, and for the others their static compliance."""
    pose = package_robots.robot(name).assemble()
    modes, frequencies = ks.modes(pose, 40), np.array([20.0, 90.0, 150.0, 400.0])
    found = ks.frequency_response(pose, frequencies, damping=damping)
    C, shapes, squares = ks.analyze(pose).compliance, modes.twists, (2 * np.pi * modes.frequencies) ** 2
    floor = modes.participation_factors
    for k, omega in enumerate(2 * np.pi * frequencies):
        s, c = (1 + 0.04j, 1) if damping == 0.02 else (1 + 2e-5j * omega, 1 - 3j / omega)
        dynamic = 1 / (squares * s - omega**2 * c)
        expected = np.einsum("k,ki,kj->ij", dynamic, shapes, shapes)
        expected += (C - np.einsum("k,ki,kj->ij", 1 / squares, shapes, shapes)) / s
        assert np.abs(found.compliance[k] - expected).max() < 1e-3 * np.abs(expected).max()
        moved = np.eye(6) + omega**2 * np.einsum("k,ki,kj->ij", dynamic, shapes, floor)
        assert np.abs(found.transmissibility[k] - moved).max() < 0.02 * np.abs(moved).max()


def test_response_of_one_mass_equals_closed_form():
    """1 / (k (1 + 2iζ) − ω² m), and k (1 + 2iζ) times that from the floor, of limbs without mass."""
    spec = sr.with_beams(ROBOTS["portal"], density=0.0)
    pose = sr.write(spec).robot().assemble()
    K = ks.analyze(pose).stiffness * (1 + 0.1j)
    M = np.diag([spec.mass] * 3 + [1.0] * 3)
    frequencies = np.array([3.0, 17.0, 60.0])
    found = ks.frequency_response(pose, frequencies, damping=0.05)
    for k, omega in enumerate(2 * np.pi * frequencies):
        H = np.linalg.inv(K - omega**2 * M)
        assert np.abs(found.compliance[k] - H).max() < 1e-9 * np.abs(H).max()
        assert np.abs(found.transmissibility[k] - H @ K).max() < 1e-8 * np.abs(H @ K).max()


def test_response_is_drawn_and_saved(tmp_path):
    found = ks.frequency_response(package_robots.robot("3rps").assemble(), np.geomspace(10, 500, 50))
    ax = ks.plot.frequency_response(found, "transmissibility", ("x", "z"))
    lines = {line.get_label(): line.get_xydata() for line in ax.get_lines()}
    assert np.allclose(lines["x"][:, 1], np.abs(found.transmissibility[:, 0, 0]))
    found.save(tmp_path / "response.csv")
    table = np.genfromtxt(tmp_path / "response.csv", delimiter=",", skip_header=1)
    assert table.shape == (50, 145) and np.allclose(table[:, 1], np.abs(found.compliance[:, 0, 0]))


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (ks.modes, {"count": 0}, "whole number"),
        (ks.modes, {"count": 1.5}, "whole number"),
        (ks.modes, {"count": 300}, r"count is 300: .* times the cube of coordinates may be at most 5e\+09"),
        (ks.modes, {"count": 10**9}, "count is 1000000000: so many modes are too expensive"),
        (ks.modes, {"drives": "open"}, "locked"),
        (ks.modes, {"payload": 5}, "Payload"),
        (ks.frequency_response, {"frequencies": [0.0, 5.0]}, "positive"),
        (ks.frequency_response, {"frequencies": [5.0, 2e9]}, r"positive numbers up to 1e\+09 \[Hz\]"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": -0.1}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": {"masses": 1.0}}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": True}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": np.True_}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": np.inf}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": np.nan}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": "0.1"}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": {"mass": False}}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "damping": {"stiffness": float("inf")}}, "damping ratio"),
        (ks.frequency_response, {"frequencies": [1.0], "tool": (0.1, 0.2)}, "three numbers"),
    ],
)
def test_invalid_arguments_raise_argument_error(function, arguments, words):
    with pytest.raises(ks.ArgumentError, match=words):
        function(package_robots.robot("3rps").assemble(), **arguments)


@pytest.mark.parametrize(
    ("name", "call"),
    [("eigenpairs", lambda pose: ks.modes(pose, 1)), ("responses", lambda pose: ks.frequency_response(pose, np.array([5.0])))],
)
def test_vibrations_use_one_thread_of_blas(name, call, monkeypatch):
    """Each library of BLAS has three threads before and after."""

    def blas_threads():
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    inner, seen = getattr(vibrations, name), []
    monkeypatch.setattr(vibrations, name, lambda *given: (seen.append(blas_threads()), inner(*given))[1])
    with threadpool_limits(3, "blas"):
        call(package_robots.robot("five_bar").assemble())
        assert seen == [{1}] and blas_threads() == {3}


@pytest.mark.parametrize("scalar", [np.float32, np.float64, np.longdouble, np.int64, np.uint8])
def test_damping_may_be_any_scalar_of_numpy(scalar):
    pose = package_robots.robot("five_bar").assemble()
    for given, plain in ((scalar(1), 1.0), ({"stiffness": scalar(1)}, {"stiffness": 1.0})):
        one, other = (ks.frequency_response(pose, [20.0], damping=damping).compliance for damping in (given, plain))
        assert np.array_equal(one, other)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("two_rigid", np.inf), ("screw_continuous", np.inf), ("mast_on_a_rod", np.inf), ("unstable_inside_a_limb", np.nan)],
)
def test_rigid_and_unstable_robots_have_no_frequencies(name, expected):
    """Rigid or massless robots have no frequency; where a spring pushes a motion away, none has a number."""
    pose = ks.load_robot(FILES / f"{name}.urdf").assemble()
    for drives in ("locked", "free"):
        found = ks.modes(pose, 2, drives=drives)
        np.testing.assert_equal(found.frequencies, [expected] * 2)
        assert ("unstable" if np.isnan(expected) else "no natural frequency") in str(found)
        response = ks.frequency_response(pose, [5.0], drives=drives)
        assert np.all(np.isfinite(response.transmissibility)) == np.isinf(expected)
        assert response.status == found.status == (ks.Status.SINGULAR if np.isnan(expected) else ks.Status.OK)
        assert response.warnings == found.warnings and bool(found.warnings) == np.isnan(expected)


# ---- closed forms and invariances ----------------------------------------------------------------------------------------


def test_two_masses_on_a_shaft_equal_closed_form():
    """√(k (1/J₁ + 1/J₂)) of a rotor with open brakes, a shaft without mass and a disc; k if the brakes hold."""
    L, d = 0.5, 0.02
    joints = (
        Joint("motor", "R", (0, 0, 0), (1, 0, 0), actuated=True),
        Joint("flange", "F", (0.1, 0, 0)),
        Joint("tip", "F", (0.1 + L, 0, 0)),
    )
    limb = Limb(joints, (Link("rotor", 2.0, (0.05, 0, 0)), Link("shaft")))
    beam = Beam("shaft", "shaft", "flange", "tip", sr.circle(d), density=0.0)
    spec = sr.Spec((limb,), (beam,), o=(0.1 + L, 0, 0), mass=3.0, com=(0.1 + L, 0, 0))
    k = sr.E / (2 * (1 + sr.NU)) * np.pi * d**4 / 32 / L
    for drives, stiffness, zero in (("locked", k, 0), ("free", k * 2, 1)):  # both inertias are 1 kg m²
        found = lowest(spec, 5, drives=drives)
        assert found.zero_frequencies == zero
        turning = np.argmax(np.abs(found.twists[:, 3]) / np.linalg.norm(found.twists[:, 3:], axis=1))
        assert found.frequencies[turning] == pytest.approx(np.sqrt(stiffness) / (2 * np.pi), rel=1e-9)


def test_hexapod_on_springs_equals_closed_form():
    """ω² = 6 k n_z²/m along z, 3 k (1 − n_z²)/m across, and 6 k r_z²/J about z: eigenvalues of k Σ $ $ᵀ in closed form."""
    k, m, radius, lean = 4e5, 3.0, 0.3, 0.4
    limbs = []
    for number in range(6):
        angle, side = np.pi / 3 * (number // 2 * 2), 1 - 2 * (number % 2)
        top = radius * np.array([np.cos(angle), np.sin(angle), 0])
        axis = np.array([-np.sin(angle) * side * np.sin(lean), np.cos(angle) * side * np.sin(lean), np.cos(lean)])
        foot, names = top - axis, [f"{kind}{number}" for kind in ("foot", "leg", "ball")]
        first, second = sr.across(axis)
        joints = (
            Joint(names[0], "U", tuple(foot), tuple(first), tuple(second)),
            Joint(names[1], "P", tuple(top - axis / 2), tuple(axis), actuated=True, stiffness=Stiffness(drive=k)),
            Joint(names[2], "S", tuple(top)),
        )
        limbs.append(Limb(joints, (Link(f"cylinder{number}"), Link(f"piston{number}"))))
    found = lowest(sr.Spec(tuple(limbs), (), mass=m), 6)
    across, along = np.sin(lean), np.cos(lean)
    squares = [6 * k * along**2 / m, 3 * k * across**2 / m, 3 * k * across**2 / m]
    squares += [6 * k * (radius * across) ** 2, *[3 * k * (radius * along) ** 2] * 2]  # its moments of inertia are 1 kg m²
    assert (2 * np.pi * found.frequencies) ** 2 == pytest.approx(sorted(squares), rel=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["four_bar", "pru2_upr", "gough"])
def test_frequencies_do_not_depend_on_how_a_file_is_written(name, seed):
    spec = ROBOTS[name]
    expected = lowest(spec, 4)
    rng = np.random.default_rng(seed)
    limbs = len(spec.limbs)
    written = sr.write(spec, tree=int(rng.integers(limbs)), twirl=seed, flip=bool(rng.integers(2)), piece=int(rng.integers(3)))
    found = ks.modes(written.robot().assemble(), 4)
    assert found.frequencies == pytest.approx(expected.frequencies, rel=1e-8)
    sizes = np.linalg.norm(found.twists[:, :3], axis=1)
    assert sizes == pytest.approx(np.linalg.norm(expected.twists[:, :3], axis=1), rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("name", ["four_bar", "planar_3rrr"])
def test_millimetres_and_metres_have_the_same_frequencies(name):
    file = sr.write(sr.in_millimetres(ROBOTS[name]))
    file.text = file.text.replace('="1" i', '="1000" i').replace('izz="1"', 'izz="1000"')  # moments of inertia in t mm²
    found = ks.modes(file.robot().assemble(closure_tolerance=1e-8), 4)
    assert found.frequencies == pytest.approx(lowest(ROBOTS[name], 4).frequencies, rel=1e-8)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["gough", "planar_3rrr"])
def test_splitting_beams_changes_no_frequency(name):
    spec = ROBOTS[name]
    assert lowest(sr.split(spec, 3), 4).frequencies == pytest.approx(lowest(spec, 4).frequencies, rel=1e-9)
