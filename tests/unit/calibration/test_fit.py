"""The statistics of calibration on straight lines and small tables, against fits that leave readings out."""

import itertools

import numpy as np
import package_robots
import pytest
from scipy import stats

import kinetostatics as ks
from kinetostatics.calibration.fit import FALSE_ALARM, determined, fit, outliers, solution
from kinetostatics.calibration.measurement_plan import _exchanged, best_subset, log_det
from kinetostatics.calibration.readings import Model, Readings
from kinetostatics.calibration.unknowns import Unknown, Unknowns, identifiable_ones, unidentifiable
from kinetostatics.load_case import LoadCase

X = np.arange(8.0)
LINE = np.stack([np.ones(8), X], axis=1)
NOISE = 1e-3 * np.array([0.4, -1.0, 0.7, -0.2, 0.9, -0.8, 0.3, -0.5])


def line_fit(J, readings, sigma_known=False):
    """Return the solution for readings of a linear model, as found by least squares."""
    x = np.linalg.lstsq(J, readings, rcond=None)[0]
    return solution(x, J, readings - J @ x, sigma_known)


def studentized_by_leaving_out(J, readings, k, sigma_known=False):
    """Return the error of predicting a reading from the others, over its standard deviation."""
    rest = np.delete(np.arange(len(readings)), k)
    x, squares = np.linalg.lstsq(J[rest], readings[rest], rcond=None)[:2]
    variance = 1.0 if sigma_known else float(squares[0]) / (len(rest) - J.shape[1])
    spread = 1 + J[k] @ np.linalg.inv(J[rest].T @ J[rest]) @ J[k]
    return (readings[k] - J[k] @ x) / np.sqrt(variance * spread)


@pytest.mark.parametrize("sigma_known", [False, True])
def test_outliers_begin_at_the_bonferroni_bound(sigma_known):
    """Bonferroni's bound on the largest of eight, with the degrees of freedom of a fit without the reading."""
    scale = 1e3 if sigma_known else 1.0
    beyond = FALSE_ALARM / 2 / 8
    bound = stats.norm.isf(beyond) if sigma_known else stats.t.isf(beyond, 8 - 1 - 2)

    def judged(size):
        readings = scale * (NOISE + size * 1e-3 * (np.arange(8) == 4))
        studentized, bad = outliers(line_fit(LINE, readings, sigma_known), float(np.sqrt(np.mean(readings**2))))
        return readings, studentized, bad

    low, high = 0.0, 100.0
    assert not judged(low)[2].any() and judged(high)[2].tolist() == [k == 4 for k in range(8)]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if judged(middle)[2].any() else (middle, high)
    readings, studentized, _ = judged(low)
    assert studentized[4] == pytest.approx(bound, rel=1e-6)
    found = [studentized_by_leaving_out(LINE, readings, k, sigma_known) for k in range(8)]
    np.testing.assert_allclose(studentized, found, rtol=1e-8)


def test_outliers_are_found_with_two_surplus_readings():
    readings = np.array([1e-3, -1e-3, 0.7e-3, 1e3, -0.4e-3])
    J = np.vander(np.arange(5.0), 3)
    assert outliers(line_fit(J, readings), 1.0)[1].tolist() == [False, False, False, True, False]


def test_reading_that_alone_determines_an_unknown_is_no_outlier():
    """The fit passes through any value of it."""
    J = np.column_stack([LINE, np.arange(8) == 2])
    studentized, bad = outliers(line_fit(J, NOISE), 1.0)
    assert studentized[2] == 0 and not bad.any() and np.all(studentized[np.arange(8) != 2] != 0)


def test_rounding_errors_are_no_outliers():
    """Beside readings of a thousand, a residual of 1e-6 is rounding, however far it is from the others."""
    readings = 1e3 + 1e-9 * np.sign(NOISE)
    readings[3] += 9e-7
    studentized, bad = outliers(line_fit(LINE, readings), 1e3)
    assert not bad.any() and not studentized.any()


def test_unknowns_without_initial_influence_are_found():
    """A factor of a quantity that is zero at the start of the search."""
    found = fit(
        lambda x: np.array([x[0], x[0] * x[1], x[0] + x[0] * x[1]]),
        lambda x: np.array([[1, 0], [x[1], x[0]], [1 + x[1], x[0]]]),
        np.zeros(2),
        np.array([2.0, 6.0, 8.0]),
        np.ones(3),
        True,
    )
    np.testing.assert_allclose(found.x, [2.0, 3.0], rtol=1e-8)
    assert found.null.shape == (2, 0)


