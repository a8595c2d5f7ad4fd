"""Reading robot files: values of all elements, and errors with file and line.

In the bad files below the comment ``<!--!-->`` marks the line that the error must name.
"""

import math
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT

from kinetostatics.description import BeamEnd, Origin
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.reader import parse_robot_text, read_robot_file

GOOD = """<?xml version="1.0"?>
<robot name="r">
  <!-- a comment -->
  <link name="ground"/>
  <link name="rod"><inertial><origin xyz="0 0 0.5"/><mass value="2"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="plate"/>
  <joint name="hinge" type="revolute">
    <parent link="ground"/><child link="rod"/>
    <axis xyz="0 2 0"/>
    <limit lower="-1" upper="1" effort="0" velocity="0"/>
  </joint>
  <joint name="ball" type="floating">
    <origin xyz="0 0 1" rpy="0 0 0.5"/>
    <parent link="rod"/><child link="plate"/>
  </joint>
  <platform link="plate"><origin xyz="0 0 0.1"/></platform>
  <loop name="strut" type="universal">
    <predecessor link="ground"><origin xyz="1 0 0"/></predecessor><successor link="plate"/>
  </loop>
  <beam link="rod" from="hinge" to="ball" youngs_modulus="200e9" poisson_ratio="0.3" density="7800">
    <circle diameter="0.01"/>
  </beam>
  <transmission name="drive"><joint name="hinge"/></transmission>
</robot>
"""

LOOP = '<loop name="strut" type="universal">'
BEAM = '<beam link="rod" from="hinge" to="ball" youngs_modulus="200e9" poisson_ratio="0.3" density="7800">'
CIRCLE = '<circle diameter="0.01"/>'
HINGE = '<joint name="hinge" type="revolute">'
BALL = '<joint name="ball" type="floating">'
LIMIT = '<limit lower="-1" upper="1" effort="0" velocity="0"/>'
PLATFORM = '<platform link="plate"><origin xyz="0 0 0.1"/></platform>'
DRIVE = '<transmission name="drive"><joint name="hinge"/></transmission>'
CHILD = '<child link="rod"/>'
PLATE, GROUND = '<link name="plate"/>', '<link name="ground"/>'
UNWEIGHED_BEAM = BEAM.replace('to="ball"', 'to="strut"').replace('density="7800"', 'name="two"')
BARE_BEAM = BEAM.replace(' poisson_ratio="0.3"', "")
WHOLE_BEAM, UNIT = f"{BEAM}\n    {CIRCLE}", 'area="1" I_y="1" I_z="1" J="1"'
END = "</robot>"

