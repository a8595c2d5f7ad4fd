"""Forward kinematics against Pinocchio, rotations and orientation coordinates against themselves."""

from itertools import permutations
from pathlib import Path

import numpy as np
import package_robots
import pinocchio as pin
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from places import ROOT

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.math import rotations
from kinetostatics.math.linalg import Cholesky, least_squares, matmul
from kinetostatics.math.rotations import orientation_named
from kinetostatics.mechanism.mechanism import Mechanism

TREE = """<robot name="tree"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
<link name="f"/><platform link="f"/>
<joint name="fixed" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0.2 -0.1 1" rpy="0.4 0 1"/></joint>
<joint name="revolute" type="revolute"><parent link="base"/><child link="a"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
<axis xyz="0 3 4"/><limit effort="1" velocity="1"/></joint>
<joint name="continuous" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 -2" rpy="2 0.2 0.3"/>
<axis xyz="0 1 0"/></joint>
<joint name="planar" type="planar"><parent link="c"/><child link="d"/><origin xyz="0 2 3" rpy="0.1 1 0.3"/>
<axis xyz="0 0 1"/></joint>
<joint name="floating" type="floating"><parent link="d"/><child link="e"/><origin xyz="1 2 0" rpy="0.1 0.2 3"/></joint>
<joint name="prismatic" type="prismatic"><parent link="e"/><child link="f"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
<axis xyz="1 0 2"/><limit effort="1" velocity="1"/></joint></robot>"""


def test_frames_and_twists_are_pinocchios():
    mechanism = Mechanism(parse_robot_text(TREE))
    model, tree = mechanism.model, mechanism.tree
    data = model.createData()
    random = np.random.default_rng(3)
    np.testing.assert_array_equal(tree.neutral, pin.neutral(model))
    q = np.column_stack([pin.normalize(model, random.uniform(-1, 1, model.nq)) for _ in range(7)])
    q = tree.integrate(q, random.uniform(-1, 1, (model.nv, 7)))
    frames = tree.forward(q)
    twists = tree.twists(frames)
    for k in range(7):
        pin.computeJointJacobians(model, data, q[:, k])
        for body in range(model.njoints):
            np.testing.assert_allclose(frames.rotation[:, :, body, k], data.oMi[body].rotation, atol=1e-14)
            np.testing.assert_allclose(frames.position[:, body, k], data.oMi[body].translation, atol=3e-14)
        np.testing.assert_allclose(twists[:, :, k], data.J, atol=1e-13)


def test_small_displacements_are_pinocchios():
    """Larger ones are not: there a body that slides and turns goes along an arc."""
    mechanism = Mechanism(parse_robot_text(TREE))
    model, tree, random = mechanism.model, mechanism.tree, np.random.default_rng(5)
    q = np.column_stack([pin.normalize(model, random.uniform(-1, 1, model.nq)) for _ in range(5)])
    v = random.uniform(-1e-6, 1e-6, (model.nv, 5))
    wanted = np.column_stack([pin.integrate(model, *pair) for pair in zip(q.T, v.T, strict=True)])
    np.testing.assert_allclose(tree.integrate(q, v) - q, wanted - q, rtol=0, atol=2e-12)


def test_link_frames_and_masses_are_pinocchios():
    robot = package_robots.robot("2pru_upr")
    pose = robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": -0.05}, orientation="XYZ")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.array(pose.q))
    for link in robot.description.links:
        placement = data.oMf[robot.model.getFrameId(link)].homogeneous
        np.testing.assert_allclose(pose.frame(link), placement, atol=1e-14)
    links = sum(link.mass for link in robot.description.links.values())
    assert pin.computeTotalMass(robot.mechanism.model) == pytest.approx(links, rel=1e-12)
    rods = sum(float(result.mass) for result in ks.analyze(robot.assemble()).beams.values())
    assert pin.computeTotalMass(robot.model) == pytest.approx(links + rods, rel=1e-12)


def test_gravity_torques_are_pinocchios():
    """Without beams that weigh anything the actuators' forces follow from Pinocchio's generalized gravity."""
    robot = ks.load_robot(ROOT / "robots" / "3rps.urdf.xacro", {"density": 1e-9, "platform_mass": 20})
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
    result = ks.analyze(pose)
    model, data = robot.model, robot.model.createData()
    gravity = pin.computeGeneralizedGravity(model, data, np.array(pose.q))
    # velocities of all joints per unit of each actuator, from neighbouring poses
    step = 1e-5
    for name in robot.description.driven:
        base = {key: float(value) for key, value in pose.actuators.items()}
        ends = [robot.assemble(actuators={**base, name: base[name] + sign * step}, near=pose).q for sign in (-1, 1)]
        work = gravity @ pin.difference(model, *ends) / (2 * step)
        assert float(result.actuator_forces[name]) == pytest.approx(work, rel=1e-6)


