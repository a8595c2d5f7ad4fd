"""Margins: utilization of efforts, safety factors against yield and buckling, warnings about exceeded limits."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.design.problem import parse_requirement

PUSHED = [0, 0, -6e4, 0, 0, 0]


def tripod(**values):
    description = package_robots.robot("3rps").description
    return ks.Robot(description.changed("rod_1", **values) if values else description).assemble(
        platform={"z": 0.5, "rx": 0.0, "ry": 0.0}
    )


def test_utilization_is_the_force_over_the_effort_of_the_file():
    result = ks.analyze(package_robots.robot("3rps").assemble(), load=PUSHED)
    for name, ratio in result.utilization.items():
        assert ratio == abs(result.actuator_forces[name]) / 2000
    assert result.effort_exceeded and result.facts["effort_exceeded"] and result.status == ks.Status.OK
    assert not ks.analyze(package_robots.robot("3rps").assemble()).effort_exceeded


def test_efforts_that_the_file_does_not_state_are_unknown():
    """An effort of 0 means unknown, as in URDF."""
    description = package_robots.robot("3rps").description
    unknown = ks.Robot(description.changed("prismatic_1", effort=0.0))
    result = ks.analyze(unknown.assemble(), load=PUSHED)
    assert np.isnan(result.utilization["prismatic_1"]) and np.isfinite(result.utilization["prismatic_2"])
    assert "effort of prismatic_1" not in result.margins.limits
    assert not any("prismatic_1" in words for words in result.warnings)


def test_safety_factors_are_the_ratios_of_limits_to_values():
    result = ks.analyze(tripod(yield_strength=250e6), load=[0, 2e4, -6e4, 0, 0, 0])
    factors = result.margins.safety_factors
    assert factors["yield of rod_1"] == pytest.approx(250e6 / result.beams["rod_1"].stress, rel=1e-14)
    assert factors["buckling of rod_2"] == pytest.approx(1 / result.beams["rod_2"].euler_ratio, rel=1e-12)
    assert result.margins.smallest == min(factors.values())
    np.testing.assert_allclose(factors[str(result.margins.limited_by)], result.margins.smallest, rtol=1e-12)


def test_smallest_safety_factor_is_the_same_in_a_batch_and_alone():
    """A batch may leave out buckling where a bound shows that it does not matter."""
    pose, loads = tripod(yield_strength=1e6), np.array([[0, 0, -k, 0, 0, 0] for k in (0, 1e3, 1e5, 1e7)])
    batch = ks.analyze(pose, load=loads).margins
    for k, load in enumerate(loads):
        alone = ks.analyze(pose, load=load).margins
        assert alone.limited_by == batch.limited_by[k]
        np.testing.assert_allclose(alone.smallest, batch.smallest[k], rtol=1e-12)
        assert batch.smallest[k] == min(float(factor[k]) for factor in batch.safety_factors.values())


def test_exceeded_limits_are_named_with_their_numbers():
    result = ks.analyze(tripod(yield_strength=1e6), load=PUSHED)
    assert "the force of prismatic_1 is beyond the limit of effort of 2000 N: 20769 N" in result.warnings
    stress = f"{result.beams['rod_1'].stress / 1e6:.5g}"
    assert f"the stress in rod_1 is beyond the yield strength of 1 MPa: {stress} MPa" in result.warnings
    batch = ks.analyze(tripod(), load=[[0, 0, -1, 0, 0, 0], PUSHED])
    assert "the force of prismatic_2 is beyond the limit of effort of 2000 N in 1 of 2 poses, up to 20769 N" in batch.warnings


def test_yield_strength_is_written_and_read():
    description = tripod(yield_strength=250e6).robot.description
    assert (
        description.beams["rod_1"].material.yield_strength == 250e6 and description.beams["rod_2"].material.yield_strength is None
    )
    assert 'yield_strength="250000000"' in description.urdf


def test_fast_motion_is_beyond_the_limit_of_velocity():
    robot = package_robots.robot("3rps")
    ways = {"z": [0.5, 0.6], "rx": [0.0, 0.0], "ry": [0.0, 0.0]}
    fast, slow = (ks.trajectory(robot, [0, seconds], platform=ways) for seconds in (0.05, 5.0))
    most = max(abs(fast.actuator_velocities["prismatic_1"]))
    assert f"prismatic_1 moves at up to {most:.5g} m/s, beyond its limit of velocity of 1 m/s" in fast.warnings
    assert slow.warnings == ()
    path = slow.analyze(load=PUSHED)
    assert max(path.over_time("utilization")["prismatic_1"]) > 10


def test_requirements_may_refer_to_the_limits_of_the_file():
    assert parse_requirement("actuator_force < limit").name == "utilization"
    found = ks.optimize(
        "2pru_upr", {"rod_diameter": (0.02, 0.12)}, subject_to=["actuator_force < limit", "safety_factor > 3"], starts=1
    )
    assert found.feasible and float(found.result.margins.smallest.min()) >= 3 - 1e-5


def test_check_tells_which_actuators_cannot_hold_the_weight():
    description = package_robots.robot("3rps").description
    weak = ks.Robot(description.changed("prismatic_1", effort=300.0)).report().to_dict()["warnings"]
    (warning,) = weak
    assert warning.startswith("at the zero pose the force of prismatic_1 is beyond the limit of effort of 300 N: 3")


def test_beam_without_outline_has_no_yield_strength():
    section = ks.sections.Section(1e-3, 1e-6, 1e-6, 1e-6)
    with pytest.raises(ks.RobotFileError, match="has a yield_strength, but no stress: the outline of <section> is unknown"):
        tripod(section=section, yield_strength=1e8)
