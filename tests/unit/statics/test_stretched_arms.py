"""Arms that nothing but their actuators makes elastic, at poses at which these move them in fewer directions than elsewhere."""

import numpy as np
import pinocchio as pin
import pytest

import kinetostatics as ks
from kinetostatics.description import Joint, JointStiffness, Link, Origin, RobotDescription

AXES = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0))
PLACES = ((0, 0, 0.1), (0, 0.1, 0), (0.6, 0, 0), (0.5, 0, 0), (0, 0.1, 0), (0, 0, -0.1))
STIFFNESS = np.array([6e4, 6e4, 3e4, 1e4, 1e4, 1e4])
LOAD = np.array([30.0, -40.0, -100.0, 2.0, 5.0, -7.0])


@pytest.fixture(scope="module")
def arm():
    """Six hinges; where all read zero the arm is stretched and its wrist straight."""
    links = [Link(f"l{k}", 1.0 + k, (0.1, 0.02, 0.01)) for k in range(7)]
    joints = [
        Joint(f"j{k}", "revolute", f"l{k}", f"l{k + 1}", Origin(place), axis, -3.0, 3.0)
        for k, (axis, place) in enumerate(zip(AXES, PLACES, strict=True))
    ]
    names = [joint.name for joint in joints]
    soft = [JointStiffness(name, drive=value) for name, value in zip(names, STIFFNESS, strict=True)]
    return ks.Robot(RobotDescription.of("arm", links=links, joints=joints, platform="l6", joint_stiffness=soft, driven=names))


def expected(arm, q, gravity):
    """J k⁻¹ (Jᵀ W − g(q)) with Pinocchio's Jacobian and gravity torques."""
    model = pin.buildModelFromXML(arm.description.urdf)
    model.gravity = pin.Motion(np.array(gravity), np.zeros(3))
    data = model.createData()
    J = pin.computeFrameJacobian(model, data, q, model.getFrameId("l6"), pin.LOCAL_WORLD_ALIGNED)
    torques = pin.computeGeneralizedGravity(model, data, q)
    return J, J @ ((J.T @ LOAD - torques) / STIFFNESS)


@pytest.mark.parametrize(
    ("q", "rank"),
    [
        ((0, 0, 0, 0, 0, 0), 5),
        ((0, 0.4, 0, 0, 0, 0), 5),
        ((0.2, -0.3, 0.8, 0.1, 0, 0.3), 5),
        ((0.2, -0.3, 0.8, 0.1, 0.5, 0.3), 6),
    ],
)
def test_a_stretched_arm_sags_by_its_drives_all_the_same(arm, q, rank) -> None:
    result = ks.analyze(arm.assemble(actuators=dict(zip(arm.description.driven, q, strict=True))), load=LOAD)
    J, twist = expected(arm, np.array(q, dtype=float), (0, 0, -9.81))
    assert np.sum(np.linalg.svd(J)[1] > 1e-9) <= rank
    np.testing.assert_allclose(result.twist, twist, atol=1e-10 * np.abs(twist).max())
    np.testing.assert_allclose(result.compliance, J / STIFFNESS @ J.T, atol=1e-10 * np.abs(J / STIFFNESS @ J.T).max())
    assert result.status == ks.Status.OK


def test_near_such_a_pose_and_in_a_batch_the_twists_are_the_same(arm) -> None:
    elbow = np.array([-1e-2, -1e-4, 0.0, 1e-4, 1e-2])
    zero = dict.fromkeys(arm.description.driven, 0.0)
    batch = ks.analyze(arm.assemble(actuators={**zero, "j2": elbow}), load=LOAD)
    assert np.all(batch.status == ks.Status.OK)
    for twist, value in zip(batch.twist, elbow, strict=True):
        right = expected(arm, np.array([0, 0, value, 0, 0, 0]), (0, 0, -9.81))[1]
        np.testing.assert_allclose(twist, right, atol=1e-7 * np.abs(right).max())
