"""Compiled code gives what NumPy gives, for any number of poses, also where poses are not reached, singular or special."""

import gc
import pickle
from dataclasses import replace

import numpy as np
import package_robots
import pytest
from small_robots import Beam, Joint, Limb, Link, Spec, cantilever, circle, robot_of, stepped_beam
from tapes import differences

import kinetostatics as ks
from kinetostatics.engine import cache as disk
from kinetostatics.engine import record, statics
from kinetostatics.engine.record import arrays_of, record_of
from kinetostatics.engine.report import engine_report
from kinetostatics.engine.statics import CompiledStatics
from kinetostatics.statics.springs import solve_with_springs as solve

NAME = "linear_delta"


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINETOSTATICS_CACHE", str(tmp_path_factory.getbasetemp() / "code"))
        return CompiledStatics(package_robots.robot(NAME).statics)


def test_any_number_of_poses_reached_or_not_special_or_not(compiled):
    """Generic poses, one whose canonical wrenches degenerate, one whose passive joints become dependent, one not reached."""
    robot = package_robots.robot(NAME)
    q = np.repeat(robot.assemble().model_q, 21, axis=1)
    q += 0.05 * np.random.default_rng(2).standard_normal(q.shape) * ~np.isin(np.arange(21), (3, 6))
    q[1, 3] += np.pi / 2
    q[7, 6] += np.pi / 2
    q[:, 9] = np.nan
    rng = np.random.default_rng(3)
    load, gravity = 100 * rng.standard_normal((6, 21)), rng.standard_normal((3, 21))
    frames = robot.mechanism.forward(q)
    whole = compiled.solve(frames, load, gravity)
    wanted = solve(robot.statics, frames, load, gravity)
    reached = np.isfinite(q[0])
    assert wanted.basis_degenerate[3] and wanted.statics[0].doubtful[:, 6].any()
    assert not np.isfinite(whole.twists[..., ~reached]).any()
    for poses in (np.flatnonzero(reached), [0], [1, 2], [3], [6], list(range(8)), [*range(9), *range(10, 17)]):
        here = frames.take(np.array(poses))
        found = compiled.solve(here, load[:, poses], gravity[:, poses])
        right = solve(robot.statics, here, load[:, poses], gravity[:, poses])
        np.testing.assert_array_equal(found.singular, right.singular)
        regular = np.flatnonzero(~right.singular)  # elsewhere numbers are nothing but rounding, divided by rounding
        worst = differences(found, right, regular)
        assert max(worst.values(), default=0.0) < 1e-11, (poses, worst)
        size = np.nanmax(np.abs(right.twists[..., regular]), initial=0.0)
        close_by = whole.twists[..., poses][..., regular]
        np.testing.assert_allclose(found.twists[..., regular], close_by, rtol=0, atol=1e-11 * size)


def test_guards_that_nobody_heeds_are_noticed(compiled, monkeypatch):
    """What the record says where it does not hold, at a limb that degenerates, is wrong: so NumPy computes there."""
    robot = package_robots.robot(NAME)
    q = np.repeat(robot.assemble().model_q, 2, axis=1)
    q[1, 1] += np.pi / 2
    pose = robot.mechanism.forward(q), np.ones((6, 2)), np.ones((3, 2))
    wanted = solve(robot.statics, *pose)
    assert max(differences(compiled.solve(*pose), wanted).values()) < 1e-11 and wanted.basis_degenerate.tolist() == [False, True]
    right = CompiledStatics._computed

    def heedless(*given, **how):
        numbers, truths = right(*given, **how)
        truths[0] = True
        return numbers, truths

    monkeypatch.setattr(CompiledStatics, "_computed", heedless)
    assert compiled.solve(*pose).basis_degenerate.tolist() == [False, False]


