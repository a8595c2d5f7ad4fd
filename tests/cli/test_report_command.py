"""``kinetostatics report``: tables, bars, maps and chapters of the page have the numbers of the results."""

import base64
import re
import shlex

import numpy as np
import pytest
from package_robots import robot
from page_code import run_python, text_of

import kinetostatics as ks
from kinetostatics.cli.main import main

LOAD = [50, 0, -500, 0, 0, 0]
PAGE = text_of("how_to/report")
COMMAND = shlex.split(re.search(r"^kinetostatics (report .*) --out report.html$", PAGE, re.MULTILINE)[1].replace(":13", ":3"))


def rows(html):
    """Return the cells of all rows of tables."""
    found = re.findall(r"<tr>(.*?)</tr>", html)
    return [[re.sub("<.*?>", "", cell) for cell in re.findall(r"<t[dh].*?>(.*?)</t[dh]>", row)] for row in found]


def chapter(html, title):
    return re.search(rf"<h2>{title}</h2>(.*?)</section>", html, re.DOTALL)[1]


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    assert main([*COMMAND, "--title", "Tripod <1>", "--out", str(file)]) == 0
    return file.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def pose():
    return robot("3rps").assemble(platform={"z": 0.5, "rx": np.radians(3), "ry": 0})


def test_report_figures_open_no_windows(monkeypatch, tmp_path):
    from matplotlib import pyplot as plt

    monkeypatch.setattr("kinetostatics.cli.robots._map", lambda *_: None)
    monkeypatch.setattr("kinetostatics.report_page.report_html", lambda *_: plt.get_backend())
    monkeypatch.setattr(plt, "switch_backend", lambda name: monkeypatch.setattr(plt, "get_backend", lambda: name))
    assert main([*COMMAND, "--out", str(tmp_path / "x.html")]) == 0
    assert (tmp_path / "x.html").read_text(encoding="utf-8") == "agg"


def test_report_sweep_fixes_other_coordinates_at_the_zero_pose(monkeypatch, tmp_path):
    found = {}
    monkeypatch.setattr("kinetostatics.report_page.save_report", lambda *_, **given: found.update(given))
    assert main(["report", "five_bar", "--sweep", "x=-5cm:5cm:3", "--out", str(tmp_path / "x.html")]) == 0
    np.testing.assert_allclose(found["workspace"]["x"], [-0.05, 0, 0.05])
    assert float(found["workspace"]["y"]) == float(robot("five_bar").assemble().platform["y"])


@pytest.mark.slow
def test_report_tables_equal_the_results(html, pose):
    result = ks.analyze(pose, LOAD)
    assert "<h1>Tripod &lt;1&gt;</h1>" in html
    short = dict(rows(chapter(html, "In short"))[1:])
    assert short["displacement"].startswith(f"{1e6 * np.linalg.norm(result.twist[:3]):.4f} µm, ")
    drives = {row[0]: row for row in rows(chapter(html, "The pose in numbers")) if row[0].startswith("prismatic")}
    corrected = {row[0]: row for row in rows(chapter(html, "Compensation"))}
    found = ks.compensate(pose, LOAD)
    for name, force in result.actuator_forces.items():
        assert f"{name} {force:.2f} N" in short["actuators"]
        assert f"{force:.2f}" in html and drives[name]
        assert corrected[name][2] == f"{1e3 * found.actuators[name]:.6f} mm"
    assert "3; z, rx, ry place the platform" in chapter(html, "The robot")
    assumed = chapter(html, "What is assumed")
    assert "Elastic beams: rod_1, rod_2 and rod_3." in assumed and "(0, 0, -9.81) m/s²" in assumed


def test_bars_of_contributions_add_up_to_100_percent(html, pose):
    result = ks.analyze(pose, LOAD)
    drawings = re.findall(r"<svg class=\"bars\".*?</svg>", chapter(html, "Where the sag comes from"), re.DOTALL)
    assert len(drawings) == 2
    whole = np.linalg.norm(result.twist[:3])
    for drawing, count in zip(drawings, (len(result.contributions), 3), strict=True):
        signs = [{"more": 1, "less": -1}[kind] for kind in re.findall(r'<rect class="(\w+)"', drawing)]
        widths = np.array([float(width) for width in re.findall(r'width="(.*?)"', drawing)])
        parts = np.array([float(part) for part in re.findall(r"\((\S+) %\)", drawing)])
        assert len(parts) == count and abs(parts.sum() - 100) < 0.06 * count
        np.testing.assert_allclose(signs * widths / widths.max(), parts / abs(parts).max(), atol=3e-3)
    first = result.contributions["load"][:3] @ result.twist[:3] / whole**2
    assert f"({100 * first:.1f} %)" in drawings[0]


