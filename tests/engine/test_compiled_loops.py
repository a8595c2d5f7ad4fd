"""Compiled code closes loops as NumPy does: the same poses and the same statuses, near and far, in reach and out of it."""

import pickle

import numpy as np
import pytest
from package_robots import robot as robot_named

from kinetostatics import analyze
from kinetostatics.engine import code, loops, programs
from kinetostatics.engine.loop_record import Program
from kinetostatics.engine.loops import CompiledSolver

#: Robot, kind of the given coordinates, orientation, and ranges of the coordinates, far beyond reach and limits.
CASES = [
    ("five_bar", "platform", None, {"x": (-0.5, 0.5), "y": (-0.4, 0.9)}),
    ("planar_3rrr", "actuators", None, {f"motor_{k}": (-1.0, 1.0) for k in (1, 2, 3)}),
    ("3rps", "platform", "tilt_torsion", {"z": (0.1, 1.3), "azimuth": (-4.0, 4.0), "tilt": (0.0, 2.0)}),
]


def both(robot, **given):
    """Return poses by compiled code and by NumPy."""
    return [robot.assemble(**given, on_failure="nan", engine=engine) for engine in ("compiled", "numpy")]


def assert_same(found, wanted):
    np.testing.assert_array_equal(found.status, wanted.status)
    for name in ("q", "platform_frame"):
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), rtol=0, atol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "kind", "orientation", "box"), CASES)
def test_both_engines_reach_the_same_poses(name, kind, orientation, box, monkeypatch):
    """Random poses, each on its own line: in reach, beyond limits, out of reach; from the zero pose and from another one."""
    robot = robot_named(name)
    random = np.random.default_rng(3)
    given = {key: random.uniform(*ends, 60) for key, ends in box.items()}
    found, wanted = both(robot, **{kind: given}, orientation=orientation)
    assert len(set(wanted.status.tolist())) > 1 and np.sum(wanted.reached) > 3
    assert_same(found, wanted)
    inside = np.flatnonzero(wanted.reached)
    near = robot.assemble(**{kind: {key: value[inside[0]] for key, value in given.items()}}, orientation=orientation)
    aim = {key: value[inside[1:4]] for key, value in given.items()}
    assert_same(*both(robot, **{kind: aim}, orientation=orientation, near=near))
    # compiled code found them
    used = []

    def nowhere(solver, poses, target, before, passing):
        used.append(poses)
        return poses, np.zeros(target.shape[1], dtype=bool), np.ones(target.shape[1], dtype=bool)

    monkeypatch.setattr(CompiledSolver, "_corrected", nowhere)
    assert not both(robot, **{kind: given}, orientation=orientation)[0].reached.any() and used


def solver_of(robot):
    prescribed = robot.mobility_analysis.with_dofs(robot.actuator_coordinates)
    example = robot.generic_poses.take(np.array([0]))
    return CompiledSolver(robot.solver, prescribed, example), prescribed


