"""The second decoupling of Eq. (12): gravity through attached wrenches, and through the deformation of the limbs."""

from functools import cache

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.results.contributions import by_mechanism_of_gravity

LOAD = [120.0, -40, -300, 5, 7, -3]
NAMES = list(ks.robots())


@cache
def result(name):
    return ks.analyze(package_robots.robot(name).assemble(), LOAD, gravity=(0.4, -0.9, -9.7))


def test_gravity_mechanisms_of_the_3rps_equal_the_paper():
    """Configuration 2, Δ_dz: platform −22.0, attached −2.2, deformation −49.9 nm; together −74.1, as in Table 1."""
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)}, orientation="tilt_torsion")
    found = ks.analyze(pose, gravity=(0, 0, -9.8))
    ways = found.mechanism_contributions.values()
    nm = [1e9 * sum(way[which][2] for way in ways) for which in ("attached", "deformation")]
    assert nm == pytest.approx([-2.2028, -49.8725], abs=1e-4)
    assert 1e9 * found.contributions["platform_weight"][2] + sum(nm) == pytest.approx(-74.110, abs=1e-3)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
def test_gravity_mechanisms_follow_equation_12(name):
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


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
def test_actuator_gravity_mechanisms_add_up_to_contributions(name):
    found = result(name)
    scale = max(np.abs(force) for force in found.actuator_forces.values())
    for drive, limbs in found.actuator_mechanism_contributions.items():
        for limb, ways in limbs.items():
            whole = found.actuator_contributions[drive][limb]
            assert ways["attached"] + ways["deformation"] == pytest.approx(whole, abs=1e-11 * scale)
            if len(found.actuator_forces) == found.robot.mobility.platform:  # actuators that virtual work determines
                assert abs(ways["deformation"]) < 1e-9 * scale


def test_deformation_under_gravity_loads_redundant_actuators():
    found = result("anymal_standing")
    forces = [ways["deformation"] for limbs in found.actuator_mechanism_contributions.values() for ways in limbs.values()]
    assert np.abs(forces).max() > 0.1


def test_gravity_mechanisms_do_not_depend_on_assembly_errors():
    robot = package_robots.robot("2pru_upr")
    assembly_errors = {"prismatic_1": [1e-4, 0, 0, 0, 0, 0]}
    poses = robot.assemble(platform={"z": [0.55, 0.6], "rx": 0.05, "ry": -0.1}, orientation="XYZ")
    both, plain = ks.analyze(poses, LOAD, assembly_errors=assembly_errors), ks.analyze(poses, LOAD)
    for limb, ways in both.mechanism_contributions.items():
        for which, twist in ways.items():
            assert twist.shape == (2, 6)
            np.testing.assert_allclose(twist, plain.mechanism_contributions[limb][which], rtol=1e-10, atol=1e-16)


# ---- all contributions split by mechanism ---------------------------------------------------------------------------------


def sums(contributions, limbs):
    """The parts of each limb's weight together, and all others."""
    return {
        name: part + contributions[f"deformation of {name}"] if name in limbs else part for name, part in contributions.items()
    }


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
def test_split_contributions_add_up_to_the_whole(name):
    whole, split = result(name), result(name).by_mechanism
    assert split.by_mechanism.contributions.keys() == split.contributions.keys()
    np.testing.assert_allclose(split.twist, whole.twist, rtol=0, atol=1e-12 * np.abs(whole.twist).max())
    for what in (
        "beam_contributions",
        "axial_contributions",
        "link_contributions",
        "joint_contributions",
        "actuator_contributions",
    ):
        ours, theirs = getattr(split, what), getattr(whole, what)
        assert ours.keys() == theirs.keys()
        scale = max((np.abs(part).max() for parts in theirs.values() for part in parts.values()), default=0)
        for item, parts in theirs.items():
            found = sums(ours[item], whole.limbs)
            for source, part in parts.items():
                np.testing.assert_allclose(found[source], part, rtol=0, atol=1e-9 * scale, err_msg=f"{what} {item} {source}")


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
def test_limb_ends_move_with_the_platform_per_contribution(name):
    """For each contribution by itself, the motion at the end of a limb is that of the platform."""
    split = result(name).by_mechanism
    (solution,), (deformation,) = split.solutions, split._deformations
    ends = [
        deformation.motions[edge.key][..., : len(solution.contributions), :]
        for limb in split.robot.topology.limbs
        for edge in limb.edges
        if edge.joint is not None and edge.joint in split.limbs[limb.name].platform_joints
    ]
    assert ends
    twists = solution.twists
    scale = np.abs(twists).max()
    for end in ends:
        np.testing.assert_allclose(end, twists, rtol=0, atol=1e-9 * scale)


def joints_at_ends(found):
    """Beams and joints at their outer ends that carry the same axial force, and the sign between the two."""
    robot, table = found.robot, found.robot.statics.joint_table
    (solution,) = found.solutions
    centres = solution.frames.points(table.centre_body, table.centre)[..., 0]
    for name, beam in found.beams.items():
        for k, joint in enumerate(table.names):
            along = beam.axes[:, 0] @ found.joint_wrenches[joint][:3]
            force = beam.section_wrenches[-1, 0]
            if np.allclose(centres[:, k], beam.points[-1], rtol=0, atol=1e-9 * robot.length):
                for sign in (1, -1):
                    if force == pytest.approx(sign * along, rel=1e-8):
                        yield name, joint, sign


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
def test_split_axial_forces_equal_split_joint_forces(name):
    split = result(name).by_mechanism
    scale = max(np.abs(beam.section_wrenches[..., 0]).max() for beam in split.beams.values())
    pairs = list(joints_at_ends(split))
    assert len(pairs) >= 2
    for beam, joint, sign in pairs:
        for source, force in split.axial_contributions[beam].items():
            along = split.beams[beam].axes[:, 0] @ split.joint_contributions[joint][source][:3]
            assert force == pytest.approx(sign * along, abs=1e-9 * scale), (beam, joint, source)


def test_gravity_mechanisms_are_summed_over_limbs():
    platform = np.array([1.0, 2.0])
    limbs = {"limb_1": {"attached": platform * 10, "deformation": platform * 100}}
    limbs["limb_2"] = {"attached": platform * 20, "deformation": platform * 300}
    parts = by_mechanism_of_gravity(platform, limbs)
    assert list(parts) == ["platform_weight", "attached", "deformation"]
    np.testing.assert_array_equal(list(parts.values()), [platform, 30 * platform, 400 * platform])
    np.testing.assert_array_equal(list(by_mechanism_of_gravity(platform, {}).values()), [platform, 0 * platform, 0 * platform])
