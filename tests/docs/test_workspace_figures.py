"""``docs/how_to/workspace_figures.md`` and ``examples/paper_workspace.py``: what they say is what the code does."""

import json
import re
import shlex
import sys

import numpy as np
import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import main

matplotlib = pytest.importorskip("matplotlib", reason="needs Matplotlib: pip install 'kinetostatics[plot]'")
matplotlib.use("Agg")

pytestmark = pytest.mark.usefixtures("no_figures_left")

PAGE = (ROOT / "docs" / "how_to" / "workspace_figures.md").read_text(encoding="utf-8")
sys.path.insert(0, str(ROOT / "examples"))
paper_workspace = pytest.importorskip("paper_workspace")


def between(name):
    found = re.search(rf"<!-- {name}: begin -->\n(.*?)<!-- {name}: end -->", PAGE, re.DOTALL)
    assert found, name
    return found.group(1).strip()


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """Run the page's example and return its names and the folder it wrote to."""
    folder = tmp_path_factory.mktemp("example")
    code = re.search(r"```python\n(.*?)```", between("example"), re.DOTALL).group(1)
    code = code.replace("40, 33)", "40, 9)")  # fewer poses
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
    pytest.importorskip("h5netcdf")
    monkeypatch.chdir(tmp_path)
    example[0]["ds"].to_netcdf("map.nc", engine="h5netcdf")
    commands = [line.partition("#")[0] for line in PAGE.splitlines() if line.startswith("kinetostatics plot")]
    assert len(commands) == 5
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0, capsys.readouterr().err
    assert {path.suffix for path in tmp_path.iterdir()} == {".nc", ".svg", ".pdf", ".png"}


def test_the_table_of_indices_is_what_the_code_has():
    assert between("indices") == paper_workspace.index_table(), "stale: run python examples/paper_workspace.py --write-docs"


def test_what_is_far_beyond_all_others_is_what_the_page_says():
    from kinetostatics.plot.selection import FAR, PART, ROUNDING

    assert (PART, FAR) == (0.02, 3.0) and f"less than {ROUNDING:.0e} of the motion" in PAGE
    assert "the outermost 2 % of the values reach more than three times as far as all the rest" in PAGE.replace("\n", " ")


# ---- maxima ------------------------------------------------------------------------------------------------------------


