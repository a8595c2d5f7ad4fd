"""Contributions to the twist."""

import numpy as np

from kinetostatics.results.contributions import by_mechanism_of_gravity


def test_parts_due_to_gravity_are_summed_over_the_limbs_and_the_platforms_weight_stands_alone():
    platform = np.array([1.0, 2.0])
    limbs = {"limb_1": {"attached": platform * 10, "deformation": platform * 100}}
    limbs["limb_2"] = {"attached": platform * 20, "deformation": platform * 300}
    parts = by_mechanism_of_gravity(platform, limbs)
    assert list(parts) == ["platform_weight", "attached", "deformation"]
    np.testing.assert_array_equal(list(parts.values()), [platform, 30 * platform, 400 * platform])
    np.testing.assert_array_equal(list(by_mechanism_of_gravity(platform, {}).values()), [platform, 0 * platform, 0 * platform])
