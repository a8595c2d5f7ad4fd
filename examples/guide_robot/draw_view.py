"""Draws the bent lift table of the guide: ``python examples/guide_robot/draw_view.py [FOLDER]``.

Needs Chromium and ``pip install 'kinetostatics[test]'``, as ``examples/make_pictures.py`` does. The page is that of
``kinetostatics view examples/guide_robot/lift_table.urdf.xacro --html FILE``.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import kinetostatics as ks

ROOT = Path(__file__).parents[2]
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


def main(folder: Path) -> None:
    """Draw the picture."""
    from playwright.sync_api import sync_playwright

    result = ks.analyze(ks.load_robot(Path(__file__).parent / "lift_table.urdf.xacro").assemble())
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as pages, sync_playwright() as playwright:
        file = Path(pages) / "lift_table.html"
        ks.save_html(result, file, title="lift_table")
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        page = browser.new_page(bypass_csp=True, viewport={"width": 1200, "height": 760})
        page.goto(file.as_uri())
        page.wait_for_function("window.robot_page && robot_page.ready")
        page.evaluate("document.body.classList.add('as-picture')")
        page.evaluate("robot_page.look(0.9, -2.2, 0.25); viewer.set_dirty()")
        page.wait_for_function("!viewer.needs_render")
        page.wait_for_timeout(200)
        page.screenshot(path=folder / "lift_table.png")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures")
