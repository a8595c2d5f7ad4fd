"""Verification by finite elements: robots agree, the finite elements equal closed forms, and errors are detected."""

import ast
import json
import os
import re
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
import small_robots as sr
import sprung_robots
import vibration_elements
from hybrid_robots import random_hybrid, write_randomly
from package_robots import robot
from places import ROOT
from simple_machines import joint, link, mount, springs, two_columns

import kinetostatics as ks
from kinetostatics import verification
from kinetostatics.cli import main as cli
from kinetostatics.description import Inertia, JointStiffness
from kinetostatics.elements import beam_formulas as beams
from kinetostatics.elements.weights import Weights
from kinetostatics.engine.programs import pose_code
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.load_case import LoadCase
from kinetostatics.verification import OpenSeesError, compare
from kinetostatics.verification import opensees as runner
from kinetostatics.verification import solve as solve_module
from kinetostatics.verification.frame_model import build
from kinetostatics.verification.frequencies import frequencies
from kinetostatics.verification.pieces import Directions
from kinetostatics.verification.solve import _constrained, solve

ROBOTS = sorted(path.name.removesuffix(".urdf.xacro") for path in (ROOT / "robots").glob("*.urdf.xacro"))
#: Robots with spinning rods: without their beams, springs alone may hold them.
SPINNING = ("anymal_standing", "delta")
LOAD, POINT, SIDEWAYS = (120.0, -40.0, -500.0, 7.0, -3.0, 11.0), (0.13, -0.07, 0.05), (3.0, -4.0, 8.0)


def assert_agrees(pose, within=1e-8, **options):
    found = ks.verify(pose, within=within, **options)
    assert found.verified and found.conclusive, str(found)
    assert set(found.ours.joint_wrenches) <= set(found.finite_elements.joint_wrenches)
    return found


# ---- every robot that comes with the package -------------------------------------------------------------------------------


def pose(name, which):
    """Return the closed zero pose (0) or one of three assembled poses without symmetry (1, 2, 3)."""
    one = robot(name)
    if which == 0:
        return one.configuration(one.model_q(one.zero_poses)[:, 0])
    return one.configuration(one.model_q(one.generic_poses)[:, which - 1], closure_tolerance=1e-9)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", ROBOTS)
def test_package_robots_agree_with_finite_elements(name):
    """With forces on all links at a pose without symmetry, and in one of four other ways."""
    at = pose(name, 3)
    assert_agrees(at, load=LOAD, gravity=(0, 0, 1), payload=ks.Payload(300.0, (0.1, 0.05, -0.2)), loads=forces_on_all_links(at))
    others = [
        (0, {}),
        (0, {"load": LOAD, "point": POINT}),
        (1, {"load": LOAD, "point": POINT, "frame": "platform", "gravity": SIDEWAYS}),
        (2, {"gravity": (0, 0, 9.8)}),
    ]
    which, options = others[ROBOTS.index(name) % len(others)]
    assert_agrees(pose(name, which), **options)


def test_compiled_code_agrees_with_finite_elements(tmp_path_factory, monkeypatch):
    """The overconstrained 2PRU-UPR, its loops closed and its statics solved by compiled code, as the report says."""
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path_factory.getbasetemp() / "code"))
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "compiled")
    one = ks.load_robot(ROOT / "robots" / "2pru_upr.urdf.xacro")
    found = assert_agrees(one.assemble(platform={"z": 0.6, "rx": -0.09, "ry": -0.1}), load=LOAD)
    assert pose_code(one, one.statics, "auto", 1) is not None
    by_numpy = ks.analyze(found.configuration, LOAD, engine="numpy")
    np.testing.assert_allclose(found.result.twist, by_numpy.twist, rtol=1e-9)
    assert not np.array_equal(found.result.twist, by_numpy.twist)


def forces_on_all_links(at):
    """Return a force on every link that may carry one: at the origins of rigid links, at both ends of beams."""
    rng, beams = np.random.default_rng(3), ks.analyze(at).beams.values()
    found = {}
    for name in at.robot.description.links:
        if inside_a_joint(at, name):
            continue
        frame = at.frame(name)
        points = [end for beam in beams if beam.description.link == name for end in beam.points[[0, -1]]]
        points = points or [frame[:3, 3] + 0.05 * rng.normal(size=3)]
        found[name] = [
            ks.LinkLoad([*(50 * rng.normal(size=3)), 0, 0, 0], frame[:3, :3].T @ (point - frame[:3, 3]), "link")
            for point in points
        ]
    return found


