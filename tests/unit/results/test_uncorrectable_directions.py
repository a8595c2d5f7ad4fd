"""In which directions no actuator moves the platform: along a batch by the same axes, as long as these tell anything."""

import numpy as np
from swinging_plate import parallelogram

import kinetostatics as ks
from kinetostatics.results.compensation import uncorrectable_directions


def test_axes_that_tell_little_are_chosen_anew():
    """A plate that moves along a circle: with upright rods along x, so that y and z tell what is left; with flat ones along z."""
    robot = ks.Robot(parallelogram())
    angles = np.array([0.0, 1.5, 1.52])
    batch = uncorrectable_directions(robot.assemble(actuators={"a": angles}), None)
    alone = uncorrectable_directions(robot.assemble(actuators={"a": 1.5}), None)
    np.testing.assert_allclose(batch[..., 1], alone[..., 0], atol=1e-9)
    np.testing.assert_allclose(batch[..., 2], batch[..., 1], atol=0.02 * robot.length)
    free = np.array([np.cos(angles), 0 * angles, -np.sin(angles), *np.zeros((3, 3))])
    np.testing.assert_allclose(np.einsum("in,ikn->kn", free, batch), 0, atol=1e-9)
