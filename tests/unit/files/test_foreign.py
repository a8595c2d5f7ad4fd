"""Loops of onshape-to-robot, Gepetto and Isaac Sim: the robot equals one in our format; missing information is asked for."""

import re
import shlex
import shutil

import numpy as np
import pytest
from places import ROOT, TESTS

import kinetostatics as ks
from kinetostatics.cli import main as cli
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.foreign_robot import _source
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.files.xacro import read_document

FOREIGN = TESTS / "foreign"
FIVE_BAR = FOREIGN / "five_bar_onshape.urdf"
FOUR_BAR = FOREIGN / "four_bar_isaac.urdf"
GEPETTO = FOREIGN / "five_bar_gepetto.urdf", FOREIGN / "five_bar_gepetto.yaml"
RRS = FOREIGN / "3rrs_gepetto.urdf", FOREIGN / "3rrs_gepetto.yaml"
HINGE = {"types": "revolute", "platform_link": "tool", "actuators": ["motor_1", "motor_2"]}


def described(source, yaml=None, **options):
    return ks.extend_robot(source, yaml=yaml, **options).description


def source_of(path):
    return _source(str(path), read_document(path.read_bytes(), str(path), {})[0])


def inertial(mass, *com):
    inertia = 'ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"'
    xyz = " ".join(map(repr, com))
    return f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia {inertia}/></inertial>'


def beams(*links):
    rest = 'youngs_modulus="70e9" poisson_ratio="0.3" density="2700"><tube outer_diameter="0.03" inner_diameter="0.024"/></beam>'
    return "".join(f'<beam link="{link}" {rest}' for link in links)


def elastic(made, *links):
    """The robot with elastic links; the links that mark frames, which weigh 1e-9 kg, weigh nothing."""
    text = re.sub('value="1e-0?9"', 'value="0"', made.urdf.replace("</robot>", f"{beams(*links)}</robot>"))
    return ks.Robot(parse_robot_text(text))


def hinge(name, parent, child, xyz, axis="0 1 0", kind="continuous"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/></joint>'
    )


def five_bar():
    """The five-bar by hand: link frames along the world's axes, cut at the other side of the tool, hinges about y."""
    return ks.Robot(
        parse_robot_text(f"""<robot name="by_hand">
    <link name="base">{inertial(1, 0, 0, -0.05)}</link>
    <link name="crank_1">{inertial(0.8, -0.075, 0, 0.1)}</link>
    <link name="tool">{inertial(2, -0.175, 0, -0.15)}</link>
    <link name="crank_2">{inertial(0.8, 0.075, 0, 0.1)}</link>
    <link name="rod_2">{inertial(1.2, -0.175, 0, 0.15)}</link>
    {hinge("motor_1", "base", "crank_1", "-0.2 0 0")}
    {hinge("motor_2", "base", "crank_2", "0.2 0 0")}
    {hinge("passive_2", "crank_2", "rod_2", "0.15 0 0.2")}
    {hinge("closing_tool", "rod_2", "tool", "-0.35 0 0.3")}
    <loop name="passive_1" type="revolute">
      <predecessor link="crank_1"><origin xyz="-0.15 0 0.2"/></predecessor>
      <successor link="tool"><origin xyz="-0.35 0 -0.3"/></successor><axis xyz="0 1 0"/>
    </loop>
    <platform link="tool"><origin xyz="-0.35 0 -0.3"/></platform>
    <transmission name="m"><joint name="motor_1"/><joint name="motor_2"/></transmission>
    {beams("crank_1", "crank_2", "rod_2")}
  </robot>""")
    )


def four_bar(kind):
    closure = '<axis xyz="0 1 0"/>' if kind == "revolute" else ""
    return ks.Robot(
        parse_robot_text(f"""<robot name="by_hand">
    <link name="base">{inertial(1, 0, 0, -0.05)}</link>
    <link name="crank">{inertial(0.7, 0.025, 0, 0.15)}</link>
    <link name="coupler">{inertial(1.5, 0.2, 0, 0.025)}</link>
    <link name="rocker">{inertial(0.9, 0.025, 0, 0.175)}</link>
    {hinge("drive", "base", "crank", "-0.2 0 0")}
    {hinge("elbow", "crank", "coupler", "0.05 0 0.3")}
    {hinge("hinge", "base", "rocker", "0.2 0 0")}
    <loop name="closure" type="{kind}">
      <predecessor link="rocker"><origin xyz="0.05 0 0.35"/></predecessor>
      <successor link="coupler"><origin xyz="0.4 0 0.05"/></successor>{closure}
    </loop>
    <platform link="coupler"/>
    <transmission name="m"><joint name="drive"/></transmission>
    {beams("crank", "rocker")}
  </robot>""")
    )


