"""The characteristic length: the mean distance of the limbs' outer joints from o, else a quarter of the robot."""

import numpy as np
import pytest
from simple_machines import joint, link, loop, mount, parallelogram, robot


def hinged(*axes):
    """A plate on hinges through one point, 0.3 and 0.7 beside o."""
    names = ["base", *(f"ring_{k}" for k in range(1, len(axes))), "plate"]
    hinges = [joint(f"hinge_{k}", "continuous", *names[k : k + 2], axis=axis) for k, axis in enumerate(axes)]
    return robot(*map(link, names), link("platform"), *hinges, joint("weld", "fixed", "plate", "platform", "0.3 0.7 0"))


@pytest.mark.parametrize(
    ("axes", "length"),
    [
        (("0 1 0",), 0.3),  # from the line of a hinge whose place along it is the file's choice alone
        (("1 0 0",), 0.7),
        (("1 0 0", "0 1 0"), np.hypot(0.3, 0.7)),  # from the point in which two of them meet
        (("0 0 1",), np.hypot(0.3, 0.7)),
    ],
)
def test_the_distance_of_the_platform_s_joint(axes, length):
    assert hinged(*axes).length == pytest.approx(length, rel=1e-12)


def test_limbs_count_alike():
    assert parallelogram().length == pytest.approx((0.0 + 0.5) / 2, rel=1e-12)


@pytest.mark.parametrize(("far", "length"), [(0.9e-3, 0.25), (1.1e-3, 1.1e-3)])
def test_joints_that_all_but_meet_in_o_tell_no_length(far, length):
    """Then it is a quarter of the robot, a 1 m high column here."""
    machine = robot(
        link("base"), link("column"), link("plate"), link("platform"), joint("foot", "fixed", "base", "column"),
        joint("head", "continuous", "column", "plate", "0 0 1"), joint("weld", "fixed", "plate", "platform", f"{far} 0 0"),
        loop("seam", "fixed", "plate", "platform", f"{far} 0 0"),
    )  # fmt: skip
    assert machine.length == pytest.approx(length, rel=1e-4)


def test_a_robot_of_one_joint_is_as_large_as_its_box():
    machine = mount(kind="continuous")
    assert machine.size == pytest.approx(0.3) and machine.length == pytest.approx(0.075)
