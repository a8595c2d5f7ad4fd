"""The zero pose: characteristic length, and closure of loops that are open at zero."""

import numpy as np
import pytest
from simple_machines import joint, link, loop, mount, parallelogram, robot

import kinetostatics as ks
from kinetostatics.kinematics import zero_pose
from kinetostatics.kinematics.loop_gaps import close


def four_bar(gap=0.0, unit=1.0, slack=False, zero=0.0, bent=0.0, turned=0.0, kind="revolute", axis="0 1 0"):
    """A linkage in the plane y = 0, its crank driven: at zero all in a line, which is too long by ``gap``.

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
def test_a_dead_centre_is_left(unit, slack):
    """All in a line, nothing that the joints do at first order closes the gap: the way out is found by chance."""
    machine = four_bar(0.05, unit, slack)
    assert machine.zero_loop_gaps["c"][0] == pytest.approx(0.05 * unit)
    assert machine.closing_error < 1e-12 and not machine.has_wrong_zero
    assert np.max(np.abs(machine.assemble().frame("platform")[:3, 1])) == pytest.approx(1.0)


@pytest.mark.parametrize("off", [0.0, 1e-6, 1e-5])
def test_drives_stay_where_the_loops_close_up_to_rounding(off):
    """Whether the file is exact or its frames are rounded: the other joints alone close what they can."""
    machine = four_bar(0.05, zero=0.3, bent=off)
    assert machine.joint_coordinates.at(machine.model_q(machine.zero_poses), machine.zero_frames)["a"] == pytest.approx(
        0.0, abs=1e-12
    )
    assert machine.closing_error == pytest.approx(off / machine.length, rel=0.01, abs=1e-13)


@pytest.mark.parametrize(
    ("gap", "turned", "off", "least"),
    [
        (0.05, 2.5, 0.0, 2.5 - np.arccos((0.3**2 + 1.15**2 - 0.9**2) / (2 * 0.3 * 1.15))),
        (0.05, 2.5, 1e-6, 2.5 - np.arccos((0.3**2 + 1.15**2 - 0.9**2) / (2 * 0.3 * 1.15))),  # far out of the others' reach
        (0.0005, 0.1, 0.0, 0.1 - np.arccos((0.3**2 + 1.1995**2 - 0.9**2) / (2 * 0.3 * 1.1995))),  # by a little
    ],
)
def test_drives_move_where_they_must(gap, turned, off, least):
    """Not much further than to the dead centre of coupler and rocker, the last place where the crank gets."""
    machine = four_bar(gap, turned=turned, zero=0.2, bent=off)
    assert machine.closing_error < 1.1 * off / machine.length + 1e-11 and not machine.has_wrong_zero
    moved = float(-machine.joint_coordinates.at(machine.model_q(machine.zero_poses), machine.zero_frames)["a"][0])
    assert least - 1e-4 < moved < least + 0.2, (least, moved)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("part", "wrong"), [(0.9e-4, False), (1.1e-4, True)])
def test_gaps_are_judged_beside_the_robot_whatever_its_size(unit, part, wrong):
    """1.2 units long: a rocker's head that far off the plane is rounding, or a mistake."""
    machine = four_bar(unit=unit, bent=1.2 * part)
    assert machine.size == pytest.approx(1.2 * unit)
    assert machine.zero_is_near != wrong and machine.has_wrong_zero == wrong


@pytest.mark.parametrize(("off", "accepted"), [(0.9e-10, True), (1.1e-10, False)])
def test_loops_may_stay_open_by_a_tenth_of_a_nanometre_unless_more_is_allowed(off, accepted):
    machine = four_bar(0.05, zero=0.3, bent=off)
    closed = machine.assemble(on_failure="nan")
    assert (closed.status == ks.Status.OK) == accepted
    q = machine.assemble(closure_tolerance=1e-9).q
    assert (machine.configuration(q, on_failure="nan").status == ks.Status.OK) == accepted
    moved = machine.assemble(actuators={"a": 0.1}, on_failure="nan")
    assert (moved.status == ks.Status.OK) == accepted


def test_what_cannot_be_reached_is_told_apart_from_what_lies_beyond_a_singular_pose():
    """Two cranks of length 1: their table gets to x = ±1, and turned by 3 rad only past the pose in which all lie in a line."""
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
def test_an_axis_that_a_loop_leaves_out_is_said_first_and_nothing_is_guessed(kind, moves, gap):
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


def test_poses_closed_together_end_where_each_ends_alone():
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
def test_axes_that_are_parallel_up_to_rounding_let_a_loop_move(tilt, mobility):
    """A parallelogram that is closed at zero whatever the axis of one hinge: 1.5708 is 3.7e-6 beside π/2, and 3e-3 is meant."""
    parts = [link("base"), link("crank"), link("platform", 1.0), link("rocker"), joint("a", "continuous", "base", "crank")]
    parts += [joint("b", "continuous", "crank", "platform", "0 0 1", f"{tilt!r} 1 0")]
    parts += [joint("d", "continuous", "base", "rocker", "0.7 0 0")]
    parts += [loop("c", "revolute", "rocker", "platform", "0 0 1", "0.7 0 0", "0 1 0")]
    assert robot(*parts).mobility.platform == mobility


# ---- characteristic length: mean distance of the limbs' outer joints from o, else a quarter of the robot


def hinged(*axes):
    """A plate on hinges through one point, 0.3 and 0.7 beside o."""
    names = ["base", *(f"ring_{k}" for k in range(1, len(axes))), "plate"]
    hinges = [joint(f"hinge_{k}", "continuous", *names[k : k + 2], axis=axis) for k, axis in enumerate(axes)]
    return robot(*map(link, names), link("platform"), *hinges, joint("weld", "fixed", "plate", "platform", "0.3 0.7 0"))


@pytest.mark.parametrize(
    ("axes", "length"),
    [
        (("0 1 0",), 0.3),  # from the line of a hinge whose place along it is the file's choice alone
        (("1 0 0",), 0.7),
        (("1 0 0", "0 1 0"), np.hypot(0.3, 0.7)),  # from the point in which two of them meet
        (("0 0 1",), np.hypot(0.3, 0.7)),
    ],
)
def test_the_distance_of_the_platform_s_joint(axes, length):
    assert hinged(*axes).length == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize(("far", "length"), [(0.9e-3, 0.25), (1.1e-3, 1.1e-3)])
def test_joints_that_all_but_meet_in_o_tell_no_length(far, length):
    """Then it is a quarter of the robot, a 1 m high column here."""
    machine = robot(
        link("base"), link("column"), link("plate"), link("platform"), joint("foot", "fixed", "base", "column"),
        joint("head", "continuous", "column", "plate", "0 0 1"), joint("weld", "fixed", "plate", "platform", f"{far} 0 0"),
        loop("seam", "fixed", "plate", "platform", f"{far} 0 0"),
    )  # fmt: skip
    assert machine.length == pytest.approx(length, rel=1e-4)


def test_sizes_of_the_smallest_robots():
    """Limbs count alike; one joint is as large as its box; a robot in one point has the length 1 m."""
    assert parallelogram().length == pytest.approx((0.0 + 0.5) / 2, rel=1e-12)
    machine = mount(kind="continuous")
    assert machine.size == pytest.approx(0.3) and machine.length == pytest.approx(0.075)
    machine = robot(link("base"), link("platform", 1.0), joint("hinge", "continuous", "base", "platform"))
    assert machine.size == 0 and machine.length == 1.0
