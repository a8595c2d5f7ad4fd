"""Warnings of buckling, of statically indeterminate forces, and measures of nearly singular poses, of parts made by hand."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.results import warnings
from kinetostatics.results.warnings import NearSingularity, _bases, _joint_forces, indeterminate_parts


@pytest.mark.parametrize(("ratio", "words"), [(0.049, ""), (0.051, "linear theory"), (0.999, "linear theory"), (1, "no result")])
def test_members_that_buckle_together_share_one_warning_from_a_twentieth_of_their_buckling_load_on(ratio, words, monkeypatch):
    monkeypatch.setattr(warnings, "_changed_stiffness", lambda result: "")
    ratios = {"a": [0.2, 1.5], "b": [0.2, 1.5], "c": ratio, "d": [np.nan, 0.0]}
    beams = {name: SimpleNamespace(name=name, euler_ratio=np.array(ratio)) for name, ratio in ratios.items()}
    both, *one = warnings._buckling(SimpleNamespace(beams=beams))
    assert both == "the forces are 150 % of the buckling load of beams a, b: no result applies"
    assert len(one) == bool(words) and all("beam c" in text and words in text for text in one)


@pytest.mark.parametrize(("part", "joints"), [(0.9e-9, "a, c"), (1.1e-9, "a, b, c"), (-1.1e-9, "a, b, c")])
def test_joints_that_rounding_alone_loads_have_no_part_in_a_self_stress(part, joints):
    """Two cut joints that carry opposite forces of 2 N but for ``part`` of them: b carries their sum, a and c one each."""
    loose = np.zeros((2, 6, 1, 1, 1))
    loose[0, 0], loose[1, 0] = 2.0, -2.0 * (1 + part)
    edges = [
        SimpleNamespace(joint=name, cut_joints=signs)
        for name, signs in (("a", ((0, 1),)), ("b", ((0, 1), (1, 1))), (None, ((0, 1),)), ("c", ((1, -1),)), ("d", ((0, 0),)))
    ]
    item = SimpleNamespace(group=SimpleNamespace(limbs=[SimpleNamespace(name="limb_1", edges=edges)]), loose=loose)
    undetermined = np.zeros((2, 1, 1), dtype=bool)
    found = SimpleNamespace(solutions=[SimpleNamespace(statics=[item], undetermined=[undetermined])])
    rest = "their forces are statically indeterminate, returned as NaN"
    assert indeterminate_parts(found) == f"the rigid rings in limb_1 ({joints}) are overconstrained in themselves: {rest}"
    undetermined[1] = True
    assert indeterminate_parts(found).startswith("the rigid limbs limb_1 overconstrain one another and the rigid rings in limb_1")
    loose[:] = 0
    undetermined[:] = False
    assert indeterminate_parts(found) == f"rigid parts are overconstrained: {rest}"


def network(**changes):
    """Two chords that share a force along x and a moment about z of 2 m · N: 3 and 4 times the force, and large moments."""
    J_c, cut_wrenches = np.zeros((6, 2, 1, 1)), np.zeros((2, 6, 2, 1, 1))
    J_c[0, 0], J_c[5, 1] = 1.0, 2.0
    cut_wrenches[0, 0, 0], cut_wrenches[1, 1, 0], cut_wrenches[:, 3:] = 3.0, 4.0, 1e3
    return SimpleNamespace(J_c=J_c, cut_wrenches=cut_wrenches, **changes)


def test_forces_in_the_joints_of_a_network_leave_moments_out():
    sizes, wrenches = _joint_forces(network(), 2.0)
    assert sizes == pytest.approx(5.0, rel=1e-12)
    np.testing.assert_allclose(np.abs(wrenches[0, 0]), [1, 0, 0, 0, 0, 0], atol=1e-12)


def test_moments_count_by_the_characteristic_length():
    Q, R = _bases(network(), 4.0)
    np.testing.assert_allclose(np.abs(R[0, 0]), [[1, 0], [0, 0.5]], atol=1e-15)
    np.testing.assert_allclose(np.abs(Q[0, 0]), np.eye(6)[:, [0, 5]], atol=1e-15)


def test_which_poses_are_nearly_singular():
    found = NearSingularity(np.array([0.021, 0.019, 1.0, 1.0, np.nan]), np.array([0.0, 0, 49, 51, np.nan]))
    assert found.where.tolist() == [False, True, False, True, False]
    assert NearSingularity(np.array([0.5, 0.1, 0.3]), np.array([1.0, 2, 11])).worst == 2
    assert NearSingularity(np.array([0.5, 0.05, 0.3]), np.array([1.0, 2, 11])).worst == 1


@pytest.mark.parametrize("name", ["3rps", "2pru_upr", "delta"])
def test_joints_are_not_called_dependent_at_ordinary_poses(name):
    """Which would cost a decision about every pose by itself, and where they are dependent there would be none."""
    found = ks.analyze(package_robots.robot(name).assemble())
    assert not any(item.doubtful.any() for item in found.solutions[0].statics)
