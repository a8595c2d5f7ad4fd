"""Draws the pictures of the README and of docs/ from exported pages: ``python examples/make_pictures.py [FOLDER]``.

Needs Chromium and ``pip install 'kinetostatics[test]'``. The pages are those of ``kinetostatics view --html``; the script only
chooses what is switched on and where the camera stands.
"""

import shutil
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import kinetostatics as ks

ROOT = Path(__file__).parent.parent
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


@dataclass
class Picture:
    """One picture: which robot where, and what of the page is seen."""

    robot: str
    platform: dict[str, float]
    title: str
    orientation: str | None = None
    load: tuple[float, ...] = (0, 0, 0, 0, 0, 0)
    gravity: tuple[float, ...] = (0, 0, -9.8)
    view: tuple[float, float, float] = (1.5, -2.6, 1.1)
    groups: dict[str, bool] = field(default_factory=dict)
    sliders: bool = False
    size: tuple[int, int] = (1200, 760)


PICTURES = {
    # the paper's configuration 2 of both robots
    "3rps": Picture(
        "3rps",
        {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)},
        "3RPS under its own weight",
        orientation="tilt_torsion",
    ),
    "2pru_upr": Picture(
        "2pru_upr",
        {"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)},
        "2PRU-UPR under its own weight",
        orientation="XYZ",
        view=(2.2, -1.5, 1.1),
    ),
    "wrenches": Picture(
        "2pru_upr",
        {"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)},
        "2PRU-UPR, constraint forces under a load",
        orientation="XYZ",
        load=(0, 0, -500, 0, 0, 0),
        view=(2.2, -1.5, 1.1),
        groups={"constraint forces": True, "actuator forces": False},
    ),
    "page": Picture(
        "3rps",
        {"z": 0.5, "rx": 0.03, "ry": -0.17},
        "3rps",
        load=(100, 50, -500, 0, 0, 0),
        sliders=True,
        size=(1400, 850),
    ),
}


def result_of(picture: Picture) -> ks.Result:
    """Analyze what a picture shows."""
    robot = ks.load_robot(ROOT / "robots" / f"{picture.robot}.urdf.xacro")
    pose = robot.assemble(platform=picture.platform, orientation=picture.orientation)
    return ks.analyze(pose, load=picture.load, gravity=picture.gravity)


def main(folder: Path) -> None:
    """Draw all pictures."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as pages, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for name, picture in PICTURES.items():
            file = Path(pages) / f"{name}.html"
            ks.save_html(result_of(picture), file, title=picture.title)
            page = browser.new_page(viewport={"width": picture.size[0], "height": picture.size[1]})
            page.goto(file.as_uri())
            page.wait_for_function("window.robot_page && robot_page.ready")
            if not picture.sliders:
                page.evaluate("document.querySelector('.dg.main').style.display = 'none'")
            for group, seen in picture.groups.items():
                page.evaluate("([group, seen]) => viewer.set_property(['Arrows', group], 'visible', seen)", [group, seen])
            page.evaluate("view => { robot_page.look(...view); viewer.set_dirty(); }", list(picture.view))
            page.wait_for_function("!viewer.needs_render")
            page.wait_for_timeout(200)
            page.screenshot(path=folder / f"{name}.png")
            page.close()
            print(f"{name}.png: {(folder / f'{name}.png').stat().st_size / 1e3:.0f} kB")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures")
