"""Functions in compiled code against NumPy at poses in and out of reach, one by one and in batches."""

import copy
import pickle

import numpy as np
import package_robots
import pytest
from telescopes import mast

import kinetostatics as ks
from kinetostatics.engine import loops
from kinetostatics.functions.compiled import CompiledFunction
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.rotations import Orientation

OUTPUTS = ("twist", "actuator_forces", "stiffness", "actuators")
#: Coordinates of the platform, None: the actuators; orientation, and how far poses are away from the zero pose [m, rad].
KINDS = {
    "3rps": (("z", "rx", "ry"), None, 0.5),
    "2pru_upr": (("z", "rx", "ry"), "xyz", 0.5),
    "five_bar": (None, None, 0.9),
    "ur10": (None, None, 7.0),
}
#: The quick ones, and one that takes long to compile.
NAMES = [pytest.param(name, marks=pytest.mark.slow) if name == "3rps" else name for name in KINDS]
POSES = 24
LOAD = (30.0, -40.0, -500.0, 3.0, 4.0, 5.0)


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINETOSTATICS_CACHE", str(tmp_path_factory.mktemp("code")))
        yield patch


_MADE = {}


def functions(name):
    """Return a function by compiled code and the same by NumPy, and inputs of poses in and out of reach."""
    if name not in _MADE:
        platform, orientation, far = KINDS[name]
        robot = package_robots.robot(name)
        made = [ks.compile(robot, platform, orientation=orientation, outputs=OUTPUTS, engine=e) for e in ("compiled", "numpy")]
        zero = robot.assemble()
        here = zero.actuators if platform is None else zero.platform_coordinates(orientation)
        rng = np.random.default_rng(5)
        spans = np.where(np.arange(POSES) % 3 == 0, far, min(0.2 * far, 0.6))
        own = [key for key in made[0].inputs if key not in ("load", "gravity")]
        at = {key: float(here[key]) + spans * rng.uniform(-1, 1, POSES) for key in own}
        _MADE[name] = *made, at, rng.uniform(-100, 100, (POSES, 6)), rng.uniform(-10, 10, (POSES, 3))
    return _MADE[name]


