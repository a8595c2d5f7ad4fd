"""URDFs that were not written for this package: platform and base by argument, actuators, and harmless mistakes."""

import shlex

import numpy as np
import pinocchio as pin
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.description import RobotDescription

WEIGHT = '<inertial><origin xyz="0.3 0.01 -0.02"/><mass value="2"/>{}</inertial>'
INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
HEAVY = WEIGHT.format(INERTIA)
LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="1"/>'
ARM = f"""<robot name="arm">
  <link name="world"/>
  <link name="foot"/>
  <link name="upper">{HEAVY}</link>
  <link name="lower">{HEAVY}</link>
  <link name="hand">{HEAVY}</link>
  <link name="tool"/>
  <link name="camera"/>
  <joint name="mount" type="fixed"><parent link="world"/><child link="foot"/></joint>
  <joint name="one" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 1 0"/>{LIMIT}</joint>
  <joint name="two" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.6 0 0" rpy="0.2 0 0"/><axis xyz="0 1 0"/>{LIMIT}
  </joint>
  <joint name="three" type="prismatic">
    <parent link="lower"/><child link="hand"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>{LIMIT}
  </joint>
  <joint name="flange" type="fixed"><parent link="hand"/><child link="tool"/><origin xyz="0 0 0.1"/></joint>
  <joint name="eye" type="fixed"><parent link="upper"/><child link="camera"/></joint>
</robot>
"""
END = "</robot>"


@pytest.fixture
def write(tmp_path):
    def written(text: str = ARM, name: str = "arm.urdf"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return written


def read(path, **links) -> RobotDescription:
    return ks.load_robot(path, **{"platform_link": "tool", **links}).description


def test_actuator_forces_of_an_arm_equal_pinocchio(write) -> None:
    """Pinocchio reads the same file."""
    path = write()
    pose = ks.load_robot(path, platform_link="tool").assemble(actuators={"one": 0.4, "two": -0.9, "three": 0.05})
    result = ks.analyze(pose)
    model = pin.buildModelFromUrdf(str(path))
    torques = pin.computeGeneralizedGravity(model, model.createData(), np.array([0.4, -0.9, 0.05]))
    np.testing.assert_allclose([result.actuator_forces[name] for name in ("one", "two", "three")], torques, rtol=1e-12)
    assert not result.twist.any()


def test_missing_platform_error_suggests_working_commands(write, capsys) -> None:
    path = str(write())
    named = "platform_link, as 'tool' or 'camera', or by <platform"
    with pytest.raises(ks.exceptions.PlatformMissingError, match=named) as caught:
        ks.load_robot(path)
    assert caught.value.likely == ("tool", "camera")
    for command in ("check", "analyze", "new --out mine.urdf.xacro --from"):
        assert main([*command.split(), path]) == 2
        first, *offers = capsys.readouterr().err.splitlines()
        assert first == f"kinetostatics: error: {path}: the file does not say which link is the platform; likely ones:"
        assert offers == [f"  kinetostatics {command} {path} --platform-link {link}" for link in ("tool", "camera")]
    assert main(shlex.split(offers[0].replace("mine", f"{path}_mine"))[1:]) == 0
    assert main(["view", "five_bar", "--compare", path, "--html", f"{path}.html"]) == 2
    assert "kinetostatics view" not in capsys.readouterr().err  # --platform-link is the first robot's
    assert main(["analyze", path, "--platform-link", "hand", "--base-link", "upper"]) == 0
    assert main(["check", path, "--platform-link", "tol"]) == 2
    assert "did you mean 'tool'" in capsys.readouterr().err


def test_only_end_link_is_the_platform_and_hand_precedes_fingers(write) -> None:
    one = ARM.replace('<link name="camera"/>', "").replace(ARM[ARM.index('  <joint name="eye"') : ARM.index(END)], "")
    robot = ks.load_robot(write(one))
    assert robot.description.platform == "tool" and "it is 'tool', the only link at an end" in robot.warnings[0]
    expected = ks.analyze(ks.load_robot(write(one), platform_link="tool").assemble())
    np.testing.assert_array_equal(ks.analyze(robot.assemble()).compliance, expected.compliance)
    assert ks.analyze(robot.assemble()).actuator_forces == expected.actuator_forces
    fingers = "".join(
        f'<link name="{name}"/><joint name="{name}_" type="prismatic"><parent link="{{}}"/><child link="{name}"/>{LIMIT}</joint>'
        for name in ("left", "right")
    )
    for link, likely in (("hand", ("tool", "right", "left")), ("tool", ("tool", "right", "left"))):
        with pytest.raises(ks.exceptions.PlatformMissingError) as caught:
            ks.load_robot(write(ARM.replace(END, fingers.format(link, link) + END)))
        assert caught.value.likely == likely


def test_platform_and_base_arguments_override_the_file(write) -> None:
    ours = write(ARM.replace(END, '<base link="foot"/><platform link="tool"><origin xyz="1 2 3"/></platform>' + END), "ours.urdf")
    theirs = ks.load_robot(ours, platform_link="lower", base_link="upper").description
    assert (theirs.platform, theirs.base, theirs.platform_origin.xyz) == ("lower", "upper", (0.0, 0.0, 0.0))
    assert theirs.actuated == ()  # the file has a platform: without <transmission> nothing is actuated
    with pytest.raises(ks.RobotFileError, match="both base and platform"):
        ks.load_robot(ours, platform_link="foot")
    for argument in ("platform_link", "base_link"):
        with pytest.raises(ks.ArgumentError, match=f"{argument}='uper': .* no such link; did you mean 'upper'"):
            ks.load_robot(ours, **{argument: "uper"})


def test_joints_without_transmission_are_actuated_with_a_warning(write) -> None:
    nothing = read(write())
    assert nothing.actuated == ("one", "two", "three")
    assert [text.partition(": ")[2] for text in nothing.warnings] == [
        "the file has no <transmission>; all 3 joints that move count as actuated."
    ]
    some = read(write(ARM.replace(END, '<transmission name="t"><joint name="two"/></transmission>' + END)))
    assert some.actuated == ("two", "one", "three")
    assert some.warnings[0].endswith("joints without a <transmission> count as actuated like the others: 'one', 'three'.")
    every = "".join(f'<transmission name="{name}"><joint name="{name}"/></transmission>' for name in ("one", "two", "three"))
    assert read(write(ARM.replace(END, every + END))).warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<robot name="arm">', "<robot>", "<robot> has no name; it is called 'arm', like its file"),
        ('<child link="tool"/>', '<child link="tool"/><mimic joint="one"/>', "<mimic> of <joint> 'flange' is ignored"),
        (END, f'<transmission name="t"><joint name="eye"/></transmission>{END}', "the <transmission> of 'eye' is ignored"),
        (END, f'<transmission name="t"><joint name="nine"/></transmission>{END}', "'nine', which does not exist"),
        (LIMIT, f'{LIMIT}<mimic joint="nine"/>', "<mimic> of <joint> 'one' refers to the joint 'nine', which does not exist"),
    ],
)
def test_harmless_mistakes_in_a_tree_are_warnings(old, new, said, write) -> None:
    """The forces equal those of the file without the mistake."""
    right, odd = (ks.load_robot(write(text), platform_link="tool") for text in (ARM, ARM.replace(old, new, 1)))
    (warning,) = [text for text in odd.description.warnings if "as actuated" not in text]
    assert said in warning
    assert dict(ks.analyze(odd.assemble()).actuator_forces) == dict(ks.analyze(right.assemble()).actuator_forces)


