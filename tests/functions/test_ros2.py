"""ROS 2 packages: compiled by their own CMake against replacements of the ROS headers, and equal to Python.

The replacements have the signatures of ros2_control 4 (Jazzy). colcon and ROS are not needed.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import package_robots
import pinocchio as pin
import pytest
import yaml
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import main

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
CMAKE = shutil.which("cmake") or str(Path(sys.executable).with_name("cmake"))
STUBS = ROOT / "tests/support/ros2_stubs"


def built(package, folder):
    """Build a package with its CMakeLists.txt, in which packages of ROS are replaced; return the driver of its controllers."""
    modules = folder / "modules"
    modules.mkdir()
    needed = [element.text for element in ET.parse(package / "package.xml").getroot() if element.tag.endswith("depend")]
    for name in needed:
        targets = f"add_library({name}::{name} INTERFACE IMPORTED)\nset({name}_TARGETS {name}::{name})\n"
        includes = f'target_include_directories({name}::{name} INTERFACE "{STUBS}")\n'
        (modules / f"Find{name}.cmake").write_text(targets + includes)
    with open(modules / "Findament_cmake.cmake", "a") as file:
        file.write("function(ament_package)\nendfunction()\n")
    with open(modules / "Findpluginlib.cmake", "a") as file:
        file.write("function(pluginlib_export_plugin_description_file base file)\n")
        file.write('  file(READ "${CMAKE_CURRENT_SOURCE_DIR}/${file}" text)\nendfunction()\n')
    strict = "-Wall -Wextra -Werror"
    flags = [f"-DCMAKE_CXX_FLAGS={strict}", f"-DCMAKE_C_FLAGS={strict}", f"-DCMAKE_INSTALL_PREFIX={folder}/installed"]
    silent = {"check": True, "stdout": subprocess.DEVNULL}
    subprocess.run([CMAKE, "-B", folder / "build", "-S", package, f"-DCMAKE_MODULE_PATH={modules}", *flags], **silent)
    subprocess.run([CMAKE, "--build", folder / "build", "--target", "install"], **silent)
    library = next((folder / "installed/lib").iterdir())
    driver = folder / "drive"
    whole = [f"-L{library.parent}", f"-l:{library.name}", f"-Wl,--no-as-needed,-rpath,{library.parent}"]
    subprocess.run(
        ["g++", "-std=c++17", f"-I{STUBS}", STUBS / "drive.cpp", "-Wl,--no-as-needed", *whole, "-o", driver], check=True
    )
    return driver


def driven(driver, plugin, rows, *arguments):
    """Return the names of interfaces, and what a controller does at each row of numbers."""
    text = "\n".join(" ".join(repr(float(number)) for number in row) for row in rows)
    ran = subprocess.run([driver, plugin, *arguments], input=text, capture_output=True, text=True, check=True)
    names, *lines = ran.stdout.splitlines()
    return names.split(), [line.split() for line in lines], ran.stderr


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("3rps")


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ros2")
    options = ["--platform", "z", "rx", "ry", "--compensate", "--ros2", "--out", str(folder / "package")]
    assert main(["export", "3rps", *options]) == 0
    return folder / "package"


@pytest.fixture(scope="module")
def driver(package):
    return built(package, package.parent)


PLUGIN = "robot_3rps_control::"


def path():
    t = np.linspace(0, 1, 9)
    return 0.5 + 0.05 * t, 0.1 * t, -0.05 * t


def test_controller_commands_the_corrected_positions_and_forces(robot, driver):
    z, rx, ry = path()
    names, lines, _ = driven(driver, f"{PLUGIN}PoseController", np.transpose([z, rx, ry]), "20")
    actuators = [f"prismatic_{k}" for k in (1, 2, 3)]
    references = [f"the_node/{name}/position" for name in ("z", "rx", "ry")]
    assert names == [*references, *(f"{name}/{kind}" for kind in ("position", "effort") for name in actuators)]
    f = ks.compile(robot, ("z", "rx", "ry"), outputs=("actuators", "actuator_forces"), compensate=True)
    wanted = f(z=z, rx=rx, ry=ry, load=[20.0] * 6)
    found = np.array(lines, dtype=float)
    np.testing.assert_allclose(found[:, :3], wanted["actuators"], atol=1e-12)
    np.testing.assert_allclose(found[:, 3:], wanted["actuator_forces"], rtol=1e-10)
    names, lines, _ = driven(driver, f"{PLUGIN}PoseController", np.transpose([z, rx, ry]), "20", "effort")
    np.testing.assert_allclose(np.array(lines, dtype=float), wanted["actuator_forces"], rtol=1e-10)


def test_commands_stay_without_reference_and_out_of_reach(driver):
    rows = [[np.nan] * 3, [0.5, 0.0, 0.0], [0.5, 4.0, 0.0], [0.52, 0.0, 0.0]]
    _, lines, warnings = driven(driver, f"{PLUGIN}PoseController", rows)
    commands = np.array(lines, dtype=float)
    assert not commands[0].any() and commands[1].all()
    np.testing.assert_array_equal(commands[2], commands[1])
    assert np.all(commands[3] != commands[1]) and "no command: status 2" in warnings


def test_broadcaster_closes_the_robot_of_the_urdf(robot, package, driver):
    """With the published positions, Pinocchio's frames of all links in the exported URDF are those of the closed robot."""
    z, rx, ry = path()
    poses = robot.assemble(platform={"z": z, "rx": rx, "ry": ry})
    rows = np.transpose([poses.actuators[name] for name in ("prismatic_1", "prismatic_2", "prismatic_3")])
    names, lines, warnings = driven(driver, f"{PLUGIN}PassiveJointBroadcaster", [*rows, [9.0, 0.0, 0.0]])
    assert names[:3] == [f"prismatic_{k}/position" for k in (1, 2, 3)]
    assert lines[-1] == lines[-2] and "open loops: status 2" in warnings
    model = pin.buildModelFromUrdf(str(package / "robot_3rps.urdf"))
    for k, (row, line) in enumerate(zip(rows, lines[:-1], strict=True)):
        assert line[0] == str(k + 1)
        position = dict(zip(line[1::2], map(float, line[2::2]), strict=True))
        position |= {f"prismatic_{n + 1}": value for n, value in enumerate(row)}
        assert set(position) == set(model.names[1:])
        assert_frames(model, position, robot, poses, k)


