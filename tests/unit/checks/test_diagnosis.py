"""Facts about a robot's limbs."""

import re

import numpy as np
import package_robots
import small_robots as sr
from odd_robots import parsed, written

import kinetostatics as ks
from kinetostatics.checks.chains import joints_of
from kinetostatics.checks.check import diagnose, missing_results
from kinetostatics.math import arrays


def test_equal_limbs_are_found_whatever_their_joint_names():
    """Names of one letter, and names that are words of labels."""
    text = sr.write(sr.rps3()).text
    for old, new in {"revolute_1": "a", "prismatic_1": "at", "revolute_2": "force", "prismatic_2": "x"}.items():
        text = re.sub(rf'"{old}"', f'"{new}"', text)
    limbs = diagnose(parsed(text)).limbs
    assert limbs[0].constraint_wrenches[1].startswith("force ∥ a at ")
    assert [limb.like for limb in limbs] == [None, "limb_1", "limb_1"]


def test_limb_degenerating_in_a_later_chunk_is_named(monkeypatch):
    monkeypatch.setattr(arrays, "AT_ONCE", 1)
    robot = package_robots.robot("linear_delta")
    q = np.repeat(robot.assemble().model_q.T, 2, axis=0)
    for name in ("upper_2_x", "upper_3_x"):
        q[1, robot.model.idx_qs[robot.model.getJointId(name)]] += np.pi / 2
    result = ks.analyze(robot.configuration(q, closure_tolerance=10.0), on_failure="nan")
    assert result.basis_degenerate.tolist() == [False, True]
    (words,) = missing_results(result)
    assert words == (
        "at some poses the wrench basis of limb_2 and limb_3 is not unique: intensities are NaN there, all else is valid"
    )


def test_hinges_of_hanging_parts_form_one_joint():
    """A bob joined to the platform by a universal and a spherical joint: a ring."""
    edges = [
        ("root", "F", (0, 0, 0), "base", "rod", {}),
        ("tip", "F", (0, 0, 0.5), "rod", "platform", {}),
        ("cross", "U", (0.3, 0, 0.5), "platform", "bob", {}),
        ("ball", "S", (0.3, 0.2, 0.6), "bob", "platform", {}),
    ]
    facts = diagnose(parsed(written(edges, [("rod", "root", "tip", {})], {"ball"}, o=(0, 0, 0.5))))
    (ring,) = facts.on_platform.graph.hanging
    assert ring.is_ring and sorted(step.kind for step in joints_of(ring.chain)) == ["spherical", "universal"]