# (what is replaced, by what, words of the message)
BAD: list[tuple[str, str, list[str]]] = [
    # XML
    ('<child link="plate"/>', '<child link="plate">\n</joint><!--!-->', ["well-formed", "<child> of line 15"]),
    (CHILD, '<child link="rod" link="x"/><!--!-->', ["well-formed", "duplicate"]),
    (CHILD, "<xacro:child/><!--!-->", ["prefix", "xmlns:xacro"]),
    ('<?xml version="1.0"?>\n', '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]><!--!-->\n', ["DOCTYPE", "entities"]),
    # <robot>
    ('<robot name="r">', '<robot name="r" version="3"><!--!-->', ["version", "'3'"]),
    (END, '<material name="m"/>\n<material name="m"/><!--!-->\n</robot>', ["material", "twice"]),
    # links
    ('<link name="ground"/>', '<link name="ground"/>\n<link name="ground"/><!--!-->', ["ground", ":4"]),
    ('<mass value="2"/>', '<mass value="-2"/><!--!-->', ["value='-2'", "zero or greater"]),
    ('<mass value="2"/>', '<mass value="heavy"/><!--!-->', ["'heavy'", "not a number"]),
    ('<mass value="2"/>', '<mass value="4 cm"/><!--!-->', ["'4 cm'", "without the unit: 0.04"]),
    ('<mass value="2"/>', '<mass value="30deg"/><!--!-->', ["not a number", "without the unit: 0.523598775598"]),
    ('<mass value="2"/>', '<mass value="1e999"/><!--!-->', ["'1e999'", "finite"]),
    (PLATE, '<link name="plate"><collision><origin rpy="0 0 nan"/><!--!--></collision></link>', ["nan"]),
    (PLATE, '<link name="plate"><beam/><!--!--></link>', ["directly inside <robot>"]),
    # joints
    (HINGE, HINGE.replace("revolute", "revolut") + "<!--!-->", ["'revolut'", "did you mean 'revolute'"]),
    (HINGE, HINGE.replace("revolute", "spherical") + "<!--!-->", ["'spherical'", "<loop>"]),
    (HINGE, '<joint name="hinge"><!--!-->', ["'type'"]),
    (BALL, '<joint name="hinge" type="floating"><!--!-->', ["'hinge'", "taken"]),
    (f'<parent link="ground"/>{CHILD}', CHILD, ["<parent>"]),
    (CHILD, "", ["<child>"]),
    ('<parent link="ground"/>', '<parent link="grond"/><!--!-->', ["'grond'", "did you mean 'ground'"]),
    (CHILD, '<child link="rods"/><!--!-->', ["'rods'", "did you mean 'rod'"]),
    (CHILD + "\n", '<child link="ground"/>\n', ["'hinge'", "'ground'", "itself"]),
    ('<axis xyz="0 2 0"/>', '<axis xyz="0 0 0"/><!--!-->', ["zero"]),
    (LIMIT, "", ["<limit>", "effort", "velocity"]),
    (LIMIT, '<limit lower="0" upper="1" velocity="0"/><!--!-->', ["'effort'"]),
    (LIMIT, '<limit lower="2" effort="0" velocity="0"/><!--!-->', ["lower=2", "upper=0", "left out is 0"]),
    (LIMIT, LIMIT + '<mimic joint="ball" multiplier="0"/><!--!-->', ["<mimic>", "multiplier=0", "'hinge'"]),
    (LIMIT, LIMIT + '<platform link="rod"/><!--!-->', ["directly inside <robot>"]),
    (LIMIT, LIMIT + "<dynamics/><!--!-->", ["damping", "friction"]),
    (LIMIT, LIMIT + '<dynamics spring="1"/><!--!-->', ["neither damping nor friction"]),
    ('<origin xyz="0 0 1" rpy="0 0 0.5"/>', '<origin xyz="0 0 1" ryp="0 0 1"/><!--!-->', ["'ryp'", "rpy"]),
    (BALL, '<joint name="ball" type="planar"><!--!-->', ["planar", "xy plane", "0 0 1", "<loop>"]),
    # the tree
    (END, '<link name="lost"/><!--!--></robot>', ["'ground'", "'lost'", "no parent"]),
    (
        GROUND,
        f'{GROUND}<!--!-->\n<joint name="round" type="fixed"><parent link="plate"/><child link="ground"/></joint>',
        ["cycle", "'ground'", "'rod'", "'plate'"],
    ),
    # misspelled elements, and ours that are not there yet
    (END, "<Loop/><!--!--></robot>", ["<Loop>", "did you mean <loop>"]),
    (END, '<joint_stiffness joint="hinge"/><!--!--></robot>', ["<joint_stiffness>", "linear, angular or drive"]),
    # base and platform
    (PLATFORM, '<platform link="plate"/>\n<platform link="rod"/><!--!-->', ["two <platform>"]),
    (PLATFORM, '<platform link="plat"/><!--!-->', ["'plat'", "did you mean 'plate'"]),
    (PLATFORM, '<platform link="plate"><orgin/><!--!--></platform>', ["<orgin>", "did you mean 'origin'"]),
    (PLATFORM, '<platform link="ground"/><!--!-->', ["'ground'", "both base and platform"]),
    (END, '<base link="plate"/></robot>', ["'plate'", "both base and platform"]),
    (END, '<base link="grund"/><!--!--></robot>', ["did you mean 'ground'"]),
    # loops
    (LOOP, '<loop name="hinge" type="universal"><!--!-->', ["'hinge'", "taken"]),
    (LOOP, '<loop name="strut" type="sperical"><!--!-->', ["'sperical'", "did you mean 'spherical'"]),
    ('<successor link="plate"/>', "", ["<successor>"]),
    ('<predecessor link="ground"><origin xyz="1 0 0"/></predecessor>', '<predecessor link="plate"/>', ["itself"]),
    (LOOP, LOOP + '<axis xyz="0 1 0"/><!--!-->', ["parallel"]),
    (LOOP, '<loop name="strut" type="spherical"><axis xyz="1 0 0"/><!--!-->', ["spherical", "no <axis>"]),
    (LOOP, '<loop name="strut" type="revolute"><axis2 xyz="0 1 0"/><!--!-->', ["revolute", "no <axis2>"]),
    (LOOP, LOOP + '<limit lower="0" upper="1"/><!--!-->', ["universal", "<limit>", "<cone>"]),
    (LOOP, '<loop name="strut" type="continuous"><limit lower="0" upper="1"/><!--!-->', ["unlimited", "revolute"]),
    (LOOP, '<loop name="strut" type="revolute"><cone angle="1"/><!--!-->', ["<cone>", "universal and spherical"]),
    (LOOP, LOOP + '<cone angle="30"/><!--!-->', ["π", "radians"]),
    # beams
    (BEAM, BEAM.replace('link="rod"', 'link="rot"') + "<!--!-->", ["'rot'", "did you mean 'rod'"]),
    (BEAM, BEAM.replace('link="rod"', 'link="plate"') + "<!--!-->", ["platform", "fixed joint"]),
    (BEAM, BEAM.replace('link="rod"', 'link="ground"') + "<!--!-->", ["base", "fixed joint"]),
    (BEAM, BEAM.replace('to="ball"', 'to="ball:left"') + "<!--!-->", [":parent", "'left'"]),
    (BEAM, BEAM.replace('to="ball"', 'to="hinge"') + "<!--!-->", ["zero length"]),
    (BEAM, BEAM.replace("200e9", "0") + "<!--!-->", ["youngs_modulus", "greater than zero"]),
    (BEAM, BEAM.replace("0.3", "0.51") + "<!--!-->", ["poisson_ratio=0.51", "0.5"]),
    (BEAM, BARE_BEAM + "<!--!-->", ["neither poisson_ratio nor shear_modulus"]),
    (BEAM, BEAM[:-1] + ' shear_modulus="1e9"><!--!-->', ["both poisson_ratio and shear_modulus"]),
    (BEAM, BARE_BEAM[:-1] + ' shear_modulus="1e9"><!--!-->', ["shear_coefficient", "Poisson"]),
    (BEAM, f"{BEAM}{CIRCLE}</beam>\n{BEAM}<!--!-->", ["two beams on the same span", ":21"]),
    (BEAM, f"{BEAM}{CIRCLE}</beam>\n{BEAM.replace('ball', 'strut')}<!--!-->", ["'rod'", "taken", ":21"]),
    (BEAM, f"{BEAM}{CIRCLE}</beam>\n{UNWEIGHED_BEAM}<!--!-->", ["density", "all", ":21"]),
    # sections
    (f"{CIRCLE}", "", ["no sections", "<circle>", "<rectangular_tube>"]),
    (CIRCLE, '<circle diameter="1e300"/><!--!-->', ["too large"]),
    (CIRCLE, '<tube outer_diameter="0.1" inner_diameter="0.1"/><!--!-->', ["inner_diameter=0.1", "less than"]),
    (CIRCLE, '<rectangular_tube width="0.1" height="0.2" thickness="0.05"/><!--!-->', ["thickness=0.05", "half"]),
    (CIRCLE, '<section area="1" I_y="1" I_z="1" J="1" shear_area_y="1"/><!--!-->', ["both shear_area_y and"]),
    (WHOLE_BEAM, BEAM + '<!--!--><rectangle width="0.1" height="0.2"/>', ["y_axis", "width"]),
    (WHOLE_BEAM, f"{BEAM}<!--!--><section {UNIT}/>", ["shear_coefficient", "shape"]),
    (WHOLE_BEAM, f'{BEAM}<!--!--><section {UNIT} shear_area_y="1" shear_area_z="0.5"/>', ["y_axis"]),
    (
        WHOLE_BEAM,
        f'{BEAM[:-1]} shear_coefficient="1"><!--!--><section {UNIT} shear_area_y="1" shear_area_z="1"/>',
        ["shear_coefficient and shear areas"],
    ),
    # transmissions
    (DRIVE, '<transmission><joint name="hing"/><!--!--></transmission>', ["'hing'", "did you mean 'hinge'"]),
    (DRIVE, '<transmission name="t"/><!--!-->', ["names no joint"]),
    (DRIVE, '<transmission><joint name="ball"/><!--!--></transmission>', ["'ball'", "floating", "actuated"]),
    (DRIVE, DRIVE + "\n" + DRIVE + "<!--!-->", ["'hinge'", "two", "once"]),
]


