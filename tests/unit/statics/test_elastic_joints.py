"""Elastic joints, bearings and actuators against closed forms; their contributions add up to the twist."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import Beam, Edge, Joint, Link, Mechanism, Stiffness, circle, write_mechanism
from simple_machines import CIRCLE, E, arm, bar, joint, link, loop, mount, robot, springs

import kinetostatics as ks

AREA = np.pi * 0.05**2 / 4
LOAD = np.array([30.0, -20.0, 50.0, 4.0, -3.0, 2.0])
STILL = (0, 0, 0)


@pytest.mark.parametrize("kind", ["fixed", "floating"])
def test_stiffness_of_elastic_mount_is_that_of_its_springs(kind):
    k = np.array([1e5, 2e5, 3e5, 400.0, 500.0, 600.0])
    machine = mount(springs("mount", linear="1e5 2e5 3e5", angular="400 500 600"), kind=kind)
    found = ks.analyze(machine.assemble(), LOAD, STILL)
    np.testing.assert_allclose(found.twist, LOAD / k, rtol=1e-12)
    np.testing.assert_allclose(found.stiffness, np.diag(k), rtol=1e-10, atol=1e-6)
    np.testing.assert_allclose(found.joint_wrenches["mount"], -LOAD, rtol=1e-12)
    np.testing.assert_allclose(found.source_contributions["joints"]["mount"], found.twist, rtol=1e-12)
    assert found.strain_energy == pytest.approx(float(LOAD @ found.twist) / 2, rel=1e-12)


def test_a_floating_joint_without_springs_carries_nothing():
    machine = robot(
        link("base"), link("column"), link("platform", 3.0), joint("free", "floating", "base", "platform", "0 0 1"),
        joint("clamp", "fixed", "base", "column"), loop("top", "fixed", "column", "platform", "0 0 1"),
        bar("column", "clamp", "top", 0.0, CIRCLE),
    )  # fmt: skip
    assert [limb.links for limb in machine.topology.limbs] == [("column",)]
    assert ks.analyze(machine.assemble(), LOAD, STILL).twist[2] == pytest.approx(50 / (E * AREA), rel=1e-9)


def test_mount_is_rigid_where_its_stiffness_is_infinite():
    """Infinite and missing stiffnesses are rigid: the twist is that of the springs alone, the stiffness infinite."""
    machine = mount(springs("mount", linear="1e5 inf inf", angular="inf 500 inf"))
    found = ks.analyze(machine.assemble(), LOAD, STILL)
    np.testing.assert_allclose(found.twist, [LOAD[0] / 1e5, 0, 0, 0, LOAD[4] / 500, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(found.compliance, np.diag([1e-5, 0, 0, 0, 1 / 500, 0]), rtol=1e-12, atol=1e-18)
    assert np.all(np.isnan(found.stiffness)) and found.status == ks.Status.OK
    np.testing.assert_allclose(found.joint_wrenches["mount"], -LOAD, rtol=1e-12)


@pytest.mark.parametrize("spring", ["0 700 0", "inf 700 inf"])
def test_a_flexure_turns_about_its_axis(spring):
    """A finite stiffness along a passive freedom is a spring; a stiffness of 0 in other directions is refused."""
    stiff = "inf 700 inf"
    if spring.startswith("0"):
        with pytest.raises(ks.RobotFileError, match="mount"):
            mount(springs("mount", angular=spring), kind="revolute")
    machine = mount(springs("mount", angular=stiff), kind="revolute")
    found = ks.analyze(machine.assemble(), LOAD, STILL)
    np.testing.assert_allclose(found.twist, [0, 0, 0, 0, LOAD[4] / 700, 0], rtol=1e-12, atol=1e-18)


def jacobian(q1, q2):
    """Return twists of the tip of the arm per unit of its actuators; turning about +y moves +x towards −z."""
    tip = np.array([0.4 * np.cos(q1) + 0.3 * np.cos(q1 + q2), 0, -0.4 * np.sin(q1) - 0.3 * np.sin(q1 + q2)])
    elbow = np.array([0.4 * np.cos(q1), 0, -0.4 * np.sin(q1)])
    y = np.array([0.0, 1.0, 0.0])
    return np.column_stack([np.concatenate([np.cross(y, tip - centre), y]) for centre in (np.zeros(3), elbow)])


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.4, 0.9), (-1.0, 1.7)])
def test_compliance_of_rigid_arm_is_that_of_its_drives(q):
    """C = J diag(1/k) Jᵀ (J. K. Salisbury, Active stiffness control of a manipulator in Cartesian coordinates, 1980)."""
    machine = arm(springs("shoulder", drive="5000"), springs("elbow", drive="2000"), elastic=False)
    pose = machine.assemble(actuators={"shoulder": q[0], "elbow": q[1]})
    found = ks.analyze(pose, LOAD, (0, 0, -10))
    J = jacobian(*q)
    C = J @ np.diag([1 / 5000, 1 / 2000]) @ J.T
    np.testing.assert_allclose(found.compliance, C, rtol=1e-10, atol=1e-15)
    torques = np.array([found.actuator_forces["shoulder"], found.actuator_forces["elbow"]])
    # the actuators' springs yield under the torques of the actuators, weights included
    np.testing.assert_allclose(found.twist, -J @ (torques / [5000, 2000]), rtol=1e-9, atol=1e-15)
    drives = found.source_contributions["actuators"]
    np.testing.assert_allclose(drives["shoulder"], -J[:, 0] * torques[0] / 5000, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(sum(drives.values()), found.twist, rtol=1e-9, atol=1e-15)


def test_twists_of_beams_drives_and_bearings_add_up():
    rigid = ks.analyze(arm().assemble(), LOAD, (0, 0, -10))
    soft = ks.analyze(arm(springs("elbow", drive="2000", linear="1e6 inf 2e6")).assemble(), LOAD, (0, 0, -10))
    for name in ("shoulder", "elbow"):
        assert soft.actuator_forces[name] == pytest.approx(rigid.actuator_forces[name], rel=1e-12)
    found = soft.source_contributions
    beams = sum(found["beams"].values())
    np.testing.assert_allclose(beams, rigid.twist, rtol=1e-9, atol=1e-16)
    np.testing.assert_allclose(
        found["actuators"]["elbow"], -jacobian(0, 0)[:, 1] * soft.actuator_forces["elbow"] / 2000, rtol=1e-9, atol=1e-16
    )
    wrench = soft.joint_wrenches["elbow"]  # the bearings displace the tip by the wrench from the base side over their stiffness
    np.testing.assert_allclose(found["joints"]["elbow"], [-wrench[0] / 1e6, 0, -wrench[2] / 2e6, 0, 0, 0], rtol=1e-9, atol=1e-16)
    np.testing.assert_allclose(beams + found["actuators"]["elbow"] + found["joints"]["elbow"], soft.twist, rtol=1e-9, atol=1e-16)


def test_elastic_bracket_of_a_branch_sags_under_its_weight():
    """A lamp on an elastic bracket below the platform sags on its spring and with the platform, and bends nothing else."""
    parts = [link("lamp", 2.0, "0 0 -0.1"), joint("hook", "fixed", "platform", "lamp", "0.2 0 0")]
    machine = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4"), *parts, springs("hook", linear="inf inf 1e3"))
    found = ks.analyze(machine.assemble(), gravity=(0, 0, -10))
    tip = sum(found.link_contributions["lamp"].values())
    turn = 0.2 * 20 / 1e4
    np.testing.assert_allclose(found.twist, [0, 0, -50 / 1e5, 0, turn, 0], rtol=1e-10, atol=1e-18)
    np.testing.assert_allclose(tip, [0, 0, -50 / 1e5 - 0.2 * turn - 20 / 1e3, 0, turn, 0], rtol=1e-10, atol=1e-18)


@pytest.mark.parametrize(("kind", "twist"), [("revolute", slice(3, 6)), ("prismatic", slice(0, 3))])
def test_drive_stiffness_acts_along_an_oblique_axis(kind, twist):
    axis = np.array([2.0, -1, 2]) / 3
    drive = '<transmission name="t"><joint name="mount"/></transmission>'
    machine = mount(springs("mount", drive="500"), drive, kind=kind, axis="2 -1 2")
    load = np.array([7.0, 2, 3, 5, -4, 6])
    found = ks.analyze(machine.assemble(), load, STILL)
    expected = np.zeros(6)
    expected[twist] = axis * (axis @ load[twist]) / 500
    np.testing.assert_allclose(found.twist, expected, rtol=1e-9, atol=1e-15)


def test_bearing_stiffness_acts_along_the_joint_frame():
    drive = '<transmission name="t"><joint name="mount"/></transmission>'
    machine = mount(springs("mount", linear="1e5 2e5 4e5"), drive, kind="revolute", axis="1 1 0")
    found = ks.analyze(machine.assemble(), (10, 20, 40, 0, 0, 0), STILL)
    np.testing.assert_allclose(found.twist, [1e-4, 1e-4, 1e-4, 0, 0, 0], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("axis", "sprung"), [("0 1 0", True), ("0 1 5e-10", True), ("0 1 1e-7", False), ("0 1 1", False)])
def test_flexure_axis_must_be_an_axis_of_the_joint_frame(axis, sprung):
    """A stiffness makes a hinge a spring only if the hinge turns about an axis of its frame."""
    text = springs("mount", angular="inf 700 inf")
    if not sprung:
        with pytest.raises(ks.KinetostaticsError):
            ks.analyze(mount(text, kind="revolute", axis=axis).assemble(), (0, 0, 0, 0, 7, 0), STILL)
        return
    found = ks.analyze(mount(text, kind="revolute", axis=axis).assemble(), (0, 0, 0, 0, 7, 0), STILL)
    assert found.twist[4] == pytest.approx(0.01, rel=1e-6)


def test_flexure_unstrained_by_axial_force_leaves_rod_rigid():
    """A spring along a freedom of the ball at one end of a strut has no effect on the platform."""
    made = hexapod_with_one_rigid_strut()
    turned = pin.rpy.rpyToMatrix(0.3, 0.2, 0.1)
    stiffness = Stiffness(tuple(map(tuple, turned)), None, (0.0, 1000.0, np.inf))
    edges = tuple(replace(e, joint=replace(e.joint, stiffness=stiffness)) if e.joint.name == "a0" else e for e in made.edges)
    results = []
    for mechanism in (made, replace(made, edges=edges)):
        one = write_mechanism(mechanism, cuts=("a0", "b1", "b2", "b3", "b4"), twirl=3).robot()
        results.append(ks.analyze(one.configuration(pin.neutral(one.model)), LOAD))
    bare, flexed = results
    assert [group.rigid_directions for group in flexed.robot.statics.groups if "limb_1" in str(group.limbs[0].name)] == [1]
    np.testing.assert_allclose(flexed.twist, bare.twist, rtol=1e-9)
    np.testing.assert_allclose(flexed.joint_wrenches["a0"], bare.joint_wrenches["a0"], rtol=1e-9, atol=1e-9)


def hexapod_with_one_rigid_strut():
    """Return six struts between balls, the first one without a beam."""
    rng, angles = np.random.default_rng(3), np.linspace(0, 5.2, 6)
    feet = np.stack([0.5 * np.cos(angles), 0.5 * np.sin(angles), 0 * angles], axis=1) + 0.05 * rng.standard_normal((6, 3))
    tops = np.stack([0.2 * np.cos(angles + 1), 0.2 * np.sin(angles + 1), 0.8 + 0 * angles], axis=1)
    edges, beams = [], []
    for k, (foot, top) in enumerate(zip(feet, tops + 0.05 * rng.standard_normal((6, 3)), strict=True)):
        edges += [
            Edge(Joint(f"a{k}", "S", tuple(foot)), "base", f"l{k}"),
            Edge(Joint(f"b{k}", "S", tuple(top)), f"l{k}", "platform"),
        ]
        beams += [Beam(f"l{k}", f"l{k}", f"a{k}", f"b{k}", circle(0.02))] if k else []
    links = tuple(Link(f"l{k}") for k in range(6))
    return Mechanism(tuple(edges), links, tuple(beams), (0.0, 0.0, 0.8), 3.0, (0.0, 0.0, 0.8))
