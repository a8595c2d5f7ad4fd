"""Maps computed in parts by several processes at once, in any order, also if some are killed, equal those of one process."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from page_code import blocks, text_of

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.workspace import block, run, store

#: A robot with poses of another assembly mode, which are corrected when all blocks are there.
ROBOT = ("five_bar", {"proximal_length": 0.28, "distal_length": 0.12})
GRID = {"x": np.linspace(-0.3, 0.3, 16), "y": np.linspace(-0.4, 0.4, 21)}


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of about 40 poses, so that small maps have several."""
    monkeypatch.setattr(run, "LEAST", 40)
    monkeypatch.setattr(run, "MOST", 40)


@pytest.fixture(scope="module")
def robot():
    return ks.load_robot(*ROBOT)


@pytest.fixture(scope="module")
def wanted(robot):
    """The map of one process, with the same blocks: rounding depends on how NumPy's poses are bundled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "LEAST", 40)
        patch.setattr(run, "MOST", 40)
        ds = ks.sweep(robot, GRID)
    assert ds.attrs["poses_by_neighbours"] > 0
    return ds


def same(found, wanted):
    """Assert that all numbers of two maps are the same to the last digit; files store texts in types of their own."""
    assert set(found.variables) == set(wanted.variables)
    for name in found.variables:
        np.testing.assert_array_equal(found[name].values, wanted[name].values, err_msg=name)
    assert {**found.attrs, "date": 0, "history": 0} == {**wanted.attrs, "date": 0, "history": 0}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["map.zarr", "map.nc"])
def test_parts_in_any_order_make_the_map(robot, wanted, small_blocks, monkeypatch, tmp_path, name):
    path, computed, compute = tmp_path / name, [], block.compute_block

    def told(plan, labels, place, q=None):
        if any(piece.stop - piece.start > 1 for piece in place) and q is None:
            computed.append(place)
        return compute(plan, labels, place, q)

    monkeypatch.setattr(block, "compute_block", told)
    for part, missing in (("3/3", [1, 2]), ("1/3", [2]), ("3/3", [2])):
        before = len(computed)
        ds = ks.sweep(robot, GRID, out=path, part=part)
        assert ds.attrs["missing_parts"] == missing and not ds.data_vars and ds.sizes["x"] == 16
        assert not path.exists() and (len(computed) == before) == (before > 6)
    with ks.sweep(robot, GRID, out=path, part="2/3") as found:
        same(found, wanted)
    assert len(computed) == len(set(map(str, computed))) == 16
    with ks.sweep(robot, GRID, out=path, part="1/3") as again:  # is there already
        same(again, wanted)
    assert len(computed) == 16 and [entry.name for entry in tmp_path.iterdir()] == [name]


def test_sweep_without_part_completes_the_map(robot, wanted, small_blocks, tmp_path):
    path = tmp_path / "map.zarr"
    assert ks.sweep(robot, GRID, out=path, part="2/4").attrs["missing_parts"] == [1, 3, 4]
    with ks.sweep(robot, GRID, out=path) as found:
        same(found, wanted)
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.zarr"]


def test_job_that_ends_while_publishing_is_replaced_by_another(robot, wanted, small_blocks, monkeypatch, tmp_path):
    path = tmp_path / "map.zarr"
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(store.Store, "keep", lambda *arguments: (_ for _ in ()).throw(KeyboardInterrupt))
        ks.sweep(robot, GRID, out=path, part="1/1")
    assert not path.exists()
    with ks.sweep(robot, GRID, out=path, part="1/1") as found:
        same(found, wanted)


JOB = """
import sys, time
import numpy as np
import kinetostatics as ks
from kinetostatics.workspace import block, run
run.LEAST = run.MOST = 40
compute = block.compute_block

def slow(*arguments):
    time.sleep(float(sys.argv[3]))
    return compute(*arguments)

