"""Code is made in a hurry at first, and anew and better when it computes much: the numbers stay."""

import sys
from pathlib import Path

import numpy as np
import package_robots
import pytest
from small_robots import cantilever, robot_of
from tapes import differences

from kinetostatics.engine import code
from kinetostatics.engine.loop_record import newton_record
from kinetostatics.engine.outputs import output_record
from kinetostatics.engine.record import example_of
from kinetostatics.engine.statics import CompiledStatics
from kinetostatics.statics.solution import solve

pytest.importorskip("llvmlite")


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A folder of the test's own, in which nobody has optimized anything."""
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "code"))
    monkeypatch.setattr(code, "HURRIES", True)
    return tmp_path / "code"


def poses(robot, N):
    frames = robot.example.take(np.zeros(N, dtype=np.intp))
    rng = np.random.default_rng(N)
    return frames, 100 * rng.standard_normal((6, N)), rng.standard_normal((3, N))


def test_code_that_computes_much_is_made_better(own, monkeypatch):
    monkeypatch.setattr(code, "MANY", 100)
    robot = robot_of(cantilever()).statics
    found = CompiledStatics(robot)
    for _ in range(200):  # one pose at a time: nobody wants to wait in the middle of that
        found.solve(*poses(robot, 1))
    found.solve(*poses(robot, 100))
    (path,) = own.iterdir()
    assert not found._code.is_optimized and not CompiledStatics.kept(robot)._code.is_optimized
    hurried, size, old = found.solve(*poses(robot, 1)), path.stat().st_size, found._code.function
    many = found.solve(*poses(robot, 20))
    assert found._code.is_optimized and found._code.function is not old and path.stat().st_size < size
    kept = CompiledStatics.kept(robot)
    assert kept._code.is_optimized
    for solution, N in ((hurried, 1), (many, 20), (found.solve(*poses(robot, 1)), 1), (kept.solve(*poses(robot, 20)), 20)):
        assert max(differences(solution, solve(robot, *poses(robot, N))).values()) < 1e-11
    found._code.optimize()
    assert len(found._code._machines) == 2


def test_where_stacks_are_small_code_is_never_made_in_a_hurry(own, monkeypatch):
    monkeypatch.setattr(code, "HURRIES", False)
    robot = robot_of(cantilever()).statics
    assert CompiledStatics(robot)._code.is_optimized and CompiledStatics.kept(robot)._code.is_optimized


def test_the_key_of_kept_code_tells_all_that_is_recorded(monkeypatch):
    """Whatever runs while a robot is recorded: a change of its text makes the code anew."""
    robot, folders = package_robots.robot("2pru_upr"), set()
    root = Path(code.__file__).parent.parent
    example, ready = robot.generic_poses.take(np.zeros(1, dtype=int)), robot.statics

    def note(frame, event, _):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(root) and path.parent != root:
            folders.add(path.relative_to(root).parts[0])

    sys.setprofile(note)
    try:
        output_record(ready, ["twist"], example_of(ready), all_vary=False)
        newton_record(robot.solver, robot.actuator_coordinates, example, 0)
    finally:
        sys.setprofile(None)
    assert {"statics", "kinematics", "limbs"} <= folders <= {*code._SOURCES, "printing"}
    # and what runs not, but is read: the table of joint types
    before, read = code._versions.__wrapped__(), Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" * (path.name == "joint_types.py"))
    assert code._versions.__wrapped__() != before