def inside_a_joint(at, name):
    try:
        ks.analyze(at, loads={name: [0] * 6})
    except ks.ArgumentError as error:
        return "which form one joint" in str(error)
    return False


# ---- natural frequencies -------------------------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize("name", [*ROBOTS, "gough_sps", "four_bar"])
def test_frequencies_of_package_robots_agree_with_finite_elements(name):
    payload = ks.Payload(30.0, (0.1, 0.05, -0.2), Inertia((0.4, 0.05, -0.03, 0.5, 0.02, 0.6)))
    at = pose(name, 1) if name in ROBOTS else sr.robot_of(SPECS[name], twirl=3).assemble()
    found = ks.verify(at, payload=payload, modes=3)
    converged = found.conclusive or name in ("gough_stewart", "orthoglide")  # their finest meshes differ by 6e-5
    assert found.verified and converged, str(found)


@pytest.mark.parts(30)
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(200))
def test_frequencies_of_random_robots_agree_with_finite_elements(seed):
    """Rings, overconstraint, elastic joints, telescopes, spins, masses beside beams; soft ones leave OpenSees fewer digits."""
    mechanism, written = write_randomly(random_hybrid(seed), seed)
    try:
        one = written.robot()
    except ks.RobotFileError:
        pytest.skip("its platform is rigidly fixed to the base")
    at = one.configuration(pin.neutral(one.model))
    ours, theirs = ks.modes(at, 3), frequencies(build(at, LoadCase(np.zeros(6), np.zeros(3))), 3)
    if theirs.scatter > 5e-3:  # as where 0.04 Hz are lost in the stiffness of free directions
        pytest.skip(f"OpenSees is accurate to {theirs.scatter:.0e} here")
    agree = ours.frequencies == pytest.approx(theirs.values, rel=max(1e-5, 3 * theirs.scatter))
    if not agree or ours.zero_frequencies != theirs.zero:  # digits and spins may be lost there, too: other elements decide
        expected, zero = vibration_elements.frequencies(mechanism, written, at, 3)
        assert ours.zero_frequencies == zero
        assert ours.frequencies == pytest.approx(expected, rel=2e-5)


def test_repr_of_a_verification_is_its_title():
    assert repr(ks.verify(robot("3rps").assemble())) == "<Check of '3rps' by finite elements (OpenSees): verified>"


def test_a_rigid_robot_has_no_natural_frequencies():
    """With an elastic actuator it has one."""
    rigid = made_of(PLATFORM, joint("motor", "revolute", "base", "platform", axis="1 0 0"), drives=("motor",))
    found = ks.verify(rigid, modes=2)
    assert found.verified and np.all(np.isinf(found.frequencies))
    one = ks.modes(ks.Robot(rigid.robot.description.with_part(JointStiffness("motor", drive=1e4))).assemble(), 2)
    assert one.frequencies == pytest.approx([np.sqrt(1e4 / 1.04) / (2 * np.pi), np.inf])
    assert re.search(r"motor +100\.0", str(one))
    assert ks.modes(rigid, 2, drives="free").zero_frequencies == 1


@pytest.mark.few(1)
@pytest.mark.parametrize(("factor", "spins"), [(1 + 2e-5, 0), (1, 1)])
def test_wrong_frequencies_are_detected(monkeypatch, factor, spins):
    at = sr.robot_of(sr.cantilever()).assemble()
    wrong = SimpleNamespace(frequencies=ks.modes(at, 2).frequencies * factor, zero_frequencies=spins)
    monkeypatch.setattr(compare, "modes_of", lambda *_, **__: wrong)
    found = ks.verify(at, modes=2)
    assert not found.verified and found.conclusive and "frequencies" in found.verdict and "DIFFERS" in str(found)


# ---- small robots: other joints, spellings, actuators that turn, local freedoms ------------------------------------------