def test_mistakes_in_transmissions_and_mimic_are_errors_with_loops(write) -> None:
    loop = '<platform link="tool"/><loop name="l" type="spherical"><predecessor link="foot"/><successor link="tool"/></loop>'
    for text in ('<transmission name="t"><joint name="nine"/></transmission>', '<transmission name="t"/>'):
        with pytest.raises(ks.RobotFileError):
            ks.load_robot(write(ARM.replace(END, loop + text + END)))
    with pytest.raises(ks.RobotFileError, match="does not exist"):
        ks.load_robot(write(ARM.replace(LIMIT, f'{LIMIT}<mimic joint="nine"/>', 1).replace(END, loop + END)))


@pytest.mark.parametrize(("kind", "axis"), [("floating", ""), ("planar", '<axis xyz="0 0 1"/>')])
def test_robot_on_a_floating_joint_has_its_foot_as_base(kind, axis, write) -> None:
    mount = '<joint name="mount" type="fixed"><parent link="world"/><child link="foot"/>'
    floating = write(ARM.replace(mount, mount.replace("fixed", kind) + axis))
    robot = ks.load_robot(floating, platform_link="tool")
    assert robot.description.base == "foot"
    expected = ks.analyze(ks.load_robot(write(), platform_link="tool").assemble()).actuator_forces
    for name, force in ks.analyze(robot.assemble()).actuator_forces.items():
        assert force == pytest.approx(expected[name], rel=1e-12)


def test_sweep_accepts_the_platform_link(write, tmp_path) -> None:
    head = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="length" default="1"/>'
    path = write(ARM.replace("0.6 0 0", "$(arg length) 0 0").replace('<robot name="arm">', head), "arm.urdf.xacro")
    fixed = {"one": 0.1, "two": 0.0, "three": 0.0}
    found = ks.sweep(path, actuators=fixed, parameters={"length": [0.6, 0.7]}, platform_link="tool", workers=1, progress=False)
    pose = ks.load_robot(path, {"length": 0.7}, platform_link="tool").assemble(actuators=fixed)
    value = float(found["actuator_force"].sel(length=0.7, actuator="one"))
    assert value == pytest.approx(ks.analyze(pose).actuator_forces["one"], rel=1e-12)
    with pytest.raises(ks.ArgumentError, match="platform_link and base_link need the robot's file"):
        ks.sweep(ks.load_robot(path, platform_link="tool"), actuators=fixed, platform_link="tool")
