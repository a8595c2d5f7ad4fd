"""Which engine is taken: what is asked for, what is installed, and whether it pays."""

import gc
import weakref

import numpy as np
import package_robots
import pytest
from small_robots import cantilever, circle, robot_of

import kinetostatics as ks
from kinetostatics.engine import choice
from kinetostatics.engine.statics import CompiledStatics


@pytest.fixture
def made(monkeypatch):
    """Robots whose code was made or found, in turn; none is ever found on disk."""
    pytest.importorskip("llvmlite")
    found = []

    class Made:
        operations = 7

        def __init__(self, robot, places=None):
            found.append(robot)
            self.solve = None

        kept = staticmethod(lambda robot, structure, places: found.append("looked"))

    monkeypatch.setattr("kinetostatics.engine.statics.CompiledStatics", Made)
    monkeypatch.setattr(choice, "_WORK", {})
    return found


def test_auto_looks_and_compiles_when_it_has_paid(made):
    robot = robot_of(cantilever()).statics
    assert choice.compiled_solver(robot, "auto", 1) is None and made == []
    for _ in range(12):
        choice.compiled_solver(robot, "auto", 1)
    assert made == ["looked"]
    choice.compiled_solver(robot, "auto", 100_000)
    assert made == ["looked"]
    choice.compiled_solver(robot, "auto", 200_000)
    assert made == ["looked", robot]
    choice.compiled_solver(robot, "auto", 200_000)
    assert made == ["looked", robot]


def test_nobody_waits_while_code_is_made_elsewhere(made):
    """As behind a live page: what is to be done now is done by NumPy, unless compiled code was asked for."""
    robot = robot_of(cantilever()).statics
    with choice._choice_of(robot).lock:
        assert choice.compiled_solver(robot, "auto", 10**6) is None and made == []
    choice.compiled_solver(robot, "auto", 10**6)
    assert made == ["looked", robot]


def test_robots_of_one_structure_count_together(made):
    """As those of a sweep over diameters, of which each has few poses; each looks for what the one before has left."""
    robots = [robot_of(cantilever(section=circle(d))).statics for d in (0.03, 0.04, 0.05)]
    for robot in robots:
        assert choice.compiled_solver(robot, "auto", 100_000) is None
    assert made == ["looked"] * 3 + [robots[2]]


@pytest.mark.slow
def test_a_robot_is_forgotten_with_its_code():
    pytest.importorskip("llvmlite")
    robot = robot_of(cantilever())
    ks.analyze(robot.assemble(), engine="compiled")
    there = weakref.ref(robot.statics)
    assert robot.statics in choice._CHOICES
    del robot
    gc.collect()
    assert there() is None


def test_compiled_compiles_at_once_and_numpy_never(made):
    robot = robot_of(cantilever()).statics
    choice.compiled_solver(robot, "numpy", 10**9)
    assert made == []
    choice.compiled_solver(robot, "compiled", 1)
    assert made == [robot]


def test_the_environment_says_what_auto_means(monkeypatch):
    assert choice.check_engine("auto") == "auto"
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "numpy")
    assert choice.check_engine("auto") == "numpy"
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "quick")
    with pytest.raises(ks.ArgumentError, match="KINETOSTATICS_ENGINE"):
        choice.check_engine("auto")


def test_without_llvmlite_numpy_computes(monkeypatch):
    monkeypatch.setattr(choice, "is_installed", lambda: False)
    robot = robot_of(cantilever())
    pose = robot.assemble()
    with pytest.raises(ks.ArgumentError, match=r"pip install 'kinetostatics\[fast\]'"):
        ks.analyze(pose, engine="compiled")
    assert choice.compiled_solver(robot.statics, "auto", 10**9) is None
    report = ks.engine_report(robot)
    assert not report.is_compiled and report.operations is None and "llvmlite is not installed" in str(report)
    assert report.to_dict()["by_numpy"][:2] == ["the equilibrium of poses", "closing the loops"]
    with pytest.raises(ks.ArgumentError, match="engine"):
        ks.analyze(pose, engine="fast")


def test_a_report_says_what_is_compiled():
    pytest.importorskip("llvmlite")
    robot = robot_of(cantilever())
    report = ks.engine_report(robot)
    assert report.is_compiled and report.reason is None and 50 < report.operations < 5000
    assert f"{report.operations:,} operations a pose" in str(report) and "closing the loops is compiled" in str(report)
    assert ks.engine_report(robot).to_dict() == report.to_dict()
    assert CompiledStatics.kept(robot.statics).operations == report.operations


def test_misfits_are_left_to_numpy(made):
    robot = package_robots.robot("2pru_upr")
    pose = robot.assemble()
    misfits = {"prismatic_1": [1e-4, 0, 0, 0, 0, 0]}
    found = ks.analyze(pose, misfits=misfits, engine="compiled")
    assert made == []
    np.testing.assert_array_equal(found.twist, ks.analyze(pose, misfits=misfits, engine="numpy").twist)


def test_whatever_analyses_closes_its_loops_by_the_same_engine(monkeypatch):
    """Each closes loops anew: corrected poses, the robots of an optimization, and others of the same file."""
    asked, robot = [], package_robots.robot("3rps")
    loops = choice.compiled_loops
    monkeypatch.setattr(choice, "compiled_loops", lambda engine: asked.append(engine) or loops("numpy"))
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.1})
    differenced = {"engine": "numpy", "point": (0, 0, 0)}
    over, read = {"z": [0.5, 0.6], "rx": [0.1, 0.1], "ry": [0.0, 0.0]}, {"Fz": [-500, -600], "dz": [-1e-6, -2e-6]}
    for analysed in (
        lambda: ks.compensate(pose, [0, 0, -500, 0, 0, 0], engine="numpy"),
        lambda: ks.sensitivities(pose, ["youngs_modulus"], ["twist"], **differenced),
        lambda: ks.optimize("3rps", {"rod_diameter": "19mm:20mm"}, "mass", ["sag < 1 mm"], over, starts=1, engine="numpy"),
        lambda: ks.calibrate(robot, {**over, **read}, ["rod_1.youngs_modulus"], engine="numpy"),
        lambda: ks.spread(pose, {"youngs_modulus": "1%"}, robots=10, **differenced),
    ):
        asked.clear()
        analysed()
        assert asked and set(asked) == {"numpy"}
