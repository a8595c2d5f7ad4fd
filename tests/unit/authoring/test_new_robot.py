"""Files written from the notation: sizes, places, sections; in Python and on the command line."""

import json
import re
from math import cos, radians, sin

import numpy as np
import pytest
from places import ROBOTS, ROOT

import kinetostatics as ks
from kinetostatics.authoring.by_name import robot_text
from kinetostatics.authoring.known_names import KNOWN_NAMES
from kinetostatics.authoring.notation import parse_architecture
from kinetostatics.checks.check import diagnose
from kinetostatics.cli.main import main
from kinetostatics.files.bundled import package_folder
from kinetostatics.files.reader import parse_robot_text


def made(architecture, **options):
    """Return a robot without the check that its actuators hold the platform."""
    return ks.Robot(parse_robot_text(robot_text(architecture, **options)))


def ends(robot):
    """Base and platform points of the limbs in the base's frame, where all joints read zero."""
    pose = robot.assemble()
    return [[pose.frame(f"{end}_{i}")[:3, 3] for end in ("foot", "seat")] for i in range(1, len(robot.topology.limbs) + 1)]


def test_radii_and_height_place_the_joints():
    robot = ks.new_robot("3-RPS", base_radius=0.25, platform_radius=0.2, height=0.55)
    for k, (base, platform) in enumerate(ends(robot)):
        azimuth = 2 * np.pi * k / 3
        np.testing.assert_allclose(base, [0.25 * cos(azimuth), 0.25 * sin(azimuth), 0], atol=1e-15)
        np.testing.assert_allclose(platform, [0.2 * cos(azimuth), 0.2 * sin(azimuth), 0.55], atol=1e-15)
    np.testing.assert_allclose(robot.assemble().platform["z"], 0.55)


def test_six_limbs_stand_in_pairs():
    robot = made("6-UPS", base_spread=radians(10), platform_spread=radians(20))
    azimuths = np.degrees([[np.arctan2(y, x) for x, y, _ in pair] for pair in ends(robot)]) % 360
    np.testing.assert_allclose(azimuths[:, 0], [350, 10, 110, 130, 230, 250], atol=1e-9)
    np.testing.assert_allclose(azimuths[:, 1], [320, 40, 80, 160, 200, 280], atol=1e-9)


def test_placements_from_csv_and_from_python_place_limbs(tmp_path):
    rows = [((0.3, 0, 0.01), (0.2, 0, 0)), ((-0.1, 0.3, 0), (-0.1, 0.15, 0)), ((-0.1, -0.3, 0), (-0.1, -0.15, 0))]
    lines = ["base_x, base_y, base_z, platform_x, platform_y, platform_z"]
    lines += [", ".join(map(str, (*base, *platform))) for base, platform in rows]
    table = tmp_path / "table.csv"
    table.write_text("\n".join(lines))
    mappings = [{"base": base, "platform": platform} for base, platform in [*rows, ((0, 0, 0), (0, 0, 0))]]
    for robot in (made("3-UPS+UP", placements=mappings), made("3-RPS", placements=table)):
        for (base, platform), found in zip(rows, ends(robot), strict=False):
            np.testing.assert_allclose(found, [base, (*platform[:2], 0.5)], atol=1e-15)


def test_beams_have_the_given_sections_and_materials():
    robot = made("6-RUS", sections={"crank": "rectangle 20mm 0.06 aluminium", "rod": "tube 30mm 22mm"}, rod_density=8000)
    crank, rod = robot.description.beams["crank_1"], robot.description.beams["rod_6"]
    assert (crank.section.width, crank.section.height, crank.material.density) == (0.02, 0.06, 2700)
    assert (rod.section.outer_diameter, rod.material.youngs_modulus, rod.material.density) == (0.03, 210e9, 8000)
    np.testing.assert_allclose(crank.y_axis, [0, 1, 0])


