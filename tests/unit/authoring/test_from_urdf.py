"""Plain URDFs extended by a small xacro: its text, and the deflection of the loaded robot."""

import re
import shlex
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics.authoring.from_urdf import extension
from kinetostatics.cli.main import main

WEIGHT = (
    '<inertial><origin xyz="0.3 0 0"/><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
)
LIMIT = '<limit lower="-2" upper="2" effort="{}" velocity="1"/>'
#: two links of 0.6 and 0.5 m along X, hinges about Y, a camera on the side of the first
ARM = f"""<robot name="arm">
  <link name="foot"/>
  <link name="upper">{WEIGHT.format(2)}</link>
  <link name="lower">{WEIGHT.format(0)}</link>
  <link name="hand"/>
  <link name="tool"/>
  <link name="camera"/>
  <joint name="one" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 1 0"/>{LIMIT.format(50)}</joint>
  <joint name="two" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.6 0 0"/><axis xyz="0 1 0"/>{LIMIT.format(20)}
  </joint>
  <joint name="three" type="prismatic">
    <parent link="lower"/><child link="hand"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>{LIMIT.format(0)}
  </joint>
  <joint name="flange" type="fixed"><parent link="hand"/><child link="tool"/></joint>
  <joint name="eye" type="fixed"><parent link="upper"/><child link="camera"/><origin xyz="0 0 0.1"/></joint>
</robot>
"""
LOAD = [0.0, 0.0, -100.0, 0.0, 0.0, 0.0]
EXAMPLE = {"platform_link": "tool", "elastic": {"upper": "tube 60mm 50mm steel"}, "joint_stiffness": {"two": 3e4}}


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    return path


def extension_text(path, **options):
    return extension(str(path), "", **options)[0]


def analyzed(robot, **options):
    return ks.analyze(robot.assemble(), **{"gravity": (0, 0, 0), "load": LOAD, **options})


def test_arm_deflection_equals_cantilever_and_spring(arm) -> None:
    """A bent upper arm with force and moment at its end, shear included, and the gear of the elbow."""
    result = analyzed(ks.extend_robot(arm, **EXAMPLE))
    section, modulus, shear = ks.sections.Tube.of(0.06, 0.05), 210e9, 210e9 / 2.6
    (kappa, _), near, far, force = section.shear_coefficients(0.3), 0.6, 0.5, 100.0
    moment = force * far
    stiffness = modulus * section.I_y
    end = force * near**3 / (3 * stiffness) + moment * near**2 / (2 * stiffness) + force * near / (kappa * shear * section.area)
    slope = force * near**2 / (2 * stiffness) + moment * near / stiffness
    gear = moment / 3e4
    assert result.twist[2] == pytest.approx(-(end + (slope + gear) * far), rel=1e-10)
    assert result.twist[4] == pytest.approx(slope + gear, rel=1e-10)
    assert set(result.source_contributions["beams"]) == {"upper"} and set(result.source_contributions["actuators"]) == {"two"}


def test_one_link_arm_bends_between_joint_and_tool(tmp_path) -> None:
    """A cantilever under a load at its end."""
    path = tmp_path / "one.urdf"
    tool = '<joint name="tip" type="fixed"><parent link="upper"/><child link="tool"/><origin xyz="0.6 0 0"/></joint>'
    head = ARM[: ARM.index('  <link name="lower"')] + re.search(r'  <joint name="one".*\n', ARM)[0]
    path.write_text(f'{head}<link name="tool"/>{tool}</robot>')
    result = analyzed(ks.extend_robot(path, elastic={"upper": "tube 60mm 50mm steel"}))
    section = ks.sections.Tube.of(0.06, 0.05)
    kappa = section.shear_coefficients(0.3)[0]
    bent = 100 * 0.6**3 / (3 * 210e9 * section.I_y) + 100 * 0.6 / (kappa * 210e9 / 2.6 * section.area)
    assert result.twist[2] == pytest.approx(-bent, rel=1e-10) and set(result.beams) == {"upper"}
    assert not any("no mass" in text for text in result.warnings)  # of a tool, which need not have one
    path.write_text(f"{head}</robot>")
    for elastic in ({"upper": "tube 60mm 50mm steel"}, "suggested"):
        with pytest.raises(ks.ArgumentError, match="'upper' is the platform, which is rigid; end it in a link") as caught:
            ks.extend_robot(path, elastic=elastic)
    said = re.search(r"<link .*</joint>", str(caught.value))[0].replace("X Y Z", "0.6 0 0")
    path.write_text(f"{head}{said}</robot>")
    assert analyzed(ks.extend_robot(path, elastic={"upper": "tube 60mm 50mm steel"})).twist[2] == pytest.approx(-bent, rel=1e-10)


