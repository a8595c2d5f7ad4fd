"""Xacro's expressions: their values, and those that are refused."""

import math
from pathlib import Path

import pytest

from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.reader import parse_robot_text, read_robot_file

BODY = (
    '<robot name="r" xmlns:xacro="x">{}<link name="a"/><link name="b"/><joint name="j" type="floating"><parent link="a"/>'
    '<child link="b"/></joint><platform link="b"/><gazebo>[{}]</gazebo></robot>'
)


def value(expression: str, before: str = "", path: str = "<text>") -> str:
    urdf = parse_robot_text(BODY.format(before, expression.replace("&", "&amp;").replace("<", "&lt;")), path).urdf
    return urdf.split("<gazebo>[")[1].split("]</gazebo>")[0].replace("&lt;", "<").replace("&amp;", "&")


def test_mathematics() -> None:
    assert value("${radians(60)} ${degrees(pi)} ${math.hypot(3, 4)} ${e} ${inf}") == f"{math.radians(60)} 180.0 5.0 {math.e} inf"
    assert value("${sin(pi/2) + math.cos(0)} ${atan2(1, 1)} ${floor(2.5)} ${factorial(5)}") == f"2.0 {math.pi / 4} 2 120"


def test_properties_arguments_and_macros() -> None:
    before = (
        '<xacro:arg name="n" default="3"/><xacro:property name="l" value="${[1, 2]}"/><xacro:property name="w" value="0.5"/>'
        '<xacro:property name="area" value="${w**2}"/>'
    )
    assert value("${l[1] * w} ${area} ${$(arg n) + 1} ${xacro.arg('n')} $(eval n + 1) $${x}", before) == "1.0 0.25 4 3 4 ${x}"
    assert value("${xacro.tokenize('a, b;c')} ${xacro.message('x')} ${python.set([1])}") == "['a', 'b', 'c']  {1}"


def test_namespaces_and_yaml(tmp_path: Path) -> None:
    (tmp_path / "sizes.yaml").write_text("rod: {length: 0.5, names: [a, b]}\nangle: !degrees 90\n", encoding="utf-8")
    (tmp_path / "part.xacro").write_text('<robot xmlns:xacro="x"><xacro:property name="k" value="7"/></robot>', encoding="utf-8")
    path = tmp_path / "robot.xacro"
    before = (
        '<xacro:include filename="part.xacro" ns="part"/><xacro:property name="s" value="${xacro.load_yaml(\'sizes.yaml\')}"/>'
    )
    text = "${part.k} ${s.rod.length * 2} ${s['rod'].names[0]} ${s.angle} ${list(s.rod.keys())} ${[n + '!' for n in s.rod.names]}"
    path.write_text(BODY.format(before, text), encoding="utf-8")
    urdf = read_robot_file(path).urdf
    assert f"<gazebo>[7 1.0 a {math.pi / 2} ['length', 'names'] ['a!', 'b!']]</gazebo>" in urdf
    path.write_text(BODY.format(before, "${s.rod.width}"), encoding="utf-8")
    with pytest.raises(RobotFileError, match="'width'"):
        read_robot_file(path)


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        ("${1 +}", "invalid syntax"),
        ("${oops}", "'oops' is not defined"),
        ("${1/0}", "division by zero"),
        ("${open('/etc/passwd').read()}", "'open' is not defined"),
        ("${[].__class__}", "__"),
        ("${[y.__class__ for y in [1]]}", "__"),
        ("${'{0.__class__}'.format(1)}", "__"),
        ("${__import__('os')}", "__"),
        ("$(eval [].__class__)", "double underscore"),
        (
            '<xacro:arg name="l" default="5cm"/>${xacro.arg("l") / 2}',
            "the xacro argument l is '5cm', which is not a number; numbers",
        ),
    ],
)
def test_what_has_no_value(expression: str, words: str) -> None:
    with pytest.raises(RobotFileError) as caught:
        parse_robot_text(BODY.format("", expression))
    assert words in str(caught.value) and "\n" not in str(caught.value) and caught.value.line == 1
