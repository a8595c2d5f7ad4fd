"""The page about robots by name: its commands and its Python run, its names build robots, its table is one."""

import re

from page_code import blocks, run_commands, run_python, text_of

import kinetostatics as ks
from kinetostatics.authoring.limb_parts import skeleton_of
from kinetostatics.authoring.notation import parse_architecture
from kinetostatics.cli.main import main

PAGE = text_of("start/robot_by_name")


def test_its_commands_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_commands("start/robot_by_name") == 4
    assert {path.name for path in tmp_path.iterdir()} == {"my_robot.urdf.xacro", "my_robot.html", "my_delta.urdf.xacro"}
    (inline,) = re.findall(r"`--set (\w+=\w+)`", PAGE)
    assert main(["check", "my_robot.urdf.xacro", "--set", inline]) == 0 and "tube ⌀50/43 mm" in capsys.readouterr().out


def test_its_python_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = run_python("start/robot_by_name")
    assert names["robot"].mobility.platform == 3 and "my_hexapod" in (tmp_path / "my_hexapod.urdf.xacro").read_text()


def test_its_table_of_places_is_one(tmp_path):
    table = tmp_path / "table.csv"
    table.write_text(next(block.text for block in blocks(PAGE) if block.kind == "text"))
    assert ks.new_robot("2-U[P]R+S[P]R", placements=table, height=0.3).mobility.platform == 3


def test_its_names_are_read():
    cells = re.findall(r"^\| (`[^|]+`) \| [^|]+ \|$", PAGE.partition("| name |")[2], re.MULTILINE)
    names = [name for cell in cells for name in re.findall(r"`([^`]+)`", cell)]
    assert len(names) > 15
    for name in names:
        architecture = parse_architecture(name)
        assert architecture.text == name.replace("2(SS)", "(4S)") and not architecture.actuators_chosen
        assert [skeleton_of(architecture, group) for group in architecture.groups]
