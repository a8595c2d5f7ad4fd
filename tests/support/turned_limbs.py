"""Poses with open loops, at which a limb of the linear Delta has dependent wrenches."""

import numpy as np
import pinocchio as pin


def with_first_limb_turned(robot, q):
    """Return coordinates q (nq,) after the first rod and the platform turn by 90° about the first axis of the upper joint."""
    pose = robot.configuration(q, closure_tolerance=np.inf)
    carriage, platform = pose.frame("carriage_1"), pose.frame("platform")
    hinge = pin.SE3(carriage[:3, :3], carriage[:3, 3])
    turned = hinge * pin.SE3(pin.utils.rotate("y", np.pi / 2), np.zeros(3)) * hinge.inverse() * pin.SE3(platform)
    found = np.array(q)
    found[coordinate(robot, "upper_1_y")] += np.pi / 2
    first = coordinate(robot, "platform_pose")
    found[first : first + 7] = pin.SE3ToXYZQUAT(turned)
    return found


def coordinate(robot, joint):
    """Return the index of a joint's first coordinate in q."""
    return robot.model.idx_qs[robot.model.getJointId(joint)]