vectors = st.tuples(*[st.floats(-2.5, 2.5)] * 3)


@given(vectors)
def test_rotation_vector_round_trip(v):
    v = np.array(v)[:, None] / max(1.0, np.linalg.norm(v) / 3.14)
    R = rotations.exponential(v)
    np.testing.assert_allclose(R[..., 0] @ R[..., 0].T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(rotations.exponential(rotations.logarithm(R)), R, atol=1e-13)
    np.testing.assert_allclose(rotations.logarithm(R), v, atol=1e-8 if np.linalg.norm(v) > 3.1 else 1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 1.0, np.pi - 1e-6, np.pi - 1e-9, np.pi])
def test_logarithm_keeps_its_digits_near_zero_and_half_a_turn(angle):
    axis = np.array([[1.0], [-2.0], [2.0]]) / 3
    R = rotations.exponential(axis * angle)
    found = rotations.logarithm(R)
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-15 + 1e-13 * angle)
    np.testing.assert_allclose(rotations.exponential(found), R, atol=1e-14)


SEQUENCES = ["".join(letters) for letters in permutations("xyz")]
CONVENTIONS = [None, "tilt_torsion", *SEQUENCES, *(letters.upper() for letters in SEQUENCES)]


@pytest.mark.few(7)
@pytest.mark.parametrize("name", CONVENTIONS)
@given(c=st.tuples(st.floats(-1.4, 1.4), st.floats(0.01, 1.4), st.floats(-1.4, 1.4)))
def test_orientation_coordinates_round_trip_and_rates(name, c):
    convention = orientation_named(name)
    c = np.array(c)[:, None]
    R = convention.matrix(c)
    np.testing.assert_allclose(convention.coordinates(R), c, atol=2e-12)
    rates = convention.rates(c)[..., 0]
    step = 1e-6
    for k in range(3):
        shift = np.zeros((3, 1))
        shift[k] = step
        turned = convention.matrix(c + shift)[..., 0] @ convention.matrix(c - shift)[..., 0].T
        np.testing.assert_allclose(rotations.logarithm(turned[..., None])[:, 0] / (2 * step), rates[:, k], atol=1e-8)


#: Beside quarter and half turns, where one convention or another tells some angles only together.
SPECIAL = st.builds(
    lambda quarters, distance, sign: quarters * np.pi / 2 + sign * 10.0**distance,
    st.integers(-2, 2),
    st.floats(-17, -2),
    st.sampled_from((-1, 0, 1)),
)
ANGLES = st.tuples(*[st.one_of(SPECIAL, st.floats(-np.pi, np.pi))] * 3)


@pytest.mark.few(7)
@pytest.mark.parametrize("name", CONVENTIONS)
@given(c=ANGLES, noise=st.tuples(*[st.floats(-3e-16, 3e-16)] * 3), near=st.tuples(*[st.floats(-10, 10)] * 3))
@example(c=(0.3, np.pi / 2, 0.2), noise=(0.0, 0.0, 0.0), near=(0.0, 0.0, 0.0))
@example(c=(0.3, np.pi, 0.2), noise=(0.0, 0.0, 0.0), near=(0.0, 0.0, 0.0))
@example(c=(np.pi, 0.0, 0.0), noise=(0.0, 0.0, 0.0), near=(-np.pi, 0.0, 0.0))
def test_orientation_coordinates_rebuild_every_rotation(name, c, noise, near):
    convention = orientation_named(name)
    R = matmul(convention.matrix(np.array(c)[:, None]), rotations.exponential(np.array(noise)[:, None]))
    found = convention.coordinates(R)
    np.testing.assert_allclose(convention.matrix(found), R, atol=1e-12)
    assert np.all(np.abs(found) < np.pi + 1e-15)
    other = np.array(near)[:, None]
    nearer = convention.coordinates(R, other)
    np.testing.assert_allclose(convention.matrix(nearer), R, atol=1e-12)
    same = convention.same(found, other, always=True)
    np.testing.assert_allclose(convention.matrix(same), R, atol=3e-9)
    if name is None:
        assert np.linalg.norm(nearer - other) <= np.linalg.norm(found - other) + 1e-12
    else:
        assert np.all(
            np.abs((nearer if name != "tilt_torsion" else nearer[:2]) - other[: 2 if name == "tilt_torsion" else 3]) < 3.15
        )