block.compute_block = slow
robot = ks.load_robot("five_bar", {"proximal_length": 0.28, "distal_length": 0.12})
grid = {"x": np.linspace(-0.3, 0.3, 16), "y": np.linspace(-0.4, 0.4, 21)}
print("ready", flush=True)
sys.stdin.readline()
print(ks.sweep(robot, grid, out=sys.argv[1], part=sys.argv[2]).attrs.get("missing_parts"))
"""


@pytest.mark.slow
def test_four_processes_at_once_of_which_one_is_killed(robot, wanted, small_blocks, tmp_path):
    path = tmp_path / "map.zarr"

    def job(part):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        pause = "1" if part == 2 else "0.05"  # long enough to be killed on a busy machine
        return subprocess.Popen([sys.executable, "-c", JOB, str(path), f"{part}/4", pause], **pipes)

    jobs = [job(part) for part in (1, 2, 3, 4)]
    for process in jobs:
        assert process.stdout.readline() == "ready\n"
    for process in jobs:
        process.stdin.write("go\n")
        process.stdin.flush()
    while not (tmp_path / "map.zarr.part").exists():
        time.sleep(0.01)
    jobs[1].send_signal(signal.SIGKILL)
    said = [process.communicate()[0].strip() for process in jobs]
    assert jobs[1].returncode == -signal.SIGKILL and not path.exists()
    assert min((said[k] for k in (0, 2, 3)), key=len) == "[2]"  # the last of them knows what is missing
    with ks.sweep(robot, GRID, out=path, part="2/4") as found:
        same(found, wanted)
    assert os.listdir(tmp_path) == ["map.zarr"]


@pytest.mark.slow
def test_script_for_slurm(tmp_path):
    """The script of docs/how_to/workspace.md, with a coarser grid and all jobs at once."""
    (script,) = (found.text for found in blocks(text_of("how_to/workspace")) if found.kind == "bash")
    assert script.count(":201") == 3 and "--array=1-20" in script
    (tmp_path / "job.sh").write_text(script.replace(":201", ":33"))
    path = f"{os.path.dirname(sys.executable)}{os.pathsep}{os.environ['PATH']}"
    slurm = {**os.environ, "PATH": path, "SLURM_CPUS_PER_TASK": "1", "SLURM_ARRAY_TASK_COUNT": "4"}
    jobs = [
        subprocess.Popen(["bash", "job.sh"], cwd=tmp_path, env={**slurm, "SLURM_ARRAY_TASK_ID": str(k)}, stdout=subprocess.PIPE)
        for k in (1, 2, 3, 4)
    ]
    said = [job.communicate()[0].decode() for job in jobs]
    assert all(job.returncode == 0 for job in jobs) and any("map.zarr will be complete after the parts" in text for text in said)
    with store.open_map(str(tmp_path / "map.zarr")) as found:
        assert found["status"].shape == (33, 33, 33) and bool(np.isfinite(found["twist"]).all())


@pytest.mark.parametrize("part", ["3", "0/4", "5/4", "a/b", 3])
def test_invalid_parts_are_refused(robot, tmp_path, part):
    with pytest.raises(ks.ArgumentError, match="it must be a number and a count such as '3/20'"):
        ks.sweep(robot, GRID, out=tmp_path / "map.zarr", part=part)


@pytest.mark.parametrize("options", [{}, {"out": "map.zarr", "restart": True}, {"out": "map.zarr", "reduce": {"x": "max"}}])
def test_parts_need_a_common_file(robot, options):
    with pytest.raises(ks.ArgumentError, match="part= needs out="):
        ks.sweep(robot, GRID, part="1/4", **options)


def test_file_systems_without_locks(robot, monkeypatch, tmp_path):
    def refused(*arguments):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(store.fcntl, "flock", refused)
    with pytest.raises(ks.KinetostaticsError, match=r"map.zarr.part.lock cannot be locked: Operation not supported"):
        ks.sweep(robot, GRID, out=tmp_path / "map.zarr", part="1/2")
    ks.sweep(robot, GRID, out=tmp_path / "map.zarr").close()  # alone it needs none
    monkeypatch.setattr(store, "fcntl", None)
    with pytest.raises(ks.KinetostaticsError, match="part= needs file locks, which this system lacks"):
        ks.sweep(robot, GRID, out=tmp_path / "other.zarr", part="1/2")
    ks.sweep(robot, GRID, out=tmp_path / "other.zarr").close()


def test_command_says_which_parts_are_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(run, "LEAST", 4)
    monkeypatch.setattr(run, "MOST", 4)
    line = "sweep 3rps --platform z=0.45:0.65:12 rx=0 ry=0 --out map.zarr --quiet --part".split()
    assert main([*line, "3/3"]) == 0
    assert capsys.readouterr().out == "part 3/3 is done; map.zarr will be complete after the parts 1, 2 of 3\n"
    assert main([*line, "1/3"]) == 0 and main([*line, "2/3"]) == 0
    assert capsys.readouterr().out.count("will be complete") == 1 and os.listdir() == ["map.zarr"]
