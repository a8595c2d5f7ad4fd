"""A case on both sides of every threshold: how little is nothing, how alike are equals."""

from types import SimpleNamespace

import numpy as np
import pytest
from test_elastic_joints import mount, springs
from test_hybrid_limbs import joint, link

import kinetostatics as ks
from kinetostatics.limbs.compliance import count_rigid
from kinetostatics.limbs.force_method import distribute, make_plan, ranks
from kinetostatics.limbs.geometry import _orientations
from kinetostatics.limbs.redundant_forces import _relaxation
from kinetostatics.math.linalg import null_space
from kinetostatics.math.ordering import axis_across, first_largest, ranked
from kinetostatics.reports import sources as report_sources
from kinetostatics.results.warnings import _large_motions, _open_loops
from kinetostatics.statics.joint_wrenches import _masked
from kinetostatics.statics.platform_equilibrium import _invert, _RigidPart
from kinetostatics.workspace.assembly_modes.continuity import JointScale, suspect_edges


def alike(difference):
    """The compliance of two wrenches that differ by little: correlated, its eigenvalues are ``difference`` and 2."""
    return np.array([[1.0, 1 - difference], [1 - difference, 1.0]])[:, :, None, None]


@pytest.mark.parametrize(("difference", "count"), [(1e-10, 0), (3e-12, 0), (3e-13, 1), (0.0, 1)])
def test_directions_without_compliance_are_rigid(difference, count):
    assert count_rigid(alike(difference)) == count
    assert count_rigid(np.diag([5.0, 7e-20])[:, :, None, None]) == 0  # beside its own direction alone, whatever its unit
    assert count_rigid(np.zeros((2, 2, 1, 1))) == 2 and count_rigid(np.zeros((0, 0, 1, 1))) == 0
    gain, loose = _relaxation(alike(difference), np.eye(2).reshape(2, 1, 2, 1, 1) * np.ones((1, 6, 1, 1, 1)))
    assert np.any(loose) == bool(count)
    assert (np.max(np.abs(gain)) > 10) == (not count)


@pytest.mark.parametrize(("pivot", "doubtful"), [(1e-5, False), (2e-6, False), (5e-7, True), (0.0, True)])
def test_pivots_that_are_not_trusted(pivot, doubtful):
    """x + y = −d and pivot · y = −e; the platform feels the third unknown."""
    P = np.zeros((6, 3))
    P[0, 2] = 1
    generic = np.array([[1.0, 1, 0], [0, 1, 0]])
    plan = make_plan(generic[:, :, None], P, 1e-6)
    A = np.array([[1.0, 1, 0], [0, pivot, 0]])
    found = distribute(plan, A[:, :, None, None], generic != 0, P, np.array([3.0, 2 * pivot])[:, None, None])
    assert bool(found.doubtful[0, 0]) == doubtful
    np.testing.assert_allclose(found.particular[:, 0, 0], [-1.0, -2, 0] if pivot else [-1.5, -1.5, 0], rtol=1e-9, atol=1e-9)


def pendulum(offset):
    """A bob that hangs on a hinge under the platform, its centre of mass beside the hinge."""
    bob = link("bob", 2.0, f"{offset} 0 -0.2"), joint("hook", "continuous", "platform", "bob", "0.1 0 0")
    return mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4"), *bob)


@pytest.mark.parametrize(("part", "status"), [(3e-8, ks.Status.OK), (3e-7, ks.Status.SINGULAR), (0.1, ks.Status.SINGULAR)])
def test_a_pendulum_hangs_straight_or_falls(part, status):
    """What passive joints may leave unbalanced of a weight: its arm over the characteristic length."""
    machine = pendulum(part * pendulum(0.0).length)
    assert ks.analyze(machine.assemble(), on_failure="nan").status == status


@pytest.mark.parametrize(("size", "unknown"), [(1e-10, False), (5e-10, False), (2e-9, True), (0.5, True)])
def test_forces_that_may_change_are_unknown(size, unknown):
    leeway = np.zeros((6, 2, 1, 1))
    leeway[4, 0], leeway[0, 1] = 1.0, size
    found = _masked(np.ones((6, 2, 1)), leeway)
    assert np.isnan(found[:, 0]).all() and np.isnan(found[:, 1]).all() == unknown


