"""The pages on feedforward and correction: their code runs, and what they say of it is so."""

import sys

import numpy as np
import pytest
from places import ROOT

sys.path.insert(0, str(ROOT / "examples"))
compensation_figures = pytest.importorskip("compensation_figures")


def test_feedforward():
    names = compensation_figures.page_names("feedforward")
    found = names["found"]
    assert not found.status.any()
    held = sum(found.result.joint_wrenches[name][:, 2] for name in ("revolute_1", "revolute_2", "revolute_3"))
    weights = found.result.base_wrench[:, 2]
    np.testing.assert_allclose(held, weights, rtol=1e-9)
    alone = compensation_figures.ks.analyze(names["path"])
    np.testing.assert_allclose(weights - alone.base_wrench[:, 2], 12 * 9.81, rtol=1e-5)  # the tool; corrected rods are longer
    here = compensation_figures.ks.analyze(names["path"], [0, 0, -12 * 9.81, 0, 0, 0])
    for drive, force in found.actuator_forces.items():
        np.testing.assert_allclose(force, here.actuator_forces[drive], rtol=1e-4)  # nearly what the uncorrected drives hold


def test_correction():
    names = compensation_figures.page_names("correct_a_machine")
    found, other = names["found"], names["other"]
    assert found.coordinates == ("z", "rx", "ry") and not found.status.any()
    for which in (found, other):
        assert max(np.abs(which.remaining_coordinates[name]).max() for name in which.coordinates) < 1e-12
    assert np.abs(found.remaining_coordinates["y"]).max() > np.abs(found.deviation_coordinates["y"]).max() > 1e-5
    assert np.abs(other.remaining_coordinates["rx"]).max() > 1e-4