SPECS = {
    "gough_sps": sr.gough("S"),  # six struts that spin
    "gough_rails": sr.gough(telescopic=False),
    "puu3": sr.with_link_masses(sr.puu3()),
    "four_bar": sr.four_bar(),
    "planar_3rrr": sr.planar_3rrr(),
    "chain": sr.locked_chain([(0, 0, 0), (0.5, 0.1, 0), (0.7, 0.2, 0.5)], [(0, 0, 1), (1, 0, 0)], mass=2.0),
    "split": sr.split(sr.pru2_upr(), 3),
    "random": sr.random_spec(["pRpS", "CCP", "rC"], 4),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", SPECS)
def test_small_robots_agree_with_finite_elements(name):
    """Every second robot in turned frames, with other cuts."""
    spec = SPECS[name]
    odd = {"twirl": 3, "whole": False, "flip": True, "cuts": [0] * len(spec.limbs)}
    options = odd if list(SPECS).index(name) % 2 else {}
    assert_agrees(sr.robot_of(spec, **options).assemble(), load=LOAD, gravity=SIDEWAYS)


def beam(carrier, start, end, more='density="7850"', section='<circle diameter="0.05"/>'):
    material = f'youngs_modulus="2e11" poisson_ratio="0.3" {more}'
    return f'<beam link="{carrier}" from="{start}" to="{end}" {material}>{section}</beam>'


def made_of(*parts, drives=()):
    actuated = [f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in drives]
    text = "".join(["<robot name='made'>", link("base"), *parts, '<platform link="platform"/>', *actuated, "</robot>"])
    return ks.Robot(parse_robot_text(text)).assemble()


PLATFORM = link("platform", 4.0, "0.1 0.1 0")
COLUMN = (
    joint("foot", "fixed", "base", "column", "0.8 0 0") + joint("head", "fixed", "column", "platform", "0 0 0.8")
    + link("column") + beam("column", "foot", "head") + PLATFORM
)  # fmt: skip


def telescope(start, *, drives, mass=2.0):
    """A clamped column carries the platform; a telescope stands beside it."""
    return made_of(
        COLUMN, link("cylinder", mass, "0 0 0.1"), link("rod"),
        joint("root", start, "base", "cylinder", axis="0 1 0"),
        joint("slide", "prismatic", "cylinder", "rod", "0 0 0.5", "0 0 1"),
        '<loop name="ball" type="spherical"><predecessor link="rod"><origin xyz="0 0 0.3"/></predecessor>'
        '<successor link="platform"><origin xyz="-0.8 0 0"/></successor></loop>',
        beam("rod", "root", "ball"), drives=drives,
    )  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize("start", ["fixed", "revolute"])
@pytest.mark.parametrize("drives", [(), ("slide",)])
def test_actuated_and_passive_telescopes_agree_with_finite_elements(start, drives):
    found = assert_agrees(telescope(start, drives=drives), load=LOAD, gravity=SIDEWAYS)
    if not drives:  # nothing holds a passive telescope along its axis, not even its own weight
        assert abs(found.finite_elements.joint_wrenches["slide"][2]) < 1e-9


@pytest.mark.few(1)
@pytest.mark.parametrize(("carrier", "masses"), [("cylinder", 0.0), ("middle", 3.0), ("rod", 0.0)])
def test_three_stage_telescope_agrees_with_finite_elements(carrier, masses):
    middle = 0.0 if carrier == "middle" else masses
    configuration = made_of(
        link("cylinder", masses, "0 0 0.1"), link("middle", middle), link("rod", masses), PLATFORM,
        joint("root", "fixed", "base", "cylinder", "0 0 1", rpy="0.3 0.2 0.1"),
        joint("one", "prismatic", "cylinder", "middle", "0 0 0.5", "0 0 1"),
        joint("two", "prismatic", "middle", "rod", "0 0 0.4", "0 0 -1"), joint("tip", "fixed", "rod", "platform", "0 0 0.3"),
        beam(carrier, "root", "tip"), drives=("one", "two"),
    )  # fmt: skip
    assert_agrees(configuration, load=LOAD, gravity=SIDEWAYS)


@pytest.mark.parametrize("elastic", ["", '<joint_stiffness joint="motor" drive="1e5"/>'], ids=["rigid", "elastic"])
def test_actuator_force_includes_mimic_joints(elastic):
    right = joint("follower", "prismatic", "base", "right", "0.8 0 0", "0 0 1")
    right = right.replace("</joint>", '<mimic joint="motor" multiplier="-0.5"/></joint>')
    found = assert_agrees(
        made_of(
            link("left", 1.0), link("right", 2.0), link("rod"), PLATFORM,
            joint("motor", "prismatic", "base", "left", axis="0 0 1"), right,
            joint("foot", "revolute", "left", "rod", axis="0 1 0"), joint("head", "fixed", "rod", "platform", "0 0 0.5"),
            '<loop name="ball" type="spherical"><predecessor link="right"/><successor link="platform"><origin xyz="0.8 0 -0.5"/>'
            "</successor></loop>", beam("rod", "foot", "head"), elastic, drives=("motor",),
        ), load=LOAD, gravity=SIDEWAYS,
    )  # fmt: skip
    wrenches = found.finite_elements.joint_wrenches
    assert found.finite_elements.actuator_forces["motor"] == pytest.approx(wrenches["motor"][2] - 0.5 * wrenches["follower"][2])


def test_hanging_links_agree_with_finite_elements():
    """A pendulum at rest and an actuated arm hang on the platform."""
    pendulum = link("pendulum", 2.0, "0 0 -0.3") + joint("hinge", "continuous", "platform", "pendulum", axis="0 1 0")
    arm = link("arm") + link("hand", 1.0, "0.1 0 0") + joint("shoulder", "revolute", "platform", "arm", "0 0.1 0", "1 0 0")
    hand = joint("wrist", "fixed", "arm", "hand", "0.5 0 0") + beam("arm", "shoulder", "wrist")
    assert_agrees(made_of(COLUMN, pendulum), load=LOAD)
    found = assert_agrees(made_of(COLUMN, arm, hand, drives=("shoulder",)), load=LOAD, gravity=SIDEWAYS)
    assert abs(found.finite_elements.actuator_forces["shoulder"]) < 1e-9  # along the arm


def test_rigid_robot_is_verified_without_stiffness():
    arm = link("arm", 3.0, "0.5 0.5 0.5") + joint("motor", "revolute", "base", "arm", axis="1 0 0")
    found = assert_agrees(made_of(arm, PLATFORM, joint("tip", "fixed", "arm", "platform", "1 0 1"), drives=("motor",)), load=LOAD)
    assert "stiffness" in found.not_compared and "stiffness" not in found.differences


# ---- the finite elements by themselves ---------------------------------------------------------------------------------------


def test_finite_elements_equal_cantilever_formula():
    L, d, E, nu = 1.3, 0.05, sr.E, sr.NU
    A, inertia = np.pi * d**2 / 4, np.pi * d**4 / 64
    model = build(sr.robot_of(sr.cantilever(L)).assemble(), LoadCase((0, 0, -20.0, 0, 0, 0)))
    solution, _ = solve(model)
    q, GA = sr.RHO * A * 9.81, E / (2 * (1 + nu)) * A
    sag = q * L**4 / (8 * E * inertia) + q * L**2 / (2 * GA) + 20 * L**3 / (3 * E * inertia) + 20 * L / GA
    slope = q * L**3 / (6 * E * inertia) + 20 * L**2 / (2 * E * inertia)
    np.testing.assert_allclose(solution.twist, [0, 0, -sag, 0, slope, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(
        solution.joint_wrenches["root"], [0, 0, q * L + 20, 0, -(q * L**2 / 2 + 20 * L), 0], rtol=1e-12, atol=1e-11
    )
    assert solution.compliance[0, 0] == pytest.approx(L / (E * A), rel=1e-12)


# ---- assembly errors -----------------------------------------------------------------------------------------------------------


def test_assembly_errors_agree_with_finite_elements():
    """Of joints and beams, in world axes and in those of a joint; tests/unit/statics/test_assembly_errors.py has closed forms."""
    turned = {"twist": [1e-4, -2e-4, 3e-4, 1e-3, 2e-3, -1e-3], "frame": "joint"}
    errors = {"a": {"length": -1e-4, "temperature": 20}, "foot_b": [1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4], "head_a": turned}
    assert_agrees(two_columns().assemble(), load=LOAD, assembly_errors=errors)


def test_platform_on_six_springs_equals_closed_form():
    """An assembly error displaces the platform by as much."""
    k, error = np.array([1e5, 2e5, 3e5, 400.0, 500.0, 600.0]), 1e-4 * np.arange(1.0, 7.0)
    at = mount(springs("mount", linear="1e5 2e5 3e5", angular="400 500 600")).assemble()
    found = assert_agrees(at, load=LOAD, gravity=(1, 2, -9), assembly_errors={"mount": error})
    expected = (np.array(LOAD) + 3.0 * np.array([1, 2, -9, 0, 0, 0])) / k + error
    np.testing.assert_allclose(found.finite_elements.twist, expected, rtol=1e-9)


# ---- springs -------------------------------------------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
@pytest.mark.parametrize("name", [name for name in ROBOTS if name not in SPINNING])
def test_package_robots_with_springs_agree_with_finite_elements(name, rigid):
    """One to three springs between any links, weights, stiff drives, with beams and without."""
    # springs press the thin beams of this one beyond their own buckling, where neither computation is accurate
    at = sprung_robots.bundled(name, 1, rigid=rigid, stiffer=10.0 if name == "planar_3rrr" else 1.0)
    # some are unstable, or nearly so, and rounding counts
    assert_agrees(at, 1e-6, load=LOAD, payload=ks.Payload(3.0, (0.1, 0.05, -0.2)))


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(21327, id="universal joint in a closed chain on the base"),
        pytest.param(21063, id="universal joint between links that the tree welds"),
        pytest.param(20359, id="elastic slide whose bearing gives way along it, too"),
        pytest.param(21383, id="telescope whose slide is at the platform"),
        pytest.param(21823, id="closed chain that ends inside a ball of three hinges"),
    ],
)
def test_hybrid_robots_with_springs_agree_with_finite_elements(seed):
    assert_agrees(sprung_robots.hybrid(seed), load=LOAD)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="the wrenches of one rod of 22 kN differ by 1.2e-7, the cause is not known")