def printed_rows():
    """Return the numbers of the table's rows, in its order; the paper's have no part of the poses."""
    rows = [[cell.strip().strip("*") for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in between("maxima").splitlines()]
    return {row[0].strip("*"): [float(cell.rstrip(" %") or "nan") for cell in row[1:]] for row in rows[2:]}


def test_the_papers_maxima_are_in_the_table():
    papers = [row for name, row in printed_rows().items() if "the paper" in name]
    assert [row[:3] for row in papers] == [[26, 0.0075, 496], [16, 0.002, 600]]


@pytest.mark.parametrize("workspace", paper_workspace.WORKSPACES, ids=lambda item: f"{item.robot}-{item.what[:24]}")
def test_maxima_of_a_coarse_grid_come_near_the_pages(workspace):
    """The coarse grid is part of the fine one: it cannot find more, and finds most of it."""
    printed = np.array(printed_rows()[workspace.what])
    found = np.array(paper_workspace.maxima(workspace, coarse=True))
    half_a_digit = np.array([5e-3, 5e-6, 5e-2])
    assert np.all(found[:3] <= printed[:3] + 1.01 * half_a_digit)
    if workspace.robot == "2pru_upr":  # the worst poses are on both grids
        assert np.all(np.abs(found[:3] - printed[:3]) <= 1.01 * half_a_digit)
    else:
        # what limits cut off differs more from grid to grid than what they do not
        assert np.all(found[:3] >= (0.75 if "less what" in workspace.what else 0.9) * printed[:3])
    if "all within limits" in workspace.what or workspace.beyond_limits:
        assert found[3] == 1 and printed[3] == 100


def test_the_paper_is_as_far_off_as_the_page_says():
    # the worst poses are on the coarse grid too
    ours, without = (paper_workspace.maxima(item, coarse=True) for item in paper_workspace.WORKSPACES[:2])
    for said, number, paper in (("+5.6 %", ours[0], 26), ("−1.8 %", ours[1], 0.0075), ("+1.4 %", ours[2], 496)):
        assert said in PAGE and f"{100 * (number / paper - 1):+.1f} %".replace("-", "−") == said
    assert without[2] == pytest.approx(496.7, abs=0.05)
    np.testing.assert_allclose(without[:2], ours[:2], rtol=1e-9)
    ds = paper_workspace.sweep("2pru_upr", np.array([0.3]), np.array([0.0, 10.0]))
    here = ds.isel(z=0, rx=0, ry=1)
    assert float(ks.indices.linear_sag(here)) == pytest.approx(27.2e-6, abs=0.05e-6)
    assert np.degrees(float(ks.indices.angular_sag(here))) == pytest.approx(ours[1], abs=5e-6)


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


@pytest.fixture(scope="module")
def figures():
    return dict(paper_workspace.figures(coarse=True))


@pytest.mark.slow
def test_figures_show_the_maps(figures):
    panels = ["slice_3rps", "round_3rps", "lines_3rps", "ways_3rps", "workspace_3rps"]
    assert list(figures) == ["figure_6", "figure_7", "figure_12", "figure_13", *panels]
    assert [getattr(figures[name], "name", "") for name in panels] == ["rectilinear", "polar", "rectilinear", "rectilinear", "3d"]
    for name, panels in (("figure_6", 6), ("figure_7", 3), ("figure_12", 6), ("figure_13", 3)):
        axes = figures[name].axes
        assert len(axes) == panels and len({ax.get_title() for ax in axes}) == panels
        for ax in axes:
            assert re.search(r"\[(µm|10⁻³ °|N)\]", ax.get_title()), ax.get_title()
            angles = ("rx [°]", "ry [°]") if name in ("figure_6", "figure_7") else (r"$\theta_X$ [°]", r"$\theta_y$ [°]")
            assert (ax.get_xlabel(), ax.get_ylabel()) == angles
            assert ax.get_title().startswith(r"$\Delta_" if panels == 6 else "$f_"), "the paper's symbols"
        assert len(figures[name].legends) == 1
    # what docs/explanation/method.md says below the picture of the ways: configuration 2 of the 3RPS is at a tilt of 10°
    lines = [line.get_ydata()[line.get_xdata().round(6) == 10].item() for line in figures["ways_3rps"].get_lines()]
    said = re.search(r"Δ_z is (.*) nm", (ROOT / "docs" / "explanation" / "method.md").read_text(encoding="utf-8"))[1]
    platform, attached, deformation, twist = (f"{-number:.1f}" for number in lines)
    assert said == f"−{platform} − {attached} − {deformation} = −{twist}"
    # the largest corner of Fig 12 (a) is the largest displacement along x of the table
    heights = np.asarray(figures["figure_12"].axes[0].collections[0]._faces)[..., 2]
    assert heights.max() == pytest.approx(27.465, abs=1e-3)


@pytest.mark.further
def test_the_readmes_picture_of_a_map_is_what_its_command_draws(figures):
    """The same quantity, axes and height as in the command, drawn by the example that draws the picture."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8").split("<!-- maps: begin -->")[1]
    command = next(line for line in readme.splitlines() if " plot " in line)
    figure = figures["round_3rps"]
    assert "--x azimuth --y tilt --at z=0.65 --out" in command and figure.get_title() == "z = 0.65 m"
    assert (figure.name, figure.figure.axes[1].get_ylabel()) == ("polar", "linear sag [µm]")
    assert (figure.get_thetamin(), figure.get_thetamax()) == (0, 360) and 50 <= figure.get_rmax() <= 52.5
    assert "docs/pictures/round_3rps.png" in readme.split("\n## ")[0]


@pytest.mark.parametrize("number", [6, 7, 13])
def test_captions_say_what_the_figures_show(number):
    assert between(f"figure {number}").strip() == paper_workspace.caption(number), "stale: paper_workspace.py --write-docs"
