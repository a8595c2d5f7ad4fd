"""The table of joint types: properties of its rows; no module compares with a type, and a new row is enough for a new type."""

import ast
import re

import numpy as np
import pytest
from loop_robots import GRAVITY, Held
from places import ROOT

import kinetostatics as ks
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType, names_of
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.mechanism.mechanism import Mechanism

SOURCE = ROOT / "src" / "kinetostatics"
LOAD = np.array([120.0, -310, -450, 41, -23, 17])


def strings(node: ast.AST) -> set[str]:
    return {item.value for item in ast.walk(node) if isinstance(item, ast.Constant) and isinstance(item.value, str)}


def test_no_module_compares_with_joint_type_names():
    """The meaning of a type is defined only in the table."""
    quoted = re.compile(f"[\"'](?:{'|'.join(JOINT_TYPES)})[\"']")
    for path in SOURCE.rglob("*.py"):
        if quoted.search(text := path.read_text(encoding="utf-8")):
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Compare | ast.Match):
                    assert not strings(node) & set(JOINT_TYPES), f"{path}:{node.lineno}"


def test_properties_of_all_joint_types():
    assert {name: item.freedoms for name, item in JOINT_TYPES.items()} == {
        "fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "cylindrical": 2, "universal": 2, "spherical": 3,
        "planar": 3, "floating": 6,
    }  # fmt: skip
    assert names_of("in_tree") == ("fixed", "revolute", "continuous", "prismatic", "floating", "planar")
    assert set(names_of("in_loop")) == set(JOINT_TYPES) - {"floating"}
    assert names_of("is_single") == ("revolute", "continuous", "prismatic")
    assert names_of("is_hinge") == ("revolute", "continuous") and names_of("is_slide") == ("prismatic",)
    assert names_of("has_limits") == ("revolute", "prismatic")
    assert names_of("has_cone") == ("universal", "spherical")
    assert names_of("is_on_axis") == ("revolute", "continuous", "prismatic", "cylindrical")
    assert set(JOINT_TYPES) - set(names_of("has_axis")) == {"fixed", "spherical", "floating"}
    assert {name: item.unit for name, item in JOINT_TYPES.items() if item.is_single} == {
        "revolute": "rad", "continuous": "rad", "prismatic": "m",
    }  # fmt: skip


def test_robot_format_page_lists_the_same_properties():
    rows = re.findall(
        r"^\| `(\w+)` \| (\d) \| (.+?) \| (.+?) \| (.+?) \|$", (ROOT / "docs/reference/robot_format.md").read_text("utf-8"), re.M
    )
    assert {row[0] for row in rows} == set(names_of("in_loop"))
    for name, freedoms, axis, axis2, limit in rows:
        item = JOINT_TYPES[name]
        limited = "`<limit>`" if item.has_limits else "unlimited" if item.is_single else "`<cone>`" if item.has_cone else "–"
        found = int(freedoms), axis != "–", axis2 != "–", limit
        assert found == (item.freedoms, item.has_axis, item.turns is Axes.BOTH, limited)


@pytest.mark.parametrize("name", names_of("in_tree")[1:])
def test_numbers_of_coordinates_equal_pinocchio(name):
    joint = (
        f'<joint name="j" type="{name}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="0" velocity="0"/></joint>'
    )
    text = f'<robot name="one"><link name="a"/><link name="b"/>{joint}<platform link="b"/></robot>'
    model = Mechanism(parse_robot_text(text)).model
    assert (model.nq, model.nv) == (JOINT_TYPES[name].coordinates, JOINT_TYPES[name].freedoms)


class New(Held):
    """A platform on a joint whose type is not in the table: a ball that slides along a line or in a plane."""

    @property
    def chain(self):
        slides = {"ball_on_line": [("P", self.a)], "ball_on_plane": [("P", self.s), ("P", self.t)]}[self.kind]
        return [*slides, *(("R", self.J[:3, k]) for k in range(3))]

    def freedoms(self, q):
        o, centre = self.platform_frame(q)[:3, 3], (self.displacement(q) @ np.append(self.c, 1))[:3]
        slides = [np.append(axis, np.zeros(3)) for kind, axis in self.chain if kind == "P"]
        return np.array([*slides, *(np.append(np.cross(axis, o - centre), axis) for axis in np.eye(3))]).T


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "slides"), [("ball_on_line", Axes.AXIS), ("ball_on_plane", Axes.ACROSS)])
def test_new_table_row_defines_a_new_loop_type(name, slides, monkeypatch):
    """Reader, writer, kinematics, statics, reports, finite elements and Pinocchio's constraints take it from the table."""
    monkeypatch.setitem(JOINT_TYPES, name, JointType(name, "B", slides=slides, turns=Axes.ALL))
    held = New(name, seed=5)
    robot = held.robot()
    assert parse_robot_text(robot.description.urdf) == robot.description
    q = held.random_q(np.random.default_rng(3))
    pose = robot.assemble(actuators=held.actuators(q))
    np.testing.assert_allclose(pose.platform_frame, held.platform_frame(q), atol=1e-11)
    result, expected = ks.analyze(pose, LOAD, gravity=GRAVITY), held.statics(q, LOAD)
    np.testing.assert_allclose(result.twist, expected.twist, rtol=0, atol=1e-8 * np.abs(expected.twist).max())
    for joint, wrench in expected.wrenches.items():
        np.testing.assert_allclose(result.joint_wrenches[joint], wrench, rtol=0, atol=1e-8 * np.abs(wrench).max())
    assert sorted(limb.constraint_wrenches.shape for limb in result.limbs.values())[0] == (6, 3 - slides.count)
    assert ks.verify(pose, LOAD, gravity=GRAVITY).verified
    assert "B" in str(robot) and name in robot.description.urdf
    assert len(pose.loop_model().constraints) == 1
