"""Warnings of a robot: uncertain ranks, loops that stay open, no limbs."""

from dataclasses import replace

import pytest
from odd_robots import parsed, written

import kinetostatics as ks
from kinetostatics.checks.check import diagnose

#: A closed chain that hangs on the ground alone.
PENDULUM = (
    '<link name="pendulum"/><joint name="q" type="continuous"><parent link="ground"/><child link="pendulum"/></joint>'
    '<loop name="p" type="revolute"><predecessor link="ground"/><successor link="pendulum"/></loop>'
)


@pytest.mark.parametrize(("tilt", "doubtful"), [(3e-3, True), (3e-2, False)])
def test_a_mobility_that_depends_on_rounding_is_doubtful(tilt, doubtful):
    """A rod on three hinges with a common centre, of which the second is tilted, the third by rounding only, and a post."""
    edges = [
        ("one", "R", (0, 0, 0), "base", "first", {"axis": (0.0, 1.0, 0.0)}),
        ("two", "R", (0, 0, 0), "first", "second", {"axis": (tilt, 1.0, 0.0)}),
        ("three", "R", (0, 0, 0), "second", "rod", {"axis": (0.0, 1.0, 5e-6)}),
        ("top", "F", (0, 0, 0.5), "rod", "platform", {}),
        ("foot", "F", (0.3, 0, 0), "base", "post", {}),
        ("head", "F", (0.3, 0, 0.5), "post", "platform", {}),
    ]
    robot = parsed(written(edges, [("rod", "three", "top", {}), ("post", "foot", "head", {})], {"head"}, o=(0.1, 0, 0.5)))
    assert (robot.mobility.gap < 1e4) == doubtful
    assert any("the mobility is doubtful" in warning for warning in diagnose(robot).warnings) == doubtful


@pytest.mark.parametrize(("shift", "rounded"), [(7e-11, False), (5e-10, True)])
def test_gaps_below_solver_tolerance_cause_no_rounding_warning(shift, rounded):
    """A gap across the plane of a five-bar, which no motion closes; 7e-11 m are 5e-10 of its characteristic length."""
    description = ks.load_robot("five_bar").description
    (name, loop) = next(iter(description.loops.items()))
    x, y, z = loop.predecessor_origin.xyz
    robot = ks.Robot(description.changed(name, predecessor_origin=replace(loop.predecessor_origin, xyz=(x, y, z + shift))))
    assert robot.closing_error > 1e-10
    assert any("angles or lengths are probably rounded" in warning for warning in diagnose(robot).warnings) == rounded


@pytest.mark.parametrize("more", ["", PENDULUM])
def test_robots_without_limbs_are_warned_of(more, tmp_path):
    file = tmp_path / "drone.urdf"
    file.write_text(
        '<robot name="r"><link name="ground"/><link name="drone"/><joint name="fly" type="floating"><parent link="ground"/>'
        f'<child link="drone"/></joint><platform link="drone"/>{more}</robot>'
    )
    assert any("no limb joins base and platform" in warning for warning in diagnose(ks.load_robot(file)).warnings)
