"""Euler's ratio: closed forms for all ends, runs of beams as one member, and what is said when it buckles."""

import json
from dataclasses import replace

import numpy as np
import package_robots
import pytest
import small_robots as sr
from mechanisms import Joint, Link
from small_robots import E

import kinetostatics as ks
from kinetostatics.buckling.euler_loads import Ends, buckling_ratio
from kinetostatics.files.bundled import robot_path
from kinetostatics.statics.deformation import axial_forces

SECTION = sr.Section(2e-3, 4e-7, 9e-7, 6e-7)
ROOT = 4.493409457909064  # of tan x = x
HELD = {"clamped": (0, 0), "pinned": (0, 1), "guided": (1, 0), "free": (1, 1)}
CASES = (
    ("clamped", "free", 2.0),
    ("pinned", "pinned", 1.0),
    ("clamped", "pinned", np.pi / ROOT),
    ("clamped", "guided", 1.0),
    ("clamped", "clamped", 0.5),
    ("pinned", "guided", 2.0),
)


def ends(first, last):
    made = [[np.eye(2)[None] * HELD[words][kind] for words in (first, last)] for kind in (0, 1)]
    return Ends(np.stack(made[0]), np.stack(made[1]))


def euler(length, factor=1.0, inertia=4e-7):
    return np.pi**2 * E * inertia / (factor * length) ** 2


def pushed(spec, load, **options):
    return ks.analyze(sr.robot_of(spec, **options).assemble(), load=load, gravity=(0, 0, 0))


# ---- the eigenvalue problem ----------------------------------------------------------------------------------------------


@pytest.mark.smoke
@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize(("first", "last", "factor"), CASES)
def test_textbook_columns(first, last, factor, n):
    """Timoshenko and Gere, section 2.1; whether of one piece or of several."""
    length, EI = 1.7, 3.0
    load = np.pi**2 * EI / (factor * length) ** 2
    pieces = length * np.arange(1, n + 1) / (n * (n + 1) / 2)
    stiffness = np.array([np.diag([EI, 2.3 * EI])] * n)
    for around in ((first, last), (last, first)):
        found = buckling_ratio(pieces[None], stiffness, np.full((1, n, 2), -0.8 * load), ends(*around))
        assert found == pytest.approx([0.8], rel=3e-6)


def test_column_under_its_own_weight():
    """Timoshenko and Gere, section 2.12: qL = 7.837 EI / L², clamped below and free above."""
    found = buckling_ratio(np.ones((1, 1)), np.eye(2)[None], np.array([[[-7.8373, 0.0]]]), ends("clamped", "free"))
    assert found == pytest.approx([1.0], rel=2e-5)


def test_stepped_column():
    """Timoshenko and Gere, section 2.14: clamped, EI_1 below and EI_2 above: k_1 l_1 tan(k_1 l_1) · … tan tan = k_1 / k_2 …"""
    lengths, EI = np.array([0.6, 0.9]), np.array([5.0, 2.0])

    def gap(P):
        k = np.sqrt(P / EI)
        return np.tan(k[0] * lengths[0]) * np.tan(k[1] * lengths[1]) - k[0] * EI[0] / (k[1] * EI[1])

    low, high = 0.1, 0.99 * (np.pi / 2 / max(lengths / np.sqrt(EI))) ** 2
    assert gap(low) < 0 < gap(high)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if gap(middle) < 0 else (low, middle)
    stiffness = EI[:, None, None] * np.diag([1.0, 3.0])
    found = buckling_ratio(lengths[None], stiffness, np.full((1, 2, 2), -low), ends("clamped", "free"))
    assert found == pytest.approx([1.0], rel=1e-6)


