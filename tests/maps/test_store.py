"""Maps on disk equal those in memory, also after the sweep was killed; they are overwritten on request only."""

import json
import random
import re
import signal
import subprocess
import sys
import time
from collections import Counter, namedtuple

import numpy as np
import package_robots
import pytest
import xarray as xr
from maps import near

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.workspace import block, run, store

GRID = {"z": np.linspace(0.45, 0.65, 20), "rx": np.linspace(-0.1, 0.1, 12), "ry": 0.0}
LOAD = (10.0, -20.0, -500.0, 3.0, 0.0, 5.0)


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("3rps")


@pytest.fixture(scope="module")
def wanted(robot):
    """The map in memory."""
    return ks.sweep(robot, GRID)


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of about 40 poses, so that small maps have several."""
    monkeypatch.setattr(run, "LEAST", 40)
    monkeypatch.setattr(run, "MOST", 40)


@pytest.mark.parametrize("name", ["map.nc", "map.zarr"])
def test_map_on_disk_equals_map_in_memory(robot, wanted, small_blocks, tmp_path, name):
    path = tmp_path / name
    with ks.sweep(robot, GRID, out=path, workers=2) as found:
        near(found, wanted)
        assert found.attrs.keys() == wanted.attrs.keys() and found["status"].dtype == np.int8
    assert [item.name for item in tmp_path.iterdir()] == [name]
    before = path.stat().st_mtime_ns
    with ks.sweep(robot, GRID, out=path) as again:  # is there already
        near(again, wanted)
    assert path.stat().st_mtime_ns == before


def test_other_maps_and_files_are_not_overwritten(robot, tmp_path):
    path = tmp_path / "map.zarr"
    z = {"z": [0.5, 0.6], "rx": 0.0, "ry": 0.0}
    ks.sweep(robot, z, out=path).close()
    with pytest.raises(ks.ArgumentError, match="map of another sweep, with other arguments"):
        ks.sweep(robot, z, load=LOAD, out=path)
    with pytest.raises(ks.ArgumentError, match="with another robot"):
        ks.sweep(package_robots.robot("3rps", rod_diameter=0.05), z, out=path)
    with ks.sweep(robot, z, load=LOAD, out=path, restart=True) as found:
        assert json.loads(found.attrs["arguments"])["load"] == list(LOAD)
    other = tmp_path / "thesis.nc"
    other.write_text("years of work")
    with pytest.raises(ks.ArgumentError, match="is not the map of a sweep"):
        ks.sweep(robot, z, out=other, restart=True)
    assert other.read_text() == "years of work"


# ---- interrupted sweeps ------------------------------------------------------------------------------------------------


def stopped_after(count, monkeypatch):
    """Make a sweep raise KeyboardInterrupt after ``count`` blocks; return the list of computed blocks, without single poses."""
    blocks, compute = [], block.compute_block

    def counted(plan, labels, block, q=None):
        if any(piece.stop - piece.start > 1 for piece in block):  # not the pose that makes a robot ready
            if len(blocks) == count:
                raise KeyboardInterrupt
            blocks.append(block)
        return compute(plan, labels, block, q)

    monkeypatch.setattr(block, "compute_block", counted)
    return blocks


def test_interrupted_sweep_resumes_with_the_missing_blocks(wanted, small_blocks, monkeypatch, tmp_path):
    path, part = tmp_path / "map.zarr", tmp_path / "map.zarr.part"
    robot = tmp_path / "robot.urdf.xacro"
    robot.write_bytes(robot_path("3rps").read_bytes())
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        stopped_after(3, patch)
        ks.sweep(robot, GRID, out=path, workers=1)
    assert part.exists() and not path.exists()
    with pytest.raises(ks.ArgumentError, match="unfinished map of another sweep, with another load;"):
        ks.sweep(robot, GRID, load=LOAD, out=path)
    text = robot.read_text()
    robot.write_text(text.replace('name="rod_diameter" default="0.1"', 'name="rod_diameter" default="0.2"'))
    with pytest.raises(ks.ArgumentError, match="with another robot, or its file has changed;"):
        ks.sweep(robot, GRID, out=path)
    robot.write_text(text)
    monkeypatch.setattr(run, "MOST", 60)  # which does not change the blocks of the store
    blocks = stopped_after(None, monkeypatch)
    with ks.sweep(robot, GRID, out=path, workers=1) as found:
        near(found, wanted)
    assert len(blocks) == 4 and not part.exists()  # of seven


@pytest.mark.slow
def test_interrupted_continuity_corrections_are_completed_on_resume(small_blocks, monkeypatch, tmp_path):
    """Corrections are stored before they are applied, and counted once."""
    robot = ks.load_robot("five_bar", {"proximal_length": 0.28, "distal_length": 0.12})
    grid = {"x": np.linspace(-0.3, 0.3, 16), "y": np.linspace(-0.4, 0.4, 21)}
    wanted = ks.sweep(robot, grid)
    assert wanted.attrs["poses_by_neighbours"] > 0
    path, count = tmp_path / "map.zarr", 16
    for more in range(3):
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            stopped_after((count if more == 0 else 0) + (more > 1), patch)
            ks.sweep(robot, grid, out=path, workers=1)
    with ks.sweep(robot, grid, out=path, workers=1) as found:
        near(found, wanted)
        assert {**found.attrs, "date": 0, "history": 0} == {**wanted.attrs, "date": 0, "history": 0}


def test_broken_stores_are_refused_and_empty_ones_restarted(robot, small_blocks, monkeypatch, tmp_path):
    path, part = tmp_path / "map.zarr", tmp_path / "map.zarr.part"
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        stopped_after(2, patch)
        ks.sweep(robot, GRID, out=path, workers=1)
    notes = json.loads((part / ".zattrs").read_text())
    (part / ".zattrs").write_text(json.dumps({store.NOTES: {**notes[store.NOTES], "sizes": "?"}}))
    with pytest.raises(
        ks.ArgumentError, match=r"map.zarr.part is the unfinished map of another sweep, which cannot be read; .*restart"
    ):
        ks.sweep(robot, GRID, out=path)
    (part / ".zattrs").write_text("{}")
    ks.sweep(robot, GRID, out=path).close()
    assert path.exists() and not part.exists()


KILLED = """
import sys, time
import numpy as np
import kinetostatics as ks
from kinetostatics.workspace import block, run
run.LEAST = run.MOST = 40
compute, log = block.compute_block, open(sys.argv[2] + ".log", "a", buffering=1)
write = run.Store.write

