"""Examples run, and their numbers agree with the paper, with the package and with the balance of energy."""

import pytest
import reproduce_paper


def test_reproduce_paper_prints_the_tables():
    printed = reproduce_paper.tables()
    assert "| 2 | f_1a [N] | 385.435 | 386.220 | 385.435 | +0.00 % | -0.20 % |" in printed


def test_left_out_attached_wrench_gives_the_papers_analytical_forces():
    """The remark under Table 4: without J_3g2 W_3g2 in Eq. (12) the paper's f_11, f_21 of configuration 2 appear."""
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


def test_actuator_power_equals_the_rate_of_energy():
    """Of kinetic and potential energy; in a slow motion the actuator forces are those that hold the robot at rest."""
    import numpy as np
    from dynamics_with_pinocchio import circle

    motion = circle(period=0.5, count=40)
    waves = 2j * np.pi * np.fft.rfftfreq(40, 0.5 / 40)  # the motion is periodic
    rate = np.fft.irfft(waves * np.fft.rfft(motion.energy), 40)
    np.testing.assert_allclose(motion.power, rate, rtol=0, atol=2e-3 * np.abs(rate).max())  # steps of a 240th of the period
    assert np.abs(motion.forces - motion.holding).max() > 0.1 * np.abs(motion.holding).max()
    slow = circle(period=500.0, count=6)
    np.testing.assert_allclose(slow.forces, slow.holding, rtol=1e-5)


@pytest.mark.parametrize("name", ["3rps", "2pru_upr"])
def test_lumped_weights_equal_loads_on_massless_rods(name):
    """The example changes Eq. (12); the same robots with rods without mass, loaded at o and at the rods' ends, agree."""
    import distributed_gravity as example
    import numpy as np

    import kinetostatics as ks

    spread = example.reproduce_paper.analyze(name, 2)
    description = spread.robot.description
    for rod in description.beams:
        description = description.changed(rod, density=0.0)
    pose = ks.Robot(description).configuration(spread.configuration.q)
    limbs = example.limbs_of(name, spread)
    weights = [item.R @ item.q * item.length for item in limbs]
    platform = ks.analyze(pose, load=np.r_[sum(weights), 0, 0, 0], gravity=spread.gravity)
    np.testing.assert_allclose(example.twist_of(name, 2, example.PLATFORM), platform.twist, rtol=1e-9, atol=1e-18)
    ends = sum(item.force(weight / 2, item.A) for item, weight in zip(limbs, weights, strict=True))
    found = ks.analyze(pose, load=ends, gravity=spread.gravity)
    np.testing.assert_allclose(example.twist_of(name, 2, example.ENDS), found.twist, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(example.twist_of(name, 2, example.SPREAD), spread.twist, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(example.twist_of(name, 2, 400), spread.twist, rtol=1e-3, atol=1e-10)  # cut finely


def test_page_beside_other_methods_is_up_to_date():
    import distributed_gravity as example

    page = example.PAGE.read_text(encoding="utf-8")
    assert example.table() in page and example.springs() in page, "stale: run python examples/distributed_gravity.py --write"
    assert "| 3RPS, 2 | at the platform | 2.231e-07 |" in page and "| 3RPS, 2 | spread | 4.969e-08 |" in page


#: Load at o [N], and sag [µm] and first frequency [Hz] that the page states, with elastic and with rigid parts from CAD.
CASTINGS = {
    "3rps_plate": ((0, 0, -500), (59.9, 27.3), (0.130, 131.9)),
    "delta_bearings": ((0, 0, -30), (20.6, 75.5), (19.7, 77.2)),
    "five_bar_castings": ((0, 0, -50), (930.0, 38.5), (0.0, float("inf"))),
}


@pytest.mark.parametrize("name", CASTINGS)
def test_robots_of_castings_are_softer_than_with_rigid_parts(name):
    """Without warnings; every part has a surface, and its weight is in one contribution."""
    import numpy as np
    import robots_of_castings as example

    import kinetostatics as ks
    from kinetostatics.viewer.drawn_poses import ShownPoses

    robot = ks.load_robot(example.FOLDER / f"{name}.urdf")
    force, *numbers = CASTINGS[name]
    for machine, (sag, frequency) in zip((robot, ks.Robot(example.rigid(robot.description))), numbers, strict=True):
        result = ks.analyze(machine.assemble(), load=[*force, 0, 0, 0])
        assert -1e6 * result.twist[2] == pytest.approx(sag, rel=0.006)
        assert ks.modes(machine.assemble(), 1).frequencies[0] == pytest.approx(frequency, rel=0.002)
        assert machine is not robot or result.warnings == ()
    poses = ShownPoses(ks.analyze(robot.assemble()))
    for part in robot.description.flexible:
        assert poses.surface(part) is not None
        given = poses.squares_and_gravity(part)[1][0]
        assert np.count_nonzero(given[:, 2]) == 1 and np.allclose(given.sum(axis=0), poses.result.gravity)


@pytest.mark.slow
def test_parts_of_a_robot_come_from_the_script(tmp_path, monkeypatch):
    import numpy as np
    import robots_of_castings as example

    import kinetostatics as ks

    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "cache"))
    made, stored = example.condensed("crossbar", tmp_path).link, ks.files.read_link(example.FOLDER / "delta_bearings_elbow_1.npz")
    assert np.allclose(made.flexibility("weld"), stored.flexibility("weld_1"), rtol=1e-6) and made.body[0] == stored.body[0]