def assert_same(made, by_hand, actuators, signs=(), load=(20.0, -5.0, -100.0, 1.0, 2.0, -3.0)):
    """Analyses of one pose of both agree; ``signs`` of joints whose axes point the other way in ``made``. Same o, world axes."""
    signs = {name: 1 for name in actuators} | dict(signs)
    expected = ks.analyze(by_hand.assemble(actuators=actuators), load=load)
    found = ks.analyze(made.assemble(actuators={name: signs[name] * value for name, value in actuators.items()}), load=load)
    for name in ("twist", "compliance", "base_wrench", "platform_weight"):
        close(getattr(found, name), getattr(expected, name), name)
    close(found.contributions["load"], expected.contributions["load"], "load")
    for name in actuators:
        close(signs[name] * found.actuator_forces[name], expected.actuator_forces[name], name)


def close(found, expected, name):
    scale = np.abs(expected).max()
    assert scale > 0, name
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * scale, err_msg=name)


# ---- the same robot ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("files", "kind"), [((FIVE_BAR,), "revolute"), (GEPETTO, "fixed")])
def test_closing_frames_and_frame_pairs_give_the_same_robot(files, kind):
    """One side of Gepetto's weld is a revolute's own frame, so the weld closes the same five-bar."""
    description = described(*files, **(HINGE if kind == "revolute" else {"platform_link": "tool"}))
    assert [loop.type for loop in description.loops.values()] == [kind] and description.actuated == ("motor_1", "motor_2")
    assert_same(
        elastic(description, "crank_1", "crank_2", "rod_2"), five_bar(), {"motor_1": 0.3, "motor_2": 0.2}, {"motor_2": -1}
    )


@pytest.mark.parametrize("kind", ["revolute", "spherical"])
def test_isaac_loop_joints_give_the_same_robot(tmp_path, kind):
    source = tmp_path / "robot.urdf"
    source.write_text(FOUR_BAR.read_text().replace('name="closure" type="revolute"', f'name="closure" type="{kind}"'))
    # the hinge's axis, y in the world, in the loop's frame on the coupler: written down independently when the file was made
    axes = {"closure": (0.1519506855116402, 0.95254130791737635, -0.26377271633661575)} if kind == "revolute" else None
    description = described(source, platform_link="coupler", actuators=["drive"], axes=axes)
    assert_same(elastic(description, "crank", "rocker"), four_bar(kind), {"drive": 0.4})


