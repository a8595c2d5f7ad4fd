"""Choice of a limb's canonical wrenches: common points of its axes, dependent joints, nearly reciprocal wrenches."""

import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

from kinetostatics.limbs import basis_choice
from kinetostatics.limbs.basis_choice import choose_basis, evaluate_bases
from kinetostatics.limbs.geometry import Candidate
from kinetostatics.limbs.statics import _may_be_dependent
from kinetostatics.limbs.wrench_candidates import common_point
from kinetostatics.math.screws import unit_twist

X, Y, Z = np.eye(3)


def wrist(*freedoms, length=2.0, serial=True, compounds=None):
    """Return a limb made of (kind, axis, point) freedoms, each a joint of its own, and its geometry about o."""
    rotates = np.array([kind == "R" for kind, *_ in freedoms])
    axes = np.array([axis / np.linalg.norm(axis) for _, axis, _ in freedoms]).T
    columns = [
        unit_twist(axis, np.asarray(point), turns) for turns, axis, (_, _, point) in zip(rotates, axes.T, freedoms, strict=True)
    ]
    compound_of = np.arange(len(freedoms)) if compounds is None else np.array(compounds)
    group = SimpleNamespace(
        passive=np.ones(len(freedoms), dtype=bool), is_serial=serial, rotates=rotates, compound_of=compound_of,
        compounds=[[SimpleNamespace(has_axis=lambda turns: True) for _ in freedoms]], model=SimpleNamespace(length=length),
        basis=SimpleNamespace(carried=range(len(freedoms))), twist_scale=np.array([1.0] * 3 + [length] * 3).reshape(6, 1, 1, 1),
    )  # fmt: skip
    geometry = SimpleNamespace(
        twists=np.stack(columns, axis=1)[:, :, None, None], axes=axes[:, :, None, None], limb_axes=np.zeros((3, 3, 1, 1))
    )
    return group, geometry


POINT = np.array([0.3, -0.2, 0.5])
MEETING = [("R", X, POINT + 0.4 * X), ("R", Y + Z, POINT), ("R", Z - X, POINT - 0.1 * (Z - X))]


def test_common_point_requires_all_axes_of_a_serial_limb():
    assert common_point(*wrist(*MEETING)) == (2, 1)  # the outer ones
    assert common_point(*wrist(*MEETING, serial=False)) is None
    assert common_point(*wrist(*MEETING, compounds=[0, 1, 1])) == (2, 0)
    assert common_point(*wrist(*MEETING, ("R", X, POINT + 0.1 * Y))) is None
    assert common_point(*wrist(*MEETING, ("P", Z, (0, 0, 0)))) is None
    # a slide is no hinge, also if its line through o meets the axes of the others
    through_o = [("R", X, X), ("R", Y, Y)]
    assert common_point(*wrist(*through_o)) == (1, 0) and common_point(*wrist(*through_o, ("P", Z, (0, 0, 0)))) is None


@pytest.mark.parametrize(("beside", "meets"), [(0.0, True), (1.9e-8, True), (2.1e-8, False), (1e-3, False)])
def test_common_point_tolerates_rounding(beside, meets):
    assert (common_point(*wrist(("R", X, POINT + beside * Y), ("R", Y, POINT), ("R", Z, POINT))) is not None) == meets


@pytest.mark.parametrize(("angle", "determined"), [(1.0, True), (1e-4, True), (3e-6, True), (3e-7, False), (0.0, False)])
def test_couple_normal_to_two_axes_is_determined_unless_they_are_parallel(angle, determined):
    group, geometry = wrist(("R", X, POINT), ("R", np.cos(angle) * X + np.sin(angle) * Y, POINT + Z))
    (couple,) = basis_choice._columns(group, [Candidate(("cross", 0, 1), None, "couple")], [], [], geometry)
    np.testing.assert_allclose(couple[:, 0, 0], [0, 0, 0, 0, 0, 1] if determined else [0, 0, 0, *[np.nan] * 3], atol=1e-9)


@pytest.mark.parametrize("length", [0.1, 10.0])
@pytest.mark.parametrize(("part", "doubtful"), [(0.98e-4, True), (1.5e-4, False), (0.1, False)])
def test_dependence_of_parallel_axes_scales_with_characteristic_length(length, part, doubtful):
    """Unit twists of hinges on o and beside it: the smaller eigenvalue of their Gram matrix is about half the squared angle."""
    two = [("R", Z, (0, 0, 0)), ("R", Z, (np.sqrt(2) * part * length, 0, 0))]
    assert _may_be_dependent(*wrist(*two, length=length)).item() == doubtful
    assert not _may_be_dependent(*wrist(*two, length=length, compounds=[0, 0])).item()  # of one universal joint


@pytest.mark.parametrize(
    ("off", "closing_error", "bad"), [(5e-7, 0, False), (2e-6, 0, True), (5e-5, 1e-6, False), (2e-4, 1e-6, True), (0, 0, False)]
)
def test_nearly_reciprocal_wrenches_are_corrected_others_replaced(off, closing_error, bad):
    """At one of two poses a hinge of one of three limbs is displaced so that a constraint wrench has the power ``off`` on it."""
    robot = package_robots.robot("3rps")
    group = copy.copy(robot.statics.groups[0])
    length = group.model.length
    group.model = SimpleNamespace(length=length, closing_error=closing_error)
    frames = robot.generic_frames.take(slice(0, 2))
    geometry = group.geometry(frames, robot.mechanism.platform_pose(frames)[1])
    scale = np.repeat([length, 1.0], 3).reshape(6, 1, 1, 1)
    allowed = geometry.twists[:, group.passive] / scale
    allowed /= np.sqrt(np.sum(allowed**2, axis=0))
    before, attached, _ = evaluate_bases(group, geometry, allowed * scale)
    unit = before[:, 0] * scale[:, 0] / np.sqrt(np.sum((before[:, 0] * scale[:, 0]) ** 2, axis=0))
    allowed[:, 0, 1, 0] += off * unit[:, 1, 0]
    J_c, J_g, degenerate = evaluate_bases(group, geometry, allowed * scale)
    assert np.argwhere(degenerate).tolist() == ([[1, 0]] if bad else [])
    assert np.abs(np.einsum("ikgn,ijgn->kjgn", allowed, J_c * scale)).max() < 1e-14
    others = ~degenerate
    others[1, 0] = False
    np.testing.assert_array_equal(J_c[..., others], before[..., others])
    if not bad:
        np.testing.assert_allclose(J_c, before, rtol=0, atol=5 * off)
        np.testing.assert_array_equal(J_g, attached)


