"""How far a sweep is: a bar on standard error."""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING

from kinetostatics.printing.waiting import in_notebook, on_terminal, showing, waiting

if TYPE_CHECKING:
    from tqdm.auto import tqdm


def wants_bar(progress: bool | None) -> bool:
    """Return whether a bar is to be shown: if it is asked for, or where somebody looks on and has not forbidden it."""
    return progress if progress is not None else on_terminal() or in_notebook()


class Bar:
    """A progress bar, if it is wanted and there is tqdm, that says in words what is done; a context manager.

    Where somebody looks on, its clock goes on whatever takes long.
    """

    def __init__(self, progress: bool | None, total: int) -> None:
        self._wanted, self._total = wants_bar(progress), total
        self._stack = ExitStack()
        self._bar: tqdm | None = None

    def __enter__(self) -> Bar:
        if not self._wanted:
            return self
        try:
            from tqdm.auto import tqdm
        except ImportError:  # nobody has asked for it
            self._stack.enter_context(waiting(f"sweeping {self._total} poses"))
            return self
        if on_terminal() or in_notebook():
            self._stack.enter_context(showing(self))
        self._bar = tqdm(total=self._total, unit=" poses", unit_scale=True, smoothing=0.1, leave=False, **_size())
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        if self._bar is not None:
            self._bar.close()

    def show(self) -> None:
        """See :class:`kinetostatics.printing.waiting.Sign`."""
        if self._bar is not None:
            self._bar.refresh()

    def hide(self) -> None:
        """See :class:`kinetostatics.printing.waiting.Sign`."""
        if self._bar is not None:
            self._bar.clear()

    def say(self, what: str) -> None:
        """Say what is being done now."""
        if self._bar is not None:
            self._bar.set_description(what)

    def add(self, how_far: str) -> None:
        """Say how far that is, the next time that the line is written."""
        if self._bar is not None:
            self._bar.set_postfix_str(how_far, refresh=False)

    def advance(self, count: int, before: bool = False) -> None:
        """Say that more poses are done; ``before``: they had been done before."""
        if self._bar is not None:
            if before:  # does not count for the speed
                self._bar.initial += count
            self._bar.update(count)


def _size() -> dict[str, int]:
    """Return a usual size for a terminal that does not know its own, nothing for others, which tqdm asks."""
    try:
        known = min(os.get_terminal_size(sys.stderr.fileno())) > 0
    except (OSError, ValueError, AttributeError):
        return {}
    return {} if known else {"ncols": 80, "nrows": 24}
