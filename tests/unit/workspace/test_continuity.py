"""Which steps between poses of a map are too large for one assembly mode, and where ways to other poses start."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.workspace.assembly_modes.continuity import JointScale, suspect_edges
from kinetostatics.workspace.assembly_modes.repair import _Look

pytestmark = pytest.mark.smoke


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


@pytest.mark.parametrize(("tilt", "known"), [(0.0, False), (0.5e-9, False), (2e-9, True), (0.2, True)])
def test_an_untilted_start_has_no_azimuth(tilt, known):
    """Ways from there to tilted poses keep to the azimuth of their ends: that of the start is rounding."""
    start = SimpleNamespace(platform_coordinates=lambda orientation: {"azimuth": 1.5, "tilt": tilt, "torsion": 0.0})
    machine = SimpleNamespace(zero_poses=None, model_q=lambda poses: np.zeros((3, 1)), configuration=lambda *_, **__: start)
    spec = SimpleNamespace(
        kind="platform",
        orientation="tilt_torsion",
        robot=lambda combination: machine,
    )
    labels = SimpleNamespace(q=[("q", "rad")] * 3, loose=[False] * 3)
    found = _Look(spec, labels, None, None, np.zeros((2, 3)), np.ones(2, dtype=bool), 1.0).zero_coordinates()
    assert found == {"tilt": tilt, "torsion": 0.0} | ({"azimuth": 1.5} if known else {})
