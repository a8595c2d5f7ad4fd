"""``kinetostatics optimize``: verdict, file and exit code."""

import json

import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

pytest.importorskip("scipy")


def test_a_size_a_file_and_exit_codes(capsys, tmp_path):
    robot, sized = str(parametric_machines.cantilever(tmp_path)), tmp_path / "sized.urdf"
    common = ["optimize", robot, "--load", "0", "0", "-500", "0", "0", "0", "--gravity", "0", "0", "0", "--starts", "1"]
    vary = ["--vary", "diameter=20mm:120mm"]
    assert main([*common, *vary, "--subject-to", "sag < 0.1 mm", "--out", str(sized)]) == 0
    out = capsys.readouterr().out
    assert "feasible, mass 50.9" in out and "96.5" in out and f"wrote {sized}" in out
    tip = ks.analyze(ks.load_robot(sized).assemble(), [0, 0, -500, 0, 0, 0], (0, 0, 0)).twist
    assert tip[2] == pytest.approx(-1e-4, rel=1e-6)
    assert main([*common, "--vary", "diameter=20mm,50mm", "--subject-to", "sag < 0.1 mm", "--json"]) == 1
    read = json.loads(capsys.readouterr().out)
    assert read["feasible"] is False and read["parameters"] == {"diameter": 0.05}
    assert main([*common, *vary, "--subject-to", "sagging < 1mm"]) == 2
    assert "no quantity 'sagging'" in capsys.readouterr().err
    assert main([*common[:-1], "0.5", *vary]) == 2
    assert "--starts" in capsys.readouterr().err


@pytest.mark.slow
def test_a_front_and_its_file(capsys, tmp_path):
    robot, table = str(parametric_machines.cantilever(tmp_path)), tmp_path / "front.csv"
    common = [
        "optimize",
        robot,
        "--load",
        "0",
        "0",
        "-500",
        "0",
        "0",
        "0",
        "--vary",
        "diameter=20mm,30mm,50mm",
        "--pareto",
        "sag",
    ]
    common += ["--tool", "200mm", "0", "0"]
    assert main([*common, "--out", str(table)]) == 0
    out = capsys.readouterr().out
    assert (
        "3 designs" in out
        and "all 3 combinations of the listed values" in out
        and len(table.read_text(encoding="utf-8").splitlines()) == 4
    )
    pytest.importorskip("matplotlib")
    assert main([*common, "--out", str(tmp_path / "front.svg"), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["objectives"]) == 3 and (tmp_path / "front.svg").stat().st_size > 5000
