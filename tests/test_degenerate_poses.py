"""Poses at which the readable wrenches of a limb degenerate: its intensities are NaN, every other number is right."""

from pathlib import Path

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics import wrench_bases
from kinetostatics.linalg import Cholesky, definite
from kinetostatics.shipped import robot_path

CASES = Path(__file__).parent / "cases"


def test_two_wrenches_that_coincide_lose_nothing_but_intensities(monkeypatch):
    """By a choice that looks at generic poses only, a force of J_ic and one of J_ig were the same line but for 1e-5."""
    robot = ks.load_robot(CASES / "basis_degenerates_to_nan.urdf")
    found = ks.analyze(robot.assemble())
    assert found.status == ks.Status.OK
    same_but_intensities(found, monkeypatch)


def test_columns_are_dependent_though_no_pivot_says_so():
    """After a small pivot the next one is rounding."""
    rng = np.random.default_rng(1)
    fooled = 0
    for size in 10.0 ** rng.uniform(-5, -4, 200):
        a, b, c = np.linalg.qr(rng.standard_normal((6, 3)))[0].T
        columns = np.array([a, a + size * (b + c), a + size * (b - c), b, c])
        columns /= np.linalg.norm(columns, axis=1)[:, None]
        gram = (columns @ columns.T)[..., None]
        assert not definite(gram, 1e-10)
        assert definite(gram[np.ix_([0, 3, 4], [0, 3, 4])], 1e-10)
        fooled += bool(Cholesky(gram).smallest_pivot > 1e-10)
    assert fooled > 5
    assert definite(np.zeros((0, 0, 3)), 1e-10).tolist() == [True] * 3


def same_but_intensities(found, monkeypatch):
    """Compare a result with that of orthonormal bases in all limbs: physics does not know what describes a limb."""
    monkeypatch.setattr(wrench_bases, "DEGENERATE", 2.0)
    other = ks.analyze(found.configuration)
    assert other.basis_degenerate
    for name in ("twist", "stiffness", "compliance", "base_wrench", "strain_energy"):
        close(getattr(found, name), getattr(other, name))
    for name in ("joint_wrenches", "actuator_forces"):
        close(*(list(getattr(result, name).values()) for result in (found, other)))
    close(*([limb.wrench for limb in result.limbs.values()] for result in (found, other)))
    for name, beam in found.beams.items():
        close(beam.deflections, other.beams[name].deflections)
        close(beam.section_wrenches, other.beams[name].section_wrenches)


def close(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.parametrize("name", ["2pru_upr", "delta", "tricept", "orthoglide"])
def test_numbers_do_not_depend_on_the_wrenches_that_describe_limbs(name, monkeypatch):
    same_but_intensities(ks.analyze(ks.load_robot(robot_path(name)).assemble()), monkeypatch)
