"""Gaps of open loops as text, and the joint or frame of a file that is probably wrong."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from simple_machines import joint, link, loop, parallelogram, robot

import kinetostatics as ks
from kinetostatics.kinematics.loop_gaps import FrameCorrection, gaps_text, worst_gaps_text

EQUATIONS = SimpleNamespace(couplings=SimpleNamespace(names=["belt", "gear"]))


def test_equal_gaps_are_grouped_in_the_text():
    gaps = {"a": (0.1, 0.0), "b": (0.1, 0.9e-9), "c": (0.9e-9, 0.0), "d": (0.0, 0.2), "e": (1.1e-9, 0.2), "f": (0.0, 0.0)}
    assert gaps_text(gaps) == (
        "loops 'a', 'b' are 0.1 m open, loop 'd' is 0.2 rad open, loop 'e' is 1.1e-09 m and 0.2 rad open (2 others closed)"
    )
    assert gaps_text({"a": (0.1, 0.0), "c": (0.0, 0.0)}) == "loop 'a' is 0.1 m open (1 other closed)"
    assert gaps_text({"c": (0.0, 0.0)}) == ""


def test_widest_gaps_are_listed_first():
    gaps = {"a": (0.01, 0.0), "belt": (0.3, 0.0), "b": (0.2, 0.1), "c": (1e-3, 0.0), "d": (0.015, 0.0)}
    assert worst_gaps_text(EQUATIONS, gaps) == (
        "joint 'belt' is 0.3 m away from the position by its <mimic>, loop 'b' stays 0.2 m and 0.1 rad open, "
        "loop 'd' stays 0.015 m open"
    )
    assert worst_gaps_text(EQUATIONS, {"a": (0.5, 0.4e-9)}) == "loop 'a' stays 0.5 m open"
    assert worst_gaps_text(EQUATIONS, {"a": (0.9e-9, 0.5e-9)}) == "no loop stays open"  # rounding
    assert worst_gaps_text(EQUATIONS, {"a": (1.1e-9, 0.0)}) == "loop 'a' stays 1.1e-09 m open"
    assert worst_gaps_text(EQUATIONS, {"a": (0.0, 0.0)}) == worst_gaps_text(EQUATIONS, {}) == "no loop stays open"


#: The joints of a five-bar linkage in the plane of x and y, by their parents: name, parent, child and origin.
JOINTS = {
    "motor_left": ("base", "crank_left", "-0.1 0 0"),
    "motor_right": ("base", "crank_right", "0.1 0 0"),
    "elbow_left": ("crank_left", "rod_left", "-0.1 0.2 0"),
    "elbow_right": ("crank_right", "rod_right", "0.1 0.2 0"),
    "tip": ("rod_left", "tool", "0.2 0.25 0"),
}
RODS = ("crank_left", "crank_right", "rod_left", "rod_right")


def beam(name):
    return f'<beam link="{name}" youngs_modulus="7e10" poisson_ratio="0.3" density="2700"><circle diameter="0.02"/></beam>'


def five_bar(parents=None, predecessor="rod_right", at="-0.2 0.25 0"):
    joints = {name: ((parents or {}).get(name, parent), child, xyz) for name, (parent, child, xyz) in JOINTS.items()}
    return robot(
        *(link(name) for name in ("base", *RODS)),
        link("tool", 1.0),
        *(joint(name, "continuous", *values, axis="0 0 1") for name, values in joints.items()),
        loop("closing", "revolute", predecessor, "tool", at, axis="0 0 1"),
        *map(beam, RODS),
        '<transmission name="l"><joint name="motor_left"/></transmission>',
        '<transmission name="r"><joint name="motor_right"/></transmission>',
        platform="tool",
    )


@pytest.mark.parametrize(
    ("name", "wrong"), [("elbow_left", "base"), ("elbow_left", "crank_right"), ("elbow_right", "rod_left"), ("tip", "crank_left")]
)
def test_error_begins_with_the_wrong_parent(name, wrong):
    right = JOINTS[name][0]
    with pytest.raises(ks.RobotFileError) as caught:
        five_bar({name: wrong})
    assert caught.value.reason.startswith(
        f"the <parent> of joint {name!r} seems wrong: on link {right!r} instead of {wrong!r} it would close all loops at zero"
    )


def test_error_begins_with_the_wrong_predecessor_or_successor():
    with pytest.raises(ks.RobotFileError) as caught:
        five_bar(predecessor="crank_left")
    assert caught.value.reason.startswith("the <predecessor> or <successor> of loop 'closing' seems wrong: on link 'rod_right'")


def test_dangling_link_is_reported_before_ambiguous_beam_ends():
    with pytest.raises(ks.RobotFileError) as caught:  # the loop's place fits no link
        five_bar({"tip": "crank_right"}, at="0.3 0.25 0")
    reason = caught.value.reason
    assert "seems wrong" not in reason
    assert re.match(r"<beam '\w+'>: link 'rod_left' ends nowhere, as 'elbow_left' is its only joint: is a <parent> wrong", reason)
    assert reason.index("ends nowhere") < reason.index("name the joint by to=")


def test_no_wrong_parent_is_suspected_with_closed_loops():
    """A dangling bracket with the frame of the base: every joint of the base would also fit the bracket."""
    parts = [link("base"), link("bracket"), link("rod"), link("tool", 1.0), joint("screw", "continuous", "base", "bracket")]
    parts += [joint("hinge", "continuous", "base", "rod"), joint("end", "continuous", "rod", "tool", "1 0 0")]
    parts += [loop("closing", "revolute", "base", "tool", "1 0 0", axis="0 1 0"), beam("bracket")]
    with pytest.raises(ks.RobotFileError, match="'bracket' ends nowhere") as caught:
        robot(*parts, platform="tool")
    assert "at zero" not in caught.value.reason


@pytest.mark.parametrize(
    ("across", "shift", "motion"), [(0.0, 0.0, True), (3e-6, 0.0, True), (1e-4, 0.0, False), (0.0, 1e-9, False)]
)
def test_correction_about_a_hinge_axis_is_a_joint_motion(across, shift, motion):
    """Up to the rounding of the axis, and only without a translation."""
    turn = 0.3 * np.array([0.0, 1.0, across])
    found = FrameCorrection("foot_0", False, "base", np.array([shift, 0.0, 0.0]), turn)
    assert found.is_motion_of(parallelogram().mechanism) == motion
