"""Robot files that are wrong in every way that came to mind: always a result or one clear message, and soon.

Every file goes the whole way, from reading to forces, in a process of its own with limits on time and memory
(:mod:`file_worker`), where numpy's warnings are errors. What must come out is a result, with finite numbers or a status that says
why not, or a :class:`KinetostaticsError` of one paragraph. Nothing may hang, crash, print, or read files that the robot
does not include.

More random files than usual: ``KINETOSTATICS_FUZZ=5000 pytest tests/properties/test_fuzz_files.py -n 2`` (the number for each of
the random tests, a third of it for the slowest; 5000 take about five minutes).
"""

import copy
import os
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import escape

import pytest
import small_robots
from file_worker import Outcome, Worker
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import ROOT

from kinetostatics.cli.main import main
from kinetostatics.files.reader import read_robot_file

#: Random files of each kind.
NUMBER = int(os.environ.get("KINETOSTATICS_FUZZ", "6"))
#: Time [s] in which an answer must come, on a busy machine too.
SECONDS = 20.0

SHIPPED = sorted((ROOT / "robots").glob("*.xacro"))
EXAMPLE = (ROOT / "docs" / "reference" / "robot_format.md").read_text(encoding="utf-8").split("```xml\n")[1].split("```")[0]
XACRO = EXAMPLE.replace('<robot name="parallelogram">', '<robot name="p" xmlns:xacro="http://www.ros.org/wiki/xacro">')


def with_body(body: str, text: str = EXAMPLE) -> str:
    return text.replace("</robot>", f"{body}</robot>")


def xacro(body: str) -> str:
    return with_body(body, XACRO)


def expression(text: str) -> str:
    return xacro(f"<gazebo>{text}</gazebo>")


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    item = Worker(SECONDS)
    yield item
    item.close()


def check(outcome: Outcome, words: Sequence[str] = (), touched: Sequence[str] = ()) -> None:
    assert list(outcome.touched) == list(touched)
    assert outcome.kind in ("result", "error"), f"{outcome.kind} at {outcome.stage!r}: {outcome.text}"
    for word in words:
        assert outcome.kind == "error" and word in outcome.text, f"{word!r} is not in {outcome.kind}: {outcome.text}"


def run(worker: Worker, folder: Path, text: str | bytes, name: str = "robot.urdf", how: str = "result") -> Outcome:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    return worker.run(path, None, how)


# ---- files, one by one -----------------------------------------------------------------------------------------------------


def entities(levels: int) -> str:
    declared = "".join(f'<!ENTITY e{k + 1} "{f"&e{k};" * 10}">' for k in range(levels))
    return f'<?xml version="1.0"?><!DOCTYPE r [<!ENTITY e0 "aaaaaaaaaa">{declared}]><robot name="&e{levels};"/>'


def row(number: int, kind: str) -> str:
    """Return links in a row that hang on the platform."""
    parts = []
    for k in range(number):
        parent = f"row_{k - 1}" if k else "plate"
        parts.append(
            f'<link name="row_{k}"/><joint name="row_joint_{k}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="row_{k}"/><origin xyz="0 0 0.001"/><axis xyz="0 0 1"/></joint>'
        )
    return with_body("".join(parts))


def star(number: int) -> str:
    """Return links that hang on the platform side by side."""
    return row(number, "fixed").replace('parent link="row_', 'parent link="plate" data="')


def loops(number: int) -> str:
    sides = '<predecessor link="ground"/><successor link="plate"><origin xyz="0 0 -0.3"/></successor>'
    return "".join(f'<loop name="loop_{k}" type="spherical">{sides}</loop>' for k in range(number))