@pytest.mark.parametrize(
    ("direction", "seen"),
    [
        ((1.0, -1.0), "the readings depend only on their sum"),
        ((-0.5, -0.5), "the readings depend only on their difference"),
        ((1.0, 4.0), "the readings depend only on a − 0.25 times b"),
        ((1.0, -4.0), "the readings depend only on a + 0.25 times b"),
        ((1.0, -4.0, 2.0), "a, b and c cannot be distinguished: a change of all in a fixed ratio"),
    ],
)
def test_identifiable_combination_of_indistinguishable_unknowns_is_named(direction, seen):
    """It does not change along the unidentifiable direction."""
    unknowns = [Unknown(name, "argument", "", 1.0, 1.0) for name in "abc"[: len(direction)]]
    (found,) = unidentifiable(unknowns, np.array([direction]).T / np.linalg.norm(direction))
    assert seen in str(found)


def test_unidentifiable_directions_have_few_unknowns():
    """A mixed basis of the directions is replaced by the sparsest one."""
    unknowns = [Unknown(name, "argument", "", 1.0, 1.0) for name in "abcde"]
    space = np.array([[1.0, -1.0, 0, 0, 0], [0, 0, 1.0, 2.0, 0]]).T @ np.array([[0.6, 0.8], [-0.8, 0.6]])
    found = unidentifiable(unknowns, space)
    assert sorted(tuple(sorted(item.direction)) for item in found) == [("a", "b"), ("c", "d")]


def test_no_exchange_improves_a_measurement_plan():
    rng = np.random.default_rng(4)
    for _ in range(5):
        blocks = rng.standard_normal((9, 1, 3)) * rng.uniform(0.1, 3.0, (9, 1, 1))
        best = max(log_det(blocks[list(some)]) for some in itertools.combinations(range(9), 4))
        assert log_det(blocks[best_subset(blocks, 4, rng)]) == pytest.approx(best, rel=1e-12)
        plan = _exchanged(np.einsum("nki,nkj->nij", blocks, blocks), np.arange(4), 1e-12 * np.eye(3)).tolist()
        others = [[*plan[:k], new, *plan[k + 1 :]] for k in range(4) for new in set(range(9)) - set(plan)]
        assert (
            best_subset(1e-6 * blocks, 4, np.random.default_rng(1)).tolist()
            == best_subset(blocks, 4, np.random.default_rng(1)).tolist()
        )
        assert len(set(plan)) == 4 and log_det(blocks[plan]) >= max(log_det(blocks[other]) for other in others) - 1e-8


@pytest.mark.parametrize(("size", "rank"), [(3e-6, 2), (0.3e-6, 1)])
def test_jacobian_columns_below_a_millionth_are_unidentifiable(size, rank):
    """One that is small by itself, and one that is nearly a multiple of another."""
    assert determined(np.array([[1.0, 0.0], [0.0, size]]))[1].shape[1] == rank
    assert determined(np.array([[1.0, 1.0], [0.0, 2 * size]]))[1].shape[1] == rank


@pytest.mark.parametrize(("part", "is_determined"), [(2e-5, False), (0.5e-5, True)])
def test_unknowns_hardly_in_unidentifiable_directions_are_determined(part, is_determined):
    found = identifiable_ones(np.array([[2.0, 0.0], [2 * part, 0.0], [0.0, 1.0]]))
    assert found.tolist() == [False, is_determined, False] and identifiable_ones(np.zeros((2, 0))).tolist() == [True, True]
    unknowns = [Unknown(name, "argument", "", 1.0, 1.0) for name in "ab"]
    (only,) = unidentifiable(unknowns, np.array([[1.0], [part]]))
    assert list(only.direction) == (["a"] if is_determined else ["a", "b"])


def test_unknowns_without_influence_are_scaled_like_the_others():
    scale, seen, null = determined(np.array([[4.0, 0.0], [3.0, 0.0]]))
    np.testing.assert_allclose(scale, [0.2, 0.2])
    np.testing.assert_allclose(np.abs(np.hstack([seen, null])), np.eye(2), atol=1e-12)


