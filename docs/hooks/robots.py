"""Pages of robots in the site: the picture behind ``<!-- robot: NAME -->`` is replaced by the page of the robot, which computes.

The pages are made when the site is built; ``ROBOT_PAGES=3rps,delta`` makes some only, and with ``EXECUTE_NOTEBOOKS=false`` the
pictures remain, as in the source.
"""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from mkdocs.utils import get_relative_url

import kinetostatics as ks

#: A robot of the package, and its picture.
ROBOT = re.compile(r"^<!-- robot: (\w+) -->\n+(!\[.*\]\(.*\))$", re.MULTILINE)
FOLDER = "gallery/pages"
#: Poses that show more than the zero pose.
POSES = {"3rps": {"z": 0.5, "rx": 0.03, "ry": -0.17}}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Make the page of every robot of the package."""
    if os.environ.get("EXECUTE_NOTEBOOKS", "true") != "false":
        for name in os.environ["ROBOT_PAGES"].split(",") if "ROBOT_PAGES" in os.environ else ks.robots():
            files.append(File.generated(config, f"{FOLDER}/{name}.html", content=page_of(name)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put pages of robots over their pictures, which remain behind them for browsers without scripts."""

    def framed(found: re.Match[str]) -> str:
        name, picture = found.groups()
        file = files.get_file_from_path(f"{FOLDER}/{name}.html")
        if file is None:
            return picture
        address = get_relative_url(file.url, page.url)
        frame = f'<iframe src="{address}" loading="lazy" title="{name}: move it, and see it sag"></iframe>'
        return f'<div class="robot" markdown="1">\n\n{picture}\n\n{frame}\n\n</div>'

    return ROBOT.sub(framed, markdown)


def page_of(name: str) -> str:
    """Return the page of a robot that bends under its weight."""
    robot = ks.load_robot(name)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        ks.save_html(ks.analyze(robot.assemble(platform=POSES[name]) if name in POSES else robot.assemble()), file)
        return file.read_text(encoding="utf-8")