#: What is in the file, and words of the message; no words: a result or any message.
XML: dict[str, tuple[str | bytes, list[str]]] = {
    "null characters": (EXAMPLE.replace("left", "le\0ft"), ["well-formed"]),
    "only null characters": (b"\0" * 1000, ["well-formed"]),
    "half a file": (EXAMPLE[: len(EXAMPLE) // 2], ["well-formed"]),
    "two roots": (EXAMPLE + EXAMPLE.partition("\n")[2], ["well-formed"]),
    "not UTF-8": (EXAMPLE.replace("left", "lïeft").encode("latin-1"), ["well-formed"]),
    "UTF-32": (EXAMPLE.encode("utf-32"), ["well-formed"]),
    "UTF-7": (EXAMPLE.replace("?>", ' encoding="utf-7"?>', 1), ["decoded"]),
    "zlib for an encoding": (EXAMPLE.replace("?>", ' encoding="zlib"?>', 1), ["decoded"]),
    "idna for an encoding": (EXAMPLE.replace("?>", ' encoding="idna"?>', 1), ["decoded"]),
    "EBCDIC": (EXAMPLE.replace("?>", ' encoding="cp037"?>', 1), ["encoding"]),
    "billion laughs": (entities(9), ["DOCTYPE"]),
    "billion laughs in UTF-16": (entities(9).encode("utf-16"), ["DOCTYPE"]),
    "external entity": ('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>', ["DOCTYPE"]),
    "parameter entity": ('<!DOCTYPE r [<!ENTITY % p SYSTEM "file:///etc/passwd"> %p;]><robot name="r"/>', ["DOCTYPE"]),
    "external DTD": ('<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot name="r"/>', ["DOCTYPE"]),
    "XInclude": (
        with_body('<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd" parse="text"/>'),
        [],
    ),
    "style sheet": ('<?xml-stylesheet href="file:///etc/passwd"?>' + EXAMPLE.partition("\n")[2], []),
    "line break in a name": (EXAMPLE.replace('"left"', '"le&#10;ft"'), ["line breaks"]),
    "tab in a name": (EXAMPLE.replace('"a"', '"a&#9;"'), ["line breaks"]),
    "long name": (EXAMPLE.replace('"left"', f'"{"x" * 5000}"'), ["5000 characters"]),
    "huge name": (EXAMPLE.replace('"left"', f'"{"x" * 1_000_000}"'), ["longer than"]),
    "long reference": (EXAMPLE.replace('<parent link="left"/>', f'<parent link="{"left" * 2000}"/>'), ["does not exist"]),
    "long number": (EXAMPLE.replace("210e9", "9" * 9000), ["not finite"]),
    "long junk": (EXAMPLE.replace("210e9", "x9" * 4500), ["is not a number"]),
    "long vector": (EXAMPLE.replace("0 1 0", "0 " * 4500), ["three numbers, not 4500"]),
    "long tag": (with_body(f"<{'platforn' * 100_000}/>"), ["is not a name"]),
    "many attributes": (with_body("<a " + " ".join(f'a{k}=""' for k in range(150_000)) + "/>"), ["more than 100000"]),
    "many elements": (with_body("<a/>" * 150_000), ["more than 100000"]),
    "many comments": (with_body("<!---->" * 150_000), ["more than 100000"]),
    "large file": (with_body("<!--" + "x" * 11_000_000 + "-->"), ["larger than 10 MB"]),
    "nested 99 deep": (with_body("<a>" * 98 + "</a>" * 98), []),
    "nested 101 deep": (with_body("<a>" * 100 + "</a>" * 100), ["nested more than 100"]),
    "nested 100000 deep": ("<a>" * 100_000, ["nested more than 100"]),
    "missing meshes": (
        EXAMPLE.replace(
            '<link name="left"/>',
            '<link name="left"><visual><geometry><mesh filename="package://none/x.stl"/></geometry></visual><collision>'
            '<geometry><mesh filename="/none/x.dae" scale="nan 1 1"/></geometry></collision></link>',
        ),
        [],
    ),
    "impossible shapes": (
        EXAMPLE.replace(
            '<link name="left"/>',
            '<link name="left"><visual><geometry><box size="x"/></geometry><material name="m"><color rgba="y"/></material>'
            '</visual><collision><geometry><sphere radius="-1"/><cylinder/></geometry></collision></link>',
        ),
        [],
    ),
    "loop on one link": (EXAMPLE.replace('<predecessor link="right">', '<predecessor link="plate">'), ["itself"]),
    "joint on one link": (EXAMPLE.replace('<parent link="left"/>', '<parent link="plate"/>'), ["itself"]),
    "cyclic joints": (
        EXAMPLE.replace('<parent link="ground"/><child link="left"/>', '<parent link="plate"/><child link="left"/>'),
        ["cycle"],
    ),
    "zero section": (EXAMPLE.replace('<circle diameter="0.02"/>', '<circle diameter="0"/>'), ["greater than zero"]),
    "far away": (EXAMPLE.replace('xyz="0.4 0 0"', 'xyz="1e300 0 0"', 1), ["too large", "1e+09"]),
    "heavy": (EXAMPLE.replace('density="7850"', 'density="1e154"', 1), ["too large"]),
    "soft": (EXAMPLE.replace("210e9", "5e-324", 1), ["too small"]),
    "shear": (EXAMPLE.replace('poisson_ratio="0.3"', 'poisson_ratio="0.3" shear_coefficient="1e-300"', 1), ["too small"]),
    "a joint called universe": (EXAMPLE.replace('"a"', '"universe"'), []),
    "a link called universe": (EXAMPLE.replace('"left"', '"universe"'), []),
    "a root called universe": (EXAMPLE.replace('"ground"', '"universe"'), []),
    "a joint called root_joint": (EXAMPLE.replace('"a"', '"root_joint"'), []),
    "a joint called like a link": (EXAMPLE.replace('"a"', '"left"'), []),
    "2000 links side by side": (star(2000), ["more than 1000 links"]),
    "800 links side by side": (star(800), []),
    "500 links in a row": (row(500, "fixed"), ["more than 400 joints in a row"]),
    "100 hinges in a row": (row(100, "continuous"), []),
    "300 floating links": (row(300, "floating"), ["more than 500 freedoms"]),
    "300 loops": (with_body(loops(300)), ["more than 250 loops"]),
    "100 loops": (with_body(loops(100)), []),
}

#: The same of expressions.
EXPRESSIONS: dict[str, list[str]] = {
    "$" * 50_000: ["invalid expression"],
    "${" * 50_000: ["invalid expression"],
    "${'a\\n\\nb' + 1}": ["expand"],
    "${xacro.fatal('a'*10**4)}": ["aaa"],
    "${'\\ud800'}": ["character"],
    "${'\\x00'}": ["character"],
    "${(-8)**0.5}": [],
    "${1e999}": [],
    "$(env KINETOSTATICS_NOT_SET)": ["not set"],
    "$(find x)": ["ROS"],
    "$(dirname)": [],
    "$(cwd)": [],
    "$(rm -rf x)": ["Unknown substitution"],
}


EXPANSIONS: dict[str, tuple[str, list[str]]] = {
    "a macro that calls itself": (xacro('<xacro:macro name="m"><b/><xacro:m/></xacro:macro><xacro:m/>'), ["calls itself"]),
    "a macro that calls itself twice": (
        xacro('<xacro:macro name="m"><xacro:m/><xacro:m/></xacro:macro><xacro:m/>'),
        ["calls itself"],
    ),
    "macros nested deep": (
        xacro('<xacro:macro name="m" params="n"><xacro:if value="${n}"><a><xacro:m n="${n-1}"/></a></xacro:if></xacro:macro>'
              '<xacro:m n="110"/>'),
        ["nested more than 100"],
    ),
    "properties in a circle": (
        xacro('<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/><q z="${a}"/>'),
        ["circular"],
    ),
    "a file that includes itself": (xacro('<xacro:include filename="robot.xacro"/>'), ["includes itself"]),
    "two files that include each other": (xacro('<xacro:include filename="back.xacro"/>'), ["includes itself"]),
    "a file that includes itself twice": (xacro('<xacro:include filename="robot.xacro"/>' * 2), ["includes itself"]),
    "a missing file": (xacro('<xacro:include filename="none.xacro"/>'), ["none.xacro", "No such file"]),
    "a missing file above": (xacro('<xacro:include filename="../../none.xacro"/>'), ["none.xacro", "No such file"]),
    "no XML": (xacro('<xacro:include filename="/etc/passwd"/>'), ["/etc/passwd:1", "well-formed"]),
    "a device": (xacro('<xacro:include filename="/dev/zero"/>'), ["not an ordinary file"]),
    "a folder": (xacro('<xacro:include filename="."/>'), ["directory"]),
    "all files beside it": (xacro('<xacro:include filename="*.xacro"/>'), ["includes itself"]),
    "a null character": (xacro("<xacro:include filename=\"${'\\0'}\"/>"), ["null"]),
    "an element that has no name": (xacro('<xacro:element xacro:name="a b"/>'), ["not a name"]),
    "an element that is a number": (xacro('<xacro:element xacro:name="${1}"/>'), ["int"]),
    "an attribute that is a number": (xacro('<xacro:attribute name="n" value="${1}"/>'), []),
    "an attribute whose name is a number": (xacro('<xacro:attribute name="${1}" value="2"/>'), ["int"]),
    "YAML that makes objects": (expression("${xacro.load_yaml('object.yaml')}"), ["object.yaml"]),
    "YAML that is none": (expression("${xacro.load_yaml('bad.yaml')}"), ["bad.yaml", "line 2"]),
}  # fmt: skip
BESIDE = {
    "back.xacro": xacro('<xacro:include filename="robot.xacro"/>'),
    "object.yaml": "!!python/object/apply:os.system [ls]\n",
    "bad.yaml": "a: [\n b: :\n",
}


#: Files that take a second and more until they are read or refused, each beside a shorter one of its kind.
LARGE = {
    "100 loops",
    "800 links side by side",
    "100 hinges in a row",
    "two files that include each other",
}


@pytest.mark.few(28)
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in XML])
def test_xml(worker: Worker, tmp_path: Path, name: str) -> None:
    text, words = XML[name]
    check(run(worker, tmp_path, text), words)