def slow(plan, labels, block, q=None):
    if any(piece.stop - piece.start > 1 for piece in block):  # not the pose that makes a robot ready
        log.write(f"begun {block} {q is None}\\n")
        time.sleep(0.02)
    return compute(plan, labels, block, q)

def told(self, block, numbers):
    write(self, block, numbers)
    log.write(f"done {block} {len(numbers)}\\n")

block.compute_block, run.Store.write = slow, told
robot = ks.load_robot("five_bar", {"proximal_length": 0.28, "distal_length": 0.12})
log.write("ready\\n")
ks.sweep(robot, {"x": np.linspace(-0.3, 0.3, 31), "y": np.linspace(-0.4, 0.4, 41)}, out=sys.argv[1], workers=2)
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["map.nc", "map.zarr"])
def test_sweep_killed_twenty_times_neither_loses_nor_repeats_blocks(tmp_path, name):
    """Except the two blocks in progress at each kill."""
    path, log, chance = tmp_path / name, tmp_path / "run.log", random.Random(1)
    command = [sys.executable, "-c", KILLED, str(path), str(tmp_path / "run")]
    kills = 0
    while kills < 20 and not path.exists():
        begun = log.read_text().count("ready") if log.exists() else 0
        process = subprocess.Popen(command)
        while process.poll() is None and (not log.exists() or log.read_text().count("ready") == begun):
            time.sleep(0.01)
        time.sleep(chance.uniform(0, 0.15))
        process.send_signal(signal.SIGKILL)
        kills += process.wait() == -signal.SIGKILL
    if not path.exists():
        subprocess.run(command, check=True)
    robot = ks.load_robot("five_bar", {"proximal_length": 0.28, "distal_length": 0.12})
    wanted = ks.sweep(robot, {"x": np.linspace(-0.3, 0.3, 31), "y": np.linspace(-0.4, 0.4, 41)})
    with store.open_map(str(path)) as found:
        near(found, wanted)
        for attribute in ("mode_jumps", "poses_of_other_modes", "poses_by_neighbours"):
            assert found.attrs[attribute] == wanted.attrs[attribute]
    assert {item.name for item in tmp_path.iterdir()} == {name, "run.log"}
    done, begun = set(), Counter()
    for what, place in re.findall(r"^(begun|done) (\(.*\)) (?:True|\d+)$", log.read_text(), re.MULTILINE):
        if what == "done":
            done.add(place)
        else:
            assert place not in done, f"{place} was computed again"
            begun[place] += 1
    assert sum(begun.values()) <= len(begun) + 2 * kills


