"""What rounding must not choose: the first of equals, and bases of spaces."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.math.linalg import EQUAL, axis_across, canonical_basis, first_largest, null_space, ranked
from kinetostatics.reports.sources import ranked as ranked_sources

NOISE = 1e-9


def test_the_first_of_equals_is_the_largest():
    assert first_largest([1.0, 3.0, 3.0 + NOISE, 2.0]) == 1
    assert first_largest([1.0, 3.0, 3.0 * (1 + 2 * EQUAL), 2.0]) == 2
    assert first_largest([0.0, 0.0]) == 0


def test_equals_keep_their_order():
    assert ranked([1.0, 3.0, 3.0 + NOISE, 5.0, 1.0 + NOISE, 0.0]) == [3, 1, 2, 0, 4, 5]
    assert ranked([]) == [] and ranked([0.0, 0.0]) == [0, 1]
    assert ranked([1.0, 1.0 + 2 * EQUAL]) == [1, 0]
    assert ranked([1e-17, 3e-17, 1.0, 2e-17]) == [2, 0, 1, 3] and ranked([1e-17, 3e-17]) == [1, 0]


@pytest.mark.parametrize("noise", [0.0, NOISE, -NOISE])
def test_the_axis_across_does_not_depend_on_rounding(noise):
    assert axis_across([noise, 1, -noise]).tolist() == [1, 0, 0]
    assert axis_across([1, 0, noise]).tolist() == [0, 1, 0]
    assert axis_across([0.6, 0.5, 0.5 + noise]).tolist() == [0, 1, 0]
    several = axis_across(np.array([[1, 0], [noise, noise], [0, 1]]))
    assert several.T.tolist() == [[0, 1, 0], [1, 0, 0]]


@pytest.mark.parametrize("k", range(6))
def test_a_basis_depends_on_its_space_alone(k):
    random = np.random.default_rng(k)
    basis = np.linalg.qr(random.standard_normal((6, 6)))[0][:, :k]
    turned = basis @ np.linalg.qr(random.standard_normal((k, k)))[0]
    found = canonical_basis(basis)
    assert canonical_basis(turned) == pytest.approx(found, abs=1e-13)
    assert found.T @ found == pytest.approx(np.eye(k), abs=1e-13)
    assert found @ (found.T @ basis) == pytest.approx(basis, abs=1e-13)


def test_spaces_of_equal_coordinates_have_one_basis_whatever_the_rounding():
    rows = np.array([[1.0, -1, 0, 0], [0, 0, 1, 1]])
    found, rank, _ = null_space(rows, 1e-5)
    assert rank == 2
    assert found == pytest.approx(np.array([[1, 0], [1, 0], [0, 1], [0, -1]]) / np.sqrt(2), abs=1e-14)
    random = np.random.default_rng(0)
    for _ in range(10):
        other, _, _ = null_space(rows + 1e-14 * random.standard_normal(rows.shape), 1e-5)
        assert other == pytest.approx(found, abs=1e-12)


# ---- what reports make of it ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name, softest, stiffest",
    [
        ("orthoglide", "in every direction", "in every direction"),
        ("gough_stewart", "in every direction of the xy plane", "along (0, 0, 1.000)"),
        ("tripteron", "along (0.577, 0.577, 0.577)", "in every direction across (0.577, 0.577, 0.577)"),
    ],
)
def test_equal_stiffnesses_have_no_direction_of_their_own(name, softest, stiffest):
    text = str(ks.analyze(package_robots.robot(name).assemble()).report())
    for word, where in (("softest", softest), ("stiffest", stiffest)):
        (line,) = (line for line in text.splitlines() if f"{word} against a force" in line)
        assert line.endswith(f"/mm {where}") or line.endswith(f"/µm {where}")


def test_rounding_is_written_as_nothing():
    pose = package_robots.robot("delta").assemble(actuators={"motor_1": 0.1, "motor_2": 0.02, "motor_3": -0.1})
    assert 0 < abs(pose.platform["rx"]) < 1e-12 and "rx = 0, ry = 0, rz = 0," in str(pose)
    assert 0 < pose.residual < 1e-12 and "loops        closed\n" in str(ks.analyze(pose))
    bent = pose.robot.configuration(pose.q + 1e-7, closure_tolerance=1e-3)
    assert f"loops        open by at most {bent.residual:.1e} (m or rad)" in str(ks.analyze(bent))


def test_moments_alone_lock_in_no_force():
    table = ks.tolerances(package_robots.robot("tripteron").assemble())
    assert table.ranked_by == "force" and {(row.force, row.at) for row in table.effects.values()} == {(0.0, "")}
    moments = [row.moment for row in table.effects.values()]
    assert moments[0] > 1 and moments == pytest.approx(sorted(moments, reverse=True), rel=1e-6)
    assert "lock in no force" not in str(table)


def test_how_alike_equals_are():
    assert first_largest([1 - 5e-7, 1.0]) == 0 and first_largest([1 - 2e-6, 1.0]) == 1
    assert ranked([1 - 5e-7, 1.0, 1 - 2e-6]) == [0, 1, 2] and ranked([1 - 2e-6, 1.0]) == [1, 0]
    assert ranked([0.5e-9, 0.9e-9, 1.0]) == [2, 0, 1] and ranked([2e-9, 3e-9, 1.0]) == [2, 1, 0]
    assert ranked_sources(np.array([1 - 5e-7, 1.0])) == [0, 1] and ranked_sources(np.array([1 - 2e-6, 1.0])) == [
        1,
        0,
    ]
    assert ranked_sources(np.array([-1.0, 0.0, 5e-7])) == [1, 2, 0]
    corner = np.array([0.5, 0.5 + 5e-7, 0.5]) / np.linalg.norm([0.5, 0.5, 0.5])
    assert axis_across(corner).tolist() == [1, 0, 0] and axis_across(corner - [0, 3e-6, 0]).tolist() == [0, 1, 0]