def test_joint_wrenches_beside_spinning_rods_agree():
    """The wrench of a spherical joint follows the mean of its sides, without the free spins of the rods."""
    found = ks.verify(sprung_robots.bundled("delta", 1, rigid=False), LOAD)
    assert found.differences["joint_wrenches"] < 1e-8


def test_motions_of_the_platform_are_no_spins():
    """Of two motions without stiffness one moves the platform: only the other is excluded as a spin."""
    moving, spin = np.zeros(12), np.zeros(12)
    moving[[0, 7]] = 0.01, 1
    spin[11] = 1
    found = _constrained(1e10 * (np.outer(moving, moving) + np.outer(spin, spin)), np.diag([0.0] * 6 + [1, 0, 1, 1, 1, 0]))
    np.testing.assert_allclose(found, np.eye(12) - np.outer(spin, spin), atol=1e-9)


def test_spins_are_looser_than_all_joints_and_have_no_geometric_stiffness():
    """Relative to the largest geometric stiffness 1e-6; of the stiffness 1e-9 of the stiffest element."""
    looseness = np.zeros(12)
    looseness[7:] = 0.9e9, 1.1e9, 1e10, 1e10, 1e10
    found = _constrained(np.diag(looseness), np.diag([0.0] * 6 + [2.0, 0.0, 0.0, 2.2e-6, 1.8e-6, 0.0]))
    np.testing.assert_allclose(np.diag(found), [1] * 8 + [0, 1, 0, 0], atol=1e-9)


