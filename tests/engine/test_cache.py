"""Code on disk: whole or not at all, in a folder that is one's own."""

import multiprocessing
import os
import sys
from pathlib import Path

import pytest

from kinetostatics.engine import cache as disk

KEY = "a" * 64


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "deep" / "code"))
    return tmp_path / "deep" / "code"


def test_what_is_written_is_read(folder):
    assert disk.read(KEY) is None
    disk.write(KEY, b"some code")
    assert disk.read(KEY) == b"some code" and [path.name for path in folder.iterdir()] == [f"{KEY}.code"]
    disk.write(KEY, b"other code")
    assert disk.read(KEY) == b"other code"


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-1], lambda b: b[:20], lambda b: b"", lambda b: b[:-1] + b"X", lambda b: b"X" + b]
)
def test_what_is_damaged_is_removed(folder, damage):
    disk.write(KEY, b"some code")
    path = folder / f"{KEY}.code"
    path.write_bytes(damage(path.read_bytes()))
    assert disk.read(KEY) is None and not path.exists()
    disk.write(KEY, b"some code")
    assert disk.read(KEY) == b"some code"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="Windows has no such permissions")
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702])
def test_a_folder_in_which_others_write_is_not_used(folder, mode):
    disk.write(KEY, b"some code")
    folder.chmod(mode)
    assert disk.read(KEY) is None
    disk.write("b" * 64, b"more")
    folder.chmod(0o700)
    assert disk.read(KEY) == b"some code" and disk.read("b" * 64) is None


def test_nothing_happens_where_nothing_can_be_written(folder):
    folder.parent.mkdir(parents=True)
    folder.write_text("not a folder")
    disk.write(KEY, b"some code")
    assert disk.read(KEY) is None


def test_folders_of_the_systems(monkeypatch):
    monkeypatch.delenv("KINETOSTATICS_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/x")
    monkeypatch.setenv("LOCALAPPDATA", "/l")
    found = {}
    for system in ("linux", "darwin", "win32"):
        monkeypatch.setattr(sys, "platform", system)
        found[system] = disk.cache_folder()
    mac = Path.home() / "Library" / "Caches" / "kinetostatics"
    assert found == {"linux": Path("/x/kinetostatics"), "darwin": mac, "win32": Path("/l/kinetostatics/Cache")}


def _write_again_and_again(letter):
    for _ in range(200):
        disk.write(KEY, letter * 50_000)
        assert disk.read(KEY) is not None


def test_several_processes_write_at_once(folder):
    context = multiprocessing.get_context("fork")
    processes = [context.Process(target=_write_again_and_again, args=(letter,)) for letter in (b"a", b"b")]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0]
    assert disk.read(KEY) in (b"a" * 50_000, b"b" * 50_000)
    assert [path.name for path in folder.iterdir()] == [f"{KEY}.code"]
