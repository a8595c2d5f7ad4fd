"""Animates modes of vibration of eight robots, and writes docs/gallery/modes.md: ``python examples/animated_modes.py [NAME …]``.

With names only their pictures are drawn. Needs Chromium and ``pip install 'kinetostatics[test]'``.
"""

import io
import shutil
import sys
import tempfile
from pathlib import Path

from make_pictures import FLAGS, ROOT, VIEWS
from PIL import Image
from playwright.sync_api import Browser, sync_playwright

import kinetostatics as ks

PICTURES = ROOT / "docs" / "pictures" / "modes"
PAGE = ROOT / "docs" / "gallery" / "modes.md"
PERPENDICULAR = "Mode 2 is the same in the perpendicular direction."
#: Names of the robots, and descriptions of their first modes.
MODES = {
    "3rps": ("3RPS", f"The platform moves sideways, and the rods bend. {PERPENDICULAR}"),
    "2pru_upr": ("2PRU-UPR", "The platform moves along x, perpendicular to the rails; the rods on the sliders bend."),
    "gough_stewart": ("Gough–Stewart platform", f"The platform moves sideways, and the legs bend. {PERPENDICULAR}"),
    "delta": ("Delta", f"The platform moves sideways; arms and rods bend. {PERPENDICULAR}"),
    "tripteron": ("Tripteron", "The platform moves along (1, 1, 1); the upper arms have most of the strain energy."),
    "five_bar": ("Five-bar", "The tool moves along y, and the proximal links bend. In mode 2 the tool leaves the plane."),
    "planar_3rrr": ("Planar 3-RRR", f"The platform moves in its plane, and the cranks bend. {PERPENDICULAR}"),
    "ur10": ("UR10", "The arm moves up and down; the upper arm has three quarters of the strain energy."),
}
#: How many frames a period has, how long each is shown [ms], and their size [pixels].
FRAMES, SHOWN, SIZE = 16, 90, (400, 300)
HEAD = """\
# Modes

The first [mode of vibration](../explanation/vibration.md) of eight robots at their zero poses, with locked actuators. Colours are
displacements; the largest is drawn as a tenth of the robot's size. `kinetostatics view 3rps --modes 6` animates modes of a robot,
`kinetostatics modes 3rps` prints them, and `python examples/animated_modes.py` writes this page.

<div class="grid cards" markdown>
"""


def modes_of(name: str) -> ks.results.Modes:
    """Return the first mode of a robot at zero."""
    return ks.modes(ks.load_robot(name).assemble(), count=1)


def page_text() -> str:
    """Return the page of the gallery."""
    cards = ""
    for name, (words, moves) in MODES.items():
        frequency = modes_of(name).frequencies[0]
        cards += f"""
-   ![{words}, mode 1](../pictures/modes/{name}.webp)

    **[{words}](robots/{name}.md)** · {frequency:.4g} Hz

    {moves}
"""
    return f"{HEAD}{cards}\n</div>\n"


def animate(browser: Browser, name: str, folder: Path) -> None:
    """Draw a period of the first mode."""
    made = folder / f"{name}.html"
    ks.save_html(modes_of(name), made)
    size = {"width": SIZE[0], "height": SIZE[1]}
    page = browser.new_page(bypass_csp=True, viewport=size, reduced_motion="reduce")  # it does not play by itself
    page.goto(made.as_uri())
    page.wait_for_function("window.robot_page && robot_page.ready")
    for hidden in ("robot-head", "robot-legend", "robot-labels"):
        page.evaluate("id => document.getElementById(id).style.display = 'none'", hidden)
    page.evaluate("document.body.classList.add('without-panel'); viewer.set_property(['Frames'], 'visible', false)")
    page.wait_for_timeout(200)
    page.evaluate("view => robot_page.look(...view)", list(VIEWS.get(name, (1.5, -2.6, 1.1))))
    frames = []
    for k in range(FRAMES):
        page.evaluate(
            "time => { const input = document.querySelector('input[name=path]');"
            " input.value = time; input.dispatchEvent(new Event('input')); }",
            k / FRAMES,
        )
        page.wait_for_function("!viewer.needs_render")
        page.wait_for_timeout(100)
        frames.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
    page.close()
    file = PICTURES / f"{name}.webp"
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=SHOWN, loop=0, quality=40, method=6)
    print(f"{file.name}: {file.stat().st_size / 1e3:.0f} kB")


def main(names: list[str]) -> None:
    """Draw the modes and write the page."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page_text(), encoding="utf-8")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for name in names or MODES:
            animate(browser, name, Path(folder))
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
