"""Beams at their limits: telescopes of almost no length, and a section's y axis almost along the beam."""

import numpy as np
import pytest
import telescopes
from simple_machines import BEAM, joint, link, robot

import kinetostatics as ks


@pytest.mark.parametrize(("reach", "counts"), [(1e-8, True), (1e-10, False), (-1e-10, False), (-1e-8, True)])
def test_telescope_without_length_but_for_rounding(reach, counts):
    """Its ends are half a metre above the ground: their coordinates are known to 5e-10 m, and a telescope that is retracted
    further has no length at which it could bear a force."""
    machine = telescopes.mast()
    pose = machine.configuration([0.0, -0.5 + reach])
    assert machine.beams["beam_b"].remaining_length(pose.frames)[0] == pytest.approx(reach if counts else 0.0, abs=1e-15)
    if counts and reach < 0:
        with pytest.raises(ks.StaticsError, match=r"no length at this pose: 'beam_b' \(-1e-08 m"):
            ks.analyze(pose)
    else:
        lower, slide = 0.5, 7850 * np.pi * 0.01**2 * 9.81 / (210e9 * np.pi * 0.01**2)
        assert ks.analyze(pose).twist[2] == pytest.approx(-slide * lower**2 / 2, rel=1e-6)


def bar(y_axis, telescope, slide="0 0 1"):
    """An upright bar, 0.02 m wide along the projection of ``y_axis``, 0.06 m along the other direction across."""
    section = f'<beam link="bar" from="foot" to="head" density="0" y_axis="{y_axis}" {BEAM}>'
    reach = (link("rod"), joint("slide", "prismatic", "bar", "rod", "0 0 0.2", slide)) if telescope else ()
    return robot(
        link("base"), link("bar"), link("platform"), joint("foot", "fixed", "base", "bar"), *reach,
        joint("head", "fixed", "rod" if telescope else "bar", "platform", "0 0 0.3" if telescope else "0 0 0.5"),
        section + '<rectangle width="0.02" height="0.06"/></beam>',
        '<transmission name="drive"><joint name="slide"/></transmission>' if telescope else "",
    )  # fmt: skip


@pytest.mark.parametrize("telescope", [False, True])
@pytest.mark.parametrize("angle", [1.5, 1e-2, 1e-4, 1e-5])
def test_y_axis_almost_along_the_beam_still_has_a_projection(angle, telescope):
    """The section's y, and with it the weak direction, is across the beam, at the azimuth of ``y_axis``."""
    azimuth = 0.7
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    machine = bar(" ".join(map(repr, (np.sin(angle) * across + [0, 0, np.cos(angle)]).tolist())), telescope)
    np.testing.assert_allclose(machine.beams["bar"].axes[:, 1], across, atol=1e-10)
    softness = ks.analyze(machine.assemble()).compliance[:2, :2]
    weak, strong = (0.5**3 / (3 * 2.0e11 * b * h**3 / 12) for b, h in ((0.06, 0.02), (0.02, 0.06)))
    np.testing.assert_allclose(softness @ across[:2], weak * across[:2], rtol=1e-9)
    np.testing.assert_allclose(softness @ [-across[1], across[0]], strong * np.array([-across[1], across[0]]), rtol=1e-9)


@pytest.mark.parametrize("telescope", [False, True])
@pytest.mark.parametrize("angle", [1e-7, 0.0])
def test_y_axis_along_the_beam_is_refused(angle, telescope):
    with pytest.raises(ks.RobotFileError, match=r"1: <beam 'bar'>: its y_axis is parallel to the beam; specify a direction"):
        ks.analyze(bar(f"{float(np.sin(angle))!r} 0 -1", telescope).assemble())


@pytest.mark.parametrize(("tilt", "along"), [(1e-6, True), (1e-4, False)])
def test_slide_inside_a_telescope_lies_along_it_up_to_rounding(tilt, along):
    machine = bar("0 1 0", True, f"{tilt!r} 0 1")
    if along:
        np.testing.assert_allclose(machine.beams["bar"].axes[:, 0], [0, 0, 1], atol=2e-6)
    else:
        with pytest.raises(ks.RobotFileError, match="the axis of the prismatic joint 'slide' inside its span does not lie along"):
            machine.beams["bar"]


def test_beams_of_a_link_share_its_mass_in_proportion_to_their_lengths():
    """Arms of 0.3 and 0.5 m of a link of 4 kg; together they weigh what the link weighs, at its centre of mass."""
    parts = [
        f'<beam link="fork" name="{name}" from="foot" to="{name}" {BEAM}><circle diameter="0.05"/></beam>'
        for name in ("side", "head")
    ]
    machine = robot(
        link("base"), link("fork", 4.0, "0.05 0.02 0.2"), link("knob"), link("platform"), joint("foot", "fixed", "base", "fork"),
        joint("side", "fixed", "fork", "knob", "0.3 0 0"), joint("head", "fixed", "fork", "platform", "0 0 0.5"), *parts,
    )  # fmt: skip
    assert [machine.beams[name].mass for name in ("side", "head")] == pytest.approx([1.5, 2.5], rel=1e-12)
    force, centre = np.array([0, 0, -4.0 * 9.81]), np.array([0.05, 0.02, 0.2])
    found = ks.analyze(machine.assemble(), gravity=(0, 0, -9.81)).joint_wrenches["foot"]
    np.testing.assert_allclose(np.abs(found), np.abs([*force, *np.cross(centre, force)]), atol=1e-9)
