"""Draws a robot of each name that is known, and writes docs/gallery/names.md: ``python examples/robots_by_name.py [NAME …]``.

With names only their pictures are drawn. Needs Chromium and ``pip install 'kinetostatics[test]'``.
"""

import re
import shutil
import sys

from make_pictures import FLAGS, ROOT, draw_robot

import kinetostatics as ks
from kinetostatics.authoring.known_names import KNOWN_NAMES, KnownName

PICTURES = ROOT / "docs" / "pictures" / "names"
PAGE = ROOT / "docs" / "gallery" / "names.md"
HEAD = """\
# Robots by name

`kinetostatics new "NAME" --out FILE.urdf.xacro` generates a robot file from each of these names, with [dimensions, sections and
masses](../start/robot_by_name.md) as options. The pictures show the robots bent by their own weight.

<div class="grid cards" markdown>
"""


def file_of(known: KnownName) -> str:
    """Return the name of a file."""
    return re.sub("[^a-z0-9]+", "_", known.name.lower())


def page_text() -> str:
    """Return the page of the gallery."""
    cards = "".join(
        f"""
-   ![{known.name}](../pictures/names/{file_of(known)}.webp)

    **{known.name}** · `{known.architecture}`

    {known.about[0].upper()}{known.about[1:]}.
"""
        for known in KNOWN_NAMES
    )
    return f"{HEAD}{cards}\n</div>\n"


def main(names: list[str]) -> None:
    """Draw the pictures and write the page."""
    from playwright.sync_api import sync_playwright

    PICTURES.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page_text(), encoding="utf-8")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for known in KNOWN_NAMES:
            if not names or known.name in names:
                result = ks.analyze(ks.new_robot(known.name).assemble())
                flat = known.arrangement == "planar"
                draw_robot(browser, result, PICTURES / f"{file_of(known)}.webp", (0.7, -1.6, 1.9) if flat else (1.5, -2.6, 1.1))
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
