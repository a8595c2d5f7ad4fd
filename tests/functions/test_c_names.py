"""No text of a robot file is code in exported files: nasty names of robots, joints and links, compiled strictly."""

import re
import shutil
import subprocess
from xml.sax.saxutils import quoteattr

import markdown_it
import pytest
from c_programs import STRICT

import kinetostatics as ks
from kinetostatics.functions.c_names import c_comment, c_names, identifier, markdown

#: Names that would end a comment, a string or a line, begin a macro, a variable, a heading, an element, ….
NASTY = {
    "comment": "*/ int evil; /*",
    "star at the end": "x *",
    "string": '"); int evil; ("%n%s',
    "backslash": "a\\",
    "trigraph": "*??/",
    "line comment": "a // b",
    "cmake": "${EVIL};$ENV{HOME}) message(FATAL_ERROR evil",
    "markdown": "`` ` ``<script>evil()</script> [x](javascript:evil) **b** _c_ | d # e #",
    "unicode": "größe 臂",
    "keyword": "int",
    "macro": "NAN",
    "header": "math",
    "target": "test",
    "reserved": "_Bool",
    "digit": "²",
}


def arm(folder, name):
    """Return an arm of two actuated beams, all of whose names contain ``name``."""
    more = ("", "2", " upper", " fore", " tip", " wrist")
    first, second, upper, fore, tip, wrist = (quoteattr(name + end) for end in more)
    joints = [(first, '"base"', upper, 0), (second, upper, fore, 0.4), (wrist, fore, tip, 0.3)]
    beams = [(upper, first, second), (fore, second, wrist)]
    parts = [f"<link name={link}/>" for link in ('"base"', upper, fore, tip)]
    for joint, parent, child, x in joints:
        kind = "fixed" if joint == wrist else "revolute"
        parts.append(
            f"""<joint name={joint} type="{kind}"><parent link={parent}/><child link={child}/>
            <origin xyz="{x} 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""
        )
    parts += [f'<transmission name="{k}"><joint name={joint}/></transmission>' for k, (joint, *_) in enumerate(joints[:2])]
    for link, start, end in beams:
        material = 'youngs_modulus="2e11" poisson_ratio="0.3" density="7850"'
        parts.append(f'<beam link={link} from={start} to={end} {material}><circle diameter="0.03"/></beam>')
    file = folder / "nasty.urdf"
    file.write_text(f"<robot name={first}>{''.join(parts)}<platform link={tip}/></robot>", encoding="utf-8")
    return ks.load_robot(file)


@pytest.fixture(scope="module", params=NASTY.values(), ids=NASTY)
def exported(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("nasty")
    robot = arm(folder, request.param)
    assert robot.name == request.param
    f = ks.compile(robot, outputs=("twist", "actuator_forces"), engine="numpy")
    return f.jacobian("actuator_forces", robot.description.actuated[0]).export_c(folder / "c"), request.param


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
def test_exported_symbols_are_the_functions_only(exported):
    """With and without trigraphs, which GNU C ignores; the test program agrees with Python."""
    export, _ = exported
    for dialect in ("-std=c99", "-std=gnu17"):
        command = ["gcc", *STRICT, dialect, "-I.", "-c", f"{export.name}.c", "-o", "robot.o"]
        subprocess.run(command, cwd=export.folder, check=True)
        table = subprocess.run(
            ["nm", "--extern-only", "--defined-only", "robot.o"], cwd=export.folder, capture_output=True, text=True
        )
        assert {line.split()[-1] for line in table.stdout.splitlines()} == {
            f"{export.name}_{function}" for function in ("start", "evaluate", "differentiate")
        }
    tests = ["gcc", *STRICT, "-I.", f"{export.name}_test.c", "robot.o", "-lm", "-o", "tests"]
    subprocess.run(tests, cwd=export.folder, check=True)
    found = subprocess.run([export.folder / "tests"], capture_output=True, text=True, check=True).stdout
    assert found.startswith("0 of 40 poses differ")


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_wrappers_compile(exported):
    export, _ = exported
    for dialect in ("-std=c++11", "-std=c++20"):
        subprocess.run(
            ["g++", dialect, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++", "-I.", f"{export.name}.hpp"],
            cwd=export.folder,
            check=True,
        )


@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_build_files_are_valid(exported):
    export, _ = exported
    made = subprocess.run(["cmake", "-B", "build"], cwd=export.folder, capture_output=True, text=True)
    assert made.returncode == 0 and "Warning" not in made.stderr, made.stderr


def test_all_files_but_the_readme_are_ascii(exported):
    export, _ = exported
    assert all((export.folder / name).read_bytes().isascii() for name in export.files if name != "README.md")


def test_readmes_show_names_as_text(exported):
    export, name = exported
    html = markdown_it.MarkdownIt("gfm-like", {"linkify": False}).render((export.folder / "README.md").read_text("utf-8"))
    assert set(re.findall(r"<(\w+)", html)) <= {
        "h1",
        "h2",
        "p",
        "ul",
        "li",
        "code",
        "pre",
        "table",
        "thead",
        "tbody",
        "tr",
        "th",
        "td",
    }
    heading = re.search("<h1>(.*) for a controller</h1>", html)[1]
    for entity, letter in (("&lt;", "<"), ("&gt;", ">"), ("&quot;", '"'), ("&amp;", "&")):
        heading = heading.replace(entity, letter)
    assert heading == name


def test_escaped_texts():
    assert c_comment("limb_1 a/b") == "limb_1 a/b" and c_comment("*/?\\ß") == r"\x2a/\x3f\\\xdf"
    assert markdown("limb_1 größe") == "limb_1 größe" and markdown("_a_ <b>") == r"\_a\_ \<b\>"


@pytest.mark.parametrize(
    ("name", "alone", "member"),
    [
        ("5 bars", "robot_5_bars", "robot_5_bars"),
        ("2", "robot_2", "robot_2"),
        ("a1-b", "a1_b", "a1_b"),
        ("größe", "gr__e", "gr__e"),
        ("_x", "robot__x", "robot__x"),
        ("int", "robot_int", "int_"),
        ("Math", "robot_Math", "Math"),
    ],
)
def test_c_identifiers_of_names(name, alone, member):
    assert identifier(name) == alone and c_names([name]) == {name: member}
    assert identifier("") == "robot_"


def test_struct_members_are_unique_and_no_keywords():
    assert c_names(["a_b", "a-b", "a b", "int", "class"]) == {
        "a_b": "a_b", "a-b": "a_b_", "a b": "a_b__", "int": "int_", "class": "class_",
    }  # fmt: skip


def test_actuators_named_like_arguments_are_refused(tmp_path):
    with pytest.raises(ks.ArgumentError, match="the actuator 'load' is named like another argument of the function"):
        ks.compile(arm(tmp_path, "load"))