@pytest.mark.few(4)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
@pytest.mark.parametrize("text", [EXAMPLE, expression("${1+1}")])
def test_encodings_that_are_read(worker: Worker, tmp_path: Path, encoding: str, text: str) -> None:
    written = text.replace("?>", ' encoding="latin-1"?>', 1).replace("left", "lïeft") if encoding == "latin-1" else text
    outcome = run(worker, tmp_path, written.encode(encoding))
    assert outcome.kind == "result", outcome.text


@pytest.mark.few(14)
@pytest.mark.parametrize("text", EXPRESSIONS, ids=lambda text: text[:60])
def test_expressions(worker: Worker, tmp_path: Path, text: str) -> None:
    escaped = text.replace("<", "&lt;")
    check(run(worker, tmp_path, expression(escaped), "robot.xacro", "read"), EXPRESSIONS[text])


@pytest.mark.few(14)
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in EXPANSIONS])
def test_expansions(worker: Worker, tmp_path: Path, name: str) -> None:
    for item, content in BESIDE.items():
        (tmp_path / item).write_text(content, encoding="utf-8")
    text, words = EXPANSIONS[name]
    check(run(worker, tmp_path, text, "robot.xacro"), words, ["/etc/passwd"] if "etc/passwd" in text else [])


# ---- paths and the command line --------------------------------------------------------------------------------------------


