"""Hints at numbers that seem to be in degrees, mm or GPa, wherever they are given."""

import re
import warnings

import odd_robots
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.checks.check import diagnose
from kinetostatics.cli.main import main
from kinetostatics.files.bundled import shipped_robots
from kinetostatics.files.reader import parse_robot_text

RPS = shipped_robots()["3rps"].read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("3rps")


def said_of(robot):
    """Return the warnings of check, and those of an analysis."""
    pose = robot.assemble(closure_tolerance=10)
    return "\n".join(diagnose(robot).warnings), "\n".join(ks.analyze(pose, on_failure="nan").warnings)


# ---- coordinates -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        ({"platform": {"z": 0.5, "rx": 8, "ry": 0}}, "rx = 8 rad is 1.27 turns: angles are in rad; write 0.139626 for"),
        ({"actuators": {"prismatic_1": 100, "prismatic_2": 0, "prismatic_3": 0}}, "prismatic_1 = 100 m is 114 times the"),
    ],
)
def test_errors_of_assemble_suggest_other_units(robot, given, hint):
    with warnings.catch_warnings(), pytest.raises(ks.AssemblyError) as caught:
        warnings.simplefilter("error")
        robot.assemble(**given)
    assert hint in str(caught.value) and "assembly mode" not in str(caught.value)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", sorted(shipped_robots()))
def test_ordinary_coordinates_cause_no_unit_warnings(name):
    robot = package_robots.robot(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pose = robot.assemble()
        robot.assemble(actuators=dict(pose.actuators))
        assert not re.search(r"look like|are in (m|rad|Pa|kg)|m large", "\n".join(diagnose(robot).warnings))
        if robot.mobility.platform == 6:
            robot.assemble(platform=pose.platform_coordinates("XYZ"), orientation="XYZ", on_failure="nan")


def test_tool_tips_in_millimetres_cause_a_warning(robot):
    pose = robot.assemble()
    result = ks.analyze(pose)
    with pytest.warns(UserWarning, match=r"point lies 200 m from o, 229 times .* write 0\.2 for 200 mm, or 200mm on"):
        result.at_point((0, 0, 200))
    with pytest.warns(UserWarning, match=r"tool lies 50 m from o, .* write -0\.05 for -50 mm") as told:
        found = ks.compensate(pose, tool=(0, -50, 0))
    assert len(told) == 1 and told[0].filename == __file__
    with pytest.warns(UserWarning, match=r"tool lies 50 m from o") as told:
        ks.tolerances(pose, tool=(0, -50, 0))
    assert len(told) == 1 and told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "tip" in str(found)  # which does not say it again
        ks.compensate(pose, tool=(0, 0, 0.2))
        result.at_point((0, 0, 8))


def test_command_prints_unit_warnings_in_one_line(capsys):
    assert main("analyze 3rps --tool 0 0 200".split()) == 0
    assert capsys.readouterr().err.count("kinetostatics: warning: point lies 200 m from o") == 1
    assert main("analyze delta --platform x=0 y=0 z=-90".split()) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "write -0.09 for -90 mm, or -90mm on" in err


# ---- files -------------------------------------------------------------------------------------------------------------


def changed(old, new, text=RPS, count=1):
    assert old in text
    return ks.Robot(parse_robot_text(text.replace(old, new, count)))


def test_rpy_in_degrees_causes_a_warning():
    text = odd_robots.four_bar()
    found = re.search(r'<joint name="head".*?rpy="([^"]*)"', text, re.DOTALL)
    text = text[: found.start(1)] + "0 90 0" + text[found.end(1) :]
    robot = ks.Robot(parse_robot_text(text))
    for said in said_of(robot):
        assert re.search(r"<text>:\d+: rpy='0 90 0' of the joint 'head' looks like degrees: angles are in rad", said)
        assert "assembly mode" not in said
    assert "Angles in degrees would explain this" in said_of(robot)[0]


def test_limits_in_degrees_and_mm_cause_warnings():
    angles = changed('lower="-10" upper="10"', 'lower="-60" upper="60"', odd_robots.four_bar())
    lengths = changed('name="rod_length_max" default="1.0"', 'name="rod_length_max" default="1000"')
    for said in said_of(angles):
        assert "the limits -60 60 of 'foot' look like degrees: angles are in rad" in said
    for said in said_of(lengths):
        assert "the limits of prismatic_1, prismatic_2, prismatic_3 go to 999.45 m, 1.14e+03 times the robot's size" in said


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"youngs_modulus": 2e5}, "2e+05 Pa; moduli are in Pa (steel: 2.1e11): 2e+05 MPa is 2e+11"),
        ({"density": 7.8e-9}, "7.8e-09 kg/m³; densities are in kg/m³ (steel: 7850): 7.8e-09 t/mm³ is 7800, and lengths are in m"),
    ],
)
def test_moduli_and_densities_in_other_units_cause_warnings(parameters, words):
    for said in said_of(ks.load_robot("3rps", parameters)):
        assert (
            f"beams rod_1, rod_2 and rod_3 have a {'density' if 'density' in parameters else 'Young'}" in said and words in said
        )


