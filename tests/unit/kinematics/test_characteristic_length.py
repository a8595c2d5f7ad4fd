"""The characteristic length: the mean distance of the limbs' outer joints from o, else a quarter of the robot."""

from types import SimpleNamespace

import numpy as np
import pytest
from simple_machines import joint, link, loop, mount, parallelogram, robot

from kinetostatics.kinematics.loop_constraints import world_frames
from kinetostatics.math.rotations import exponential
from kinetostatics.mechanism.tree import Frames


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


def test_a_robot_in_one_point_has_the_length_one():
    machine = robot(link("base"), link("platform", 1.0), joint("hinge", "continuous", "base", "platform"))
    assert machine.size == 0 and machine.length == 1.0


def test_frames_are_seen_from_the_base_wherever_it_goes():
    """The base link is in its own frame; what lies elsewhere keeps its place relative to it."""
    random = np.random.default_rng(4)
    turns = exponential(random.standard_normal((3, 5, 7)))
    frames = Frames(turns, random.standard_normal((3, 5, 7)))
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = exponential(np.array([[0.3], [0.4], [-0.5]]))[:, :, 0], (1.0, 2.0, 3.0)
    seen = world_frames(SimpleNamespace(base_frame=(2, placement)), frames)
    assert seen.rotation.shape == (3, 3, 5, 7) and seen.position.shape == (3, 5, 7)
    for pose in range(7):
        world = [
            np.block([[part.rotation[..., b, pose], part.position[:, b, pose, None]], [0, 0, 0, 1]])
            for part in (frames, seen)
            for b in range(5)
        ]
        base = world[2] @ placement
        for before, after in zip(world[:5], world[5:], strict=True):
            np.testing.assert_allclose(after, np.linalg.inv(base) @ before, atol=1e-12)
    assert world_frames(SimpleNamespace(base_frame=None), frames) is frames
