"""Images of the page: their content, and the files that are written."""

import base64
import io

import numpy as np
import package_robots
import pytest
from browser_pages import settle
from PIL import Image as image

import kinetostatics as ks
from kinetostatics.cli import main as cli


def pixels(data):
    return np.asarray(image.open(io.BytesIO(data)).convert("RGB")).astype(int)


@pytest.mark.slow
def test_page_image_has_header_robot_labels_and_legend(page):
    settle(page)
    found = pixels(base64.b64decode(page.evaluate("robot_page.picture()").partition(",")[2]))
    width, height = page.evaluate("(e => [e.offsetWidth, e.offsetHeight])(document.getElementById('robot-stage'))")
    assert found.shape[1] == 2 * width and found.shape[0] > 2 * height + 100
    top = found.shape[0] - 2 * (height + 46)
    head, robot, legend = found[:top], found[top : top + 2 * height], found[top + 2 * height :]
    assert (head.min(axis=2) < 120).sum() > 500  # pose, gravity, load
    assert ((robot.max(axis=2) - robot.min(axis=2)) > 40).mean() > 0.02
    ends = [[0x44, 0x01, 0x54], [0xFD, 0xE7, 0x25]]
    columns = [np.flatnonzero((np.abs(legend - colour).max(axis=2) <= 6).any(axis=0)) for colour in ends]
    assert columns[0].min() < columns[1].max() - 500  # the bar, violet to yellow
    for text, left, top_of, right, bottom in page.evaluate(
        """[...document.querySelectorAll('.robot-label')].filter(e => e.style.visibility === 'visible').map(e => {
          const r = e.getBoundingClientRect(), f = document.getElementById('robot-stage').getBoundingClientRect();
          return [e.textContent, r.left - f.left, r.top - f.top, r.right - f.left, r.bottom - f.top]; })"""
    ):
        patch = robot[round(2 * top_of) : round(2 * bottom), round(2 * left) : round(2 * right)]
        assert np.ptp(patch) > 80, text  # text on a light background
    settle(page)
    with page.expect_download() as download:
        page.click("#robot-tools button:text-is('image')")
    assert download.value.suggested_filename == "2pru_upr.png"


@pytest.mark.slow
def test_view_command_writes_an_image(browser, tmp_path, capsys, monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)
    file = tmp_path / "stress.png"
    assert cli.main(["view", "2pru_upr", "--screenshot", str(file), "--colour", "axial", "--from", "top"]) == 0
    assert f"wrote {file}" in capsys.readouterr().out
    found = pixels(file.read_bytes())
    assert found.shape == (800, 1200, 3)
    blue = (found[..., 2] > found[..., 0] + 60) & (found[..., 2] > 120)
    red = (found[..., 0] > found[..., 2] + 60) & (found[..., 0] > 120)
    assert blue[60:720].mean() > 0.003  # rods in compression
    assert red[740:].mean() > 0.001  # the legend's other end
    assert (found[60:720].min(axis=2) < 245).mean() > 0.05


@pytest.mark.slow
def test_handles_are_no_part_of_images(visit, tmp_path):
    ks.save_html(ks.analyze(package_robots.robot("3rps").assemble()), tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri())
    seen = "() => robot_page.handles.map(({ object }) => object.visible)"
    assert page.evaluate(seen) == [True] * 3
    first = page.evaluate("robot_page.picture(1)")
    assert page.evaluate(seen) == [True] * 3
    page.evaluate("for (const { object } of robot_page.handles) object.scale.setScalar(1e-6)")
    assert page.evaluate("robot_page.picture(1)") == first
    assert visit(f"{(tmp_path / 'page.html').as_uri()}#picture").evaluate(seen) == [False] * 3
