"""One HTML file that holds meshcat's page, the scene and the scripts that move it; it needs no server and no network."""

from __future__ import annotations

import html
import json
import re
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from kinetostatics.exceptions import KinetostaticsError

_SCRIPTS = (
    "motion.js", "drawing.js", "colouring.js", "compare.js", "views.js", "panel.js", "cards.js", "picture.js", "live.js",
    "page.js",
)  # fmt: skip


def page_html(scene: dict[str, Any]) -> str:
    """Return the page of a scene (:meth:`Scene.plain`)."""
    parts = {
        "title": html.escape(scene["title"]),
        "style": _asset("page.css"),
        "meshcat": _meshcat(),
        "scene": json.dumps(scene, allow_nan=False, separators=(",", ":")).replace("</", "<\\/"),
        "script": "".join(_asset(name) for name in _SCRIPTS),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _asset("page.html"))


def iframe_html(page: str, height: int = 640) -> str:
    """Return a page inside an ``<iframe>``, for notebooks."""
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: {height}px; border: 1px solid #8888"></iframe>'


def _asset(name: str) -> str:
    return (files("kinetostatics.viewer") / "assets" / name).read_text(encoding="utf-8")


@cache
def _meshcat() -> str:
    """Return meshcat's own script. Its ``static_html()`` holds the same, but starts a server process to put it together."""
    found = find_spec("meshcat")  # importing it would import its server
    if found is None or found.origin is None:
        raise KinetostaticsError("the page needs meshcat: pip install meshcat")
    try:
        return (Path(found.origin).parent / "viewer" / "dist" / "main.min.js").read_text(encoding="utf-8")
    except OSError as error:
        raise KinetostaticsError(f"the installed meshcat has no page to show ({error}); reinstall meshcat") from None
