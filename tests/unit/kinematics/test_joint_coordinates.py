"""Coordinates of joints and loops, and exceeded limits and cones."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from simple_machines import joint, link, loop, parallelogram, robot

import kinetostatics as ks
from kinetostatics.description import Cone


def test_loops_have_coordinates_like_joints():
    """Both cranks lean by 0.3, and the table turns back as far at both of its ends."""
    machine = parallelogram()
    pose = machine.assemble(actuators={"foot_0": [0.3, -0.2]})
    found = machine.joint_coordinates.at(pose.model_q, pose.frames)
    assert {name: value.tolist() for name, value in found.items()} == {
        name: pytest.approx([sign * 0.3, -sign * 0.2])
        for name, sign in (("foot_0", 1), ("foot_1", 1), ("head_0", -1), ("head_1", -1))
    }
    assert not pose.limits_exceeded


@pytest.mark.parametrize(("lower", "upper", "at", "reads"), [
    (-0.25, 0.25, [0.2, 0.3, -0.3], [-0.2, -0.3, 0.3]),
    (11.0, 15.0, [0.0, -0.2, 1.2, -1.3], [4 * np.pi, 4 * np.pi + 0.2, 4 * np.pi - 1.2, 4 * np.pi + 1.3]),
])  # fmt: skip
def test_loop_angle_is_unwrapped_into_its_limits(lower, upper, at, reads):
    table = parallelogram().description
    limited = replace(table.loops["head_1"], lower=lower, upper=upper)
    machine = ks.Robot(replace(table, loops={"head_1": limited}))
    pose = machine.assemble(actuators={"foot_0": at})
    np.testing.assert_allclose(machine.joint_coordinates.at(pose.model_q, pose.frames)["head_1"], reads, atol=1e-9)
    beyond = [not lower <= value <= upper for value in reads]
    assert (pose.status == ks.Status.LIMIT_EXCEEDED).tolist() == beyond
    assert set(pose.limits_exceeded) == ({"head_1"} if any(beyond) else set())


@pytest.mark.parametrize(("angle", "beyond"), [(0.4, False), (0.6, True), (-0.6, True)])
def test_cone_axes_need_no_unit_length(angle, beyond):
    """A ball joint between base and platform, whose z axis is tilted by ``angle`` from the zero pose."""
    free = robot(
        link("base"), link("platform", 1.0), joint("free", "floating", "base", "platform"),
        loop("ball", "spherical", "base", "platform"),
    ).description  # fmt: skip
    ball = replace(free.loops["ball"], cone=Cone(0.5, (0.0, 0.0, 4.0), (0.0, 0.0, 0.1)))
    machine = ks.Robot(replace(free, loops={"ball": ball}))
    pose = machine.assemble(platform={"rx": angle, "ry": 0.0, "rz": 0.0})
    assert (pose.status == ks.Status.LIMIT_EXCEEDED) == beyond
    if beyond:
        item = pose.limits_exceeded["ball"]
        assert float(item.value) == pytest.approx(0.6) and (item.lower, item.upper) == (0.0, 0.5)


@pytest.mark.parametrize("link", ["nothing", 3, None, ["rod_1"], {}])
def test_frames_of_unknown_links_are_refused(link):
    pose = package_robots.robot("3rps").assemble()
    with pytest.raises(ks.ArgumentError, match="no link"):
        pose.frame(link)


@pytest.mark.parametrize(("gap", "closed"), [(0.9e-10, True), (1.1e-10, False), (1e-7, False)])
def test_loops_are_closed_up_to_a_tenth_of_a_nanometre(gap, closed):
    """A distal link of 0.23 m, turned a little, opens the five-bar's wrist by the arc."""
    machine = package_robots.robot("five_bar")
    q = machine.assemble().q.copy()
    q[1] += gap / 0.23
    if closed:
        assert machine.configuration(q).residual == pytest.approx(gap, rel=1e-3)
    else:
        with pytest.raises(ks.AssemblyError, match="m open, more than"):
            machine.configuration(q)
