"""Xacro's expressions: those that robots use give what Python gives."""

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


SAME = """
1 + 2 * 3 - 4 / 5 // 2 % 3
-2**2
2**-1
2**0.5
1e3
'a' + "b" * 3
'%.3f|%s' % (1/3, 'x')
1 < 2 <= 3 != 4
1 < 2 > 3
not 1 or 0 and 2
'' or 'x'
3 if 1 > 2 else 4
[1, 2, 3][1:]
(1, 2, 3)[-1]
'abcdef'[1:5:2]
[x**2 for x in range(5) if x % 2]
[x * y for x, y in [(1, 2), (3, 4)]]
[[x for x in range(y)] for y in range(3)]
sum([1, 2, 3])
sum(x for x in [1, 2])
list(map(float, '1 2 3'.split()))
' '.join(map(str, [1, 2]))
' '.join([str(round(x, 2)) for x in [1/3, 2/3]])
max(1, 2), min([3, 1])
max([1, 5, 2])
sorted([3, 1, 2], reverse=True)
dict(a=1, b=2)['b']
dict(a=1).get('c', 7)
sorted(dict(a=1, b=2).keys())
len('abc'), int('7'), float('1.5'), bool(0), str(2)
'a' in 'abc', 1 not in [2]
None is None
isinstance(1, int), isinstance('a', (int, str))
'A.b'.lower().replace('.', '_').startswith('a')
list(zip([1, 2], 'ab'))
list(enumerate('ab'))
abs(-1), divmod(7, 2), all([1, 0]), any([1, 0]), ord('a')
[*range(3), *'ab']
1 << 4 | 3 & 2 ^ 1
~5 >> 1
True, False
(1.0).is_integer()
tuple(reversed([1, 2]))
""".strip().splitlines()


PYTHON = "sum sorted range isinstance zip enumerate abs divmod all any ord tuple reversed".split()


@pytest.mark.parametrize("expression", SAME)
def test_as_in_python(expression: str) -> None:
    used = expression
    for name in PYTHON:
        used = used.replace(f"{name}(", f"python.{name}(")
    assert value(f"${{{used}}}") == str(eval(expression))


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
    text = "${part.k} ${s.rod.length * 2} ${s['rod'].names[0]} ${s.angle} ${s.rod.keys()} ${[n + '!' for n in s.rod.names]}"
    path.write_text(BODY.format(before, text), encoding="utf-8")
    urdf = read_robot_file(path).urdf
    assert f"<gazebo>[7 1.0 a {math.pi / 2} ['length', 'names'] ['a!', 'b!']]</gazebo>" in urdf
    path.write_text(BODY.format(before, "${s.rod.width}"), encoding="utf-8")
    with pytest.raises(RobotFileError, match="'width'"):
        read_robot_file(path)


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        ("1 +", "invalid syntax"),
        ("1 2", "syntax"),
        ("oops", "'oops' is not defined"),
        ("1/0", "division by zero"),
        ("'a' + 1", "concatenate"),
        ("[1][2]", "out of range"),
        ("int('x')", "invalid literal"),
        ("lambda: 1", "lambda is not allowed"),
        ("(x := 1)", ":= is not allowed"),
        ("1j", "complex is not allowed"),
        ("(-8)**(1/3)", "power of a negative number"),
        ("[1].append(2)", "'append'"),
        ("'a'.encode()", "'encode'"),
        ("pi()", "pi is not a function"),
        ("'a'()", "is not a function"),
        ("[0 for pi.x in [1]]", "must be a name"),
        ("[x for x in 5]", "cannot be iterated"),
        ("10**400 * 1.0", "too large"),
        ("exp(1000)", "range"),
    ],
)
def test_what_has_no_value(expression: str, words: str) -> None:
    with pytest.raises(RobotFileError) as caught:
        value(f"${{{expression}}}")
    assert words in str(caught.value) and "\n" not in str(caught.value)
