"""Arguments of a wrong type or value are errors of the package with a message, in all public functions."""

import itertools

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.engine.engine_report import engine_report
from kinetostatics.kinematics.alternatives import choices, prescribed_platform
from kinetostatics.math.rotations import orientation_named

NAN, ONE_J = float("nan"), 1j
WRONG = (
    None, 3, "x", b"x", [1, 2], ["z"], (), {}, {"z": None}, {"z": "a"}, {"z": {}}, {1: 2}, {None: 1}, {"z": [1, [2, 3]]},
    {"z": 0.5, "rx": None, "ry": 0}, {"z": 0.5, "rx": ONE_J, "ry": 0}, {"z": 0.5, "rx": "2deg", "ry": 0}, object(),
    np.zeros(3), np.array("x"), np.zeros(3, complex), ONE_J, NAN, set(), -1,
    {"prismatic_1": None, "prismatic_2": 0, "prismatic_3": 0},
    {"prismatic_1": [1, 2], "prismatic_2": [1, 2, 3], "prismatic_3": 0},
)  # fmt: skip


def calls(robot, pose, folder):
    """Return one function for each argument of the public functions: it calls with the given value of that argument."""
    of_pose = {"configuration": pose}
    table = [
        (robot.assemble, {}, "platform actuators orientation near closure_tolerance on_failure"),
        (robot.configuration, {"q": pose.q}, "q closure_tolerance on_failure"),
        (ks.analyze, of_pose, "configuration load gravity point frame assembly_errors on_failure"),
        (ks.compensate, of_pose, "configuration load gravity controlled orientation on_failure closure_tolerance"),
        (ks.compile, {"robot": robot}, "platform actuators outputs"),
        (
            ks.calibrate,
            {"robot": robot, "measurements": {"Fz": [-100.0], "dz": [-1e-6]}, "unknowns": ["rod_1"]},
            "measurements unknowns reference payload point",
        ),
        (ks.plan_measurements, {"robot": robot, "unknowns": ["rod_1"], "n": 1}, "n platform actuators load"),
        (
            ks.tolerances,
            {**of_pose, "tolerances": {"rod_1.density": "1%"}, "samples": 10},
            "configuration tolerances rank_by samples distribution seed",
        ),
        (
            ks.sweep,
            {"robot": robot},
            "robot platform actuators orientation load gravity point frame assembly_errors closure_tolerance chunks",
        ),
        (ks.sweep, {"robot": "3rps"}, "parameters"),
    ]
    found = {
        f"{function.__name__}({name}=)": lambda v, function=function, given=given, name=name: function(**{**given, name: v})
        for function, given, names in table
        for name in names.split()
    }
    found["sensitivities(by=)"] = lambda v: v is not None and ks.sensitivities(pose, v)  # None: all parameters, which takes long
    return found | {
        "an assembly error of a beam": lambda v: ks.analyze(pose, assembly_errors={"rod_1": v}),
        "an assembly error of a joint": lambda v: ks.analyze(pose, assembly_errors={"prismatic_1": v}),
        "a beam's length": lambda v: ks.analyze(pose, assembly_errors={"rod_1": {"length": v}}),
        "an assembly error's frame": lambda v: ks.analyze(
            pose, assembly_errors={"prismatic_1": {"twist": np.zeros(6), "frame": v}}
        ),
        "load_robot": ks.load_robot,
        "read_robot_file": ks.files.read_robot_file,
        "extend_robot": ks.extend_robot,
        "parameters": lambda v: ks.load_robot("3rps", v),
        "parameters of plain URDF": lambda v: ks.load_robot(folder / "plain.urdf", v),
        "a parameter": lambda v: ks.load_robot("3rps", {"rod_diameter": v}),
        "a swept parameter": lambda v: ks.sweep("3rps", parameters={"rod_diameter": v}),
        "Robot": ks.Robot,
        "validate": ks.description.validate,
        "save_robot": lambda v: ks.save_robot(v, folder / "saved.urdf"),
        "frame": pose.frame,
    }


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("every", [40, pytest.param(1, marks=pytest.mark.slow)])
def test_wrong_values_raise_errors_of_the_package(tmp_path, every):
    """Every fortieth pair of an argument and a wrong value; all pairs in the slow tests."""
    robot = package_robots.robot("3rps")
    ks.save_robot(robot, tmp_path / "plain.urdf")
    answered = 0
    everything = itertools.product(enumerate(calls(robot, robot.assemble(), tmp_path).items()), enumerate(WRONG))
    for (argument, (name, call)), (number, value) in everything:
        if (argument + number) % every:
            continue
        try:
            call(value)
        except ks.KinetostaticsError as error:
            answered += 1
            assert str(error), name
        except Exception as error:
            pytest.fail(f"{name} of {value!r} ends in {type(error).__name__}: {error}")
    assert answered > 900 / every


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda robot: ks.save_html("3rps", "x.html"), "a picture needs a Result"),
        (lambda robot: ks.save_html(robot, "x.txt"), "the page is an HTML file, which a browser prints as PDF; name it 'x.html'"),
        (lambda robot: ks.save_html(robot, "x.html", compare=ks.analyze(robot.assemble())), "compare= .* leave them out"),
        (lambda robot: ks.save_html(ks.analyze(robot.assemble()), "x.html", compare=robot), "compare= needs a Result"),
        (
            lambda robot: ks.save_image(ks.analyze(robot.assemble()), "x.png", size=800),
            "size is 800; it must be width and height",
        ),
        (lambda robot: engine_report("3rps"), "engine_report needs a Robot, got '3rps'"),
        (lambda robot: ks.indices.at_point(3, (0, 0, 0)), "this is not a Dataset of ks.sweep"),
        (lambda robot: ks.plot.save(3, "x.svg"), "save needs a figure or axes"),
        (
            lambda robot: ks.pareto("3rps", {"rod_diameter": "4cm:12cm"}, ("mass", " mass")),
            "a front has two different quantities",
        ),
    ],
)
def test_wrong_types_are_argument_errors(call, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ks.ArgumentError, match=message):
        call(package_robots.robot("3rps"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", [None, 3.5, {}, object()])
def test_invalid_output_paths_are_errors(path):
    with pytest.raises(ks.ArgumentError, match="must be the path of a file"):
        ks.save_robot(package_robots.robot("3rps"), path)
    if path is not None:
        with pytest.raises(ks.ArgumentError, match="must be the path of a file"):
            ks.sweep("3rps", out=path)


@pytest.mark.parametrize(
    ("what", "value", "message"),
    [
        ("platform", [0.5, 0, 0], r"platform is \[0.5, 0, 0\]; it must be a mapping .* such as \{\"z\": 0.5\}"),
        ("actuators", [0, 0, 0], r"actuators is \[0, 0, 0\]; it must be a mapping .* such as \{'prismatic_1': 0.02\}"),
        ("platform", {2: 0.5}, r"platform has the key 2; keys are names, as in \{\"z\": 0.5\}"),
        ("platform", {"z": None, "rx": 0, "ry": 0}, "z = None is not"),
        ("closure_tolerance", "small", r"closure_tolerance is 'small'; it must be a positive length \[m\] and angle \[rad\]"),
        ("orientation", 3, "orientation is 3; it must be a name"),
        ("on_failure", "rise", "on_failure is 'rise'; it must be one of 'raise', 'nan'"),
        ("near", 0.5, "near= needs a Configuration"),
        ("near", {"z": 0.5}, "near: no joint 'z' of one freedom"),
    ],
)
def test_invalid_arguments_of_assemble_are_errors(what, value, message):
    with pytest.raises(ks.ArgumentError, match=message):
        package_robots.robot("3rps").assemble(**{what: value})


# ---- coordinates that do not determine the pose ------------------------------------------------------------------------


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("planar_3rrr", "xyz", "; x, y, rz do"),
        ("delta", ("x", "y", "rx"), "; z, x, y do"),
        ("five_bar", ("z", "rx"), "; x, y or x, rz or y, rz do"),
        ("spherical_3rrr", "xyz", "; rz, rx, ry do"),
        ("3rps", "xyz", "a singular pose for them; z, rx, ry do"),
        ("3rps", "z", "give exactly 3 of x, y, z, rx, ry, rz; z, rx, ry do"),
        ("2pru_upr", ("z", "x", "rx"), "; z, rx, ry or z, y, ry do"),
    ],
)
def test_coordinate_errors_name_valid_choices(name, given, words):
    with pytest.raises(ks.exceptions.CoordinatesError) as caught:
        package_robots.robot(name).assemble(platform=dict.fromkeys(given, 0.1))
    assert words in str(caught.value)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["3rps", "2pru_upr", "exechon", "five_bar", "tricept", "planar_3rrr"])