def test_command_writes_a_file_that_includes_the_source(tmp_path, capsys):
    """The written file gives the same robot once beams are added to it; the source stays as it is."""
    source = tmp_path / "cad" / "robot.urdf"
    source.parent.mkdir()
    shutil.copy(FIVE_BAR, source)
    out = tmp_path / "robot.urdf.xacro"
    arguments = [*"--types closing_tool=revolute --platform-link tool --actuators motor_1 motor_2 --out".split(), str(out)]
    assert cli.main(["new", "--from", str(source), *arguments]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith(f"{out}: 1 loop, platform tool, base base, actuated: motor_1, motor_2; elastic: nothing yet")
    assert printed.err == ""
    text = out.read_text()
    turned = re.search(r"turned by 163\.8° with all joints at zero; (<origin [^>]*/>) makes", text)[1]
    platform = f'<platform link="tool">{turned}</platform>'
    followed = ks.Robot(parse_robot_text(text.replace('<platform link="tool"/>', platform), str(out), {}))
    pose = {name: float(value) for name, value in followed.assemble().platform.items()}
    assert [pose[name] for name in ("rx", "ry", "rz")] == pytest.approx([0, 0, 0], abs=1e-10)
    assert '<xacro:include filename="cad/robot.urdf"/>' in text
    assert source.read_bytes() == FIVE_BAR.read_bytes()
    robot = ks.load_robot(out)
    assert robot.description.loops["closing_tool"].type == "revolute"
    assert cli.main(["new", "--from", str(source), *arguments]) == 2  # a file that may have beams by now is not overwritten
    assert "exists already" in capsys.readouterr().err
    out.write_text(text.replace("</robot>", f"{beams('crank_1', 'crank_2', 'rod_2')}</robot>"))
    with_frames = ks.analyze(ks.load_robot(out).assemble(), load=(0, 0, -100, 0, 0, 0))
    by_hand = ks.analyze(five_bar().assemble(), load=(0, 0, -100, 0, 0, 0))
    np.testing.assert_allclose(with_frames.twist, by_hand.twist, rtol=1e-8, atol=1e-15)


def test_links_between_two_joints_may_be_beams():
    """Beams of a closed loop need no given ends; suggested beams have the mass of the link."""
    sections = dict.fromkeys(("crank_1", "crank_2", "rod_2"), "tube 30mm 24mm aluminium")
    robot = ks.extend_robot(FIVE_BAR, **HINGE, elastic=sections)
    weights = {name: beam.material.density for name, beam in robot.description.beams.items()}
    assert weights == {"crank_1": None, "crank_2": None, "rod_2": None} and len(robot.beams) == 3
    suggested = ks.extend_robot(FIVE_BAR, **HINGE, elastic="suggested")
    assert set(suggested.description.beams) == set(sections)
    with pytest.raises(ArgumentError, match="'tool' is not between two moving joints"):
        ks.extend_robot(FIVE_BAR, **HINGE, elastic={"tool": "circle 20mm"})


def test_yaml_beside_urdf_is_read_by_all_commands(capsys, tmp_path):
    source = ["--from", str(GEPETTO[0]), "--platform-link", "tool"]
    assert cli.main(["new", *source]) == 0
    taken = capsys.readouterr()
    assert f"{GEPETTO[1]}: the loops are read from this file" in taken.err
    assert cli.main(["new", *source, "--yaml", str(GEPETTO[1])]) == 0
    assert capsys.readouterr().out == taken.out
    assert cli.main(["check", str(GEPETTO[0])]) == 2  # as for any file, with commands
    assert f"kinetostatics check {GEPETTO[0]} --platform-link tool" in capsys.readouterr().err
    robot = ks.load_robot(GEPETTO[0], platform_link="tool")
    assert [loop.type for loop in robot.description.loops.values()] == ["fixed"]
    assert robot.description.actuated == ("motor_1", "motor_2")
    other = written(tmp_path, GEPETTO[0].read_bytes(), "five_bar.urdf")
    written(tmp_path, "gains: 3\n", "five_bar.yaml")
    actuated = ks.load_robot(other, platform_link="tool").description.actuated
    assert actuated == ("motor_1", "passive_1", "motor_2", "passive_2", "closedloop1_A")


@pytest.mark.parametrize("file", [FOUR_BAR, FIVE_BAR])
def test_commands_ask_for_what_a_file_lacks_by_a_command_that_works(file, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["analyze", str(file)]) == 2
    said = capsys.readouterr().err
    command = shlex.split(said.partition(" For example: ")[2])
    assert "lacks information; give also " in said and command[:4] == ["kinetostatics", "new", "--from", str(file)]
    assert cli.main(command[1:]) == 0
    assert len(ks.load_robot(command[-1]).description.loops) == 1


def test_command_writes_a_whole_file_if_joints_change(tmp_path, capsys):
    """The included file could not be changed, so there is no include; comments on loops and actuators are the same."""
    out = tmp_path / "robot.urdf"
    assert cli.main(["new", "--from", str(RRS[0]), "--yaml", str(RRS[1]), "--platform-link", "platform", "--out", str(out)]) == 0
    assert capsys.readouterr().err == ""
    text = out.read_text()
    assert "xacro" not in text
    found = ks.load_robot(out).description
    axes = {"to_rotule_1_X": (1, 0, 0), "to_rotule_1_Y": (0, 1, 0), "to_rotule_1_Z": (0, 0, 1)}
    assert {name: found.joints[name].axis for name in axes} == axes
    assert [found.joints[name].parent for name in axes] == ["rod_1", "to_rotule_1_X_link", "to_rotule_1_Y_link"]
    assert found.joints["to_rotule_1_Z"].child == "platform"
    assert found.actuated == ("mot1", "mot2", "mot3")
    assert "to_rotule_1" not in found.joints and {loop.type for loop in found.loops.values()} == {"spherical"}
    assert ks.Robot(found).mobility.platform == 3


def test_special_characters_in_names_are_kept(tmp_path, monkeypatch, capsys, name="$(x) ${1} b&c<[1]'.urdf"):
    text = FIVE_BAR.read_text().replace('"tool"', '"to&quot;o&amp;l ${1}"').replace('name="onshape"', 'name="a&lt;b$(c)"')
    written(tmp_path, text, name)
    monkeypatch.chdir(tmp_path)
    arguments = ["--types", "revolute", "--platform-link", 'to"o&l ${1}', "--actuators", "motor_1", "--out", "out.urdf"]
    assert cli.main(["new", "--from", name, *arguments]) == 0
    capsys.readouterr()
    found = ks.load_robot("out.urdf").description
    assert (found.name, found.platform, found.loops["closing_tool"].successor) == ("a<b$(c)", 'to"o&l ${1}', 'to"o&l ${1}')


def test_command_accepts_spellings_of_types_axes_and_actuators(capsys):
    """One type for all, axes with commas or spaces, an empty list of actuators."""
    assert cli.main(["new", "--from", str(FIVE_BAR), "--types", "spherical", "--platform-link", "tool", "--actuators"]) == 0
    assert 'type="spherical"' in (text := capsys.readouterr().out) and "transmission" not in text and "axis" not in text
    for axis in ("0,-2,0", "0 -2 0"):
        options = ["--axes", f"closure={axis}", *"--platform-link coupler --actuators drive".split()]
        assert cli.main(["new", "--from", str(FOUR_BAR), *options]) == 0
        assert '<axis xyz="0 -1 0"/>' in capsys.readouterr().out
    universal = "--types closing_tool=universal --axes closing_tool=0,0,1/1,0,0 --platform-link tool --actuators"
    assert cli.main(["new", "--from", str(FIVE_BAR), *universal.split()]) == 0
    text = capsys.readouterr().out
    assert '<axis xyz="0 0 1"/>' in text and '<axis2 xyz="1 0 0"/>' in text
    assert cli.main(["new", "--from", str(FOUR_BAR), "--axes", "closure=up"]) == 2
    assert "not of the form X,Y,Z" in capsys.readouterr().err


# ---- missing information -------------------------------------------------------------------------------------------


def asked(*arguments, **answers):
    with pytest.raises(ArgumentError, match="lacks information; give also ") as caught:
        described(*arguments, **answers)
    message = str(caught.value)
    return message, [word for word in ("platform_link", "types", "axes", "actuators") if re.search(f" {word}[:,]", message)]


def test_all_missing_information_is_listed_at_once():
    message, missing = asked(FIVE_BAR)
    line = line_of(FIVE_BAR, '<link name="closing_tool_1">')
    assert missing == ["platform_link", "types", "actuators"]  # no axes: mates turn about z
    for part in (
        "platform_link, one of crank_1, tool, crank_2, rod_2;",
        f"types: of closing_tool ({FIVE_BAR}:{line}), which joins rod_2 and tool, one of fixed, revolute",
        "actuators, none or some of motor_1, passive_1, motor_2, passive_2",
    ):
        assert part in message
    message, missing = asked(FOUR_BAR)
    assert missing == ["platform_link", "axes", "actuators"]
    line = line_of(FOUR_BAR, "<loop_joint")
    assert f"closure ({FOUR_BAR}:{line}), which joins coupler and rocker, in its frame on coupler" in message


def line_of(path, part):
    return next(number for number, line in enumerate(path.read_text().splitlines(), 1) if part in line)


def test_missing_types_are_asked_for(tmp_path):
    """Loaders differ in what a missing ``type`` means; a ``<loop_joint>`` without a type means nothing."""
    yaml = written(tmp_path, GEPETTO[1].read_text().replace("type: ['6d']\n", ""))
    assert asked(GEPETTO[0], yaml, platform_link="tool")[1] == ["types"]
    source = written(tmp_path, FOUR_BAR.read_text().replace(' type="revolute">\n    <link1', ">\n    <link1"), "isaac.urdf")
    assert asked(source, platform_link="coupler", actuators=["drive"])[1] == ["types"]
    assert asked(source, platform_link="coupler", actuators=["drive"], types={"closure": "planar"})[1] == ["axes"]


def test_actuated_joints_have_texts_of_the_yaml_in_their_names(tmp_path):
    """As in Gepetto's loader; without such texts they are asked for."""
    yaml = written(tmp_path, "closed_loop: [['closedloop1_A', 'closedloop1_B']]\ntype: ['6d']\n")
    assert asked(GEPETTO[0], yaml, platform_link="tool")[1] == ["actuators"]
    source = written(tmp_path, GEPETTO[0].read_text().replace('name="passive_1"', 'name="motor_1_bearing"'), "robot.urdf")
    assert described(source, GEPETTO[1], platform_link="tool").actuated == ("motor_1", "motor_1_bearing", "motor_2")


def test_frames_of_revolute_mates_give_the_type(tmp_path):
    def marked(height, of="rod_2"):
        marks = ""
        for name, link in (("closing_tool_1", of), ("closing_tool_2", "tool")):
            rest = FIVE_BAR.read_text().partition(f'<joint name="{name}_frame"')[2]
            xyz, rpy = re.search(r'xyz="([^"]*)" rpy="([^"]*)"', rest).groups()
            x, y, z = map(float, xyz.split())
            # these frames' z axes are along the link's own z, up or down
            shifted = z + height * (-1 if abs(float(rpy.split()[0])) > 1 else 1)
            marks += f'<link name="{name}_z"/><joint name="{name}_z_frame" type="fixed"><parent link="{link}"/>'
            marks += f'<child link="{name}_z"/><origin xyz="{x!r} {y!r} {shifted!r}" rpy="{rpy}"/></joint>'
        return written(tmp_path, FIVE_BAR.read_text().replace("</robot>", f"{marks}</robot>"), "robot.urdf")

    for height in (0.1, 0.1 + 9e-6):  # files have six digits
        made = described(marked(height), platform_link="tool", actuators=["motor_1", "motor_2"])
        assert (made.loops["closing_tool"].type, made.loops["closing_tool"].axis) == ("revolute", (0, 0, 1))
    for height, link in ((0.2, "rod_2"), (0.1 + 1.1e-5, "rod_2"), (0.1, "crank_2")):
        assert asked(marked(height, of=link), platform_link="tool", actuators=[])[1] == ["types"]


def test_arguments_have_priority_over_the_source():
    made = described(*GEPETTO, platform_link="tool", types={"closedloop1": "spherical"}, actuators=["motor_1"])
    assert (made.loops["closedloop1"].type, made.actuated) == ("spherical", ("motor_1",))
    assert described(FIVE_BAR, **HINGE, axes={"closing_tool": (2, 0, 0)}).loops["closing_tool"].axis == (1, 0, 0)


def test_elements_of_our_format_in_the_source_are_kept(tmp_path):
    """onshape-to-robot appends such elements to the URDF by its option ``additional_xml``."""
    ours = '<platform link="tool"/><base link="base"/><transmission name="t"><joint name="motor_1"/></transmission></robot>'
    source = written(tmp_path, FIVE_BAR.read_text().replace("</robot>", ours), "robot.urdf")
    made = described(source, types="revolute")
    assert (made.platform, made.base, made.actuated) == ("tool", "base", ("motor_1",))
    assert described(source, types="revolute", actuators=["motor_2", "motor_1"]).actuated == ("motor_1", "motor_2")
    with pytest.raises(ArgumentError, match=r"'motor_1' is not among them, but the source has a <transmission> for it"):
        described(source, types="revolute", actuators=["motor_2"])
    with pytest.raises(ArgumentError, match=f"platform_link='tool': {source} names its platform already; leave the argument out"):
        described(source, types="revolute", platform_link="tool")


def test_gepetto_universal_fixed_and_spherical_joints_are_converted(tmp_path):
    """UJOINT_ZX turns about z first and then about x of the joint's frame, whatever its axis was; FIXED is fixed."""
    rest = "closed_loop: [['closedloop2_A', 'closedloop2_B'], ['closedloop3_A', 'closedloop3_B']]\ntype: [3d, 3d]\n"
    names = "name_mot: [mot, to_rotule]\njoint_name"
    yaml = written(tmp_path, f"{rest}{names}: [to_rotule_1, free2]\njoint_type: [UJOINT_ZX, FIXED]\n")
    made = described(RRS[0], yaml, platform_link="platform")
    before = parse_robot_text(RRS[0].read_text().replace("</robot>", '<platform link="platform"/></robot>')).joints
    first, second = made.joints["to_rotule_1_Z"], made.joints["to_rotule_1_X"]
    assert (first.axis, second.axis) == ((0, 0, 1), (1, 0, 0))
    assert first.origin == before["to_rotule_1"].origin and second.origin.xyz == second.origin.rpy == (0, 0, 0)
    assert (first.parent, first.child) == ("rod_1", "to_rotule_1_Z_link") == ("rod_1", second.parent)
    assert made.actuated == ("mot1", "to_rotule_1_Z", "to_rotule_1_X", "mot2", "mot3")
    assert (made.joints["free2"].type, made.joints["free2"].origin) == ("fixed", before["free2"].origin)
    yaml.write_text(yaml.read_text().replace("ZX", "ZY"))
    assert described(RRS[0], yaml, platform_link="platform").joints["to_rotule_1_Y"].axis == (0, 1, 0)
    spherical = written(tmp_path, f"{rest}{names}: [to_rotule_1]\njoint_type: [SPHERICAL]\n")
    actuated = described(RRS[0], spherical, platform_link="platform").actuated
    assert actuated == ("mot1", *(f"to_rotule_1_{axis}" for axis in "XYZ"), "mot2", "mot3")


def test_xacro_sources_are_included_with_their_arguments(tmp_path):
    head = '<robot name="four_bar" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="mass" default="1.5"/>'
    text = FOUR_BAR.read_text().replace('<robot name="four_bar">', head).replace('value="1.5"', 'value="$(arg mass)"')
    source = written(tmp_path, text, "robot.urdf.xacro")
    answers = {"platform_link": "coupler", "actuators": ["drive"], "axes": {"closure": (0, 0, 1)}}
    assert described(source, **answers).links["coupler"].mass == 1.5
    assert described(source, **answers, parameters={"mass": 4}).links["coupler"].mass == 4
    with pytest.raises(RobotFileError, match="no <xacro:arg> for the parameter 'mas'"):
        described(source, **answers, parameters={"mas": 4})
    with pytest.raises(RobotFileError, match="has no parameters"):
        described(FOUR_BAR, **answers, parameters={"mass": 4})


def test_rounded_files_close_with_a_larger_tolerance(tmp_path):
    """Newer versions of onshape-to-robot write six digits, which an overconstrained loop cannot close exactly."""
    numbers = re.compile(r'(?<=[" ])-?\d+\.\d{7,}(?:e-?\d+)?(?=[" ])')
    text = numbers.sub(lambda match: f"{float(match[0]):g}", FIVE_BAR.read_text())
    assert text != FIVE_BAR.read_text()
    robot = elastic(described(written(tmp_path, text, "robot.urdf"), **HINGE), "crank_1", "crank_2", "rod_2")
    with pytest.raises(ks.AssemblyError, match="open"):
        robot.assemble()
    load = (20, -5, -100, 1, 2, -3)
    rounded = ks.analyze(robot.assemble(closure_tolerance=1e-5), load=load)
    np.testing.assert_allclose(rounded.twist, ks.analyze(five_bar().assemble(), load=load).twist, rtol=1e-3, atol=1e-9)


# ---- wrong input ---------------------------------------------------------------------------------------------------


def written(folder, text, name="robot.yaml"):
    path = folder / name
    path.write_bytes(text) if isinstance(text, bytes) else path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("answers", "message"),
    [
        ({"platform_link": "tol"}, r"platform_link='tol': .* has no such link; did you mean 'tool'"),
        ({"base_link": "tool"}, r"the link 'tool' is both base and platform"),
        ({"types": {"closing_tol": "revolute"}}, r"types: there is no loop 'closing_tol'; did you mean 'closing_tool'"),
        ({"types": {"closing_tool": "hinge"}}, r"types: 'closing_tool' cannot be 'hinge'"),
        ({"types": ["revolute"]}, r"types must be a dict with the loops' names as keys, not list"),
        ({"types": "spherical", "axes": {"closing_tool": (0, 0, 1)}}, r"'closing_tool' is spherical and has no axis"),
        ({"axes": {"closing_tool": (0, 0)}}, r"axes: 'closing_tool' is revolute and needs three numbers, not \(0, 0\)"),
        ({"axes": {"closing_tool": (0, 0, 0)}}, r"axes: an axis of 'closing_tool' is zero"),
        ({"types": "universal", "axes": {"closing_tool": (0, 0, 1)}}, r"needs two axes of three numbers each"),
        ({"types": "universal", "axes": {"closing_tool": ((0, 0, 1), (0, 0, 1))}}, r"the two axes of .* are parallel"),
        ({"actuators": "motor_1"}, r"actuators is 'motor_1'; it must be a sequence of names"),
        ({"actuators": ["motor_3"]}, r"actuators: there is no joint 'motor_3' with one freedom; did you mean"),
    ],
)
def test_wrong_arguments_are_errors(answers, message):
    with pytest.raises((ArgumentError, RobotFileError), match=message):
        described(FIVE_BAR, **{**HINGE, **answers})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"closing_tool_2"', '"closing_tol_2"', r"'closing_tool_1' has no partner: there is no link 'closing_tool_2' fixed to"),
        (
            'name="closing_tool_1_frame" type="fixed"',
            'name="closing_tool_1_frame" type="floating"',
            r"'closing_tool_2' has no partner",
        ),
        ('<robot name="onshape">', '<robot name="onshape"><loop name="a"/>', r"lacks the attribute 'type'"),
        ('link name="rod_2"', 'link name="rod_3"', r"refers to the link 'rod_2', which does not exist; did you mean 'rod_3'"),
        ('"motor_1"', '"closing_tool"', r"the loop's name 'closing_tool' is taken already by a joint"),
    ],
)
def test_wrong_closing_frames_are_errors(tmp_path, old, new, message):
    source = written(tmp_path, FIVE_BAR.read_text().replace(old, new), "robot.urdf")
    with pytest.raises(RobotFileError, match=message) as caught:
        described(source, **HINGE)
    assert caught.value.file.startswith(str(tmp_path))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<link2", "<link1", r"has two <link1>; leave one of them"),
        ('<link2 link="rocker"', '<link2 link="roker"', r"the link 'roker', which does not exist; did you mean 'rocker'"),
        ('<link2 link="rocker"', '<link2 link="coupler"', r"<loop> 'closure' joins the link 'coupler' to itself"),
        ('type="revolute">\n    <link1', 'type="floating">\n    <link1', r"has the type 'floating'; known: "),
        ('type="revolute">\n    <link1', 'type="ball">\n    <link1', r"has the type 'ball'; known: "),
        ('<loop_joint name="closure"', '<loop_joint name="drive"', r"the loop's name 'drive' is taken already"),
    ],
)
def test_wrong_isaac_loop_joints_are_errors(tmp_path, old, new, message):
    text = FOUR_BAR.read_text()
    source = written(tmp_path, text.replace(old, new), "robot.urdf")
    with pytest.raises(RobotFileError, match=message) as caught:
        described(source, platform_link="coupler", actuators=["drive"], axes={"closure": (0, 1, 0)})
    assert caught.value.file == str(source)
    assert caught.value.line >= line_of(FOUR_BAR, "<loop_joint")


