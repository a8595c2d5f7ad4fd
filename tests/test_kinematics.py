"""Forward kinematics against Pinocchio, rotations and orientation coordinates against themselves."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinetostatics as ks
from kinetostatics import rotations
from kinetostatics.linalg import Cholesky, least_squares
from kinetostatics.mechanism import Mechanism
from kinetostatics.orientation import orientation_named
from kinetostatics.robot_file import parse_robot_text
from kinetostatics.shipped import robot_path

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


def test_link_frames_and_masses_are_pinocchios():
    from pathlib import Path

    robot = ks.load_robot(Path(__file__).parent.parent / "robots" / "2pru_upr.urdf.xacro")
    pose = robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": -0.05}, orientation="XYZ")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.array(pose.q))
    for link in robot.description.links:
        placement = data.oMf[robot.model.getFrameId(link)].homogeneous
        np.testing.assert_allclose(pose.frame(link), placement, atol=1e-14)
    total = sum(link.mass for link in robot.description.links.values())
    assert pin.computeTotalMass(robot.model) == pytest.approx(total, rel=1e-12)


def test_gravity_torques_are_pinocchios():
    """Without beams that weigh anything the drives' forces follow from Pinocchio's generalized gravity."""
    from pathlib import Path

    robot = ks.load_robot(Path(__file__).parent.parent / "robots" / "3rps.urdf.xacro", {"density": 1e-9, "platform_mass": 20})
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
    result = ks.analyze(pose)
    model, data = robot.model, robot.model.createData()
    gravity = pin.computeGeneralizedGravity(model, data, np.array(pose.q))
    # velocities of all joints per unit of each drive, from neighbouring poses
    step = 1e-5
    for name in robot.description.driven:
        base = {key: float(value) for key, value in pose.actuators.items()}
        ends = [robot.assemble(actuators={**base, name: base[name] + sign * step}, near=pose).q for sign in (-1, 1)]
        work = gravity @ (ends[1] - ends[0]) / (2 * step)
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


CONVENTIONS = [None, "tilt_torsion", "XYZ", "xyz", "ZYX", "zyx", "YXZ", "zxy", "YZX", "xzy"]


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
    with pytest.raises(ks.CoordinatesError, match="orientation"):
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
    robot = ks.load_robot(robot_path("delta"))
    systems = []

    def seen(a, b, nullity=0):
        x = least_squares(a, b, nullity)
        systems.append((a, b, x))
        return x

    monkeypatch.setattr("kinetostatics.solver.least_squares", seen)
    for y in (12.1, 12.0, 11.0):
        robot.assemble(platform={"x": 0.5, "y": y / 43, "z": -0.5})
    assert len(systems) > 20
    for a, b, x in systems:
        assert np.all(np.isfinite(x))
        left = np.abs(np.einsum("ij...,jk...->ik...", a, x) - b).max()
        assert left < 1e-6 * np.abs(b).max() + 1e-12
