"""A beam as a link given by its stiffness and mass matrices, a class of this test, gives the results of the beam."""

import numpy as np
import pytest
from hybrid_robots import random_hybrid, write_randomly
from matrix_link import with_matrix_links

import kinetostatics as ks

LOAD, GRAVITY = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81)
ROBOTS = ["linear_delta", *range(60)]


def _robot(which):
    if isinstance(which, str):
        return ks.load_robot(which)
    return write_randomly(random_hybrid(which), which)[1].robot()


def _alike(found, expected, name=""):
    if hasattr(expected, "items"):
        assert list(found) == list(expected)
        for key, value in expected.items():
            _alike(found[key], value, f"{name}/{key}")
    else:
        scale = np.max(np.abs(np.nan_to_num(expected)), initial=0.0)
        assert np.allclose(found, expected, rtol=0, atol=1e-9 * scale, equal_nan=True), name


def _result(robot):
    try:
        return ks.analyze(robot.assemble(), load=LOAD, gravity=GRAVITY)
    except ks.KinetostaticsError as error:
        return str(error)


@pytest.mark.few(12)
@pytest.mark.parametrize("which", ROBOTS)
def test_statics(which):
    robot = _robot(which)
    found, expected = _result(with_matrix_links(robot)), _result(robot)
    if isinstance(expected, str):
        assert found == expected
        return
    for name in ("twist", "compliance", "actuator_forces", "joint_wrenches", "contributions", "base_wrench"):
        _alike(getattr(found, name), getattr(expected, name), name)