def test_coordinates_that_are_not_determined_are_those_nearby():
    azimuth = orientation_named("tilt_torsion")
    near = np.array([[2.0], [0.5], [1.5]])
    np.testing.assert_allclose(azimuth.same(np.array([[0.0], [0.0], [0.3]]), near, False), [[2.0], [0.0], [0.3]], atol=1e-15)
    turned = azimuth.same(np.array([[0.0], [np.pi], [0.3]]), near, False)
    np.testing.assert_allclose(turned, [[2.0], [np.pi], [4.3]], atol=1e-15)
    fixed = np.array([[0.0], [0.1], [0.3]])
    np.testing.assert_array_equal(azimuth.same(fixed, near, False), fixed)
    euler = orientation_named("XYZ")
    found = euler.same(np.array([[0.1], [np.pi / 2], [0.2]]), np.array([[1.0], [0.0], [0.0]]), False)
    np.testing.assert_allclose(found, [[1.0], [np.pi / 2], [-0.7]], atol=1e-15)
    beyond = euler.same(np.array([[3.0], [2.0], [0.2]]), np.array([[-3.0], [2.0], [0.0]]), True)
    np.testing.assert_allclose(beyond, [[3.0 - 2 * np.pi], [2.0], [0.2]], atol=1e-15)
    half = orientation_named(None).same(np.array([[0.0], [np.pi], [0.0]]), np.array([[0.1], [-3.0], [0.0]]), False)
    np.testing.assert_allclose(half, [[0.0], [-np.pi], [0.0]], atol=1e-15)


@given(skewed=st.floats(-1.3, 1.3), q=st.tuples(st.floats(-3, 3), SPECIAL, st.floats(-3, 3)), side=st.sampled_from((-1, 1)))
def test_three_angles_about_oblique_axes(skewed, q, side):
    """Spherical joints written as three revolutes, whose first and last axes may be at any angle."""
    axes = np.array([[1.0, 0.0, np.sin(skewed)], [0, 1, 0], [0, 0, np.cos(skewed)]])
    zero = skewed - np.pi / 2  # the second angle at which both are one line
    q = np.array([q[0], -zero + q[1], q[2]])[:, None]
    turns = [rotations.exponential(axes[:, [k]] * q[k]) for k in range(3)]
    R = matmul(matmul(turns[0], turns[1]), turns[2])
    near = q + np.array([[0.3], [side * 1e-3], [-0.2]])
    found = rotations.three_angles(axes, R, near)
    turns = [rotations.exponential(axes[:, [k]] * found[k]) for k in range(3)]
    np.testing.assert_allclose(matmul(matmul(turns[0], turns[1]), turns[2]), R, atol=1e-12)
    assert abs(found[1, 0] - near[1, 0]) < np.pi


@pytest.mark.few(1)
@pytest.mark.parametrize("rpy", ["3.141592653589793 0 0.3", "0.2 1.5707963267948966 0"])
def test_poses_are_assembled_from_their_own_reports(rpy):
    text = Path(robot_path("gough_stewart")).read_text()
    turned = text.replace('<platform link="platform"/>', f'<platform link="platform"><origin rpy="{rpy}"/></platform>')
    assert turned != text
    robot = ks.Robot(parse_robot_text(turned, "gough_stewart.urdf.xacro"))
    drives = robot.description.driven
    lengths = np.array([3.0, -4, 5, 2, -2, 7]) * 1e-3
    for pose in (robot.assemble(), robot.assemble(actuators=dict(zip(drives, lengths, strict=True)))):
        for name in CONVENTIONS:
            report = pose.platform_coordinates(name)
            for near in (None, pose):
                again = robot.assemble(platform=report, orientation=name, near=near)
                np.testing.assert_allclose(again.platform_frame, pose.platform_frame, atol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("distance", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-5, 1e-2])
def test_a_tool_that_points_straight_down(distance):
    arm = package_robots.robot("ur10")
    q = np.array([0, -np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2, 0.7]) + distance * np.array([1, -2, 1, 3, 2, 1])
    pose = arm.assemble(actuators=dict(zip(arm.description.driven, q, strict=True)))
    for name in CONVENTIONS:
        report = pose.platform_coordinates(name)
        convention = orientation_named(name)
        R = convention.matrix(np.array([report[angle] for angle in convention.names])[:, None])[..., 0]
        np.testing.assert_allclose(R, pose.platform_frame[:3, :3], atol=1e-12)
        again = arm.assemble(platform=report, orientation=name, near=pose)
        np.testing.assert_allclose(again.platform_frame, pose.platform_frame, atol=1e-12)
        np.testing.assert_allclose(again.q, pose.q, atol=1e-9)


