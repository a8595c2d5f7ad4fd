"""Screenshots of a page by an installed Chromium."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from urllib.parse import urlencode

from kinetostatics.exceptions import ArgumentError, KinetostaticsError

#: Names of Chromium browsers on various systems.
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
#: No window, no sandbox (for containers), WebGL in software, no network, and time for the page to draw.
FLAGS = (
    "--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
    "--virtual-time-budget=5000",
)  # fmt: skip
#: Time limit of a browser [s].
PATIENCE = 120
#: Choices for colour and view.
COLOURS = ("deflection", "stress", "axial", "euler")
VIEWS = ("home", "front", "side", "top")


def save_screenshot(
    html: str, path: str | os.PathLike[str], size: tuple[int, int], colour: str = "deflection", view: str = "home"
) -> None:
    """Write a picture of a page without its panel as a PNG file.

    Args:
        html: the page.
        path: path of the file; an existing file is replaced.
        size: width and height [pixels].
        colour: quantity shown by colours, one of :data:`COLOURS`.
        view: direction of view, one of :data:`VIEWS`.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        KinetostaticsError: there is no Chromium, it fails, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise ArgumentError(f"{os.fspath(path)}: images are PNG files; name it {target.with_suffix('.png').name!r}")
    for name, value, known in (("colour", colour, COLOURS), ("view", view, VIEWS)):
        if value not in known:
            raise ArgumentError(f"{name} is {value!r}; it must be one of {', '.join(known)}")
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
    with tempfile.TemporaryDirectory(prefix="kinetostatics_") as folder:
        page, image = Path(folder) / "page.html", Path(folder) / "page.png"
        page.write_text(html, encoding="utf-8")
        address = f"{page.as_uri()}#picture&{urlencode({'colour': colour, 'view': view})}"
        command = [browser, *FLAGS, f"--user-data-dir={folder}/profile", f"--window-size={size[0]},{size[1]}"]
        try:
            subprocess.run([*command, f"--screenshot={image}", address], capture_output=True, timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise KinetostaticsError(f"{browser} has drawn no image: {error}") from None
        if not image.is_file():
            raise KinetostaticsError(f"{browser} has drawn no image; write the page as HTML, open it and press I")
        try:
            shutil.copyfile(image, target)
        except OSError as error:
            raise KinetostaticsError(f"{os.fspath(path)}: cannot write the image: {error.strerror or error}") from None