def reciprocal_power(wrenches, twists, scale):
    """Return the largest power of unit wrenches (6, n, …) on unit twists (6, k, …), both about o."""
    unit = [array / np.sqrt(np.sum(array**2, axis=0)) for array in (wrenches * scale, twists / scale)]
    return np.abs(np.einsum("ij...,ik...->jk...", *unit)).max(axis=(0, 1))


@pytest.mark.parametrize("off", [1e-9, 1e-3])
def test_attached_wrenches_are_reciprocal_to_twists_of_the_platform_joint(off):
    """At one of two poses a twist of the platform joint of one of three limbs is changed; the constraint wrenches stay."""
    robot = package_robots.robot("3rps")
    group = robot.statics.groups[0]
    frames = robot.generic_frames.take(slice(0, 2))
    geometry = group.geometry(frames, robot.mechanism.platform_pose(frames)[1])
    scale = np.repeat([group.model.length, 1.0], 3).reshape(6, 1, 1, 1)
    allowed = geometry.twists[:, group.passive]
    constraint, before, _ = evaluate_bases(group, geometry, allowed)
    twists = np.array(geometry.twists)
    changed = int(np.flatnonzero(group.platform_joint)[0])
    twists[:, changed, 1, 0] += off * before[:, 0, 1, 0] * scale[:, 0, 0, 0] ** 2
    J_c, J_g, degenerate = evaluate_bases(group, replace(geometry, twists=twists), allowed)
    own = twists[:, group.platform_joint]
    assert reciprocal_power(before, own, scale)[1, 0] > 0.1 * off and not degenerate.any()
    assert reciprocal_power(J_g, own, scale).max() < 1e-14
    np.testing.assert_array_equal(J_c, constraint)


@pytest.mark.parametrize(("off", "qualifies"), [(1e-9, True), (1e-7, False), (5e-6, False)])
def test_wrenches_that_are_not_reciprocal_do_not_qualify(off, qualifies):
    """A hinge of a limb is displaced so that the preferred constraint wrench has the power ``off`` on it; others are chosen."""
    robot = package_robots.robot("3rps")
    group = copy.copy(robot.statics.groups[0])
    frames = robot.generic_frames
    geometry = group.geometry(frames, robot.mechanism.platform_pose(frames)[1])
    scale = np.repeat([group.model.length, 1.0], 3).reshape(6, 1, 1, 1)
    first = evaluate_bases(group, geometry, geometry.twists[:, group.passive])[0][:, 0]
    twists, hinge = np.array(geometry.twists), int(np.flatnonzero(group.passive)[0])
    unit = first * scale[:, 0] / np.sqrt(np.sum((first * scale[:, 0]) ** 2, axis=0))
    size = np.sqrt(np.sum((twists[:, hinge] / scale[:, 0]) ** 2, axis=0))
    twists[:, hinge] += off * size * unit * scale[:, 0]
    moved = replace(geometry, twists=twists)
    preferred, count = group.basis.constraint[0].label, geometry.limb_axes.shape[-1]
    group.basis = choose_basis(group, moved, count)
    assert (preferred in [candidate.label for candidate in group.basis.constraint]) == qualifies
    J_c, _, degenerate = evaluate_bases(group, moved, twists[:, group.passive])
    assert not degenerate.any() and reciprocal_power(J_c, twists[:, group.passive], scale).max() < 1e-14


@pytest.mark.parametrize(("angle", "bad"), [(1.3e-5, True), (1.5e-5, False)])
def test_bases_of_nearly_parallel_wrenches_degenerate(angle, bad, monkeypatch):
    """Two wrenches of one of three limbs at one of two poses: the eigenvalue of their Gram matrix is half the squared angle."""
    robot, columns = package_robots.robot("3rps"), basis_choice._columns
    group = robot.statics.groups[0]
    frames = robot.generic_frames.take(slice(0, 2))
    geometry = group.geometry(frames, robot.mechanism.platform_pose(frames)[1])
    scale = np.repeat([1.0, 1 / group.model.length], 3)

    def turned(*given):
        first, second, *others = columns(*given) if given[1] is group.basis.constraint else (None, None)
        if first is None:
            return []
        one, other = first[:, 1, 0] * scale, second[:, 1, 0] * scale
        across = other - one * (one @ other) / (one @ one)
        second[:, 1, 0] = (one / np.linalg.norm(one) + angle * across / np.linalg.norm(across)) / scale
        return [first, second, *others]

    monkeypatch.setattr(basis_choice, "_columns", turned)
    with np.errstate(invalid="ignore"):  # without twists to which the wrenches are reciprocal
        none = np.zeros((6, int(np.sum(group.passive)), *geometry.limb_axes.shape[2:]))
        degenerate = evaluate_bases(group, geometry, none)[2]
    assert np.argwhere(degenerate).tolist() == ([[1, 0]] if bad else [])
