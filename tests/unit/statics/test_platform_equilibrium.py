"""The platform's equilibrium on both sides of its thresholds; indeterminate forces of rigid parts."""

from types import SimpleNamespace

import numpy as np
import pytest
from simple_machines import CIRCLE, RHO, bar, joint, link, loop, mount, robot, springs

import kinetostatics as ks
from kinetostatics.statics import singularity
from kinetostatics.statics.platform_equilibrium import _RigidPart


def pendulum(offset):
    """Return a bob that hangs on a hinge under the platform, its centre of mass ``offset`` beside the hinge."""
    bob = link("bob", 2.0, f"{offset} 0 -0.2"), joint("hook", "continuous", "platform", "bob", "0.1 0 0")
    return mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4"), *bob)


@pytest.mark.parametrize(("part", "status"), [(3e-8, ks.Status.OK), (3e-7, ks.Status.SINGULAR), (0.1, ks.Status.SINGULAR)])
def test_pendulum_with_offset_mass_is_singular(part, status):
    """The threshold is that of the weight's arm over the characteristic length."""
    machine = pendulum(part * pendulum(0.0).length)
    assert ks.analyze(machine.assemble(), on_failure="nan").status == status


def rigid_wrenches(tilt):
    """Return the rigid part of two forces that enclose a small angle, with springs in all directions."""
    J = np.zeros((1, 1, 6, 2))
    J[..., 0, :] = 1
    J[..., 1, 1] = tilt
    split = SimpleNamespace(rigid=np.eye(2)[None, None], J=J)
    return _RigidPart(np.eye(6)[:, :, None], [split], np.ones(6)), split


@pytest.mark.parametrize(("tilt", "rank"), [(1e-8, 2), (4e-9, 2), (5e-10, 1), (0.0, 1)])
def test_nearly_equal_rigid_wrenches_count_as_one(tilt, rank):
    part, split = rigid_wrenches(tilt)
    assert part.undetermined == (rank == 1)
    # a strain along one of them alone contradicts the other, or turns the platform far
    moved, _ = part.solve(np.zeros((6, 1, 1)), [split], [np.array([1.0, 0]).reshape(2, 1, 1, 1)], errors=True)
    assert np.isnan(moved).all() == (rank == 1)


@pytest.mark.parametrize("stiffness", [1.0, 1e-6, 1e-10, 4e-12, 5e-13, 0.0])
def test_freedom_left_by_rigid_wrenches_needs_stiffness(stiffness):
    """A rigid force along x, and springs in the other directions, one of them with a small stiffness."""
    K = np.diag([1.0] * 5 + [stiffness])[:, :, None]
    split = SimpleNamespace(rigid=np.ones((1, 1, 1, 1)), J=np.eye(6)[None, None, :, :1])
    part = _RigidPart(K, [split], np.ones(6))
    assert part.singular.tolist() == [stiffness < 1e-12]
    if stiffness > 1e-12:
        np.testing.assert_allclose(part.compliance[5, 5, 0] * stiffness, 1.0, rtol=1e-4)
        assert np.abs(part.compliance[0]).max() < 1e-12


@pytest.mark.parametrize("tilt", [1.0, 0.01, 1e-3, 1e-7, 0.0])
def test_six_distinct_rigid_wrenches_hold_the_platform(tilt):
    """Two of them enclose a small angle, which makes their forces large."""
    J = np.eye(6)
    J[:2, 1] = np.cos(tilt), np.sin(tilt)
    turned = np.linalg.qr(np.random.default_rng(1).standard_normal((6, 6)))[0]  # so that nothing is exact by itself
    split = SimpleNamespace(rigid=np.eye(6)[None, None], J=(turned @ J)[None, None])
    part = _RigidPart(np.zeros((6, 6, 1)), [split], np.ones(6))
    assert part.singular.tolist() == part.undetermined.tolist() == [tilt == 0]
    if tilt:
        assert not part.compliance.any()
        _, (forces,) = part.solve(turned[:, 1].reshape(6, 1, 1), [split], [np.zeros((6, 1, 1, 1))])
        wanted = [-1 / np.tan(tilt), 1 / np.sin(tilt), 0, 0, 0, 0]
        np.testing.assert_allclose(forces[:, 0, 0, 0], wanted, rtol=0, atol=2e-15 / tilt**2)  # rounding of J, and no more


@pytest.mark.parametrize(("sine", "held"), [(1.0, True), (2e-6, True), (1e-6, False), (0.0, False)])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_platform_is_constrained_only_by_six_distinct_wrenches(sine, held, size):
    """Six wrenches, two of which enclose an angle: the smallest eigenvalue of their Gram matrix is half its squared sine."""
    J = np.eye(6)
    J[:, 5] = np.sqrt(1 - sine**2) * J[:, 0] + sine * J[:, 5]
    groups = [SimpleNamespace(basis=SimpleNamespace(constraint=columns)) for columns in ([0, 1], [2, 3, 4, 5])]
    limbs = [SimpleNamespace(J_c=size * J[:, group.basis.constraint, None, None], group=group) for group in groups]
    assert bool(singularity.is_constrained(limbs, np.ones(6), 1)[0]) == held


def test_load_sharing_of_collinear_rigid_hinges_is_indeterminate():
    """A foot on two hinges, one of them actuated, carries a rod and the platform."""
    machine = robot(
        link("base"), link("foot"), link("rod"), link("platform", 2.0, "0.1 0 0"),
        joint("one", "continuous", "base", "foot"), loop("two", "revolute", "base", "foot", "0 0.3 0", "0 0.3 0", "0 1 0"),
        joint("root", "fixed", "foot", "rod"), joint("head", "fixed", "rod", "platform", "0 0 0.5"),
        bar("rod", "root", "head", RHO, CIRCLE), '<transmission name="t"><joint name="one"/></transmission>',
    )  # fmt: skip
    found = ks.analyze(machine.assemble(actuators={"one": [0.0, 0.4]}), load=[5.0, 6.0, 7.0, 0, 0, 0])
    assert found.indeterminate.all() and np.isfinite(found.twist).all()
    for name in ("one", "two"):
        assert np.isnan(found.joint_wrenches[name]).any(axis=-1).all()
    for name in ("root", "head"):
        assert np.isfinite(found.joint_wrenches[name]).all()
    weight = 9.81 * (2.0 + float(found.beams["rod"].mass[0]))
    np.testing.assert_allclose(np.abs(found.joint_wrenches["root"][0, :3]), [5, 6, weight - 7], rtol=1e-9)