def test_written_file_has_comments_and_leading_arguments(tmp_path):
    path = tmp_path / "my_robot.urdf.xacro"
    robot = ks.new_robot("3-RPS", path, base_radius=0.25)
    text = path.read_text(encoding="utf-8")
    assert robot.name == "my_robot" and "The notation has no marks of actuators" in text
    assert "has no marks of actuators" not in robot_text("3-R[P]S")
    assert text.index('<xacro:arg name="base_radius" default="0.25"/>') < text.index("<link ")
    assert "O to the limbs' base points B_i" in text and "$(find kinetostatics)/library/limbs.xacro" in text
    assert max(map(len, text.splitlines())) <= 130
    thick = ks.load_robot(path, parameters={"rod_outer_diameter": 0.05})
    assert thick.description.beams["rod_1"].section.outer_diameter == 0.05
    assert text == robot_text("3-RPS", base_radius=0.25, name="my_robot")


def test_new_command_writes_the_file_and_prints_chosen_actuators(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = ["new", "3-RPS", "--base-radius", "250mm", "--height=0.55", "--section", "rod=circle 40mm", "--set", "stroke=100mm"]
    assert main([*command, "--out", "mine.urdf.xacro"]) == 0
    said = capsys.readouterr()
    assert said.out == (
        "mine.urdf.xacro: 3-R[P]S, mobility 3, actuated: prismatic_1, prismatic_2, prismatic_3 "
        "(the usual ones, as none was marked)\n"
    )
    assert main([*command, "--name", "mine"]) == 0
    assert capsys.readouterr().out == (tmp_path / "mine.urdf.xacro").read_text(encoding="utf-8")
    assert main([*command, "--out", "mine.urdf.xacro"]) == 2 and "exists already" in capsys.readouterr().err
    assert main(["check", "mine.urdf.xacro", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mobility"]["platform"] == 3


def test_new_list_prints_all_known_names(capsys):
    assert main(["new", "--list"]) == 0
    assert capsys.readouterr().out.splitlines() == [known.line for known in KNOWN_NAMES]


@pytest.mark.few(8)
@pytest.mark.parametrize("known", KNOWN_NAMES, ids=lambda known: known.name)
def test_every_known_name_makes_a_robot_held_by_actuators(known):
    robot = ks.new_robot(known.name)
    assert parse_architecture(known.architecture).text == known.architecture
    assert robot.mobility.platform == len(robot.description.actuated)
    assert not diagnose(robot).problems and not robot.description.warnings
    assert ks.analyze(robot.assemble(), load=[10, 20, -500, 1, 2, 3]).status == ks.Status.OK


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("Stewart Platform", "6-U[P]S"),
        ("Delta robot", "Delta"),
        ("3-[R](4S)", "Delta"),  # hangs like a Delta
        ("5R", "five-bar"),
        ("agile eye", "spherical 3-RRR"),
        ("3-R[P]R", "planar 3-RPR"),  # planar, as nothing else is called so
    ],
)
def test_names_and_architectures_write_the_same_file(text, same):
    assert robot_text(text) == robot_text(same)


@pytest.mark.parametrize(
    ("limbs", "options"),
    [
        ("3-RPS", {"sections": {"cylinder": "tube 80mm 60mm"}, "actuator_stiffness": 1e7}),
        ("3-CPS", {}),
        ("3-RCS", {}),
        ("3-PRC", {}),
    ],
)
def test_cylindrical_and_divided_limbs_close_at_zero(limbs, options):
    robot = made(limbs, **options)
    robot.configuration(np.array(robot.assemble().q) * 0, closure_tolerance=1e-12)


def test_given_options_override_those_of_a_name():
    assert made("Delta", height=0.4).assemble().platform["z"] == pytest.approx(0.4)
    assert made("3-R[P]R", arrangement="symmetric").mobility.platform == 1


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("3-RRR", 'kinetostatics new "planar 3-RRR" (three arms: two translations and a rotation in a plane) or '
            'kinetostatics new "spherical 3-RRR" ('),
        ("SCARA", "'SCARA' is a serial robot"),
        ("cable robot", "tension only"),
        ("Quattro", "has an articulated platform"),
        ("Bonev", "no mechanism 'Bonev' is known"),
        ("3-RXS", "architecture '3-RXS', place 4 ('X')"),
        ("4-[P]RRR", "can still move: a translation along (0, 0, 1)"),
        ("3-[C]RU", "has 5 freedoms in this placement and only 3 actuators"),
    ],
)  # fmt: skip
def test_ambiguous_or_impossible_architecture_is_a_one_line_error(name, words, tmp_path, capsys):
    out = tmp_path / "none.urdf.xacro"
    assert main(["new", name, "--out", str(out)]) == 2 and not out.exists()
    message = capsys.readouterr().err
    assert words in message and len(message.splitlines()) == 1


