"""Robots of the package example-robot-data: included unedited, and compared with independent computations.

Pinocchio reads the package's own files here.
"""

import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import xacro
from package_robots import robot
from places import ROOT

import kinetostatics as ks
from kinetostatics.authoring.spans import spans
from kinetostatics.files.bundled import PackageNotFound, package_folder
from kinetostatics.files.reader import read_robot_file

ORIGINALS = {
    "ur10": "robots/ur_description/urdf/ur10_robot.urdf",
    "anymal_standing": "robots/anymal_b_simple_description/robots/anymal.urdf",
}
GRAVITY = np.array([0.0, 0.0, -9.81])
SIDEWAYS = np.array([3.0, -4.0, 8.0])
LOAD = np.array([120.0, -40.0, -500.0, 7.0, -3.0, 11.0])
ARM = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
LEGS = ("LF", "RF", "LH", "RH")
DRIVES = ("HAA", "HFE", "KFE")


@cache
def original(name, floating=False):
    """The package's own file as Pinocchio reads it, and data for it."""
    path = str(package_folder("example-robot-data") / ORIGINALS[name])
    model = pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer()) if floating else pin.buildModelFromUrdf(path)
    return model, model.createData()


def arm_pose(number):
    """One of some poses of the arm, and its coordinates."""
    q = np.random.default_rng(number).uniform(-2, 2, 6)
    return robot("ur10").assemble(actuators=dict(zip(ARM, q, strict=True))), q


def stand(one=None, **where):
    one = one or robot("anymal_standing")
    target = {"x": 0.0, "y": 0.0, "z": 0.48, "rx": 0.0, "ry": 0.0, "rz": 0.0}
    return one.assemble(platform={**target, **where})


UNEVEN = {"x": 0.04, "y": -0.03, "z": 0.47, "rx": 0.05, "ry": -0.07, "rz": 0.09}


# ---- files of the package ------------------------------------------------------------------------------------------------------


def attributes(element):
    """An element without its comments and layout."""
    return element.tag, dict(element.attrib), [attributes(child) for child in element if isinstance(child.tag, str)]


@cache
def expanded(name):
    """The robot's URDF as plain xacro makes it, which knows nothing of packages."""
    folder = str(package_folder("example-robot-data"))
    path = ROOT / "robots" / f"{name}.urdf.xacro"
    return xacro.process_file(str(path), mappings={"example_robot_data": folder}).toxml()


@pytest.mark.parametrize("name", ORIGINALS)
def test_urdf_of_the_package_is_included_unedited(name):
    root = ET.parse(package_folder("example-robot-data") / ORIGINALS[name]).getroot()
    theirs, ours = [attributes(element) for element in root], [attributes(element) for element in ET.fromstring(expanded(name))]
    for element in theirs:
        assert element in ours
    added = [item for item in ours if item not in theirs]
    elements = {"link", "joint", "base", "platform", "beam", "loop", "transmission", "joint_stiffness"}
    assert {tag for tag, _, _ in added} <= elements
    assert not [child for tag, _, children in added if tag == "link" for child in children]  # no mass of our own


@pytest.mark.parametrize("name", ORIGINALS)
def test_plain_xacro_and_pinocchio_load_the_robots(name, capfd):
    expanded.cache_clear()
    model, theirs = pin.buildModelFromXML(expanded(name)), original(name, name != "ur10")[0]
    assert (model.nq, model.nv) == (theirs.nq, theirs.nv)
    assert pin.computeTotalMass(model) == pytest.approx(pin.computeTotalMass(theirs), rel=1e-14)
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""


@pytest.mark.parametrize("name", ORIGINALS)
@pytest.mark.parametrize("gravity", [GRAVITY, SIDEWAYS])
def test_base_wrench_equals_weight_of_the_original_masses(name, gravity):
    """Force and moment: beams must not move masses."""
    if name == "ur10":
        pose, q = arm_pose(1)
        model, data = original(name)
    else:
        pose = stand(**UNEVEN)
        model, data = original(name, True)
        q = floating_coordinates(pose)
    pin.forwardKinematics(model, data, q)
    weights = [  # the first body is the world, to which the arm's base belongs
        np.concatenate([body.mass * gravity, np.cross(placement.act(body.lever), body.mass * gravity)])
        for body, placement in zip(model.inertias, data.oMi, strict=True)
        if body.mass > 0
    ]
    total = np.sum(weights, axis=0)
    np.testing.assert_allclose(ks.analyze(pose, gravity=gravity).base_wrench, -total, atol=1e-11 * np.abs(total).max())