@pytest.mark.slow
def test_strut_on_a_soft_joint_is_not_a_spin():
    """A universal joint holds it, 2e9 times as soft as the stiffest beam; taken for a spin, joint wrenches differ by 4e-6."""
    at = sprung_robots.serial(["CpU", "RRpU", "p", "UpR", "RpS", "rUS"], 10064, 1, rigid=False)
    rigid_drives = replace(at.robot.description, joint_stiffness={})
    assert_agrees(ks.Robot(rigid_drives).configuration(at.q, closure_tolerance=1e-9), load=LOAD)


@pytest.mark.slow
def test_actuator_forces_with_large_geometric_stiffness_agree():
    """A spring holds an arm a million times as stiffly as its drive: loads that follow a first guess leave 2e-6 of the force."""
    spring = """<spring name="spring" stiffness="3e4" free_length="0"><predecessor link="base"><origin xyz="0 0.1 0.4"/>
</predecessor><successor link="platform"/></spring>"""
    at = made_of(
        link("arm"), link("platform"), joint("hinge", "continuous", "base", "arm", axis="0 1 0", rpy="0 -0.5 0"),
        joint("tip", "fixed", "arm", "platform", "0.25 0 0"), beam("arm", "hinge", "tip"), spring,
        '<joint_stiffness joint="hinge" drive="0.01"/>', drives=("hinge",),
    )  # fmt: skip
    assert ks.verify(at, load=LOAD).differences["actuator_forces"] < 1e-10