def test_paths(worker: Worker, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "circle").symlink_to(tmp_path / "circle")
    for path, words in [
        (tmp_path / "pipe", ["not an ordinary file"]),
        (Path("/dev/zero"), ["not an ordinary file"]),
        (tmp_path / "empty", ["empty"]),
        (tmp_path / "circle", ["cannot be read"]),
        (tmp_path / "none", ["No such file"]),
        (tmp_path, ["directory"]),
        (tmp_path / ("x" * 1000), ["cannot be read"]),
    ]:
        outcome = worker.run(path)
        assert outcome.kind == "error", outcome
        assert all(word in outcome.text for word in words), outcome


def test_parameters(worker: Worker, tmp_path: Path) -> None:
    path = tmp_path / "robot.xacro"
    path.write_text(xacro('<xacro:arg name="n" default="1"/><gazebo>${2*$(arg n)}</gazebo>'), encoding="utf-8")
    assert worker.run(path, {"n": "3"}).kind == "result"
    for value in ("[].__class__", "1]", "x" * 10**6):
        outcome = worker.run(path, {"n": value})
        assert outcome.kind == "error", outcome


WRONG = {
    "not XML": EXAMPLE[:300],
    "entities": entities(9),
    "macros": xacro('<xacro:macro name="m"><xacro:m/><xacro:m/></xacro:macro><xacro:m/>'),
    "code": expression("${[y.__class__ for y in [1]]}"),
    "loop on one link": XML["loop on one link"][0],
    "rigid platform": EXAMPLE.replace("continuous", "fixed").replace('type="revolute"', 'type="fixed"'),
}


