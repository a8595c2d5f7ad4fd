"""``kinetostatics tolerances``: the tables, JSON and the histogram."""

import json

import parametric_machines
import pytest

from kinetostatics.cli.main import main


def test_tables_json_and_histogram(capsys, tmp_path):
    pytest.importorskip("matplotlib")
    robot = str(parametric_machines.cantilever(tmp_path))
    arguments = ["tolerances", robot, "--load", "0", "0", "-500", "0", "0", "0", "--tolerance", "E=3%", "--samples", "500"]
    picture = tmp_path / "tolerances.svg"
    assert main([*arguments, "--out", str(picture), "--what", "z"]) == 0
    out = capsys.readouterr().out
    assert "500 random samples" in out and "100.0" in out and f"wrote {picture}" in out
    assert picture.stat().st_size > 5000
    assert main([*arguments, "--samples", "20", "--json", "--seed", "4", "--distribution", "uniform"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert read["samples"] == 20 and read["seed"] == 4 and read["distribution"] == "uniform"
    # the whole twist is by E⁻¹
    assert read["worst_case"]["displacement"] == pytest.approx(0.03 * read["nominal"]["displacement"], rel=1e-6)
    assert main([*arguments, "--samples", "1.5"]) == 2
    assert "--samples is 1.5; it must be a whole number from 2 on" in capsys.readouterr().err
