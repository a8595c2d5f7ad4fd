"""Closing loops, reaching poses, limits; errors for impossible poses and robots; statics of unusual robots."""

import re
import warnings
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import package_robots
import pinocchio as pin
import pytest
import simple_machines as sm
import small_robots as sr
from hypothesis import given
from hypothesis import strategies as st
from package_robots import robot

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

seeds = st.integers(0, 10**6)
paper = st.sampled_from(("3rps", "2pru_upr"))

#: the workspaces, as platform coordinates: lower and upper ends
WORKSPACE = {
    "3rps": ({"z": (0.35, 0.75), "rx": (-0.45, 0.45), "ry": (-0.45, 0.45)}, None),
    "2pru_upr": ({"z": (0.3, 0.6), "rx": (-0.25, 0.25), "ry": (-0.25, 0.25)}, "XYZ"),
}


def robot_of_text(text):
    return ks.Robot(parse_robot_text(text))


def random_targets(name, rng, shape=()):
    ranges, orientation = WORKSPACE[name]
    return {key: rng.uniform(*ends, shape) for key, ends in ranges.items()}, orientation


# ---- reaching the workspace ----------------------------------------------------------------------------------------------


@given(paper, seeds)
def test_the_whole_workspace_is_reached_from_the_zero_pose(name, seed):
    targets, orientation = random_targets(name, np.random.default_rng(seed), (40,))
    poses = robot(name).assemble(platform=targets, orientation=orientation)
    assert np.all(poses.residual < 1e-12)
    assert np.all((poses.status == ks.Status.OK) | (poses.status == ks.Status.LIMIT_EXCEEDED))
    for key, values in targets.items():
        np.testing.assert_allclose(poses.platform[key], values, rtol=0, atol=1e-12)
    # q closes the loops by itself: Pinocchio's frames agree
    model, i = robot(name).model, int(seed % 40)
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array(poses.q[i]))
    platform = data.oMf[model.getFrameId("platform")].homogeneous
    np.testing.assert_allclose(poses.platform_frame[i], platform, rtol=0, atol=1e-12)
    again = robot(name).configuration(poses.q)
    assert np.all(again.residual < 1e-12)


@given(paper, seeds)
def test_forward_kinematics_inverts_inverse_kinematics(name, seed):
    rng = np.random.default_rng(seed)
    targets, orientation = random_targets(name, rng)
    inverse = robot(name).assemble(platform=targets, orientation=orientation)
    near = robot(name).assemble(actuators=dict(inverse.actuators), near=inverse)
    np.testing.assert_allclose(near.platform_frame, inverse.platform_frame, rtol=0, atol=1e-11)
    forward = robot(name).assemble(actuators=dict(inverse.actuators))
    np.testing.assert_allclose(forward.platform_frame, inverse.platform_frame, rtol=0, atol=1e-10)
    np.testing.assert_allclose(forward.q, inverse.q, rtol=0, atol=1e-9)


def test_lengths_of_the_3rps_follow_from_its_geometry():
    """Inverse kinematics in closed form: distances between platform points and base points."""
    targets, _ = random_targets("3rps", np.random.default_rng(1), (30,))
    poses = robot("3rps").assemble(platform=targets)
    for k, azimuth in enumerate(np.radians([0, -120, 120]), 1):
        out = np.array([np.cos(azimuth), np.sin(azimuth), 0])
        head = poses.platform_frame @ np.append(0.2 * out, 1)
        rod = head[:, :3] - 0.3 * out
        np.testing.assert_allclose(0.55 + poses.actuators[f"prismatic_{k}"], np.linalg.norm(rod, axis=1), atol=1e-12)
        np.testing.assert_allclose(rod @ [-out[1], out[0], 0], 0, atol=1e-12)  # in the revolute joint's plane


def test_orientation_conventions_agree():
    rng = np.random.default_rng(7)
    angles = {key: rng.uniform(-0.4, 0.4) for key in ("rx", "ry", "rz")}
    position = {key: v + rng.uniform(-0.03, 0.03) for key, v in zip("xyz", (0.02, -0.01, 0.73), strict=True)}
    one = small("gough")
    pose = one.assemble(platform={**position, **angles})
    np.testing.assert_allclose(
        pose.platform_frame[:3, :3], pin.exp3(np.array([angles["rx"], angles["ry"], angles["rz"]])), atol=1e-12
    )
    for name in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "tilt_torsion"):
        coordinates = {key: float(value) for key, value in pose.platform_coordinates(name).items()}
        again = one.assemble(platform=coordinates, orientation=name)
        np.testing.assert_allclose(again.platform_frame, pose.platform_frame, rtol=0, atol=1e-11)
        for key, value in coordinates.items():
            assert again.platform[key] == pytest.approx(value, abs=1e-11)
        if name != "tilt_torsion":
            R = np.eye(3)
            for axis in name.lower():
                turn = pin.utils.rotate(axis, float(coordinates[f"r{axis}"]))
                R = R @ turn if name.isupper() else turn @ R
            np.testing.assert_allclose(R, pose.platform_frame[:3, :3], atol=1e-12)
    azimuth, tilt, torsion = (float(pose.platform_coordinates("tilt_torsion")[k]) for k in ("azimuth", "tilt", "torsion"))
    normal = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    np.testing.assert_allclose(pose.platform_frame[:3, 2], normal, atol=1e-12)
    R = pin.utils.rotate("z", azimuth) @ pin.utils.rotate("y", tilt) @ pin.utils.rotate("z", torsion - azimuth)
    np.testing.assert_allclose(pose.platform_frame[:3, :3], R, atol=1e-12)