def test_payload_centres_are_varied_as_first_moments():
    """Centres and their derivatives follow from mass and first moments."""
    robot = package_robots.robot("3rps")
    names = ["payload.mass", "payload.x", "payload.z", "rod_1"]
    found = Unknowns(robot, names, {}, ks.Payload(2.0, (0.1, 0.2, 0.3)), {})
    values = np.array([3.0, 0.6, 1.5, 0.8])
    told, factors = found.reported(values)
    np.testing.assert_allclose(told, [3.0, 0.2, 0.5, 1.25])
    np.testing.assert_allclose([item.start for item in found.items], [2.0, 0.2, 0.6, 1.0])
    steps = 1e-6 * np.eye(4)
    differences = [(found.reported(values + step)[0] - found.reported(values - step)[0]) / 2e-6 for step in steps]
    np.testing.assert_allclose(factors, np.transpose(differences), atol=1e-9)


def test_payload_model_is_defined_at_zero_mass():
    """The first moment acts as a couple then, and the centre is NaN."""
    robot = package_robots.robot("3rps")
    gauges = {"dz": ks.Gauge((0, 0, 1)), "drx": ks.Gauge((1, 0, 0), measures="rotation")}
    unknowns = Unknowns(robot, ["payload.mass", "payload.y"], gauges, None, {})
    rows = {"z": np.array([0.5]), "rx": np.array([0.1]), "ry": np.array([0.2])}
    readings = Readings(np.zeros(2, dtype=int), np.arange(2), gauges)
    model = Model(unknowns, rows, np.zeros((1, 6)), readings, "undeformed", None, LoadCase())
    pose = robot.assemble(platform=rows)
    for moment in (0.0, 0.3):
        arm = pose.frame("platform")[0, :3, :3] @ [0, moment, 0]
        twist = ks.analyze(pose, [0, 0, 0, *np.cross(arm, [0, 0, -9.81])]).twist[0]
        np.testing.assert_allclose(model.predict(np.array([0.0, moment])), twist[[2, 3]], rtol=1e-9)
    slope = (model.predict(np.array([1e-3, 0.3])) - model.predict(np.array([0.0, 0.3]))) / 1e-3
    np.testing.assert_allclose(model.jacobian(np.array([0.0, 0.3]))[:, 0], slope, rtol=1e-8)
    told, factors = unknowns.reported(np.array([0.0, 0.3]))
    assert told[0] == 0 and np.isnan(told[1]) and factors[0].tolist() == [1, 0] and np.all(np.isnan(factors[1]))


def test_unknown_that_hardly_moves_a_reading_keeps_its_value():
    """Below ``UNSEEN`` of the largest column an unknown is unidentifiable, alone: neither does it move nor any other with it."""
    slope = np.stack([np.ones(8), 0.9e-6 * np.sqrt(8 / 140) * X], axis=1)  # its column is 0.9e-6 of the other's
    scale, seen, null = determined(slope)
    np.testing.assert_array_equal(np.abs(null), [[0.0], [1.0]])
    np.testing.assert_array_equal(np.abs(seen), [[1.0], [0.0]])
    np.testing.assert_allclose(scale, 1 / np.sqrt(8), rtol=1e-15)
    found = fit(lambda x: slope @ x, lambda x: slope, np.array([5.0, 3.0]), 1.0 + NOISE, np.ones(8), False)
    assert found.x[1] == 3.0 and found.degrees_of_freedom == 7 and found.covariance[1, 1] == 0.0
    assert determined(slope * [1.0, 1.2])[2].shape == (2, 0)  # 1.08e-6 of it is seen


@pytest.mark.parametrize("k", range(8))
def test_an_outlier_among_exact_readings_is_studentized_by_rounding(k):
    """Without it nothing is left but rounding, which counts as ``ROUNDING`` of the readings, never as zero or less."""
    readings = (0.1 + 0.3 * X) * (1 + 0.01 * k) + (np.arange(8) == k)
    studentized, bad = outliers(line_fit(LINE, readings), 2.0)
    assert bad.tolist() == (np.arange(8) == k).tolist()
    free = 1 - LINE[k] @ np.linalg.solve(LINE.T @ LINE, LINE[k])
    assert studentized[k] == pytest.approx(np.sqrt(free) / (1e-9 * 2.0), rel=1e-6)
