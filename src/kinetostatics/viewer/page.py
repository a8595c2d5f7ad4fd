"""The page of a scene, one HTML file that needs neither server nor network; and a PNG picture of the page."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import html
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from subprocess import DEVNULL
from urllib.parse import urlencode

from kinetostatics.arguments import warn
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.layout.renderings import asset, filled
from kinetostatics.output_files import replacing
from kinetostatics.viewer.description import Scene
from kinetostatics.viewer.packing import Packing, zipped

_asset = partial(asset, __package__)
_SCRIPTS = (
    "motion.js", "labels.js", "drawing.js", "colouring.js", "compare.js", "views.js", "panel.js", "modes.js", "cards.js",
    "picture.js", "live.js", "page.js",
)  # fmt: skip
#: Largest size of a page [characters].
MOST = 5_000_000
#: Numbers of bits to which a path is rounded (None: single precision), each with the rounding error for the note. The first one
#: for which the page is small enough is used. Twenty bits are more digits than the page shows.
ROUNDINGS = ((None, ""), (20, ""), (16, "0.001 %"), (12, "0.02 %"))


def fitting_page(describe: Callable[[int], Scene], every: int = 1, engine: dict[str, object] | None = None) -> str:
    """Return the page of a path, with as many digits and poses as fit into :data:`MOST`.

    A note and a warning tell what is lost. ``describe(n)`` returns the scene with every n-th pose; ``every`` is the smallest n.
    ``engine``: see :func:`page_html`.
    """
    scene = describe(every)
    one_pose = max(shown.stations.frames for shown in (scene, scene.compare) if shown is not None) == 1
    for bits, part in ROUNDINGS:
        losses = [f"numbers are rounded to {part} of the largest"] if part else []
        losses += [f"one of {every} consecutive poses is shown"] if every > 1 else []
        note = f"{' and '.join(losses)}, to keep the page below {MOST / 1e6:.0f} MB"
        shown = replace(scene, notes=[*scene.notes, note]) if losses else scene
        page = page_html(shown.plain(packing=Packing(bits)), engine)
        if len(page) < MOST or one_pose:
            if losses:
                warn(note)
            return page
    return fitting_page(describe, 2 * every)


def page_html(scene: dict[str, object], engine: dict[str, object] | None = None) -> str:
    """Return the page of the data ``scene``, made by :meth:`Scene.plain`; with ``engine``, a page that computes."""
    script, meshcat = page_scripts()
    held = {"meshcat": meshcat, "scene": scene, "engine": engine}
    markup = {
        "style": _asset("page.css"),
        "packed": zipped(json.dumps(held, allow_nan=False, separators=(",", ":"))),
        "script": script,
    }
    return filled(_asset("page.html"), {"title": scene["title"], "policy": policy(script, meshcat)}, markup)


@cache
def page_scripts() -> tuple[str, str]:
    """Return the script of the page, and meshcat's, which it starts."""
    start = f"function start(description, computed) {{\n{''.join(map(_asset, _SCRIPTS))}}}\n\n"
    return f'\n"use strict";\n(() => {{\n{start}{_asset("unpacking.js")}{_asset("engine.js")}unpackPage();\n}})();\n', _meshcat()


def policy(*scripts: str) -> str:
    """Return the content security policy of a page that runs only these scripts and WebAssembly, and reaches no network."""
    hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in hashes)
    return (
        f"default-src 'none'; script-src {allowed} 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:; "
        "connect-src 'none'; base-uri 'none'; form-action 'none'"
    )


def iframe_html(page: str, height: int = 640) -> str:
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: {height}px; border: 1px solid #8888"></iframe>'


@cache
def _meshcat() -> str:
    """Return meshcat's script from its package; meshcat's ``static_html()`` would start a server process."""
    package = find_spec("meshcat")  # importing it would import its server
    if package is None or package.origin is None:
        raise KinetostaticsError("the page needs meshcat: pip install meshcat")
    try:
        return (Path(package.origin).parent / "viewer" / "dist" / "main.min.js").read_text(encoding="utf-8")
    except OSError as error:
        raise KinetostaticsError(f"the installed meshcat has no page to show ({error}); reinstall meshcat") from None


#: Names of Chromium browsers on various systems.
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
#: Options: no window, no sandbox (for containers), WebGL in software, no network, 5 s for the page to draw.
FLAGS = (
    "--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
    "--virtual-time-budget=5000",
)  # fmt: skip
#: Time limits of successive attempts [s]: on a busy machine a third of all runs of Chromium hang.
PATIENCE = (60, 90, 120)
#: Choices for colour and view.
COLOURS = ("deflection", "stress", "axial", "euler")
VIEWS = ("home", "front", "side", "top")


def save_screenshot(
    html: str, path: str | os.PathLike[str], size: tuple[int, int], colour: str = "deflection", view: str = "home"
) -> None:
    """Write a PNG file with the picture of a page, without its panel; see :func:`kinetostatics.save_image`."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise ArgumentError(f"{os.fspath(path)}: images are PNG files; name it {target.with_suffix('.png').name!r}")
    for name, value, choices in (("colour", colour, COLOURS), ("view", view, VIEWS)):
        if value not in choices:
            raise ArgumentError(f"{name} is {value!r}; it must be one of {', '.join(choices)}")
    if (
        not isinstance(size, (tuple, list))
        or len(size) != 2
        or not all(isinstance(pixels, int) and 100 <= pixels <= 10_000 for pixels in size)
    ):
        raise ArgumentError(f"size is {size!r}; it must be width and height from 100 to 10000 pixels")
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise KinetostaticsError(
            "an image needs Chromium or Chrome, and none is installed (Debian: apt install chromium); or write the page as HTML, "
            "open it and press I"
        )
    with tempfile.TemporaryDirectory(prefix="kinetostatics_", ignore_cleanup_errors=True) as folder:
        page, image = Path(folder) / "page.html", Path(folder) / "page.png"
        page.write_text(html, encoding="utf-8")
        address = f"{page.as_uri()}#picture&{urlencode({'colour': colour, 'view': view})}"
        command = [browser, *FLAGS, f"--window-size={size[0]},{size[1]}", f"--screenshot={image}", address]
        for seconds in PATIENCE:
            profile = f"--user-data-dir={folder}/profile_{seconds}"
            with contextlib.suppress(OSError, subprocess.TimeoutExpired):
                # without pipes: child processes of the browser could hold them open
                subprocess.run([*command, profile], stdout=DEVNULL, stderr=DEVNULL, timeout=seconds)
            if image.is_file():
                break
        else:
            raise KinetostaticsError(
                f"{browser} has drawn no image in {len(PATIENCE)} attempts; write the page as HTML, open it and press I"
            )
        with replacing(target) as partial:
            shutil.copyfile(image, partial)