def change(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def marked_line(text: str) -> int | None:
    """Return the number of the line with the mark, None without it."""
    lines = [number for number, line in enumerate(text.splitlines(), 1) if "<!--!-->" in line]
    return lines[0] if lines else None


@pytest.mark.parametrize(("old", "new", "words"), BAD)
def test_bad_file_is_refused_with_line_and_reason(old: str, new: str, words: list[str]) -> None:
    text = change(GOOD, old, new)
    with pytest.raises(RobotFileError) as caught:
        parse_robot_text(text, "robots/bad.urdf")
    error = caught.value
    assert error.file == "robots/bad.urdf"
    assert error.line is not None
    assert error.line == (marked_line(text) or error.line)
    assert str(error) == f"robots/bad.urdf:{error.line}: {error.reason}"
    assert "\n" not in str(error)
    for word in words:
        assert word in str(error)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", None, ["empty"]),
        ("<robot", 1, ["well-formed"]),
        ("hello", 1, ["well-formed"]),
        ("<!-- only a comment -->", 1, ["well-formed", "no element"]),
        ("\n<urdf/>", 2, ["<urdf>", "<robot>"]),
        ("<robot name='r'/>", 1, ["no links"]),
        ("<robot name='r'>\n<link name='a'/></robot>", 1, ["no platform", "no joint moves a link", "<platform link="]),
        ("\ud800", 1, ["decoded"]),
        ("<robot>\n" + "<visual>\n" * 10_000 + "</visual>" * 10_000 + "</robot>", 201, ["nested in 200 elements"]),
    ],
)
def test_bad_text_is_refused_with_line_and_reason(text: str, line: int | None, words: list[str]) -> None:
    with pytest.raises(RobotFileError) as caught:
        parse_robot_text(text)
    assert (caught.value.file, caught.value.line) == ("<text>", line)
    for word in words:
        assert word in str(caught.value)


