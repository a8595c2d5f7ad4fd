"""Robots without any limb between base and platform are described, not refused."""

import pytest

import kinetostatics as ks
from kinetostatics.checks.check import robot_facts

#: a closed chain that hangs on the ground alone
PENDULUM = (
    '<link name="pendulum"/><joint name="q" type="continuous"><parent link="ground"/><child link="pendulum"/></joint>'
    '<loop name="p" type="revolute"><predecessor link="ground"/><successor link="pendulum"/></loop>'
)


@pytest.mark.parametrize("more", ["", PENDULUM])
def test_check_explains_robots_without_limbs(more, tmp_path):
    file = tmp_path / "drone.urdf"
    file.write_text(
        '<robot name="r"><link name="ground"/><link name="drone"/><joint name="fly" type="floating"><parent link="ground"/>'
        f'<child link="drone"/></joint><platform link="drone"/>{more}</robot>'
    )
    assert any("no limb joins base and platform" in warning for warning in robot_facts(ks.load_robot(file)).warnings)