# ---- the arm ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("gravity", [GRAVITY, SIDEWAYS])
def test_arm_torques_equal_pinocchio(number, gravity):
    """Gravity torques of the package's own inertials, and torques of a load at the tool by its Jacobian."""
    pose, q = arm_pose(number)
    model, data = original("ur10")
    model = model.copy()
    model.gravity.linear = gravity
    data = model.createData()
    held = pin.computeGeneralizedGravity(model, data, q)
    jacobian = pin.computeFrameJacobian(model, data, q, model.getFrameId("tool0"), pin.LOCAL_WORLD_ALIGNED)
    for load in (np.zeros(6), LOAD):
        ours = ks.analyze(pose, load=load, gravity=gravity).actuator_forces
        expected = held - jacobian.T @ load
        np.testing.assert_allclose([ours[name] for name in ARM], expected, atol=1e-11 * np.abs(expected).max())


#: The elastic tubes as the robot file's comments give them: link, its ends in the link's frame, diameter, wall, kilograms.
TUBES = (
    ("upper_arm_link", (0, 0, 0), (0, 0, 0.612), 0.108, 0.005, 12.93),
    ("upper_arm_link", (0, 0, 0.612), (0, -0.1719, 0.612), 0.12, 0.006, 0.0),
    ("forearm_link", (0, 0, 0), (0, 0, 0.5723), 0.086, 0.004, 3.87),
)
YOUNG, POISSON = 70e9, 0.33
RIGID = ("shoulder_link", "wrist_1_link", "wrist_2_link", "wrist_3_link")


def tube_stiffnesses(diameter, wall):
    """EA, kGA, GJ, EI of a tube; the shear coefficient is Cowper's (1966)."""
    inner = diameter - 2 * wall
    area, inertia = np.pi / 4 * (diameter**2 - inner**2), np.pi / 64 * (diameter**4 - inner**4)
    m = (inner / diameter) ** 2
    kappa = 6 * (1 + POISSON) * (1 + m) ** 2 / ((7 + 6 * POISSON) * (1 + m) ** 2 + (20 + 12 * POISSON) * m)
    G = YOUNG / 2 / (1 + POISSON)
    return YOUNG * area, kappa * G * area, G * 2 * inertia, YOUNG * inertia


def sag_by_summed_strains(q, load, gravity):
    """Twist of the tool: every slice of every tube strains under what hangs beyond it, and carries the rest along rigidly.

    Frames are Pinocchio's, of the package's file; integrals are Gauss's with five stations, exact for these polynomials.
    """
    model, data = original("ur10")
    pin.framesForwardKinematics(model, data, q)
    frame = {item.name: data.oMf[k] for k, item in enumerate(model.frames) if item.type == pin.FrameType.BODY}
    tool = frame["tool0"].translation
    order = ["shoulder_link", "upper_arm_link", "forearm_link", *RIGID[1:]]  # outwards; masses of rigid links at their origin
    masses = {"shoulder_link": 7.778, "wrist_1_link": 1.96, "wrist_2_link": 1.96, "wrist_3_link": 0.202}
    nodes, weights = np.polynomial.legendre.leggauss(5)
    fractions, weights = (nodes + 1) / 2, weights / 2
    twist = np.zeros(6)
    for number, (link, start, end, diameter, wall, mass) in enumerate(TUBES):
        EA, kGA, GJ, EI = tube_stiffnesses(diameter, wall)
        a, b = frame[link].act(np.array(start, float)), frame[link].act(np.array(end, float))
        length = np.linalg.norm(b - a)
        x = (b - a) / length
        for fraction, weight in zip(fractions, weights, strict=True):
            p = a + fraction * (b - a)
            loads = [(load[:3], tool), (mass * (1 - fraction) * gravity, (p + b) / 2)]
            loads += [
                (other[5] * gravity, frame[other[0]].act((np.array(other[1]) + other[2]) / 2)) for other in TUBES[number + 1 :]
            ]
            beyond = order[order.index(link) + 1 :]
            loads += [(masses[name] * gravity, frame[name].translation) for name in beyond if name in masses]
            force = sum(f for f, _ in loads)
            moment = load[3:] + sum(np.cross(at - p, f) for f, at in loads)
            along, turn = x * (x @ force), x * (x @ moment)
            strain = along / EA + (force - along) / kGA
            curvature = turn / GJ + (moment - turn) / EI
            ds = weight * length
            twist[:3] += ds * (strain + np.cross(curvature, tool - p))
            twist[3:] += ds * curvature
    return twist


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize(("load", "gravity"), [(np.zeros(6), GRAVITY), (LOAD, np.zeros(3)), (LOAD, SIDEWAYS)])
def test_arm_sag_equals_sum_of_slice_strains(number, load, gravity):
    pose, q = arm_pose(number)
    expected = sag_by_summed_strains(q, load, gravity)
    np.testing.assert_allclose(ks.analyze(pose, load=load, gravity=gravity).twist, expected, atol=1e-11 * np.abs(expected).max())


