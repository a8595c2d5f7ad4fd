"""Robots in formats of other tools are equal to the same robots in our format."""

import re
from dataclasses import replace

import numpy as np
import pytest
from other_formats import drake_ball, frames, gazebo_joint, loop_closures, with_loops_as, words

import kinetostatics as ks
from kinetostatics.exceptions import ArgumentError, RobotFileError

LOAD = (20.0, -5.0, -100.0, 1.0, 2.0, -3.0)


def assert_equal(found, robot):
    """Equal twists to 1e-12 at the zero pose, and equal actuator forces."""
    expected, result = (ks.analyze(each.assemble(), load=LOAD) for each in (robot, found))
    np.testing.assert_allclose(result.twist, expected.twist, rtol=0, atol=1e-12 * np.abs(expected.twist).max())
    assert found.description.actuated == robot.description.actuated and np.abs(expected.twist).max() > 1e-7
    for name in robot.description.actuated:
        assert result.actuator_forces[name] == pytest.approx(expected.actuator_forces[name], rel=1e-9, abs=1e-9)


def name_ends(robot, path):
    """Let beams end at loops without names, which are called by their two links."""
    text = path.read_text()
    for loop in robot.description.loops.values():
        text = text.replace(f'"{loop.name}"', f'"{loop.predecessor}_{loop.successor}"')
    path.write_text(text)


@pytest.mark.parametrize("name", ["five_bar", "3rps", "gough_stewart", "2pru_upr", "linear_delta", "spherical_3rrr"])
def test_constraints_are_written_and_read(name, tmp_path):
    robot, path = ks.load_robot(name), tmp_path / "robot.urdf"
    ks.save_robot(robot, path, dialect="urdf-constraint")
    text = path.read_text()
    assert text.count("<constraint ") == len(robot.description.loops) and "<loop" not in text
    found = ks.load_robot(path)
    loops = [replace(loop, cone=None) for loop in robot.description.loops.values()]
    assert list(found.description.loops.values()) == loops
    assert_equal(found, robot)


@pytest.mark.parametrize("name", ["five_bar", "gough_stewart", "2pru_upr"])
def test_joints_in_the_tag_of_gazebo_close_loops(name, tmp_path):
    robot, path = ks.load_robot(name), tmp_path / "robot.urdf"
    with_loops_as(robot, path, lambda loop: gazebo_joint(loop, frames(robot.description)))
    found = ks.load_robot(path)
    assert set(found.description.loops) == set(robot.description.loops)
    assert_equal(found, robot)


def test_ball_constraints_of_drake_close_loops(tmp_path):
    robot, path = ks.load_robot("gough_stewart"), tmp_path / "robot.urdf"
    with_loops_as(robot, path, drake_ball)
    name_ends(robot, path)
    assert_equal(ks.load_robot(path), robot)


