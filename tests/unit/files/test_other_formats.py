"""Robots in formats of other tools are equal to the same robots in our format; their loops have MuJoCo's gaps."""

import re
from dataclasses import replace

import numpy as np
import pytest
from other_formats import (
    bushing,
    closing_joints,
    drake_ball,
    frames,
    gazebo_joint,
    loop_closures,
    mjcf,
    sdf,
    with_loops_as,
    words,
)

import kinetostatics as ks
from kinetostatics.cli import main as cli
from kinetostatics.description import Inertia, JointStiffness
from kinetostatics.exceptions import ArgumentError, PlatformMissingError, RobotFileError
from kinetostatics.files.bundled import package_folder

LOAD = (20.0, -5.0, -100.0, 1.0, 2.0, -3.0)


def assert_equal(found, robot):
    """Equal twists to 1e-12 at the zero pose, and equal actuator forces."""
    expected, result = (ks.analyze(each.assemble(), load=LOAD) for each in (robot, found))
    np.testing.assert_allclose(result.twist, expected.twist, rtol=0, atol=1e-12 * np.abs(expected.twist).max())
    assert found.description.actuated == robot.description.actuated and np.abs(expected.twist).max() > 1e-7
    for name in robot.description.actuated:
        assert result.actuator_forces[name] == pytest.approx(expected.actuator_forces[name], rel=1e-9, abs=1e-9)


def parts_of(robot, description):
    """The description read from a whole file, with the platform's frame and the elastic parts, which the file cannot have."""
    old = robot.description
    parts = {name: getattr(old, name) for name in ("platform_origin", "beams", "joint_stiffness", "springs", "flexible", "base")}
    return ks.Robot(replace(description, **parts))


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


