"""What the second look at a map is given of the first."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.workspace.schema import NO_MODE, ZERO_MODE
from kinetostatics.workspace.targets import Target


@pytest.mark.parametrize("loose", [False, True])
@pytest.mark.parametrize("combination", [(), (3,)])
def test_where_joints_are_loose_the_place_of_o_is_given_with_them(loose, combination):
    random, robots = np.random.default_rng(0), (1,) * len(combination)
    arrays = {
        "q": random.random((*robots, 4, 5, 2)),
        "platform_pose": random.random((*robots, 4, 5, 6)),
        "characteristic_length": np.full(robots, 0.3),
        "mode": random.choice([ZERO_MODE, NO_MODE], (*robots, 4, 5)),
    }
    one = (0,) * len(combination)
    target = SimpleNamespace(
        labels=SimpleNamespace(loose=(False, loose)), _block=lambda *_: None, read=lambda name, _: arrays[name]
    )
    known = Target.to_finish(target, combination, (), (slice(0, 4), slice(0, 5))).keywords
    np.testing.assert_array_equal(known["q"][..., :2], arrays["q"][one])
    np.testing.assert_array_equal(known["q"][..., 2:], arrays["platform_pose"][one][..., : 3 * loose])
    np.testing.assert_array_equal(known["reached"], arrays["mode"][one] == ZERO_MODE)
    assert known["length"] == 0.3 and known["combination"] == combination
