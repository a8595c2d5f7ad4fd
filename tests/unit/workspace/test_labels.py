"""Labels of Pinocchio's coordinates in maps."""

from loop_robots import floating, frame
from simple_machines import joint, link, robot

from kinetostatics.workspace.dataset import _q_labels


def test_coordinates_of_endless_joints_are_a_cosine_and_a_sine():
    parts = link("base"), link("arm"), link("slide"), link("platform", 1.0)
    chain = robot(
        *parts,
        joint("turn", "continuous", "base", "arm"),
        joint("reach", "prismatic", "arm", "slide", axis="1 0 0"),
        joint("wrist", "revolute", "slide", "platform"),
    )
    assert _q_labels(chain) == [("turn:cos", "1"), ("turn:sin", "1"), ("reach", "m"), ("wrist", "rad")]
    free = floating("spherical", frame(), frame())
    assert _q_labels(free) == [(f"free:{k}", "1") for k in range(7)]