def hung_up(phi, stiffness=300.0):
    """An arm on a hinge along y with a drive of 10 N·m/rad, turned up by φ, in a spring of no free length."""
    arm = link("arm") + joint("hinge", "continuous", "base", "arm", axis="0 1 0", rpy=f"0 {-phi} 0")
    spring = f'''<spring name="spring" stiffness="{stiffness}" free_length="0"><predecessor link="base"><origin xyz="0 0 0.4"/>
</predecessor><successor link="arm"><origin xyz="0.25 0 0"/></successor></spring>'''
    platform = link("platform") + joint("tip", "fixed", "arm", "platform")
    return made_of(arm, platform, spring, '<joint_stiffness joint="hinge" drive="10"/>', drives=("hinge",))


@pytest.mark.few(1)
@pytest.mark.parametrize("phi", [0.0, 0.8, np.pi / 2, -0.3, -np.pi / 2])
def test_finite_elements_of_arm_with_spring_equal_formula(monkeypatch, phi):
    """10 + k a b sin φ; the stiffness 10 + k b² of stretching and turning of the spring alone is not verified."""
    at, stiffness = hung_up(phi), 10 + 30 * np.sin(phi)
    solution, _ = solve(build(at, LoadCase(np.zeros(6), np.zeros(3))))
    assert 1 / solution.compliance[4, 4] == pytest.approx(stiffness, rel=1e-9)
    assert solution.twist[4] == pytest.approx(-30 * np.cos(phi) / stiffness, rel=1e-9, abs=1e-12)
    right = ks.analyze(at, gravity=(0, 0, 0), on_failure="nan")
    changed = right.compliance * stiffness / 28.75
    monkeypatch.setattr(ks.Result, "compliance", property(lambda self: changed))
    found = ks.verify(at, gravity=(0, 0, 0))
    assert found.conclusive and not found.verified and found.differences["compliance"] > 0.01


@pytest.mark.few(1)
@pytest.mark.parametrize("tension", [1e-2, 1.0, -1.0])
def test_finite_elements_of_beam_with_pulling_spring_equal_formula(tension):
    """A constant pull T along a cantilever, which turns with its chord: 3EI/L³ − (6/5 − 1) T/L."""
    solution, _ = solve(build(pulled(tension), LoadCase(np.zeros(6), np.zeros(3))))
    softer = 3 * sr.E * np.pi * 0.01**4 / 64 / 0.5**3 - 1 / solution.compliance[0, 0]
    assert softer == pytest.approx(tension / 0.5 / 5, rel=1e-4)


def pulled(tension):
    """A slender cantilever, 0.5 m high, in a spring of constant force to its foot."""
    pull = f'''<spring name="pull" stiffness="0" free_length="0" preload="{tension}"><predecessor link="base"/>
<successor link="platform"/></spring>'''
    mast = beam("mast", "root", "tip", 'density="0" shear_coefficient="inf"', '<circle diameter="0.01"/>')
    return made_of(
        link("mast"), link("platform"), joint("root", "fixed", "base", "mast"),
        joint("tip", "fixed", "mast", "platform", "0 0 0.5"), mast, pull,
    )  # fmt: skip


def test_accuracy_of_finite_elements_includes_the_meshes_of_beams(monkeypatch):
    monkeypatch.setattr(solve_module, "ELEMENTS", np.array([2, 3, 4]))
    found = ks.verify(pulled(2000.0), load=LOAD)
    assert not found.verified and "the reference solution is accurate to" in found.verdict
    assert all(found.scatter[name] >= difference for name, difference in found.differences.items())


