"""The three ways in which gravity acts: each is the sum over all limbs, the platform's weight stands alone."""

from types import SimpleNamespace

import numpy as np

from kinetostatics.results.gravity_mechanisms import actuator_gravity_mechanisms, gravity_mechanisms


def test_ways_of_all_limbs_are_added_up():
    platform = np.array([1.0, 2.0])
    limbs = {"limb_1": {"attached": platform * 10, "deformation": platform * 100}}
    limbs["limb_2"] = {"attached": platform * 20, "deformation": platform * 300}
    found = SimpleNamespace(
        contributions={"platform_weight": platform, "load": platform * 7}, mechanism_contributions=limbs,
        actuator_contributions={"drive": {"platform_weight": -platform, "load": platform}},
        actuator_mechanism_contributions={"drive": limbs},
    )  # fmt: skip
    ways = gravity_mechanisms(found)
    assert list(ways) == ["platform_weight", "attached", "deformation"]
    np.testing.assert_array_equal(list(ways.values()), [platform, 30 * platform, 400 * platform])
    [(drive, ways)] = actuator_gravity_mechanisms(found).items()
    assert drive == "drive"
    np.testing.assert_array_equal(list(ways.values()), [-platform, 30 * platform, 400 * platform])
    none = SimpleNamespace(contributions={"platform_weight": platform}, mechanism_contributions={})
    np.testing.assert_array_equal(list(gravity_mechanisms(none).values()), [platform, 0 * platform, 0 * platform])