@cache
def small(name):
    specs = {
        "gough": sr.gough, "gough_sps": lambda: sr.gough("S"), "puu3": sr.puu3, "four_bar": sr.four_bar,
        "planar_3rrr": sr.planar_3rrr,
    }  # fmt: skip
    return sr.robot_of(specs[name]())


@given(st.sampled_from(("3rps", "2pru_upr", "four_bar", "planar_3rrr")), seeds)
def test_the_assembly_mode_is_that_of_fine_continuation(name, seed):
    one = robot(name) if name in WORKSPACE else small(name)
    rng = np.random.default_rng(seed)
    span = {"3rps": 0.12, "2pru_upr": 0.08, "four_bar": 0.9, "planar_3rrr": 0.5}[name]
    target = {joint: rng.uniform(-span, span) for joint in one.description.actuated}
    direct = one.assemble(actuators=target, on_failure="nan")
    pose = one.assemble()
    for s in np.linspace(0, 1, 25)[1:]:
        pose = one.assemble(actuators={k: s * v for k, v in target.items()}, near=pose, on_failure="nan")
        if pose.status == ks.Status.UNREACHABLE:
            break
    assert (pose.status == ks.Status.UNREACHABLE) == (direct.status == ks.Status.UNREACHABLE)
    np.testing.assert_allclose(direct.platform_frame, pose.platform_frame, rtol=0, atol=1e-9)


def test_poses_have_broadcast_shapes_of_coordinates():
    one = robot("3rps")
    poses = one.assemble(platform={"z": np.linspace(0.5, 0.6, 4)[:, None], "rx": np.linspace(-0.1, 0.1, 3), "ry": 0.0})
    assert poses.shape == (4, 3) and poses.q.shape == (4, 3, one.model.nq) and poses.frame("rod_2").shape == (4, 3, 4, 4)
    moved = one.assemble(platform={"z": poses.platform["z"] + 0.01, "rx": poses.platform["rx"], "ry": 0.05}, near=poses)
    assert moved.shape == (4, 3) and np.all(moved.residual < 1e-12)
    with pytest.raises(ks.ArgumentError, match="shape"):
        one.assemble(platform={"z": [0.51, 0.56], "rx": 0.1, "ry": 0.05}, near=poses)
    with pytest.raises(ks.ArgumentError, match="another robot"):
        one.assemble(near=robot("2pru_upr").assemble())
    empty = one.assemble(platform={"z": np.zeros((0, 3)), "rx": 0.0, "ry": 0.0})
    assert empty.shape == (0, 3) and ks.analyze(empty).twist.shape == (0, 3, 6)


# ---- errors of coordinates -----------------------------------------------------------------------------------------------


def test_unreachable_pose_error_names_mobility_and_open_loop():
    one = robot("3rps")
    with pytest.raises(ks.AssemblyError) as caught:
        one.assemble(actuators={"prismatic_1": 2.0, "prismatic_2": -0.3, "prismatic_3": -0.3})
    error = caught.value
    assert error.mobility == 3 and "mobility 3" in str(error)
    worst = max(error.residuals, key=lambda name: max(error.residuals[name]))
    assert worst in ("spherical_1", "spherical_2", "spherical_3") and worst in str(error)
    assert error.residual == max(max(pair) for pair in error.residuals.values()) > 1e-3
    number = f"{error.residuals[worst][0]:.3g}"
    assert number in str(error)
    with pytest.raises(ks.AssemblyError, match=r"mobility 3.*loop '(universal_2|revolute_3)' stays"):
        robot("2pru_upr").assemble(platform={"z": 0.9, "rx": 0, "ry": 0}, orientation="XYZ")


