"""The page about robots by name: its commands and Python run, its table of placements is valid, its gallery is up to date."""

import re

import robots_by_name
from page_code import blocks, run_commands, run_python, text_of

import kinetostatics as ks
from kinetostatics.authoring.known_names import KNOWN_NAMES
from kinetostatics.cli.main import main

PAGE = text_of("start/robot_by_name")


def test_commands_of_the_page_write_their_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_commands("start/robot_by_name") == 4
    assert {path.name for path in tmp_path.iterdir()} == {"my_robot.urdf.xacro", "my_robot.html", "my_delta.urdf.xacro"}
    (inline,) = re.findall(r"`--set (\w+=\w+)`", PAGE)
    assert main(["check", "my_robot.urdf.xacro", "--set", inline]) == 0 and "tube ⌀50/43 mm" in capsys.readouterr().out


def test_python_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = run_python("start/robot_by_name")
    assert names["robot"].mobility.platform == 3 and "my_hexapod" in (tmp_path / "my_hexapod.urdf.xacro").read_text()


def test_placement_table_of_the_page_is_valid(tmp_path):
    table = tmp_path / "table.csv"
    table.write_text(next(block.text for block in blocks(PAGE) if block.kind == "text"))
    assert ks.new_robot("2-U[P]R+S[P]R", placements=table, height=0.3).mobility.platform == 3


def test_gallery_of_names_is_up_to_date():
    assert robots_by_name.PAGE.read_text(encoding="utf-8") == robots_by_name.page_text(), "run python examples/robots_by_name.py"
    drawn = {file.stem for file in robots_by_name.PICTURES.iterdir()}
    assert drawn == {robots_by_name.file_of(known) for known in KNOWN_NAMES}