def test_lengths_that_look_like_mm_are_errors_or_warnings(tmp_path, capsys):
    out = tmp_path / "large.urdf.xacro"
    for typed, words in (
        ("--base-radius 350", "base_radius = 350 m: lengths are in m; write 0.35 for 350 mm, or 350mm on the command line"),
        ("--set rod_outer_diameter=60", "rod_outer_diameter = 60 m: lengths are in m; write 0.06 for 60 mm, or 60mm"),
    ):
        assert main(["new", "3-RPS", *typed.split(), "--out", str(out)]) == 2
        assert words in capsys.readouterr().err and not out.exists()
    typed = "--base-radius 350m --height 400m --set platform_radius=300m"
    assert main(["new", "3-RPS", *typed.split(), "--out", str(out)]) == 0
    assert "warning: base_radius = 350 m: lengths are in m" in capsys.readouterr().err and out.exists()
    with pytest.warns(UserWarning, match="height = 500 m: lengths are in m; write 0.5 for 500 mm"):
        robot_text("3-RPS", height=500)


def test_wall_thickness_is_a_parameter_of_the_file():
    """The inner diameter follows from the wall thickness, unless the inner diameter is given."""

    def sizes(text, **parameters):
        section = parse_robot_text(text, parameters=parameters).beams["rod_1"].section
        return section.outer_diameter, section.inner_diameter

    tube = robot_text("3-RPS", sections={"rod": "tube 60mm 50mm"})
    assert sizes(tube) == pytest.approx((0.06, 0.05))
    assert sizes(tube, rod_outer_diameter=0.08) == pytest.approx((0.08, 0.07))
    assert sizes(tube, rod_wall_thickness=0.002) == pytest.approx((0.06, 0.056))
    assert sizes(tube, rod_inner_diameter=0.04) == pytest.approx((0.06, 0.04))
    assert sizes(robot_text("3-RPS", rod_wall_thickness=0.001))[1] == pytest.approx(0.032)
    assert sizes(robot_text("3-RPS", rod_inner_diameter=0.02))[1] == 0.02


def test_redundant_actuators_are_warned_of(tmp_path, capsys):
    assert main(["new", "3-[R]RR", "--arrangement", "symmetric", "--out", str(tmp_path / "upright.urdf.xacro")]) == 0
    assert "warning: 3 actuators for mobility 1 brace one another: another --arrangement" in capsys.readouterr().err


def test_new_command_passes_azimuths_and_guide(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "2-PRU+UPR", "--azimuths", "90deg", "-90deg", "0", "--guide", "radial", "--out", "one.urdf.xacro"]) == 0
    found = ends(ks.load_robot("one.urdf.xacro"))
    np.testing.assert_allclose([base for base, _ in found], [[0, 0.3, 0], [0, -0.3, 0], [0.3, 0, 0]], atol=1e-15)


def test_the_library_is_found_from_any_file(tmp_path):
    """``$(find kinetostatics)`` is the folder of robots: a file may also extend one of them."""
    assert (package_folder("kinetostatics") / "library" / "joints.xacro").is_file()
    path = tmp_path / "mine.urdf.xacro"
    path.write_text(
        '<robot name="mine" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="$(find kinetostatics)/3rps.urdf.xacro"/></robot>'
    )
    assert list(ks.load_robot(path).description.beams) == ["rod_1", "rod_2", "rod_3"]


def test_library_joints_turn_about_the_given_axes():
    robot = parse_robot_text(
        """<robot name="joints" xmlns:xacro="http://www.ros.org/wiki/xacro">
          <xacro:include filename="$(find kinetostatics)/library/joints.xacro"/>
          <link name="base"/><link name="middle"/><link name="tip"/>
          <xacro:universal name="u" parent="base" child="middle" cross="cross" first="x" second="z" xyz="1 0 0" angle_max="1"/>
          <xacro:spherical name="s" parent="middle" child="tip" ball="ball" first="y" second="x" xyz="0 0 2" angle_max="0.5"/>
          <platform link="tip"/>
        </robot>"""
    )
    joints = robot.joints
    assert list(joints) == ["u_x", "u_z", "s_y", "s_x", "s_z"]
    assert [joints[name].axis for name in joints] == [(1, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, 1)]
    assert [joints[name].child for name in joints] == ["cross", "middle", "ball_y", "ball_x", "tip"]
    assert (joints["u_z"].upper, joints["s_x"].upper, joints["s_z"].upper) == (1, 0.5, np.pi)


