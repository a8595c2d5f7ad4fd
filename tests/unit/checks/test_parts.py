"""What is said of a robot's limbs."""

import re

import small_robots as sr
from odd_robots import parsed

from kinetostatics.checks.collect import robot_facts


def test_limbs_are_alike_whatever_their_joints_are_called():
    """Names of one letter, and names that are words of labels."""
    text = sr.write(sr.rps3()).text
    for old, new in {"revolute_1": "a", "prismatic_1": "at", "revolute_2": "force", "prismatic_2": "x"}.items():
        text = re.sub(rf'"{old}"', f'"{new}"', text)
    limbs = robot_facts(parsed(text)).limbs
    assert limbs[0].constraint_wrenches[1].startswith("force ∥ a at ")
    assert [limb.like for limb in limbs] == [None, "limb_1", "limb_1"]
