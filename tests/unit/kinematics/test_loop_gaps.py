"""How far loops are open, in words: alike ones together, the widest first, rounding not at all."""

from types import SimpleNamespace

import numpy as np
import package_robots

from kinetostatics.kinematics.loop_gaps import are_within, gaps_text, worst_gaps_text
from kinetostatics.kinematics.robot_kinematics import RobotKinematics

EQUATIONS = SimpleNamespace(couplings=SimpleNamespace(names=["belt", "gear"]))


def test_gaps_that_are_alike_are_told_together():
    gaps = {"a": (0.1, 0.0), "b": (0.1, 0.9e-9), "c": (0.9e-9, 0.0), "d": (0.0, 0.2), "e": (1.1e-9, 0.2), "f": (0.0, 0.0)}
    assert gaps_text(gaps) == (
        "loops 'a', 'b' are 0.1 m open, loop 'd' is 0.2 rad open, loop 'e' is 1.1e-09 m and 0.2 rad open (2 others closed)"
    )
    assert gaps_text({"a": (0.1, 0.0), "c": (0.0, 0.0)}) == "loop 'a' is 0.1 m open (1 other closed)"
    assert gaps_text({"a": (0.1, 1.2)}) == "loop 'a' is 0.1 m and 1.2 rad open" and gaps_text({"c": (0.0, 0.0)}) == ""


def test_the_widest_gaps_are_told_first():
    gaps = {"a": (0.01, 0.0), "belt": (0.3, 0.0), "b": (0.2, 0.1), "c": (1e-3, 0.0), "d": (0.015, 0.0)}
    assert worst_gaps_text(EQUATIONS, gaps) == (
        "joint 'belt' is 0.3 m away from the position by its <mimic>, loop 'b' stays 0.2 m and 0.1 rad open, "
        "loop 'd' stays 0.015 m open"
    )
    assert worst_gaps_text(EQUATIONS, {"gear": (0.0, 0.3), "c": (2.9e-3, 0.0), "d": (0.0, 3.1e-3)}) == (
        "joint 'gear' is 0.3 rad away from the position by its <mimic>, loop 'd' stays 0 m and 0.0031 rad open"
    )
    assert worst_gaps_text(EQUATIONS, {"a": (0.5, 0.4e-9)}) == "loop 'a' stays 0.5 m open"
    assert worst_gaps_text(EQUATIONS, {"a": (0.9e-9, 0.5e-9)}) == "no loop stays open"  # rounding
    assert worst_gaps_text(EQUATIONS, {"a": (1.1e-9, 0.0)}) == "loop 'a' stays 1.1e-09 m open"
    assert worst_gaps_text(EQUATIONS, {"a": (0.0, 0.0)}) == worst_gaps_text(EQUATIONS, {}) == "no loop stays open"


def test_all_loops_have_to_be_closed():
    gaps = {"a": (0.1, 0.0), "b": (0.05, 0.2)}
    assert are_within(gaps, 0.1, 0.2) and not are_within(gaps, 0.09, 0.2) and not are_within(gaps, 0.1, 0.19)
    assert are_within({}, 0.0, 0.0)


def test_drives_of_the_tree_come_before_those_of_loops():
    description = SimpleNamespace(driven=["l2", "t2", "l1", "t1"])
    mechanism = SimpleNamespace(description=description, body_of_joint={"t1": 5, "t2": 7})
    loops = [SimpleNamespace(name=name) for name in ("l1", "other", "l2")]
    equations = SimpleNamespace(loops=loops, joint_of_body={5: SimpleNamespace(first_v=11), 7: SimpleNamespace(first_v=13)})
    robot = RobotKinematics.__new__(RobotKinematics)
    robot.description, robot.mechanism, robot.equations = description, mechanism, equations
    assert robot.actuator_names == ["t2", "t1", "l2", "l1"]
    found = robot.actuator_coordinates
    assert (found.columns, found.loops) == ((13, 11), (2, 0))


def test_coordinates_are_compared_with_their_limits():
    machine = package_robots.robot("3rps")
    pose = machine.assemble(platform={"z": np.array([0.5, 0.1]), "rx": 0.0, "ry": 0.0})
    for item in pose.limits_exceeded.values():
        assert item.where.tolist() == ((item.value < item.lower) | (item.value > item.upper)).tolist() and item.where.any()
    assert pose.limits_exceeded and not any(item.where[0] for item in pose.limits_exceeded.values())