def test_spherical_joint_with_spring_about_one_axis_agrees():
    """Its moment turns with the mean of its sides, unlike that of a universal joint, with one axis fixed in either side."""
    ends = '<origin xyz="0.1 0.2 {}" rpy="0.4 0.3 0.2"/>'
    ball = f"""<loop name="ball" type="spherical"><predecessor link="base">{ends.format(0.1)}</predecessor>
<successor link="strut">{ends.format(-0.6)}</successor></loop><joint_stiffness joint="ball" angular="inf 2000 0"/>"""
    spring = """<spring name="spring" stiffness="3e5" free_length="0.1"><predecessor link="base"><origin xyz="0.3 0.2 0"/>
</predecessor><successor link="platform"><origin xyz="-0.3 0.3 -0.2"/></successor></spring>"""
    strut = link("strut") + joint("end", "fixed", "platform", "strut", "-0.8 0 -0.1") + beam("strut", "ball", "end")
    assert_agrees(made_of(COLUMN, strut, ball, spring), load=LOAD)


# ---- directions ----------------------------------------------------------------------------------------------------------------


def test_directions_of_edges_from_base_to_platform():
    """From base 0 to platform 9; edges passed in both directions stay as written."""
    brace = Directions({"a": (0, 1), "b": (2, 0), "c": (1, 9), "d": (2, 9), "bridge": (2, 1), "other": (1, 2)}, 0, 9)
    assert [brace.inner_first(edge) for edge in ("a", "b", "c", "d")] == [True, False, True, True]
    assert brace.inner_first("bridge") and brace.inner_first("other")  # passed both ways: as written
    ring = Directions({"a": (0, 1), "b": (9, 1), "out": (3, 1), "one": (3, 4), "two": (4, 3), "end": (4, 5)}, 0, 9)
    assert [ring.inner_first(edge) for edge in ("a", "b", "out", "end")] == [True, False, False, True]
    assert ring.inner_first("one") and ring.inner_first("two")
    pendulum = Directions({"a": (0, 9), "hinge": (1, 9), "arm": (1, 2)}, 0, 9)
    assert [pendulum.inner_first(edge) for edge in ("hinge", "arm")] == [False, True]


def test_finite_elements_do_not_import_the_statics():
    allowed = re.compile(
        r"kinetostatics\.(verification|description|exceptions|math\.(arrays|graphs|linalg)|layout\.mapping|arguments)\b"
        r"|kinetostatics\.(kinematics\.configuration|mechanism\.beam_geometry|load_case)$"
    )
    for name in ("pieces", "frame", "frame_model", "opensees", "solve", "worker"):
        tree = ast.parse((Path(verification.__file__).parent / f"{name}.py").read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("kinetostatics"):
                assert allowed.match(node.module), (name, node.module)


# ---- detection of errors -----------------------------------------------------------------------------------------------------


def too_soft(monkeypatch):
    right = beams.end_displacement
    monkeypatch.setattr(beams, "end_displacement", lambda *args: right(*args) * (1 + 1e-5))


def too_heavy(monkeypatch):
    right = Weights.wrenches
    monkeypatch.setattr(Weights, "wrenches", lambda self, *args: right(self, *args) * (1 + 1e-5))


def wrong_sign(monkeypatch):
    right = ks.Result.actuator_forces.func
    monkeypatch.setattr(ks.Result, "actuator_forces", property(lambda self: {k: -v for k, v in right(self).items()}))


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("mistake", "wrong"),
    [(too_soft, {"twist", "stiffness"}), (too_heavy, {"joint_wrenches", "actuator_forces"}), (wrong_sign, {"actuator_forces"})],
)
def test_wrong_results_are_detected(monkeypatch, mistake, wrong):
    mistake(monkeypatch)
    one = ks.load_robot(ROOT / "robots" / "3rps.urdf.xacro")
    found = ks.verify(one.assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.1}), load=LOAD)
    assert not found.verified
    assert wrong <= {name for name, difference in found.differences.items() if difference > found.within}
    assert found.verdict.startswith("NOT verified") and "DIFFERS" in str(found)


@cache
def right_result():
    return ks.analyze(pose("3rps", 0), LOAD)


def without(numbers, name):
    return {key: value for key, value in numbers.items() if key != name}