def rigid_wrenches(tilt):
    """Two rigid forces that differ by little, and springs everywhere."""
    J = np.zeros((1, 1, 6, 2))
    J[..., 0, :] = 1
    J[..., 1, 1] = tilt
    split = SimpleNamespace(rigid=np.eye(2)[None, None], J=J)
    return _RigidPart(np.eye(6)[:, :, None], [split], np.ones(6)), split


@pytest.mark.parametrize(("tilt", "rank"), [(1e-8, 2), (4e-9, 2), (5e-10, 1), (0.0, 1)])
def test_rigid_wrenches_that_are_one(tilt, rank):
    part, split = rigid_wrenches(tilt)
    assert part.rank == rank and part.loose == (rank == 1)
    # a strain along one of them alone: they contradict one another, or turn the platform far
    moved, _ = part.solve(np.zeros((6, 1, 1)), [split], [np.array([1.0, 0]).reshape(2, 1, 1, 1)])
    assert np.isnan(moved).all() == (rank == 1)


@pytest.mark.parametrize(("difference", "contradict"), [(1e-10, False), (5e-10, False), (4e-9, True), (1.0, True)])
def test_misfits_that_contradict_one_another(difference, contradict):
    part, split = rigid_wrenches(0.0)
    moved, forces = part.solve(np.zeros((6, 1, 1)), [split], [np.array([1.0, 1 - difference]).reshape(2, 1, 1, 1)])
    assert np.isnan(moved).all() == np.isnan(forces[0]).all() == contradict
    if not contradict:
        np.testing.assert_allclose(moved[:, 0, 0], [1, 0, 0, 0, 0, 0], atol=1e-9)


@pytest.mark.parametrize(("pivot", "singular"), [(1e-12, False), (3e-14, False), (3e-15, True), (0.0, True)])
def test_a_stiffness_of_nothing_is_none(pivot, singular):
    """Beside its own direction alone: what is left of it where all other directions are free."""
    K = np.eye(6)[:, :, None]
    K[0, 1] = K[1, 0] = np.sqrt(1 - pivot)
    assert _invert(K, np.ones(6))[1] == singular


def test_an_error_without_effect_is_not_in_the_table():
    """A joint that is springs everywhere: every error moves the platform; beside turns of 1 rad shifts of 1e-12 m are nothing."""
    pose = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4")).assemble()
    assert len(ks.tolerances(pose, length=1e-8, angle=1.0)) == 6
    assert {row.error for row in ks.tolerances(pose, length=1e-11, angle=1.0)} == {"rx", "ry", "rz"}


def test_equals_keep_their_order():
    assert first_largest([1 - 5e-7, 1.0]) == 0 and first_largest([1 - 2e-6, 1.0]) == 1
    assert ranked([1 - 5e-7, 1.0, 1 - 2e-6]) == [0, 1, 2] and ranked([1 - 2e-6, 1.0]) == [1, 0]
    assert ranked([0.5e-9, 0.9e-9, 1.0]) == [2, 0, 1] and ranked([2e-9, 3e-9, 1.0]) == [2, 1, 0]
    assert report_sources.ranked(np.array([1 - 5e-7, 1.0])) == [0, 1] and report_sources.ranked(np.array([1 - 2e-6, 1.0])) == [
        1,
        0,
    ]
    assert report_sources.ranked(np.array([-1.0, 0.0, 5e-7])) == [1, 2, 0]
    corner = np.array([0.5, 0.5 + 5e-7, 0.5]) / np.linalg.norm([0.5, 0.5, 0.5])
    assert axis_across(corner).tolist() == [1, 0, 0] and axis_across(corner - [0, 3e-6, 0]).tolist() == [0, 1, 0]


