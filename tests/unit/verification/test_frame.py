"""The frame of the finite elements: which directions of a joint are free, elastic or held."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.description import JointStiffness
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.verification.frame import joint_axes, joint_springs, releases
from kinetostatics.verification.frame_model import _sizes

FRAME = np.eye(4)
FRAME[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
INF = np.inf


def placed(kind, locked=False):
    """A joint whose axis is the x axis of its frame, world y."""
    x = FRAME[:3, 0]
    return SimpleNamespace(type=JOINT_TYPES[kind], frames=(FRAME, FRAME), axis=x, axis2=FRAME[:3, 1], locked=locked)


@pytest.mark.parametrize("nothing", [0.0, INF])
def test_stiffness_that_is_no_number_or_zero_is_no_spring(nothing):
    """A bearing's spring is infinitely stiff there: whether the direction is free or held is the joint's matter."""
    (bearing,) = joint_springs(
        placed("revolute"), JointStiffness("hinge", linear=(2e6, nothing, 3e6), angular=(nothing, 4.0, 5.0))
    )
    np.testing.assert_array_equal(bearing.stiffness, [2e6, INF, 3e6, INF, 4.0, 5.0])
    np.testing.assert_array_equal(bearing.axes, FRAME[:3, :3])
    assert joint_springs(placed("revolute"), JointStiffness("hinge", linear=(nothing,) * 3)) == ()


@pytest.mark.parametrize(("kind", "place"), [("revolute", 3), ("prismatic", 0)])
def test_actuator_is_a_spring_along_the_coordinate(kind, place):
    joint = placed(kind)
    (drive,) = joint_springs(joint, JointStiffness("motor", drive=7e4))
    np.testing.assert_array_equal(drive.stiffness, [7e4 if k == place else INF for k in range(6)])
    np.testing.assert_allclose(drive.axes, joint_axes(joint), atol=1e-15)
    np.testing.assert_allclose(drive.axes[:, 0], joint.axis, atol=1e-15)
    for rigid in (INF, None):
        assert joint_springs(joint, JointStiffness("motor", drive=rigid)) == ()
    assert joint_springs(joint, None) == ()


@pytest.mark.parametrize("nothing", [0.0, INF])
@pytest.mark.parametrize(("kind", "free"), [("revolute", 3), ("prismatic", 0)])
def test_free_direction_stays_free_without_a_spring_along_it(kind, free, nothing):
    joint = placed(kind)
    along, across = JointStiffness("j", (9.0, nothing, nothing), (9.0, nothing, nothing)), (nothing, 9.0, 9.0)
    wanted = np.arange(6) == free
    for elastic in (None, JointStiffness("j", across, across), JointStiffness("j", (nothing,) * 3, (nothing,) * 3)):
        axes, loose = releases(joint, elastic)
        np.testing.assert_array_equal(loose, wanted)
        np.testing.assert_allclose(axes[:, 0], joint.axis, atol=1e-15)
    assert not releases(joint, along)[1].any()  # the spring takes the direction over
    assert not releases(placed(kind, locked=True), None)[1].any()


def test_direction_counts_as_elastic_up_to_rounding_only():
    """The axis may deviate from the frame's by rounding; a deviation of a thousandth leaves a free direction."""
    elastic = JointStiffness("j", None, (9.0, 0.0, 0.0))
    for angle, free in ((1e-11, False), (1e-7, True), (1e-3, True)):
        joint = placed("revolute")
        joint.axis = np.cos(angle) * FRAME[:3, 0] + np.sin(angle) * FRAME[:3, 1]
        assert releases(joint, elastic)[1].tolist() == [False] * 3 + [free, False, False]


def test_springs_about_one_axis_of_a_universal_joint_leave_the_other_free():
    joint = placed("universal")
    axes, loose = releases(joint, None)
    assert loose.tolist() == [False] * 4 + [True, True]
    np.testing.assert_allclose(np.abs(axes.T @ joint.axis), [0, 1, 0], atol=1e-15)
    for values, left in (((9.0, 0.0, 0.0), joint.axis2), ((0.0, 9.0, INF), joint.axis)):
        axes, loose = releases(joint, JointStiffness("j", None, values))
        assert loose.tolist() == [False] * 3 + [True, False, False]
        np.testing.assert_allclose(axes[:, 0], left, atol=1e-15)
    assert not releases(joint, JointStiffness("j", None, (9.0, 9.0, 0.0)))[1].any()


@pytest.mark.parametrize(("platform", "expected"), [(1, 0.3), (0, np.sqrt(25.04)), (2, np.sqrt(25.04))])
def test_length_is_the_mean_distance_of_what_holds_the_platform(platform, expected):
    """From o: 0.2 and 0.4; the size of the frame where nothing holds the platform, or only at o."""
    o, beside, below = np.array([[0.0, 0.0, 4.0], [0.0, 0.2, 4.0], [0.0, 0.0, 3.6]])
    beam = SimpleNamespace(pieces=(3, 1), points=(np.array([3.0, 0, 0]), beside))
    joints = [SimpleNamespace(pieces=(3, 1), point=below), SimpleNamespace(pieces=(3, 0), point=o)]
    size, length = _sizes(o, platform, np.zeros((1, 3)), [beam], joints)
    assert (size, length) == pytest.approx((np.sqrt(3.0**2 + 0.2**2 + 4.0**2), expected))
