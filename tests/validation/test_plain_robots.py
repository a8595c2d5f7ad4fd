"""Unedited URDFs of the package example-robot-data load, pass ``check``, and sag by the stiffness of their actuators.

A few of them here; all of them with ``KINETOSTATICS_ALL_URDFS=1``, which takes a minute.
"""

import os
import re
import shlex

import numpy as np
import pinocchio as pin
import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.authoring.from_urdf import extension
from kinetostatics.cli.main import main
from kinetostatics.exceptions import PlatformMissingError
from kinetostatics.files.bundled import package_folder

FOLDER = package_folder("example-robot-data") / "robots"
FILES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.urdf"))
#: Of actuators whose efforts are not in the file [N·m/rad].
STIFFNESS = 1000.0
SOME = (
    "asr_twodof_description/urdf/TwoDofs.urdf",
    "bolt_description/robots/bolt.urdf",
    "iris_description/robots/iris.urdf",
    "panda_description/urdf/panda.urdf",
    "so_arm_description/urdf/so101.urdf",
)
CHOSEN = FILES if os.environ.get("KINETOSTATICS_ALL_URDFS") else SOME
NO_ROBOTS = (
    "hector_description/robots/quadrotor_base.urdf",
    "iris_description/robots/iris_simple.urdf",
    "ur_description/urdf/ur3.urdf",
)


def platform_of(file: str) -> str:
    """Return the platform of a file, or the first link that the error of the missing platform proposes."""
    try:
        return ks.load_robot(FOLDER / file).description.platform
    except PlatformMissingError as error:
        return error.likely[0]


@pytest.mark.slow
def test_three_urdf_files_are_refused() -> None:
    refused = []
    for file in FILES:
        try:
            platform_of(file)
        except ks.RobotFileError:
            refused.append(file)
    assert set(refused) == set(NO_ROBOTS) and len(FILES) >= 69


def test_page_shows_the_written_extension_file() -> None:
    text = (ROOT / "docs" / "how_to" / "plain_urdf.md").read_text(encoding="utf-8")
    elastic = {"upper_arm_link": "tube 108mm 98mm aluminium", "forearm_link": "tube 86mm 78mm aluminium"}
    written = extension(str(FOLDER / "ur_description" / "urdf" / "ur10_robot.urdf"), "", "tool0", elastic=elastic)[0]
    assert re.findall(r"<!-- extension -->\n```xml\n(.*?)```", text, re.DOTALL) == [written]


@pytest.mark.few(1)
@pytest.mark.parametrize("file", [file for file in CHOSEN if file not in NO_ROBOTS])
def test_suggested_commands_succeed(file, tmp_path, monkeypatch, capsys) -> None:
    """First commands that name a platform, if there is more than one; then commands that make the robot elastic."""
    monkeypatch.chdir(tmp_path)

    def said(command: list[str]) -> list[list[str]]:
        assert main(command) in (0, 2)
        text = capsys.readouterr()
        return [shlex.split(line)[1:] for line in (text.out + text.err).splitlines() if line.startswith("  kinetostatics ")]

    commands = said(["analyze", str(FOLDER / file)])
    assert commands
    named = commands[0][0] == "analyze"
    for found in (said(command) for command in commands) if named else [commands]:
        for command in found:
            assert main(command) == 0
        if found:
            capsys.readouterr()
            assert main(["check", found[1][1]]) == 0
            assert "beam theory is doubtful" not in capsys.readouterr().out
        else:
            assert file == "iris_description/robots/iris.urdf"


@pytest.mark.few(1)
@pytest.mark.parametrize("file", [file for file in CHOSEN if file not in NO_ROBOTS])
def test_extended_urdf_passes_check_and_sag_equals_pinocchio(file, tmp_path, capsys) -> None:
    """Δ = J k⁻¹ (−g): the platform's Jacobian and the gravity torques of the unedited file, the actuators' stiffnesses."""
    path, platform = tmp_path / "mine.urdf.xacro", platform_of(file)
    plain = ks.files.read_robot_file(FOLDER / file, platform_link=platform)
    efforts = [plain.joints[name].effort for name in plain.actuated]
    stiffness = "suggested" if any(efforts) else dict.fromkeys(plain.actuated, STIFFNESS)
    made = ks.extend_robot(FOLDER / file, path, platform_link=platform, joint_stiffness=stiffness)
    assert main(["check", str(path)]) == 0
    mimics = any(joint.mimic for joint in made.description.joints.values())
    assert ("the loops close" if mimics else "there are no loops") in capsys.readouterr().out
    if mimics:
        return  # Pinocchio's reader makes independent joints of them
    model = pin.buildModelFromUrdf(str(FOLDER / file))
    data, q = model.createData(), pin.neutral(model)
    J = pin.computeFrameJacobian(model, data, q, model.getFrameId(platform), pin.LOCAL_WORLD_ALIGNED)
    stiffness = np.full(model.nv, np.inf)
    for name, item in made.description.joint_stiffness.items():
        stiffness[model.joints[model.getJointId(name)].idx_v] = item.drive
    if not any(joint.effort for joint in made.description.joints.values()):
        assert np.all(stiffness == STIFFNESS)
    twist = -J @ (pin.computeGeneralizedGravity(model, data, q) / stiffness)
    result = ks.analyze(made.assemble())
    compliance = J / stiffness @ J.T
    np.testing.assert_allclose(result.twist, twist, atol=1e-9 * max(np.abs(twist).max(), 1e-9))
    # the angles of this file are rounded, which leaves it 4e-6 rad beside a pose in which it cannot move in all directions
    tolerance = 1e-6 if file.endswith("so100.urdf") else 1e-9
    np.testing.assert_allclose(result.compliance, compliance, atol=tolerance * np.abs(compliance).max())