def test_unreadable_files_are_errors(tmp_path: Path) -> None:
    empty, binary, encoding = tmp_path / "empty.urdf", tmp_path / "binary.urdf", tmp_path / "encoding.urdf"
    empty.write_text("")
    binary.write_bytes(b"<robot name='\xff\xfe'/>")
    encoding.write_bytes(b"<?xml version='1.0' encoding='klingon'?><robot name='r'/>")
    for path, word in [
        (tmp_path / "none.urdf", "No such file"),
        (tmp_path, "directory"),
        (empty, "empty"),
        (binary, "well-formed"),
        (encoding, "encoding"),
        (Path(f"{tmp_path}\0"), "null"),
    ]:
        with pytest.raises(RobotFileError, match=word) as caught:
            read_robot_file(path)
        assert caught.value.file == str(path)


def test_everything_of_a_small_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "small.urdf"
    path.write_text(GOOD)
    robot = read_robot_file(str(path))
    assert (robot.name, robot.path, robot.warnings) == ("r", str(path), ())
    rod, ground, _ = (robot.links[name] for name in ("rod", "ground", "plate"))
    assert (rod.mass, rod.center_of_mass, rod.has_inertial) == (2.0, (0.0, 0.0, 0.5), True)
    assert (ground.mass, ground.has_inertial, str(rod.place)) == (0.0, False, f"{path}:5")
    hinge, ball = robot.joints["hinge"], robot.joints["ball"]
    assert (hinge.type, hinge.parent, hinge.child) == ("revolute", "ground", "rod")
    assert (hinge.axis, hinge.lower, hinge.upper, hinge.origin) == ((0.0, 1.0, 0.0), -1.0, 1.0, Origin())
    assert (ball.axis, ball.lower, ball.upper) == ((1.0, 0.0, 0.0), -math.inf, math.inf)
    assert ball.origin == Origin((0.0, 0.0, 1.0), (0.0, 0.0, 0.5))
    assert (hinge.place.line, ball.place.line) == (8, 13)
    assert (robot.base, robot.platform, robot.platform_origin) == ("ground", "plate", Origin((0.0, 0.0, 0.1)))
    assert robot.platform_place.line == 17
    loop = robot.loops["strut"]
    assert (loop.type, loop.predecessor, loop.successor) == ("universal", "ground", "plate")
    assert (loop.predecessor_origin, loop.successor_origin) == (Origin((1.0, 0.0, 0.0)), Origin())
    assert (loop.axis, loop.axis2, loop.cone) == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), None)
    assert (loop.lower, loop.upper, loop.place.line) == (-math.inf, math.inf, 18)
    beam = robot.beams["rod"]
    assert (beam.name, beam.link, beam.start, beam.end) == ("rod", "rod", BeamEnd("hinge"), BeamEnd("ball"))
    assert (beam.youngs_modulus, beam.density, beam.thermal_expansion, beam.y_axis) == (200e9, 7800.0, 0.0, None)
    assert beam.shear_modulus == pytest.approx(200e9 / 2.6)
    area = math.pi / 4 * 0.01**2
    assert beam.section.area == pytest.approx(area)
    assert beam.shear_areas == pytest.approx([6 * 1.3 / 8.8 * area] * 2)
    assert beam.place.line == 21
    assert robot.actuated == ("hinge",)


def test_the_urdf_text_loads_in_pinocchio_and_reads_again() -> None:
    robot = parse_robot_text(GOOD.replace('name="r"', 'name="ü &lt;&quot;"').replace("0 0 0.1", "0\t0\n&#10;0.1"))
    model = pin.buildModelFromXML(robot.urdf)
    assert (model.nq, model.name) == (8, 'ü <"')
    assert "beam" in robot.urdf and "kinetostatics" not in robot.urdf
    again = parse_robot_text(robot.urdf)
    assert again.name == robot.name
    assert (again.platform_origin, list(again.joints)) == (robot.platform_origin, list(robot.joints))


