"""``kinetostatics calibrate``: estimates, plans, files and mistakes."""

import json

import numpy as np
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A cantilever of 80 % of its stiffness, bent by three weights at its tip, with a gauge at zero before each."""
    folder = tmp_path_factory.mktemp("files")
    path = parametric_machines.cantilever(folder)
    pose = ks.load_robot(path, {"E": 1.6e11}).assemble()
    loads = np.zeros((3, 6))
    loads[:, 2] = [-100, -200, -300]
    dz = ks.analyze(pose, loads, (0, 0, 0)).twist[:, 2]
    rows = "\n".join(f"{force:.0f},{1e6 * reading:.6f}" for force, reading in zip(loads[:, 2], dz, strict=True))
    (folder / "mine.csv").write_text(f"Fz,tip [um]\n{rows}\n", encoding="utf-8")
    (folder / "gauges.csv").write_text("name,ux,uy,uz,sigma [um]\ntip,0,0,1,1\n", encoding="utf-8")
    return folder, str(path)


def test_estimates_a_file_and_a_figure(place, capsys):
    pytest.importorskip("matplotlib")
    folder, robot = place
    common = ["calibrate", robot, str(folder / "mine.csv"), "--gauges", str(folder / "gauges.csv"), "--reference", "unloaded"]
    out, figure = folder / "mine.urdf", folder / "residuals.svg"
    assert main([*common, "--unknowns", "rod", "--out", str(out), str(figure)]) == 0
    said = capsys.readouterr().out
    assert "× 0.8" in said and "3 readings of 3 rows" in said and f"wrote {out}" in said and figure.stat().st_size > 1000
    tip = ks.analyze(ks.load_robot(out).assemble(), [0, 0, -300, 0, 0, 0], (0, 0, 0)).twist[2]
    own = ks.analyze(ks.load_robot(robot).assemble(), [0, 0, -300, 0, 0, 0], (0, 0, 0)).twist[2]
    assert tip == pytest.approx(own / 0.8, rel=1e-6)
    assert main([*common, "--unknowns", "rod", "payload.mass", "offsets", "--json", "--level", "0.9"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert read["level"] == 0.9 and read["estimates"]["offset.tip"]["value"] == pytest.approx(0, abs=1e-11)
    assert read["unidentifiable"][0]["words"].startswith("no reading depends on payload.mass")
    assert read["estimates"]["payload.mass"]["interval"] == [None, None]


def test_a_plan(place, capsys):
    folder, robot = place
    loads = ["--load-case", "0 0 -100 0 0 0", "0 0 -0.3kN 0 0 0", "0 200 0 0 0 0"]
    common = ["calibrate", robot, "--unknowns", "rod", "--readings", "dz"]
    assert main([*common, "--plan", "1", *loads, "--reference", "unloaded", "--out", str(folder / "plan.csv")]) == 0
    assert "out of 3 poses with loads" in capsys.readouterr().out
    lines = (folder / "plan.csv").read_text(encoding="utf-8").splitlines()
    assert lines == ["Fx,Fy,Fz,Mx,My,Mz,dz", "0,0,-300,0,0,0,"]  # the largest load along what is read
    for more, words in (
        (["--plan", "1.5"], "--plan is 1.5; it must be a whole number from 1 on"),
        (["--plan", "1", "--out", "a.svg"], "--out: a.svg does not end in .csv"),
        (["--plan", "1", "--load-case", "0 0 1"], "has 3 numbers"),
        (["--plan", "1", "--load", *"001000"], "--load: measurements have their loads in the table"),
        (["--plan", "1", "--reference", "x=1"], "reference has the coordinates x"),
        ([], "give either MEASUREMENTS"),
    ):
        assert main([*common, *more]) == 2
        assert words in capsys.readouterr().err
