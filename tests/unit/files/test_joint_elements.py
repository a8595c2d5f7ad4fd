"""Reading of ``<joint_stiffness>`` and ``<mimic>``, and errors with their line."""

import math

import pytest

from kinetostatics.description import JointStiffness, Mimic, RobotDescription
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.reader import parse_robot_text

INF = math.inf

ROBOT = """<robot name="r">
  <link name="ground"/>
  <link name="arm"/>
  <link name="jaw"/>
  <link name="slide"/>
  <link name="plate"/>
  <joint name="motor" type="revolute">
    <parent link="ground"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="0"/>
  </joint>
  <joint name="bolt" type="fixed"><parent link="arm"/><child link="plate"/></joint>
  <joint name="passive" type="continuous"><parent link="arm"/><child link="jaw"/><axis xyz="1 1 0"/></joint>
  <joint name="rail" type="prismatic">
    <parent link="ground"/><child link="slide"/><axis xyz="0 -2 0"/><limit effort="0" velocity="0"/>
  </joint>
  <platform link="plate"/>
  <loop name="ball" type="spherical"><predecessor link="ground"/><successor link="plate"/></loop>
  <loop name="cross" type="universal"><predecessor link="ground"/><successor link="plate"/></loop>
  <loop name="table" type="planar"><predecessor link="ground"/><successor link="plate"/><axis xyz="0 1 0"/></loop>
  <loop name="sleeve" type="cylindrical"><predecessor link="ground"/><successor link="plate"/><axis xyz="1 0 1"/></loop>
  <transmission name="drive"><joint name="motor"/></transmission>
</robot>
"""
RAIL = '<axis xyz="0 -2 0"/>'
PASSIVE = '<axis xyz="1 1 0"/>'
END = "</robot>"
#: Line before which something is added at the end.
LAST = ROBOT[: ROBOT.index(END)].count("\n") + 1


def with_line(line: str, at: str = END) -> str:
    """Return the robot with one more line before ``at``."""
    assert ROBOT.count(at) == 1
    return ROBOT.replace(at, f"{line}\n{at}")


def read(line: str, at: str = END) -> RobotDescription:
    return parse_robot_text(with_line(line, at), "joints.urdf")


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('joint="motor" drive="1e5"', JointStiffness("motor", drive=1e5)),
        # an actuated joint's own direction counts as blocked, and actuator and group act in series
        ('joint="motor" drive="1e5" angular="inf 2 3e4"', JointStiffness("motor", None, (INF, 2.0, 3e4), 1e5)),
        ('joint="motor" angular="inf inf inf"', JointStiffness("motor")),
        ('joint="bolt" linear="1 2 3" angular="4 5 inf"', JointStiffness("bolt", (1.0, 2.0, 3.0), (4.0, 5.0, INF))),
        # along the freedom of a passive joint: a spring, or none
        ('joint="rail" linear="1e9 5 inf"', JointStiffness("rail", (1e9, 5.0, INF))),
        ('joint="ball" angular="0 7 inf"', JointStiffness("ball", None, (0.0, 7.0, INF))),
        ('joint="table" linear="0 7 0" angular="7 0 7"', JointStiffness("table", (0.0, 7.0, 0.0), (7.0, 0.0, 7.0))),
        # axes that are none of the frame's: all three elastic, or a direction that has no freedom
        ('joint="passive" angular="1 2 3" linear="1 inf inf"', JointStiffness("passive", (1.0, INF, INF), (1.0, 2.0, 3.0))),
        ('joint="cross" angular="1 2 3" linear="inf inf 1"', JointStiffness("cross", (INF, INF, 1.0), (1.0, 2.0, 3.0))),
    ],
)
def test_joint_stiffness_is_read(attributes: str, expected: JointStiffness) -> None:
    robot = read(f"<joint_stiffness {attributes}/>")
    found = robot.joint_stiffness[expected.joint]
    assert (found.joint, found.linear, found.angular, found.drive) == (
        expected.joint, expected.linear, expected.angular, expected.drive,
    )  # fmt: skip
    assert (found.place.file, found.place.line) == ("joints.urdf", LAST)
    assert list(robot.joint_stiffness) == [expected.joint]


