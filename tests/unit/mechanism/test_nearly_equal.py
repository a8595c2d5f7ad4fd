"""Axes and points count as equal up to rounding, not up to what a drawing shows."""

import numpy as np
import package_robots
import pytest
from loop_robots import floating, frame
from simple_machines import BEAM, CIRCLE, RHO, joint, link, robot

import kinetostatics as ks
from kinetostatics.description import JointStiffness
from kinetostatics.mechanism.beam_geometry import SpanFinder
from kinetostatics.mechanism.joints import is_sprung


def chain(*parts):
    """A hinge, a beam of 1 m and what follows it up to the platform."""
    beam = f'<beam link="rod" from="foot" to="head" density="{RHO}" {{}} {BEAM}>{CIRCLE}</beam>'
    return robot(link("base"), link("rod"), joint("foot", "continuous", "base", "rod"), *parts, beam.format(""))


@pytest.mark.parametrize(("angle", "sprung"), [(0.0, True), (3e-5, True), (1e-3, False)])
def test_spring_along_an_axis_of_the_frame_acts_on_axes_along_it(angle, sprung):
    """A cosine of 1 − 1e-9 is an angle of 45 µrad, as of rounded decimal numbers."""
    axis = np.array([np.cos(angle), 0.0, np.sin(angle)])
    stiffness = JointStiffness("j", linear=(5.0, 0.0, 0.0), angular=(0.0, 7.0, 0.0))
    assert is_sprung(stiffness, False, axis) == sprung and is_sprung(stiffness, False, -axis) == sprung
    assert is_sprung(stiffness, True, np.roll(axis, 1)) == sprung
    assert not is_sprung(stiffness, True, axis) and not is_sprung(stiffness, False, None) and not is_sprung(None, True, axis)
    assert is_sprung(JointStiffness("j", angular=(1.0, 2.0, 3.0)), True, None)  # about all axes


@pytest.mark.parametrize(("tilt", "refused"), [(0.0, True), (3e-7, True), (3e-6, False), (1e-3, False)])
def test_y_axis_may_not_be_parallel_to_the_beam(tilt, refused):
    """Within 1e-6 rad its direction would be rounding."""
    given = f'y_axis="{tilt} 0 1"'
    parts = link("base"), link("rod"), link("platform", 1.0), joint("foot", "continuous", "base", "rod")
    beam = f'<beam link="rod" from="foot" to="head" density="{RHO}" {given} {BEAM}>{CIRCLE}</beam>'
    head = joint("head", "fixed", "rod", "platform", "0 0 1")
    if refused:
        with pytest.raises(ks.RobotFileError, match="y_axis is parallel"):
            robot(*parts, head, beam)
    else:
        np.testing.assert_allclose(robot(*parts, head, beam).mechanism.model.nq, 2)  # it is read


@pytest.mark.parametrize(
    ("which", "offset", "run"),
    [(1, 0.0, True), (1, 1e-10, True), (1, 1e-7, False), (2, 1e-13, True), (2, 1e-10, False), (2, 1e-3, False)],
)
def test_three_hinges_are_a_spherical_joint_if_their_axes_meet(offset, run, which):
    """The second hinge may lie anywhere on the axis of the first one, the third one where both axes meet."""
    at = ["0 0 1", "0.2 0 0", "0 0 0"]
    if which == 1:
        at[1], at[2] = f"0.2 0 {offset}", f"0 0 {-offset}"
    else:
        at[2] = f"0 {offset} 0"
    wrist = [link("fork"), link("cross"), link("platform", 1.0)]
    axes = ("1 0 0", "0 1 0", "0 0 1")
    ends = ("rod", "fork", "cross", "platform")
    hinges = [joint(name, "continuous", *ends[k : k + 2], at[k], axes[k]) for k, name in enumerate(("head", "second", "third"))]
    runs = chain(*wrist, *hinges).mechanism.spherical_runs
    assert [item.joints for item in runs] == ([("head", "second", "third")] if run else [])


@pytest.mark.parametrize(("tilt", "run"), [(0.0, True), (1e-10, True), (1e-7, False)])
@pytest.mark.parametrize("which", [1, 2])
def test_hinges_of_a_spherical_joint_are_perpendicular(tilt, run, which):
    axes = ["1 0 0", "0 1 0", "0 0 1"]
    axes[which] = f"{tilt} 1 0" if which == 1 else f"0 {tilt} 1"
    parts = [link("fork"), link("cross"), link("platform", 1.0)]
    ends = ("rod", "fork", "cross", "platform")
    for k, name in enumerate(("head", "second", "third")):
        parts.append(joint(name, "continuous", *ends[k : k + 2], "0 0 1" if k == 0 else "0 0 0", axes[k]))
    assert len(chain(*parts).mechanism.spherical_runs) == run


def test_rates_of_a_body_at_rest_are_zero():
    """Its quaternion does not change; (0, 0, 0) is no axis to divide by."""
    tree = floating("revolute", frame(), frame(), axis=(0, 0, 1)).solver.tree
    q = tree.integrate(tree.neutral[:, None], np.full((tree.nv, 1), 0.1))
    np.testing.assert_array_equal(tree.rates(q, np.zeros((tree.nv, 1))), 0.0)


def test_weights_at_a_pose_that_is_not_reached_are_nan():
    """Pinocchio, which computes those of one pose, takes no NaN."""
    machine = package_robots.robot("five_bar")
    pose = machine.assemble(platform={"x": 9.0, "y": 0.0}, on_failure="nan")
    result = ks.analyze(pose)
    assert result.status == ks.Status.UNREACHABLE and np.isnan(result.twist).all() and np.isnan(result.base_wrench).all()


@pytest.mark.parametrize(
    ("kinds", "axis", "offset", "one"),
    [
        (("continuous", "prismatic"), "0 0 1", "0 0 0.3", True), (("prismatic", "continuous"), "0 0 1", "0 0 0.3", True),
        (("continuous", "prismatic"), "1e-10 0 1", "0 0 0.3", True), (("continuous", "prismatic"), "1e-7 0 1", "0 0 0.3", False),
        (("continuous", "prismatic"), "0 0 1", "1e-10 0 0.3", True), (("continuous", "prismatic"), "0 0 1", "1e-7 0 0.3", False),
        (("prismatic", "prismatic"), "0 0 1", "0 0 0.3", False), (("continuous", "continuous"), "0 0 1", "0 0 0.3", False),
        (("continuous", "continuous"), "1 0 0", "0 0 0.3", True), (("continuous", "continuous"), "1 0 0", "0 1e-7 0.3", False),
        (("continuous", "continuous"), "1 0 0", "0 1e-10 0.3", True),
    ],
)  # fmt: skip
def test_two_joints_of_a_massless_link_are_one_if_their_axes_coincide_or_meet(kinds, axis, offset, one):
    """A hinge and a slide along one line are a cylindrical joint, two hinges with a common point a universal joint."""
    parts = (
        link("base"),
        link("middle"),
        link("rod"),
        link("platform", 1.0),
        joint("first", kinds[0], "base", "middle", axis="0 0 1"),
    )
    beam = f'<beam link="rod" from="second" to="head" density="{RHO}" {BEAM}>{CIRCLE}</beam>'
    second, head = joint("second", kinds[1], "middle", "rod", offset, axis), joint("head", "fixed", "rod", "platform", "0 0 1")
    mechanism = robot(*parts, second, head, beam).mechanism
    found = SpanFinder(mechanism)._are_one_joint("middle", mechanism.connections["first"], mechanism.connections["second"])
    assert found == one
