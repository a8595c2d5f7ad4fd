"""What a small mistake in the code would make a wrong number of, and no other test noticed: one thing at a time."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from small_maps import map_of
from test_elastic_joints import arm, mount, springs
from test_hybrid_limbs import AREA as BAR_AREA
from test_hybrid_limbs import RHO, E, bar, joint, link, robot, truss
from test_misfits import two_columns

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.kinematics.pose_spread import ordinary_poses
from kinetostatics.math.screws import describe_twist
from kinetostatics.workspace.assembly_modes.following import Poses

STILL = (0, 0, 0)
AREA = np.pi * 0.02**2 / 4
BAR_STIFFNESS = E * BAR_AREA


def test_the_axial_force_at_both_ends_of_a_hanging_rod():
    """It carries its own weight at the end where it hangs, and the load alone at the other."""
    machine = robot(
        link("base"), link("rod"), link("platform", 1.0), joint("clamp", "fixed", "base", "rod"),
        joint("head", "fixed", "rod", "platform", "0 0 -1"), bar("rod", "clamp", "head", RHO, '<circle diameter="0.02"/>'),
    )  # fmt: skip
    found = ks.analyze(machine.assemble(), gravity=(0, 0, -10))
    np.testing.assert_allclose(found.beams["rod"].points[[0, 10, -1]], [[0, 0, 0], [0, 0, -0.5], [0, 0, -1]], atol=1e-12)
    lines = str(found).splitlines()
    at = next(k for k, line in enumerate(lines) if "N outer [N]" in line)
    header, row = (
        lines[k].replace(" [", "[").replace("N inner", "N-inner").replace("N outer", "N-outer").split() for k in (at, at + 1)
    )
    cells = dict(zip((name.partition("[")[0] for name in header), row, strict=False))
    assert float(cells["N-inner"]) == pytest.approx(10 + 10 * RHO * AREA, rel=1e-3)
    assert float(cells["N-outer"]) == pytest.approx(10, rel=1e-3)


def test_a_pitch_is_the_way_per_turn():
    """A screw about z through (2, 0, 0) that rises by 0.3 m/rad, at half a rad/s."""
    twist = np.array([0, -2 * 0.5, 0.3 * 0.5, 0, 0, 0.5])
    assert describe_twist(twist, 1.0) == "a rotation about the axis (0, 0, 1) through o + (2, 0, 0) m with a pitch of 0.3 m/rad"
    assert describe_twist(2 * twist, 1.0) == describe_twist(twist, 1.0)
    level = "a rotation about the axis (0, 0, 1) through o + (0, 0, 0) m"
    for pitch, said in ((1.9e-6, False), (2.1e-6, True), (-2.1e-6, True)):
        assert describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0).startswith(level)
        assert ("pitch" in describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0)) == said
    assert describe_twist(np.array([0, 3.0, 4.0, 0, 0, 0]), 1.0) == "a translation along (0, 0.6, 0.8)"
    for turn, words in ((2e-6, "translation"), (3e-6, "rotation")):  # 5 · 1e-6 / 2 m
        assert describe_twist(np.array([3.0, 4.0, 0, 0, 0, turn]), 2.0).startswith(f"a {words}")


def test_tolerances_tell_the_largest_moment_and_all_of_the_motion():
    """A column too long between two clamps bends both; the moment of the table is that of the joint which has the largest."""
    pose = two_columns().assemble()
    for row in ks.tolerances(pose, length=2e-4, angle=1e-3, temperature=30):
        if row.kind != "joint":
            continue
        twist = np.zeros(6)
        twist[("x", "y", "z", "rx", "ry", "rz").index(row.error)] = row.amount
        one = ks.analyze(pose, gravity=STILL, misfits={row.name: {"twist": twist, "frame": "joint"}})
        moments = {name: np.linalg.norm(wrench[3:]) for name, wrench in one.joint_wrenches.items()}
        forces = {name: np.linalg.norm(wrench[:3]) for name, wrench in one.joint_wrenches.items()}
        assert row.moment == pytest.approx(max(moments.values()), rel=1e-6, abs=1e-4)
        assert row.force == pytest.approx(forces[row.at] if row.at else 0.0, rel=1e-6, abs=1e-4)
        assert row.displacement == pytest.approx(np.linalg.norm(one.twist[:3]), rel=1e-9, abs=1e-15)
        assert row.rotation == pytest.approx(np.linalg.norm(one.twist[3:]), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("name", ["3rps", "2pru_upr", "delta", "planar_3rrr"])
def test_limb_axes_are_right_handed(name):
    machine = ks.load_robot(robot_path(name))
    frames = machine.assemble().frames
    _, o = machine.mechanism.platform_pose(frames)
    for group in machine.statics.groups:
        axes = np.moveaxis(group.geometry(frames, o).limb_axes, (0, 1), (-2, -1))
        np.testing.assert_allclose(np.linalg.det(axes), 1, rtol=1e-12)
        np.testing.assert_allclose(axes @ np.swapaxes(axes, -1, -2), np.broadcast_to(np.eye(3), axes.shape), atol=1e-12)


@pytest.mark.parametrize(("kind", "twist"), [("revolute", slice(3, 6)), ("prismatic", slice(0, 3))])
def test_a_drive_along_an_oblique_axis_gives_way_along_it(kind, twist):
    axis = np.array([2.0, -1, 2]) / 3
    drive = '<transmission name="t"><joint name="mount"/></transmission>'
    machine = mount(springs("mount", drive="500"), drive, kind=kind, axis="2 -1 2")
    load = np.array([7.0, 2, 3, 5, -4, 6])
    found = ks.analyze(machine.assemble(), load, STILL)
    expected = np.zeros(6)
    expected[twist] = axis * (axis @ load[twist]) / 500
    np.testing.assert_allclose(found.twist, expected, rtol=1e-9, atol=1e-15)


def test_bearings_are_along_the_joint_s_frame_whatever_its_axis():
    drive = '<transmission name="t"><joint name="mount"/></transmission>'
    machine = mount(springs("mount", linear="1e5 2e5 4e5"), drive, kind="revolute", axis="1 1 0")
    found = ks.analyze(machine.assemble(), (10, 20, 40, 0, 0, 0), STILL)
    np.testing.assert_allclose(found.twist, [1e-4, 1e-4, 1e-4, 0, 0, 0], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("axis", "sprung"), [("0 1 0", True), ("0 1 5e-10", True), ("0 1 1e-7", False), ("0 1 1", False)])
def test_a_flexure_needs_an_axis_of_its_frame(axis, sprung):
    """A hinge is a spring if its axis is one of those that the stiffnesses are along."""
    text = springs("mount", angular="inf 700 inf")
    if not sprung:
        with pytest.raises(ks.KinetostaticsError):
            ks.analyze(mount(text, kind="revolute", axis=axis).assemble(), (0, 0, 0, 0, 7, 0), STILL)
        return
    found = ks.analyze(mount(text, kind="revolute", axis=axis).assemble(), (0, 0, 0, 0, 7, 0), STILL)
    assert found.twist[4] == pytest.approx(0.01, rel=1e-6)


def test_drives_of_poses_that_are_not_reached_have_no_position():
    machine = ks.load_robot(robot_path("orthoglide"))
    pose = machine.assemble(platform={"x": [0.0, 9.0], "y": 0.0, "z": 0.0})
    assert pose.status.tolist() == [ks.Status.OK, ks.Status.UNREACHABLE]
    for value in pose.actuators.values():
        assert np.isfinite(value).tolist() == [True, False]
    for value in pose.platform.values():
        assert np.isfinite(value).tolist() == [True, False]
    assert np.isnan(pose.q[1]).all() and np.isnan(pose.residual[1])


def test_a_sag_with_an_unknown_component_is_unknown():
    twist = np.array([[3.0, 4, 0, 0, 0, 0], [np.nan, 4, 0, 0, 3, 4], [0, 0, 0, np.nan, 0, 1]])
    ds = map_of({"x": ([0.0, 1, 2], "m")}, twist=twist, forces={"a": [1.0, -3, 2], "b": [2.0, np.nan, -5]})
    np.testing.assert_equal(ks.indices.linear_sag(ds).values, [5, np.nan, 0])
    np.testing.assert_equal(ks.indices.angular_sag(ds).values, [0, 5, np.nan])
    np.testing.assert_equal(ks.indices.largest_actuator_force(ds).values, [2, np.nan, 5])
    assert isinstance(ks.indices.linear_sag(ds), xr.DataArray)


@pytest.mark.parametrize(("tilt", "known"), [(0.0, False), (0.5e-9, False), (2e-9, True), (0.2, True)])
def test_an_untilted_start_has_no_azimuth(tilt, known):
    """Ways from there to tilted poses keep to the azimuth of their ends: that of the start is rounding."""
    start = SimpleNamespace(platform_coordinates=lambda orientation: {"azimuth": 1.5, "tilt": tilt, "torsion": 0.0})
    machine = SimpleNamespace(zero_poses=None, model_q=lambda poses: np.zeros((3, 1)), configuration=lambda *_, **__: start)
    plan = SimpleNamespace(
        kind="platform",
        orientation="tilt_torsion",
        robot=lambda combination: machine,
        coordinates=lambda region: {"azimuth": np.array([0.5, 1.0]), "tilt": tilt + np.array([0.1, 0.3])},
    )
    labels = SimpleNamespace(q=[("q", "rad")] * 3, loose=[False] * 3)
    found, far = Poses(plan, labels, None, None, np.zeros((2, 3)), np.ones(2, dtype=bool)).from_zero()
    assert np.isnan(found["azimuth"]) == (not known) and found["tilt"] == tilt
    np.testing.assert_allclose(far, np.array([0.25, 2.25]) + known * np.array([4.0, 1.0]), rtol=1e-6)


@pytest.mark.parametrize("bar_number", [0, 1, 2])
def test_a_bar_of_a_truss_that_is_too_long_presses_the_others(bar_number):
    """Self-stress of one limb by a misfit: K u = Σ EA/L e δ, N = EA/L (e u − δ)."""
    machine = truss()
    feet = np.array([[-1.0, 0], [0, 0], [1, 0]])
    along = np.array([0.0, 1.0]) - feet
    lengths = np.linalg.norm(along, axis=1)
    e, k = along / lengths[:, None], BAR_STIFFNESS / lengths
    delta = np.where(np.arange(3) == bar_number, 1e-4, 0)
    u = np.linalg.solve((e.T * k) @ e, e.T @ (k * delta))
    forces = k * (e @ u - delta)
    found = ks.analyze(machine.assemble(), gravity=STILL, misfits={f"bar_{bar_number}": {"length": 1e-4}})
    np.testing.assert_allclose(found.twist[[0, 2]], u, rtol=1e-9, atol=1e-16)
    for number, force in enumerate(forces):
        np.testing.assert_allclose(found.beams[f"bar_{number}"].section_wrenches[:, 0], force, rtol=1e-7)
        wrench = found.joint_wrenches[f"foot_{number}"]
        np.testing.assert_allclose(wrench[[0, 2]], -force * e[number], rtol=1e-7, atol=1e-9 * abs(force))


def test_the_paper_s_drive_force_is_that_at_the_base_end():
    found = ks.analyze(ks.load_robot(robot_path("3rps")).assemble())
    for number in (1, 2, 3):
        beam = found.beams[found.limbs[f"limb_{number}"].beams[0]]
        force = found.paper_forces[f"limb_{number}"][f"f_{number}a"]
        assert force == pytest.approx(beam.section_wrenches[0, 0], rel=1e-12)
        assert abs(force) > abs(beam.section_wrenches[1, 0]) + 1e-3  # the rod's own weight


def test_ordinary_poses_are_parts_of_the_way_to_the_limits():
    """One drive at a time goes a fifth and three fifths of its way, not farther than 1.2 characteristic lengths."""
    machine = ks.load_robot(robot_path("3rps"))
    pose = machine.configuration(ordinary_poses(machine).T)
    connections = machine.mechanism.connections
    drives = list(machine.description.driven)
    moved = np.stack([pose.actuators[name] for name in drives], axis=1)
    wanted = [np.zeros(3)]
    far = 1.2 * machine.length
    for part in (0.2, 0.6):
        for side in ("lower", "upper"):
            wanted += list(np.diag([part * np.clip(getattr(connections[name], side), -far, far) for name in drives]))
    np.testing.assert_allclose(moved, wanted, atol=1e-9)


def test_pinocchio_s_model_weighs_all_that_moves_with_a_body():
    """The outer of the arm's two bodies is a link of 1 kg at 0.15 m and the platform of 0.5 kg at 0.3 m."""
    model = arm(elastic=False).assemble().model
    inner, outer = list(model.inertias)[-2:]
    assert (inner.mass, outer.mass) == pytest.approx((2.0, 1.5))
    assert outer.lever == pytest.approx([(1.0 * 0.15 + 0.5 * 0.3) / 1.5, 0, 0]) and inner.lever == pytest.approx([0.2, 0, 0])