@pytest.mark.parametrize("folder", ["urdf", ".", "config"])
def test_loop_closures_of_exporters_close_loops(folder, tmp_path):
    """Beside the URDF, in the folder above or beside its folder. A <mimic> of a dependent joint is dropped."""
    robot, path = ks.load_robot("five_bar"), tmp_path / "urdf" / "robot.urdf"
    path.parent.mkdir()
    with_loops_as(robot, path, lambda loop: None)
    name_ends(robot, path)
    mimic = '<mimic joint="shoulder_1" multiplier="-1"/>'
    path.write_text(re.sub('(<joint name="elbow_1".*?)</joint>', rf"\1{mimic}</joint>", path.read_text(), flags=re.DOTALL))
    (tmp_path / folder).mkdir(exist_ok=True)
    (tmp_path / folder / "loop_closures.yaml").write_text(loop_closures(robot))
    found = ks.load_robot(path)
    assert mimic in path.read_text() and found.description.joints["elbow_1"].mimic is None
    assert any("the loops are read from this file" in text for text in found.description.warnings)
    assert_equal(found, robot)
    (tmp_path / folder / "loop_closures.yaml").write_text(loop_closures(robot).replace("link_b: tool", "link_b: tol"))
    with pytest.raises(
        RobotFileError, match=r"loop_closures\.yaml:4: link_b is 'tol', which does not exist; did you mean 'tool'"
    ):
        ks.load_robot(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="revolute">\n    <parent ', 'type="hinge">\n    <parent ', "has the type 'hinge', which is unknown; known: "),
        ("<child_axis", "<child_axi", "<child_axi> does not belong in <constraint> 'wrist'; did you mean 'child_axis'"),
        ('<child_axis xyz="0 0 1"', '<child_axis xyz="0 1 0"', "is revolute, and its axis differs in its two frames"),
        (
            '<child link="tool"/>\n    <child_',
            '<child link="tol"/>\n    <child_',
            "the link 'tol', which does not exist; did you mean 'tool'",
        ),
    ],
)
def test_wrong_constraints_are_errors(old, new, message, tmp_path):
    robot, path = ks.load_robot("five_bar"), tmp_path / "robot.urdf"
    ks.save_robot(robot, path, dialect="urdf-constraint")
    text = path.read_text().replace("    <limit", '    <child_axis xyz="0 0 1"/>\n    <limit')
    head, tag, tail = text.partition("<constraint")
    assert old in tail
    path.write_text(head + tag + tail.replace(old, new, 1))
    with pytest.raises(RobotFileError, match=message):
        ks.load_robot(path)


def test_axes_of_gazebo_joints_may_be_those_of_the_model(tmp_path):
    """As in files for older versions; a gearbox and unknown links are errors."""
    robot, path = ks.load_robot("five_bar"), tmp_path / "robot.urdf"
    at = frames(robot.description)
    with_loops_as(robot, path, lambda loop: gazebo_joint(loop, at))
    text = path.read_text()
    (loop,) = robot.description.loops.values()
    axis = (at[loop.predecessor] @ loop.predecessor_origin.matrix)[:3, :3] @ loop.axis
    old = re.search("<axis>.*?</axis>", text)[0]
    for new in (
        f"<axis><xyz>{words(axis)}</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>",
        f'<axis><xyz expressed_in="__model__">{words(axis)}</xyz></axis>',
        f'<axis><xyz expressed_in="tool">{words(at["tool"][:3, :3].T @ axis)}</xyz></axis>',
    ):
        path.write_text(text.replace(old, new))
        assert_equal(ks.load_robot(path), robot)
    for old, new, message in (
        ('type="revolute"><parent>', 'type="gearbox"><parent>', "has the type 'gearbox', which is not read"),
        ("<child>tool<", "<child>tol<", "refers to the link 'tol'; did you mean 'tool'"),
        ("<pose>", "<pose>a ", "pose=.* of .* is wrong: 'a' is not a number"),
    ):
        assert old in text
        path.write_text(text.replace(old, new))
        with pytest.raises(RobotFileError, match=message):
            ks.load_robot(path)


def test_actuators_may_be_those_of_ros2_control(tmp_path):
    robot, path = ks.load_robot("five_bar"), tmp_path / "robot.urdf"
    ks.save_robot(robot, path, dialect="urdf-constraint")
    joints = "".join(f'<joint name="{name}"><command_interface name="effort"/></joint>' for name in robot.description.actuated)
    measured = '<joint name="elbow_1"><state_interface name="position"/></joint>'
    control = f'<ros2_control name="c" type="system">{joints}{measured}</ros2_control>'
    without = re.sub("<transmission.*</transmission>", "", path.read_text(), flags=re.DOTALL)
    path.write_text(without.replace("</robot>", f"{control}</robot>"))
    assert_equal(ks.load_robot(path), robot)
    path.write_text(without)
    with pytest.raises(ArgumentError, match=r"lacks information; give also actuators, .*--actuators shoulder_1 shoulder_2"):
        ks.load_robot(path)


def test_unknown_dialects_are_errors(tmp_path):
    with pytest.raises(ArgumentError, match="dialect is 'sdf'; it is None or 'urdf-constraint'"):
        ks.save_robot(ks.load_robot("five_bar"), tmp_path / "robot.urdf", dialect="sdf")