def test_hinge_across_in_any_direction():
    """Clamped, and hinged about an axis at 0 … 90°: between the softer and the stiffer plane, exact where they part."""
    EI, loads = np.diag([2.0, 5.0]), []
    for angle in np.linspace(0, np.pi / 2, 5):
        axis = np.array([np.cos(angle), np.sin(angle)])  # turns about y let w slope
        turns = np.stack([np.zeros((1, 2, 2)), np.outer(axis, axis)[None]])
        held = Ends(np.zeros((2, 1, 2, 2)), turns)
        loads.append(1 / buckling_ratio(np.ones((1, 1)), EI[None], np.full((1, 1, 2), -1.0), held)[0])
    pinned, clamped = ROOT**2, 4 * np.pi**2
    assert loads[0] == pytest.approx(min(2 * clamped, 5 * pinned), rel=1e-5)
    assert loads[-1] == pytest.approx(min(2 * pinned, 5 * clamped), rel=1e-5)
    assert np.all(np.diff(loads) < 0)


def test_planes_at_once_are_each_by_itself():
    """Axes turned about the member change nothing, whatever the ends."""
    rng = np.random.default_rng(0)
    lengths, forces = np.array([[0.6, 0.9]]), -rng.uniform(0.5, 2, (1, 2, 2))
    stiffness = np.array([np.diag([5.0, 2.0]), np.diag([3.0, 4.0])])
    for first in ((0, 0), (1, 0), (0, 1), (1, 1)):
        for last in ((0, 0), (1, 0), (0, 1)):
            turns = np.array([np.diag(first), np.diag(last)], dtype=float)[:, None]
            held = Ends(np.zeros((2, 1, 2, 2)), turns)
            R = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
            turned = Ends(held.shifts, R @ turns @ R.T)
            found = buckling_ratio(lengths, stiffness, forces, held)
            assert buckling_ratio(lengths, R @ stiffness @ R.T, forces, turned) == pytest.approx(found, rel=1e-11)


# ---- members of robots -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize("direction", [(1, 0, 0), (0.3, -0.5, 0.8)])
def test_a_cantilever_is_one_member_however_it_is_split(n, direction):
    length = 1.5
    spec = sr.split(sr.cantilever(length, direction, section=SECTION, y_axis=(0.1, 1, 0.2), density=0.0), n)
    along = np.array(direction) / np.linalg.norm(direction)
    found = pushed(spec, (*(-0.96 * euler(length, 2) * along), 0, 0, 0), twirl=3)
    assert len(found.beams) == n
    for beam in found.beams.values():
        assert beam.euler_ratio == pytest.approx(0.96, rel=1e-9)
        assert len(beam.member) == n and beam.ends == "clamped and free"
    assert not found.buckles and not any("buckles" in text for text in found.warnings)
    assert sum("96 % of its Euler load" in text for text in found.warnings) == 1
    assert pushed(spec, (*(1e5 * along), 0, 0, 0)).beams["arm"].euler_ratio == 0


def test_beams_of_other_sections_and_corners():
    """A stepped cantilever is one member; an arm with a corner is two, the inner one with a free end, too."""
    stepped = sr.stepped_beam(density=0.0)
    found = pushed(stepped, (*(-1e4 * np.array(stepped.o) / np.linalg.norm(stepped.o)), 0, 0, 0))
    assert len({float(beam.euler_ratio) for beam in found.beams.values()}) == 1
    corner = sr.locked_chain([(0, 0, 0), (1, 0, 0), (1, 0, 1)], [(0, 1, 0), (0, 1, 0)], section=SECTION, y_axis=(0, 1, 0))
    found = pushed(corner, (-1000.0, 0, -1000.0, 0, 0, 0))
    assert [beam.member for beam in found.beams.values()] == [("arm_1",), ("arm_2",)]
    assert all(beam.ends == "clamped and free" for beam in found.beams.values())


