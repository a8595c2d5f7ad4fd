"""See it sag: the deformed robot in a browser page that needs neither server nor network.

A result becomes a :class:`Scene <kinetostatics.viewer.description.Scene>` of plain numbers, and that one HTML file with
meshcat's page; everything that moves there is computed in the page.
"""

from __future__ import annotations

import os
import sys
import tempfile
import webbrowser
from pathlib import Path

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.result import Result
from kinetostatics.viewer.page import iframe_html, page_html
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.waiting import in_notebook, pausing


class View:
    """A page that shows a result; notebooks display it in place.

    Attributes:
        html: the whole page.
        path: of the file that the browser was given, or None.
    """

    def __init__(self, html: str, path: Path | None = None) -> None:
        self.html, self.path = html, path

    def __repr__(self) -> str:
        return f"<View in {str(self.path)!r}>" if self.path else f"<View, {len(self.html) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return iframe_html(self.html)


def show(result: Result, *, title: str | None = None) -> View:
    """Open a result in the browser, or below the cell of a notebook.

    Args:
        result: of :func:`kinetostatics.analyze`; of a batch, its poses become an animation.
        title: heading of the page; default the robot's name.

    Returns:
        The view, which a notebook displays when it is the last value of a cell.

    Raises:
        ArgumentError: no pose could be analysed, or there are too many.
    """
    html = page_html(describe_scene(result, title).plain())
    if in_notebook():
        return View(html)
    path = _temporary_file(html, result.robot.name)
    open_browser(path.as_uri())
    return View(html, path)


def save_html(result: Result, path: str | os.PathLike[str], *, title: str | None = None) -> None:
    """Write a result as one HTML file that works by double click.

    Args:
        result: of :func:`kinetostatics.analyze`; of a batch, its poses become an animation.
        path: of the file; an existing one is replaced.
        title: heading of the page; default the robot's name.

    Raises:
        ArgumentError: no pose could be analysed, or there are too many.
        KinetostaticsError: the file cannot be written.
    """
    html = page_html(describe_scene(result, title).plain())
    try:
        Path(path).write_text(html, encoding="utf-8")
    except OSError as error:
        raise KinetostaticsError(f"{os.fspath(path)}: cannot write the page: {error.strerror or error}") from None


def open_browser(address: str) -> None:
    """Open an address in the browser, or say on standard error where to find it."""
    with pausing():  # some browsers are programs of the terminal
        if not webbrowser.open(address):
            print(f"no browser could be started; open this address yourself: {address}", file=sys.stderr)


def _temporary_file(html: str, name: str) -> Path:
    """Write a page where the browser can read it after this program has ended."""
    safe = "".join(c if c.isalnum() or c in "-_" else "_" for c in name)
    handle, path = tempfile.mkstemp(prefix=f"kinetostatics_{safe}_", suffix=".html")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(html)
    return Path(path)
