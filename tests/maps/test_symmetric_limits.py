"""Symmetric robots have symmetric limits: at poses turned by 120° other limbs have the same coordinates and the same verdict."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks


@pytest.mark.parametrize(("name", "stroke"), [("3rps", 0.2), ("3prs", 0.3), ("linear_delta", 0.25)])
def test_limits_are_those_of_the_turned_pose(name, stroke):
    robot = package_robots.robot(name)
    names, rng = robot.actuator_names, np.random.default_rng(0)
    q = rng.uniform(-stroke, stroke, (300, 3))
    turned = [
        robot.assemble(actuators=dict(zip(names, np.roll(q, shift, axis=1).T, strict=True)), on_failure="nan").status
        for shift in range(3)
    ]
    assert np.array_equal(turned[0], turned[1]) and np.array_equal(turned[0], turned[2])
    assert set(turned[0]) >= {ks.Status.OK, ks.Status.LIMIT_EXCEEDED}
