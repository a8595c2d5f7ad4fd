"""``kinetostatics tolerances``, ``sensitivities``, ``optimize``, ``calibrate``: tables, JSON, files, exit codes, errors."""

import json

import numpy as np
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

LOAD = "--load 0 0 -500 0 0 0".split()


@pytest.fixture
def robot(tmp_path):
    return str(parametric_machines.cantilever(tmp_path))


@pytest.fixture
def run(capsys):
    """Return a function that runs a command; it returns standard output, read if it is JSON, or the error."""

    def answer(*arguments, code=0):
        assert main([*map(str, arguments)]) == code
        out, err = capsys.readouterr()
        return err if code == 2 else json.loads(out) if "--json" in arguments else out

    return answer


def test_tolerances_prints_samples_and_writes_a_chart(run, robot, tmp_path):
    picture = tmp_path / "tolerances.svg"
    common = ["tolerances", robot, *LOAD, "--tolerance", "E=3%", "--samples"]
    out = run(*common, 500, "--out", picture, "--what", "z")
    assert "500 random samples" in out and "100.0" in out and f"wrote {picture}" in out
    assert picture.stat().st_size > 5000
    read = run(*common, 20, "--json", "--seed", "4", "--distribution", "uniform")
    assert read["samples"] == 20 and read["seed"] == 4 and read["distribution"] == "uniform"
    # the whole twist is proportional to 1/E
    assert read["worst_case"]["displacement"] == pytest.approx(0.03 * read["nominal"]["displacement"], rel=1e-6)
    assert "--samples is 1.5; it must be a whole number from 2 on" in run(*common, 1.5, code=2)


def test_sensitivities_prints_effects_and_writes_a_chart(run, robot, tmp_path):
    chart = tmp_path / "stiffen.svg"
    common = ["sensitivities", robot, *LOAD, "--by", "E"]
    out = run(*common, "diameter", "--out", chart)
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line.startswith("  ")}
    assert "-1.000" in rows["E"] and rows["rod"][-1] == "-1.000" and f"wrote {chart}" in out
    assert chart.stat().st_size > 5000
    read = run(*common, "--json")
    assert list(read["parameters"]) == ["E"] and list(read["sources"]) == ["rod"]


# ---- optimize --------------------------------------------------------------------------------------------------------


def test_optimize_writes_the_sized_robot_and_sets_exit_codes(run, robot, tmp_path):
    sized = tmp_path / "sized.urdf"
    common = ["optimize", robot, *LOAD, "--gravity", 0, 0, 0, "--vary"]
    out = run(*common, "diameter=20mm:120mm", "--starts", 1, "--subject-to", "sag < 0.1 mm", "--out", sized)
    assert "feasible, mass 50.9" in out and "96.5" in out and f"wrote {sized}" in out
    tip = ks.analyze(ks.load_robot(sized).assemble(), [0, 0, -500, 0, 0, 0], (0, 0, 0)).twist
    assert tip[2] == pytest.approx(-1e-4, rel=1e-6)
    read = run(*common, "diameter=20mm,50mm", "--subject-to", "sag < 0.1 mm", "--json", code=1)
    assert read["feasible"] is False and read["parameters"] == {"diameter": 0.05}
    assert "no quantity 'sagging'" in run(*common, "diameter=20mm:120mm", "--subject-to", "sagging < 1mm", code=2)
    assert "--starts" in run(*common, "diameter=20mm:120mm", "--starts", 0.5, code=2)


def test_optimize_pareto_writes_table_and_figure(run, robot, tmp_path):
    table, figure = tmp_path / "front.csv", tmp_path / "front.svg"
    common = ["optimize", robot, *LOAD, "--vary", "diameter=20mm,30mm,50mm", "--pareto", "sag", "--tool", "200mm", 0, 0]
    out = run(*common, "--out", table)
    assert "3 designs" in out and "all 3 combinations of the listed values" in out
    assert len(table.read_text(encoding="utf-8").splitlines()) == 4
    read = run(*common, "--out", figure, "--json")
    assert len(read["objectives"]) == 3 and figure.stat().st_size > 5000


# ---- calibrate -------------------------------------------------------------------------------------------------------


def test_calibrate_estimates_stiffness_and_writes_robot_and_figure(run, robot, tmp_path):
    """A cantilever of 80 % of its stiffness, bent by three weights at its tip, with a gauge at zero before each."""
    pose = ks.load_robot(robot, {"E": 1.6e11}).assemble()
    loads = np.zeros((3, 6))
    loads[:, 2] = [-100, -200, -300]
    dz = ks.analyze(pose, loads, (0, 0, 0)).twist[:, 2]
    rows = "\n".join(f"{force:.0f},{1e6 * reading:.6f}" for force, reading in zip(loads[:, 2], dz, strict=True))
    measured, gauges, out, figure = (tmp_path / name for name in ("mine.csv", "gauges.csv", "mine.urdf", "residuals.svg"))
    measured.write_text(f"Fz,tip [um]\n{rows}\n", encoding="utf-8")
    gauges.write_text("name,ux,uy,uz,sigma [um]\ntip,0,0,1,1\n", encoding="utf-8")
    common = ["calibrate", robot, measured, "--gauges", gauges, "--reference", "unloaded", "--unknowns", "rod"]
    said = run(*common, "--out", out, figure)
    assert "× 0.8" in said and "3 readings of 3 rows" in said and f"wrote {out}" in said and figure.stat().st_size > 1000
    tip, own = (ks.analyze(ks.load_robot(file).assemble(), loads[2], (0, 0, 0)).twist[2] for file in (out, robot))
    assert tip == pytest.approx(own / 0.8, rel=1e-6)
    read = run(*common, "payload.mass", "offsets", "--json", "--level", "0.9")
    assert read["level"] == 0.9 and read["estimates"]["offset.tip"]["value"] == pytest.approx(0, abs=1e-11)
    assert read["unidentifiable"][0]["words"].startswith("no reading depends on payload.mass")
    assert read["estimates"]["payload.mass"]["interval"] == [None, None]


def test_calibrate_plan_chooses_the_largest_load(run, robot, tmp_path):
    loads = ["--load-case", "0 0 -100 0 0 0", "0 0 -0.3kN 0 0 0", "0 200 0 0 0 0"]
    common = ["calibrate", robot, "--unknowns", "rod", "--readings", "dz"]
    out = run(*common, "--plan", 1, *loads, "--reference", "unloaded", "--out", tmp_path / "plan.csv")
    assert "out of 3 poses with loads" in out
    lines = (tmp_path / "plan.csv").read_text(encoding="utf-8").splitlines()
    assert lines == ["Fx,Fy,Fz,Mx,My,Mz,dz", "0,0,-300,0,0,0,"]  # the largest load along what is read
    for more, words in (
        (["--plan", "1.5"], "--plan is 1.5; it must be a whole number from 1 on"),
        (["--plan", "1", "--out", "a.svg"], "--out: a.svg does not end in .csv"),
        (["--plan", "1", "--load-case", "0 0 1"], "has 3 numbers"),
        (["--plan", "1", "--load", *"001000"], "--load: measurements have their loads in the table"),
        (["--plan", "1", "--reference", "x=1"], "reference has the coordinates x"),
        ([], "give either MEASUREMENTS"),
    ):
        assert words in run(*common, *more, code=2)
