"""Robots that are written to a file load as the same robots."""

import copy
import math
import pickle
import xml.etree.ElementTree as ET
from pathlib import Path

import hybrid_robots as hr
import numpy as np
import pytest
import small_robots as sr
from hypothesis import given, settings
from hypothesis import strategies as st
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.description import Joint, Link, Loop, RobotDescription
from kinetostatics.files.reader import parse_robot_text

#: Every element and attribute of the format, and elements for other tools.
EVERYTHING = """<?xml version="1.0" encoding="utf-8"?>
<robot name="ü &lt;&quot;&amp;'" version="1.0" xmlns:gz="urn:gazebo">
  <link name="world"/>
  <link name="ground">
    <visual name="v"><origin xyz="0.1 0 1e-3" rpy="0 0 0.1"/><geometry><box size="1 1 0.1"/></geometry>
      <material name="grey"/></visual>
    <collision><geometry><sphere radius="0.5"/></geometry></collision>
  </link>
  <link name="arm"><inertial><origin xyz="0 0.1 0.5" rpy="0.1 0.2 -0.3"/><mass value="2.3"/>
    <inertia ixx="1" ixy="-0.1" ixz="0.01" iyy="1.1" iyz="1e-3" izz="0.9"/></inertial></link>
  <link name="rod"/><link name="box"/><link name="plate"/><link name="follower"/><link name="sledge"/><link name="floor"/>
  <link name="massless"><inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="on the ground" type="fixed">
    <parent link="world"/><child link="ground"/><origin xyz="0 0 0.3333333333333333" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="motor" type="revolute"><parent link="ground"/><child link="arm"/><origin xyz="-0.5 0 0"/><axis xyz="0.6 0 -0.8"/>
    <limit lower="-1" upper="0.1" effort="10" velocity="2.5"/><dynamics damping="0.1" friction="0.2"/>
    <safety_controller k_velocity="1" k_position="2" soft_lower_limit="-0.9" soft_upper_limit="0"/><calibration rising="0.1"/>
  </joint>
  <joint name="elbow" type="continuous"><parent link="arm"/><child link="rod"/><origin xyz="0 0 1"/><axis xyz="0 -1 0"/></joint>
  <joint name="wrist" type="continuous"><parent link="rod"/><child link="plate"/><origin xyz="0 1 0"/><axis xyz="0 1 0"/>
    <limit effort="3" velocity="0"/></joint>
  <joint name="rail" type="prismatic"><parent link="ground"/><child link="box"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit effort="0" velocity="0"/></joint>
  <joint name="table" type="planar"><parent link="ground"/><child link="sledge"/><axis xyz="0 0 -1"/></joint>
  <joint name="free" type="floating"><parent link="ground"/><child link="floor"/></joint>
  <joint name="gear" type="continuous"><parent link="ground"/><child link="follower"/>
    <mimic joint="motor" multiplier="-0.3333333333333333" offset="0.1"/></joint>
  <joint name="bolt" type="fixed"><parent link="plate"/><child link="massless"/></joint>
  <base link="ground"/>
  <platform link="plate"><origin xyz="0 0 0.1" rpy="0.1 -0.2 0.3"/></platform>
  <loop name="l fixed" type="fixed"><predecessor link="box"/><successor link="sledge"><origin rpy="0 0 -0.0"/></successor></loop>
  <loop name="l revolute" type="revolute"><predecessor link="box"><origin xyz="0 0 1.1"/></predecessor><successor link="plate"/>
    <axis xyz="0 0 1"/><limit lower="-1e-3" upper="2" effort="1"/></loop>
  <loop name="l continuous" type="continuous"><predecessor link="box"/><successor link="floor"/><limit velocity="2"/></loop>
  <loop name="l prismatic" type="prismatic"><predecessor link="box"/><successor link="floor"/><limit lower="-1" upper="1"/></loop>
  <loop name="l cylindrical" type="cylindrical"><predecessor link="box"/><successor link="floor"/><axis xyz="0 0.6 0.8"/></loop>
  <loop name="l universal" type="universal"><predecessor link="floor"/><successor link="plate"/><axis2 xyz="0.6 0 0.8"/>
    <cone angle="0.7" predecessor_axis="0.8 0.6 0" successor_axis="0 0.6 0.8"/></loop>
  <loop name="l spherical" type="spherical"><predecessor link="floor"/><successor link="plate"/>
    <cone angle="3.14159265358979"/></loop>
  <loop name="l planar" type="planar"><predecessor link="floor"/><successor link="sledge"/><axis xyz="0 0 -1"/></loop>
  <beam link="arm" from="motor" to="elbow" youngs_modulus="210e9" poisson_ratio="0.3" density="7850" thermal_expansion="1.2e-5">
    <circle diameter="0.02"/></beam>
  <beam link="rod" name="rod again" youngs_modulus="70e9" shear_modulus="26e9" shear_coefficient="0.5"
    from="elbow" to="wrist"><tube outer_diameter="0.03" inner_diameter="0.021"/></beam>
  <beam link="box" from="rail:child" to="l revolute" youngs_modulus="1e9" poisson_ratio="-0.2" shear_coefficient="inf"
    y_axis="0.6 0.8 0" density="0"><rectangle width="0.02" height="0.05"/></beam>
  <beam link="sledge" from="table:parent" to="l planar" youngs_modulus="2e9" poisson_ratio="0.5" y_axis="0.8 0.6 0" density="1">
    <rectangular_tube width="0.04" height="0.05" thickness="0.003"/></beam>
  <beam link="floor" from="free" to="l spherical" youngs_modulus="2e9" shear_modulus="1e9" y_axis="0 1 0" density="1">
    <section area="0.001" I_y="1e-7" I_z="2e-7" J="3e-7" shear_area_y="8e-4" shear_area_z="7e-4"/></beam>
  <beam link="floor" name="floor 2" from="free" to="l universal" youngs_modulus="2e9" poisson_ratio="0.1" density="1"
    shear_coefficient="1"><section area="0.001" I_y="1e-7" I_z="1e-7" J="3e-7"/></beam>
  <joint_stiffness joint="motor" drive="12345.678" linear="1e8 inf 2e8" angular="1e5 1e5 1e5"/>
  <joint_stiffness joint="rail" linear="1e8 1e8 0"/>
  <joint_stiffness joint="l spherical" angular="1 0 inf"/>
  <joint_stiffness joint="bolt" linear="inf inf inf"/>
  <joint_stiffness joint="l prismatic" drive="inf"/>
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <gazebo reference="arm"><gz:sensor type="ray"> <!-- lost --> text &lt; &amp; <gz:on>1</gz:on></gz:sensor></gazebo>
  <transmission name="drives"><type>SimpleTransmission</type>
    <joint name="motor"><hardwareInterface>EffortJointInterface</hardwareInterface></joint><joint name="elbow"/>
    <actuator name="m"><mechanicalReduction>100</mechanicalReduction></actuator></transmission>
  <transmission name="drive_l prismatic"><joint name="l prismatic"/></transmission>
  <transmission name="own name"><joint name="l revolute"/></transmission>
</robot>
"""


