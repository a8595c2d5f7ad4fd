"""Rates of the tree's coordinates by the given coordinates, against differences of assembled poses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import package_robots
import pytest
from loop_robots import Held
from places import ROOT
from simple_machines import joint, link, loop
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.description.joints import Mimic
from kinetostatics.kinematics.alternatives import prescribed_platform
from kinetostatics.kinematics.path_following import follow
from kinetostatics.kinematics.rates import moving_bodies
from kinetostatics.kinematics.velocities import freedom_rates, with_given
from kinetostatics.math.linalg import least_squares
from kinetostatics.math.rotations import orientation_named


def follower():
    description = ks.files.read_robot_file(ROOT / "robots" / "3rps.urdf.xacro")
    return ks.Robot(
        replace(description.changed("prismatic_3", mimic=Mimic("prismatic_1", -0.4)), actuated=("prismatic_1", "prismatic_2"))
    )


def slider_crank():
    """A crank of 0.3 and a coupler of 0.8 in the plane y = 0; the slide along x that drives them is the loop."""
    parts = [link("base"), link("crank"), link("platform", 1.0), link("block"), joint("a", "continuous", "base", "crank")]
    parts += [joint("b", "continuous", "crank", "platform", "0 0 0.3"), joint("c", "continuous", "platform", "block", "0.8 0 0")]
    parts += [loop("s", "prismatic", "base", "block", "0.8 0 0.3", axis="1 0 0")]
    return robot_of(*parts, '<transmission name="t"><joint name="s"/></transmission>')


ROBOTS = {
    "slides and spherical joints": (lambda: package_robots.robot("3rps"), ("z", "rx", "ry"), (0.5, 0.1, -0.05)),
    "a follower": (follower, ("z", "rx"), (0.5, 0.03)),
    "hinges": (lambda: package_robots.robot("planar_3rrr"), ("x", "y", "rz"), (0.02, -0.03, 0.1)),
    "tilt and torsion": (lambda: package_robots.robot("3prs"), ("z", "azimuth", "tilt"), (0.55, 0.7, 0.3)),
    "an actuated sliding loop": (lambda: Held("prismatic", 3, drive="closing").robot(), None, (0.1,)),
    "an actuated turning loop": (lambda: Held("continuous", 4, drive="closing").robot(), None, (0.3,)),
    "a crank actuated by its slider": (slider_crank, None, (0.1,)),
    "a base that is not the root": (lambda: Held("cylindrical", 5, "upside_down").robot(), None, (0.1, 0.2)),
}


def rates_of(robot, prescribed, pose):
    """Return the freedoms' rates (nv, n, 1) by each given coordinate."""
    solver, prescribed = robot.solver, robot.mobility_analysis.with_dofs(prescribed)
    gradient, rates = solver.rates(prescribed, pose.poses, solver.values(prescribed, pose.poses))
    step = -least_squares(gradient, rates, prescribed.local_dofs)
    return with_given(solver, prescribed, freedom_rates(solver, prescribed, gradient, rates, step))


def close_to(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("name", ROBOTS)
def test_rates_equal_differences_of_assembled_poses(name):
    make, platform, values = ROBOTS[name]
    robot, h = make(), 1e-6
    names = platform or robot.description.actuated
    turned = {"orientation": "tilt_torsion"} if "tilt" in names else {}
    start = robot.assemble(**{"platform" if platform else "actuators": dict(zip(names, values, strict=True))}, **turned)
    ways = [("actuators", robot.actuator_coordinates, robot.actuator_names, start.actuators)]
    if platform:
        given = dict(zip(platform, values, strict=True))
        ways.append(("platform", prescribed_platform(platform, orientation_named(turned.get("orientation"))), platform, given))
    for way, prescribed, coordinates, at in ways:
        v = rates_of(robot, prescribed, start)
        at = {item: float(at[item]) for item in at}
        for k, item in enumerate(coordinates):
            more = turned if way == "platform" else {}
            up, down = (robot.assemble(**{way: {**at, item: at[item] + by}}, near=start, **more).poses.x for by in (h, -h))
            close_to(robot.equations.tree.rates(start.poses.x, v[:, k]), (up - down) / (2 * h))


@pytest.mark.parametrize(("left", "follows"), [(0.0, True), (0.9e-6, True), (1.1e-6, False), (1.0, False)])
@pytest.mark.parametrize("size", [1e-13, 1e-3, 1.0, 1e3])
def test_rates_that_violate_a_loop_are_nan(left, follows, size):
    """One of two equations can be satisfied, the other changes by the part ``left``; rates below 1e-12 are rounding."""
    follows = follows or size < 1e-12
    solver = SimpleNamespace(
        tree=SimpleNamespace(nv=3), column_scale=np.array([1.0, 2.0, 1.0]), free_columns=lambda _: np.array([1])
    )
    rates = size * np.array([1.0, left])[:, None, None]
    gradient, step = np.array([1.0, 0.0])[:, None, None], np.full((1, 1, 1), -size)
    found = freedom_rates(solver, None, gradient, rates, step)[:, 0, 0]
    np.testing.assert_array_equal(found, [0.0, -2 * size, 0.0] if follows else [np.nan] * 3)


@pytest.mark.parametrize("name", ["five_bar", "planar_3rrr"])
def test_derivatives_of_twists_equal_differences_along_the_motion(name):
    """Coordinates c + v t + ½ a t², whose rates these are at t = 0; loops bend the bodies' paths even without acceleration."""
    robot = package_robots.robot(name)
    prescribed = robot.mobility_analysis.with_dofs(robot.actuator_coordinates)
    start, n, rng = robot.zero_poses, prescribed.size, np.random.default_rng(3)
    velocity, acceleration = rng.uniform(-1, 1, (2, n, 1))
    target = robot.solver.values(prescribed, start)
    h, twists = 1e-4, []
    for time in (-h, h):
        there = target + velocity * time + acceleration * time**2 / 2
        pose, reached, _ = follow(robot.solver, prescribed, start, there)
        assert reached.all()
        twists.append(moving_bodies(robot.solver, prescribed, pose, velocity + acceleration * time, acceleration)[0])
    for accelerated in (acceleration, 0 * acceleration):
        derivative = moving_bodies(robot.solver, prescribed, start, velocity, accelerated)[1]
        linear = moving_bodies(robot.solver, prescribed, start, acceleration - accelerated, 0 * velocity)[0]
        by_differences = (twists[1] - twists[0]) / (2 * h) - linear
        np.testing.assert_allclose(derivative, by_differences, rtol=0, atol=1e-6 * np.abs(by_differences).max())
