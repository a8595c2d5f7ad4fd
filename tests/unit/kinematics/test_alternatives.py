"""Start values for a 3-RRR whose limbs are straight at zero: a singular pose, from which no line of coordinates starts."""

import re
import shlex

import numpy as np
import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import main

CASE = (ROOT / "tests" / "cases" / "wrong_motor_axis.urdf.xacro").read_text(encoding="utf-8")
#: Angle of a crank against the line to the centre: two links of 0.25 m span the 0.3 m from base to platform point.
CRANK = np.arccos(0.15 / 0.25)


@pytest.fixture
def straight(tmp_path):
    path = tmp_path / "straight.urdf.xacro"
    text = re.sub(r' rpy="0 0 -1.86"|\+0\.93', "", CASE).replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>')
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.few(1)
@pytest.mark.parametrize("asked", [[], ["--platform", "x=0", "y=0", "rz=0"]])
def test_suggested_start_values_reach_the_pose(asked, straight, capsys) -> None:
    assert main(["analyze", str(straight), *asked]) == 2
    said = re.search(r"reached with (--.*) \(in Python near=(.*)\)", capsys.readouterr().err)
    assert main(["analyze", str(straight), *asked, *shlex.split(said[1])]) == 0
    assert "motor_1 -53.1301°, motor_2 -53.1301°, motor_3 -53.1301°" in capsys.readouterr().out


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_near_joint_values_choose_the_assembly_mode(side, straight) -> None:
    robot = ks.load_robot(straight)
    bent = {f"elbow_{i}": side for i in (1, 2, 3)}
    pose = robot.assemble(platform={"x": 0.0, "y": 0.0, "rz": 0.0}, near=bent)
    np.testing.assert_allclose(list(pose.actuators.values()), -side * CRANK, atol=1e-9)
    with pytest.raises(ks.exceptions.CoordinatesError, match="near: no joint 'elbw_1' of one freedom: did you mean 'elbow_1'"):
        robot.assemble(platform={"x": 0.0, "y": 0.0, "rz": 0.0}, near={"elbw_1": 1.0})
    with pytest.raises(ks.AssemblyError) as caught:  # nowhere near
        robot.assemble(platform={"x": 3.0, "y": 0.0, "rz": 0.0})
    assert "reached with" not in str(caught.value)