def saved(robot: ks.Robot | RobotDescription, folder: Path, name: str = "saved.urdf") -> RobotDescription:
    """Write a robot to a file and return the description that is read from it."""
    ks.save_robot(robot, folder / name)
    return ks.files.read_robot_file(folder / name)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", sorted(path.name.removesuffix(".urdf.xacro") for path in ROBOTS.glob("*.urdf.xacro")))
def test_saved_package_robots_read_back_equal(name: str, tmp_path: Path) -> None:
    robot = ks.load_robot(name)  # as fresh as the one that is read back
    description = saved(robot, tmp_path)
    assert description == robot.description and description.warnings == robot.description.warnings
    assert description.urdf == robot.description.urdf
    one, other = (ks.analyze(item.assemble(), (1, 2, 3, 4, 5, 6)).to_dict() for item in (robot, ks.Robot(description)))
    assert {**one, "file": ""} == {**other, "file": ""}


def test_saved_file_keeps_every_element_and_attribute(tmp_path: Path) -> None:
    description = parse_robot_text(EVERYTHING, str(tmp_path / "everything.urdf"))
    again = saved(description, tmp_path)
    assert again == description and again is not description
    assert again.urdf == description.urdf
    for part in ("links", "joints", "loops", "beams", "joint_stiffness"):
        assert list(getattr(again, part)) == list(getattr(description, part))
    assert again.actuated == description.actuated == ("motor", "elbow", "l prismatic", "l revolute")
    # every element, attribute and text of the source is there, also those that the reader ignores
    assert lines(ET.fromstring(EVERYTHING)) <= lines(ET.parse(tmp_path / "saved.urdf").getroot())


def lines(element: ET.Element, path: str = "", number: int = 0) -> set[str]:
    """Return a line for every element, attribute and text of an element, numbers as floats."""
    key = next((element.get(name) for name in ("name", "link", "joint") if element.get(name)), "")
    path = f"{path}/{element.tag}[{key}]" if path else element.tag
    found = {path}
    for name, value in element.attrib.items():
        found.add(f"{path}.{name}={readable(value)}")
    if element.text and element.text.strip():
        found.add(f"{path}:{element.text.strip()}")
    for child in element:
        found |= lines(child, path)
    return found