def test_library_page_names_all_macros():
    page = (ROOT / "docs" / "reference" / "xacro_library.md").read_text(encoding="utf-8")
    for file in sorted((ROBOTS / "library").glob("*.xacro")):
        assert f"`{file.name}`" in page
        macros = re.findall(r'<xacro:macro name="(\w+)"', file.read_text(encoding="utf-8"))
        inner = {"ball_rod", "in_limb_frame"}  # parts of others
        assert [name for name in macros if f"`{name}`" not in page and name not in inner] == []


def test_error_of_impossible_triangle_has_a_line():
    with pytest.raises(ks.RobotFileError, match="crank and rod form no triangle") as caught:
        parse_robot_text(robot_text("3-RRS"), parameters={"rod_length": 0.1})
    assert caught.value.line is not None


@pytest.mark.parametrize(
    ("architecture", "options", "words"),
    [
        ("3-RPS", {"base_radius": -1}, "base_radius is -1; it must be greater than zero"),
        ("3-RPS", {"height": "x"}, "height is 'x'; it must be a number"),
        ("3-RPS", {"foo": 1}, "has no value 'foo'"),
        ("3-UPS", {"rod_length": 1}, "'rod_length': it follows from height and radii"),
        ("3-RPS", {"rod_wall_thickness": 1e-3, "rod_inner_diameter": 0.02}, "both given"),
        ("3-RRS", {"crank_angle": 1, "rod_length": 1}, "both given"),
        ("3-RRS", {"crank_length": 0.01}, "form no triangle"),
        ("3-RPS", {"sections": {"rd": "circle 20mm"}}, "has no 'rd'; did you mean 'rod'"),
        ("3-RPS", {"sections": {"rod": "pipe 3mm"}}, "is no shape"),
        ("3-RPS", {"sections": {"rod": "circle 20mm oak"}}, "is no material"),
        ("3-RPS", {"sections": {"rod": "tube 50mm 60mm"}}, "not smaller than the outer one"),
        ("3-RPS", {"sections": {"rod": "rectangular_tube 20mm 20mm 10mm"}}, "must be less than half"),
        ("3-RPS", {"sections": {"rod": "circle 20kg"}}, "'20kg' is not a length"),
        ("3-RPS", {"azimuths": (0, 1)}, "azimuths has 2 values"),
        ("3-RPS", {"placements": [((0, 0, 0), (0, 0, 0))] * 3}, "limb 1: .* is not a row"),
        ("3-RPS", {"placements": [{}]}, "one row for each of the 3 limbs"),
        ("4-UPS", {"arrangement": "cartesian"}, "for three limbs, along X, Y and Z"),
        ("3-RPR", {"arrangement": "spherical"}, "for limbs of three revolute joints"),
        ("spherical 3-RRR", {"crank_arc": 0.1, "rod_arc": 0.1}, "do not reach from its first axis to its last"),
    ],
)
def test_wrong_values_are_errors(architecture, options, words):
    with pytest.raises(ks.ArgumentError, match=words):
        robot_text(architecture, **options)


@pytest.mark.parametrize("limbs", ["4-PRR", "4-R[P]R", "5-[P]RR"])
def test_more_planar_limbs_are_planar(limbs):
    """Arranged around Z with other axes, four such limbs leave one freedom."""
    robot = ks.new_robot(limbs)
    assert robot.mobility.platform == 3 and len(robot.description.actuated) == int(limbs[0])
    moved = robot.mobility_analysis.platform_motions(robot.zero_poses)
    assert np.abs(moved[2:5]).max() < 1e-9  # no z, rx, ry
    assert ks.new_robot(limbs, arrangement="symmetric").mobility.platform == 1
