"""Every example runs, and one number of each is right."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "examples"))


def test_reproduce_paper_prints_the_tables():
    command = [sys.executable, str(ROOT / "examples" / "reproduce_paper.py")]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, encoding="utf-8").stdout
    assert "| 2 | f_1a [N] | 385.435 | 386.220 | 385.435 | +0.00 % | -0.20 % |" in printed


def test_left_out_attached_wrench_gives_the_papers_analytical_forces():
    """The remark under Table 4: without J_3g2 W_3g2 in Eq. (12) the paper's f_11, f_21 of configuration 2 appear."""
    reproduce_paper = pytest.importorskip("reproduce_paper")
    result = reproduce_paper.analyze("2pru_upr", 2)
    limb = result.limbs["limb_3"]
    assert limb.attached_labels[1].startswith("force along limb y")
    left_out = limb.attached_wrenches[:, 1] * limb.attached_intensities[1]
    changed = result.twist + result.compliance @ left_out
    for name, printed in (("limb_1", 123.34), ("limb_2", 119.88)):
        limb = result.limbs[name]
        forces = limb.intensities + _stiffness(limb) @ limb.constraint_wrenches.T @ (changed - result.twist)
        assert abs(abs(forces[0]) - printed) < 1e-4 * printed, (name, forces)


def _stiffness(limb):
    import numpy as np

    return np.linalg.inv(limb.compliance)


def test_dynamics_with_pinocchio_put_into_the_robot_what_it_gains():
    """The drives' work is the change of kinetic and potential energy; a slow motion needs what holds the robot at rest."""
    import numpy as np
    from dynamics_with_pinocchio import circle

    motion = circle(period=0.5, count=40)
    waves = 2j * np.pi * np.fft.rfftfreq(40, 0.5 / 40)  # the motion is periodic
    rate = np.fft.irfft(waves * np.fft.rfft(motion.energy), 40)
    np.testing.assert_allclose(motion.power, rate, rtol=0, atol=2e-3 * np.abs(rate).max())  # steps of a 240th of the period
    assert np.abs(motion.forces - motion.holding).max() > 0.1 * np.abs(motion.holding).max()
    slow = circle(period=500.0, count=6)
    np.testing.assert_allclose(slow.forces, slow.holding, rtol=1e-5)