def test_both_engines_say_the_same_of_a_batch(compiled, monkeypatch):
    """Statuses, facts, joint wrenches, beams: of poses some of which are not reached."""
    robot = package_robots.robot(NAME)
    x = np.linspace(-0.6, 0.6, 24)
    poses = robot.assemble(platform={"x": x, "y": 0.1, "z": float(robot.assemble().platform["z"])}, on_failure="nan")
    load = [10, 20, -300, 4, 5, 6]
    found, wanted = (ks.analyze(poses, load, engine=engine) for engine in ("compiled", "numpy"))
    assert found.status.tolist() == wanted.status.tolist() and 2 in wanted.status and (wanted.status < 2).sum() > 3
    for name in ("twist", "stiffness", "base_wrench", "strain_energy"):
        close(getattr(found, name), getattr(wanted, name))
    for name in ("contributions", "joint_wrenches", "actuator_forces"):
        for key, value in getattr(wanted, name).items():
            np.testing.assert_array_equal(np.isnan(value), np.isnan(getattr(found, name)[key]))
        close(*(list(getattr(result, name).values()) for result in (found, wanted)))
    for name, beam in wanted.beams.items():
        close(found.beams[name].stress, beam.stress)


def test_of_many_poses_most_is_computed_when_it_is_asked_for(cache):
    """Nothing but the twist first; then all the rest, also of a copy and of one that was sent elsewhere."""
    robot = robot_of(cantilever())
    poses = robot.configuration(np.repeat(robot.assemble().q[None], 700, axis=0))
    load = 100 * np.random.default_rng(4).standard_normal((700, 6))
    found, wanted = (ks.analyze(poses, load, engine=engine) for engine in ("compiled", "numpy"))
    close(found.twist, wanted.twist)
    (part,) = found._found
    assert "whole" not in vars(part)
    for result in (pickle.loads(pickle.dumps(found)), found):
        assert result.status.tolist() == wanted.status.tolist()
        for name in ("stiffness", "base_wrench", "strain_energy"):
            close(getattr(result, name), getattr(wanted, name))
        for name, wrench in wanted.joint_wrenches.items():
            close(result.joint_wrenches[name], wrench)
        close(result.limbs["limb_1"].intensities, wanted.limbs["limb_1"].intensities)
    assert "whole" in vars(part) and found.solutions == (part.whole,)


def close(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.nanmax(np.abs(wanted)))


def test_a_solution_is_gone_when_nobody_has_it(compiled):
    """Nothing is left to be collected, which would take a third of the time of a single pose; its limbs know what it knew."""
    robot = package_robots.robot(NAME)
    given = robot.zero_frames, np.ones((6, 1)), np.ones((3, 1))
    limbs = compiled.solve(*given).whole.statics
    np.testing.assert_array_equal(limbs[0].C, compiled.solve(*given).whole.statics[0].C)
    gc.disable()
    try:
        left = []
        for _ in range(3):  # what other tests have left may take several collections
            gc.collect()
            compiled.solve(*given).twists.sum()
            left.append(gc.collect())
        assert min(left) == 0
    finally:
        gc.enable()


def test_a_changed_diameter_or_mass_takes_the_same_code(cache):
    thin = robot_of(cantilever()).statics
    first = CompiledStatics(thin)
    kept = sorted(cache.iterdir())
    thick = robot_of(cantilever(section=circle(0.08))).statics
    found = CompiledStatics.kept(thick)
    assert found is not None and sorted(cache.iterdir()) == kept
    pose = thick.example, np.ones((6, 1)), np.ones((3, 1))
    twists = found.solve(*pose).twists
    np.testing.assert_allclose(twists, solve(thick, *pose).twists, rtol=1e-12)
    assert np.max(np.abs(twists)) < 0.5 * np.max(np.abs(first.solve(*pose).twists))


