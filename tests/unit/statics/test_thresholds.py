"""A case on both sides of every threshold of the platform's equilibrium: how little is nothing."""

from types import SimpleNamespace

import numpy as np
import pytest
from simple_machines import joint, link, mount, springs

import kinetostatics as ks
from kinetostatics.statics import singularity
from kinetostatics.statics.joint_wrenches import _masked
from kinetostatics.statics.platform_equilibrium import _invert, _RigidPart


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
    undetermined = np.zeros((6, 2, 1, 1))
    undetermined[4, 0], undetermined[0, 1] = 1.0, size
    found = _masked(np.ones((6, 2, 1)), undetermined)
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
    assert part.loose == (rank == 1)
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


@pytest.mark.parametrize(("sine", "held"), [(1.0, True), (2e-6, True), (1e-6, False), (0.0, False)])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_platform_held_by_wrenches_that_differ(sine, held, size):
    """Six wrenches, two of which enclose an angle: the smallest eigenvalue of their Gram matrix is half its squared sine."""
    J = np.eye(6)
    J[:, 5] = np.sqrt(1 - sine**2) * J[:, 0] + sine * J[:, 5]
    limbs = [SimpleNamespace(J_c=size * J[:, columns, None, None]) for columns in ([0, 1], [2, 3, 4, 5])]
    assert bool(singularity.held(limbs, np.ones(6), 1)[0]) == held