@pytest.mark.parametrize(("mass", "outer"), [(0.05, 0.01), (20.0, 0.12), (90.0, None)])
def test_suggested_tubes_are_slender_and_not_too_heavy(mass, outer, arm) -> None:
    arm.write_text(ARM.replace(WEIGHT.format(2), WEIGHT.format(mass)))
    if outer is None:
        with pytest.raises(ks.ArgumentError, match="no link of the file has the data of a beam"):
            ks.extend_robot(arm, platform_link="tool", elastic="suggested")
        return
    robot = ks.extend_robot(arm, platform_link="tool", elastic="suggested")
    assert robot.description.beams["upper"].section.outer_diameter == outer
    assert not [text for text in robot.warnings if "beam upper" in text]


def test_original_is_included_unchanged_and_nothing_overwritten(arm, tmp_path) -> None:
    (tmp_path / "sub").mkdir()
    path = tmp_path / "sub" / "mine.urdf.xacro"
    made = ks.extend_robot(arm, path, **EXAMPLE)
    text = path.read_text()
    assert '<xacro:include filename="../arm.urdf"/>' in text and arm.read_text() == ARM
    assert analyzed(ks.load_robot(path)).twist == pytest.approx(analyzed(made).twist, rel=1e-14)
    assert made.description == ks.load_robot(path).description
    with pytest.raises(ks.ArgumentError, match="exists and is not overwritten"):
        ks.extend_robot(arm, path, **EXAMPLE)
    assert made.description.actuated == ("one", "two", "three")
    assert ks.extend_robot(arm, platform_link="tool", actuators=["two"]).description.actuated == ("two",)


def test_uncommented_suggestions_equal_the_suggested_options(arm, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = extension_text(arm, platform_link="tool")
    assert "upper: 0.6 m between its joints, 2 kg" in text and "lower" not in text  # which weighs nothing
    assert '<joint_stiffness joint="one" drive="10000"/> effort 50 N m' in text
    assert '<joint_stiffness joint="two" drive="4000"/> effort 20 N m' in text and 'joint="three" actuator' not in text
    ET.fromstring(text)
    without = re.sub(r"<!-- [^<]*(<(beam|joint_stiffness).*?(</beam>|/>))[^<]*-->", r"\1", text, flags=re.DOTALL)
    path = tmp_path / "taken.urdf.xacro"
    path.write_text(without)
    taken = ks.load_robot(path)
    suggested = ks.extend_robot(arm, platform_link="tool", elastic="suggested", joint_stiffness="suggested")
    assert list(taken.description.beams) == ["upper"] and list(taken.description.joint_stiffness) == ["one", "two"]
    np.testing.assert_allclose(analyzed(taken).twist, analyzed(suggested).twist, rtol=1e-14)
    beam = taken.description.beams["upper"].section
    assert beam.area * 2700 * 0.6 == pytest.approx(2, rel=0.05)  # the link's mass, to two digits of the diameter


def test_massless_link_gets_the_density_of_its_material(arm) -> None:
    robot = ks.extend_robot(arm, platform_link="tool", elastic={"lower": "rectangular_tube 90mm 70mm 8mm aluminium"})
    beam = robot.description.beams["lower"]
    assert beam.density == 2700 and beam.y_axis == (0, 1, 0)
    weight = -ks.analyze(robot.assemble()).base_wrench[2] / -9.81
    assert weight == pytest.approx(2 + 2700 * beam.section.area * 0.5, rel=1e-12)


def test_platform_base_and_actuators_of_the_file_are_kept(arm) -> None:
    end = '<platform link="tool"/><base link="foot"/><transmission name="t"><joint name="one"/></transmission></robot>'
    arm.write_text(ARM.replace("</robot>", end))
    text = extension_text(arm)
    assert "<platform" not in text and "<base" not in text
    assert re.findall(r'<transmission name="drive_(\w+)"', text) == ["two", "three"]
    for argument in ("platform_link", "base_link"):
        with pytest.raises(ks.ArgumentError, match=f"names its {argument[:-5]} already"):
            extension_text(arm, **{argument: "upper"})


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"elastic": {"hand": "circle 20mm"}}, "'hand' is not between two moving joints .* these are: 'upper', 'lower'"),
        ({"elastic": {"upper": "tube 20mm"}}, "elastic, upper: .* a tube has 2"),
        ({"elastic": "all"}, "elastic is 'all'; it is 'suggested', or sections by link"),
        ({"joint_stiffness": {"too": 1e4}}, "joint_stiffness: no actuator 'too': did you mean 'two'"),
        ({"joint_stiffness": {"two": -1.0}}, "joint_stiffness of 'two' is -1.0; it must be a number greater than zero"),
        ({"actuators": "two"}, "actuators is 'two'; it must be a sequence of names"),
    ],
)
def test_wrong_arguments_are_errors(options, said, arm) -> None:
    with pytest.raises(ks.ArgumentError, match=said):
        ks.extend_robot(arm, **{"platform_link": "tool", **options})


# ---- on the command line -----------------------------------------------------------------------------------------------


