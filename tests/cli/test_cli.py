"""The command line: standard output and error, exit codes, and errors in one line."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import odd_robots
import package_robots
import pytest
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.cli.inputs import parse_items, parse_parameters, parse_quantity
from kinetostatics.cli.main import COMMANDS, main
from kinetostatics.files.bundled import robot_path, shipped_robots

#: configuration 2 of the 3RPS in the paper
CONFIGURATION_2 = "--platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion --gravity 0 0 -9.8".split()
#: "recovered" values of paper_tables.json
TWIST = [4.96878e-08, 5.26152e-08, -7.411e-08, 5.25908e-08, -2.22135e-08, 2.58967e-08]
DRIVES = [385.4348, 364.7818, 367.832]


def run(capsys, *arguments):
    """Run the command line in this process; return exit code, standard output and standard error."""
    code = main([str(item) for item in arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def fails(capsys, *arguments):
    """Run a command that must fail, and return its one line on standard error."""
    code, out, err = run(capsys, *arguments)
    assert code == 2 and out == ""
    assert err.startswith("kinetostatics: error: ") and err.count("\n") == 1 and err.endswith("\n")
    return err


def process(*arguments, **options):
    options = {"capture_output": True, "text": True, "encoding": "utf-8", "timeout": 60, **options}
    return subprocess.run([sys.executable, "-m", "kinetostatics", *map(str, arguments)], check=False, **options)


# ---- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("", None, "not a number"),
        ("inf", None, "not a number"),
        ("1,5", None, "not a number"),
        ("2inch", None, "unknown unit 'inch'"),
        ("2deg", "length", "a length is needed"),
        ("2mm", "angle", "an angle is needed"),
        ("2mm", "number", "a plain number is needed"),
    ],
)
def test_invalid_quantities_are_errors(text, kind, message):
    with pytest.raises(ks.ArgumentError, match=message):
        parse_quantity(text, kind)


def test_name_value_items_are_parsed():
    assert parse_items("--set", ["a=1", " b = x=y "]) == {"a": "1", "b": "x=y"}
    assert parse_parameters(["d=80mm", "n=3", "name=two words", "angle=${pi}", "t=5nmi", "E=70GPa"]) == {
        "d": 0.08,
        "n": "3",
        "name": "two words",
        "angle": "${pi}",
        "t": "5nmi",
        "E": 70e9,
    }
    for bad in (["a"], ["=1"], ["a="], [""]):
        with pytest.raises(ks.ArgumentError, match="name=value"):
            parse_items("--set", bad)
    with pytest.raises(ks.ArgumentError, match="'a' is given twice"):
        parse_items("--set", ["a=1", "a=2"])


# ---- robots ----------------------------------------------------------------------------------------------------------


def test_shipped_robots_are_found_by_name():
    assert set(shipped_robots()) == {path.name.removesuffix(".urdf.xacro") for path in ROBOTS.glob("*.urdf.xacro")}
    assert robot_path("3rps").samefile(ROBOTS / "3rps.urdf.xacro")
    assert robot_path(ROBOTS / "2pru_upr.urdf.xacro") == ROBOTS / "2pru_upr.urdf.xacro"
    with pytest.raises(ks.RobotFileError, match="Is a directory"):
        robot_path(ROBOTS)


@pytest.mark.parametrize(
    "call",
    [robot_path, ks.load_robot, lambda path: ks.sweep(path, {"z": [0.5]}), lambda path: ks.optimize(path, {"a": "1mm:2mm"})],
    ids=["path", "load_robot", "sweep", "optimize"],
)
def test_missing_robot_file_has_one_error_with_a_suggestion(call):
    with pytest.raises(ks.RobotFileError, match=r"^3rsp: the file cannot be read: No such file .* did you mean '3rps'"):
        call("3rsp")


def test_local_file_precedes_a_shipped_robot(tmp_path, monkeypatch):
    (tmp_path / "3rps").write_text((ROBOTS / "2pru_upr.urdf.xacro").read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert robot_path("3rps") == Path("3rps")


# ---- help ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_has_an_example(capsys, command):
    code, out, err = run(capsys, *command, "--help")
    assert code == 0 and err == ""
    assert "usage: kinetostatics" in out and "examples:\n  kinetostatics" in out


def test_version_is_printed(capsys):
    assert run(capsys, "--version") == (0, f"kinetostatics {ks.__version__}\n", "")


# ---- check -----------------------------------------------------------------------------------------------------------


def test_check_prints_the_limbs(capsys):
    code, out, err = run(capsys, "check", "3rps")
    assert code == 0 and err == "" and "limb_1: R P(actuated) S" in out


def test_check_of_an_unanalysable_robot_exits_with_1(capsys, tmp_path):
    path = tmp_path / "open.urdf"
    ks.save_robot(odd_robots.open_loops(), path)
    code, out, err = run(capsys, "check", path)
    assert code == 1 and err == "" and "Cannot be analysed\n  ! the loops of 'four_bar' cannot be closed" in out
    code, out, err = run(capsys, "check", path, "--json")
    assert code == 1 and json.loads(out)["mobility"] is None
    assert err.startswith("kinetostatics: warning: the loops of 'four_bar' cannot be closed")


# ---- analyze ---------------------------------------------------------------------------------------------------------


def test_analyze_json_equals_the_result(capsys):
    code, out, err = run(capsys, "analyze", "3rps", *CONFIGURATION_2, "--json")
    assert code == 0 and err == ""
    found = json.loads(out)
    np.testing.assert_allclose(found["twist"], TWIST, rtol=1e-5)
    np.testing.assert_allclose([found["actuator_forces"][f"prismatic_{k}"] for k in (1, 2, 3)], DRIVES, atol=6e-5)
    robot = ks.load_robot(ROBOTS / "3rps.urdf.xacro")
    pose = robot.assemble(platform={"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)}, orientation="tilt_torsion")
    expected = ks.analyze(pose, gravity=(0, 0, -9.8)).to_dict()
    expected["file"] = found["file"]
    np.testing.assert_allclose(found.pop("twist"), expected.pop("twist"), rtol=1e-12)
    assert found.keys() == expected.keys()
    assert found["limbs"].keys() == expected["limbs"].keys()
    # arrays stand in one line each, so that the output can be read
    assert max(map(len, out.splitlines())) < 6000 and len(out.splitlines()) > 100


def test_default_pose_closes_where_zero_actuators_do_not(capsys, tmp_path):
    path = tmp_path / "stretched.urdf"
    ks.save_robot(odd_robots.drive_out_of_reach(), path)
    code, out, err = run(capsys, "analyze", path)
    assert code == 0, err
    assert out.startswith("! the loops do not close with all actuators at zero")
    code, out, err = run(capsys, "analyze", path, "--json")
    assert code == 0 and err.startswith("kinetostatics: warning: the loops do not close with all actuators at zero")
    assert json.loads(out)["warnings"][0].startswith("the loops do not close")
    assert "cannot reach slide = 0" in fails(capsys, "analyze", path, "--actuators", "slide=0")


def test_actuators_accept_units_and_negative_values(capsys):
    options = "--actuators prismatic_1=-1e-2 prismatic_2=20mm --actuators prismatic_3=-.005m --json"
    code, out, _ = run(capsys, "analyze", "3rps", *options.split())
    assert code == 0
    actuators = json.loads(out)["configuration"]["actuators"]
    assert list(actuators.values()) == pytest.approx([-0.01, 0.02, -0.005], abs=1e-12)


def test_load_at_a_point_is_moved_to_o(capsys):
    options = "--load 0 0 -1e3 -.5 0 0 --point 100mm -20um 0 --frame platform --gravity 0 0 0 --json".split()
    code, out, err = run(capsys, "analyze", "3rps", *options)
    assert code == 0, err
    np.testing.assert_allclose(json.loads(out)["load"], [0, 0, -1000, -0.5 + 20e-6 * 1000, 100, 0], atol=1e-11)


def test_limit_warnings_are_in_report_or_standard_error(capsys):
    arguments = ["analyze", "3rps", "--platform", "z=1.5", "rx=0", "ry=0"]
    code, out, err = run(capsys, *arguments)
    assert code == 0 and err == "" and "! prismatic_1 is beyond its limits" in out
    code, out, err = run(capsys, *arguments, "--json")
    assert code == 0 and len(json.loads(out)["warnings"]) == 3
    assert [line.startswith("kinetostatics: warning: prismatic_") for line in err.splitlines()] == [True] * 3


def test_near_selects_the_assembly_mode(capsys):
    """For the same point of the tool the actuators of two modes differ by more than half a turn."""
    robot = package_robots.robot("five_bar")
    arguments = ["analyze", "five_bar", "--platform", "x=0", "y=-300mm", "--json"]
    modes = []
    for near in ({}, {"platform": {"x": -0.2, "y": 0.0}}, {"actuators": {"shoulder_1": 0.3, "shoulder_2": 0.2}}):
        start = robot.assemble(**near)
        words = [f"{name}={value}" for values in near.values() for name, value in values.items()]
        found = json.loads(run(capsys, *arguments, *(["--near", *words] if near else []))[1])["configuration"]["actuators"]
        wanted = robot.assemble(platform={"x": 0, "y": -0.3}, near=start).actuators
        assert found == pytest.approx({name: float(value) for name, value in wanted.items()}, abs=1e-9)
        modes.append(found["shoulder_1"])
    assert modes[0] == pytest.approx(modes[2]) and abs(modes[1] - modes[0]) > np.pi


# ---- errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("", "COMMAND"),
        ("chek 3rps", "there is no command 'chek'; did you mean 'check'?"),
        ("check", "ROBOT is missing; it comes before the options"),
        ("check 3rps --fast", "unrecognized arguments: --fast"),
        ("check 3rp", "3rp: the file cannot be read: No such file"),
        ("check 3rps --set rod_diameter=0.1 rod_diameter=0.2", "'rod_diameter' is given twice"),
        ("analyze 3rps --platform z=0.5 rx=0", "the mobility of '3rps' is 3"),
        ("analyze 3rps --platform z=0.5 rx=0 ry=two", "--platform: ry: 'two' is not a number"),
        ("analyze 3rps --platform z=5deg rx=0 ry=0", "--platform: z: '5deg' is an angle, but a length is needed"),
        ("analyze 3rps --platform z=0.5 rx=0 ry=0 --actuators prismatic_1=0", "not allowed with argument"),
        ("analyze 3rps --actuators prismatic_1=0 prismatic_2=0", "missing for prismatic_3"),
        ("analyze 3rps --actuators prismatic_1=1deg prismatic_2=0 prismatic_3=0", "a length is needed"),
        ("analyze 3rps --load 0 0 -1e3", "expected 6 arguments"),
        ("analyze 3rps --load 0 0 -1e3 0 0 5mm", "a moment is needed"),
        ("analyze 3rps --gravity 0 0 down", "--gravity: 'down' is not a number"),
        ("analyze 3rps --near z=5deg rx=0 ry=0", "--near: z: '5deg' is an angle, but a length is needed"),
        ("analyze 2pru_upr --platform z=0.6 rx=0 ry=0 --near z=3 rx=0 ry=0", "--near: '2pru_upr' (mobility 3) cannot reach"),
        ("export five_bar --scalar half --out c", "scalar is 'half'"),
        ("export five_bar --platform x y --by x --out c", "name the outputs to differentiate with --jacobian"),
        ("export five_bar --compensate --out c", "needs platform="),
        ("analyze 3rps --plattform z=-5mm", "unrecognized arguments: --plattform z=-5mm (see kinetostatics analyze --help)"),
    ],
)
def test_errors_are_one_line(capsys, arguments, message):
    assert message in fails(capsys, *arguments.split())


# ---- as a program ----------------------------------------------------------------------------------------------------


def test_analyze_imports_no_heavy_packages():
    code = (
        "import sys; from kinetostatics.cli.main import main; main(['analyze', '3rps']); "
        "heavy = {'yourdfpy', 'meshcat', 'trimesh', 'scipy', 'xarray', 'dask', 'pandas', 'urllib.request'}; "
        "assert not heavy & set(sys.modules), 'heavy imports'"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr


def test_ascii_terminals_get_replaced_characters():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = process("analyze", "3rps", *CONFIGURATION_2, env=environment)
    assert done.returncode == 0 and done.stderr == "" and "?m" in done.stdout


@pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")
def test_unwritable_standard_output_has_its_exit_codes():
    done = process("robots", stdout=open("/dev/full", "w"), capture_output=False, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "kinetostatics: error: No space left on device\n"
    reader, writer = os.pipe()
    os.close(reader)
    done = process("robots", "--json", stdout=writer, capture_output=False, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode == 1 and done.stderr == ""


def test_tolerances_prints_the_largest_effects_only(capsys):
    code, out, _ = run(capsys, "tolerances", "2pru_upr", "--top", 3)
    rows = [line.split()[0] for line in out.splitlines() if ".error." in line]
    ranked = ks.tolerances(package_robots.robot("2pru_upr").assemble())
    assert code == 0 and rows == list(ranked.effects)[:3] and "and 47 more" in out


@pytest.mark.few(2)
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["analyze", "--help"], ["new", "--list"]])
def test_help_version_and_list_import_no_heavy_packages(arguments):
    """They answer at once: no robot is needed for them."""
    code = (
        "import sys; from kinetostatics.cli.main import main; "
        f"main({arguments!r}); "
        "heavy = {'pinocchio', 'scipy', 'argcomplete', 'kinetostatics.cli.completion', 'kinetostatics.robot'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]", done.stdout


def test_export_writes_c_files_and_lists_outputs(capsys, tmp_path):
    folder = tmp_path / "controller"
    pose, names = ("--platform", "x", "y"), ("--outputs", "twist", "--name", "bars")
    code, out, err = run(capsys, "export", "five_bar", *pose, *names, "--jacobian", "twist", "--out", folder)
    header = (folder / "bars.h").read_text()
    assert "twist_by_x[6]" in header and "twist_by_y[6]" in header and "by_load" not in header
    assert code == 0 and err == ""
    assert out.startswith("wrote bars.h, bars.c, bars.hpp, bars_test.c, CMakeLists.txt, README.md to ")
    assert "operations per correction of the loops" in out and "twist (6,) [m, rad]" in out
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        ["bars.h", "bars.c", "bars.hpp", "bars_test.c", "CMakeLists.txt", "README.md"]
    )
