"""``docs/how_to/workspace_figures.md`` and ``examples/paper_workspace.py``: code runs, tables are up to date."""

import json
import re

import matplotlib
import numpy as np
import paper_workspace
import pytest
from page_code import between, blocks, commands, text_of
from places import ROOT

from kinetostatics.cli.main import main

matplotlib.use("Agg")

pytestmark = pytest.mark.usefixtures("no_figures_left")

PAGE = text_of("how_to/workspace_figures")


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """Run the page's example and return its names and the folder it wrote to."""
    folder = tmp_path_factory.mktemp("example")
    code = blocks(between(PAGE, "example"))[0].text.replace("40, 33)", "40, 5)").replace("0.8, 5)", "0.8, 3)")  # fewer poses
    names = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(compile(code, "workspace_figures.md", "exec"), names)  # the page's own text
    return names, folder


def test_the_pages_example_runs(example):
    names, folder = example
    assert {path.name for path in folder.iterdir()} == {"sag.svg", "surfaces.pdf", "workspace.png", "forces.pdf"}
    assert names["stiffness"].attrs["units"] == "N/m"
    assert np.nanmin(names["stiffness"]) > 0


@pytest.mark.slow
def test_the_pages_commands_run(example, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    example[0]["ds"].to_netcdf("map.nc", engine="h5netcdf")
    drawn = [command for command in commands("how_to/workspace_figures") if command[0] == "plot"]
    assert len(drawn) == 5
    for command in drawn:
        assert main(command) == 0, capsys.readouterr().err
    assert {path.suffix for path in tmp_path.iterdir()} == {".nc", ".svg", ".pdf", ".png"}


def test_table_of_indices_equals_that_of_the_code():
    assert between(PAGE, "indices").strip() == paper_workspace.index_table(), (
        "stale: run python examples/paper_workspace.py --write-docs"
    )


# ---- maxima ------------------------------------------------------------------------------------------------------------


def printed_rows():
    """Return the numbers of the table's rows, in its order; those of the paper have no share of poses."""
    rows = [
        [cell.strip().strip("*") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in between(PAGE, "maxima").strip().splitlines()
    ]
    return {row[0].strip("*"): [float(cell.rstrip(" %") or "nan") for cell in row[1:]] for row in rows[2:]}


def test_the_papers_maxima_are_in_the_table():
    papers = [row for name, row in printed_rows().items() if "the paper" in name]
    assert [row[:3] for row in papers] == [[26, 0.0075, 496], [16, 0.002, 600]]


@pytest.mark.parametrize("workspace", paper_workspace.WORKSPACES, ids=lambda item: f"{item.robot}-{item.what[:24]}")
def test_maxima_of_a_coarse_grid_approach_those_of_the_page(workspace):
    """The coarse grid is part of the fine one: it cannot find more, and finds most of it."""
    printed = np.array(printed_rows()[workspace.what])
    found = np.array(paper_workspace.maxima(workspace, coarse=True))
    half_a_digit = np.array([5e-3, 5e-6, 5e-2])
    assert np.all(found[:3] <= printed[:3] + 1.01 * half_a_digit)
    if workspace.robot == "2pru_upr":  # the worst poses are on both grids
        assert np.all(np.abs(found[:3] - printed[:3]) <= 1.01 * half_a_digit)
    else:
        # workspaces that limits cut off differ more from grid to grid
        assert np.all(found[:3] >= (0.75 if "only poses" in workspace.what else 0.9) * printed[:3])
    if "all within limits" in workspace.what or workspace.beyond_limits:
        assert found[3] == 1 and printed[3] == 100


@pytest.mark.parametrize("number", [1, 2])
def test_rod_forces_are_those_of_the_papers_table_4(number):
    tables = json.loads((ROOT / "examples" / "paper_tables.json").read_text(encoding="utf-8"))
    case = tables["2pru_upr"][f"configuration_{number}"]
    ds = paper_workspace.sweep("2pru_upr", np.array([0.6]), np.array([-6.0, -5.0, 0.0]))
    at = {"z": 0, "rx": 2, "ry": 2} if number == 1 else {"z": 0, "rx": 1, "ry": 0}  # θ_X = −5°, θ_y = −6°
    np.testing.assert_allclose(ds["rod_base_force"].isel(at), case["recovered"]["fa"], rtol=2e-6)
    # without J_3g2 W_3g2 the printed digits of the analytical column
    _, forces = paper_workspace.left_out(ds)
    np.testing.assert_allclose(forces.isel(at), [float(text) for text in case["analytical"]["fa"]], rtol=5e-5)