def test_axis_of_isaac_loop_joint_is_ignored(tmp_path):
    """Drake's old element of the same name had an axis; its frame is unknown here."""
    source = written(tmp_path, FOUR_BAR.read_text().replace("</loop_joint>", '<axis xyz="0 1 0"/></loop_joint>'), "robot.urdf")
    assert asked(source, platform_link="coupler", actuators=["drive"])[1] == ["axes"]


PAIRS = "closed_loop: [['closedloop1_A', 'closedloop1_B']]\n"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", None, r"must be a mapping, which begins with a key"),
        ("a: [", 1, r"this is not YAML"),
        (b"\xff\xfe\xfa", None, r"this is not YAML: .utf-8. codec"),
        ("name_mot: [motor]\n", None, r"there is no closed_loop, and the URDF has no loops either"),
        (f"{PAIRS}{PAIRS}", 2, r"the key 'closed_loop' comes twice"),
        ("? [a]\n: b\n", 1, r"a key must be text in one line"),
        ("closed_loop: 3\n", 1, r"closed_loop must be a list"),
        ("closed_loop:\n  - [a, b, c]\n", 2, r"must be a pair of frames, not 3"),
        ("closed_loop: [['closedloop1_A', 'closedlop1_B']]\n", 1, r"no link or joint 'closedlop1_B'; did you mean"),
        ("closed_loop: [['closedloop1_B', 'rod_2']]\ntype: [3d]\n", 1, r"<loop> .* joins the link 'rod_2' to itself"),
        (f"{PAIRS}type: [3d, 6d]\n", 2, r"type has 2 entries, and closed_loop has 1"),
        (f"{PAIRS}type: [5d]\n", 2, r"an entry of type is '5d', which is unknown; did you mean '6D'"),
        (f"{PAIRS}type: [6d]\nname_mot: [motr]\n", 3, r"name_mot has 'motr', which is in no movable joint's name; did you mean"),
        (
            f"{PAIRS}type: [6d]\njoint_name: [passive_1]\n",
            3,
            r"joint_type has 0 entries, and joint_name has 1",
        ),
        (f"{PAIRS}joint_type: [SPHERICAL]\n", 2, r"joint_type has 1 entries, and joint_name has 0"),
        (f"{PAIRS}joint_name: [pasive_1]\njoint_type: [SPHERICAL]\n", 2, r"'pasive_1', which is unknown; did you"),
        (
            f"{PAIRS}joint_name: [closedloop1_B_frame]\njoint_type: [FIXED]\n",
            2,
            r"'closedloop1_B_frame', which is unknown; did you",
        ),
        (f"{PAIRS}joint_name: [passive_1]\njoint_type: [CARDAN]\n", 3, r"is 'CARDAN', which is unknown; known: FIXED, SPHERICAL"),
        ("closed_loop: !!python/object/apply:os.system ['touch stolen']\n", 1, r"an entry of closed_loop must be a list"),
        pytest.param("closed_loop: " + "[" * 2000, None, r"not YAML", marks=pytest.mark.slow),
    ],
)
def test_wrong_yaml_is_an_error_with_line(tmp_path, monkeypatch, text, line, message):
    monkeypatch.chdir(tmp_path)
    yaml = written(tmp_path, text)
    with pytest.raises(RobotFileError, match=message) as caught:
        described(GEPETTO[0], yaml, platform_link="tool", actuators=[], types="fixed")
    assert (caught.value.file, caught.value.line) == (str(yaml), line)
    assert len(str(caught.value)) < 1500
    assert not (tmp_path / "stolen").exists()