def test_loop_limits_and_cones_are_read() -> None:
    text = change(GOOD, LOOP, '<loop name="strut" type="prismatic"><limit lower="-2"/>')
    loop = parse_robot_text(text).loops["strut"]
    assert (loop.lower, loop.upper) == (-2.0, 0.0)
    spherical = '<loop name="strut" type="spherical"><cone angle="3.14159265359" predecessor_axis="0 4 0"/>'
    cone = parse_robot_text(change(GOOD, LOOP, spherical)).loops["strut"].cone
    assert cone is not None
    assert (cone.angle, cone.predecessor_axis, cone.successor_axis) == (math.pi, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    skew = parse_robot_text(change(GOOD, LOOP, LOOP + '<axis xyz="0 0 1"/><axis2 xyz="0 1 1"/>')).loops["strut"]
    assert skew.axis2 == pytest.approx((0.0, math.sqrt(0.5), math.sqrt(0.5)))


def test_defaults_of_tree_joint_limits() -> None:
    def hinge(limit: str, kind: str = "revolute") -> tuple[float, float]:
        text = change(change(GOOD, LIMIT, limit), HINGE, HINGE.replace("revolute", kind))
        joint = parse_robot_text(text).joints["hinge"]
        return joint.lower, joint.upper

    assert hinge('<limit effort="1" velocity="1"/>') == (-math.inf, math.inf)
    assert hinge('<limit upper="0.5" effort="1" velocity="1"/>', "prismatic") == (0.0, 0.5)
    assert hinge("", "continuous") == (-math.inf, math.inf)
    assert hinge(LIMIT, "continuous") == (-math.inf, math.inf)


def test_tree_joint_axes_are_normalized() -> None:
    def ball(kind: str, axis: str) -> tuple[float, float, float]:
        robot = parse_robot_text(change(GOOD, BALL, f'<joint name="ball" type="{kind}">{axis}'))
        pin.buildModelFromXML(robot.urdf)
        return robot.joints["ball"].axis

    assert ball("planar", '<axis xyz="0 0 -5"/>') == (0.0, 0.0, -1.0)
    assert ball("fixed", '<axis xyz="0 0 0"/>') == (1.0, 0.0, 0.0)
    assert ball("continuous", "") == (1.0, 0.0, 0.0)
    assert ball("continuous", '<axis xyz="1e-200 0 0"/>') == (1.0, 0.0, 0.0)
    assert ball("continuous", '<axis xyz="1e300 1e300 0"/>') == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.0))


def test_shear_modulus_and_shear_areas_are_read() -> None:
    def beam(attributes: str, section: str = CIRCLE) -> tuple[float, float, float]:
        head = BARE_BEAM[:-1] + f" {attributes}>"
        read = parse_robot_text(change(change(GOOD, CIRCLE, section), BEAM, head)).beams["rod"]
        return read.shear_modulus, *read.shear_areas

    numbers = 'area="2" I_y="1" I_z="3" J="4"'
    area = math.pi / 4 * 0.01**2
    assert beam('shear_modulus="8e9" shear_coefficient="0.5"') == pytest.approx((8e9, area / 2, area / 2))
    assert beam('shear_modulus="8e9" shear_coefficient="inf"') == (8e9, math.inf, math.inf)
    general = f'<section {numbers} shear_area_y="0.6" shear_area_z="0.7"/>'
    assert beam('shear_modulus="8e9" y_axis="1 0 0"', general) == (8e9, 0.6, 0.7)
    assert beam('poisson_ratio="0.5" y_axis="1 0 0" shear_coefficient="1"', f"<section {numbers}/>")[1:] == (2.0, 2.0)


def test_beam_ends_are_read_with_sides_and_defaults() -> None:
    telescope = BEAM.replace('"hinge"', '"hinge:parent"').replace('"ball"', '"strut:child"')
    beam = parse_robot_text(change(GOOD, BEAM, telescope)).beams["rod"]
    assert (beam.start, beam.end) == (BeamEnd("hinge", "parent"), BeamEnd("strut", "child"))
    beam = parse_robot_text(change(GOOD, BEAM, BEAM.replace(' from="hinge" to="ball"', ""))).beams["rod"]
    assert (beam.start, beam.end) == (None, None)
    beam = parse_robot_text(GOOD.replace('"ball"', '"a:child"')).beams["rod"]
    assert beam.end == BeamEnd("a:child")


def test_actuated_joints_have_the_order_of_ros_transmissions() -> None:
    transmissions = (
        '<transmission name="b"><type>t/Simple</type><joint name="strut"><hardwareInterface/></joint>'
        '<actuator name="m"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>'
        '<transmission><joint name="hinge"/><joint name="ball"/></transmission>'
    )
    text = change(change(GOOD, DRIVE, transmissions), LOOP, '<loop name="strut" type="prismatic">')
    text = change(text, BALL, '<joint name="ball" type="continuous">')
    assert parse_robot_text(text).actuated == ("strut", "hinge", "ball")


def test_foreign_elements_are_ignored() -> None:
    others = (
        '<gazebo reference="rod"><beam/></gazebo><ros2_control name="x"><joint name="hinge"/></ros2_control>'
        '<material name="m"><color rgba="1 1 1 1"/></material><sensor name="s"/><x:y xmlns:x="urn:x" x:z="1"/>'
        "<unbound:prefix/>text"
    )
    robot = parse_robot_text(change(GOOD, END, others + END))
    assert robot.warnings == ()
    pin.buildModelFromXML(robot.urdf)


