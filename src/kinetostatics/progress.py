"""Progress line on the terminal for work of more than a second: task and elapsed time; the line is erased at the end."""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from kinetostatics.arguments import Keyword

#: Delay before the line appears, and interval between updates [s].
EVERY = 1.0


def on_terminal() -> bool:
    """Whether standard error is a terminal."""
    return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()


def in_notebook() -> bool:
    """Whether the code runs in a notebook, which can display HTML."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None else None
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})


def waiting(what: str | Callable[[], str], enabled: bool = True, always: bool = False) -> AbstractContextManager[None]:
    """Return a context in which a task and its elapsed time are shown on the terminal; an inner context hides outer ones.

    Args:
        what: the task, such as "verifying", or a function that returns it.
        enabled: whether to show the task at all.
        always: whether to show it even if standard error is not a terminal.
    """
    if not enabled or not (always or on_terminal()):
        return nullcontext()
    since = time.monotonic()
    return _line.showing(lambda: f"{what if isinstance(what, str) else what()} … {time.monotonic() - since:.0f} s")


def pausing() -> AbstractContextManager[None]:
    """Return a context in which the progress line is erased, for output that is to stay."""
    return _line.showing(lambda: "") if _line.texts else nullcontext()


class _Line:
    """The progress line, and the thread that updates it as long as there is a task."""

    def __init__(self) -> None:
        self.texts: list[Callable[[], str]] = []
        self._lock, self._end, self._width = threading.RLock(), threading.Event(), 0

    @contextmanager
    def showing(self, text: Callable[[], str]) -> Iterator[None]:
        """Show a text in place of the texts of the surrounding tasks."""
        with self._lock:
            self._write("")
            if not self.texts:
                self._begin()
            self.texts.append(text)
        try:
            yield
        finally:
            with self._lock:
                self._write("")
                self.texts.remove(text)
                if not self.texts:
                    self._end.set()
                    if warnings.showwarning is self._show:
                        warnings.showwarning = self._before

    def _begin(self) -> None:
        """Start the thread, and make Python erase the line before each warning."""
        self._end = threading.Event()
        threading.Thread(target=self._renew, args=(self._end,), daemon=True).start()
        self._before = before = warnings.showwarning

        def show(*warning: Keyword, **more: Keyword) -> None:
            with self._lock:
                self._write("")
                before(*warning, **more)

        self._show = warnings.showwarning = show

    def _renew(self, end: threading.Event) -> None:
        while not end.wait(EVERY):
            with self._lock:
                if self.texts and not end.is_set():
                    self._write(self.texts[-1]())

    def _write(self, text: str) -> None:
        if text or self._width:
            try:
                sys.stderr.write(f"\r{text:{self._width}}" if text else f"\r{' ' * self._width}\r")
                sys.stderr.flush()
            except (OSError, ValueError):  # the terminal is gone
                pass
        self._width = len(text)


_line = _Line()
