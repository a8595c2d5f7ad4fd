"""Parameters of a robot: names, units, values, steps of central differences, and changed descriptions."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from simple_machines import joint, link, robot, springs

import kinetostatics as ks
from kinetostatics.parametric.parametric_robot import (
    ParametricRobot,
    _with_beam_axes,
    check_unit,
    have_same_statics,
)
from kinetostatics.parametric.robot_numbers import numbers_of_parts

METAL = 'y_axis="0 1 0" youngs_modulus="2e11" density="7850"'


def machine(*more):
    """An arm of a hinge and a slide with every kind of parameter."""
    return robot(
        *(link("base"), link("upper", 2.0, "0.2 0 0"), link("fore"), link("platform", 0.5, "0 0.01 0")),
        joint("hinge", "revolute", "base", "upper"),
        joint("slide", "prismatic", "upper", "fore", "0.4 0 0", "1 0 0"),
        joint("wrist", "fixed", "fore", "platform", "0.3 0 0"),
        f'<beam link="upper" from="hinge" to="slide" {METAL} poisson_ratio="0.3" shear_coefficient="0.9">'
        '<rectangle height="0.04" width="0.02"/></beam>',
        f'<beam link="fore" from="slide" to="wrist" {METAL} shear_modulus="8e10">'
        '<section area="1e-3" I_y="2e-8" I_z="3e-8" J="4e-8" shear_area_y="5e-4" shear_area_z="6e-4"/></beam>',
        springs("hinge", linear="1e7 inf 2e7", drive="1e3"),
        springs("slide", drive="2e5"),
        springs("wrist", angular="0.5 inf 1e4"),
        '<spring name="rope" stiffness="300" free_length="0.1" preload="5"><predecessor link="base"><origin xyz="0 0 0.4"/>'
        '</predecessor><successor link="upper"/></spring>',
        *(f'<transmission name="t_{name}"><joint name="{name}"/></transmission>' for name in ("hinge", "slide")),
        *more,
    )


#: Unit of each parameter, and its value in a description.
SINGLE = {
    "upper.mass": ("kg", lambda d: d.links["upper"].mass),
    "platform.mass": ("kg", lambda d: d.links["platform"].mass),
    "upper.youngs_modulus": ("Pa", lambda d: d.beams["upper"].material.youngs_modulus),
    "upper.poisson_ratio": ("1", lambda d: d.beams["upper"].material.poisson_ratio),
    "upper.density": ("kg/m³", lambda d: d.beams["upper"].material.density),
    "upper.shear_coefficient": ("1", lambda d: d.beams["upper"].shear_coefficient),
    "upper.width": ("m", lambda d: d.beams["upper"].section.width),
    "upper.height": ("m", lambda d: d.beams["upper"].section.height),
    "fore.youngs_modulus": ("Pa", lambda d: d.beams["fore"].material.youngs_modulus),
    "fore.shear_modulus": ("Pa", lambda d: d.beams["fore"].material.shear_modulus),
    "fore.density": ("kg/m³", lambda d: d.beams["fore"].material.density),
    "fore.area": ("m²", lambda d: d.beams["fore"].section.area),
    "fore.I_y": ("m⁴", lambda d: d.beams["fore"].section.I_y),
    "fore.I_z": ("m⁴", lambda d: d.beams["fore"].section.I_z),
    "fore.J": ("m⁴", lambda d: d.beams["fore"].section.J),
    "fore.shear_area_y": ("m²", lambda d: d.beams["fore"].section.shear_area_y),
    "fore.shear_area_z": ("m²", lambda d: d.beams["fore"].section.shear_area_z),
    "hinge.actuator_stiffness": ("N·m/rad", lambda d: d.joint_stiffness["hinge"].drive),
    "slide.actuator_stiffness": ("N/m", lambda d: d.joint_stiffness["slide"].drive),
    "rope.stiffness": ("N/m", lambda d: d.springs["rope"].stiffness),
    "rope.free_length": ("m", lambda d: d.springs["rope"].free_length),
    "rope.preload": ("N", lambda d: d.springs["rope"].preload),
}
#: The same of parameters with three components, and their steps.
LENGTH = 0.175  # of the machine [m]
TRIPLE = {
    "upper.center_of_mass": ("m", lambda d: d.links["upper"].center_of_mass, [1e-3 * LENGTH] * 3),
    "platform.center_of_mass": ("m", lambda d: d.links["platform"].center_of_mass, [1e-3 * LENGTH] * 3),
    "hinge.linear_stiffness": ("N/m", lambda d: d.joint_stiffness["hinge"].linear, [1e4, None, 2e4]),
    "wrist.angular_stiffness": ("N·m/rad", lambda d: d.joint_stiffness["wrist"].angular, [0.5e-3, None, 10.0]),
}


def test_each_number_changes_alone():
    known = numbers_of_parts(machine())
    assert set(known) == {*SINGLE, *TRIPLE, *(f"{name}.placement" for name in ("hinge", "slide", "wrist"))}
    for name, (unit, number) in SINGLE.items():
        (item,) = known[name]
        value = number(item.description)
        assert (item.name, item.unit, item.value) == (name, unit, value) and item.step == pytest.approx(1e-3 * value)
        changed = item.changed(0.01 * value)
        assert number(changed) == item.of(changed) == pytest.approx(1.01 * value, rel=1e-14)
    for name, (unit, numbers, steps) in TRIPLE.items():
        for k, (item, axis) in enumerate(zip(known[name], "xyz", strict=True)):
            values = numbers(item.description)
            assert (item.name, item.unit, item.value) == (f"{name}.{axis}", unit, values[k])
            assert item.step == (steps[k] if steps[k] is None else pytest.approx(steps[k]))
            np.testing.assert_allclose(numbers(item.changed(0.01)), np.add(values, 0.01 * np.eye(3)[k]), rtol=1e-14)
    for name in ("hinge", "slide", "wrist"):
        items = known[f"{name}.placement"]
        assert [item.name.rpartition(".")[2] for item in items] == ["x", "y", "z", "rx", "ry", "rz"]
        assert [item.unit for item in items] == ["m"] * 3 + ["rad"] * 3
        assert [item.step for item in items] == pytest.approx([1e-3 * LENGTH] * 3 + [1e-3] * 3)
        assert {value for item in items for value in (item.value, item.of(item.changed(0.1)))} == {0.0}
    assert machine().length == pytest.approx(LENGTH)


def test_zero_and_infinite_numbers_are_no_parameters():
    """An infinite shear coefficient, a density of 0 and a free length of 0 are no parameters; steps are relative to values."""
    description = machine().description
    upper, rope = description.beams["upper"], description.springs["rope"]
    rigid = replace(upper, shear_coefficient=np.inf, material=replace(upper.material, density=0.0))
    other = description.with_part(rigid).changed("rope", free_length=0.0)
    gone = set(numbers_of_parts(ks.Robot(description))) - set(numbers_of_parts(ks.Robot(other)))
    assert gone == {"upper.shear_coefficient", "upper.density", "rope.free_length"} and rope.free_length == 0.1
    light = description.with_part(replace(description.links["upper"], mass=1e-3))
    assert numbers_of_parts(ks.Robot(light))["upper.mass"][0].step == pytest.approx(1e-6)
    with pytest.raises(ks.ArgumentError, match=r"has no parameter 'rope.stifness': did you mean 'rope.stiffness'"):
        ks.compile(machine()).jacobian("twist", "rope.stifness")


# ---- arguments of files ----------------------------------------------------------------------------------------------


def test_arguments_of_a_file_have_steps_relative_to_their_values_or_to_one():
    number = ParametricRobot(package_robots.robot("3rps")).number("rod_diameter")
    assert (number.unit, number.step) == ("m", pytest.approx(1e-3 * number.value))
    assert ParametricRobot(package_robots.robot("3rps", density=0.0)).number("density").step == 1e-3


def test_a_number_may_be_named_once():
    family = ParametricRobot(package_robots.robot("3rps"))
    assert list(family.names(["rod_diameter", "rod_*.density", "rod_1.*"]))[:1] == ["rod_diameter"]
    with pytest.raises(ks.ArgumentError, match=r"tolerances: 'rod_1.density' is named twice, the second time by 'rod_1.\*'"):
        family.names(["rod_1.density", "rod_1.*"], "tolerances")
    assert len(family.names(["rod_1.density", "rod_2.density"], "tolerances")) == 2


def test_typed_units_have_the_dimension_of_the_number():
    numbers = numbers_of_parts(machine())
    (mass,), (ratio,) = numbers["upper.mass"], numbers["upper.poisson_ratio"]
    check_unit(mass, "g", "tolerances")
    check_unit(mass, "", "tolerances")
    check_unit(replace(mass, unit=""), "mm", "tolerances")  # an unknown unit
    for number, words in ((mass, "upper.mass is given in mm, but it is in kg"), (ratio, "given in mm, but it has no unit")):
        with pytest.raises(ks.ArgumentError, match=words):
            check_unit(number, "mm", "tolerances")


def test_limits_inertias_and_visuals_have_no_part_in_statics():
    one = machine().description
    hinge, upper = one.joints["hinge"], one.links["upper"]
    idle = replace(one.with_part(replace(hinge, upper=1.0)).with_part(replace(upper, extra="<visual/>")), extra="<material/>")
    assert one != idle and have_same_statics(one, idle)
    for part in (replace(hinge, axis=(0.0, 0.0, 1.0)), replace(upper, mass=3.0), replace(one.springs["rope"], preload=6.0)):
        assert not have_same_statics(one, one.with_part(part))
    assert not have_same_statics(one, replace(one, actuated=("hinge",)))


@pytest.mark.parametrize("make", [machine, lambda: package_robots.robot("ur10"), lambda: package_robots.robot("3rps")])
def test_changed_robots_keep_the_axes_of_beams(make):
    """Those of round beams, which files leave out, are written; given ones stay as they are."""
    first = make()
    kept = ks.Robot(_with_beam_axes(first, first.description))
    for name, beam in first.description.beams.items():
        np.testing.assert_allclose(kept.beams[name].axes, first.beams[name].axes, atol=1e-14)
        assert beam.y_axis is None or kept.description.beams[name] is beam
        assert kept.description.beams[name].y_axis is not None
