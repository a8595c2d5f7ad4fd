"""Warnings of probable input errors begin where the constants say: just inside there is none, just outside there is one."""

import numpy as np
import pytest
from simple_machines import joint, link, robot

from kinetostatics.checks.check import diagnose

E = 2e11


def mast(length=1.0, diameter=0.05, density=7850.0, shear=E / 2.6, alpha=1e-5, rod_mass=0.0, top_mass=3.0, more="", head="fixed"):
    """An upright rod, clamped to the base, with a mass on its top."""
    beam = (
        f'<beam link="rod" from="foot" to="head" density="{density!r}" youngs_modulus="{E}" shear_modulus="{shear!r}" '
        f'shear_coefficient="0.9" thermal_expansion="{alpha!r}"><circle diameter="{diameter!r}"/></beam>'
    )
    parts = link("base"), link("rod", rod_mass), link("platform", top_mass), joint("foot", "fixed", "base", "rod")
    return robot(*parts, joint("head", head, "rod", "platform", f"0 0 {length!r}"), beam, more)


def warned(words, **given):
    return any(words in warning for warning in diagnose(mast(**given)).warnings)


def test_ordinary_values_cause_no_warnings():
    assert not diagnose(mast()).warnings


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1 / 20.1, "thicker"), (1 / 19.9, "only 0.05 times"), (4.9999, "only 5 times"), (5.0, None), (5.0 * (1 - 1e-10), None),
        (1999.0, None), (2001.0, "2e+03 times as long as thick"),
    ],
)  # fmt: skip
def test_beams_stubby_or_thin_as_wires(ratio, words):
    found = [text for text in diagnose(mast(2.0, 2.0 / ratio)).warnings if "rod" in text]
    assert len(found) == (words is not None) and all(words in text for text in found)


@pytest.mark.parametrize(("ratio", "odd"), [(0.99, True), (1.01, False), (999.0, False), (1001.0, True)])
def test_moduli_of_no_material(ratio, odd):
    assert warned("are inconsistent", shear=E / ratio) == odd


@pytest.mark.parametrize(("alpha", "odd"), [(-2.1e-5, True), (-1.9e-5, False), (0.9e-3, False), (1.1e-3, True)])
def test_thermal_expansion_of_no_solid(alpha, odd):
    assert warned("the thermal expansion", alpha=alpha) == odd


@pytest.mark.parametrize(("size", "odd"), [(0.99e-3, True), (1.01e-3, False), (99.0, False), (101.0, True)])
def test_sizes_of_robots_in_millimetres_or_beyond(size, odd):
    length = size / mast(head="continuous").zero_size
    assert warned("large; write lengths in m", length=length, diameter=length / 20, head="continuous") == odd


@pytest.mark.parametrize("factor", [1.0, -1.0])
@pytest.mark.parametrize(("ratio", "odd"), [(1.0, False), (1.29, False), (1.31, True), (5.0, True)])
def test_masses_by_density_and_by_inertial(ratio, factor, odd):
    """Up to 1.3 times, in either direction, are drawings that differ in details."""
    weight = 7850.0 * np.pi / 4 * 0.05**2
    assert warned("replaces the", rod_mass=float(weight * ratio**factor)) == odd


def test_density_of_zero_beside_a_mass():
    assert warned("no mass, because the density is 0", density=0.0, rod_mass=1.0) and not warned("no mass", density=0.0)
    assert warned("nothing in the file has a mass", density=0.0, top_mass=0.0)


@pytest.mark.parametrize(("kind", "turns", "unit"), [("linear", 0, "N/m"), ("angular", 1, "N·m/rad")])
def test_stiffnesses_under_which_a_robot_would_fall_or_that_no_joint_has(kind, turns, unit):
    """Its own weight moves it by 10 mm, or turns it by 0.2 rad with a lever of its characteristic length."""
    plain = mast()
    weight = 9.81 * diagnose(plain).mass
    soft = weight * (plain.length if turns else 1.0) / (0.01, 0.2)[turns]

    def texts(value):
        more = f'<joint_stiffness joint="foot" {kind}="{value!r} inf inf"/>'
        return [text for text in diagnose(mast(more=more)).warnings if "foot" in text]

    assert texts(1.02 * soft) == texts(0.98e12) == []
    assert len(texts(0.98 * soft)) == 1 and f"stiffnesses are in {unit}" in texts(0.98 * soft)[0]
    assert len(texts(1.02e12)) == 1 and "more than that of any real joint" in texts(1.02e12)[0]


@pytest.mark.parametrize(
    ("inside", "warns"),
    [
        ('<visual><geometry><box size="1 1 1"/></geometry></visual>', True),
        ('<collision><geometry><box size="1 1 1"/></geometry></collision>', True),
        ("", False),
        (
            '<visual><geometry><box size="1 1 1"/></geometry></visual><inertial><mass value="0"/>'
            '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>',
            False,
        ),
    ],
)
def test_drawn_links_without_a_mass(inside, warns):
    """On a hinge of its own; a mass of 0 is meant. Welded to a link with a mass, it is a part of that link."""
    for welded in (False, True):
        parts = f'<link name="cover">{inside}</link>', joint("lid", "fixed" if welded else "continuous", "platform", "cover")
        found = [text for text in diagnose(mast(more="".join(parts))).warnings if "has a shape but no mass" in text]
        assert len(found) == (warns and not welded)