def readable(value: str) -> str:
    try:
        return " ".join(repr(float(item) + 0.0) for item in value.split())
    except ValueError:
        return value


def test_normalised_values_read_back_equal() -> None:
    text = EVERYTHING.replace('<axis xyz="0.6 0 -0.8"/>', '<axis xyz="1 2 -2"/>').replace('"0.8 0.6 0" succ', '"1 1 1e-9" succ')
    description = parse_robot_text(
        text.replace("3.14159265358979", "3.1415926536").replace('lower="-1" upper="0.1" ', 'lower="-1" ')
    )
    assert description.joints["motor"].axis == (1 / 3, 2 / 3, -2 / 3)
    assert parse_robot_text(description.urdf) == description


@settings(max_examples=30, deadline=None)
@given(st.tuples(*[st.floats(-1e30, 1e30) | st.floats(-1, 1)] * 3).filter(any))
def test_directions_read_back_equal(axis: tuple[float, float, float]) -> None:
    loop = Loop("l", "revolute", "a", "b", axis=axis)
    links, joint = [Link("a"), Link("b")], Joint("j", "floating", "a", "b")
    one = ks.description.validate(RobotDescription.of("r", links=links, joints=[joint], loops=[loop], platform="b"))
    assert math.hypot(*one.loops["l"].axis) == pytest.approx(1, abs=1e-15)
    assert parse_robot_text(one.urdf).loops["l"].axis == one.loops["l"].axis


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_saved_random_robots_read_back_equal(seed: int, tmp_path: Path) -> None:
    """Files in random cuts with link frames turned at random, half of them with elastic joints and limbs of any shape."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        kinds = list(rng.choice(["RpS", "UpS", "pUS", "pRU", "UpR", "SpR", "rUU", "CrS"], 3))
        file = sr.write(sr.random_spec(kinds, seed), twirl=seed, whole=bool(rng.integers(2)), flip=bool(rng.integers(2)))
    else:
        _, file = hr.write_randomly(hr.random_hybrid(seed, 0.5), seed)
    robot = ks.Robot(parse_robot_text(file.text))
    assert saved(robot, tmp_path) == robot.description


# ---- files ---------------------------------------------------------------------------------------------------------------


def test_mesh_paths_are_adapted_to_the_new_folder(tmp_path: Path) -> None:
    mesh = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    meshes = [mesh.format(name) for name in ("part.stl", "meshes/a&amp;b.dae", "package://robot/x.stl", "/abs/y.stl")]
    text = EVERYTHING.replace('<link name="rod"/>', f'<link name="rod">{"".join(meshes)}</link>')
    (tmp_path / "one" / "two").mkdir(parents=True)
    source = tmp_path / "one" / "robot.urdf"
    source.write_text(text, encoding="utf-8")
    description = ks.files.read_robot_file(source)
    assert saved(description, tmp_path / "one") == description
    moved = saved(description, tmp_path / "one" / "two").links["rod"].extra
    names = [item.get("filename") for item in ET.fromstring(f"<x>{moved}</x>").iter("mesh")]
    assert names == ["../part.stl", "../meshes/a&b.dae", "package://robot/x.stl", "/abs/y.stl"]
    back = ks.files.read_robot_file(tmp_path / "one" / "two" / "saved.urdf")
    assert saved(back, tmp_path / "one").links["rod"].extra == description.links["rod"].extra


def test_unwritable_paths_are_refused(tmp_path: Path) -> None:
    description = parse_robot_text(EVERYTHING)
    source = tmp_path / "robot.xacro"
    source.write_bytes((ROBOTS / "3rps.urdf.xacro").read_bytes())
    for path, words in [
        (source, "uses xacro"),
        (tmp_path, "cannot be written"),
        (tmp_path / "none" / "x.urdf", "cannot be written: No such file"),
        ("a\0b", "null"),
    ]:
        with pytest.raises(ks.ArgumentError, match=words):
            ks.save_robot(description, path)
    assert source.read_bytes() == (ROBOTS / "3rps.urdf.xacro").read_bytes()
    assert saved(description, tmp_path, "twice.urdf") == saved(description, tmp_path, "twice.urdf")


def test_descriptions_can_be_copied() -> None:
    description = parse_robot_text(EVERYTHING)
    assert copy.deepcopy(description) == pickle.loads(pickle.dumps(description)) == copy.copy(description) == description