def test_unreachable_poses_of_a_batch_are_nan():
    one = robot("2pru_upr")
    poses = one.assemble(platform={"z": [0.6, 0.9, 0.5], "rx": 0.05, "ry": 0.0}, orientation="XYZ")
    np.testing.assert_array_equal(poses.status, [ks.Status.OK, ks.Status.UNREACHABLE, ks.Status.OK])
    found = ks.analyze(poses)
    np.testing.assert_array_equal(found.status, poses.status)
    everything = [
        poses.q, poses.residual, poses.platform_frame, poses.frame("rod_1"), found.twist, found.stiffness, found.compliance,
        found.base_wrench, found.contributions["limb_2"], found.joint_wrenches["universal_2"], found.strain_energy,
        found.actuator_forces["prismatic_1"], found.limbs["limb_1"].intensities, found.limbs["limb_1"].compliance,
        found.beams["rod_3"].deflections, found.beams["rod_3"].stress, found.platform_wrench, poses.platform["z"],
        poses.actuators["prismatic_1"], found.link_contributions["platform"]["load"], found.beams["rod_1"].length,
    ]  # fmt: skip
    for array in everything:
        assert np.all(np.isnan(array[1])) and np.all(np.isfinite(array[[0, 2]]))
    alone = one.assemble(platform={"z": 0.9, "rx": 0.05, "ry": 0.0}, orientation="XYZ", on_failure="nan")
    assert alone.status == ks.Status.UNREACHABLE and np.all(np.isnan(alone.q))
    assert np.all(np.isnan(ks.analyze(alone, on_failure="nan").twist))
    with pytest.raises(ks.AssemblyError):
        one.assemble(platform={"z": [0.6, 0.9], "rx": 0.05, "ry": 0.0}, orientation="XYZ", on_failure="raise")


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [0, 50048])
def test_large_batch_reaches_the_same_poses_as_single_calls(seed):
    """Scattered over and beyond both discs that a five-bar's arms reach, in random order, some of them far away."""
    robot, rng = package_robots.robot("five_bar"), np.random.default_rng(seed)
    x, y = rng.uniform(-0.45, 0.45, 4000), rng.uniform(0.03, 0.5, 4000)
    x[::101], y[::101] = rng.uniform(3, 9, x[::101].size), -40.0
    found = robot.assemble(platform={"x": x, "y": y}, on_failure="nan")
    reach = np.maximum(np.hypot(x + 0.1375, y), np.hypot(x - 0.1375, y))
    reached = found.status != ks.Status.UNREACHABLE
    assert not np.any(reached & (reach > 0.46))
    assert np.all(reached[reach < 0.4595]), "a batch takes larger steps, but for half a millimetre it is the same"
    # each element of the batch is the pose alone
    for k in rng.choice(np.flatnonzero(reached), 20):
        alone = robot.assemble(platform={"x": x[k], "y": y[k]})
        np.testing.assert_allclose(found.q[k], alone.q, atol=1e-9)


@pytest.mark.parametrize("odd", [np.nan, np.inf, 1e300])
def test_invalid_coordinate_fails_only_its_own_pose(odd, count=20):
    robot = package_robots.robot("five_bar")
    x, y = np.linspace(-0.1, 0.1, count), np.full(count, 0.3)
    x[7] = odd
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", r"x = 1e\+300 m is .* times the robot's size")
        found = robot.assemble(platform={"x": x, "y": y}, on_failure="nan")
    assert found.status[7] == ks.Status.UNREACHABLE and np.all(np.isnan(found.q[7]))
    assert np.all(np.delete(found.status, 7) == ks.Status.OK)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"platform": {"z": 0.5}}, "1 platform coordinate.*mobility.* 3.*exactly 3"),
        ({"platform": {"x": 0, "y": 0, "z": 0.5, "rx": 0}}, "4 platform coordinates.*mobility.* 3"),
        ({"platform": {"z": 0.5, "rx": 0, "roll": 0}}, "'roll'.*rx"),
        ({"platform": {"z": 0.5, "rx": 0, "tilt": 0}}, "'tilt'"),
        ({"platform": {"z": 0.5, "azimuth": 0, "rx": 0}, "orientation": "tilt_torsion"}, "'rx'"),
        ({"platform": {"x": 0.001, "y": 0, "z": 0.5}}, "do not determine.*z, rx, ry do$"),
        ({"platform": {"z": 0.5, "rz": 0, "rx": 0}}, "do not determine"),
        ({"platform": {"z": 0.5, "rx": 0, "ry": 0}, "orientation": "XXY"}, "orientation 'XXY'"),
        ({"platform": {"z": 0.5, "rx": 0, "ry": 0}, "orientation": "Xyz"}, "orientation 'Xyz'"),
        ({"platform": {"z": "high", "rx": 0, "ry": 0}}, "z = 'high'"),
        ({"platform": {"z": np.nan, "rx": 0, "ry": 0}}, "finite"),
        ({"platform": {"z": [0.5, 0.6], "rx": [0, 0, 0], "ry": 0}}, "shapes"),
        ({"actuators": {"prismatic_1": 0}}, "missing.*prismatic_2, prismatic_3"),
        ({"actuators": {"prismatic_1": 0, "prismatic_2": 0, "prismatic_3": 0, "prismatic_4": 0}}, "'prismatic_4'.*mean"),
        ({"actuators": {"prismatic_1": 0, "prismatic_2": 0, "revolute_3": 0}}, "revolute_3"),
        ({"actuators": {}, "platform": {}}, "not both"),
        ({"closure_tolerance": 0}, "closure_tolerance"),
        ({"on_failure": "skip"}, "on_failure"),
    ],
)  # fmt: skip
def test_wrong_coordinates_and_arguments_are_refused(arguments, words):
    with pytest.raises(ks.ArgumentError, match=words) as caught:
        robot("3rps").assemble(**arguments)
    assert isinstance(caught.value, ks.exceptions.CoordinatesError) == ({"platform", "actuators"} & set(arguments) != set())