#: Results with a loss, and the difference that is then infinite.
LOSSES = {
    "twist": ("twist", lambda right: right * np.nan, "twist"),
    "stiffness": ("stiffness", lambda right: right * np.nan, "stiffness"),
    "wrench": ("joint_wrenches", lambda right: {**right, "prismatic_2": np.full(6, np.nan)}, "joint_wrenches"),
    "joint": ("joint_wrenches", lambda right: without(right, "prismatic_2"), "joint_wrenches"),
    "further joint": ("joint_wrenches", lambda right: {**right, "another": np.zeros(6)}, "joint_wrenches"),
    "beam": ("beams", lambda right: without(right, "rod_2"), "beam_wrenches"),
}


@pytest.mark.few(3)
@pytest.mark.parametrize("loss", LOSSES)
def test_missing_results_are_detected(monkeypatch, loss):
    name, change, wrong = LOSSES[loss]
    changed = change(getattr(right_result(), name))
    monkeypatch.setattr(ks.Result, name, property(lambda self: changed))
    found = ks.verify(pose("3rps", 0), load=LOAD)
    assert not found.verified and found.differences[wrong] == np.inf
    assert [item for item in found.differences.values() if item > found.within] == [np.inf]
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["differences"][wrong] is None
    assert loss in ("twist", "stiffness", "wrench") or found.not_compared


@pytest.mark.few(1)
@pytest.mark.parametrize("end", [0, 1])
def test_both_ends_of_a_beam_are_compared(monkeypatch, end):
    right = compare._ends

    def wrong(beam):
        sections = right(beam).copy()
        sections[end] *= 1 + 1e-4
        return sections

    monkeypatch.setattr(compare, "_ends", wrong)
    found = ks.verify(pose("3rps", 0), load=LOAD)
    assert not found.verified and 1e-6 < found.differences["beam_wrenches"] < 1e-3


@pytest.mark.parametrize("options", [{"load": np.zeros((3, 6))}, {"within": 0.0}, {"frame": "moon"}, {"point": (1, 2)}])
def test_invalid_arguments_raise_argument_error(options):
    with pytest.raises(ks.ArgumentError):
        ks.verify(pose("3rps", 0), **options)


# ---- the command ---------------------------------------------------------------------------------------------------------------


def test_command_prints_statics_and_finite_elements(capsys):
    assert cli.main(["verify", "3rps", "--load", "100", "0", "-500", "0", "0", "0"]) == 0
    printed = capsys.readouterr()
    assert printed.err == "" and printed.out.startswith("Check of '3rps'") and "\nVerified: " in printed.out
    assert "finite elements" in printed.out and "prismatic_3 [N]" in printed.out


def test_command_exits_with_1_where_results_differ(capsys, monkeypatch):
    too_soft(monkeypatch)
    assert cli.main(["verify", "3rps", "--json", "--platform", "z=500mm", "rx=2deg", "ry=0"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["verified"] and 1e-8 < found["differences"]["twist"] < 1e-4
    for side in ("ours", "finite_elements"):
        assert len(found[side]["twist"]) == 6 and np.shape(found[side]["stiffness"]) == (6, 6)
        assert set(found[side]["actuator_forces"]) == {"prismatic_1", "prismatic_2", "prismatic_3"}


# ---- where OpenSees is missing, broken or crashes ------------------------------------------------------------------------------


def test_missing_opensees_error_names_pip_install(capsys, monkeypatch):
    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OpenSeesError, match=r"pip install 'kinetostatics\[verify\]'"):
        ks.verify(pose("3rps", 0))
    assert cli.main(["verify", "3rps"]) == 2
    assert "kinetostatics[verify]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("raise ImportError('libblas.so.3: cannot open')", "cannot be loaded .*libblas3"),
        ("import os; os._exit(3)", "exit code 3"),
        ("logFile = 1", "OpenSees failed: AttributeError"),
    ],
)
def test_broken_opensees_raises_opensees_error(tmp_path, monkeypatch, code, message):
    package = tmp_path / "openseespy" / "opensees"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "__init__.py").write_text(code)
    (tmp_path / "openseespylinux.py").write_text("")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: object())
    with pytest.raises(OpenSeesError, match=message):
        ks.verify(pose("3rps", 0))


def test_hanging_opensees_raises_opensees_error(monkeypatch):
    def hang(*args, **options):
        raise subprocess.TimeoutExpired("opensees", options["timeout"])

    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(runner.subprocess, "run", hang)
    with pytest.raises(OpenSeesError, match="did not finish"):
        ks.verify(pose("3rps", 0))