def test_wide_limits_of_screw_motors_cause_no_warning():
    limit = '<limit lower="-100" upper="100" effort="1" velocity="1"/>'
    motor = f'<joint name="motor" type="revolute"><parent link="base"/><child link="cap"/>{limit}</joint><link name="cap"/>'
    nut = motor.replace("motor", "nut").replace("cap", "cup").replace("</joint>", '<mimic joint="motor"/></joint>')
    for joints, expected in ((motor, True), (motor + nut, False)):
        text = RPS.replace("</robot>", f'{joints}<transmission name="m"><joint name="motor"/></transmission></robot>')
        assert ("'motor' look like degrees" in said_of(ks.Robot(parse_robot_text(text)))[0]) == expected


@pytest.mark.slow
def test_tolerances_in_millimetres_cause_a_warning(robot):
    """Numbers without a unit near the robot's size; smaller ones or those with a unit cause none."""
    pose = robot.assemble()
    with pytest.warns(UserWarning, match=r"rod_1.outer_diameter = 0.03 m is 0.3 times the length itself of 0.1 m") as told:
        ks.tolerances(pose, {"rod_1.outer_diameter": 0.03}, samples=2)
    assert len(told) == 1 and told[0].filename == __file__ and "write 3e-05 for 0.03 mm, or 0.03mm on" in str(told[0].message)
    with pytest.warns(UserWarning, match=r"platform.center_of_mass.x = 0.5 m is .* the robot's size of"):
        ks.tolerances(pose, {"platform.center_of_mass.x": "0.5"}, samples=2)
    with pytest.warns(UserWarning) as told:
        ks.tolerances(pose, {"*.error.[xyz]": 1, "*.error.r?": 0.5}, samples=2)
    assert [item.filename for item in told] == [__file__] * 2
    assert "revolute_1.error.x = 1 m is 1.14 times the robot's size of 0.875 m: lengths are in m" in str(told[0].message)
    assert "revolute_1.error.rx = 0.5 rad is 28.6°: angles are in rad; write 0.0005 for" in str(told[1].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ks.tolerances(pose, {"*.error.[xyz]": 0.01, "*.error.r?": 0.1}, samples=2)
        ks.tolerances(
            pose, {"rod_1.outer_diameter": "30mm", "rod_2.outer_diameter": "30%", "rod_3.outer_diameter": 0.001}, samples=2
        )


def test_file_parameters_in_millimetres_cause_a_warning():
    with pytest.warns(UserWarning, match=r"^rod_diameter = 80 m is 800 times the file's own 0.1 m: ") as told:
        ks.load_robot("3rps", {"rod_diameter": 80})
    assert len(told) == 1 and told[0].filename == __file__ and "write 0.08 for 80 mm" in str(told[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ks.load_robot("3rps", {"rod_diameter": "0.2", "density": 8000, "youngs_modulus": 7e13, "rod_length_max": 3})