STIFFNESSES = {
    "weld": ("five_bar", (1e5, 2e5, 3e5, 1e3, 2e3, 3e3)),
    "hinge": ("five_bar", (1e5, 2e5, 3e5, 1e3, 2e3, 0.0)),
    "cylinder": ("five_bar", (1e5, 2e5, 0.0, 1e3, 2e3, 0.0)),
    "ball": ("gough_stewart", (1e6, 2e6, 3e6, 0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("kind", STIFFNESSES)
def test_bushings_of_drake_are_elastic_joints(kind, tmp_path):
    """Free in the directions without stiffness, along and about the axes of the frame on the first link."""
    (name, stiffness), path = STIFFNESSES[kind], tmp_path / "robot.urdf"
    rigid = ks.load_robot(name).description
    types = {"weld": "fixed", "cylinder": "cylindrical", "ball": "spherical", "hinge": "continuous"}
    axis = (1.0, 0.0, 0.0) if kind in ("weld", "ball") else (0.0, 0.0, 1.0)
    free = {"type": types[kind], "axis": axis, "lower": -np.inf, "upper": np.inf, "cone": None}
    loops = {key: replace(loop, **free) for key, loop in rigid.loops.items()}
    elastic = {key: JointStiffness(key, stiffness[:3], stiffness[3:]) for key in loops}
    robot = ks.Robot(replace(rigid, loops=loops, joint_stiffness=elastic))
    with_loops_as(ks.Robot(rigid), path, lambda loop: bushing(loop, stiffness))
    name_ends(robot, path)
    found = ks.load_robot(path)
    assert {loop.type for loop in found.description.loops.values()} == {types[kind]}
    assert_equal(found, robot)
    with_loops_as(ks.Robot(rigid), path, lambda loop: bushing(loop, (0, 1, 1, 1, 1, 0)))
    name_ends(robot, path)
    with pytest.raises(RobotFileError, match="has no stiffness in directions that are together the freedoms of no joint type"):
        ks.load_robot(path)


def test_bushings_in_sdf_are_elastic_joints(tmp_path):
    (robot, path), stiffness = (ks.load_robot("gough_stewart"), tmp_path / "robot.sdf"), STIFFNESSES["ball"][1]
    text = sdf(robot.description)
    for name, loop in robot.description.loops.items():
        text = re.sub(rf'<joint name="{name}".*?</joint>', "", text, flags=re.DOTALL)
        origins = (("A", loop.predecessor, loop.predecessor_origin), ("C", loop.successor, loop.successor_origin))
        parts = [
            f'<frame name="{name}_{side}" attached_to="{link}"><pose>{words((*origin.xyz, *origin.rpy))}</pose></frame>'
            for side, link, origin in origins
        ]
        ends = "".join(f"<drake:bushing_frame{side}>{name}_{side}</drake:bushing_frame{side}>" for side in "AC")
        ends += f"<drake:bushing_torque_stiffness>{words(stiffness[3:])}</drake:bushing_torque_stiffness>"
        ends += f"<drake:bushing_force_stiffness>{words(stiffness[:3])}</drake:bushing_force_stiffness>"
        parts.append(f"<drake:linear_bushing_rpy>{ends}</drake:linear_bushing_rpy>")
        text = text.replace("</model>", f"{''.join(parts)}</model>")
    path.write_text(text.replace("<sdf ", '<sdf xmlns:drake="http://drake.mit.edu" '))
    description = ks.load_robot(path, platform_link=robot.description.platform).description
    values = {(each.linear, each.angular) for each in description.joint_stiffness.values()}
    assert len(description.joint_stiffness) == len(description.loops) == 5 and values == {(stiffness[:3], stiffness[3:])}


GEARED = """
<robot name="geared"><link name="frame"/><link name="ground"/><link name="motor"/><link name="arm"/>
  <joint name="lift" type="fixed"><parent link="frame"/><child link="ground"/></joint>
  <joint name="drive" type="continuous"><parent link="ground"/><child link="motor"/><axis xyz="0 0 1"/></joint>
  <joint name="output" type="continuous"><parent link="ground"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  COUPLING<platform link="arm"/><joint_stiffness joint="drive" drive="100"/>
  <transmission name="t"><joint name="drive"/></transmission></robot>"""


@pytest.mark.parametrize(("links", "ratio"), [(("motor", "arm"), -0.25), (("arm", "motor"), -4)])
def test_couplings_of_urdf_plus_are_ratios_of_joints(links, ratio, tmp_path):
    """An arm behind a gear of ratio four has the stiffness of its motor times sixteen: rz = M / (16 k)."""
    path = tmp_path / "robot.urdf"
    ends = f'<predecessor link="{links[0]}"/><successor link="{links[1]}"/>'
    text = GEARED.replace("COUPLING", f'<coupling name="gear" type="rolling">{ends}<ratio value="{ratio}"/></coupling>')
    path.write_text(text.replace('name="output"', 'name="output" independent="False"'))
    robot = ks.load_robot(path)
    mimic = robot.description.joints["output"].mimic
    assert (mimic.joint, mimic.multiplier) == ("drive", -0.25)
    assert ks.analyze(robot.assemble(), load=(0, 0, 0, 0, 0, 3)).twist[5] == pytest.approx(3 / (16 * 100), rel=1e-9)
    path.write_text(text.replace('<parent link="ground"/><child link="arm"/>', '<parent link="motor"/><child link="arm"/>'))
    with pytest.raises(RobotFileError, match=r"<coupling> 'gear' couples output; only the ratio of two joints can be read"):
        ks.load_robot(path)


@pytest.mark.parametrize("name", ["five_bar", "spherical_3rrr"])
@pytest.mark.parametrize("folder", ["urdf", "."])
def test_closing_joints_of_fusion2urdf_close_loops(name, folder, tmp_path):
    """Those joints are actuated that are not passive; a file without closing joints is of no meaning."""
    robot, path = ks.load_robot(name), tmp_path / "urdf" / "robot.urdf"
    path.parent.mkdir()
    with_loops_as(robot, path, lambda loop: "")
    path.write_text(re.sub("<transmission.*</transmission>", "", path.read_text(), flags=re.DOTALL))
    yaml = tmp_path / folder / "robot_data.yaml"
    yaml.write_text(closing_joints(robot))
    found = ks.load_robot(path)
    limits = [(loop.type, loop.lower, loop.upper) for loop in robot.description.loops.values()]
    assert [(loop.type, loop.lower, loop.upper) for loop in found.description.loops.values()] == limits
    assert_equal(found, robot)
    yaml.write_text(yaml.read_text().partition("closing_joints:")[0] + "closing_joints: []\n")
    with pytest.raises(RobotFileError):  # the beams of the file end at its loops
        ks.load_robot(path)


@pytest.mark.parametrize("name", ["five_bar", "spherical_3rrr"])
@pytest.mark.parametrize("folder", ["urdf", ".", "config"])
def test_loop_closures_of_exporters_close_loops(name, folder, tmp_path):
    """Beside the URDF, in the folder above or beside its folder. A <mimic> of a dependent joint is dropped."""
    robot, path = ks.load_robot(name), tmp_path / "urdf" / "robot.urdf"
    path.parent.mkdir()
    with_loops_as(robot, path, lambda loop: "")
    name_ends(robot, path)
    driven, link = robot.description.actuated[0], next(iter(robot.description.loops.values())).predecessor
    dependent = next(key for key, joint in robot.description.joints.items() if joint.child == link)
    mimic = f'<mimic joint="{driven}" multiplier="-1"/>'
    path.write_text(re.sub(f'(<joint name="{dependent}".*?)</joint>', rf"\1{mimic}</joint>", path.read_text(), flags=re.DOTALL))
    (tmp_path / folder).mkdir(exist_ok=True)
    (tmp_path / folder / "loop_closures.yaml").write_text(loop_closures(robot))
    found = ks.load_robot(path)
    assert mimic in path.read_text() and found.description.joints[dependent].mimic is None
    assert any("the loops are read from this file" in text for text in found.description.warnings)
    assert_equal(found, robot)
    (tmp_path / folder / "loop_closures.yaml").write_text(loop_closures(robot).replace("link_b: ", "link_b: x"))
    with pytest.raises(RobotFileError, match=r"loop_closures\.yaml:4: link_b is 'x.*', which is unknown; did you mean "):
        ks.load_robot(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="revolute">\n    <parent ', 'type="hinge">\n    <parent ', "has the type 'hinge'; known: "),
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
        ("<child>tool<", "<child>tol<", "refers to the frame 'tol', which does not exist; did you mean 'tool'"),
        ("<pose>", "<pose>a ", "of <joint> 'wrist' is wrong: 'a' is not a number"),
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
    ks.save_robot(robot, path)
    ours = re.sub("<transmission.*</transmission>", control, path.read_text(), flags=re.DOTALL)
    path.write_text(ours)
    assert_equal(ks.load_robot(path), robot)
    path.write_text(without)
    with pytest.raises(ArgumentError, match=r"lacks information; give also actuators, .*--actuators shoulder_1 shoulder_2"):
        ks.load_robot(path)


def test_unknown_dialects_are_errors(tmp_path):
    with pytest.raises(ArgumentError, match="dialect is 'sdf'; it is None or 'urdf-constraint'"):
        ks.save_robot(ks.load_robot("five_bar"), tmp_path / "robot.urdf", dialect="sdf")


@pytest.mark.parametrize("joint_frames", ["child", "model"])
@pytest.mark.parametrize("name", ["five_bar", "gough_stewart", "2pru_upr"])
def test_sdf_files_are_read(name, joint_frames, tmp_path):
    robot, path = ks.load_robot(name), tmp_path / "robot.sdf"
    for version in ("1.8", "1.11"):
        path.write_text(sdf(robot.description, joint_frames).replace('version="1.8"', f'version="{version}"'))
        description = ks.load_robot(path, platform_link=robot.description.platform).description
        assert_equal(parts_of(robot, description), robot)


def with_masses(robot):
    """The robot with a mass of each rod and cylinder, which MuJoCo needs."""
    inertia = Inertia((1e-3, 1e-4, -2e-4, 2e-3, 1e-4, 2.5e-3), (0.1, 0.2, 0.3))
    links = {
        name: replace(link, mass=0.3, center_of_mass=(0.01, 0.0, 0.1), inertia=inertia, has_inertial=True)
        if name[:3] in ("rod", "cyl")
        else link
        for name, link in robot.description.links.items()
    }
    return ks.Robot(replace(robot.description, links=links))


def test_mjcf_files_are_read(tmp_path):
    pytest.importorskip("mujoco")
    robot, path = with_masses(ks.load_robot("gough_stewart")), tmp_path / "robot.xml"
    path.write_text(mjcf(robot.description))
    description = ks.load_robot(path, platform_link=robot.description.platform).description
    assert_equal(parts_of(robot, description), robot)


def test_springs_of_passive_joints_in_mjcf_are_elastic(tmp_path):
    """A plate on a spring, which turns by M / k; springs that our format does not have are listed."""
    pytest.importorskip("mujoco")
    path = tmp_path / "spring.xml"
    plate = '<body name="plate"><joint name="h" axis="0 1 0" stiffness="40"/><geom size="0.1" mass="2"/>FURTHER</body>'
    further = '<body name="tip"><joint name="t" axis="0 1 1" stiffness="3"/><geom size="0.1"/></body>'
    path.write_text(f"<mujoco><worldbody>{plate.replace('FURTHER', further)}</worldbody></mujoco>")
    robot = ks.load_robot(path, platform_link="plate")
    assert robot.description.joint_stiffness["h"].angular == (np.inf, 40, np.inf)
    said = " ".join(robot.description.warnings)
    assert "springs of joints count as relaxed at each analysed pose (1 of them)" in said
    assert "springs of joints that are not along an axis of a body are ignored (1 of them)" in said
    path.write_text(f"<mujoco><worldbody>{plate.replace('FURTHER', '')}</worldbody></mujoco>")
    robot = ks.load_robot(path, platform_link="plate")
    assert ks.analyze(robot.assemble(), load=(0, 0, 0, 0, 3, 0)).twist[4] == pytest.approx(3 / 40, rel=1e-9)


def test_springs_of_sdf_are_elastic_but_those_of_actuated_joints(tmp_path):
    path, link = tmp_path / "spring.sdf", "<inertial><mass>2</mass></inertial>"
    axis = "<axis><xyz>0 1 0</xyz><dynamics><spring_stiffness>40</spring_stiffness></dynamics></axis>"
    joint = f'<joint name="h" type="revolute"><parent>world</parent><child>plate</child>{axis}</joint>'
    text = f'<sdf version="1.8"><model name="m"><link name="plate">{link}</link>{joint}</model></sdf>'
    path.write_text(text)
    robot = ks.load_robot(path, platform_link="plate")
    assert "springs of joints count as relaxed at each analysed pose (1 of them)" in " ".join(robot.description.warnings)
    assert ks.analyze(robot.assemble(), load=(0, 0, 0, 0, 3, 0)).twist[4] == pytest.approx(3 / 40, rel=1e-9)
    tip = joint.replace(">plate<", ">tip<").replace('"h"', '"other"').replace("world", "plate")
    driven = "<plugin filename='c'><joint_name>h</joint_name><joint_name>other</joint_name></plugin>"
    path.write_text(text.replace("</model>", f'<link name="tip">{link}</link>{tip}{driven}</model>'))
    description = ks.load_robot(path, platform_link="tip").description
    assert description.actuated == ("h", "other") and not description.joint_stiffness


def test_actuators_of_tendons_drive_the_joint_that_all_their_joints_follow(tmp_path):
    """As in Robotiq's gripper 2F-85 of MuJoCo's Menagerie."""
    pytest.importorskip("mujoco")
    finger = '<body name="{0}"><joint name="{0}" axis="0 0 1"/><geom size="0.1"/></body>'
    fingers = "".join(finger.format(name) for name in ("left", "right"))
    split = '<joint joint="left" coef="0.5"/><joint joint="right" coef="0.5"/>'
    path = tmp_path / "gripper.xml"
    path.write_text(
        f'<mujoco><worldbody><body name="palm">{fingers}</body></worldbody>'
        '<equality><joint joint1="right" joint2="left"/><connect body1="left" body2="right" anchor="0 0 0"/></equality>'
        f'<tendon><fixed name="split">{split}</fixed></tendon><actuator><motor tendon="split"/></actuator></mujoco>'
    )
    with pytest.raises(PlatformMissingError, match="as 'left' or 'right', or by"):  # not the palm, which is fixed to the world
        ks.load_robot(path)
    description = ks.load_robot(path, platform_link="right").description
    assert description.actuated == ("left",) and description.joints["right"].mimic.joint == "left"


def test_actuators_of_whole_files_are_asked_for_by_a_command_that_works(tmp_path, capsys):
    path, out = tmp_path / "robot.sdf", tmp_path / "robot.urdf"
    path.write_text(re.sub("<plugin.*?</plugin>", "", sdf(ks.load_robot("five_bar").description), flags=re.DOTALL))
    with pytest.raises(ArgumentError, match=r"give also platform_link, .*; actuators, none or some of ") as caught:
        ks.load_robot(path)
    command = str(caught.value).partition(" For example: kinetostatics ")[2].split()
    assert cli.main([*command[:-1], str(out)]) == 0
    assert ks.load_robot(out).description.actuated == ("shoulder_1", "shoulder_2")


GAPS = """
<mujoco model="gaps"><compiler angle="radian" autolimits="true"/><worldbody>
  <body name="base"><geom size="0.1"/>
    <body name="a" pos="0.1 0.2 0.3" quat="0.9 0.1 -0.3 0.2">
      <joint name="a1" axis="1 2 3" pos="0.01 0.02 0.03"/><joint name="a2" type="slide" axis="0 1 1" ref="0.1"/>
      <geom size="0.1" pos="0.1 0 0"/>
      <body name="a_tip" pos="0.4 0 0.1"><joint name="a3" axis="0 1 0" ref="0.3" range="-1 1"/><geom size="0.1"/>
        <site name="mark_a" pos="0.1 0.1 0" quat="0.5 0.5 -0.5 0.5"/></body>
    </body>
    <body name="b" pos="-0.3 0.1 0"><joint name="b1" axis="0 0 1"/><geom size="0.1"/><site name="mark_b" pos="0.2 0.3 0.1"/>
      <body name="b_tip" pos="0 0 0.2"><joint name="b2" axis="1 0 0"/><geom size="0.1"/></body></body>
  </body></worldbody>
  <equality><ENTRY/><joint joint1="b2" joint2="b1" polycoef="0.05 -2 0 0 0"/></equality>
  <tendon><fixed name="cable"><joint joint="a1" coef="1"/><joint joint="b1" coef="1"/></fixed></tendon>
  <actuator><motor joint="a1"/><position joint="b1" kp="10"/><motor tendon="cable" name="pull"/></actuator>
</mujoco>"""


@pytest.mark.parametrize(
    "entry",
    [
        'connect name="tip" body1="a_tip" body2="b" anchor="0.3 0.2 0.1"',
        'connect name="tip" site1="mark_a" site2="mark_b"',
        'weld name="tip" body1="a_tip" body2="b"',
        'weld name="tip" body1="a_tip" body2="b" anchor="0.1 0.2 0.3" relpose="0.2 -0.1 0.4 0.3 0.8 -0.1 0.5"',
        'weld name="tip" site1="mark_a" site2="mark_b"',
    ],
)
def test_gaps_of_loops_are_those_of_mujoco(entry, tmp_path):
    """Away from the pose of the file; MuJoCo's residual of a rotation is the vector part of its quaternion."""
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "gaps.xml"
    path.write_text(GAPS.replace("ENTRY", entry))
    description = ks.load_robot(path, platform_link="a_tip").description
    assert description.actuated == ("a1", "b1") and description.base == "world"
    said = " ".join(description.warnings)
    assert "tendons are ignored (1 of them)" in said and "the actuator pull drives no joint" in said
    assert (description.joints["a3"].lower, description.joints["a3"].upper) == (-1.3, 0.7)
    follower = description.joints["b2"].mimic
    assert (follower.joint, follower.multiplier, follower.offset) == ("b1", -2, 0.05)
    model = mujoco.MjModel.from_xml_path(str(path))
    state = mujoco.MjData(model)
    moved = {"a1": 0.2, "a2": -0.05, "a3": 0.15, "b1": 0.1, "b2": 0.05 - 2 * 0.1}
    for name, value in moved.items():
        state.joint(name).qpos = model.qpos0[model.joint(name).qposadr] + value
    mujoco.mj_forward(model, state)
    residual = state.efc_pos[state.efc_id == 0][: 3 if "connect" in entry else 6]
    (loop,) = description.loops.values()
    at = frames(description, moved)
    first, second = at[loop.predecessor] @ loop.predecessor_origin.matrix, at[loop.successor] @ loop.successor_origin.matrix
    np.testing.assert_allclose(first[:3, 3] - second[:3, 3], residual[:3], rtol=0, atol=1e-9)
    assert np.abs(residual).max() > 1e-2
    if loop.type == "fixed":
        import pinocchio

        between = pinocchio.Quaternion(np.ascontiguousarray(second[:3, :3].T @ first[:3, :3]))
        rotation = between.coeffs()[:3] * np.sign(between.coeffs()[3])
        np.testing.assert_allclose(np.linalg.norm(rotation), np.linalg.norm(residual[3:]), rtol=0, atol=1e-9)


CASSIE = package_folder("example-robot-data") / "robots" / "cassie_description" / "robots"


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["cassie_v2", "cassie_wo_gearbox_spring", "cassie_reduced", "cassie_simple"])
def test_public_sdf_files_pass_the_check(name, tmp_path, capsys):
    """Cassie's legs have two loops each. Without springs, those joints need actuators; three files hold the pelvis by a slide."""
    joints = ("roll-op", "yaw-op", "pitch-op", "knee-op", "foot-op", *(["knee-shin-joint"] if name.endswith("spring") else []))
    actuators = [f"{side}-{joint}" for side in ("left", "right") for joint in joints] + (
        ["static"] if name != "cassie_v2" else []
    )
    out = tmp_path / "robot.urdf"
    robot = ks.extend_robot(CASSIE / f"{name}.sdf", path=out, platform_link="left-foot", actuators=actuators)
    assert len(robot.description.loops) == 4 and robot.mobility.platform == 6
    springs = {f"{side}-{joint}-joint" for side in ("left", "right") for joint in ("knee-shin", "tarsus-spring")}
    assert set(robot.description.joint_stiffness) == (set() if name.endswith("spring") else springs)
    assert cli.main(["check", str(out)]) == 0, capsys.readouterr().out


def test_gearboxes_are_refused():
    with pytest.raises(RobotFileError, match=r"cassie\.sdf:130: <joint> 'left-roll-joint' has the type 'gearbox'"):
        ks.load_robot(CASSIE / "cassie.sdf")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</model>", '<model name="m"/></model>', "contains a <model>; write it as one model by: gz sdf -p"),
        ("</sdf>", '<model name="m"/></sdf>', "the file has 2 models"),
        ("<child>tool<", "<child>tol<", "refers to the frame 'tol', which does not exist"),
    ],
)
def test_wrong_sdf_files_are_errors(old, new, message, tmp_path):
    path = tmp_path / "robot.sdf"
    path.write_text(sdf(ks.load_robot("five_bar").description).replace(old, new))
    with pytest.raises(RobotFileError, match=message):
        ks.load_robot(path)


def test_files_without_platform_are_asked_for_by_commands(tmp_path, capsys):
    path = tmp_path / "robot.sdf"
    path.write_text(sdf(ks.load_robot("gough_stewart").description))
    assert cli.main(["check", str(path)]) == 2
    assert f"kinetostatics check {path} --platform-link platform" in capsys.readouterr().err
    out = tmp_path / "robot.urdf"
    assert cli.main(["new", "--from", str(path), "--platform-link", "platform", "--out", str(out)]) == 0
    assert "include" not in out.read_text() and len(ks.load_robot(out).description.loops) == 5