def test_code_of_another_robot_is_not_taken(cache, monkeypatch):
    """A stale cache, whatever made it so: the code is tried on an example, and its sizes are looked at before."""
    one, other = (robot_of(spec).statics for spec in (cantilever(), cantilever(direction=(0.6, 0.0, 0.8))))
    more = robot_of(stepped_beam()).statics
    monkeypatch.setattr(statics, "code_key", lambda structure: "0" * 64)
    CompiledStatics(one)
    assert CompiledStatics.kept(one) is not None
    for robot in (other, more):
        assert CompiledStatics.kept(robot) is None
    pose = more.example, np.ones((6, 1)), np.ones((3, 1))
    assert max(differences(CompiledStatics(more).solve(*pose), solve(more, *pose)).values()) < 1e-11


def wrong_record(model, places=None):
    """Return a record one of whose products is a sum."""
    record = record_of(model, places)
    k = max(k for k in record.numbers if record.tape.operations[k][0] == "multiply")
    record.tape.operations[k] = ("add", *record.tape.operations[k][1:])
    return record


def test_code_of_another_version_or_processor_is_not_taken(cache, monkeypatch):
    """It has another name; and whatever stands under the right one is tried: wrong code is made anew."""
    robot = robot_of(cantilever()).statics
    sound = CompiledStatics(robot)
    for name in ("kinetostatics.engine.code._versions", "kinetostatics.engine.llvm.processor"):
        with monkeypatch.context() as other:
            other.setattr(name, lambda: "another")
            assert CompiledStatics.kept(robot) is None
    path = cache / f"{sound._key}.code"
    right = path.read_bytes()
    bodies = robot.example.position.shape[1]
    disk.write(sound._key, statics._compiled(wrong_record(robot), len(sound._parameters), bodies))
    assert path.read_bytes() != right and CompiledStatics.kept(robot) is None
    CompiledStatics(robot)
    assert path.read_bytes() == right


def test_an_o_that_is_nothing_but_rounding_is_no_difference(cache, monkeypatch):
    """A platform that turns about the world's origin alone: its o is 1e-16 m beside it, and code is not refused for that."""
    turns = [
        Joint(f"turn_{k}", "R", (0.0, 0.0, 0.0), axis, driven=True) for k, axis in ((1, (0.6, 0.0, 0.8)), (2, (0.0, 1.0, 0.0)))
    ]
    limb = Limb((*turns, Joint("tip", "F", (0.48, 0.1, 0.36))), (Link("inner"), Link("arm")))
    beam = Beam("arm", "arm", "turn_2", "tip", circle(0.05))
    origin = (0.0, 0.0, 0.0)
    robot = robot_of(Spec((limb,), (beam,), o=origin, com=origin), twirl=1).statics
    example = record.example_of(robot)
    assert 0 < np.max(np.abs(solve(robot, *example).o)) < 1e-15
    CompiledStatics(robot)
    for shift, right in ((3e-16, True), (1e-6, False)):
        moved = lambda *given, by=shift: replace(record.by_numpy(*given), o=record.by_numpy(*given).o + by)  # noqa: E731
        monkeypatch.setattr(statics, "by_numpy", moved)
        assert (CompiledStatics.kept(robot) is not None) == right


def test_code_that_is_wrong_is_not_used(monkeypatch):
    """A wrong operation is noticed when the code is made: NumPy computes then."""
    robot = robot_of(cantilever())
    monkeypatch.setattr(statics, "record_of", wrong_record)
    monkeypatch.setattr(statics, "code_key", lambda structure: "1" * 64)
    report = engine_report(robot)
    assert not report.is_compiled and "other numbers than NumPy" in str(report)
    pose = robot.assemble()
    np.testing.assert_array_equal(ks.analyze(pose, engine="compiled").twist, ks.analyze(pose, engine="numpy").twist)


def test_solutions_are_taken_apart_completely():
    """Every array of a solution that is not given has a path."""
    robot = package_robots.robot(NAME).statics
    paths = arrays_of(solve(robot, robot.example, np.ones((6, 1)), np.ones((3, 1))))
    assert {path.split(".")[1] for path in paths} >= {"twists", "statics", "unbalanced", "open", "undetermined", "singular", "o"}
