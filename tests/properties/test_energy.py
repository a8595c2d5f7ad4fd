"""Springs on robots of all kinds against the second derivative of the energy (:mod:`energy_model`), and closed forms.

Stiffness, displacement and stability of robots with springs follow from the energy of springs and weights in displaced poses.
A few random ones by default;

    KINETOSTATICS_RANDOM_ROBOTS=5000 python -m pytest -q tests/properties/test_energy.py

tries that many.
"""

import os

import energy_model
import numpy as np
import package_robots
import pytest
import simple_machines as sm
import small_robots as sr
import sprung_robots
from energy_structure import structure_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from places import ROOT

import kinetostatics as ks
from kinetostatics.load_case import LoadCase
from kinetostatics.verification.frame_model import build

COUNT = int(os.environ.get("KINETOSTATICS_RANDOM_ROBOTS", "2"))
LOAD = (10.0, 20.0, -30.0, 1.0, 2.0, 3.0)
CLOSE = 1e-7


def assert_matches_energy(pose):
    """Compare with the energy; return whether the pose is far enough from singular ones."""
    structure = structure_of(pose, LOAD)
    answer = energy_model.at_the_pose(structure, stiffening_loads=False)
    if answer.gap < 1e5:
        return False
    result = ks.analyze(pose, LOAD, on_failure="nan")
    unit = np.repeat([1.0, pose.robot.length], 3)
    rigid = 1e-4 * structure.length / structure.force
    for found, wanted, scale, least in (
        (result.compliance, answer.compliance, np.outer(unit, unit), rigid),
        (result.twist, answer.twist, unit, rigid * np.linalg.norm(LOAD)),
        (sum(result.contributions.values()), answer.twist, unit, rigid * np.linalg.norm(LOAD)),
    ):
        size = max(float(np.linalg.norm(wanted * scale)), least)
        assert np.linalg.norm((found - wanted) * scale) <= CLOSE * size
    assert unstable(result) == (answer.negative > 0), (result.warnings, answer.negative)
    return True


def unstable(result):
    return any("unstable" in item for item in result.warnings)


# ---- random robots -------------------------------------------------------------------------------------------------------------

RIGID = sorted(set(package_robots.NAMES) - {"anymal_standing", "orthoglide"})


@pytest.mark.few(1)
@pytest.mark.parametrize("name", RIGID)
def test_sprung_package_robots_match_second_derivative_of_energy(name):
    judged = 0
    for seed in range(3):
        pose = sprung_robots.bundled(name, seed)
        judged += assert_matches_energy(pose)
    assert judged


@settings(max_examples=COUNT, deadline=None)
@given(
    st.lists(st.sampled_from(sr.LIMBS), min_size=1, max_size=6).filter(lambda limbs: sum(map(sr.wrenches, limbs)) >= 6),
    st.integers(0, 2**31),
)
def test_sprung_random_robots_match_second_derivative_of_energy(kinds, seed):
    try:
        pose = sprung_robots.serial(kinds, seed)
    except ks.KinetostaticsError:
        assume(False)
    assume(assert_matches_energy(pose))


@pytest.mark.few(2)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_every_part_of_a_stiff_robot_is_in_equilibrium(name):
    """Forces of joints, beams, springs, weights and loads on each part add up to zero."""
    at = sprung_robots.bundled(name, 2, rigid=False, stiffer=1e8)
    result, gravity = ks.analyze(at, LOAD), np.array([0, 0, -9.81])
    model = build(at, LoadCase(LOAD, gravity))
    left = model.loads.copy()

    def put(piece, wrench, point):
        left[piece] += np.append(wrench[:3], wrench[3:] + np.cross(point - model.references[piece], wrench[:3]))

    for joint in model.joints:
        if joint.name in result.joint_wrenches:
            for piece, sign in zip(joint.pieces, (-1, 1), strict=True):
                put(piece, sign * result.joint_wrenches[joint.name], joint.point)
    for beam in model.beams:
        sections = result.beams[beam.name].section_wrenches[[0, -1]].reshape(2, 2, 3) @ result.beams[beam.name].axes.T
        for piece, sign, wrench, point in zip(beam.pieces, (1, -1), sections.reshape(2, 6), beam.points, strict=True):
            put(piece, sign * wrench, point)
    whole = list(range(len(left)))  # pieces of the base, or of the platform, are one part
    for joint in model.joints:
        if joint.name in model.outside_limbs:
            first, second = (whole[piece] for piece in joint.pieces)
            whole = [first if root == second else root for root in whole]
    size = max(float(np.linalg.norm(wrench[:3])) for wrench in result.joint_wrenches.values())
    for part in set(whole) - {whole[model.base]}:
        pieces = [piece for piece, root in enumerate(whole) if root == part]
        about = model.references[part]
        total = sum(np.append(left[k, :3], left[k, 3:] + np.cross(model.references[k] - about, left[k, :3])) for k in pieces)
        assert np.abs(total).max() < 1e-6 * size, part