def test_missing_files_and_loops_are_errors(tmp_path):
    with pytest.raises(RobotFileError, match=r"nowhere\.urdf: the file cannot be read: No such file"):
        described(tmp_path / "nowhere.urdf")
    with pytest.raises(RobotFileError, match=r"nowhere\.yaml: the file cannot be read: No such file"):
        described(GEPETTO[0], tmp_path / "nowhere.yaml")
    with pytest.raises(ArgumentError, match=r"types= and axes= are for loops of another tool, and .* has none"):
        ks.extend_robot("3rps", types="revolute")


# ---- the documentation ---------------------------------------------------------------------------------------------


def test_foreign_loops_page_shows_the_printed_output(tmp_path, monkeypatch, capsys):
    page = (ROOT / "docs" / "how_to" / "foreign_loops.md").read_text()
    (block,) = re.findall(r"```console\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    for path in FOREIGN.iterdir():
        shutil.copy(path, tmp_path)
    for command in block.split("$ ")[1:]:
        line, _, expected = command.partition("\n")
        cli.main(line.split()[1:])
        printed = capsys.readouterr()
        assert printed.out + printed.err == expected
    made = (tmp_path / "five_bar.urdf.xacro").read_text()
    (shown,) = re.findall(r"```xml\n(<robot.*?)```", page, re.DOTALL)
    made = re.sub(r"(<origin) xyz[^/]*", r'\1 xyz="…" rpy="…"', made)
    without_comments = re.sub(r"\n *<!--.*?-->(?=\n)", "", made, flags=re.DOTALL).partition("\n")[2]
    assert re.sub(r"\n\n+", "\n", without_comments) == shown