@pytest.mark.parametrize("command", ["check", "analyze"])
@pytest.mark.parametrize("name", WRONG)
def test_command_line(tmp_path: Path, name: str, command: str, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(str(WRONG[name]), encoding="utf-8")
    code, (out, err) = main([command, str(path)]), capfd.readouterr()  # of the process: libraries print too
    assert (code, out) == (2, "")
    assert err.startswith("kinetostatics: error: ") and err.count("\n") == 1
    assert str(path) in err and len(err) < 2000


# ---- random changes --------------------------------------------------------------------------------------------------------

Pick = Callable[[Sequence[Any]], Any]

NUMBERS = (
    *("nan", "inf", "-inf", "", "x", "1,5", "0x10", "1_0", "٣", "1e999", "9" * 400),
    *("0", "-0.0", "-1", "1", "2", "1e-3", "1e3", "1e-6", "1e6", "3.141592653589793", "1.57"),
    *("1e300", "-1e300", "1e-300", "1e154", "1e100", "1e-100", "1e30", "1e-30", "1e20", "1e-20", "1e12", "1e-12", "5e-324"),
)
JUNK = (
    *("", " ", "x", "0", "1 2", "1 2 3", "1 2 3 4", "nan nan nan", "0 0 0", "\n", "é", "☃", "\U0001f600", "<&>\"'", "a:child"),
    *("${1/0}", "$(arg x)", "../../x", "package://x/y.stl", "file:///etc/passwd", "%s%n", "x" * 3000, "universe", "-"),
)
TYPES = (*("fixed", "revolute", "continuous", "prismatic", "floating", "planar", "cylindrical", "universal", "spherical", "x"),)
ELEMENTS = (
    *("<base link='{link}'/>", "<platform link='{link}'/>", "<transmission><joint name='{joint}'/></transmission>"),
    *("<loop name='new' type='{type}'><predecessor link='{link}'/><successor link='{link2}'/></loop>",),
    "<loop name='new' type='{type}'><predecessor link='{link}'><origin xyz='{number} 0 0' rpy='0 {number} 0'/></predecessor>"
    "<successor link='{link2}'/></loop>",
    *("<joint name='new' type='{type}'><parent link='{link}'/><child link='{link2}'/></joint>", "<link name='new'/>"),
    "<beam link='{link}' youngs_modulus='{number}' poisson_ratio='0.3' density='{number}' name='new'>"
    "<circle diameter='{number}'/></beam>",
    "<beam link='{link}' from='{joint}' to='{joint2}' youngs_modulus='2e11' poisson_ratio='0.3'><circle diameter='0.01'/></beam>",
    *("<mimic joint='{joint}'/>", "<mimic joint='{joint}' multiplier='{number}' offset='{number}'/>", "<inertial/>"),
    "<joint_stiffness joint='{joint}' linear='{number} {number} {number}' angular='1e5 1e5 {number}' drive='{number}'/>",
    *("<joint_stiffness joint='{joint}' angular='{number} inf inf'/>", "<joint_stiffness joint='{joint}' drive='{number}'/>"),
    *("<origin xyz='{number} {number} {number}'/>", "<axis xyz='0 0 {number}'/>"),
    *("<limit lower='{number}' upper='1' effort='1' velocity='1'/>", "<cone angle='{number}'/>", "text", "<gazebo><x/></gazebo>"),
    "<inertial><mass value='{number}'/><inertia ixx='{number}' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>",
)


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def names(root: ElementTree.Element, *tags: str) -> list[str]:
    return [item.get("name", "") for item in root if item.tag in tags] or [""]


def change(root: ElementTree.Element, pick: Pick) -> str:
    """Change one thing in a robot; return what was done."""
    parents = [(parent, child) for parent in root.iter() for child in parent]
    parent, element = pick(parents) if parents else (root, root)
    links, joints = names(root, "link"), names(root, "joint", "loop")
    numeric = [
        (item, name) for item in root.iter() for name, value in item.attrib.items() if is_number((value.split() or ["x"])[0])
    ]
    references = [
        (item, name, links if item.get(name) in links else joints)
        for item in root.iter()
        for name in ("link", "from", "to", "joint", "name")
        if item.get(name) in links + joints
    ]
    kind = pick(("number", "number", "number", "number", "reference", "reference", "type", "junk", "delete", "delete attribute",
                 "duplicate", "swap", "sides", "move", "add", "add", "tag", "rename"))  # fmt: skip
    if kind == "number" and numeric:
        item, name = pick(numeric)
        parts = item.attrib[name].split()
        parts[pick(range(len(parts)))] = pick(NUMBERS)
        item.set(name, " ".join(parts))
        return f"{item.tag} {name}={item.get(name)!r}"
    if kind == "reference" and references:
        item, name, known = pick(references)
        item.set(name, pick(known))
        return f"{item.tag} {name}={item.get(name)!r}"
    if kind == "type":
        found = [item for item in root.iter() if item.get("type")]
        if found:
            item = pick(found)
            item.set("type", pick(TYPES))
            return f"{item.get('name')} becomes {item.get('type')}"
    if kind == "junk" and element.attrib:
        name = pick(sorted(element.attrib))
        element.set(name, pick(JUNK))
        return f"{element.tag} {name}={element.get(name)!r}"
    if kind == "delete" and parent is not element:
        parent.remove(element)
        return f"{element.tag} deleted"
    if kind == "delete attribute" and element.attrib:
        name = pick(sorted(element.attrib))
        del element.attrib[name]
        return f"{name} of {element.tag} deleted"
    if kind == "duplicate":
        twin = copy.deepcopy(element)
        if pick((False, True)) and twin.get("name"):
            twin.set("name", twin.get("name", "") + "_twin")
        parent.append(twin)
        return f"{element.tag} twice"
    if kind == "swap" and len(parent) > 1:
        i, j = pick(range(len(parent))), pick(range(len(parent)))
        parent[i], parent[j] = parent[j], parent[i]
        return f"children {i} and {j} of {parent.tag} swapped"
    if kind == "sides":
        pairs = [
            (item.find(a), item.find(b)) for item in root.iter() for a, b in (("parent", "child"), ("predecessor", "successor"))
        ]
        pairs = [(a, b) for a, b in pairs if a is not None and b is not None]
        if pairs:
            a, b = pick(pairs)
            a.tag, b.tag = b.tag, a.tag
            return f"{a.tag} and {b.tag} swapped"
    if kind == "move" and element is not root:
        goal = pick([item for item in root.iter() if item not in set(element.iter())])
        parent.remove(element)
        goal.append(element)
        return f"{element.tag} moved into {goal.tag}"
    if kind == "tag":
        element.tag = pick(("link", "joint", "loop", "beam", "platform", "base", "origin", "axis", "transmission", "x"))
        return f"an element becomes {element.tag}"
    if kind == "rename" and references:
        item, name, _ = pick(references)
        item.set(name, pick(JUNK))
        return f"{item.tag} {name}={item.get(name)!r}"
    values = {"link": pick(links), "link2": pick(links), "joint": pick(joints), "joint2": pick(joints), "type": pick(TYPES)}
    written = {name: escape(value, {"'": "&apos;"}) for name, value in values.items()}
    text = pick(ELEMENTS).format(**written, number=pick(NUMBERS))
    goal = pick((root, root, element))
    if text.startswith("<"):
        goal.insert(pick(range(len(goal) + 1)), ElementTree.fromstring(text))
    else:
        goal.text = text
    return f"{text} in {goal.tag}"


#: Elastic joints of all kinds, and a flap that follows the actuator.
ELASTIC = with_body(
    "<link name='flap'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>"
    "<joint name='hinge' type='continuous'><parent link='plate'/><child link='flap'/><axis xyz='0 1 0'/>"
    "<mimic joint='a' multiplier='-0.5' offset='0.1'/></joint>"
    "<joint_stiffness joint='a' linear='1e8 1e8 inf' angular='1e5 2e5 1e5' drive='3e4'/>"
    "<joint_stiffness joint='b' angular='1e5 0 inf'/>"
    "<joint_stiffness joint='c' linear='1e8 1e8 1e8' angular='1e5 10 1e5'/><joint_stiffness joint='hinge' angular='inf 1e3 inf'/>"
)


@cache
def sources() -> list[str]:
    """Return the robots that are changed: the shipped ones, expanded, the documentation's and small ones."""
    specs = (small_robots.gough(), small_robots.planar_3rrr(), small_robots.four_bar(), small_robots.stepped_beam())
    small = [small_robots.write(spec).text for spec in specs]
    plain = []
    for path in SHIPPED:
        root = ElementTree.fromstring(read_robot_file(path).urdf)
        for link in root.iter("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
        plain.append(ElementTree.tostring(root, encoding="unicode"))
    return [*plain, EXAMPLE, ELASTIC, *small]


def changed(pick: Pick) -> tuple[str, list[str]]:
    """Return a robot file with one to three things changed, and what they are."""
    root = ElementTree.fromstring(pick(sources()))
    done = [change(root, pick) for _ in range(pick((1, 1, 2, 3)))]
    return ElementTree.tostring(root, encoding="unicode"), done


def thrashed(pick: Pick) -> bytes:
    """Return a robot file, xacro too, of which a piece is cut out, repeated or overwritten."""
    data = bytearray(pick([path.read_bytes() for path in SHIPPED] + [XACRO.encode(), EXAMPLE.encode("utf-16")]))
    for _ in range(pick((1, 2, 3))):
        start = pick(range(len(data)))
        stop = min(len(data), start + pick((1, 1, 2, 10, 100, 1000)))
        piece = bytes(data[start:stop])
        new = pick((b"", piece * 2, bytes(reversed(piece)), b"\0", b"<", b">", b'"', b"&", b"${", b"}", b"$(", b"\xff\xfe",
                    b"]]>", b"<!--", b"<xacro:", b"<!DOCTYPE x>", b"nan", b"-", b"e9", b"${pi}", b"'"))  # fmt: skip
        data[start:stop] = new
    return bytes(data)


def scaled(pick: Pick) -> tuple[str, list[str]]:
    """Return a robot file with one to six numbers of another order of magnitude, here and there or all of a kind."""
    root = ElementTree.fromstring(pick(sources()))
    done = []
    for _ in range(pick((1, 1, 2, 3, 6))):
        places = [
            (item, name)
            for item in root.iter()
            for name, value in item.attrib.items()
            if value.split() and is_number(value.split()[0]) and name not in ("rpy", "name", "effort", "velocity", "version")
        ]
        item, name = pick(places)
        factor = pick((-1, 1)) if pick(range(10)) == 0 else 10.0 ** pick(range(-31, 31))
        same = [other for other in root.iter(item.tag) if other.get(name)] if pick((False, True)) else [item]
        for other in same:
            parts = [float(part) for part in other.attrib[name].split()]
            other.set(name, " ".join(repr(part * factor if part else pick((0.0, 0.0, factor))) for part in parts))
        done.append(f"{name} of {len(same)} {item.tag} times {factor:g}")
    return ElementTree.tostring(root, encoding="unicode"), done


def fuzz(number: int) -> settings:
    return settings(max_examples=number, deadline=None, suppress_health_check=list(HealthCheck))


@fuzz(NUMBER)
@given(data=st.data())
def test_changed_robots(worker: Worker, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    text, done = changed(lambda items: data.draw(st.sampled_from(items)))
    outcome = run(worker, tmp_path_factory.getbasetemp(), text)
    assert outcome.kind in ("result", "error"), f"{done}: {outcome.kind} at {outcome.stage!r}: {outcome.text}\n{text}"
    assert outcome.touched == ()


@fuzz(NUMBER // 3)
@given(data=st.data())
def test_numbers_of_other_orders(worker: Worker, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    text, done = scaled(lambda items: data.draw(st.sampled_from(items)))
    outcome = run(worker, tmp_path_factory.getbasetemp(), text)
    assert outcome.kind in ("result", "error"), f"{done}: {outcome.kind} at {outcome.stage!r}: {outcome.text}\n{text}"


@fuzz(NUMBER)
@given(data=st.data())
def test_thrashed_files(worker: Worker, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    content = thrashed(lambda items: data.draw(st.sampled_from(items)))
    check(run(worker, tmp_path_factory.getbasetemp(), content))
