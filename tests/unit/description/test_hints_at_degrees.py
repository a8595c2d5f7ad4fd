"""Angles and limits that look like degrees."""

import pytest
from simple_machines import joint, link, robot


@pytest.mark.parametrize(
    ("limit", "is_odd"), [(12.56, False), (12.57, True), (90.0, True), (720.0, True), (721.0, False), (1e9, False)]
)
def test_limits_beyond_two_turns_look_like_degrees(limit, is_odd):
    """And very wide ones stand for none at all."""
    hinge = joint("hinge", "revolute", "base", "platform").replace('upper="9"', f'upper="{limit}"')
    description = robot(link("base"), link("platform", 1.0), hinge).description
    found = description.angle_hints()
    assert len(found) == is_odd and all("the limits" in text and "'hinge' look like degrees" in text for text in found)


@pytest.mark.parametrize(("angle", "is_odd"), [("6.29", False), ("90", True), ("12", False), ("13", True), ("-180", True)])
def test_angles_of_frames(angle, is_odd):
    parts = link("base"), link("platform", 1.0), joint("hinge", "revolute", "base", "platform", rpy=f"0 {angle} 0")
    description = robot(*parts).description
    assert len(description.angle_hints()) == is_odd