# ---- the quadruped ------------------------------------------------------------------------------------------------------------


def floating_coordinates(pose):
    """Pinocchio's coordinates of the package's own file on a free flyer, at a pose of the standing robot."""
    model, _ = original("anymal_standing", True)
    q = pin.neutral(model)
    trunk = pose.frame("base")
    q[:7] = pin.SE3ToXYZQUAT(pin.SE3(trunk[:3, :3], trunk[:3, 3]))
    for leg in LEGS:
        for drive in DRIVES:
            joint = model.joints[model.getJointId(f"{leg}_{drive}")]
            q[joint.idx_q] = pose.actuators[f"{leg}_{drive}"]
    return q


def foot_forces(result):
    return np.array([result.joint_wrenches[f"{leg}_contact"][:3] for leg in LEGS])


def test_feet_are_at_their_positions_and_carry_the_weight():
    pose = stand(**UNEVEN)
    model, data = original("anymal_standing", True)
    pin.framesForwardKinematics(model, data, floating_coordinates(pose))
    feet = np.array([data.oMf[model.getFrameId(f"{leg}_FOOT")].translation for leg in LEGS])
    np.testing.assert_allclose(
        feet, [[0.4405, 0.246, 0], [0.4405, -0.246, 0], [-0.4405, 0.246, 0], [-0.4405, -0.246, 0]], atol=1e-12
    )
    result = ks.analyze(pose)
    forces = foot_forces(result)
    weight = pin.computeTotalMass(model) * 9.81
    np.testing.assert_allclose(forces.sum(axis=0), [0, 0, weight], atol=1e-10 * weight)
    assert (forces[:, 2] > 0.1 * weight).all()
    np.testing.assert_allclose(np.cross(feet, forces).sum(axis=0), result.base_wrench[3:], atol=1e-10 * weight)
    moments = [result.joint_wrenches[f"{leg}_contact"][3:] for leg in LEGS]
    assert np.abs(moments).max() < 1e-10 * weight  # a ball joint turns freely


@pytest.mark.parametrize("gravity", [GRAVITY, SIDEWAYS])
def test_leg_torques_equal_pinocchio(gravity):
    """Virtual work of the package's own masses, the actuators and the forces at the feet, for legs and trunk."""
    pose = stand(**UNEVEN)
    result = ks.analyze(pose, load=LOAD, gravity=gravity)
    model = original("anymal_standing", True)[0].copy()
    model.gravity.linear = gravity
    data, q = model.createData(), floating_coordinates(pose)
    missing = pin.computeGeneralizedGravity(model, data, q)
    for leg, force in zip(LEGS, foot_forces(result), strict=True):
        jacobian = pin.computeFrameJacobian(model, data, q, model.getFrameId(f"{leg}_FOOT"), pin.LOCAL_WORLD_ALIGNED)
        missing = missing - jacobian[:3].T @ force
    jacobian = pin.computeFrameJacobian(model, data, q, model.getFrameId("base"), pin.LOCAL_WORLD_ALIGNED)
    missing = missing - jacobian.T @ LOAD
    expected = np.zeros(model.nv)
    for leg in LEGS:
        for drive in DRIVES:
            at = model.joints[model.getJointId(f"{leg}_{drive}")].idx_v
            expected[at] = result.actuator_forces[f"{leg}_{drive}"]
    np.testing.assert_allclose(missing, expected, atol=1e-9 * np.abs(expected).max())  # their shanks are 1 nm off