# ---- closed forms --------------------------------------------------------------------------------------------------------------


def arm(drive):
    """Return a massless arm on an actuated hinge along y, held by a spring of zero free length."""
    return sm.robot(
        sm.link("ground"), sm.link("platform"), sm.joint("hinge", "continuous", "ground", "platform"),
        '<transmission name="drive"><joint name="hinge"/></transmission>', sm.springs("hinge", drive=drive),
        '<spring name="spring" stiffness="300" free_length="0"><predecessor link="ground"><origin xyz="0 0 0.4"/></predecessor>',
        '<successor link="platform"><origin xyz="0.25 0 0"/></successor></spring>',
    )  # fmt: skip


@pytest.mark.parametrize("drive", [1e-3, 1e-6])
def test_spring_holds_an_arm_on_a_weak_drive(drive):
    """The rotation is −k a b cos φ / (d + k a b sin φ), with a drive stiffness d much smaller than that of the spring."""
    phi = np.radians([20.0, 45, 90, 130])
    result = ks.analyze(arm(drive=drive).assemble(actuators={"hinge": -phi}))
    twist = -30 * np.cos(phi) / (drive + 30 * np.sin(phi))
    np.testing.assert_allclose(result.twist[:, 4], twist, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(result.actuator_forces["hinge"], -drive * twist, rtol=1e-12, atol=1e-12 * drive)


def leg(tension):
    """Return an actuated hinge with 1,000 N·m/rad, an actuated slide of 0.5 m, and a spring between the leg's two parts."""
    spring = f'<spring name="inside" stiffness="0" free_length="0" preload="{tension}"><predecessor link="cylinder"/>'
    return sm.robot(
        sm.link("ground"), sm.link("cylinder"), sm.link("platform"), sm.joint("hinge", "revolute", "ground", "cylinder"),
        sm.joint("slide", "prismatic", "cylinder", "platform", axis="0 0 1"), sm.springs("hinge", drive=1000),
        '<transmission name="a"><joint name="hinge"/></transmission><transmission name="b"><joint name="slide"/></transmission>',
        f'{spring}<successor link="platform"/></spring>' if tension else "",
    )  # fmt: skip


@pytest.mark.parametrize("tension", [0, 500, 2000, -2000])
def test_a_spring_inside_a_leg_has_no_effect_outside(tension):
    result = ks.analyze(leg(tension).assemble(actuators={"hinge": 0.0, "slide": 0.5}), (10, 0, 0, 0, 0, 0), (0, 0, 0))
    np.testing.assert_allclose(result.twist[[0, 4]], [0.0025, 0.005], rtol=1e-9)
    assert float(result.actuator_forces["hinge"]) == pytest.approx(-5, rel=1e-9)
    assert float(result.actuator_forces["slide"]) == pytest.approx(tension, rel=1e-9, abs=1e-9)
    np.testing.assert_allclose(result.joint_wrenches["hinge"], [-10, 0, 0, 0, -5, 0], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(result.base_wrench, [-10, 0, 0, 0, -5, 0], rtol=1e-9, atol=1e-6)


def test_instability_inside_a_limb_is_detected():
    """A spring pushes on a link between two beams beyond their lateral stiffness, in two directions."""
    pose = ks.load_robot(ROOT / "tests" / "cases" / "unstable_inside_a_limb.urdf").assemble()
    assert energy_model.at_the_pose(structure_of(pose)).negative == 2
    result = ks.analyze(pose, on_failure="nan")
    assert unstable(result), str(result)
