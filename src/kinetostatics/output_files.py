"""Writing of files: a complete new file replaces the old one at once; if it cannot be completed, the old one remains."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from kinetostatics.arguments import path_name
from kinetostatics.exceptions import ArgumentError


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str], new: bool = False) -> Iterator[Path]:
    """Yield the path of a file to be written beside ``path``; after the block it is renamed to ``path``, after an error deleted.

    Args:
        path: path of the file; devices and pipes are written directly.
        new: whether an existing file is an error.

    Raises:
        ArgumentError: the file cannot be written, or exists; the message names it.
    """
    name = path_name("path", path)
    if "\0" in name:
        raise ArgumentError(f"{name!r} cannot be written: embedded null character")
    if new and os.path.lexists(name):
        raise ArgumentError(f"{name} exists and is not overwritten; delete it or choose another name")
    target = Path(os.path.realpath(name))  # a link remains a link
    partial = target.with_name(f"{target.name}.{secrets.token_hex(4)}.partial")
    try:
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        yield partial if target.is_file() or not target.exists() else target
        if target.is_file():
            shutil.copymode(target, partial)
        if partial.exists():
            os.replace(partial, target)
    except OSError as error:
        raise ArgumentError(f"{name} cannot be written: {error.strerror or error}") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()


def write_text(path: str | os.PathLike[str], text: str, new: bool = False) -> None:
    """Write a text in UTF-8; arguments and errors are those of :func:`replacing`."""
    with replacing(path, new) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")
