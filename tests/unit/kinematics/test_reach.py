"""Ordinary poses within the limits."""

import numpy as np
import package_robots

from kinetostatics.kinematics.reach import ordinary_poses


def test_ordinary_poses_lie_at_fractions_of_the_limits():
    """One actuator at a time moves by 0.2 and 0.6 of its limits, which count up to 1.2 characteristic lengths."""
    machine = package_robots.robot("3rps")
    pose = machine.configuration(ordinary_poses(machine).T)
    connections = machine.mechanism.connections
    drives = list(machine.description.actuated)
    moved = np.stack([pose.actuators[name] for name in drives], axis=1)
    wanted = [np.zeros(3)]
    far = 1.2 * machine.length
    for part in (0.2, 0.6):
        for side in ("lower", "upper"):
            wanted += list(np.diag([part * np.clip(getattr(connections[name], side), -far, far) for name in drives]))
    np.testing.assert_allclose(moved, wanted, atol=1e-9)