@pytest.mark.parametrize(("angle", "parallel"), [(1e-4, True), (1.3e-3, True), (1.5e-3, False), (0.1, False)])
def test_parallel_axes_point_the_same_way_together(angle, parallel):
    """Level axes point anticlockwise around z; these two tell so only together, and else point along x."""
    axes = np.array([[1.0, 0, 0], [np.cos(angle), 0, np.sin(angle)]]).T[:, :, None]
    moments = np.array([[0.0, 0, -0.3]] * 2).T[:, :, None]
    assert _orientations(axes, moments, np.array([True, True]), 2.0)[:, 0].tolist() == ([-1, -1] if parallel else [1, 1])
    assert _orientations(axes, moments, np.array([True, False]), 2.0)[:, 0].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("axis", "moment", "sign"),
    [
        ((0, 0.97, 0.21), 0.0, 1), ((0.97, 0, -0.21), 0.5, -1), ((0.98, 0, -0.19), 0.21, 1), ((0.98, 0, 0.19), -0.21, -1),
        ((0.98, 0.19, 0), -0.19, 1), ((-0.98, 0.19, 0), 0.19, -1), ((-0.19, -0.98, 0), 0.19, -1), ((-0.21, 0.97, 0), 0.0, -1),
    ],
)  # fmt: skip
def test_which_way_an_axis_points(axis, moment, sign):
    """Up; if level, anticlockwise around z; if it meets z, along x, else along y."""
    moments = np.array([0, 0, moment])[:, None, None]
    unit = np.array(axis) / np.linalg.norm(axis)
    assert _orientations(unit[:, None, None], moments, np.array([True]), 1.0) == sign


def steps(*sizes):
    """Poses on a line whose one angle grows by these steps."""
    q = np.cumsum([0.0, *sizes])[:, None]
    return suspect_edges(q, np.ones(len(q), dtype=bool), JointScale(np.ones(1), np.array([True]))).first.tolist()


def test_steps_that_are_too_large():
    assert steps(1e-2, 1.1e-2, 1e-2, 1.1e-2) == []
    assert steps(1e-2, 1e-2, 1.0, 1e-2, 1e-2) == [2]
    assert steps(1e-9, 1e-9, 9e-7, 1e-9, 1e-9) == [] and steps(1e-9, 1e-9, 2e-6, 1e-9, 1e-9) == [2]  # all but the same
    # how much more than half of the smaller neighbour, and a fifth of the usual
    assert steps(1e-2, 1e-2, 1.65e-2, 1e-2, 1e-2) == [] and steps(1e-2, 1e-2, 1.75e-2, 1e-2, 1e-2) == [2]


@pytest.mark.parametrize(("size", "suspect"), [(0.039, False), (0.041, True)])
def test_a_step_without_neighbours_may_be_four_times_the_usual(size, suspect):
    lower = 0.01 * np.arange(5.0)
    q = np.stack([lower, lower + np.array([0.01, 0.01, size, 0.01, 0.01])])[:, :, None]
    found = suspect_edges(q, np.ones((2, 5), dtype=bool), JointScale(np.ones(1), np.array([True])))
    assert ((2, 7) in zip(found.first, found.second, strict=True)) == suspect


def test_half_turns_are_short():
    q = np.array([3.12, 3.13, 3.14, -3.1331853, -3.1231853, -3.1131853])[:, None]
    for row in (q, -q):
        assert len(suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([True])))) == 0
        assert 2 in suspect_edges(row, np.ones(6, dtype=bool), JointScale(np.ones(1), np.array([False]))).first


def warned(residual=0.0, twist=(0.0,) * 6, length=2.0):
    return SimpleNamespace(
        configuration=SimpleNamespace(residual=np.array(residual)), twist=np.array(twist), robot=SimpleNamespace(length=length)
    )


def test_open_loops_and_large_motions_are_warned_of():
    assert _open_loops(warned(0.9e-9)) == [] and _open_loops(warned([0, np.nan])) == []
    assert "open by up to 1.1e-09" in _open_loops(warned([1.1e-9, 0]))[0]
    assert _large_motions(warned(twist=[0.11, 0.16, 0, 0.09, 0, 0])) == []
    assert "moves by 0.21 m" in _large_motions(warned(twist=[0.21, 0, 0, 0, 0, 0]))[0]
    assert "0.11 rad" in _large_motions(warned(twist=[0, 0, 0, 0, 0.11, 0]))[0]


def test_ranks_are_judged_beside_the_largest_value_or_one():
    for values, count in (((1e3, 5e-3), 1), ((1e3, 2e-2), 2), ((1e-3, 2e-5), 2), ((1e-3, 5e-6), 1), ((0.0, 0.0), 0)):
        matrix = np.diag(values)
        assert ranks(matrix[:, :, None], np.zeros((6, 2)), 1e-5) == (count, 0)
        assert null_space(matrix, 1e-5)[1] == count
