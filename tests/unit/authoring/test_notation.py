"""The notation of parallel robots: meaning of architectures, and places of errors."""

import pytest

import kinetostatics as ks
from kinetostatics.authoring.limb_parts import skeleton_of
from kinetostatics.authoring.notation import parse_architecture


@pytest.mark.parametrize(
    ("written", "means"),
    [
        ("3-RPS", "3-R[P]S"),
        ("3RPS", "3-R[P]S"),
        ("3-RP\u0332S", "3-R[P]S"),
        ("3-RRS", "3-[R]RS"),
        ("2PRU-UPR", "2-[P]RU+U[P]R"),
        ("2-[P]RU + U[P]R", "2-[P]RU+U[P]R"),
        ("6-SPS", "6-S[P]S"),
        ("3-UPS+UP", "3-U[P]S+UP"),  # the tube of a Tricept has no actuator
        ("2-UPR+SPR", "2-U[P]R+S[P]R"),  # each limb of an Exechon has one
        ("4-[R]2(SS)", "4-[R](4S)"),
        ("3-[R](2-SS)", "3-[R](4S)"),
        ("3-PRPaR", "3-[P]R(4R)R"),
        ("3-[PR]S", "3-[P][R]S"),
        ("3-CRR", "3-[C]RR"),
    ],
)
def test_spellings_of_architectures_are_equivalent(written, means):
    found = parse_architecture(written)
    assert found.text == means and parse_architecture(means).text == means
    assert found.actuators_chosen == (not any(mark in written for mark in "[\u0332"))


@pytest.mark.parametrize(
    ("architecture", "freedoms", "drives"),
    [("3-RPS", 3, 3), ("6-UPS", 6, 6), ("3-UPS+UP", 3, 3), ("2-PRU+UPR", 0, 3), ("3-PRRR", 0, 3), ("6-SPS", 12, 6)],
)
def test_freedoms_and_actuators_follow_gruebler(architecture, freedoms, drives):
    """Overconstrained mechanisms have more freedoms than the formula says; 6-SPS has six spins besides."""
    found = parse_architecture(architecture)
    assert (found.formula_freedoms, found.actuators) == (freedoms, drives)


@pytest.mark.parametrize(
    ("architecture", "place", "words"),
    [
        ("3-R[P]X", 7, "no joint has this sign"),
        ("2-[P]RU+U[P", 10, "not closed"),
        ("3-UPS+U(PP", 8, "no joint has this sign"),
        ("3-UPS+RRRRR", 10, "more than 3 rotational joints"),
        ("3-UPS+PPS", 8, "two prismatic joints in a row"),
        ("3-R[S]P", 5, "cannot be actuated"),
        ("3-R[]S", 4, "the bracket is empty"),
        ("13-R[P]S", 1, "13 limbs"),
        ("3-UPS+", 6, "a limb is missing behind it"),
    ],
)
def test_errors_name_the_place_in_the_architecture(architecture, place, words):
    with pytest.raises(ks.ArgumentError, match=words) as caught:
        ks.new_robot(architecture)
    assert f"architecture {architecture!r}, place {place} ({architecture[place - 1]!r}): " in str(caught.value)


@pytest.mark.parametrize(
    ("limb", "axes"),
    [
        ("UPS", ["nx", ""]),
        ("PRU", ["", "nx"]),
        ("UPR", ["xn", ""]),
        ("PUU", ["nx", "xn"]),
        ("RUS", ["", "nx", ""]),
        ("UP", ["xn", ""]),
    ],
)
def test_axes_of_universal_joints_follow_their_neighbours(limb, axes):
    """n is the direction of the limb's revolute axes: a universal joint has it on the side of a revolute neighbour."""
    architecture = parse_architecture(f"3-{limb}")
    assert [point.axes for point in skeleton_of(architecture, architecture.groups[0]).points] == axes
