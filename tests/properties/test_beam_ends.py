"""Beams on links with just two joints have these for ends by default."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks


def unnamed(robot, ends=("start", "end")):
    """Return the robot without ``from`` and ``to`` of the beams between the only two joints of their links, and these beams."""
    changed = {}
    for name, beam in robot.description.beams.items():
        both = {item.name for item in robot.mechanism.at_link[beam.link]}
        if len(both) == 2 and {beam.start.joint, beam.end.joint} == both and not (beam.start.side or beam.end.side):
            changed[name] = replace(beam, **dict.fromkeys(ends))
    return ks.Robot(replace(robot.description, beams={**robot.description.beams, **changed})), list(changed)


@pytest.mark.few(4)
@pytest.mark.parametrize("ends", [("start", "end"), ("start",), ("end",)])
@pytest.mark.parametrize("name", ["2pru_upr", "delta", "five_bar", "linear_delta", "spherical_3rrr", "ur10"])
def test_beam_ends_default_to_the_two_joints_of_a_link(name, ends):
    """In parallelograms (rings within a limb) and in serial limbs: the ends that the package's robots name."""
    robot = package_robots.robot(name)
    other, beams = unnamed(robot, ends)
    assert beams
    assert other.topology.warnings == robot.topology.warnings
    for beam in beams:
        wanted, found = robot.topology.spans[beam], other.topology.spans[beam]
        np.testing.assert_array_equal(found.start, wanted.start)
        np.testing.assert_array_equal(found.end, wanted.end)
