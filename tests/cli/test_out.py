"""Files of ``--out`` that cannot be written: one line before long computations, in every command."""

import os

import pytest
from test_cli import fails

import kinetostatics as ks
from kinetostatics.cli.commands import COMMANDS, command

POSE = "--platform z=0.5 rx=0 ry=0".split()
#: Arguments of every command that writes files, and an ending that it accepts.
WRITING = {
    "analyze": (["3rps", "--table", "{table}"], ".csv"),
    "compensate": (["3rps", *POSE], ".csv"),
    "response": (["3rps", "--frequencies", "1:9:3"], ".csv"),
    "sweep": (["3rps", "--platform", "z=0.5:0.6:2", "rx=0", "ry=0"], ".nc"),
    "report": (["3rps", *POSE], ".html"),
    "tolerances": (["3rps", "--tolerance", "rod_*.outer_diameter=0.1mm"], ".svg"),
    "sensitivities": (["3rps"], ".svg"),
    "optimize": (["3rps", "--vary", "rod_diameter=40mm:60mm", "--subject-to", "sag < 1mm"], ".urdf"),
    "calibrate": (["3rps", "--plan", "3", "--unknowns", "rod_1", "--platform", "z=0.5:0.6:3", "rx=0", "ry=0"], ".csv"),
    "new": (["3-RPS"], ".xacro"),
    "plot": (["{map}", "--what", "linear_sag"], ".svg"),
    "export": (["3rps"], ""),
}


def test_all_commands_that_write_files_are_here():
    assert set(WRITING) == {name for name in COMMANDS if "out" in command(name).options}


@pytest.fixture(scope="module")
def small_map(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.nc"
    ks.sweep("3rps", platform={"z": [0.5, 0.55, 0.6], "rx": [0.0, 0.05, 0.1], "ry": 0.0}, out=path).close()
    return path


@pytest.mark.parametrize("name", WRITING)
@pytest.mark.parametrize("kind", ["folder", "missing", "not permitted"])
def test_unwritable_files_are_one_line(capsys, tmp_path, monkeypatch, small_map, name, kind):
    monkeypatch.chdir(tmp_path)
    arguments, ending = WRITING[name]
    if kind == "not permitted":
        monkeypatch.setattr(os, "access", lambda *_: False)  # root may write everywhere but to /proc
    (tmp_path / f"folder{ending}").mkdir()
    (tmp_path / "table.csv").write_text("time,z,rx,ry\n0,0.5,0,0\n1,0.55,0,0\n")
    out = {"folder": f"folder{ending}", "missing": f"missing/x{ending}", "not permitted": f"/proc/x{ending}"}[kind]
    if name == "export":  # its folder is created
        out = {"folder": "table.csv", "missing": "table.csv/x", "not permitted": "/proc/x"}[kind]
    values = [item.format(table="table.csv", map=small_map) for item in arguments]
    message = fails(capsys, name, *values, "--out", out)
    assert os.path.basename(out) in message or os.path.dirname(out) in message, message


@pytest.mark.parametrize("out", [".", "..", "/"])
def test_a_report_needs_a_file(capsys, out):
    assert "HTML" in fails(capsys, "report", "3rps", "--out", out)