def assert_alike(found, wanted):
    assert list(found) == list(wanted)
    np.testing.assert_array_equal(found["status"], wanted["status"])
    for name in OUTPUTS:
        assert found[name].shape == wanted[name].shape
        assert np.array_equal(np.isnan(found[name]), np.isnan(wanted[name]))
        scale = np.nanmax(np.abs(wanted[name]), initial=1e-20) if np.size(wanted[name]) else 1.0
        np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=1e-11 * scale)
    assert np.array_equal(np.isnan(found["residual"]), np.isnan(wanted["residual"]))
    np.testing.assert_allclose(found["residual"], wanted["residual"], rtol=0, atol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", NAMES)
def test_compiled_batch_equals_numpy(name):
    f, g, at, load, gravity = functions(name)
    wanted = g(**at, load=load, gravity=gravity)
    assert f._compiled is not None and len(set(wanted["status"].tolist())) > 1
    assert_alike(f(**at, load=load, gravity=gravity), wanted)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", NAMES)
def test_compiled_single_poses_equal_numpy(name, monkeypatch):
    f, g, at, load, gravity = functions(name)
    wanted = g(**at, load=load, gravity=gravity)
    at_once, whole = [], CompiledFunction.single

    def counted(self, *arguments):
        at_once.append(whole(self, *arguments))
        return at_once[-1]

    monkeypatch.setattr(CompiledFunction, "single", counted)
    for k in range(POSES):
        found = f(**{key: float(value[k]) for key, value in at.items()}, load=load[k], gravity=gravity[k])
        assert_alike(found, {key: wanted[key][k] for key in wanted})
    taken = [item for item in at_once if item is not None]
    assert np.sum(wanted["status"] <= ks.Status.LIMIT_EXCEEDED) / 2 <= len(taken) < POSES


@pytest.mark.few(1)
@pytest.mark.parametrize("name", NAMES)
def test_compiled_path_equals_numpy(name):
    """Each pose starts from the previous one, as on a controller."""
    f, g, at, *_ = functions(name)
    zero = {key: float(value[0]) for key, value in at.items()}
    values = careful = None
    for k in range(1, 9):
        here = {key: zero[key] * 0.1 * k + 0.9 * float(at[key][1]) * (1 - 0.1 * k) + 0.1 * float(at[key][1]) for key in at}
        values, careful = f(**here, near=values), g(**here, near=careful)
        assert_alike(values, careful)
        if careful["status"] in (ks.Status.OK, ks.Status.LIMIT_EXCEEDED):
            np.testing.assert_allclose(values.pose.q, careful.pose.q, rtol=0, atol=1e-11 * max(1.0, f.robot.length))
            assert values.pose.prescribed == careful.pose.prescribed
        else:
            values = careful = None


def test_values_and_functions_can_be_pickled_and_copied():
    f, _, at, *_ = functions("five_bar")
    values = f(**{key: float(value[1]) for key, value in at.items()})
    again = pickle.loads(pickle.dumps(values))
    assert np.array_equal(again["twist"], values["twist"]) and np.array_equal(again.pose.q, values.pose.q)
    assert not values["twist"].flags.writeable
    other = copy.copy(f)
    assert np.array_equal(other(**{key: float(value[1]) for key, value in at.items()})["twist"], values["twist"])


def test_invalid_arguments_of_compiled_functions_raise():
    f, _, at, *_ = functions("five_bar")
    one = {key: float(value[1]) for key, value in at.items()}
    with pytest.raises(ks.ArgumentError, match="its last axis must have 6 entries"):
        f(**one, load=[1.0])
    for wrong in ({"load": [[1.0] * 5]}, {"gravity": [[0.0, 0.0, -9.81, 0.0]]}):
        with pytest.raises(ks.ArgumentError, match="its last axis must have"):
            f(**{name: values[:2] for name, values in at.items()}, **wrong)
    with pytest.raises(ks.ArgumentError, match="not finite"):
        f(**one, gravity=[0, 0, np.nan])
    with pytest.raises(ks.exceptions.CoordinatesError, match="is not finite"):
        f(**{**one, next(iter(one)): np.inf})
    with pytest.raises(ks.ArgumentError, match="are missing"):
        f()
    with pytest.raises(ks.ArgumentError, match="do not fit together"):
        f(**{**one, next(iter(one)): [0.1, 0.2]}, load=np.zeros((3, 6)))


def test_statuses_of_singular_telescopes_and_exceeded_limits():
    """A telescope beyond its start, within its limits and beyond them, one by one and in a batch."""
    robot = mast()
    f, g = (ks.compile(robot, outputs=OUTPUTS, engine=engine) for engine in ("compiled", "numpy"))
    statuses = []
    for slide in (-0.6, -0.4, 0.3, 2.1):
        found, wanted = f(slide_a=slide, slide_b=0.3, load=LOAD), g(slide_a=slide, slide_b=0.3, load=LOAD)
        assert_alike(found, wanted)
        statuses.append(int(found["status"]))
    assert statuses == [ks.Status.SINGULAR, ks.Status.OK, ks.Status.OK, ks.Status.LIMIT_EXCEEDED]
    several = [-0.6, -0.4, 0.3, 2.1]
    assert f(slide_a=several, slide_b=0.3)["status"].tolist() == statuses
    near = f(slide_a=1.9, slide_b=0.3)
    beyond = f._compiled.single({"slide_a": 2.1, "slide_b": 0.3}, near, LOAD, (0, 0, -9.81))
    assert near["status"] == ks.Status.OK and beyond["status"] == ks.Status.LIMIT_EXCEEDED
    assert f._compiled.single({"slide_a": -0.6, "slide_b": 0.3}, None, LOAD, (0, 0, -9.81)) is None


@pytest.mark.parametrize(("rough", "tolerance"), [(1e-4, 1e-3), (1e-3, 1e-4)])
def test_poses_with_open_loops_are_left_to_numpy(rough, tolerance, monkeypatch):
    """A turned distal link opens the wrist by the chord; the smaller of both tolerances counts."""
    f = functions("five_bar")[0]
    monkeypatch.setattr(f._compiled, "_most", rough)
    monkeypatch.setattr("kinetostatics.functions.compiled.TOLERANCE", tolerance)
    opened = 1e-4 * np.array([0.0, 0.5, 0.98, 1.5, 2.0, 5.0])
    x = np.repeat(f.robot.zero_poses.x, 6, axis=1)
    (row,) = (joint.first_q for joint in f.robot.solver.tree.joints if joint.body == f.robot.mechanism.body_of_joint["elbow_2"])
    x[row] += 2 * np.arcsin(opened / 2 / 0.23)  # the link's length [m]
    poses, doubted = f.robot.configuration(f.robot.model_q(SolverState(x, np.zeros((3, 6)))).T, closure_tolerance=1.0), []

    def careful(here, load, gravity):
        doubted.extend(here.q[:, 0].tolist())
        return {}

    found = f._compiled.many(poses, np.zeros(6), np.zeros(3), careful)
    np.testing.assert_allclose(found["residual"], opened, rtol=0, atol=1e-15)
    assert len(doubted) == 3 and set(found["status"].tolist()) == {ks.Status.OK}


def test_line_near_a_singular_pose_is_left_to_numpy(monkeypatch):
    f, _, at, *_ = functions("five_bar")
    one = {key: float(value[1]) for key, value in at.items()}

    doubts = []

    class Doubtful(loops.Bound):
        def __init__(self, code, inputs, parameters, numbers, truths):
            super().__init__(code, inputs, parameters, numbers, truths)
            self.result = truths if len(numbers) == 0 else None  # whether two poses are on one side of a singular one

        def __call__(self):
            super().__call__()
            if self.result is not None and doubts:
                assert self.result.all()
                self.result[:] = False

    assert f._compiled.single(one, None, LOAD, (0, 0, -9.81)) is not None
    monkeypatch.setattr(loops, "Bound", Doubtful)
    other = copy.copy(f)
    assert other._compiled.single(one, None, LOAD, (0, 0, -9.81)) is not None
    doubts.append("as of a pose beside a singular one")
    assert other._compiled.single(one, None, LOAD, (0, 0, -9.81)) is None
    assert_alike(other(**one, load=LOAD), f(**one, load=LOAD))


def test_single_pose_may_start_from_a_previous_pose():
    f, *_ = functions("ur10")
    far = {key: 1.5 for key in f.inputs if key not in ("load", "gravity")}
    assert f._compiled.single(far, None, LOAD, (0, 0, -9.81)) is None
    values = f(**far)
    beside = {key: 1.55 for key in far}
    assert f._compiled.single(beside, values, LOAD, (0, 0, -9.81)) is not None
    batch = f(**{**far, next(iter(far)): [1.5, 1.6]})
    assert f._compiled.single(beside, batch, LOAD, (0, 0, -9.81)) is None


@pytest.mark.parametrize("holds", [True, False])
def test_lines_of_ambiguous_angles_take_the_shorter_way(holds, monkeypatch):
    """Large angles, or azimuth, tilt and torsion; where the record of the start does not hold, NumPy computes it."""
    f, g, at, *_ = functions("2pru_upr")
    monkeypatch.setattr(Orientation, "unique_below", 0.0)
    monkeypatch.setattr(f._compiled, "unique_below", 0.0)
    started, asked = loops.CompiledSolver._started, []
    assert f._compiled._solver._start is not None

    def doubted(*given):
        first, c, good = started(*given)
        asked.append(good.all())
        return (first, c, good) if holds else (first * np.nan, c * np.nan, good & False)

    monkeypatch.setattr(loops.CompiledSolver, "_started", doubted)
    one = {key: 0.3 * float(value[1]) + 0.7 * float(f.robot.assemble().platform[key]) for key, value in at.items()}
    beside = {key: value + 0.01 for key, value in one.items()}
    values, careful = f(**one), g(**one)
    assert_alike(values, careful)
    found = f._compiled.single(beside, values, LOAD, (0, 0, -9.81))
    assert_alike(found, g(**beside, near=careful, load=LOAD))
    assert len(asked) == 2 and all(asked)
    several = {key: value + np.linspace(0, 0.02, 3) for key, value in one.items()}
    assert_alike(f(**several, near=values), g(**several, near=careful))


@pytest.mark.parametrize("doubt", ["guards", "usual", "singular", "worst_equation", "opening"])
def test_poses_in_doubt_are_left_to_numpy_one_by_one_and_in_batches(doubt, monkeypatch):
    """Each condition by itself: the numbers of such poses, here NaN, are never returned."""
    f, g, at, load, gravity = functions("ur10")
    wanted, some = g(**at, load=load, gravity=gravity), np.arange(POSES) % 3 == 1

    def doubtful(numbers, truths, places, poses):
        numbers, truths = numbers.copy(), truths.copy()
        if doubt in ("worst_equation", "opening"):
            rows, numbers[:, poses] = places[doubt].rows, np.nan
            numbers[rows, poses] = 1.0
        else:
            row = 0 if doubt == "guards" else places[doubt].rows.start
            numbers[:, poses] = np.nan
            numbers[places["worst_equation"].rows, poses] = numbers[places["opening"].rows, poses] = 0.0
            truths[row, poses] = doubt == "singular"
        return numbers, truths

    many, single = f._compiled._code_of_many, f._compiled._computed
    computed = many.computed
    monkeypatch.setattr(many, "computed", lambda *given: doubtful(*computed(*given), many.places, some))
    assert_alike(f(**at, load=load, gravity=gravity), wanted)
    near, k = f(**{key: float(value[1]) for key, value in at.items()}), 1
    here = {key: float(value[1]) for key, value in at.items()}
    assert f._compiled.single(here, near, load[k], gravity[k]) is not None
    monkeypatch.setattr(f._compiled, "_computed", lambda: doubtful(*single(), f._compiled._code.places, slice(None)))
    assert f._compiled.single(here, near, load[k], gravity[k]) is None