def test_from_a_pose_the_platform_turns_the_shorter_way():
    arm = package_robots.robot("ur10")
    drives = arm.description.driven
    pose = arm.assemble(actuators=dict(zip(drives, [0.3, -1.0, 1.5, -2.0, -1.5, 0.7], strict=True)))
    report = pose.platform_coordinates("tilt_torsion")
    for name in ("azimuth", "torsion"):
        moved = {**report, name: report[name] + 2 * np.pi + 0.1}
        one, two = (
            arm.assemble(platform={**moved, name: moved[name] - k * 2 * np.pi}, orientation="tilt_torsion", near=pose)
            for k in (0, 1)
        )
        np.testing.assert_allclose(one.q, two.q, atol=1e-12)


def test_euler_sequences_mean_what_they_say():
    c = np.array([0.3, -0.5, 0.7])
    about = {axis: rotations.exponential(np.eye(3)[:, [k]] * c[k])[..., 0] for k, axis in enumerate("xyz")}
    moving = orientation_named("XYZ").matrix(c[:, None])[..., 0]
    np.testing.assert_allclose(moving, about["x"] @ about["y"] @ about["z"], atol=1e-15)
    fixed = orientation_named("xyz").matrix(c[:, None])[..., 0]
    np.testing.assert_allclose(fixed, about["z"] @ about["y"] @ about["x"], atol=1e-15)
    moving = orientation_named("ZXY").matrix(c[:, None])[..., 0]
    np.testing.assert_allclose(moving, about["z"] @ about["x"] @ about["y"], atol=1e-15)


@pytest.mark.parametrize("name", ["XYX", "Xyz", "abc", "", "XY"])
def test_unknown_orientation(name):
    with pytest.raises(ks.exceptions.CoordinatesError, match="orientation"):
        orientation_named(name)


def test_cholesky_solves_batches_and_sees_singular_matrices():
    random = np.random.default_rng(0)
    J = random.standard_normal((6, 6, 50))
    A = np.einsum("ijn,kjn->ikn", J, J)
    A[:, :, 7] = np.outer(J[:, 0, 7], J[:, 0, 7])  # of rank one
    factor = Cholesky(A)
    smallest = factor.smallest_eigenvalue()
    exact = np.linalg.eigvalsh(np.moveaxis(A, 2, 0))[:, 0]
    np.testing.assert_array_less(smallest, exact * (1 + 1e-6) + 1e-12)
    np.testing.assert_array_less(exact / 6.0001 - 1e-12, smallest)
    b = random.standard_normal((6, 2, 50))
    x = factor.solve(b)
    for k in set(range(50)) - {7}:
        backward = np.abs(A[:, :, k] @ x[:, :, k] - b[:, :, k]).max()
        assert backward < 1e-14 * np.linalg.norm(A[:, :, k]) * np.linalg.norm(x[:, :, k])


def test_spins_of_rods_are_told_from_rounding(monkeypatch):
    """Where a Delta's arm nearly folds upon its rods the columns of its freedoms differ in size by nine orders of magnitude."""
    robot = package_robots.robot("delta")
    systems = []

    def seen(a, b, nullity=0):
        x = least_squares(a, b, nullity)
        systems.append((a, b, x))
        return x

    monkeypatch.setattr("kinetostatics.kinematics.solver.least_squares", seen)
    for y in (12.1, 12.0, 11.0):
        robot.assemble(platform={"x": 0.5, "y": y / 43, "z": -0.5})
    assert len(systems) > 20
    for a, b, x in systems:
        assert np.all(np.isfinite(x))
        left = np.abs(np.einsum("ij...,jk...->ik...", a, x) - b).max()
        assert left < 1e-6 * np.abs(b).max() + 1e-12


@pytest.mark.parametrize("largest", range(4))
def test_quaternions_of_matrices_whatever_component_is_largest(largest):
    q = 0.3 * np.random.default_rng(largest).standard_normal((4, 20))
    q[largest] = 1.0
    q /= np.linalg.norm(q, axis=0)
    q *= np.where(q[3] < 0, -1, 1)
    R = rotations.matrix_of_quaternion(q)
    np.testing.assert_allclose(np.linalg.det(np.moveaxis(R, 2, 0)), 1, rtol=1e-13)
    np.testing.assert_allclose(np.einsum("ijn,jn->in", R, q[:3]), q[:3], atol=1e-14)
    np.testing.assert_allclose(rotations.quaternion_of_matrix(R), q, atol=1e-14)
    v = rotations.logarithm(R)
    np.testing.assert_allclose(rotations.quaternion_exponential(v), q, atol=1e-13)
