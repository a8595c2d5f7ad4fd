"""Robots that come with the package: their names stand for their files everywhere, and they can be listed and copied."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.files.bundled import shipped_robots
from kinetostatics.files.reader import parse_robot_text

NAMES = sorted(path.name.removesuffix(".urdf.xacro") for path in ROBOTS.glob("*.urdf.xacro"))


def test_name_of_a_shipped_robot_stands_for_its_file(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("3rps", Path("3rps"), b"3rps"):
        assert Path(ks.files.read_robot_file(name).path).samefile(ROBOTS / "3rps.urdf.xacro")
    robot = ks.load_robot("3rps", {"rod_diameter": 0.08})
    assert robot.description.beams["rod_1"].section.outer_diameter == 0.08
    assert ks.extend_robot("3rps").description.actuated == robot.description.actuated


def test_local_file_precedes_the_shipped_robot(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROBOTS / "2pru_upr.urdf.xacro", "3rps")
    shutil.copytree(ROBOTS / "library", "library")
    assert ks.load_robot("3rps").name == "2pru_upr"
    assert ks.sweep("3rps").attrs["robot_name"] == "2pru_upr"
    assert main(["check", "3rps", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["name"] == "2pru_upr"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("3rsp", "no robot of that name comes with the package: did you mean '3rps'"),
        ("robots/tricep.urdf.xacro", "did you mean 'tricept'"),
        ("zzzz", f"known: {NAMES[0]}, "),
    ],
)
def test_error_of_unknown_robot_suggests_similar_names(monkeypatch, tmp_path, name, hint):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ks.RobotFileError, match="No such file") as caught:
        ks.load_robot(name)
    assert hint in str(caught.value) and caught.value.file == name


@pytest.mark.parametrize("wrong", [None, ["3rps"]])
def test_wrong_type_of_path_is_an_error(wrong):
    with pytest.raises(ks.ArgumentError, match="is neither the path of a robot's file nor the name"):
        ks.load_robot(wrong)


def test_robots_are_listed_with_descriptions(capsys):
    found = ks.robots()
    assert sorted(found) == NAMES == list(found)
    assert found["3rps"].startswith("3RPS: three telescopic rods") and found["3rps"].endswith("under the platform.")
    assert all(about.endswith(".") and "\n" not in about and 30 < len(about) < 160 for about in found.values()), found
    assert main(["robots"]) == 0 and capsys.readouterr().out == f"{found}\n"
    assert main(["robots", "--json"]) == 0 and json.loads(capsys.readouterr().out) == dict(found)
    assert repr(found).splitlines() == [f"{name:{max(map(len, NAMES))}}  {found[name]}" for name in NAMES]


@pytest.mark.parametrize("name", ["3rps", "2pru_upr"])
def test_copied_robot_equals_the_shipped_one(monkeypatch, tmp_path, capsys, name):
    monkeypatch.chdir(tmp_path)
    assert main(["robots", "--copy", name]) == 0
    uses_library = '"library/' in (ROBOTS / f"{name}.urdf.xacro").read_text()
    parts = sorted(f"library/{part.name}" for part in (ROBOTS / "library").iterdir()) if uses_library else []
    assert capsys.readouterr().out == "".join(f"wrote {copy}\n" for copy in (f"{name}.urdf.xacro", *parts))
    assert ks.files.read_robot_file(f"{name}.urdf.xacro").urdf == ks.files.read_robot_file(name).urdf


def test_robot_without_local_library_uses_the_packaged_one(tmp_path):
    text = (ROBOTS / "3rps.urdf.xacro").read_text()
    alone = tmp_path / "3rps.urdf.xacro"
    alone.write_text(text)
    assert ks.files.read_robot_file(alone).urdf == parse_robot_text(text).urdf == ks.files.read_robot_file("3rps").urdf
    (tmp_path / "library").mkdir()
    (tmp_path / "library" / "limbs.xacro").write_text('<robot name="mine"><link name="of_my_own"/></robot>')
    with pytest.raises(ks.RobotFileError):  # a library beside the file comes first
        ks.files.read_robot_file(alone)
    alone.write_text(text.replace("library/limbs", "library/legs"))
    with pytest.raises(ks.RobotFileError, match=r"library/legs\.xacro"):
        ks.files.read_robot_file(alone)


def test_copies_overwrite_nothing(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    Path("delta.urdf.xacro").write_text("mine")
    Path("exechon.urdf.xacro").symlink_to("nowhere")
    for name in ("delta", "exechon"):
        assert main(["robots", "--copy", "3rps", name]) == 2
        assert f"{name}.urdf.xacro is there already, and is not overwritten" in capsys.readouterr().err
    assert Path("delta.urdf.xacro").read_text() == "mine" and not Path("3rps.urdf.xacro").exists()
    for folder in ("library", "mine"):
        Path(folder).mkdir()
    Path("library/joints.xacro").write_text("mine")
    assert main(["robots", "--copy", "3rps"]) == 2
    assert "library/joints.xacro is there already, and is not overwritten" in capsys.readouterr().err
    assert not Path("3rps.urdf.xacro").exists()
    monkeypatch.chdir("mine")
    assert main(["robots", "--copy", "3rps"]) == 0 and main(["robots", "--copy", "2pru_upr"]) == 0  # the library is there by then
    assert capsys.readouterr().out.count("library/joints.xacro") == 1
    assert main(["robots", "--copy", "dleta"]) == 2
    assert "did you mean 'delta'?" in capsys.readouterr().err


def test_robot_list_is_empty_without_robot_folders(monkeypatch, tmp_path):
    monkeypatch.setattr(sys.modules["kinetostatics.files.bundled"], "OWN_FOLDERS", (tmp_path / "none",))
    assert main(["robots"]) == 0 and dict(ks.robots()) == shipped_robots() == {}


def test_paths_are_shown_relative_to_the_working_folder(tmp_path, monkeypatch):
    from kinetostatics.files.bundled import robot_path, shown_path

    monkeypatch.chdir(tmp_path)
    assert shown_path(str(tmp_path / "sub" / "mine.urdf")) == "sub/mine.urdf"
    assert shown_path(str(robot_path("3rps"))) == "3rps.urdf.xacro" and shown_path("../x.urdf") == "../x.urdf"
    assert shown_path(str(tmp_path.parent / "x.urdf")) == str(tmp_path.parent / "x.urdf")
    robot = ks.load_robot("3rps")
    assert str(robot_path("3rps").parent) not in f"{robot}{robot!r}{robot._repr_html_()}{robot.description!r}"


def test_a_missing_file_is_the_same_error_everywhere(tmp_path, capsys):
    path = tmp_path / "3rpss"
    calls = (
        ks.load_robot,
        ks.files.read_robot_file,
        ks.extend_robot,
        lambda name: ks.sweep(name, {"z": [0.5]}),
        lambda name: ks.optimize(name, {"rod_diameter": "5cm:6cm"}, "mass"),
    )
    said = set()
    for call in calls:
        with pytest.raises(ks.RobotFileError) as caught:
            call(path)
        said.add(str(caught.value))
    assert len(said) == 1 and "cannot be read: No such file" in (text := said.pop()) and "did you mean '3rps'" in text
    assert main(["analyze", str(path)]) == 2 and text in capsys.readouterr().err