def test_warnings_name_line_and_element() -> None:
    text = change(change(GOOD, ' density="7800"', ""), "<inertial>", "<intertial>")
    text = change(text, "</inertial>", "</intertial>")
    text = change(text, '<axis xyz="0 2 0"/>', '<axes xyz="0 2 0"/>')
    text = change(text, HINGE, HINGE.replace("revolute", "continuous"))
    warnings = parse_robot_text(text, "w.urdf").warnings
    assert [re.match(r"w.urdf:(\d+): ", line).group(1) for line in warnings] == ["5", "10", "11", "8", "21"]  # type: ignore[union-attr]
    for line, word in zip(warnings, ["<inertial>", "<axis>", "continuous", "no <axis>", "weighs nothing"], strict=True):
        assert word in line
        assert line.endswith((".", "?"))
    massless = BEAM.replace("7800", "0")
    assert parse_robot_text(change(change(GOOD, BEAM, massless), '<mass value="2"/>', '<mass value="0"/>')).warnings == ()


# xacro


XACRO = GOOD.replace('<robot name="r">', '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">')


def xacro(body: str) -> str:
    return change(XACRO, END, body + END)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder whose name would fail if xacro evaluated it."""
    path = tmp_path / "a folder ${with} $(arg trouble)"
    path.mkdir()
    return path


def test_xacro_parameters_replace_defaults() -> None:
    arguments = (
        '<xacro:arg name="d" default="0.01"/><xacro:arg name="n" default="a"/>'
        '<xacro:if value="0"><xacro:arg name="unused" default="1"/></xacro:if>'
    )
    text = change(XACRO, '<link name="ground"/>', arguments + '<link name="ground"/>')
    text = change(text, CIRCLE, '<circle diameter="${2*$(arg d)}"/>').replace('"hinge"', '"$(arg n)"')

    def diameter(**parameters: object) -> float:
        return parse_robot_text(text, parameters=parameters).beams["rod"].section.outer_diameter  # type: ignore[attr-defined,no-any-return]

    assert diameter() == 0.02
    assert diameter(d=0.1 + 0.2) == 2 * (0.1 + 0.2)
    assert diameter(d=3) == 6.0
    assert diameter(d="0.5", unused=True) == 1.0
    assert list(parse_robot_text(text, parameters={"n": "$ b"}).joints) == ["$ b", "ball"]
    with pytest.raises(RobotFileError, match=r"parameter 'dd'; .*known: d, n, unused|did you mean 'd'"):
        diameter(dd=1)
    with pytest.raises(ArgumentError, match="'d' must be a number or a string, not list"):
        diameter(d=[1])
    with pytest.raises(RobotFileError, match=r"does not use xacro.*'d'"):
        parse_robot_text(GOOD, parameters={"d": 1})
    assert parse_robot_text(GOOD, parameters={}).name == "r"


def test_xacro_keeps_order_and_places(folder: Path) -> None:
    inner = folder / "inner part.xacro"
    inner.write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        '<xacro:macro name="tool" params="name *at">\n'
        '  <link name="${name}"/>\n'
        '  <joint name="to_${name}" type="fixed"><parent link="plate"/><child link="${name}"/>\n'
        '    <xacro:insert_block name="at"/></joint>\n'
        "</xacro:macro>\n<link name='extra'/>\n</robot>"
    )
    outer = folder / "outer.urdf"  # xacro by its content, not by its name
    outer.write_text(xacro(
        '<xacro:include filename="inner part.xacro"/>\n'
        '<xacro:tool name="t1"><origin xyz="1 0 0"/></xacro:tool>\n'
        '<xacro:tool name="t2"><origin xyz="2 0 0"/></xacro:tool>\n'
        '<joint name="e" type="fixed"><parent link="plate"/><child link="extra"/></joint>'
    ))  # fmt: skip
    robot = read_robot_file(outer)
    assert list(robot.links) == ["ground", "rod", "plate", "extra", "t1", "t2"]
    assert list(robot.joints) == ["hinge", "ball", "to_t1", "to_t2", "e"]
    assert robot.joints["to_t2"].origin.xyz == (2.0, 0.0, 0.0)
    for name, line in [("extra", 7), ("t1", 3), ("t2", 3)]:
        assert (robot.links[name].place.file, robot.links[name].place.line) == (str(inner), line)
    assert robot.links["rod"].place.file == str(outer)
    assert "xacro" not in robot.urdf
    assert pin.buildModelFromXML(robot.urdf).nq == 8


BAD_XACRO: list[tuple[str, list[str]]] = [
    ('<link name="${oops}"/><!--!-->', ["'oops' is not defined"]),
    ('<link name="$(arg oops)"/><!--!-->', ["no xacro argument 'oops'", "<xacro:arg"]),
    ('<link name="$(find package)"/><!--!-->', ["$(find", "ROS", "relative"]),
    ("<xacro:oops/><!--!-->", ["unknown macro name", "xacro:oops"]),
    ('<xacro:include filename="none.xacro"/><!--!-->', ["cannot read", "none.xacro", "No such file"]),
    (
        '<xacro:macro name="m" params="a">\n<link name="${a}${oops}"/><!--!-->\n</xacro:macro>\n<xacro:m a="1"/>',
        ["'oops' is not defined", "in the macro called at <text>:28"],
    ),
    ('<xacro:macro name="m">\n<xacro:m/><!--!-->\n</xacro:macro><xacro:m/>', ["come to an end"]),
    ('<xacro:property name="p" value="${p}"/>\n<link name="${p}"/><!--!-->', ["circular", "p"]),
    (
        '<xacro:macro name="m" params="x">\n<beam link="rod" y="${x}"/><!--!-->\n</xacro:macro>\n<xacro:m x="1"/>',
        ["'y' is not an attribute of <beam> of link 'rod'"],
    ),
    ('<xacro:property name="x" value="${-1}"/>\n<base link="r${x}"/><!--!-->', ["'r-1'", "known: ground, plate, rod"]),
    ('<xacro:include filename="/etc/passwd"/>', ["/etc/passwd:1", "well-formed"]),
    ('<xacro:include filename="/dev/zero"/><!--!-->', ["not an ordinary file"]),
    ('<xacro:element xacro:name="a b"/><!--!-->', ["'a b' is not a name"]),
    ("<gazebo>${'\\x00'}</gazebo><!--!-->", ["character"]),
    *((f"<gazebo>{text}</gazebo><!--!-->", [words]) for text, words in (
        ("${1 +}", "invalid syntax"),
        ("${1/0}", "division by zero"),
        ("${open('/etc/passwd').read()}", "'open' is not defined"),
        ("${[y.__class__ for y in [1]]}", "__"),
        ("${'{0.__class__}'.format(1)}", "__"),
        ("$(eval [].__class__)", "double underscore"),
        ('<xacro:arg name="l" default="5cm"/>${xacro.arg("l") / 2}', "argument l is '5cm', which is not a number; numbers"),
    )),
]  # fmt: skip


@pytest.mark.parametrize(("body", "words"), BAD_XACRO)
def test_bad_xacro_is_refused_with_line_and_reason(body: str, words: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    text = xacro(body)
    with pytest.raises(RobotFileError) as caught:
        parse_robot_text(text)
    assert caught.value.line == (marked_line(text) or caught.value.line)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)
    assert capfd.readouterr() == ("", "")
    # Nothing of the failure stays behind in xacro's module.
    assert parse_robot_text(xacro("")).name == "r"


@pytest.mark.parametrize(
    ("inner", "words"),
    [
        ("<robot>\n<link name='a'>\n</robot><!--!-->", ["well-formed", "<link> of line 2"]),
        ("<robot xmlns:xacro='x'>\n<link name='${oops}'/><!--!-->\n</robot>", ["'oops' is not defined"]),
        ("<!DOCTYPE robot><!--!-->\n<robot/>", ["DOCTYPE"]),
        ("<robot xmlns:xacro='x'>\n<xacro:include filename='inner.xacro'/><!--!-->\n</robot>", ["come to an end"]),
    ],
)
def test_bad_included_file_is_refused_with_file_and_line(folder: Path, inner: str, words: list[str]) -> None:
    (folder / "inner.xacro").write_text(inner)
    outer = folder / "outer.xacro"
    outer.write_text(xacro('<xacro:include filename="inner.xacro"/>'))
    with pytest.raises(RobotFileError) as caught:
        read_robot_file(outer)
    assert (caught.value.file, caught.value.line) == (str(folder / "inner.xacro"), marked_line(inner))
    for word in words:
        assert word in str(caught.value)


def test_xacro_namespaces_and_yaml_are_read(tmp_path: Path) -> None:
    (tmp_path / "sizes.yaml").write_text("rod: {length: 0.5, names: [a, b]}\nangle: !degrees 90\n")
    (tmp_path / "part.xacro").write_text('<robot xmlns:xacro="x"><xacro:property name="k" value="7"/></robot>')
    path = tmp_path / "robot.xacro"
    included = (
        '<xacro:include filename="part.xacro" ns="part"/><xacro:property name="s" value="${xacro.load_yaml(\'sizes.yaml\')}"/>'
    )
    path.write_text(xacro(f"{included}<gazebo>${{part.k}} ${{s.rod.length * 2}} ${{s['rod'].names[0]}} ${{s.angle}}</gazebo>"))
    assert f"<gazebo>7 1.0 a {math.pi / 2}</gazebo>" in read_robot_file(path).urdf


def test_optional_includes_may_be_missing_and_includes_have_parameters(folder: Path) -> None:
    (folder / "inner.xacro").write_text('<robot xmlns:xacro="x"><xacro:arg name="far" default="1"/></robot>')
    outer = folder / "outer.xacro"
    body = '<xacro:include filename="none.xacro" optional="true"/><xacro:include filename="inner.xacro"/>'
    outer.write_text(xacro(body))
    assert read_robot_file(outer, {"far": 2}).warnings == ()
    with pytest.raises(RobotFileError, match="known: far"):
        read_robot_file(outer, {"xyz": 2})


def test_xacro_warnings_are_warnings_of_the_robot(capfd: pytest.CaptureFixture[str]) -> None:
    robot = parse_robot_text(xacro('<xacro:property name="pi" value="3"/><xacro:include filename="none*.xacro"/>'))
    assert "redefining global symbol: pi" in robot.warnings[0]
    assert "none*.xacro" in robot.warnings[1]
    assert all(line.startswith("<text>: ") and line.endswith(".") for line in robot.warnings)
    assert capfd.readouterr() == ("", "")


def test_xacro_files_are_read_in_parallel_threads() -> None:
    def work(index: int) -> None:
        text = xacro('<xacro:arg name="n" default="x"/><material name="$(arg n)"/>')
        assert f'<material name="m{index}"/>' in parse_robot_text(text, parameters={"n": f"m{index}"}).urdf
        with pytest.raises(RobotFileError):
            parse_robot_text(xacro("${oops}"))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, range(8)))


def test_the_example_of_the_documentation_is_read() -> None:
    page = (ROOT / "docs" / "reference" / "robot_format.md").read_text(encoding="utf-8")
    example = re.findall(r"```xml\n(.*?)```", page, re.DOTALL)[0]
    robot = parse_robot_text(example)
    assert (list(robot.beams), list(robot.loops), robot.actuated, robot.warnings) == (["left", "right"], ["c"], ("a",), ())
    assert pin.buildModelFromXML(robot.urdf).nv == 3


def test_reading_urdf_imports_neither_pinocchio_nor_xacro() -> None:
    code = (
        "import sys; from kinetostatics.files.reader import parse_robot_text; parse_robot_text(sys.argv[1]); "
        "assert not {'pinocchio', 'xacro', 'yaml', 'meshcat', 'urllib.request'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, GOOD], check=True)


# random mutations


NUMBERS = ["", "nan", "inf", "-inf", "1e999", "-1", "0", "1e300", "1e-320", "9" * 400, "0 0 0", "1 1", "${1/0}"]
NAMES = ["x", "rod", "hinge", "plate", "&lt;", "fixed", "planar", "$(arg x)", "a:child"]
SOURCES = [
    GOOD,
    XACRO,
    change(change(GOOD, CIRCLE, '<rectangular_tube width="3" height="4" thickness="1"/>'), BEAM,
           BEAM[:-1] + ' y_axis="0 1 0" shear_coefficient="1" thermal_expansion="1e-5" name="b">'),
    change(GOOD, LOOP, LOOP + '<axis xyz="0 0 1"/><axis2 xyz="1 0 0"/><cone angle="1" successor_axis="0 0 1"/>'),
    change(change(GOOD, CIRCLE, '<section area="1" I_y="1" I_z="2" J="1" shear_area_y="1" shear_area_z="1"/>'), BEAM,
           BEAM[:-1] + ' y_axis="0 1 0">'),
]  # fmt: skip


@given(st.data())
def test_mutated_files_are_read_or_refused(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(SOURCES))
    for _ in range(data.draw(st.integers(1, 3))):
        what = data.draw(st.sampled_from(["value", "tag", "delete", "duplicate", "characters"]))
        pattern = {"value": r'(?<==")[^"]*', "tag": r"(?<=[</])\w+"}.get(what, r"<\w+[^<>]*/>|</?\w+[^<>]*>| \w+=\"[^\"]*\"")
        spots = list(re.finditer(pattern, text))
        if not spots:
            continue
        spot = data.draw(st.sampled_from(spots))
        if what == "value":
            new = data.draw(st.sampled_from(NUMBERS + NAMES))
        elif what == "tag":
            new = data.draw(st.sampled_from(["beam", "loop", "link", "joint", "platform", "x", "xacro:if", "origin"]))
        elif what == "characters":
            new = data.draw(st.text(max_size=4))
        else:
            new = "" if what == "delete" else spot.group() * 2
        text = text[: spot.start()] + new + text[spot.end() :]
    try:
        robot = parse_robot_text(text)
    except RobotFileError as error:
        assert str(error).startswith("<text>")
        assert error.line is not None or not text.strip()
    else:
        pin.buildModelFromXML(robot.urdf)