def test_workspace_chapter_has_worst_cases_and_maps(html):
    lean = np.radians([-15, 0, 15])
    ds = ks.sweep(robot("3rps"), {"rx": lean, "ry": lean, "z": 0.5}, load=LOAD)
    said = chapter(html, "Over the workspace")
    worst = ks.indices.worst(ds, "linear_sag")
    where = ", ".join(f"{name} = {np.degrees(worst.coordinates[name]):g} deg" for name in ("rx", "ry"))
    assert f"worst sag {1e6 * worst.value:.4g} µm at {where}" in said
    softest = ks.indices.worst(ds, "least_translational_stiffness")
    assert f"least translational stiffness {softest.value / 1e6:.3f} N/µm" in said
    pictures = re.findall(r'alt="(\S+) over rx, ry" src="data:image/svg\+xml;base64,(.*?)"', said)
    assert [name for name, _ in pictures] == [
        *("linear_sag", "angular_sag", "least_translational_stiffness", "largest_actuator_force")
    ]
    assert all(base64.b64decode(data).rstrip().endswith(b"</svg>") for _, data in pictures)


def test_python_of_the_how_to_page_writes_the_same_report(html, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    drawn = {
        "_figures": r'<div class="maps">.*?</div>',
        "scene_html": r'<div class="scene">.*?<img class="still".*?>',
    }
    for name, pattern in drawn.items():  # slow drawings are taken from the first page
        same = re.search(pattern, html, re.DOTALL)[0]
        monkeypatch.setattr(f"kinetostatics.report_page.{name}", lambda *_more, same=same: same)
    run_python("how_to/report", {"-15, 15, 13": "-15, 15, 3", '"Tripod with 500 N"': '"Tripod <1>"'})
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == html


@pytest.mark.slow
def test_report_with_a_tool_refers_to_its_tip(pose, monkeypatch, tmp_path):
    """Displacement, contributions, map and compensation are those of the tip."""
    for name in ("scene_html", "verification_html"):
        monkeypatch.setattr(f"kinetostatics.report_page.{name}", lambda *_: "drawn elsewhere")
    file, load, tool = tmp_path / "tip.html", ["--load", *map(str, LOAD)], ["--tool", "50mm", "0", "200mm"]
    at = ["--platform", "z=500mm", "rx=3deg", "ry=0", "--sweep", "rx=0:3deg:2"]
    assert main(["report", "3rps", *at, *load, *tool, "--controlled", "x", "y", "z", "--out", str(file)]) == 0
    html = file.read_text(encoding="utf-8")
    tip = ks.analyze(pose, LOAD).at_point((0.05, 0, 0.2))
    sag = float(np.linalg.norm(tip.twist[:3]))
    assert dict(rows(chapter(html, "In short"))[1:])["displacement"].startswith(f"{1e6 * sag:.4f} µm, ")
    bars = chapter(html, "Where the sag comes from")
    share = 100 * (tip.contributions["load"][:3] @ tip.twist[:3]) / sag**2
    assert f"({share:.1f} %)" in bars and "Parts of the displacement of the tool&#x27;s tip" in bars
    said = chapter(html, "Over the workspace")
    assert f"worst sag {1e6 * sag:.4g} µm at rx = 3 deg" in said and "those of the tool's tip" in said
    assert "Corrected: x, y and z of the tool" in chapter(html, "Compensation")


def test_report_has_the_finite_element_verdict(html):
    assert "<p>Verified: the largest difference is " in chapter(html, "Checked by finite elements")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--sweep", "prismatic_1=0"], "coordinates of actuators and of the platform cannot vary together"),
        (["--sweep", "z=0:1"], "does not give the number of values"),
        (["--title"], "expected one argument"),
        (["--out", "nowhere/x.html"], "--out: there is no folder"),
    ],
)
def test_invalid_options_of_report_are_one_line_errors(more, message, capsys, tmp_path):
    assert main([*COMMAND, "--out", str(tmp_path / "x.html"), *more]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("kinetostatics: error: ") and message in err and err.count("\n") == 1
