"""``kinetostatics compensate`` and ``analyze --tool``: output and files equal the results of Python; errors are one line."""

import csv
import json

import numpy as np
import package_robots
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

LOAD = "--load 0 0 -500 0 0 0".split()


def run(capsys, *arguments):
    code = main(list(map(str, arguments)))
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_tool_tip_sag_of_a_cantilever_equals_the_closed_form(capsys, tmp_path):
    """w = F L³/3EI + a F L²/2EI at the tip of a tool, a beyond the end."""
    common = ["analyze", parametric_machines.cantilever(tmp_path), *LOAD, "--gravity", 0, 0, 0, "--tool"]
    sag = 64 * 500 * (0.8**3 / 3 + 0.2 * 0.8**2 / 2) / (np.pi * 2e11 * 0.04**4)
    assert f"the tool's tip moves by {1e3 * sag:.3f} mm" in run(capsys, *common, "200mm", 0, 0)[1]
    _, out, _ = run(capsys, *common, "200mm", 0, 0, "--json")
    assert json.loads(out)["tool"]["twist"][2] == pytest.approx(-sag, rel=1e-9)
    code, _, err = run(capsys, *common, "1kg", 0, 0)
    assert code == 2 and "--tool" in err


# ---- compensate ------------------------------------------------------------------------------------------------------


def test_compensate_of_one_pose_equals_python(capsys):
    robot = package_robots.robot("3rps")
    found = ks.compensate(robot.assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0}), [0, 0, -500, 0, 0, 0])
    arguments = ("compensate", "3rps", "--platform", "z=500mm", "rx=0.05", "ry=0", *LOAD)
    code, out, _ = run(capsys, *arguments)
    assert code == 0 and out.strip() == str(found)
    code, out, _ = run(capsys, *arguments, "--json", "--controlled", "z", "rx", "ry")
    read = json.loads(out)
    assert code == 0 and read["actuators"]["prismatic_1"] == pytest.approx(float(found.actuators["prismatic_1"]), abs=1e-15)
    assert read["controlled"] == ["z", "rx", "ry"] and read["status"] == "OK" and read["warnings"] == []


def test_compensate_of_a_table_equals_that_of_a_grid(capsys, tmp_path):
    out_file = tmp_path / "corrected.csv"
    code, out, _ = run(
        capsys, "compensate", "3rps", "--platform", "z=450mm:500mm:2", "rx=0,0.1", "ry=0", *LOAD, "--out", out_file
    )
    assert code == 0 and "4 poses" in out and f"wrote {out_file}" in out
    rows = list(csv.DictReader(out_file.read_text(encoding="utf-8").splitlines()))
    wanted = [(float(row["z [m]"]), round(float(row["rx [rad]"]), 12)) for row in rows]
    assert wanted == [(0.45, 0), (0.45, 0.1), (0.5, 0), (0.5, 0.1)]
    path = tmp_path / "path.csv"
    path.write_text("z [mm],rx [deg],ry\n450,0,0\n500, 0.1rad ,0\n", encoding="utf-8")
    again = tmp_path / "again.csv"
    code, _, _ = run(capsys, "compensate", "3rps", "--table", path, *LOAD, "--out", again)
    of_table = list(csv.DictReader(again.read_text(encoding="utf-8").splitlines()))
    for k, row in zip((0, 3), of_table, strict=True):
        assert code == 0 and float(row["prismatic_2 [m]"]) == pytest.approx(float(rows[k]["prismatic_2 [m]"]), abs=1e-14)
    drives = tmp_path / "drives.csv"
    drives.write_text("prismatic_1 [mm],prismatic_2,prismatic_3\n-10,0,10mm\n", encoding="utf-8")
    code, out, _ = run(capsys, "compensate", "3rps", "--table", drives, "--json")
    assert code == 0 and json.loads(out)["shape"] == [1] and json.loads(out)["controlled"] == ["z", "rx", "ry"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("z,rx,ry\n", "a line of names"),
        ("z,z,ry\n1,2,3\n", "'z' is given twice"),
        ("z,rx,ry\n0.5,0\n", ":2: 2 cells below 3 titles"),
        ("z,rx,ry\n0.5,0,1mm\n", ":2: ry: '1mm' is a length, but an angle is needed"),
        ("z [,rx,ry\n0.5,0,1\n", "is not a name"),
        ("z [mm],rx [deg],ry\n500,,1\n", ":2: rx is missing"),
        ("z;rx;ry\n0,5;0;1\n", ":1: separate columns by commas"),
    ],
)
def test_invalid_pose_tables_are_one_line_errors(capsys, tmp_path, text, said):
    path = tmp_path / "poses.csv"
    path.write_text(text, encoding="utf-8")
    code, out, err = run(capsys, "compensate", "3rps", "--table", path)
    assert code == 2 and out == "" and said in err and str(path) in err and err.count("\n") == 1


def test_table_with_coordinates_and_too_many_poses_are_errors(capsys, tmp_path):
    code, _, err = run(capsys, "compensate", "3rps", "--table", tmp_path / "none.csv", "--platform", "z=1")
    assert code == 2 and "either --table or coordinates" in err
    code, _, err = run(capsys, "compensate", "3rps", "--platform", "z=0:1:2000", "rx=0:1:2000", "ry=0")
    assert code == 2 and "more than 1,000,000 poses" in err