@pytest.mark.parametrize(
    ("element", "words"),
    [
        ('<joint_stiffness joint="motor"/>', ["has no stiffness", "linear, angular or drive"]),
        ('<joint_stiffness joint="moto" drive="1"/>', ["'moto'", "did you mean 'motor'"]),
        ('<joint_stiffness joint="motor" drive="-inf"/>', ["drive='-inf'", "finite"]),
        ('<joint_stiffness joint="motor" drive="1e-40"/>', ["too small"]),
        ('<joint_stiffness joint="rail" drive="1"/>', ["'rail'", "not actuated", "<transmission>"]),
        ('<joint_stiffness joint="motor" linear="1 2 -3"/>', ["'1 2 -3'", "zero or greater", "inf"]),
        ('<joint_stiffness joint="motor" angular="1 1 0"/>', ["angular", "0 about z", "'motor' constrains", "inf"]),
        ('<joint_stiffness joint="bolt" angular="0 1 1"/>', ["0 about x", "'bolt' constrains"]),
        ('<joint_stiffness joint="table" linear="1 0 1"/>', ["0 along y", "'table' constrains"]),
        ('<joint_stiffness joint="cross" angular="1 inf 1"/>', ["universal", "three finite numbers", "left out"]),
        ('<joint_stiffness joint="passive" angular="1 1 inf"/>', ["'passive' turns about", "origin rpy", "frame's axes"]),
        ('<joint_stiffness joint="sleeve" linear="1 0 1"/>', ["'sleeve' slides along", "origin rpy", "frame's axes"]),
        ('<joint_stiffness joint="motor" drive="1"/>\n<joint_stiffness joint="motor" drive="1"/>', ["already", f"urdf:{LAST}"]),
    ],
)
def test_wrong_joint_stiffness_is_an_error(element: str, words: list[str]) -> None:
    with pytest.raises(RobotFileError) as caught:
        read(element)
    assert caught.value.line == LAST + element.count("\n")
    for word in words:
        assert word in str(caught.value)


def test_mimic_is_read() -> None:
    robot = read('<mimic joint="motor" multiplier="-0.5" offset="0.1"/>', RAIL)
    assert robot.joints["rail"].mimic == Mimic("motor", -0.5, 0.1)
    assert robot.actuated == ("motor",)
    assert read('<mimic joint="motor"/>', PASSIVE).joints["passive"].mimic == Mimic("motor", 1.0, 0.0)
    # a joint that is locked with its master blocks its own direction too
    text = with_line('<mimic joint="motor"/>', RAIL)
    assert parse_robot_text(text.replace(END, '<joint_stiffness joint="rail" linear="1 2 3"/></robot>')).joint_stiffness
    with pytest.raises(RobotFileError, match="0 along y"):
        parse_robot_text(text.replace(END, '<joint_stiffness joint="rail" linear="1 0 3"/></robot>'))


@pytest.mark.parametrize(
    ("mimic", "words"),
    [
        ('<mimic joint="bolt"/>', ["'bolt'", "is fixed", "an actuated revolute, continuous or prismatic"]),
        ('<mimic joint="passive"/>', ["'passive'", "not actuated", "<transmission>"]),
        ('<mimic joint="sleeve"/>', ["the loop 'sleeve'", "of the tree"]),
        ('<mimic joint="rail"/>', ["itself"]),
        ('<mimic joint="motr"/>', ["'motr'", "did you mean 'motor'"]),
        ('<mimic joint="motor" multiplier="0"/>', ["multiplier=0", "between"]),
        ('<mimic joint="motor" offset="1e10"/>', ["offset", "too large"]),
        ('<mimic joint="motor"/><mimic joint="motor"/>', ["two <mimic>"]),
    ],
)
def test_wrong_mimic_is_an_error(mimic: str, words: list[str]) -> None:
    with pytest.raises(RobotFileError) as caught:
        read(mimic, RAIL)
    assert caught.value.line == 13
    for word in words:
        assert word in str(caught.value)


def test_floating_actuated_and_chained_joints_cannot_mimic() -> None:
    with pytest.raises(RobotFileError, match="'loose' is floating and cannot mimic"):
        parse_robot_text(
            ROBOT.replace('"bolt" type="fixed"', '"loose" type="floating"').replace(
                '<child link="plate"/>', '<child link="plate"/><mimic joint="motor"/>'
            )
        )
    followers = with_line('<mimic joint="motor"/>', RAIL)
    with pytest.raises(RobotFileError, match="'rail' mimics 'motor' and cannot be actuated"):
        parse_robot_text(followers.replace('<joint name="motor"/>', '<joint name="motor"/><joint name="rail"/>'))
    with pytest.raises(RobotFileError, match=r"'passive'.*mimics 'rail', which mimics 'motor'"):
        parse_robot_text(followers.replace(PASSIVE, f'{PASSIVE}<mimic joint="rail"/>'))


@pytest.mark.parametrize(("angle", "refused"), [(0.0, True), (4e-5, True), (5e-5, False)])
def test_axes_of_a_universal_joint_are_not_parallel(angle: float, refused: bool) -> None:
    """1 - cos of their angle is more than 1e-9."""
    axes = f'<axis xyz="0 0 -1"/><axis2 xyz="{math.sin(angle)!r} 0 {math.cos(angle)!r}"/>'
    cross = '<loop name="cross" type="universal"><predecessor link="ground"/><successor link="plate"/>'
    text = ROBOT.replace(cross, cross + axes)
    if refused:
        with pytest.raises(RobotFileError, match=r"the two axes of .*cross.* are parallel"):
            parse_robot_text(text)
    else:
        assert parse_robot_text(text).loops["cross"].axis == (0, 0, -1)
