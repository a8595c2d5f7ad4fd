"""Signs of life: a line on the terminal that says what takes so long, and is gone when it is done.

Nothing is written where standard error is no terminal.
"""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol, TextIO

#: Seconds until the first sign, and from one to the next.
EVERY = 1.0


class Sign(Protocol):
    """Something that fills the last line of a terminal."""

    def show(self) -> None:
        """Write the line, or write it anew."""

    def hide(self) -> None:
        """Leave the line empty."""


def on_terminal() -> bool:
    """Return whether standard error is a terminal."""
    return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()


def in_notebook() -> bool:
    """Return whether this runs in a notebook, which can display HTML."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None else None
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})


def waiting(what: str | Callable[[], str], wanted: bool = True, always: bool = False) -> AbstractContextManager[None]:
    """Say on the terminal what is being done, if it takes longer than a second, and for how long already.

    Args:
        what: in words, such as "verifying", or what returns them.
        wanted: False: say nothing.
        always: whether to say it where standard error is no terminal, too.
    """
    return _life.with_sign(_Words(what)) if wanted and (always or on_terminal()) else nullcontext()


def pausing() -> AbstractContextManager[None]:
    """Leave the terminal to somebody else: for questions, or messages that stay."""
    return _life.with_sign(_Nothing()) if _life.signs else nullcontext()


class _Nothing:
    def show(self) -> None:
        pass

    def hide(self) -> None:
        pass


class _Words:
    def __init__(self, what: str | Callable[[], str]) -> None:
        self._what, self._since, self._width = what, time.monotonic(), 0

    def show(self) -> None:
        what = self._what if isinstance(self._what, str) else self._what()
        text = f"{what} … {time.monotonic() - self._since:.0f} s"
        _write(f"\r{text}{' ' * (self._width - len(text))}")
        self._width = len(text)

    def hide(self) -> None:
        _write(f"\r{' ' * self._width}\r" if self._width else "")
        self._width = 0


def _write(text: str) -> None:
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    except (OSError, ValueError):  # the terminal is gone
        pass


class _Life:
    """The signs that wait for their turn, the last of which is shown, and the thread that shows it as long as there are any."""

    def __init__(self) -> None:
        self.signs: list[Sign] = []
        self._lock = threading.RLock()
        self._end = threading.Event()

    @contextmanager
    def with_sign(self, sign: Sign) -> Iterator[None]:
        with self._lock:
            if self.signs:
                self.signs[-1].hide()
            else:
                self._begin()
            self.signs.append(sign)
        try:
            yield
        finally:
            with self._lock:
                sign.hide()
                self.signs.remove(sign)
                if not self.signs:
                    self._finish()

    def _begin(self) -> None:
        """Show the last sign anew every second, and let warnings begin on an empty line."""
        self._end = threading.Event()
        threading.Thread(target=self._renew, args=(self._end,), daemon=True).start()
        before = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            with self._lock:
                if self.signs:
                    self.signs[-1].hide()
                before(message, category, filename, lineno, file, line)

        self._before, self._show = before, show
        warnings.showwarning = show

    def _finish(self) -> None:
        self._end.set()
        if warnings.showwarning is self._show:
            warnings.showwarning = self._before

    def _renew(self, end: threading.Event) -> None:
        while not end.wait(EVERY):
            with self._lock:
                if self.signs and not end.is_set():
                    self.signs[-1].show()


_life = _Life()
