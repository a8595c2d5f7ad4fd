"""Compiled statics against NumPy for any number of poses, including unreached, singular and degenerate ones."""

import pickle

import numpy as np
import package_robots
import pytest
from small_robots import cantilever, circle, robot_of, stepped_beam
from tapes import assert_same_results, close, computed, differences, solved
from turned_limbs import coordinate, with_first_limb_turned

import kinetostatics as ks
from kinetostatics.engine import pose_code
from kinetostatics.engine.code import store
from kinetostatics.engine.engine_report import engine_report
from kinetostatics.engine.pose_code import ANALYSIS, PoseCode

NAME = "linear_delta"


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINETOSTATICS_CACHE", str(tmp_path_factory.getbasetemp() / "code"))
        return code_of(package_robots.robot(NAME))


def code_of(robot, **how):
    return PoseCode(robot, robot.statics, ANALYSIS, **how)


def is_kept(robot):
    return code_of(robot, anew=False).is_there


def example(robot):
    return robot.generic_poses.x[:, :1], np.ones((6, 1)), np.ones((3, 1))


def test_compiled_statics_equals_numpy_for_any_number_of_poses(compiled):
    """Generic poses, one whose canonical wrenches degenerate, one whose passive joints become dependent, one not reached."""
    robot = package_robots.robot(NAME)
    home = robot.assemble()
    height = float(home.platform["z"])
    q = np.array(robot.assemble(platform={"x": np.linspace(-0.08, 0.08, 21), "y": 0.1, "z": height}).model_q)
    q[:, [3, 6]] = home.model_q
    q[:, 3] = with_first_limb_turned(robot, q[:, 3])
    q[coordinate(robot, "upper_2_x"), 6] += np.pi / 2
    q[:, 9] = np.nan
    rng = np.random.default_rng(3)
    given = robot.equations.from_model(q), 100 * rng.standard_normal((6, 21)), rng.standard_normal((3, 21))
    whole, holds = computed(compiled, *given)
    wanted = solved(robot, *given)
    reached = np.isfinite(q[0])
    assert (
        wanted["basis_degenerate"][3] and wanted["doubtful"][6] and not np.isfinite(whole["contributions"][..., ~reached]).any()
    )
    assert np.flatnonzero(~holds).tolist() == [3, 6, 9]
    for some in ([0], [1, 2], list(range(3)), [4, 5, 7, 8, *range(10, 21)]):
        mine = [array[:, some] for array in given]
        found, _ = computed(compiled, *mine)
        worst = differences(found, solved(robot, *mine))
        assert max(worst.values(), default=0.0) < 1e-11, (some, worst)
        for name, array in whole.items():
            np.testing.assert_array_equal(found[name], array[..., some])


def test_ignored_guards_give_wrong_results(monkeypatch):
    """The record is wrong where a limb degenerates; its guards leave such poses to NumPy."""
    robot = package_robots.robot(NAME)
    q = np.repeat(robot.assemble().model_q, 2, axis=1)
    q[:, 1] = with_first_limb_turned(robot, q[:, 1])
    pose = robot.configuration(q.T, closure_tolerance=np.inf)
    assert ks.analyze(pose, engine="compiled").basis_degenerate.tolist() == [False, True]
    right = PoseCode.computed

    def heedless(*given, **how):
        numbers, truths = right(*given, **how)
        truths[0] = True
        return numbers, truths

    monkeypatch.setattr(PoseCode, "computed", heedless)
    assert ks.analyze(pose, engine="compiled").basis_degenerate.tolist() == [False, False]


def test_engines_agree_on_a_batch(compiled, monkeypatch):
    """Statuses, facts, joint wrenches and beams at poses in and out of reach."""
    robot = package_robots.robot(NAME)
    x = np.linspace(-0.6, 0.6, 24)
    poses = robot.assemble(platform={"x": x, "y": 0.1, "z": float(robot.assemble().platform["z"])}, on_failure="nan")
    load = [10, 20, -300, 4, 5, 6]
    found, wanted = (ks.analyze(poses, load, engine=engine) for engine in ("compiled", "numpy"))
    assert 2 in wanted.status and (wanted.status < 2).sum() > 3
    assert_same_results(found, wanted)
    for name, beam in wanted.beams.items():
        close(found.beams[name].stress, beam.stress, 1e-10)


