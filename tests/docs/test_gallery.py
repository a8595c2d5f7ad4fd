"""The gallery: a page for every shipped robot, with computed facts, sketches and pictures of modes that are up to date."""

import posixpath
import re
import runpy
from collections import Counter
from types import SimpleNamespace

import animated_modes
import gallery_pages as gallery
import kinematic_sketches
import numpy as np
import package_robots
import pytest
from PIL import Image

from kinetostatics.files.bundled import shipped_robots

ROBOTS = sorted(shipped_robots())


def words(text):
    """Return the words of a text, numbers as floats."""
    found = [re.fullmatch(r"-?\d+(\.\d+)?", word) for word in text.split()]
    return [float(number[0]) if number else word for number, word in zip(found, text.split(), strict=True)]


def test_every_shipped_robot_has_a_page_and_a_kind():
    assert sorted(gallery.KINDS) == ROBOTS == sorted(page.stem for page in gallery.PAGES.glob("*.md"))


def test_pages_of_all_robots_and_the_first_page_show_a_robot_that_computes():
    """The site puts the page of the robot over its picture; its address is relative to the page that shows it."""
    pytest.importorskip("mkdocs", reason="the site, which is built with the linters, needs the extra docs")
    hook = runpy.run_path(str(gallery.ROOT / "docs" / "hooks" / "robots.py"))
    for name in ROBOTS:
        file = SimpleNamespace(url=f"gallery/pages/{name}.html")
        files = SimpleNamespace(get_file_from_path=lambda path, file=file: file if path == file.url else None)
        places = {
            gallery.page_of(name): f"gallery/robots/{name}/",
            **({gallery.ROOT / "docs/index.md": ""} if name == "3rps" else {}),
        }
        for page, url in places.items():
            shown = hook["on_page_markdown"](page.read_text(encoding="utf-8"), SimpleNamespace(url=url), None, files)
            (address,) = re.findall(r'<iframe src="(.*?)"', shown)
            assert posixpath.normpath(posixpath.join(url, address)) == file.url
            assert re.search(rf'<div class="robot" markdown="1">\n\n!\[.*?\]\(.*{name}\.(png|webp)\)', shown)
    assert "robot_page" in hook["page_of"]("3rps")


@pytest.mark.few(1)
@pytest.mark.parametrize("page", [*map(gallery.page_of, gallery.KINDS), gallery.INDEX], ids=lambda page: page.stem)
def test_gallery_pages_are_up_to_date(page):
    shown, fresh = words(page.read_text(encoding="utf-8")), words(gallery.fresh(page))
    stale = "stale: run python tests/support/gallery_pages.py"
    assert len(shown) == len(fresh), stale
    for a, b in zip(shown, fresh, strict=True):
        assert a == (pytest.approx(b, rel=2e-3) if isinstance(b, float) else b), stale


def test_facts_equal_known_values_of_the_robots():
    """The paper's robots, the Delta's spinning rods, the isotropic Orthoglide, the tripod's sag of Table 1."""
    assert gallery.facts("3rps")["limbs"] == "`3-R[P]S`"
    assert gallery.facts("2pru_upr")["limbs"] == "`2-[P]RU + U[P]R`"
    assert gallery.facts("delta")["limbs"] == "`3-[R](SS‖SS)`"
    assert [gallery.facts("delta")[key] for key in ("mobility", "local freedoms")] == ["3", "6"]
    softest, stiffest = re.findall(r"[\d.]+", gallery.facts("orthoglide")["stiffness"])
    assert softest == stiffest
    # at 9.81 m/s², not 9.8 as in Table 1
    sag = float(re.search(r"o moves by ([\d.]+) nm", gallery.facts("3rps")["sag"])[1])
    assert sag == pytest.approx(83.19 * 9.81 / 9.8, rel=2e-4)


@pytest.mark.parametrize(
    ("name", "joints"),
    [
        ("3rps", {(1, 0, False): 3, (0, 1, True): 3, (3, 0, False): 3}),
        ("gough_stewart", {(2, 0, False): 6, (0, 1, True): 6, (3, 0, False): 6}),
        ("delta", {(1, 0, True): 3, (3, 0, False): 12}),
    ],
)
def test_sketches_have_the_joints_of_the_robot(name, joints):
    """Joints that meet in a point are one symbol: its numbers of rotations and translations, and whether it is actuated."""
    robot = package_robots.robot(name)
    pose = robot.assemble()
    symbols = kinematic_sketches.symbols_of(robot, pose)
    assert Counter((symbol.turns, symbol.slides, symbol.actuated) for symbol in symbols) == joints
    if name == "3rps":  # legs at azimuths 120° apart, hinges on a circle of 300 mm
        feet = np.array([symbol.point for symbol in symbols if symbol.turns == 1])
        assert np.linalg.norm(feet[:, :2], axis=1) == pytest.approx(0.3, rel=1e-12)
    assert kinematic_sketches.seen(np.array([0.0, 0.0, 1.0]))[0] == 0  # upright stays upright


@pytest.mark.slow
def test_gallery_of_modes_is_up_to_date():
    assert animated_modes.PAGE.read_text(encoding="utf-8") == animated_modes.page_text(), "run python examples/animated_modes.py"


def test_pictures_of_modes_are_small_and_animated():
    for name in animated_modes.MODES:
        file = animated_modes.PICTURES / f"{name}.webp"
        assert Image.open(file).n_frames == animated_modes.FRAMES and file.stat().st_size <= 60_000
