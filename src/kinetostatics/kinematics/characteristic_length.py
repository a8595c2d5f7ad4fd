"""Characteristic length of a robot, the scale of lengths relative to angles."""

from __future__ import annotations

import numpy as np

from kinetostatics.mechanism.limb_joints import compound_joints
from kinetostatics.mechanism.limbs import Topology
from kinetostatics.mechanism.mechanism import Mechanism


def box_diagonal(mechanism: Mechanism) -> float:
    """Return the diagonal [m] of the box around all bodies, joints and the platform with all joints at zero."""
    body, placement = mechanism.platform_frame
    frames = mechanism.forward(mechanism.tree.neutral[:, None])
    points = [frames.position[:, :, 0].T]
    for item in mechanism.connections.values():
        points.append(frames.point(item.predecessor_body, item.predecessor_frame[:3, 3]).T)
    points.append(frames.point(body, placement[:3, 3]).T)
    cloud = np.concatenate(points)
    return float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))


def characteristic_length(mechanism: Mechanism, topology: Topology, size: float) -> float:
    """Return the mean distance [m] of the limbs' outer joints from o, or a quarter of the robot's ``size`` [m]."""
    body, placement = mechanism.platform_frame
    frames = mechanism.forward(mechanism.tree.neutral[:, None])
    o = frames.point(body, placement[:3, 3])[:, 0]
    distances = []
    for limb in topology.limbs:
        compound_of = {name: compound for compound in compound_joints(mechanism, limb) for name in compound.joints}
        for edge in limb.edges:
            if edge.joint is None or len(edge.cut_joints) != 1 or not limb.to_platform[edge.cut_joints[0][0]]:
                continue
            connection = mechanism.connections[edge.joint]
            for link, item_body, frame in (
                (connection.successor, connection.successor_body, connection.successor_frame),
                (connection.predecessor, connection.predecessor_body, connection.predecessor_frame),
            ):
                if link in topology.platform.links:  # may differ from the platform's body if fixed by a loop
                    arm = frames.point(item_body, frame[:3, 3])[:, 0] - o
                    if edge.joint in compound_of:
                        compound = compound_of[edge.joint]
                        along = frames.direction(item_body, frame[:3, :3] @ connection.axis)[:, 0]
                        arm = arm + along * (compound.shift if compound.has_centre else -(along @ arm))
                    distances.append(float(np.linalg.norm(arm)))
                    break
    mean = float(np.mean(distances)) if distances else 0.0
    if mean > 1e-3 * size:
        return mean
    return size / 4 if size > 0 else 1.0
