"""A telescope pushed together beyond its own start: no numbers, and one plain error, whatever else holds the platform.

The robot is a mast of two telescopes in series, both driven, so that the compliance of the mast would stay positive although
one of them had a negative length.
"""

from dataclasses import replace

import numpy as np
import pytest
from telescopes import mast

import kinetostatics as ks


def posed(robot: ks.Robot, *slides: float | list[float]) -> ks.Configuration:
    return robot.assemble(actuators=dict(zip(("slide_a", "slide_b"), slides, strict=True)))


def test_one_pose_raises_an_error_that_names_the_telescope() -> None:
    pose = posed(mast(), -0.6, 0.3)
    with pytest.raises(ks.StaticsError, match=r"'beam_a' \(-0.1 m from start to end\)") as caught:
        ks.analyze(pose, load=[1, 2, -3, 0, 0, 0])
    assert "beam_b" not in str(caught.value)
    with pytest.raises(ks.StaticsError, match=r"'beam_a' \(-0.1 m from start to end\)"):
        pose.model  # noqa: B018


def test_poses_before_and_beyond_are_told_apart() -> None:
    """Where the second telescope is longer than the first is turned inside out, the mast's compliance stays positive."""
    poses = posed(mast(), [-0.4, -0.49, -0.6, -0.7], [0.3] * 4)
    result = ks.analyze(poses)
    assert result.status.tolist() == [ks.Status.OK, ks.Status.OK, ks.Status.SINGULAR, ks.Status.SINGULAR]
    assert np.isfinite(result.twist[:2]).all()
    assert np.isnan(result.twist[2:]).all()


def test_an_open_branch_may_be_pushed_together_to_nothing() -> None:
    """What hangs on the platform by a telescope without length is bent by nothing, and weighs what there is of it."""
    whole = mast().description
    branch = ks.Robot(replace(whole, platform="end_a"))
    with np.errstate(all="raise"):
        found = ks.analyze(posed(branch, 0.0, -0.5), [10, 0, 0, 0, 0, 0])
        motion = sum(found.link_contributions["end_b"].values())
        assert not found.buckles
    np.testing.assert_allclose(motion, found.twist, rtol=1e-12)  # their origins are one point