def test_untilted_pose_accepts_any_azimuth():
    pose = robot("3rps").assemble(platform={"z": 0.5, "azimuth": 0.3, "tilt": 0.0}, orientation="tilt_torsion")
    np.testing.assert_allclose(pose.platform_frame[:3, :3], np.eye(3), atol=1e-12)


def test_open_configurations_are_refused():
    one = robot("3rps")
    q = np.array(one.assemble().q)
    assert one.configuration(q).residual < 1e-12
    q[0] += 1e-3
    with pytest.raises(ks.AssemblyError, match="spherical_"):
        one.configuration(q)
    assert one.configuration(q, closure_tolerance=1e-2).residual > 1e-5
    assert one.configuration([q, q]).status.tolist() == [ks.Status.UNREACHABLE] * 2
    with pytest.raises(ks.ArgumentError, match="nq = "):
        one.configuration([0, 0])
    with pytest.raises(ks.ArgumentError, match="no link 'rod_9'"):
        one.assemble().frame("rod_9")


# ---- limits --------------------------------------------------------------------------------------------------------------


def test_exceeded_limits_and_cones_are_reported():
    one = robot("3rps")
    fine = one.assemble(platform={"z": 0.5, "rx": 0, "ry": 0})
    assert fine.status == ks.Status.OK and not fine.limits_exceeded
    high = one.assemble(platform={"z": 1.1, "rx": 0, "ry": 0})
    assert high.status == ks.Status.LIMIT_EXCEEDED
    assert set(high.limits_exceeded) == {"prismatic_1", "prismatic_2", "prismatic_3"}
    item = high.limits_exceeded["prismatic_1"]
    assert item.upper == pytest.approx(0.45) and item.value == pytest.approx(np.hypot(1.1, 0.1) - 0.55) and item.where
    found = ks.analyze(high)
    assert found.status == ks.Status.LIMIT_EXCEEDED and np.all(np.isfinite(found.twist))
    assert any("prismatic_1" in warning for warning in found.warnings)
    batch = one.assemble(platform={"z": [0.5, 0.5, 1.1], "rx": [0.0, 1.0, 0.0], "ry": 0})
    assert batch.status.tolist() == [ks.Status.OK, ks.Status.LIMIT_EXCEEDED, ks.Status.LIMIT_EXCEEDED]
    for item in batch.limits_exceeded.values():
        np.testing.assert_array_equal(item.where, (item.value < item.lower - 1e-9) | (item.value > item.upper + 1e-9))
    tilted = one.assemble(platform={"z": 0.5, "rx": 1.0, "ry": 0})
    cones = {joint: item for joint, item in tilted.limits_exceeded.items() if joint.startswith("spherical_")}
    assert cones
    for k in (1, 2, 3):  # the angle between rod and normal, by hand
        angle = np.arccos(tilted.frame(f"rod_{k}")[:3, 2] @ tilted.platform_frame[:3, 2])
        assert (f"spherical_{k}" in cones) == (angle > np.radians(60))
        if f"spherical_{k}" in cones:
            assert cones[f"spherical_{k}"].value == pytest.approx(angle)


# ---- rounded angles ------------------------------------------------------------------------------------------------------


def rounded(text, digits=4):
    """Return the text of a robot whose angles are rounded."""

    def short(match):
        return 'rpy="' + " ".join(f"{float(v):.{digits}f}" for v in match[1].split()) + '"'

    return re.sub(r'rpy="([^"]*)"', short, text)


@pytest.mark.parametrize(("seed", "digits"), [(1, 4), pytest.param(5, 6, marks=pytest.mark.slow)])
def test_rounded_angles_of_overconstrained_robot_need_a_tolerance(seed, digits):
    exact = ks.analyze(sr.robot_of(sr.pru2_upr()).assemble(), gravity=(0, 0, 9.8))
    # with four digits the frames are turned by right angles, with six in any way
    one = robot_of_text(rounded(sr.write(sr.pru2_upr(), twirl=seed, right=digits == 4).text, digits))
    with pytest.raises(ks.AssemblyError) as caught:
        one.assemble()
    assert "rounded" in str(caught.value) and "tolerance" in str(caught.value)
    assert 1e-8 < caught.value.residual < 1e-4
    pose = one.assemble(closure_tolerance=1e-4)
    assert pose.residual == pytest.approx(caught.value.residual, rel=1e-3)
    found = ks.analyze(pose, gravity=(0, 0, 9.8))
    np.testing.assert_allclose(found.twist, exact.twist, rtol=0, atol=1e-4 * np.abs(exact.twist).max())
    for joint, force in exact.actuator_forces.items():
        assert found.actuator_forces[joint] == pytest.approx(force, rel=1e-4)
    assert [limb.labels for limb in found.limbs.values()] == [limb.labels for limb in exact.limbs.values()]
    assert one.mobility.platform == 3 and one.mobility.redundant_constraints == 3
    many = one.assemble(platform={"z": [0.45, 0.55], "rx": 0.1, "ry": [0.05, -0.1]}, orientation="XYZ", closure_tolerance=1e-4)
    assert many.status.tolist() == [ks.Status.OK] * 2


def test_rounded_angles_without_overconstraint_close_exactly():
    text = sr.write(sr.rps3(), twirl=1, right=True).text
    assert robot_of_text(rounded(text)).assemble().residual < 1e-12