# ---- disks -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, free, message",
    [
        ({}, 10**12, r"takes .* PB, and this machine has .* GB of memory: write it to a file \(out=, --out\), make it lazy"),
        ({"out": "map.nc"}, 10**12, "PB, twice that while it is written, and the disk of 'map.nc' has 1 TB free"),
        ({"out": "map.zarr"}, 10**3, "has 1 kB free: use a coarser grid or another disk"),
    ],
)
def test_maps_too_large_for_memory_or_disk_are_refused(robot, tmp_path, monkeypatch, arguments, free, message):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(store.shutil, "disk_usage", lambda path: namedtuple("usage", "total used free")(10**13, 0, free))
    many = np.linspace(-0.1, 0.1, 10_000)
    with pytest.raises(ks.ArgumentError, match=f"a map of 1,000,000,000,000 poses .*{message}"):
        ks.sweep(robot, {"z": np.linspace(0.4, 0.6, 10_000), "rx": many, "ry": many}, **arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["map.nc", "map.zarr"])
def test_full_disk_is_one_error_and_keeps_finished_blocks(robot, wanted, small_blocks, monkeypatch, tmp_path, name):
    from zarr.storage import LocalStore

    path, left = tmp_path / name, [80]
    put = LocalStore.set

    async def full(self, key, value):
        if "/" in key and not key.split("/")[-1].startswith("."):
            left[0] -= 1
            if left[0] < 0:
                raise OSError(28, "No space left on device", key)
        await put(self, key, value)

    with monkeypatch.context() as patch, pytest.raises(ks.KinetostaticsError) as error:
        patch.setattr(LocalStore, "set", full)
        ks.sweep(robot, GRID, out=path)
    assert re.fullmatch(r".*: No space left on device; the results so far are in \S+, and the same call .*", str(error.value))
    blocks = stopped_after(None, monkeypatch)
    with ks.sweep(robot, GRID, out=path) as found:
        near(found, wanted)
    assert len(blocks) < 7 + 7


def test_unwritable_folder_is_one_error(robot, tmp_path, monkeypatch):
    def refused(*arguments, **options):
        raise PermissionError(13, "Permission denied", str(tmp_path / "map.nc.part"))

    monkeypatch.setattr(xr.Dataset, "to_zarr", refused)
    with pytest.raises(ks.KinetostaticsError, match=r"map.nc.part: Permission denied$"):
        ks.sweep(robot, GRID, out=tmp_path / "map.nc")


def test_map_size_is_computed_before_the_sweep(robot, wanted, monkeypatch):
    sizes = []
    monkeypatch.setattr(run, "check_memory", lambda plan, labels: sizes.append(store.size_of(plan, labels)) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        ks.sweep(robot, GRID)
    assert sizes == [sum(wanted[name].nbytes for name in wanted.data_vars)]
    assert sizes[0] / 240 == pytest.approx(1.1e3, rel=0.05)  # what docs/how_to/workspace.md says