def assert_frames(model, position, robot, poses, k):
    q = pin.neutral(model)
    for name, value in position.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for link in robot.description.links:
        body, placement = robot.mechanism.body_of[link]
        place = data.oMf[model.getFrameId(link)]
        point = poses.frames.point(body, placement[:3, 3])[:, k]
        np.testing.assert_allclose(place.translation, point, atol=1e-9, err_msg=link)
        np.testing.assert_allclose(
            place.rotation, poses.frames.rotation[:, :, body, k] @ placement[:3, :3], atol=1e-9, err_msg=link
        )


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["delta", "gough_stewart", "2pru_upr", "exechon", "spherical_3rrr"])
def test_broadcaster_closes_other_robots(name, tmp_path):
    """Among them robots with spherical joints of three revolutes, with and without floating platforms."""
    robot = package_robots.robot(name)
    ks.compile(robot, outputs=("actuators", "actuator_forces")).export_ros2(tmp_path / "package", name="it")
    pose = package_robots.generic_pose(name)
    model = pin.buildModelFromUrdf(str(tmp_path / "package/it.urdf"))
    driver = built(tmp_path / "package", tmp_path)
    row = [float(pose.actuators[joint]) for joint in robot.actuator_names]
    _, (commands,), _ = driven(driver, "it_control::PoseController", [row])
    forces = ks.analyze(robot.assemble(actuators=dict(zip(robot.actuator_names, row, strict=True)))).actuator_forces
    np.testing.assert_allclose(np.array(commands, float), [*row, *forces.values()], rtol=1e-7, atol=1e-9)
    _, (line,), _ = driven(driver, "it_control::PassiveJointBroadcaster", [row])
    position = dict(zip(line[1::2], map(float, line[2::2]), strict=True)) | dict(zip(robot.actuator_names, row, strict=True))
    assert_frames(model, position, robot, robot.assemble(actuators=dict(zip(robot.actuator_names, row, strict=True))), 0)


def test_files_name_each_other(package):
    root = ET.parse(package / "package.xml").getroot()
    assert root.get("format") == "3" and root.findtext("name") == "robot_3rps_control"
    library = ET.parse(package / "plugins.xml").getroot()
    assert library.get("path") == "robot_3rps_control"
    types = yaml.safe_load((package / "controllers.yaml").read_text())
    manager = types["controller_manager"]["ros__parameters"]
    for plugin in library:
        assert plugin.get("type") == plugin.get("name").replace("/", "::")
        assert {"type": plugin.get("name")} in manager.values()
    assert types["pose_commands"]["ros__parameters"]["joints"] == [f"pose_controller/{name}" for name in ("z", "rx", "ry")]
    parameters = types["pose_controller"]["ros__parameters"]
    assert parameters["command_interfaces"] == ["position", "effort"] and parameters["gravity"] == [0.0, 0.0, -9.81]
    urdf = ET.parse(package / "robot_3rps.urdf").getroot()
    assert {element.tag for element in urdf} == {"link", "joint", "material", "ros2_control"}
    assert [joint.get("name") for joint in urdf.find("ros2_control").findall("joint")] == [f"prismatic_{k}" for k in (1, 2, 3)]
    assert "does not build them by colcon" in (package / "README.md").read_text()


def test_mistakes_are_named(robot, tmp_path, capsys):
    with pytest.raises(ks.ArgumentError, match="a ROS 2 package needs the output 'actuators'"):
        ks.compile(robot, outputs="actuator_forces").export_ros2(tmp_path / "package")
    assert main(["export", "3rps", "--ros2", "--scalar", "float", "--out", str(tmp_path / "package")]) == 2
    assert "--ros2 takes neither --jacobian nor --scalar" in capsys.readouterr().err
