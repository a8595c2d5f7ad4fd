"""Joint wrenches that rigid parts leave open are NaN, and no others."""

import numpy as np
from simple_machines import CIRCLE, RHO, bar, joint, link, loop, robot

import kinetostatics as ks


def test_two_rigid_hinges_on_one_line_share_in_a_way_that_nobody_knows():
    """A foot on two hinges, one of them driven, carries a rod and the platform."""
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
