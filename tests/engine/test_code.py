"""Code on disk: its key and its files."""

import multiprocessing
import os
import sys
from pathlib import Path

import numpy as np
import package_robots
import pytest

from kinetostatics.engine import code
from kinetostatics.engine.code import read_stored, store
from kinetostatics.engine.loop_record import newton_record
from kinetostatics.engine.pose_code import ANALYSIS, STABILITY, pose_model
from kinetostatics.engine.pose_record import pose_record

KEY = "a" * 64


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "deep" / "code"))
    return tmp_path / "deep" / "code"


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-1], lambda b: b[:20], lambda b: b"", lambda b: b[:-1] + b"X", lambda b: b"X" + b]
)
def test_damaged_files_are_removed(folder, damage):
    assert read_stored(KEY) is None
    store(KEY, b"some code")
    path = folder / f"{KEY}.code"
    assert read_stored(KEY) == b"some code" and [*folder.iterdir()] == [path]
    path.write_bytes(damage(path.read_bytes()))
    assert read_stored(KEY) is None and not path.exists()
    store(KEY, b"other code")
    assert read_stored(KEY) == b"other code"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="Windows has no such permissions")
def test_cache_folder_writable_by_others_is_not_used(folder):
    store(KEY, b"some code")
    for mode in (0o777, 0o770, 0o702):
        folder.chmod(mode)
        assert read_stored(KEY) is None
        store("b" * 64, b"more")
        folder.chmod(0o700)
        assert read_stored(KEY) == b"some code" and read_stored("b" * 64) is None


def test_store_without_usable_folder_stores_nothing(folder):
    folder.parent.mkdir(parents=True)
    folder.write_text("not a folder")
    store(KEY, b"some code")
    assert read_stored(KEY) is None


def test_cache_folder_of_each_operating_system(monkeypatch):
    monkeypatch.delenv("KINETOSTATICS_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/x")
    monkeypatch.setenv("LOCALAPPDATA", "/l")
    mac = Path.home() / "Library" / "Caches" / "kinetostatics"
    for system, expected in (("linux", "/x/kinetostatics"), ("darwin", mac), ("win32", "/l/kinetostatics/Cache")):
        monkeypatch.setattr(sys, "platform", system)
        assert code.cache_folder() == Path(expected)


def _store_repeatedly(letter):
    for _ in range(200):
        store(KEY, letter * 50_000)
        assert read_stored(KEY) is not None


def test_processes_store_the_same_key_concurrently(folder):
    context = multiprocessing.get_context("fork")
    processes = [context.Process(target=_store_repeatedly, args=(letter,)) for letter in (b"a", b"b")]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0]
    assert read_stored(KEY) in (b"a" * 50_000, b"b" * 50_000)
    assert [path.name for path in folder.iterdir()] == [f"{KEY}.code"]


def test_code_key_depends_on_all_recorded_source(monkeypatch):
    robot, files = package_robots.robot("five_bar"), set()
    root = Path(code.__file__).parent.parent
    example = robot.generic_poses.take(np.zeros(1, dtype=int))

    def note(frame, event, _):
        files.add(frame.f_code.co_filename)

    asked = ANALYSIS, STABILITY, (("worst_equation", "opening", "within"),)
    given = [(pose_model(robot, robot.statics, stages), stages) for stages in asked]
    sys.setprofile(note)
    try:
        for (model, inputs), stages in given:
            pose_record(model, [name for stage in stages for name in stage], inputs)
        newton_record(robot.solver, robot.actuator_coordinates, example)
    finally:
        sys.setprofile(None)
    places = {Path(file).relative_to(root).parts[0] for file in files if Path(file).is_relative_to(root)}
    assert {"statics", "kinematics", "limbs", "elements", "buckling", "quantities.py"} <= places
    assert places <= {*code._SOURCES, "layout"}
    # data that are read without a call: the table of joint types
    before, read = code._versions.__wrapped__(), Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" * (path.name == "joint_types.py"))
    assert code._versions.__wrapped__() != before
