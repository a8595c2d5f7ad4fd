"""Choice of the engine, which depends on the call alone."""

import gc
import sys
import weakref
from contextlib import nullcontext

import numpy as np
import package_robots
import pytest
from small_robots import cantilever, circle, robot_of

import kinetostatics as ks
from kinetostatics.engine import programs
from kinetostatics.engine.engine_report import engine_report
from kinetostatics.engine.pose_code import ANALYSIS, PoseCode

OVER, READ = {"x": [0.01, 0.02], "y": [0.3, 0.3]}, {"Fy": [-50, -60], "dx": [-1e-6, -2e-6]}


@pytest.fixture
def made(monkeypatch):
    """Robots whose code was compiled, and "looked" for each search on disk, which finds nothing."""
    found = []

    class Made:
        operations = 7

        def __init__(self, robot, statics, stages, places=None, anew=True):
            self.is_there = anew
            found.append(robot if anew else "looked")

    monkeypatch.setattr("kinetostatics.engine.pose_code.PoseCode", Made)
    return found


def code(robot, engine, poses):
    return programs.pose_code(robot, robot.statics, engine, poses)


def test_auto_compiles_by_number_of_poses(made):
    robots = [robot_of(cantilever(section=circle(d))) for d in (0.03, 0.04, 0.05)]
    for _ in range(20):
        assert code(robots[0], "auto", 999) is None and made == []
    for robot in robots:  # independent of other robots of the same structure
        assert code(robot, "auto", 9_999) is None
    assert made == ["looked"] * 3
    code(robots[0], "auto", 10_000)
    code(robots[0], "auto", 10_000)
    assert made == ["looked"] * 3 + [robots[0]]


def test_compilation_shows_a_waiting_message(made, monkeypatch):
    told, robot = [], robot_of(cantilever())
    monkeypatch.setattr(programs, "waiting", lambda what: told.append(what) or nullcontext())
    for poses in (999, 10_000, 10_000):
        code(robot, "auto", poses)
    assert told == [f"compiling code for {robot.name}, once on this computer"]


def test_single_pose_never_waits_for_compilation(made):
    robot = robot_of(cantilever())
    code(robot, "auto", 1)
    with programs._POSES[robot][None, False].lock:
        assert code(robot, "auto", 1) is None and made == []


@pytest.mark.slow
def test_robot_and_code_are_garbage_collected():
    robot = robot_of(cantilever())
    ks.analyze(robot.assemble(), engine="compiled")
    there = weakref.ref(robot)
    assert robot in programs._POSES
    del robot
    gc.collect()
    assert there() is None


def test_engine_compiled_always_compiles_and_numpy_never(made):
    robot = robot_of(cantilever())
    code(robot, "numpy", 10**9)
    assert made == []
    code(robot, "compiled", 1)
    assert made == [robot]


def test_environment_variable_sets_the_engine_of_auto(monkeypatch):
    assert programs.check_engine("auto") == "auto"
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "numpy")
    assert programs.check_engine("auto") == "numpy"
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "quick")
    with pytest.raises(ks.ArgumentError, match="KINETOSTATICS_ENGINE"):
        programs.check_engine("auto")


def test_engine_for_many_calls_counts_all_poses():
    found = {engine: [programs.engine_for(engine, poses) for poses in (9_999, 10_000)] for engine in programs.ENGINES}
    assert found == {"auto": ["auto", "compiled"], "compiled": ["compiled"] * 2, "numpy": ["numpy"] * 2}


def test_engine_report_states_compiled_operations():
    robot = robot_of(cantilever())
    report = engine_report(robot)
    assert report.is_compiled and report.reason is None and 50 < report.operations < 5000
    assert f"{report.operations:,} operations a pose" in str(report) and "closing the loops is compiled" in str(report)
    assert engine_report(robot).to_dict() == report.to_dict()
    assert PoseCode(robot, robot.statics, ANALYSIS, anew=False).operations == report.operations


def test_assembly_errors_are_left_to_numpy(made):
    robot = package_robots.robot("2pru_upr")
    pose = robot.assemble()
    assembly_errors = {"prismatic_1": [1e-4, 0, 0, 0, 0, 0]}
    found = ks.analyze(pose, assembly_errors=assembly_errors, engine="compiled")
    assert made == []
    np.testing.assert_array_equal(found.twist, ks.analyze(pose, assembly_errors=assembly_errors, engine="numpy").twist)


class Asked(Exception):
    """Raised with the engine that is asked to close the loops."""


@pytest.mark.parametrize(
    "analysed",
    [
        lambda pose: ks.compensate(pose, [0, -5, 0, 0, 0, 0], engine="numpy"),
        lambda pose: ks.sensitivities(pose, ["tool_mass"], ["twist"], engine="numpy", point=(0, 0, 0)),
        lambda _: ks.optimize("five_bar", {"tool_mass": "1:2"}, "mass", ["sag < 1 mm"], OVER, starts=1, engine="numpy"),
        lambda pose: ks.calibrate(pose.robot, {**OVER, **READ}, ["proximal_1.youngs_modulus"], engine="numpy"),
        lambda pose: ks.tolerances(pose, {"tool_mass": "1%"}, samples=10, engine="numpy", point=(0, 0, 0)),
    ],
)
def test_analyses_close_loops_by_the_given_engine(analysed, monkeypatch):
    """Analyses that close loops themselves: of corrected poses, of robots of an optimization, of changed robots."""
    pose = package_robots.robot("five_bar").assemble(platform={"x": 0.01, "y": 0.3})

    def asked(engine):
        raise Asked(engine)

    for module in [module for name, module in sys.modules.items() if name.startswith("kinetostatics.")]:
        if hasattr(module, "compiled_loops"):
            monkeypatch.setattr(module, "compiled_loops", asked)
    with pytest.raises(Asked, match=r"^numpy$"):
        analysed(pose)