@pytest.mark.parametrize(
    ("kind", "words", "factor"), [("S", "pinned", np.pi / ROOT), ("F", "clamped", 0.5), ("U", "pinned", np.pi / ROOT)]
)
def test_ends_by_joints(kind, words, factor):
    """Struts from a clamped foot to a platform that other limbs hold, too."""
    length = 1.2
    spec = sr.portal(height=length, section=SECTION, y_axis=(0, 1, 0), density=0.0)
    limb = spec.limbs[1]
    head = replace(limb.joints[1], kind=kind, axis=(1, 0, 0), **({"axis2": (0, 1, 0)} if kind == "U" else {}))
    spec = replace(spec, limbs=(spec.limbs[0], replace(limb, joints=(limb.joints[0], head))))
    found = pushed(spec, (0, 0, -1e5, 0, 0, 0)).beams["column_2"]
    assert found.ends == ("clamped at both ends" if words == "clamped" else f"clamped and {words}")
    force = -float(found.section_wrenches[0, 0])
    assert found.euler_ratio == pytest.approx(force / euler(length, factor), rel=3e-6)


def test_a_leg_of_a_hexapod_is_pinned_and_its_cylinder_and_rod_are_one():
    robot = package_robots.robot("gough_stewart")
    found = ks.analyze(robot.assemble(), load=(0, 0, -1e5, 0, 0, 0))
    cylinder, rod = found.beams["cylinder_1"], found.beams["rod_1"]
    assert cylinder.member == rod.member == ("cylinder_1", "rod_1")
    assert rod.ends == "pinned at both ends"
    assert cylinder.euler_ratio == rod.euler_ratio > 0


@pytest.mark.parametrize("driven", [True, False])
def test_a_driven_crank_holds_what_hangs_on_its_tip(driven):
    """A parallelogram: the driven side is clamped, and nothing else keeps its tip from going sideways; the other is a strut."""
    length, width = 1.1, 0.7
    limbs, beams = [], []
    for k, x in ((1, 0.0), (2, width)):
        joints = (
            Joint(f"foot_{k}", "R", (x, 0, 0), (0, 1, 0), driven=driven and k == 1),
            Joint(f"head_{k}", "R", (x, 0, length), (0, 1, 0)),
        )
        limbs.append(sr.Limb(joints, (Link(f"side_{k}"),)))
        beams.append(sr.Beam(f"side_{k}", f"side_{k}", f"foot_{k}", f"head_{k}", SECTION, y_axis=(0, 1, 0), density=0.0))
    if not driven:  # held by a third, rigid limb instead
        limbs.append(
            sr.Limb(
                (Joint("foot_3", "R", (0.3, 0, 0), (0, 1, 0), driven=True), Joint("head_3", "R", (0.3, 0, length), (0, 1, 0))),
                (Link("side_3"),),
            )
        )
    spec = sr.Spec(tuple(limbs), tuple(beams), o=(width / 2, 0, length))
    found = pushed(spec, (0, 0, -1e5, 0, 5e4 * (not driven), 0)).beams
    assert found["side_2"].ends == "hinged at both ends" and any(beam.euler_ratio > 0 for beam in found.values())
    assert found["side_1"].ends == ("clamped and hinged, swaying" if driven else "hinged at both ends")
    for name in ("side_1", "side_2"):
        force = max(-float(found[name].section_wrenches[0, 0]), 0)
        softer = euler(length, 2.0 if driven and name == "side_1" else 1.0)  # deflecting along x, about the section's y
        assert found[name].euler_ratio == pytest.approx(force / softer, rel=1e-6)


@pytest.mark.few(1)
@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_splitting_beams_changes_no_ratio(n, seed):
    spec = sr.gough(telescopic=False, seed=seed)
    rng = np.random.default_rng(seed)
    load = (*rng.normal(size=2) * 1e4, -1e5, *rng.normal(size=3) * 1e3)
    one, more = pushed(spec, load), pushed(sr.split(spec, n), load)
    for name, beam in one.beams.items():
        assert more.beams[name].ends == beam.ends
        assert float(more.beams[name].euler_ratio) == pytest.approx(float(beam.euler_ratio), rel=1e-6)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["gough_stewart", "delta", "anymal_standing", "ur10"])
