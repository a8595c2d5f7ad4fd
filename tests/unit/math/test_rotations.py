"""Rotations and orientation coordinates: round trips, derivatives, special angles, poses assembled from reported coordinates."""

from itertools import permutations
from pathlib import Path

import numpy as np
import package_robots
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.math import rotations
from kinetostatics.math.linalg import matmul
from kinetostatics.math.rotations import orientation_named

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


#: Near quarter and half turns, where some conventions determine only the sum or difference of two angles.
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


def test_undetermined_orientation_coordinates_are_the_nearby_ones():
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
def test_three_angles_about_oblique_axes_rebuild_the_rotation(skewed, q, side):
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
def test_poses_are_assembled_from_their_reported_coordinates(rpy):
    text = Path(robot_path("gough_stewart")).read_text()
    turned = text.replace('<platform link="platform"/>', f'<platform link="platform"><origin rpy="{rpy}"/></platform>')
    assert turned != text
    robot = ks.Robot(parse_robot_text(turned, "gough_stewart.urdf.xacro"))
    lengths = dict(zip(robot.description.actuated, np.array([3.0, -4, 5, 2, -2, 7]) * 1e-3, strict=True))
    for pose in (robot.assemble(), robot.assemble(actuators=lengths)):
        for name in CONVENTIONS:
            for near in (None, pose):
                again = robot.assemble(platform=pose.platform_coordinates(name), orientation=name, near=near)
                np.testing.assert_allclose(again.platform_frame, pose.platform_frame, atol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("distance", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-5, 1e-2])
def test_downward_tool_is_assembled_from_its_reported_coordinates(distance):
    arm = package_robots.robot("ur10")
    q = np.array([0, -np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2, 0.7]) + distance * np.array([1, -2, 1, 3, 2, 1])
    pose = arm.assemble(actuators=dict(zip(arm.description.actuated, q, strict=True)))
    for name in CONVENTIONS:
        again = arm.assemble(platform=pose.platform_coordinates(name), orientation=name, near=pose)
        np.testing.assert_allclose(again.platform_frame, pose.platform_frame, atol=1e-12)
        np.testing.assert_allclose(again.q, pose.q, atol=1e-9)


@pytest.mark.filterwarnings("ignore:.* turns")
def test_platform_turns_the_shorter_way_from_a_pose():
    arm = package_robots.robot("ur10")
    drives = arm.description.actuated
    pose = arm.assemble(actuators=dict(zip(drives, [0.3, -1.0, 1.5, -2.0, -1.5, 0.7], strict=True)))
    report = pose.platform_coordinates("tilt_torsion")
    for name in ("azimuth", "torsion"):
        moved = {**report, name: report[name] + 2 * np.pi + 0.1}
        one, two = (
            arm.assemble(platform={**moved, name: moved[name] - k * 2 * np.pi}, orientation="tilt_torsion", near=pose)
            for k in (0, 1)
        )
        np.testing.assert_allclose(one.q, two.q, atol=1e-12)


def test_euler_sequences_are_products_of_their_rotations():
    c = np.array([0.3, -0.5, 0.7])
    about = {axis: rotations.exponential(np.eye(3)[:, [k]] * c[k])[..., 0] for k, axis in enumerate("xyz")}
    for name, order in (("XYZ", "xyz"), ("xyz", "zyx"), ("ZXY", "zxy")):
        R = orientation_named(name).matrix(c[:, None])[..., 0]
        np.testing.assert_allclose(R, np.linalg.multi_dot([about[axis] for axis in order]), atol=1e-15)


@pytest.mark.parametrize("name", ["XYX", "Xyz", "abc", "", "XY"])
def test_unknown_orientation_is_an_error(name):
    with pytest.raises(ks.exceptions.CoordinatesError, match="orientation"):
        orientation_named(name)


@pytest.mark.parametrize("largest", range(4))
def test_quaternions_round_trip_with_any_largest_component(largest):
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


@pytest.mark.parametrize("beside", [0.0, 1e-16, 1e-14, 3e-13, 1e-9, 1e-3])
def test_shortest_rotation_to_a_nearly_opposite_direction(beside):
    """Where the normal of both is rounding, any other one is taken: the rotation is half a turn and leads there."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, aside = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
        b = -a + beside * aside
        b /= np.linalg.norm(b)
        v = rotations.rotation_between(a[:, None], b[:, None])
        assert np.linalg.norm(v) == pytest.approx(np.pi, abs=2 * beside + 1e-12)
        np.testing.assert_allclose(rotations.exponential(v)[..., 0] @ a, b, rtol=0, atol=1e-11 if beside < 1e-12 else 1e-6)


@pytest.mark.parametrize("name", ["xyz", "ZYX"])
def test_only_ambiguous_rotations_of_a_batch_are_described_anew(name):
    """Half a turn is −π as well as π; an angle that is unique is not moved by a full turn, whatever the others are."""
    convention = orientation_named(name)
    c = np.array([[np.pi, 0.3], [0.2, 0.1], [-0.4, -0.2]])
    first = c - np.array([[2 * np.pi, 0], [0, 0], [0, 0]])
    near = c + np.array([[-2 * np.pi, 2 * np.pi], [0, 0], [0, 0]])
    np.testing.assert_allclose(convention.same(c, near, False), first, atol=1e-12)
    np.testing.assert_allclose(convention.same(c, near, True), near, atol=1e-12)
    np.testing.assert_allclose(convention.same(c, near, np.array([True, False])), first, atol=1e-12)