def test_frames_of_many_poses_are_computed_on_demand(monkeypatch):
    """Statics take frames block by block; where the record does not hold, NumPy computes them."""
    robot, random = robot_named("five_bar"), np.random.default_rng(4)
    zero = robot.assemble().platform
    found, wanted = both(robot, platform={name: zero[name] + random.uniform(-0.03, 0.03, 700) for name in "xy"})
    twists = [analyze(pose, engine=engine).twist for pose, engine in ((found, "compiled"), (wanted, "numpy"))]
    np.testing.assert_allclose(*twists, rtol=1e-9, atol=1e-18)
    assert "known" not in vars(found.frames)

    class Doubtful(code.Bound):
        def __call__(self):
            super().__call__()
            *_, numbers, truths = self._kept
            numbers[:, ::3], truths[:, ::3] = np.nan, False

    few, many = np.arange(7, 12), np.arange(50, 690)
    taken = found.frames.take(many)
    with monkeypatch.context() as patch:
        patch.setattr(code, "Bound", Doubtful)
        pairs = [(taken, wanted.frames.take(many)), (pickle.loads(pickle.dumps(found.frames)), wanted.frames)]
        assert all(np.isfinite(frames.rotation).all() for frames, _ in pairs)
    for frames, others in (
        *pairs,
        (found.frames.take(few), wanted.frames.take(few)),
        (taken.take(few), wanted.frames.take(few + 50)),
    ):
        np.testing.assert_allclose(frames.rotation, others.rotation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(frames.position, others.position, rtol=0, atol=1e-12)


def test_near_pose_is_found_directly_far_pose_along_line(monkeypatch):
    robot, goes = robot_named("five_bar"), []
    known = CompiledSolver.in_one_go
    monkeypatch.setattr(CompiledSolver, "in_one_go", lambda *given: goes.append(known(*given)) or goes[-1])
    zero = robot.assemble().platform
    for shift, quickly in ((0.01, True), (-0.03, True), (1.0, False)):
        goes.clear()
        assert_same(*both(robot, platform={"x": float(zero["x"]) + shift, "y": float(zero["y"])}))
        assert [item is not None for item in goes] == [quickly] * len(goes) and bool(goes) == (shift < 1)


def test_wrong_loop_code_and_other_robots_code_are_rejected(monkeypatch):
    """A wrong operation is detected when the code is compiled, another robot's code by its sizes or an example."""
    robot = robot_named("five_bar")
    functions = loops._FUNCTIONS
    name, right, *sizes = functions[0]
    monkeypatch.setattr(loops, "code_key", lambda text: "2" * 63 + str(len(text.split()[0]) % 10))

    def wrong(*given):
        program = right(*given)
        operations = program.tape.operations
        k = max(k for k in range(len(operations)) if operations[k][0] == "sine")
        operations[k] = ("cosine", *operations[k][1:])
        return Program(program.tape, program.numbers, program.truths)

    monkeypatch.setattr(loops, "_FUNCTIONS", ((name, wrong, *sizes), *functions[1:]))
    with pytest.raises(loops.NotRecordedError, match="differs from NumPy"):
        solver_of(robot)
    monkeypatch.setattr(loops, "_FUNCTIONS", functions)
    _, prescribed = solver_of(robot)
    example = robot.generic_poses.take(np.array([0]))
    assert CompiledSolver(robot.solver, prescribed, example, anew=False).is_there
    other = robot_named("planar_3rrr")
    given = other.mobility_analysis.with_dofs(other.actuator_coordinates)
    assert not CompiledSolver(other.solver, given, other.generic_poses.take(np.array([0])), anew=False).is_there


def test_auto_compiles_loops_by_number_of_poses(monkeypatch):
    robot = robot_named("five_bar")
    made = []

    def init(self, solver, prescribed, example, anew):
        vars(self).update(vars(solver), is_there=anew)
        made.append("made" if anew else "looked")

    monkeypatch.setattr(programs, "_LOOPS", type(programs._LOOPS)())
    monkeypatch.setattr(loops.CompiledSolver, "__init__", init)
    chosen = programs.compiled_loops("auto")
    given = robot.actuator_coordinates
    for _ in range(20):
        assert chosen(robot, given, 999) is robot.solver and made == []
    assert chosen(robot, given, 9_999) is robot.solver and made == ["looked"]
    assert chosen(robot, given, 10_000) is not robot.solver and made == ["looked", "made"]
    assert chosen(robot, given, 1) is not robot.solver and made == ["looked", "made"]  # it is in memory
    assert programs.compiled_loops("numpy")(robot, given, 10**9) is robot.solver


def test_missing_step_and_line_start_code_has_fallbacks(monkeypatch):
    robot = robot_named("five_bar")
    (solver, prescribed), start = solver_of(robot), robot.generic_poses.take(np.array([0]))
    target = robot.solver.values(prescribed, start) + 0.01
    monkeypatch.setattr(loops, "found_or_made", lambda *_: [])
    assert solver._start is None
    for found, expected in zip(solver.line(prescribed, start, target), robot.solver.line(prescribed, start, target), strict=True):
        np.testing.assert_array_equal(found, expected)
    moved, step = solver.single_step()
    assert step(np.concatenate([start.x, start.c]), target) and moved.shape[1] > 1
    np.testing.assert_allclose(moved[:-3, :1], robot.solver.newton(prescribed, start, target)[0].x, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("method", "flag"), [("_corrected", 1), ("_corrected", 2), ("_placed", 1)])
def test_code_whose_guards_fail_at_its_own_example_is_refused(monkeypatch, method, flag):
    """Its numbers may be right there, but it would never be used, or say of a closed pose that it is open."""
    robot, right = robot_named("five_bar"), getattr(CompiledSolver, method)

    def doubtful(*given):
        results = list(right(*given))
        results[flag] = ~results[flag]
        return tuple(results)

    assert solver_of(robot)[0].is_there
    monkeypatch.setattr(CompiledSolver, method, doubtful)
    with pytest.raises(loops.NotRecordedError, match="differs from NumPy"):
        solver_of(robot)


def test_line_starts_whose_guards_fail_at_the_example_are_left_to_numpy(monkeypatch):
    right = CompiledSolver._started

    def doubtful(*given):
        *numbers, holds = right(*given)
        return *numbers, ~holds

    solver, other = (solver_of(robot_named("five_bar"))[0] for _ in range(2))
    assert solver._start is not None
    monkeypatch.setattr(CompiledSolver, "_started", doubtful)
    assert other._start is None


@pytest.mark.parametrize("error", [1e-11, 1e-8])
def test_loop_code_may_differ_from_numpy_by_rounding_only(monkeypatch, error):
    robot, right = robot_named("five_bar"), CompiledSolver._corrected

    def shifted(*given):
        found, *flags = right(*given)
        found.x[0] += error
        return found, *flags

    monkeypatch.setattr(CompiledSolver, "_corrected", shifted)
    if error < 1e-9:
        assert solver_of(robot)[0].is_there
    else:
        with pytest.raises(loops.NotRecordedError, match="differs from NumPy"):
            solver_of(robot)
