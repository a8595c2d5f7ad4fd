"""The zero pose: characteristic length, and closure of loops that are open at zero."""

from dataclasses import replace

import numpy as np
import pytest
from simple_machines import joint, link, loop, mount, parallelogram, robot

import kinetostatics as ks
from kinetostatics.kinematics import zero_pose
from kinetostatics.kinematics.loop_gaps import close


def four_bar(gap=0.0, unit=1.0, slack=False, zero=0.0, bent=0.0, turned=0.0, kind="revolute", axis="0 1 0"):
    """A linkage in the plane y = 0, its crank actuated: at zero all in a line, which is too long by ``gap``.

    Args:
        gap: [units].
        unit: the length of the unit [m].
        slack: whether the crank is a telescope across the line.
        zero: what the coupler's and rocker's zeros are turned by [rad].
        bent: by how much the rocker's head is off the plane [units].
        turned: what the crank's zero is turned by [rad].
        kind, axis: of the loop; None leaves the axis out.
    """

    def at(x, y=0.0):
        return f"{x * unit!r} {y * unit!r} 0"

    parts = [link("base"), link("crank"), link("platform", 1.0), link("rocker")]
    parts += [joint("a", "continuous", "base", "crank", rpy=f"0 {turned!r} 0")]
    inner = "crank"
    if slack:
        parts += [link("sleeve"), joint("s", "prismatic", "crank", "sleeve", axis="0 0 1")]
        inner = "sleeve"
    parts += [
        joint("b", "continuous", inner, "platform", at(0.3), rpy=f"0 {zero!r} 0"),
        joint("d", "continuous", "base", "rocker", at(1.2 - gap), rpy=f"0 {-zero!r} 0"),
        loop("c", kind, "rocker", "platform", at(-0.4, bent), at(0.5), axis),
        '<transmission name="t"><joint name="a"/></transmission>',
    ]
    return robot(*parts)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
@pytest.mark.parametrize("slack", [False, True])
def test_loops_close_from_a_dead_centre(unit, slack):
    """With all links in a line, no motion of first order closes the gap; random starts find a closed pose."""
    machine = four_bar(0.05, unit, slack)
    assert machine.zero_loop_gaps["c"][0] == pytest.approx(0.05 * unit)
    assert machine.closing_error < 1e-12 and not machine.has_wrong_zero
    assert np.max(np.abs(machine.assemble().frame("platform")[:3, 1])) == pytest.approx(1.0)


@pytest.mark.parametrize("off", [0.0, 1e-6, 1e-5])
def test_actuators_stay_if_passive_joints_close_the_loops(off):
    """For exact files, and for files whose rounded frames leave a gap."""
    machine = four_bar(0.05, zero=0.3, bent=off)
    assert machine.joint_coordinates.at(machine.model_q(machine.zero_poses), machine.zero_frames)["a"] == pytest.approx(
        0.0, abs=1e-12
    )
    assert machine.closing_error == pytest.approx(off / machine.length, rel=0.01, abs=1e-13)


@pytest.mark.parametrize(
    ("gap", "turned", "off", "least"),
    [
        (0.05, 2.5, 0.0, 2.5 - np.arccos((0.3**2 + 1.15**2 - 0.9**2) / (2 * 0.3 * 1.15))),
        (0.05, 2.5, 1e-6, 2.5 - np.arccos((0.3**2 + 1.15**2 - 0.9**2) / (2 * 0.3 * 1.15))),  # far from closed by the others
        (0.0005, 0.1, 0.0, 0.1 - np.arccos((0.3**2 + 1.1995**2 - 0.9**2) / (2 * 0.3 * 1.1995))),  # almost closed by them
    ],
)
def test_actuators_move_if_passive_joints_cannot_close_loops(gap, turned, off, least):
    """Not much further than to the dead centre of coupler and rocker, the limit of the crank's motion."""
    machine = four_bar(gap, turned=turned, zero=0.2, bent=off)
    assert machine.closing_error < 1.1 * off / machine.length + 1e-11 and not machine.has_wrong_zero
    moved = float(-machine.joint_coordinates.at(machine.model_q(machine.zero_poses), machine.zero_frames)["a"][0])
    assert least - 1e-4 < moved < least + 0.2, (least, moved)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("part", "wrong"), [(0.9e-4, False), (1.1e-4, True)])
