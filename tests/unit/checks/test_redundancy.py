"""Self-stresses of robots with joints that follow others."""

import pytest
from odd_robots import parsed

from kinetostatics.checks.redundancy import _SelfStresses

INERTIAL = '<inertial><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
HINGE = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>{}</joint>'
SLIDE = """<joint name="{}" type="prismatic"><parent link="{}"/><child link="{}"/><axis xyz="1 0 0"/>
<limit effort="0" velocity="0"/>{}</joint>"""

MIMIC = '<mimic joint="{}" multiplier="{}"/>'


@pytest.mark.parametrize("leader", ["hinge", "slide"])
@pytest.mark.parametrize(("beside", "count"), [(0.0, 5), (1e-3, 4), (-0.3, 4)])
def test_self_stresses_of_a_slide_coupled_to_a_hinge(leader, beside, count):
    """Turning about z at the origin and sliding along x by 0.7 m/rad is a rotation about (0, 0.7): a hinge there leaves this
    freedom and makes five self-stresses; elsewhere it leaves no freedom and makes four."""
    turn, slide = HINGE, SLIDE
    if leader == "hinge":
        joints = turn.format("turn", "ground", "arm", "") + slide.format("slide", "arm", "plate", MIMIC.format("turn", 0.7))
    else:
        joints = turn.format("turn", "ground", "arm", MIMIC.format("slide", 1 / 0.7)) + slide.format("slide", "arm", "plate", "")
    robot = parsed(
        f"""<robot name="cam"><link name="ground"/><link name="arm"/><link name="plate">{INERTIAL}</link>{joints}
  <platform link="plate"><origin xyz="0.2 0.1 0.3"/></platform>
  <loop name="pivot" type="revolute">
    <predecessor link="ground"><origin xyz="0 {0.7 + beside} 0"/></predecessor>
    <successor link="plate"><origin xyz="0 {0.7 + beside} 0"/></successor><axis xyz="0 0 1"/>
  </loop>
  <transmission name="drive"><joint name="{"turn" if leader == "hinge" else "slide"}"/></transmission>
</robot>"""
    )
    assert robot.length != pytest.approx(1, abs=0.05)
    assert _SelfStresses(robot, robot.zero_poses).states.shape[1] == count
