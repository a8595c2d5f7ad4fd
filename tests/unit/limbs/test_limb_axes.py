"""Axes of limbs: handedness and sense; centres of their joints."""

import numpy as np
import package_robots
import pytest
from simple_machines import joint, link, loop, robot, springs

from kinetostatics.limbs.basis_choice import evaluate_bases
from kinetostatics.limbs.geometry import _nearest_centres, _orientations


@pytest.mark.parametrize("name", ["2pru_upr", "delta"])
def test_limb_axes_are_right_handed(name):
    machine = package_robots.robot(name)
    frames = machine.assemble().frames
    _, o = machine.mechanism.platform_pose(frames)
    for group in machine.statics.groups:
        axes = np.moveaxis(group.geometry(frames, o).limb_axes, (0, 1), (-2, -1))
        np.testing.assert_allclose(np.linalg.det(axes), 1, rtol=1e-12)
        np.testing.assert_allclose(axes @ np.swapaxes(axes, -1, -2), np.broadcast_to(np.eye(3), axes.shape), atol=1e-12)


@pytest.mark.parametrize(("angle", "parallel"), [(1e-4, True), (1.3e-3, True), (1.5e-3, False), (0.1, False)])
def test_parallel_axes_of_a_limb_share_their_sense(angle, parallel):
    """Level axes point anticlockwise around z. Parallel ones get a common sense, others, here, that along x."""
    axes = np.array([[1.0, 0, 0], [np.cos(angle), 0, np.sin(angle)]]).T[:, :, None]
    moments = np.array([[0.0, 0, -0.3]] * 2).T[:, :, None]
    assert _orientations(axes, moments, np.array([True, True]), 2.0)[:, 0].tolist() == ([-1, -1] if parallel else [1, 1])
    assert _orientations(axes, moments, np.array([True, False]), 2.0)[:, 0].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("axis", "moment", "sign"),
    [
        ((0, 0.97, 0.21), 0.0, 1), ((0.97, 0, -0.21), 0.5, -1), ((0.98, 0, -0.19), 0.21, 1), ((0.98, 0, 0.19), -0.21, -1),
        ((0.98, 0.19, 0), -0.19, 1), ((-0.98, 0.19, 0), 0.19, -1), ((-0.19, -0.98, 0), 0.19, -1), ((-0.21, 0.97, 0), 0.0, -1),
    ],
)  # fmt: skip
def test_axis_sense_is_up_or_anticlockwise_or_along_x(axis, moment, sign):
    """Up; if level, anticlockwise around z; if it meets z, along x, else along y."""
    moments = np.array([0, 0, moment])[:, None, None]
    unit = np.array(axis) / np.linalg.norm(axis)
    assert _orientations(unit[:, None, None], moments, np.array([True]), 1.0) == sign


@pytest.mark.parametrize(
    ("outside", "end"), [("nothing", (0.3, 0, 0)), ("an elastic weld", (0.3, 0.2, 0.4)), ("a slide", (0.4, 0, 0))]
)
def test_centres_of_limb_joints_lie_where_hinges_cross(outside, end):
    """Two hinges that cross at x = 0.3, the outer one with its origin 0.2 beside that, and a further joint behind them or none.

    The origin of a slide on its line does not matter: its centre is its point nearest to where the hinges cross.
    """
    parts = [
        link("base"),
        link("ring"),
        link("platform", 1.0, "0 0 0.1"),
        joint("inner", "continuous", "base", "ring", axis="1 0 0"),
    ]
    if outside == "nothing":
        parts += [joint("outer", "continuous", "ring", "platform", "0.3 0.2 0", "0 1 0")]
    else:
        parts += [link("flange"), joint("outer", "continuous", "ring", "flange", "0.3 0.2 0", "0 1 0")]
    if outside == "an elastic weld":
        weld = joint("weld", "fixed", "flange", "platform", "0 0 0.4")
        parts += [weld, springs("weld", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4")]
    if outside == "a slide":
        parts += [joint("slide", "prismatic", "flange", "platform", "0.1 -0.2 0.4", "0 0 1")]
    machine = robot(*parts)
    [group] = machine.statics.groups
    centres = group.geometry(machine.zero_frames, np.zeros((3, 1))).centres[:, :, 0, 0]
    np.testing.assert_allclose(centres[:, 0], [0.3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(centres[:, -1], end, atol=1e-12)


def test_nearest_centre_of_a_joint_prefers_the_outer_one():
    assert _nearest_centres([False, True, False, True, False, False], True) == {0: 1, 2: 3, 4: 3, 5: 3}
    assert _nearest_centres([True, False, False, True], True) == {1: 0, 2: 3}
    assert _nearest_centres([False, False], True) == _nearest_centres([False, False], False) == {0: None, 1: None}
    assert _nearest_centres([True, False, True], False) == {1: None}  # a limb that branches has no next joint


def test_limb_y_is_along_a_passive_hinge_rather_than_a_universal_joint():
    machine = robot(
        link("base"), link("cross"), link("rod"), link("slider"), link("platform", 1.0),
        joint("foot_x", "continuous", "base", "cross", axis="1 0 0"), joint("foot_y", "continuous", "cross", "rod"),
        joint("slide", "prismatic", "rod", "slider", axis="0 0 1"),
        joint("head", "continuous", "slider", "platform", "0 0 0.5", "0.6 0.8 0"),
    )  # fmt: skip
    [group] = machine.statics.groups
    axes = group.geometry(machine.zero_frames, np.array([[0.0], [0.0], [0.5]])).limb_axes[..., 0, 0]
    np.testing.assert_allclose(np.abs(axes.T @ [0.6, 0.8, 0]), [0, 1, 0], atol=1e-12)


def test_force_through_the_inner_ball_of_a_limb_is_parallel_to_its_outer_hinge():
    """Ball, actuated slide, hinge: forces on the platform meet the ball and are normal to, or along, the hinge's axis."""
    machine = robot(
        link("base"), link("rod"), link("slider"), link("platform", 1.0),
        joint("free", "floating", "base", "platform", "0 0 0.5"),
        joint("head", "continuous", "platform", "slider", axis="0.6 0.8 0"),
        joint("slide", "prismatic", "slider", "rod", axis="0 0 1"), loop("ball", "spherical", "base", "rod", there="0 0 -0.5"),
        '<transmission name="t"><joint name="slide"/></transmission>',
    )  # fmt: skip
    [group] = machine.statics.groups
    assert [candidate.label for candidate in group.basis.constraint] == ["force along limb axis at head", "force ∥ head at ball"]
    geometry = group.geometry(machine.zero_frames, np.array([[0.0], [0.0], [0.5]]))
    J_c, _, _ = evaluate_bases(group, geometry, geometry.twists[:, group.passive])
    force, moment_about_o = np.split(J_c[:, 1, 0, 0], 2)
    np.testing.assert_allclose(np.abs(force), [0.6, 0.8, 0], atol=1e-12)
    np.testing.assert_allclose(moment_about_o + np.cross([0, 0, 0.5], force), 0, atol=1e-12)