def test_three_standing_feet_carry_the_weight():
    one = robot("anymal_standing", standing="RF LH RH")
    assert len(one.topology.limbs) == 3
    result = ks.analyze(stand(one, x=-0.05, y=-0.05))
    forces = np.array([result.joint_wrenches[f"{leg}_contact"][:3] for leg in LEGS[1:]])
    np.testing.assert_allclose(
        forces.sum(axis=0), [0, 0, 9.81 * pin.computeTotalMass(original("anymal_standing", True)[0])], atol=1e-8
    )
    assert (forces[:, 2] > 0).all()
    assert result.warnings == one.warnings


def test_trunk_sag_on_elastic_drives_equals_stored_energy():
    """Clapeyron: the work of the load is twice the energy of elastic drives and legs."""
    pose = stand(robot("anymal_standing", actuator_stiffness=300.0), **UNEVEN)
    load = np.array([20.0, -10.0, -50.0, 1.0, 2.0, -3.0])
    result = ks.analyze(pose, load=load, gravity=np.zeros(3))
    springs = sum(torque**2 / 300.0 for torque in result.actuator_forces.values())
    legs = 2 * sum(beam.strain_energy for beam in result.beams.values())
    assert load @ result.twist == pytest.approx(springs + legs, rel=1e-10)
    assert springs > 50 * legs


def test_foot_positions_are_parameters():
    pose = stand(robot("anymal_standing", RF_foot="0.5 -0.3 0.05", LH_foot="-0.4 0.25 -0.02"))
    for leg, where in (("RF", [0.5, -0.3, 0.05]), ("LH", [-0.4, 0.25, -0.02])):
        np.testing.assert_allclose(pose.frame(f"{leg}_FOOT")[:3, 3], where, atol=1e-10)
    assert (pose.actuators["RF_KFE"] < 0) and (pose.actuators["LH_KFE"] > 0)  # knees bend as they did


# ---- others of the package, without beams -------------------------------------------------------------------------------------


def elastic_robots(file):
    """Yield robots in which every link that may be a beam is one: those on the way to one tip after the other."""
    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    frames = {item.name: data.oMf[k].homogeneous for k, item in enumerate(model.frames) if item.type == pin.FrameType.BODY}
    inner = {int(parent) for parent in model.parents}
    tips = {int(item.parentJoint): item.name for item in model.frames if item.type == pin.FrameType.BODY}
    done = set()
    for tip in (name for body, name in tips.items() if body not in inner):
        found = spans(read_robot_file(str(file), platform_link=tip), frames).values()
        links = {span.link for span in found if span.mass > 0} - done  # others weigh what their material does
        done |= links
        while links:
            try:
                yield ks.extend_robot(file, platform_link=tip, elastic=dict.fromkeys(links, "tube 50mm 40mm steel"))
                break
            except ks.RobotFileError as error:  # what hangs on its middle would have to be held there
                [other] = [link for link in links if f"of its beam ({link!r})" in str(error)]
                links = links - {other}


@pytest.mark.parts(30)
@pytest.mark.few(1)
@pytest.mark.parametrize(
    "file", sorted(path for path in package_folder("example-robot-data").glob("robots/**/*.urdf") if path.stem != "ur3"),
    ids=lambda path: path.stem,
)  # fmt: skip
def test_elastic_links_keep_mass_and_centre_of_mass(file):
    model = pin.buildModelFromUrdf(str(file))
    model.gravity.linear = SIDEWAYS
    for one in elastic_robots(file):
        drives, joints = one.description.actuated, one.description.joints
        pose = one.assemble(actuators=dict(zip(drives, np.random.default_rng(5).uniform(-0.5, 0.5, len(drives)), strict=True)))
        held = pin.computeGeneralizedGravity(model, model.createData(), pose.q)
        expected = {name: held[model.joints[model.getJointId(name)].idx_v] for name in joints if model.existJointName(name)}
        for joint in joints.values():
            if joint.mimic is not None:
                expected[joint.mimic.joint] += joint.mimic.multiplier * expected[joint.name]
        found = ks.analyze(pose, gravity=SIDEWAYS).actuator_forces
        expected = [expected[name] for name in drives]
        np.testing.assert_allclose([found[name] for name in drives], expected, atol=1e-10 * np.abs(held).max(), rtol=1e-10)


# ---- the page and the examples -------------------------------------------------------------------------------------------------


