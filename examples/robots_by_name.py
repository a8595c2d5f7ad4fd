"""Four robots built by name, in the picture of docs/start/robot_by_name.md: ``python examples/robots_by_name.py [FILE]``.

Needs Chromium and ``pip install 'kinetostatics[test]'``.
"""

import base64
import shutil
import sys
import tempfile
from pathlib import Path

from make_pictures import FLAGS, ROOT

import kinetostatics as ks

#: Architectures with sizes, and from where they are seen.
ROBOTS = {
    "3-R[P]S": (dict(base_radius=0.25, platform_radius=0.2, height=0.55), (1.5, -2.6, 1.1)),
    "6-U[P]S": (dict(base_radius=0.3, platform_radius=0.2, height=0.4), (1.5, -2.6, 1.1)),
    "3-[R](4S)": (
        dict(base_radius=0.15, platform_radius=0.08, height=-0.5, crank_length=0.25, rod_length=0.55),
        (1.5, -2.6, 0.7),
    ),
    "3-[R]RR": (dict(arrangement="planar", base_radius=0.3, platform_radius=0.08), (1.0, -1.9, 2.0)),
}
SIZE = (600, 420)


def main(file: Path) -> None:
    """Draw the picture."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    cells = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for name, (sizes, view) in ROBOTS.items():
            made = Path(folder) / "robot.html"
            ks.save_html(ks.analyze(ks.new_robot(name, **sizes).assemble()), made, title=name)
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
            page.goto(made.as_uri())
            page.wait_for_function("window.robot_page && robot_page.ready")
            page.evaluate("document.body.classList.add('as-picture')")
            page.evaluate("viewer.set_property(['Arrows'], 'visible', false)")
            page.wait_for_timeout(200)
            page.evaluate("view => { robot_page.look(...view); viewer.set_dirty(); }", list(view))
            page.wait_for_function("!viewer.needs_render")
            page.wait_for_timeout(200)
            shot = base64.b64encode(page.screenshot()).decode()
            cells.append(f'<figure><img src="data:image/png;base64,{shot}"><figcaption>{name}</figcaption></figure>')
            page.close()
        style = f"""<style>
            body {{margin: 0; display: grid; grid-template-columns: 1fr 1fr; font: 22px monospace; text-align: center}}
            figure {{margin: 0}} img {{width: {SIZE[0]}px}} figcaption {{padding-bottom: 12px}}</style>"""
        page = browser.new_page(viewport={"width": 2 * SIZE[0], "height": 2 * SIZE[1] + 80})
        page.set_content(style + "".join(cells))
        page.screenshot(path=file)
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures" / "robots_by_name.png")