# ---- poses and robots that cannot be held --------------------------------------------------------------------------------


def without_drives(spec, count):
    """Return the spec with its first ``count`` actuators taken away."""
    limbs = []
    for limb in spec.limbs:
        joints = []
        for joint in limb.joints:
            off = joint.actuated and count > 0
            count -= off
            joints.append(replace(joint, actuated=joint.actuated and not off))
        limbs.append(replace(limb, joints=tuple(joints)))
    return replace(spec, limbs=tuple(limbs))


def test_singular_pose_names_the_free_twist():
    # four-bar with coupler and follower in one line: the actuated crank leaves the coupler an infinitesimal freedom
    y = (0, 1, 0)
    points = {1: ((0, 0, 0), (0, 0, 0.5)), 2: ((0.8, 0, 0), (0.48, 0, 0.2))}
    limbs = tuple(
        sr.Limb((sr.Joint(f"foot_{n}", "R", a, y, actuated=n == 1), sr.Joint(f"head_{n}", "R", b, y)), (sr.Link(f"crank_{n}"),))
        for n, (a, b) in points.items()
    )
    beams = tuple(sr.Beam(f"crank_{n}", f"crank_{n}", f"foot_{n}", f"head_{n}", sr.circle(0.03)) for n in points)
    spec = sr.Spec(limbs, beams, o=(0, 0, 0.5), mass=1.0, com=(0.3, 0, 0.4))
    one = sr.robot_of(spec)
    pose = one.configuration(pin.neutral(one.model))
    with pytest.raises(ks.exceptions.SingularPoseError) as caught:
        ks.analyze(pose, (1, 0, 0, 0, 0, 0), (0, 0, 0))
    free = caught.value.free_twists
    assert free.shape == (6, 1)
    direction = free[:, 0] / np.abs(free[:, 0]).max()
    np.testing.assert_allclose(np.abs(direction), [0, 0, 0, 0, 1, 0], atol=1e-9)  # turns about head_1, where o is
    assert "singular" in str(caught.value) and "rotation" in str(caught.value).lower()
    batch = ks.analyze(one.configuration(np.zeros((2, one.model.nq))), (1, 0, 0, 0, 0, 0), (0, 0, 0))
    assert batch.status.tolist() == [ks.Status.SINGULAR] * 2
    assert np.all(np.isnan(batch.twist)) and np.all(np.isnan(batch.joint_wrenches["head_2"]))


@pytest.mark.parametrize("name", ["rps3", "planar_3rrr"])
def test_missing_actuator_raises_singular_pose_error(name):
    spec = without_drives(getattr(sr, name)(), 1)
    one = sr.robot_of(spec)
    with pytest.raises(ks.exceptions.SingularPoseError, match=r"2 actuators.*mobility of 3") as caught:
        ks.analyze(one.configuration(pin.neutral(one.model)))
    assert caught.value.free_twists.shape[1] == 1


def test_limb_that_cannot_hold_its_weight_raises_an_error():
    spec = sr.gough()
    # a seventh limb of two struts with ball joints at their ends sags like a rope
    joints = (
        sr.Joint("ball_a", "S", (0.9, 0, 0)), sr.Joint("ball_b", "S", (0.8, 0.2, 0.3)), sr.Joint("ball_c", "S", (0.6, 0, 0.75)),
    )  # fmt: skip
    extra = sr.Limb(joints, (sr.Link("strut_a", 1.0, (0.85, 0.1, 0.15)), sr.Link("strut_b", 1.0, (0.7, 0.1, 0.525))))
    one = sr.robot_of(replace(spec, limbs=(*spec.limbs, extra)))
    pose = one.configuration(pin.neutral(one.model))
    with pytest.raises(ks.exceptions.LimbEquilibriumError) as caught:
        ks.analyze(pose)
    assert caught.value.limb == "limb_7" and "limb_7" in str(caught.value)
    assert set(caught.value.joints) >= {j for j in one.description.joints if j.startswith("ball_")}
    for joint in caught.value.joints:
        assert joint in str(caught.value)
    assert ks.analyze(pose, on_failure="nan").status == ks.Status.SINGULAR
    # without weight it has no effect
    light = replace(extra, links=(sr.Link("strut_a"), sr.Link("strut_b")))
    one = sr.robot_of(replace(spec, limbs=(*spec.limbs, light)))
    same = ks.analyze(one.configuration(pin.neutral(one.model)), gravity=(0, 0, -9.81))
    plain = sr.robot_of(spec)
    np.testing.assert_allclose(same.twist, ks.analyze(plain.assemble()).twist, rtol=1e-9)


def test_spinning_strut_does_not_change_the_statics():
    one = small("gough_sps")
    assert (one.mobility.platform, one.mobility.local, one.mobility.redundant_constraints) == (6, 6, 0)
    assert str(one.mobility) == "6 (+6 local)"
    found = ks.analyze(one.assemble(), load=(10, 20, 30, 1, 2, 3))
    other = ks.analyze(small("gough").assemble(), load=(10, 20, 30, 1, 2, 3))
    np.testing.assert_allclose(found.twist, other.twist, rtol=1e-9)
    for joint, force in other.actuator_forces.items():
        assert found.actuator_forces[joint] == pytest.approx(force, rel=1e-9)