def test_example_of_the_page_agrees_with_ur10(tmp_path):
    page = (ROOT / "docs" / "how_to" / "plain_urdf.md").read_text(encoding="utf-8")
    file = tmp_path / "my_ur10.urdf.xacro"
    file.write_text(re.findall(r"```xml\n(.*?)```", page, re.DOTALL)[0], encoding="utf-8")
    one = ks.load_robot(file)
    pose, q = arm_pose(0)
    result = ks.analyze(one.assemble(actuators=dict(zip(ARM, q, strict=True))))
    assert result.warnings == one.warnings
    shipped = ks.analyze(pose)
    for name in ARM:
        assert result.actuator_forces[name] == pytest.approx(shipped.actuator_forces[name], abs=1e-9)
    assert np.linalg.norm(result.twist[:3] - shipped.twist[:3]) < 0.3 * np.linalg.norm(shipped.twist[:3])


def printed_by(example):
    command = [sys.executable, str(ROOT / "examples" / f"{example}.py")]
    return subprocess.run(command, check=True, capture_output=True, text=True, encoding="utf-8").stdout


@pytest.mark.slow
def test_example_elastic_arm_prints_consistent_tables():
    text = printed_by("elastic_arm")
    rows = [[float(item) for item in line.split()] for line in text.splitlines() if re.match(r" +\d+ +-\d", line)]
    assert len(rows) == 14
    reach, payload, own, total, _, lift, *_ = np.array(rows).T
    assert (np.diff(reach) > 0).all() and (np.diff(total) < 0).all() and (np.diff(lift) < 0).all()
    np.testing.assert_allclose(payload + own, total, atol=0.1)
    before, after = (float(re.search(rf"([\d.e-]+) µm {word}", text)[1]) for word in ("before", "after"))
    assert before == pytest.approx(924.4, abs=0.1) and after < 1e-3
    _, causes = text.split("With gears")
    causes = [float(item) for item in re.findall(r"^  \w+ +([\d.]+) µm$", causes, re.MULTILINE)]
    assert len(causes) == 6 and causes == sorted(causes, reverse=True)
    assert sum(causes) == pytest.approx(float(re.search(r"at 1150 mm: (\d+) µm", text)[1]), abs=1)


@pytest.mark.slow
def test_example_standing_quadruped_balances_the_weight():
    text = printed_by("standing_quadruped")
    feet = [float(line.split()[1]) for line in text.splitlines() if re.match(r"   (LF|RF|LH|RH) ", line)]
    assert len(feet) == 4 + 4 + 4 + 3
    for some in (feet[:4], feet[4:8], feet[8:12], feet[12:]):
        assert sum(some) == pytest.approx(30.4752 * 9.81, abs=0.2)
    assert text.count("would tip") == 2 and text.count("stands\n") == 3


# ---- search for packages ------------------------------------------------------------------------------------------------------


def install(prefix, name):
    (prefix / "share" / "ament_index" / "resource_index" / "packages").mkdir(parents=True, exist_ok=True)
    (prefix / "share" / "ament_index" / "resource_index" / "packages" / name).touch()
    (prefix / "share" / name).mkdir()
    return prefix / "share" / name


def test_package_folder_searches_ros_then_pip(tmp_path, monkeypatch):
    pip = install(tmp_path / "site" / "cmeel.prefix", "my_robots")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    assert package_folder("my_robots") == pip
    first, second = install(tmp_path / "a", "my_robots"), install(tmp_path / "b", "my_robots")
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join([str(tmp_path / "a"), str(tmp_path / "b")]))
    assert package_folder("my_robots") == first
    (first.parent / "ament_index" / "resource_index" / "packages" / "my_robots").unlink()
    assert package_folder("my_robots") == second


def test_missing_example_robot_data_error_names_pip_install(monkeypatch):
    monkeypatch.setattr(sys, "path", [])
    monkeypatch.setattr(sys, "prefix", os.devnull)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    path = ROOT / "robots" / "ur10.urdf.xacro"
    with pytest.raises(ks.RobotFileError, match="pip install example-robot-data") as caught:
        read_robot_file(path)
    line = 1 + path.read_text(encoding="utf-8").split("$(find example-robot-data)")[0].count("\n")
    assert str(caught.value).startswith(f"{path}:{line}: ")


def test_invalid_package_names_are_refused():
    with pytest.raises(PackageNotFound, match="did you mean 'example-robot-data'") as caught:
        package_folder("example_robot_data")
    assert "pip" not in str(caught.value)
    for name in ("", ".", "..", "../pinocchio", "a/b", "a b", "/etc", "-x", "a\0", "x\n", "$(arg x"):
        with pytest.raises(PackageNotFound, match="not the name of a package"):
            package_folder(name)