def test_new_from_command_equals_extend_robot(arm, tmp_path, capsys) -> None:
    out = tmp_path / "mine.urdf.xacro"
    command = ["new", "--from", str(arm), "--platform-link", "tool", "--elastic", "upper=tube 60mm 50mm steel"]
    assert main([*command, "--joint-stiffness", "two=30kNm/rad", "--out", str(out)]) == 0
    assert f"{out}: platform tool, base foot, actuated: one, two, three; elastic: upper, two" in capsys.readouterr().out
    assert ks.load_robot(out).description == ks.extend_robot(arm, **EXAMPLE).description
    assert main(["new", "--from", str(arm), "--platform-link", "tool", "--joint-stiffness", "suggested"]) == 0
    assert 'drive="10000"' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "does not say which link is the platform; likely ones:\n .* --platform-link tool"),
        (["3-RPS"], "give an architecture or --from, not both"),
        (["--platform-link", "tool", "--height", "1"], "--height is for an architecture, and not for --from"),
    ],
)
def test_new_from_command_reports_wrong_arguments(arguments, said, arm, capsys) -> None:
    assert main(["new", "--from", str(arm), *arguments]) == 2
    assert re.search(said, capsys.readouterr().err)


#: A finger on either side of the tool, 0.1 kg each; the second follows the first.
GRIPPER = "".join(
    f'<link name="{name}">{WEIGHT.format(0.1).replace("0.3 0 0", "0 0 0")}</link>'
    f'<joint name="{name}_slide" type="prismatic"><parent link="tool"/><child link="{name}"/><axis xyz="0 {side} 0"/>'
    f"{LIMIT.format(5)}{follows}</joint>"
    for name, side, follows in (("left", 1, ""), ("right", -1, '<mimic joint="left_slide"/>'))
)


def test_joints_outside_the_chain_are_locked_actuators(arm, tmp_path, capsys) -> None:
    arm.write_text(ARM.replace("</robot>", f"{GRIPPER}</robot>"))
    out = tmp_path / "mine.urdf.xacro"
    options = ["--platform-link", "tool", "--elastic", "upper=tube 60mm 50mm steel", "--actuators", "one", "two", "three"]
    assert main(["new", "--from", str(arm), *options, "--out", str(out)]) == 0
    text = out.read_text()
    head, tail = text.split("locked joints outside the chain")
    assert "left_slide" not in head and '<joint name="left_slide"/>' in tail and "right_slide" not in text
    robot = ks.load_robot(out)
    assert robot.description.actuated == ("one", "two", "three", "left_slide") and robot.actuators_outside_limbs == (
        "left_slide",
    )
    drives = {"one": 0.1, "two": [0.2, 0.3], "three": 0.0}
    result = ks.analyze(robot.assemble(actuators=drives))
    whole = ks.analyze(robot.assemble(actuators={**drives, "left_slide": 0.0}))
    np.testing.assert_array_equal(result.twist, whole.twist)
    assert result.contributions["platform_weight"][0, 2] < 0, "the fingers weigh"
    words = "analyze --actuators one=0.1 two=0.2 three=0".split()
    assert main([words[0], str(out), *words[1:]]) == 0
    assert "left_slide 0 mm" in capsys.readouterr().out
    with pytest.raises(ks.exceptions.CoordinatesError, match="actuator values are missing for two"):
        robot.assemble(actuators={"one": 0.0, "three": 0.0, "left_slide": 0.0})


def test_unactuated_joint_of_the_chain_stays_passive(arm) -> None:
    passive = GRIPPER.replace('<mimic joint="left_slide"/>', "")
    arm.write_text(ARM.replace("</robot>", f"{passive}</robot>"))
    made = ks.extend_robot(arm, platform_link="tool", actuators=["two"])
    assert made.description.actuated == ("two", "left_slide", "right_slide")
    both = ks.extend_robot(arm, platform_link="left", actuators=["two", "three", "one"])  # left_slide is in the chain
    assert both.description.actuated == ("two", "three", "one", "right_slide")


def test_rigid_robot_warning_suggests_working_commands(arm, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    pose = "--platform-link tool --actuators one=10deg two=-20deg three=0 --load 0 0 -100 0 0 0".split()
    assert main(["analyze", "arm.urdf", *pose]) == 0
    first, *commands = capsys.readouterr().out.splitlines()[:3]
    assert first.startswith("! nothing is elastic, so nothing sags")
    assert commands[0].endswith("--elastic suggested --joint-stiffness suggested --out arm_elastic.urdf.xacro")
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0
    assert "nothing is elastic" not in capsys.readouterr().out
    assert main(["analyze", "arm.urdf", *pose]) == 0
    assert "arm_elastic_2.urdf.xacro" in capsys.readouterr().out
    arm.write_text(re.sub(r'effort="\d+"', 'effort="0"', ARM))
    assert main(["analyze", "arm.urdf", *pose]) == 0
    assert "--platform-link tool --elastic suggested --out" in capsys.readouterr().out
    bare = re.sub(r'(effort|<mass value)="[\d.]+"', r'\1="0"', ARM)
    arm.write_text(bare.replace("</robot>", f"{GRIPPER}</robot>"))  # a finger that yields moves no tool
    assert main(["analyze", "arm.urdf", *pose]) == 0
    assert "links get a <beam>, actuators a <joint_stiffness>" in capsys.readouterr().out