def test_axial_forces_are_those_of_the_beams(name):
    robot = package_robots.robot(name)
    result = ks.analyze(robot.assemble(), load=(30, -20, -500, 4, 5, 6))
    found = axial_forces(robot, result.solutions[0])
    assert set(found) == set(result.beams)
    size = max(float(np.abs(beam.section_wrenches).max()) for beam in result.beams.values())
    for key, beam in result.beams.items():
        np.testing.assert_allclose(found[key][:2, 0], beam.section_wrenches[[0, -1], 0], rtol=1e-9, atol=1e-11 * size)
        assert found[key][2, 0] == pytest.approx(float(beam.length), rel=1e-12)


def test_a_batch_is_its_poses():
    robot = package_robots.robot("3rps")
    poses = robot.assemble(platform={"z": [0.5, 0.55, 0.6], "rx": 0.1, "ry": [0.0, 0.1, -0.1]})
    found = ks.analyze(poses, load=(0, 0, -1e6, 0, 0, 0))
    for k, (z, ry) in enumerate(((0.5, 0.0), (0.55, 0.1), (0.6, -0.1))):
        alone = ks.analyze(robot.assemble(platform={"z": z, "rx": 0.1, "ry": ry}), load=(0, 0, -1e6, 0, 0, 0))
        for name, beam in alone.beams.items():
            assert found.beams[name].euler_ratio[k] == pytest.approx(float(beam.euler_ratio), rel=1e-10)


# ---- what is said ----------------------------------------------------------------------------------------------------------


def test_what_buckles_is_said_first():
    length = 1.0
    robot = sr.robot_of(sr.cantilever(length, section=SECTION, y_axis=(0, 1, 0), density=0.0))
    load = np.zeros((3, 6))
    load[:, 0] = np.array([-0.5, -0.999999, -45.4]) * euler(length, 2)
    batch = ks.analyze(robot.assemble(), load=load)
    assert batch.buckles.tolist() == [False, False, True]
    assert batch.facts["buckles"].tolist() == [False, False, True]
    assert np.all(batch.status == ks.Status.OK)
    assert "BUCKLES" in str(batch)
    found = ks.analyze(robot.assemble(), load=load[2])
    assert found.buckles
    assert str(found).splitlines()[0].startswith("Analysis of 'small': BUCKLES")
    assert found.warnings[0] == "beam arm (clamped and free) buckles: its axial force is 4.54e+03 % of its Euler load"
    assert not any("underestimates" in text for text in found.warnings)
    plain = json.loads(json.dumps(found.to_dict()))
    assert plain["buckles"] is True and plain["beams"]["arm"]["ends"] == "clamped and free"
    assert plain["beams"]["arm"]["member"] == ["arm"]


@pytest.mark.slow
def test_sweeps_tell_what_buckles():
    pytest.importorskip("xarray")
    robot = ks.load_robot(robot_path("3rps"), parameters={"rod_diameter": 0.004})
    z = np.linspace(0.5, 0.7, 5)
    ds = ks.sweep(
        robot_path("3rps"),
        platform={"z": z, "rx": 0.0, "ry": 0.0},
        load=(0, 0, -400, 0, 0, 0),
        parameters={"rod_diameter": [0.004, 0.1]},
    )
    poses = robot.assemble(platform={"z": z, "rx": 0.0, "ry": 0.0})
    alone = ks.analyze(poses, load=(0, 0, -400, 0, 0, 0))
    ratios = np.max([beam.euler_ratio for beam in alone.beams.values()], axis=0)
    assert ds["buckles"].dtype == bool
    thin = ds["buckles"].isel(rod_diameter=0).values.ravel()
    np.testing.assert_array_equal(thin, ratios >= 1)
    assert not ds["buckles"].isel(rod_diameter=1).any()


def test_a_rigid_robot_does_not_buckle():
    limb = sr.Limb((Joint("a", "P", (0, 0, 0), (0, 0, 1), driven=True), Joint("b", "F", (0, 0, 1))), (Link("rod", 1.0),))
    found = pushed(sr.Spec((limb,), (), o=(0, 0, 1)), (0, 0, -1e9, 0, 0, 0))
    assert found.buckles.dtype == bool and not found.buckles
