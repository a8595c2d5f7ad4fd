"""A passive floating joint from base to platform is no limb; all limbs are alike, each closed by a loop."""

import numpy as np
import pytest
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.authoring.by_name import robot_text
from kinetostatics.files.reader import parse_robot_text

TEXT = (ROBOTS / "3rps.urdf.xacro").read_text(encoding="utf-8")
LOAD = [10, -20, 30, 1, 2, -3]


BALL = """<joint name="spherical_1_x" type="revolute">
    <parent link="rod_1"/><child link="ball_1_x"/><origin xyz="0 0 0" rpy="0 ${home_lean} 0"/><axis xyz="1 0 0"/>
    <limit effort="0" velocity="2"/>
  </joint>
  <link name="ball_1_x"/>
  <joint name="spherical_1_y" type="revolute">
    <parent link="ball_1_x"/><child link="ball_1_y"/><axis xyz="0 1 0"/><limit effort="0" velocity="2"/>
  </joint>
  <link name="ball_1_y"/>
  <joint name="spherical_1_z" type="revolute">
    <parent link="ball_1_y"/><child link="socket_1"/><axis xyz="0 0 1"/><limit effort="0" velocity="2"/>
  </joint>
  <link name="socket_1"/>
  <joint name="socket_1_to_platform" type="fixed">
    <parent link="socket_1"/><child link="platform"/><origin xyz="${-platform_radius} 0 0"/>
  </joint>
"""


def through_limb_1() -> str:
    """The 3RPS whose tree reaches the platform through limb 1, whose ball is three revolutes, instead of the floating joint."""
    text = TEXT
    start = text.index('<joint name="platform_pose"')
    text = text[:start] + BALL + text[text.index("</joint>", start) + len("</joint>") :]
    for old, new in (
        ('<xacro:platform_ball i="1" azimuth="0"/>', ""),
        ('to="spherical_${i}"', "to=\"${'spherical_1_x' if i == 1 else 'spherical_%d' % i}\""),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    return text


@pytest.fixture(scope="module")
def pair():
    return ks.Robot(parse_robot_text(through_limb_1(), str(ROBOTS / "3rps.urdf.xacro"))), ks.load_robot("3rps")


@pytest.mark.parametrize(
    "coordinates",
    [
        {"actuators": {"prismatic_1": 0.03, "prismatic_2": -0.02, "prismatic_3": 0.01}},
        {"platform": {"z": 0.5, "rx": 0.05, "ry": -0.17}, "orientation": "XYZ"},
        {"platform": {"z": [0.45, 0.6], "azimuth": [-2.0, 1.0], "tilt": 0.2}, "orientation": "tilt_torsion"},
    ],
)
def test_results_equal_those_of_a_tree_through_limb_1(pair, coordinates):
    one, other = (ks.analyze(robot.assemble(**coordinates), load=LOAD) for robot in pair)
    drives = [f"prismatic_{i}" for i in (1, 2, 3)]
    for what in ("twist", "stiffness", "base_wrench"):
        expected = getattr(one, what)
        np.testing.assert_allclose(getattr(other, what), expected, atol=1e-9 * np.abs(expected).max(), rtol=1e-9, err_msg=what)
    for drive in drives:
        np.testing.assert_allclose(other.actuator_forces[drive], one.actuator_forces[drive], rtol=1e-9)
    for i in (1, 2, 3):
        mine, theirs = other.limbs[f"limb_{i}"], one.limbs[f"limb_{i}"]
        assert mine.labels == theirs.labels
        np.testing.assert_allclose(mine.intensities, theirs.intensities, atol=1e-9 * np.abs(theirs.intensities).max())
    for drive in drives:
        np.testing.assert_allclose(other.configuration.actuators[drive], one.configuration.actuators[drive], atol=1e-12)


def test_floating_joint_is_no_limb_and_cannot_be_actuated(pair):
    robot = pair[1]
    assert list(ks.analyze(robot.assemble()).limbs) == ["limb_1", "limb_2", "limb_3"]
    assert [limb.is_serial for limb in robot.topology.limbs] == [True] * 3
    with pytest.raises(ks.RobotFileError, match="'platform_pose' is floating and cannot be actuated"):
        parse_robot_text(
            TEXT.replace('<joint name="prismatic_1"/>', '<joint name="platform_pose"/>'), str(ROBOTS / "3rps.urdf.xacro")
        )


@pytest.mark.few(1)
@pytest.mark.parametrize("end", ["flange_4", "platform_pose", "platform_pose:child"])
def test_beam_may_end_at_the_floating_joint(end):
    """The tube of a Tricept is fixed to the platform at o, where the floating joint is on the platform's side."""
    text = robot_text("3-U[P]S+UP", sections={"rod_4": "tube 120mm 100mm"})
    start = '<xacro:rod_4_beam link="rod_${i}" start="universal_${i}_y" end="flange_${i}"/>'
    assert start in text
    robot = ks.Robot(parse_robot_text(text.replace(start, start.replace("flange_${i}", end.replace("_4", "_${i}")))))
    expected = ks.analyze(ks.new_robot("3-U[P]S+UP", sections={"rod_4": "tube 120mm 100mm"}).assemble(), load=LOAD).twist
    np.testing.assert_allclose(ks.analyze(robot.assemble(), load=LOAD).twist, expected, rtol=1e-9, atol=1e-18)