def test_tolerated_gap_is_relative_to_robot_size(unit, part, wrong):
    """A gap at the rocker's head of less than 1e-4 of the robot, 1.2 units, is rounding, and a larger one a mistake."""
    machine = four_bar(unit=unit, bent=1.2 * part)
    assert machine.size == pytest.approx(1.2 * unit)
    assert machine.zero_is_near != wrong and machine.has_wrong_zero == wrong


@pytest.mark.parametrize(("off", "accepted"), [(0.9e-10, True), (1.1e-10, False)])
def test_default_closure_tolerance_is_a_tenth_of_a_nanometre(off, accepted):
    machine = four_bar(0.05, zero=0.3, bent=off)
    closed = machine.assemble(on_failure="nan")
    assert (closed.status == ks.Status.OK) == accepted
    q = machine.assemble(closure_tolerance=1e-9).q
    assert (machine.configuration(q, on_failure="nan").status == ks.Status.OK) == accepted
    moved = machine.assemble(actuators={"a": 0.1}, on_failure="nan")
    assert (moved.status == ks.Status.OK) == accepted


def test_error_distinguishes_unreachable_targets_from_singular_lines():
    """Two cranks of length 1: the table reaches x = ±1; a crank angle of 3 rad lies beyond the pose with all links in a line."""
    with pytest.raises(ks.AssemblyError, match=r"up to 52.1 % .* the target itself can be assembled, but the line to it passes"):
        parallelogram().assemble(actuators={"foot_0": 3.0})
    with pytest.raises(ks.AssemblyError, match=r"the nearest pose found has x = (0.99\d*|1), and there no loop stays open"):
        parallelogram().assemble(platform={"x": 1.2})


@pytest.mark.parametrize(
    ("kind", "moves", "gap"),
    [
        ("revolute", "turns about x", 0.05),
        ("prismatic", "slides along x", 0.0),
    ],
)
def test_missing_loop_axis_is_reported_instead_of_frame_corrections(kind, moves, gap):
    missing = four_bar(gap, bent=0.1, kind=kind, axis=None)
    (warning,) = [text for text in missing.description.file_warnings if "<loop> 'c'" in text]
    assert "has no <axis>" in warning and f"it {moves} of its predecessor's <origin>" in warning
    with pytest.raises(ks.AssemblyError) as caught:
        missing.assemble()
    message = str(caught.value)
    assert "The file leaves out the <axis> of 'c', which then is x: write it first" in message
    assert "moving the origin" not in message and "on link" not in message
    written = four_bar(gap, bent=0.1, kind=kind, axis="1 0 0")
    assert not any("<axis>" in text for text in written.description.file_warnings)
    with pytest.raises(ks.AssemblyError, match=r"moving the origin|No correction of a single frame"):
        written.assemble()


def test_closing_a_batch_equals_closing_single_poses():
    machine = four_bar(0.05, zero=0.3)
    random, solver, start = np.random.default_rng(2), machine.solver, machine.zero_poses
    poses = zero_pose.SolverState(start.x + random.uniform(-0.7, 0.7, (start.x.shape[0], 6)), np.repeat(start.c, 6, axis=1))
    nothing = zero_pose.PrescribedCoordinates(), np.zeros((0, 1))
    together, left = close(solver, poses, *nothing)
    assert np.sum(left < 1e-12) > 3
    for k in range(6):
        alone, residual = close(solver, poses.take(np.array([k])), *nothing)
        np.testing.assert_allclose(together.x[:, k], alone.x[:, 0], rtol=0, atol=1e-9)
        assert residual[0] == pytest.approx(left[k], abs=1e-12)