@pytest.mark.parametrize("orientation", [None, "XYZ", "tilt_torsion"])
def test_named_coordinate_choices_determine_the_pose(name, orientation):
    robot = package_robots.robot(name)
    convention = orientation_named(orientation)
    found = choices(robot, convention, (), robot.zero_poses)
    for names in found:
        assert robot.mobility_analysis.fixes_platform_at(prescribed_platform(names, convention), robot.zero_poses)
        values = robot.assemble().platform_coordinates(orientation)
        pose = robot.assemble(platform={name: values[name] for name in names}, orientation=orientation)
        np.testing.assert_allclose(pose.platform_frame, robot.assemble().platform_frame, atol=1e-9)


@pytest.mark.parametrize(
    "command",
    [
        ["compensate"],
        ["sensitivities"],
        ["tolerances", "--tolerance", "rod_diameter=1%"],
        ["optimize", "--vary", "rod_diameter=4cm:8cm"],
        ["report"],
        ["calibrate", "--plan", "1", "--unknowns", "rod_1"],
    ],
)
def test_missing_output_folder_is_an_error_before_computing(capsys, command):
    file = "no/such/file.html" if command == ["report"] else "no/such/file.csv"
    assert main([command[0], "3rps", *command[1:], "--out", file]) == 2
    assert capsys.readouterr().err == "kinetostatics: error: --out: there is no folder no/such\n"