def test_unheld_limb_is_named_although_platform_is_held():
    # a strut between ball joints whose centre of mass is off its axis would spin
    spec = sr.gough("S")
    limb = spec.limbs[0]
    heavy = replace(limb, links=(sr.Link("cylinder_1", 2.0, (0.5, 0.3, 0.2)), limb.links[1]))
    one = sr.robot_of(replace(spec, limbs=(heavy, *spec.limbs[1:])))
    with pytest.raises(ks.exceptions.LimbEquilibriumError, match="limb_1"):
        ks.analyze(one.assemble())


# ---- rigid limbs ---------------------------------------------------------------------------------------------------------


def walls(*limbs, mass=2.0, beams=()):
    return sr.Spec(limbs, beams, o=(0, 0, 1), mass=mass, com=(0, 0, 1))


def wall(n, y, kind="R", actuated=True):
    """Return a column whose foot is an actuator, or a rail along x, and whose head is an actuator."""
    foot = sr.Joint(f"foot_{n}", kind, (0, y, 0), (1, 0, 0), actuated=actuated)
    joints = (foot, sr.Joint(f"head_{n}", "R", (0, y, 1), (0, 1, 0), actuated=True))
    return sr.Limb(joints, (sr.Link(f"column_{n}"),))


def test_forces_of_redundant_rigid_limbs_are_indeterminate():
    beam = sr.Beam("third", "column_3", "foot_3", "head_3", sr.circle(0.05))
    one = sr.robot_of(walls(wall(1, -1), wall(2, 1), wall(3, 0.5), mass=10.0, beams=(beam,)))
    found = ks.analyze(one.assemble(), load=(10, 0, 0, 0, 0, 0))
    assert found.status == ks.Status.INDETERMINATE
    np.testing.assert_allclose(found.twist, 0, atol=1e-20)
    for limb in ("limb_1", "limb_2"):
        assert np.all(np.isnan(found.limbs[limb].intensities))
        assert np.all(np.isnan(found.limbs[limb].wrench))
    assert np.all(np.isnan(found.joint_wrenches["foot_1"]))
    assert np.isnan(found.actuator_forces["foot_2"])
    assert any("limb_1" in warning and "limb_2" in warning for warning in found.warnings)
    # the elastic third one, between base and a platform that stands still, carries only its own weight
    q = 7850 * sr.circle(0.05).area * 9.81
    assert found.limbs["limb_3"].wrench[2] == pytest.approx(q / 2, rel=1e-9)
    assert np.all(np.isfinite(found.joint_wrenches["foot_3"]))
    assert np.all(np.isfinite(found.beams["third"].deflections))


def test_only_indeterminate_forces_of_rigid_limbs_are_nan():
    # the second wall is on a rail along x: all of the load along x goes to the first
    one = sr.robot_of(walls(wall(1, -1), wall(2, 1, "P", False)))
    found = ks.analyze(one.assemble(), load=(10, 0, 0, 0, 0, 0))
    assert found.status == ks.Status.INDETERMINATE
    np.testing.assert_allclose(found.twist, 0, atol=1e-20)
    assert np.all(np.isnan(found.joint_wrenches["foot_1"][1:3]))
    # the base's total wrench is determined
    np.testing.assert_allclose(found.base_wrench, [-10, 0, 2 * 9.81, 0, -10, 0], rtol=0, atol=1e-9)


# ---- unusual robots ------------------------------------------------------------------------------------------------------


def test_limb_without_links_carries_its_share():
    """A hinge directly between base and platform, and a column beside it."""
    one = sm.robot(
        sm.link("base"), sm.link("column"), sm.link("platform", 4.0, "0.5 0 0"),
        sm.joint("hinge", "revolute", "base", "platform", "0 0 1"), sm.joint("foot", "revolute", "base", "column", "1 0 0"),
        sm.loop("head", "revolute", "column", "platform", "0 0 1", "1 0 0", "0 1 0"),
        sm.bar("column", "foot", "head", sm.RHO, sm.CIRCLE),
    )  # fmt: skip
    assert [limb.links for limb in one.topology.limbs] == [("column",), ()]
    found = ks.analyze(one.assemble(), load=(0, 0, -100, 0, 0, 0), point=(1, 0, 1))
    assert found.status == ks.Status.OK
    A = np.pi * 0.05**2 / 4
    q = sm.RHO * A * 9.81
    np.testing.assert_allclose(found.twist, [0, 0, 0, 0, (100 + 2 * 9.81 + q / 2) / (sm.E * A), 0], rtol=1e-9, atol=1e-18)
    assert found.joint_wrenches["hinge"][2] == pytest.approx(2 * 9.81, rel=1e-9)
    np.testing.assert_allclose(found.joint_wrenches["hinge"][4], 0, atol=1e-9)


def portal_text(extra="", loops=""):
    text = sr.write(sr.portal(mass=5.0)).text
    return text.replace("</robot>", extra + loops + "</robot>")