def test_results_of_many_poses_are_computed_on_demand(cache):
    """First the twist alone, then all other results, also of a pickled copy."""
    robot = robot_of(cantilever())
    poses = robot.configuration(np.repeat(robot.assemble().q[None], 700, axis=0))
    load = 100 * np.random.default_rng(4).standard_normal((700, 6))
    found, wanted = (ks.analyze(poses, load, engine=engine) for engine in ("compiled", "numpy"))
    close(found.twist, wanted.twist, 1e-10)
    (part,) = found.chunks
    assert "solutions" not in vars(part) and part._stage == 0
    for result in (pickle.loads(pickle.dumps(found)), found):
        assert_same_results(result, wanted)
        close(result.limbs["limb_1"].intensities, wanted.limbs["limb_1"].intensities, 1e-10)
    assert part._stage == 1 and found.solutions == part.solutions


def test_robots_of_different_diameters_share_code(cache):
    thin, thick = robot_of(cantilever()), robot_of(cantilever(section=circle(0.08)))
    first = code_of(thin)
    kept = sorted(cache.iterdir())
    found = code_of(thick, anew=False)
    assert found.is_there and sorted(cache.iterdir()) == kept
    twists = [computed(item, *example(thick))[0]["contributions"] for item in (first, found)]
    np.testing.assert_allclose(twists[1], solved(thick, *example(thick))["contributions"], rtol=1e-12)
    assert np.max(np.abs(twists[1])) < 0.5 * np.max(np.abs(twists[0]))


def test_cached_code_of_another_robot_is_rejected(cache, monkeypatch):
    """Code in the cache under a wrong key: its sizes are checked, then its results at an example."""
    one, other = (robot_of(spec) for spec in (cantilever(), cantilever(direction=(0.6, 0.0, 0.8))))
    more = robot_of(stepped_beam())
    monkeypatch.setattr(pose_code, "code_key", lambda structure: "0" * 64)
    code_of(one)
    assert is_kept(one)
    for robot in (other, more):
        assert not is_kept(robot)
    assert max(differences(computed(code_of(more), *example(more))[0], solved(more, *example(more))).values()) < 1e-11


def wrong_record(*given):
    """Return a record one of whose products is a sum."""
    record = right_record(*given)
    k = max(k for k in record.all_rows() if record.tape.operations[k][0] == "multiply")
    record.tape.operations[k] = ("add", *record.tape.operations[k][1:])
    return record


right_record = pose_code.pose_record


def test_cached_code_of_another_version_or_processor_is_rejected(cache, monkeypatch):
    """Its key differs; wrong code under the right key is detected by an example, and compiled anew."""
    robot = robot_of(cantilever())
    sound = code_of(robot)
    for name in ("kinetostatics.engine.code._versions", "kinetostatics.engine.llvm.processor"):
        with monkeypatch.context() as other:
            other.setattr(name, lambda: "another")
            assert not is_kept(robot)
    path = cache / f"{sound._key}.code"
    right = path.read_bytes()
    with monkeypatch.context() as wrong:
        wrong.setattr(pose_code, "pose_record", wrong_record)
        model, given = pose_code.pose_model(robot, robot.statics, ANALYSIS)
        store(sound._key, pose_code.compiled(model, ANALYSIS, given, sound._sizes))
    assert path.read_bytes() != right and not is_kept(robot)
    code_of(robot)
    assert path.read_bytes() == right


def test_wrongly_compiled_code_is_replaced_by_numpy(monkeypatch):
    """A wrong operation is detected when the code is compiled."""
    robot = robot_of(cantilever())
    monkeypatch.setattr(pose_code, "pose_record", wrong_record)
    monkeypatch.setattr(pose_code, "code_key", lambda structure: "1" * 64)
    report = engine_report(robot)
    assert not report.is_compiled and "differ from NumPy's" in str(report)
    pose = robot.assemble()
    np.testing.assert_array_equal(ks.analyze(pose, engine="compiled").twist, ks.analyze(pose, engine="numpy").twist)
