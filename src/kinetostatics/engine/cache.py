"""Cache of object code on disk, so that a structure is compiled once per computer; safe for concurrent processes."""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import sys
import tempfile
from pathlib import Path

#: First bytes of a file.
_MAGIC = b"kinetostatics object code 1\n"


def cache_folder() -> Path:
    """Return the folder of object code: ``KINETOSTATICS_CACHE``, or the user's cache folder of this system."""
    if given := os.environ.get("KINETOSTATICS_CACHE"):
        return Path(given)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "kinetostatics"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "kinetostatics" / "Cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "kinetostatics"


def read(key: str) -> bytes | None:
    """Return the content stored under a key, or None. Damaged files are removed."""
    folder = _own(cache_folder())
    if folder is None:
        return None
    path = folder / f"{key}.code"
    try:
        found = path.read_bytes()
    except OSError:
        return None
    digest, kept = found[len(_MAGIC) : len(_MAGIC) + 32], found[len(_MAGIC) + 32 :]
    if found.startswith(_MAGIC) and hashlib.sha256(kept).digest() == digest:
        return kept
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def write(key: str, content: bytes) -> None:
    """Store content under a key, if the folder exists or can be created and is the user's own; else do nothing."""
    with contextlib.suppress(OSError):
        cache_folder().mkdir(parents=True, exist_ok=True, mode=0o700)
        folder = _own(cache_folder())
        if folder is None:
            return
        number, name = tempfile.mkstemp(dir=folder)
        try:
            with os.fdopen(number, "wb") as file:
                file.write(_MAGIC + hashlib.sha256(content).digest() + content)
            os.replace(name, folder / f"{key}.code")  # atomic: no other process can read an incomplete file
        except OSError:
            os.unlink(name)
            raise


def _own(folder: Path) -> Path | None:
    """Return a folder if it belongs to the user and nobody else may write there (its content is executed), else None."""
    try:
        facts = folder.stat()
    except OSError:
        return None
    if not stat.S_ISDIR(facts.st_mode):
        return None
    if hasattr(os, "getuid") and (facts.st_uid != os.getuid() or facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        return None
    return folder
