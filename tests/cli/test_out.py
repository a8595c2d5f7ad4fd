"""Files of ``--out`` that cannot be written: one line before long computations, in every command."""

import json
import os

import pytest
from test_cli import fails

import kinetostatics as ks
from kinetostatics.cli.commands import COMMANDS, command
from kinetostatics.cli.main import main

POSE = "--platform z=0.5 rx=0 ry=0".split()
#: Arguments of every command that writes files, and an ending that it accepts.
WRITING = {
    "analyze": (["3rps", "--table", "{table}"], ".csv"),
    "compensate": (["3rps", *POSE], ".csv"),
    "capacity": (["3rps", *POSE], ".svg"),
    "modes": (["3rps", *POSE], ".npz"),
    "response": (["3rps", "--frequencies", "1:9:3"], ".csv"),
    "sweep": (["3rps", "--platform", "z=0.5:0.6:2", "rx=0", "ry=0"], ".nc"),
    "report": (["3rps", *POSE], ".html"),
    "tolerances": (["3rps", "--tolerance", "rod_*.outer_diameter=0.1mm"], ".svg"),
    "sensitivities": (["3rps"], ".svg"),
    "optimize": (["3rps", "--vary", "rod_diameter=40mm:60mm", "--subject-to", "sag < 1mm"], ".urdf"),
    "calibrate": (["3rps", "--plan", "3", "--unknowns", "rod_1", "--platform", "z=0.5:0.6:3", "rx=0", "ry=0"], ".csv"),
    "import-link": (["arm.mat", "--interface", "a=1", "b=2"], ".npz"),
    "condense": (["arm.step", "--interface", "a=face a", "b=face b"], ".npz"),
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


def test_o_is_short_for_out_in_every_command(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.csv").write_text("time,z,rx,ry\n0,0.5,0,0\n1,0.55,0,0\n")
    for name, (arguments, ending) in WRITING.items():
        if name not in ("plot", "export"):
            values = [item.format(table="table.csv") for item in arguments]
            assert "missing" in fails(capsys, name, *values, "-o", f"missing/x{ending}")


@pytest.mark.parametrize(
    ("arguments", "near"),
    [
        (["anlyze", "3rps"], "there is no command 'anlyze'; did you mean 'analyze'?"),
        (["Modes", "3rps"], "there is no command 'Modes'; did you mean 'modes'"),
        (["analyze", "3RPS"], "did you mean '3rps'"),
        (["analyze", "5-bar"], "did you mean 'five_bar'"),
        (["analyze", "gough-stewart"], "did you mean 'gough_stewart'"),
    ],
)
def test_unknown_names_are_answered_by_the_nearest(capsys, arguments, near):
    assert near in fails(capsys, *arguments)


def test_the_response_has_a_range_of_frequencies(capsys):
    """From a tenth of the first natural frequency to twice the third."""
    assert main(["response", "3rps", *POSE, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["frequencies"]
    pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
    first, _, third = ks.modes(pose, 3).frequencies
    assert found[0] == pytest.approx(first / 10) and found[-1] == pytest.approx(2 * third)
