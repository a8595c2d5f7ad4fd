"""Loops of onshape-to-robot, Gepetto and Isaac Sim: the same robot as in our format, and questions instead of guesses."""

import math
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics import cli
from kinetostatics.exceptions import ArgumentError, KinetostaticsError, RobotFileError
from kinetostatics.foreign_loops import ForeignLoop
from kinetostatics.robot_file import parse_robot_text

FOREIGN = Path(__file__).parent / "foreign"
FIVE_BAR = FOREIGN / "five_bar_onshape.urdf"
FOUR_BAR = FOREIGN / "four_bar_isaac.urdf"
GEPETTO = FOREIGN / "five_bar_gepetto.urdf", FOREIGN / "five_bar_gepetto.yaml"
RRS = FOREIGN / "3rrs_gepetto.urdf", FOREIGN / "3rrs_gepetto.yaml"
HINGE = {"types": "revolute", "platform": "tool", "driven": ["motor_1", "motor_2"]}


def inertial(mass, *com):
    inertia = 'ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"'
    xyz = " ".join(map(repr, com))
    return f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia {inertia}/></inertial>'


def beams(*links):
    rest = 'youngs_modulus="70e9" poisson_ratio="0.3" density="2700"><tube outer_diameter="0.03" inner_diameter="0.024"/></beam>'
    return "".join(f'<beam link="{link}" {rest}' for link in links)


def elastic(made, *links):
    """The robot with elastic links; the links that mark frames, which weigh 1e-9 kg, weigh nothing."""
    text = made.urdf.replace("</robot>", f"{beams(*links)}</robot>").replace('value="1e-9"', 'value="0"')
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


def rrs():
    """The 3-RRS by hand: along the world's axes, the platform in the tree behind limb 2, limbs 1 and 3 cut at their balls.

    The platform's link has its origin at the ball of limb 2.
    """

    def around(i, radius, height=0.0):
        angle = 2 * math.pi * (i - 1) / 3
        return np.array([radius * math.cos(angle), radius * math.sin(angle), height])

    def written(point):
        return " ".join(map(repr, point.tolist()))

    ball = around(2, 0.15)
    center = np.array([0.01, 0.02, 0]) - ball
    parts = [f'<link name="base">{inertial(1, 0, 0, -0.05)}</link><link name="platform">{inertial(2.5, *center.tolist())}</link>']
    for i in (1, 2, 3):
        across = written(around(i + 0.75, 1))
        parts.append(f'<link name="crank_{i}">{inertial(0.5, *around(i, 0.05, 0.1).tolist())}</link>')
        parts.append(f'<link name="rod_{i}">{inertial(0.4, *around(i, -0.125, 0.125).tolist())}</link>')
        parts.append(hinge(f"mot{i}", "base", f"crank_{i}", written(around(i, 0.3)), across))
        parts.append(hinge(f"free{i}", f"crank_{i}", f"rod_{i}", written(around(i, 0.1, 0.2)), across))
        tip = written(around(i, -0.25, 0.25))
        if i == 2:
            parts.append('<link name="a"/><link name="b"/>')
            parts.append(hinge("ball_z", "rod_2", "a", tip, "0 0 1"))
            parts.append(hinge("ball_y", "a", "b", "0 0 0", "0 1 0"))
            parts.append(hinge("ball_x", "b", "platform", "0 0 0", "1 0 0"))
        else:
            parts.append(
                f'<loop name="ball_{i}" type="spherical"><predecessor link="rod_{i}"><origin xyz="{tip}"/></predecessor>'
                f'<successor link="platform"><origin xyz="{written(around(i, 0.15) - ball)}"/></successor></loop>'
            )
    parts.append(f'<platform link="platform"><origin xyz="{written(around(1, 0.15) - ball)}"/></platform>')
    parts.append("".join(f'<transmission name="{i}"><joint name="mot{i}"/></transmission>' for i in (1, 2, 3)))
    parts.append(beams(*(f"{part}_{i}" for part in ("crank", "rod") for i in (1, 2, 3))))
    return ks.Robot(parse_robot_text(f'<robot name="by_hand">{"".join(parts)}</robot>'))


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


@pytest.mark.parametrize("actuators", [{"motor_1": 0.0, "motor_2": 0.0}, {"motor_1": 0.3, "motor_2": 0.2}])
def test_closing_frames_give_the_robot(actuators):
    made = elastic(ks.import_robot(FIVE_BAR, **HINGE), "crank_1", "crank_2", "rod_2")
    assert_same(made, five_bar(), actuators, {"motor_2": -1})


@pytest.mark.parametrize("actuators", [{"motor_1": 0.0, "motor_2": 0.0}, {"motor_1": 0.3, "motor_2": 0.2}])
def test_pair_of_whole_frames_gives_the_robot(actuators):
    """One side of the weld is a revolute's own frame, so the weld closes the same five-bar."""
    made = elastic(ks.import_robot(*GEPETTO, platform="tool"), "crank_1", "crank_2", "rod_2")
    assert made.description.loops["closedloop1"].type == "fixed"
    assert made.description.driven == ("motor_1", "motor_2")
    assert_same(made, five_bar(), actuators, {"motor_2": -1})


@pytest.mark.parametrize("actuators", [(0.0, 0.0, 0.0), (0.1, -0.05, 0.15)])
def test_pairs_of_points_and_a_spherical_joint_give_the_robot(actuators):
    made = elastic(ks.import_robot(*RRS, platform="platform"), *(f"{part}_{i}" for part in ("crank", "rod") for i in (1, 2, 3)))
    assert [loop.type for loop in made.description.loops.values()] == ["spherical", "spherical"]
    assert made.mobility.platform == 3
    assert_same(made, rrs(), {f"mot{i}": value for i, value in enumerate(actuators, 1)})


@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("kind", ["revolute", "spherical"])
def test_loop_joints_give_the_robot(tmp_path, kind, angle):
    source = tmp_path / "robot.urdf"
    source.write_text(FOUR_BAR.read_text().replace('name="closure" type="revolute"', f'name="closure" type="{kind}"'))
    # the hinge's axis, y in the world, in the loop's frame on the coupler: written down independently when the file was made
    axes = {"closure": (0.1519506855116402, 0.95254130791737635, -0.26377271633661575)} if kind == "revolute" else None
    description = ks.import_robot(source, platform="coupler", driven=["drive"], axes=axes)
    assert_same(elastic(description, "crank", "rocker"), four_bar(kind), {"drive": angle})