def hang(name, parent, xyz, mass, kind="fixed", com="0 0 -0.2"):
    return sm.link(name, mass, com) + sm.joint(f"{name}_joint", kind, parent, name, xyz)


def test_branch_weight_counts_for_its_base_platform_or_limb():
    plain = ks.analyze(robot_of_text(portal_text()).assemble())
    A = np.pi * 0.05**2 / 4
    # on the base: it changes the base reaction only
    base = ks.analyze(robot_of_text(portal_text(hang("box", "base", "2 0 0", 3.0))).assemble())
    np.testing.assert_allclose(base.twist, plain.twist, rtol=1e-12)
    np.testing.assert_allclose(base.base_wrench - plain.base_wrench, [0, 0, 3 * 9.81, 0, -2 * 3 * 9.81, 0], atol=1e-9)
    # on the platform, at rest on a hinge below it: the platform's weight. The platform's link sits at a column's head.
    pendulum = hang("bob", "platform", "0.4 0 0", 3.0, "revolute")
    found = ks.analyze(robot_of_text(portal_text(pendulum)).assemble())
    lower = found.contributions["platform_weight"] - plain.contributions["platform_weight"]
    np.testing.assert_allclose(lower[2], -3 * 9.81 / 2 / (200e9 * A), rtol=1e-9)
    np.testing.assert_allclose(found.joint_wrenches["bob_joint"], [0, 0, 3 * 9.81, 0, 0, 0], atol=1e-9)
    moved = sum(found.link_contributions["bob"].values())
    assert moved[2] == pytest.approx(found.twist[2], rel=1e-9)
    # on a limb, at the column's head, fixed to the column: the limb's weight
    extra = hang("lamp", "column_1", "0 0 1", 3.0)
    found = ks.analyze(robot_of_text(portal_text(extra)).assemble())
    more = found.beams["column_1"].section_wrenches[0, 0] - plain.beams["column_1"].section_wrenches[0, 0]
    assert more == pytest.approx(-3 * 9.81, rel=1e-2)  # nearly all of it goes down this column
    np.testing.assert_allclose(found.base_wrench[2] - plain.base_wrench[2], 3 * 9.81, rtol=1e-9)
    assert found.contributions["limb_1"][2] < plain.contributions["limb_1"][2]


def test_swinging_branch_raises_an_error_unless_actuated():
    extra = hang("bob", "platform", "0.4 0 0", 3.0, "revolute", com="0.3 0 0")
    one = robot_of_text(portal_text(extra))
    with pytest.raises(ks.exceptions.LimbEquilibriumError, match=r"platform.*bob_joint") as caught:
        ks.analyze(one.assemble())
    assert caught.value.joints == ("bob_joint",)
    actuated = extra + '<transmission name="d"><joint name="bob_joint"/></transmission>'
    found = ks.analyze(robot_of_text(portal_text(actuated)).assemble())
    assert abs(found.actuator_forces["bob_joint"]) == pytest.approx(3 * 9.81 * 0.3, rel=1e-9)
    sideways = robot_of_text(portal_text(hang("bob", "platform", "0.4 0 0", 3.0, "revolute")))
    with pytest.raises(ks.exceptions.LimbEquilibriumError):
        ks.analyze(sideways.assemble(), gravity=(1, 0, -9.81))
    assert ks.analyze(sideways.assemble(), gravity=(0, 1, -9.81)).status == ks.Status.OK


def test_base_need_not_be_the_root():
    """The same robot with another root of the tree: world axes and origin are the base's."""
    plain = sr.write(sr.rps3()).text
    # a root link in front of the base, joined by a free joint or by a turned fixed one
    floating = plain.replace(
        "<platform ", '<link name="root"/><joint name="free" type="floating"><parent link="root"/><child link="base"/>'
        '<origin xyz="1 2 3" rpy="0.3 0.2 0.1"/></joint><base link="base"/><platform ', 1,
    )  # fmt: skip
    targets = {"prismatic_1": 0.03, "prismatic_2": -0.02, "prismatic_3": 0.01}
    expected = ks.analyze(robot_of_text(plain).assemble(actuators=targets), (1, 2, 3, 4, 5, 6))
    one = robot_of_text(floating)
    found = ks.analyze(one.assemble(actuators=targets), (1, 2, 3, 4, 5, 6))
    np.testing.assert_allclose(found.twist, expected.twist, rtol=0, atol=1e-9 * np.abs(expected.twist).max())
    np.testing.assert_allclose(found.base_wrench, expected.base_wrench, rtol=0, atol=1e-9 * 100)
    np.testing.assert_allclose(found.configuration.platform_frame, expected.configuration.platform_frame, rtol=0, atol=1e-12)


def test_a_limb_whose_twists_are_nearly_dependent_has_a_basis():
    """One of its singular values is below 1e-2, far above rounding."""
    one = sr.robot_of(sr.random_spec(["SrC", "RpR", "SUpp"], 257))
    assert ks.analyze(one.configuration(pin.neutral(one.model))).status == ks.Status.OK


