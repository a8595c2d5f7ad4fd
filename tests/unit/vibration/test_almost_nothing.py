"""Almost no stiffness, almost equal frequencies, almost dependent loops: where modes tell them from rounding, by closed forms."""

import numpy as np
import pytest
from simple_machines import BEAM, joint, link, loop, robot

import kinetostatics as ks
from kinetostatics.vibration import motions


def spring(name, link_name, at, there, stiffness):
    """A spring from the base to a link, without force as it stands."""
    length = float(np.linalg.norm(np.subtract(there, at)))
    start, end = (f'<origin xyz="{" ".join(map(str, point))}"/>' for point in (at, there))
    return (
        f'<spring name="{name}" stiffness="{stiffness!r}" free_length="{length!r}"><predecessor link="base">{start}</predecessor>'
        f'<successor link="{link_name}">{end}</successor></spring>'
    )


@pytest.mark.parametrize(("soft", "counts"), [(1e-3, True), (1e-6, False)])
def test_soft_spring_beside_a_stiff_one_counts_until_it_is_rounding(soft, counts):
    """An arm of two passive hinges about z along x, with a spring of 4e5 N/m across its end and a soft one across its middle.

    Its deflections y₁ at 1 m and y₂ at 2 m have K = diag(c, k) and, with masses m, M there and rotary inertias J of both links,
    M = [[m + 2 J, −J], [−J, M + J]].
    """
    stiff, middle, end, J = 4e5, 2.0, 3.0, 1.0
    machine = robot(
        link("base"), link("upper", middle, "1 0 0"), link("platform", end, "1 0 0"),
        joint("shoulder", "continuous", "base", "upper", axis="0 0 1"),
        joint("elbow", "continuous", "upper", "platform", "1 0 0", "0 0 1"),
        spring("stiff", "platform", (2, 3, 0), (1, 0, 0), stiff), spring("soft", "upper", (1, 3, 0), (1, 0, 0), soft),
    )  # fmt: skip
    found = ks.modes(machine.assemble(), 2, gravity=(0, 0, 0))
    mass = np.array([[middle + 2 * J, -J], [-J, end + J]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, np.diag([soft, stiff]))).real)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies, expected if counts else [expected[1], np.inf], rtol=1e-5)
    assert found.zero_frequencies == (not counts)


@pytest.mark.parametrize(("wider", "equal"), [(1e-6, False), (1e-10, True)])
def test_bending_modes_lie_along_the_axes_of_a_section_that_is_almost_square(wider, equal):
    """The squares of the frequencies differ by twice its relative excess of width; only modes of equal frequencies may be turned
    into one another, and then the first one moves the platform along x."""
    azimuth, side = 0.5, 0.03
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    machine = robot(
        link("base"), link("rod"), link("platform", 3.0), joint("foot", "fixed", "base", "rod"),
        joint("head", "fixed", "rod", "platform", "0 0 0.8"),
        f'<beam link="rod" from="foot" to="head" density="0" {BEAM} y_axis="{" ".join(map(repr, across.tolist()))}">'
        f'<rectangle width="{side * (1 + wider)!r}" height="{side}"/></beam>',
    )  # fmt: skip
    weak, strong = ks.modes(machine.assemble(), 3).twists[1:, :2]  # the first is torsion
    along = np.eye(2) if equal else np.array([[-across[1], across[0]], across[:2]])
    for moved, direction in zip((weak, strong), along, strict=True):
        assert abs(moved @ direction) > 0.1
        np.testing.assert_allclose(moved, (moved @ direction) * direction, atol=1e-6)


@pytest.mark.parametrize("tilt", [0.0, 1e-11, 1e-10])
def test_loop_with_an_axis_tilted_by_rounding_stays_movable(tilt):
    """A parallelogram of links without mass swings on its drive: ω² = k / (m r²), of the mass m that moves on circles of r."""
    drive, mass, r = 900.0, 2.5, 0.3
    axis = f"{float(np.sin(tilt))!r} {float(np.cos(tilt))!r} 0"
    machine = robot(
        link("base"), link("left"), link("right"), link("platform", mass), joint("a", "revolute", "base", "left"),
        joint("b", "continuous", "left", "platform", f"0 0 {r}"),
        joint("d", "continuous", "base", "right", "0.4 0 0", axis),
        loop("c", "revolute", "right", "platform", f"0 0 {r}", "0.4 0 0", "0 1 0"),
        '<joint_stiffness joint="a" drive="900"/><transmission name="drive"><joint name="a"/></transmission>',
    )  # fmt: skip
    found = ks.modes(machine.assemble(actuators={"a": 0.4}), 1, gravity=(0, 0, 0))
    assert found.zero_frequencies == 0
    assert found.frequencies[0] == pytest.approx(np.sqrt(drive / (mass * r**2)) / (2 * np.pi), rel=1e-8)


def test_mass_on_the_axis_of_an_elastic_hinge_has_no_mode_at_this_pose():
    """A point mass m on a slide at the distance q from a hinge of the stiffness k: ω² = k / (m q²), and no mode at q = 0."""
    text = link("platform", 2.5).replace('"1"', '"0"')
    machine = robot(
        link("base"), link("arm"), text, joint("hinge", "revolute", "base", "arm", axis="0 0 1"),
        joint("slide", "prismatic", "arm", "platform", axis="1 0 0"), '<joint_stiffness joint="hinge" drive="900"/>',
        *(f'<transmission name="{name}"><joint name="{name}"/></transmission>' for name in ("hinge", "slide")),
    )  # fmt: skip
    with np.errstate(all="raise"):
        found = ks.modes(machine.assemble(actuators={"hinge": 0.2, "slide": [0.3, 0.0, 0.6]}), 1)
        frequencies, twists = found.frequencies[:, 0], found.twists
    np.testing.assert_allclose(frequencies[[0, 2]], np.sqrt(900 / 2.5) / np.array([0.3, 0.6]) / (2 * np.pi), rtol=1e-9)
    assert np.isinf(frequencies[1]) and found.zero_frequencies.tolist() == [0, 0, 0]
    assert np.isfinite(twists[[0, 2]]).all() and np.isnan(twists[1]).all()


def test_response_does_not_depend_on_how_much_is_solved_at_once(monkeypatch):
    pose, frequencies = ks.load_robot("3rps").assemble(), [5.0, 40.0, 200.0]
    expected = ks.frequency_response(pose, frequencies).compliance
    monkeypatch.setattr(motions, "_AT_ONCE", 1)
    np.testing.assert_allclose(ks.frequency_response(pose, frequencies).compliance, expected, rtol=1e-12)