@pytest.mark.parametrize(("tilt", "mobility"), [(0.0, 1), (3.7e-6, 1), (3e-3, 0)])
def test_axes_parallel_up_to_rounding_leave_mobility_one(tilt, mobility):
    """A parallelogram with one tilted hinge: by 3.7e-6, the rounding of π/2 to 1.5708, or by 3e-3, which is intended."""
    parts = [link("base"), link("crank"), link("platform", 1.0), link("rocker"), joint("a", "continuous", "base", "crank")]
    parts += [joint("b", "continuous", "crank", "platform", "0 0 1", f"{tilt!r} 1 0")]
    parts += [joint("d", "continuous", "base", "rocker", "0.7 0 0")]
    parts += [loop("c", "revolute", "rocker", "platform", "0 0 1", "0.7 0 0", "0 1 0")]
    assert robot(*parts).mobility.platform == mobility


# ---- characteristic length: mean distance of the limbs' outer joints from o, else a quarter of the robot's size


def hinged(*axes):
    """A plate on hinges through one point, 0.3 and 0.7 beside o."""
    names = ["base", *(f"ring_{k}" for k in range(1, len(axes))), "plate"]
    hinges = [joint(f"hinge_{k}", "continuous", *names[k : k + 2], axis=axis) for k, axis in enumerate(axes)]
    return robot(*map(link, names), link("platform"), *hinges, joint("weld", "fixed", "plate", "platform", "0.3 0.7 0"))


@pytest.mark.parametrize(
    ("axes", "length"),
    [
        (("0 1 0",), 0.3),  # from the axis of a hinge, as its point on the axis is arbitrary
        (("1 0 0",), 0.7),
        (("1 0 0", "0 1 0"), np.hypot(0.3, 0.7)),  # from the point in which two of them meet
        (("0 0 1",), np.hypot(0.3, 0.7)),
    ],
)
def test_length_is_the_distance_of_the_outer_joint(axes, length):
    assert hinged(*axes).length == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize(("far", "length"), [(0.9e-3, 0.25), (1.1e-3, 1.1e-3)])
def test_length_if_the_outer_joint_is_almost_at_o(far, length):
    """Below 1e-3 of the robot's size, here 1 m, it is a quarter of this size."""
    machine = robot(
        link("base"), link("column"), link("plate"), link("platform"), joint("foot", "fixed", "base", "column"),
        joint("head", "continuous", "column", "plate", "0 0 1"), joint("weld", "fixed", "plate", "platform", f"{far} 0 0"),
        loop("seam", "fixed", "plate", "platform", f"{far} 0 0"),
    )  # fmt: skip
    assert machine.length == pytest.approx(length, rel=1e-4)


def test_size_and_length_of_the_smallest_robots():
    """The length is a mean over limbs, a quarter of the size, or for a robot in one point 1 m."""
    assert parallelogram().length == pytest.approx((0.0 + 0.5) / 2, rel=1e-12)
    machine = mount(kind="continuous")
    assert machine.size == pytest.approx(0.3) and machine.length == pytest.approx(0.075)
    machine = robot(link("base"), link("platform", 1.0), joint("hinge", "continuous", "base", "platform"))
    assert machine.size == 0 and machine.length == 1.0


@pytest.mark.parametrize(("part", "closed"), [(5e-8, True), (5e-7, False), (1e-5, False)])
def test_gaps_that_no_motion_closes_are_rounding_only_up_to_a_tenth_of_a_millionth(part, closed):
    """A five-bar whose wrist is out of plane, by this part of the characteristic length; Newton's method cannot do anything."""
    description = ks.load_robot("five_bar").description
    length, (name, held) = ks.load_robot("five_bar").length, next(iter(description.loops.items()))
    x, y, z = held.predecessor_origin.xyz
    shifted = replace(held.predecessor_origin, xyz=(x, y, z + part * length))
    machine = ks.Robot(description.changed(name, predecessor_origin=shifted))
    solver, prescribed = machine._solver(), machine.actuator_coordinates
    start, residual = zero_pose.closed_zero(solver, prescribed)
    assert residual == pytest.approx(part, rel=1e-3)
    assert solver.newton(prescribed, start, solver.values(prescribed, start))[1].tolist() == [closed]