@pytest.mark.parametrize("carrier", ["rod", "middle", "cylinder"])
def test_drives_of_a_telescope_carry_the_links_beyond_them(carrier):
    """Each actuator holds the links outboard of it, and the beam if that is carried by one of them."""
    one = sm.robot(
        sm.link("base"), sm.link("cylinder"), sm.link("middle", 3.0), sm.link("rod"), sm.link("platform"),
        sm.joint("root", "fixed", "base", "cylinder"), sm.joint("p1", "prismatic", "cylinder", "middle", "0 0 0.4", "0 0 1"),
        sm.joint("p2", "prismatic", "middle", "rod", "0 0 0.4", "0 0 1"),
        sm.joint("head", "fixed", "rod", "platform", "0 0 0.4"),
        '<transmission name="t"><joint name="p1"/><joint name="p2"/></transmission>',
        sm.bar(carrier, "root", "head", sm.RHO, sm.CIRCLE),
    )  # fmt: skip
    result = ks.analyze(one.assemble(), gravity=(0, 0, -10))
    beam, link = sm.RHO * np.pi * 0.025**2 * 1.2, 0 if carrier == "middle" else 3  # whose own mass is replaced by the beam's
    assert float(result.actuator_forces["p1"]) == pytest.approx(10 * (link + beam * (carrier in ("middle", "rod"))))
    assert float(result.actuator_forces["p2"]) == pytest.approx(10 * beam * (carrier == "rod"), abs=1e-9)
    assert result.base_wrench[2] == pytest.approx(10 * (beam + link))


def test_actuated_local_freedom_follows_its_actuator():
    """A passive pendulum hangs on a fixed rod, and an actuated arm on the base: neither moves the platform."""
    one = sm.robot(
        sm.link("base"), sm.link("rod"), sm.link("platform"), sm.joint("foot", "fixed", "base", "rod"),
        sm.joint("head", "fixed", "rod", "platform", "0 0 0.5"), sm.bar("rod", "foot", "head", sm.RHO, sm.CIRCLE),
        hang("pendulum", "rod", "0 0 0.5", 1.0, "continuous"), hang("arm", "base", "1 0 0", 1.0, "continuous"),
        '<transmission name="t"><joint name="arm_joint"/></transmission>',
    )  # fmt: skip
    pose = one.assemble(actuators={"arm_joint": 0.7})
    assert pose.status == ks.Status.OK and float(pose.actuators["arm_joint"]) == pytest.approx(0.7)
    assert float(ks.analyze(pose).actuator_forces["arm_joint"]) == pytest.approx(9.81 * 0.2 * np.sin(0.7))


@pytest.mark.few(1)
@pytest.mark.parametrize("rounded", ["1.57", "1.571", "1.5708"])
def test_rounding_does_not_change_the_assembly_mode(rounded):
    """A distant pose that closes the rounded loop a little better is not chosen."""
    text = Path(__file__).with_name("five_bar_rounded.urdf").read_text()
    exact = ks.Robot(parse_robot_text(text.replace('"1.57 0 0"', '"1.5707963267948966 0 0"')))
    robot = ks.Robot(parse_robot_text(text.replace('"1.57 0 0"', f'"{rounded} 0 0"')))
    assert robot.mobility.platform == exact.mobility.platform == 2
    with pytest.raises(ks.AssemblyError, match="rounded"):
        robot.assemble()
    for drives in ({"A1": 0, "A2": 0}, {"A1": 0.2, "A2": -0.1}):
        found = ks.analyze(robot.assemble(actuators=drives, closure_tolerance=2e-3))
        wanted = ks.analyze(exact.assemble(actuators=drives))
        np.testing.assert_allclose(found.configuration.platform_frame, wanted.configuration.platform_frame, atol=2e-3)
        np.testing.assert_allclose(found.twist, wanted.twist, atol=1e-2 * np.abs(wanted.twist).max())
        assert any("open" in warning for warning in found.warnings)


def test_beams_of_dead_branches_bend_under_their_own_weight():
    """A bracket on the base is a cantilever: q L²/2 at its root, q L⁴/8EI at its tip."""
    one = sm.robot(
        sm.link("base"), sm.link("rod"), sm.link("platform"), sm.link("arm"), sm.link("end"),
        sm.joint("foot", "fixed", "base", "rod"), sm.joint("head", "fixed", "rod", "platform", "0 0 0.5"),
        sm.joint("inner", "fixed", "base", "arm"), sm.joint("outer", "fixed", "arm", "end", "0.4 0 0"),
        sm.bar("rod", "foot", "head", 0.0, sm.CIRCLE), sm.bar("arm", "inner", "outer", sm.RHO, sm.CIRCLE),
    )  # fmt: skip
    beam = ks.analyze(one.assemble(), gravity=(0, 0, -10)).beams["arm"]
    q, length, EI = sm.RHO * np.pi * 0.025**2 * 10, 0.4, sm.E * np.pi * 0.025**4 / 4
    assert np.hypot(*beam.section_wrenches[0, 4:]) == pytest.approx(q * length**2 / 2)
    assert beam.deflections[-1, 2] == pytest.approx(-q * length**4 / (8 * EI))
    assert beam.strain_energy == pytest.approx(q**2 * length**5 / (40 * EI))
