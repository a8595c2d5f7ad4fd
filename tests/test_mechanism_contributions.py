"""The second decoupling of Eq. (12): gravity through attached wrenches, and through the deformation of the limbs."""

from functools import cache

import numpy as np
import pytest

import kinetostatics as ks

LOAD = [120.0, -40, -300, 5, 7, -3]
NAMES = list(ks.robots())


@cache
def result(name):
    return ks.analyze(ks.load_robot(name).assemble(), LOAD, gravity=(0.4, -0.9, -9.7))


def test_the_paper_s_3rps():
    """Configuration 2, Δ_dz: platform −22.0, attached −2.2, deformation −49.9 nm; together −74.1, as in Table 1."""
    robot = ks.load_robot("3rps")
    pose = robot.assemble(platform={"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)}, orientation="tilt_torsion")
    found = ks.analyze(pose, gravity=(0, 0, -9.8))
    ways = found.mechanism_contributions.values()
    nm = [1e9 * sum(way[which][2] for way in ways) for which in ("attached", "deformation")]
    assert nm == pytest.approx([-2.2028, -49.8725], abs=1e-4)
    assert 1e9 * found.contributions["platform_weight"][2] + sum(nm) == pytest.approx(-74.110, abs=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_both_ways_are_those_of_equation_12(name):
    found = result(name)
    scale = max(np.abs(twist).max() for twist in found.contributions.values())
    for limb, ways in found.mechanism_contributions.items():
        mine = found.limbs[limb]
        attached = -found.compliance @ mine.attached_wrenches @ mine.attached_intensities
        np.testing.assert_allclose(ways["attached"], attached, rtol=0, atol=1e-9 * scale)
        if np.linalg.cond(mine.compliance) < 1e12:  # not partly rigid
            pulled = mine.constraint_wrenches @ np.linalg.solve(mine.compliance, mine.sag)
            np.testing.assert_allclose(ways["deformation"], found.compliance @ pulled, rtol=0, atol=1e-8 * scale)
        np.testing.assert_allclose(ways["attached"] + ways["deformation"], found.contributions[limb], rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("name", NAMES)
def test_forces_of_drives_are_split_alike(name):
    found = result(name)
    scale = max(np.abs(force) for force in found.actuator_forces.values())
    for drive, limbs in found.actuator_mechanism_contributions.items():
        for limb, ways in limbs.items():
            whole = found.actuator_contributions[drive][limb]
            assert ways["attached"] + ways["deformation"] == pytest.approx(whole, abs=1e-11 * scale)
            if len(found.actuator_forces) == found.robot.mobility.platform:  # drives that virtual work determines
                assert abs(ways["deformation"]) < 1e-9 * scale


def test_redundant_drives_share_what_deformation_makes():
    found = result("anymal_standing")
    forces = [ways["deformation"] for limbs in found.actuator_mechanism_contributions.values() for ways in limbs.values()]
    assert np.abs(forces).max() > 0.1


def test_misfits_and_batches_keep_their_places():
    robot = ks.load_robot("2pru_upr")
    misfits = {"prismatic_1": [1e-4, 0, 0, 0, 0, 0]}
    poses = robot.assemble(platform={"z": [0.55, 0.6], "rx": 0.05, "ry": -0.1}, orientation="XYZ")
    both, plain = ks.analyze(poses, LOAD, misfits=misfits), ks.analyze(poses, LOAD)
    for limb, ways in both.mechanism_contributions.items():
        for which, twist in ways.items():
            assert twist.shape == (2, 6)
            np.testing.assert_allclose(twist, plain.mechanism_contributions[limb][which], rtol=1e-10, atol=1e-16)
