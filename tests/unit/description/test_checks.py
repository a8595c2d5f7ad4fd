"""Parts check their values when they are made, by the rules of files and with their sentences; no XML is written for that."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from places import ROBOTS

import kinetostatics as ks
from kinetostatics import hooks
from kinetostatics.description import (
    Beam,
    BeamEnd,
    Cone,
    Inertia,
    Joint,
    JointStiffness,
    Link,
    Loop,
    Material,
    Mimic,
    Origin,
    RobotDescription,
    Spring,
    validate,
)
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.sections import Rectangle, Section, Tube

STEEL, INF = Material(2e11, 0.3), math.inf


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Link("a", mass=-1), "mass=-1 of link 'a' must be zero or greater"),
        (lambda: Link("a", 1, (0, 0, 1e10)), "center_of_mass=(0, 0, 10000000000.0) of link 'a' is too large to compute with"),
        (lambda: Link(""), "name='' of link '' is empty"),
        (lambda: Link("a", inertia=Inertia((1, 2, 3, 4, 5, INF))), "inertia.moments=(1, 2, 3, 4, 5, inf) of link 'a' is not"),
        (lambda: Joint("j", "hinge", "a", "b"), "joint 'j' has the type 'hinge'; known: continuous, fixed"),
        (lambda: Joint("j", "fixed", "a", "b", axis=(0, 0, 0)), "axis=(0, 0, 0) of joint 'j' is zero; it must have a direction"),
        (lambda: Joint("j", "fixed", "a", "b", Origin((0, 1))), "origin.xyz=(0, 1) of joint 'j' must be three numbers, not 2"),
        (lambda: Joint("j", "fixed", "a", "b", (0, 0, 1)), "origin=(0, 0, 1) of joint 'j' is not of the type Origin"),
        (lambda: Joint("j", "revolute", "a", "b", lower=2, upper=1), "joint 'j' has lower=2 above upper=1"),
        (lambda: Joint("j", "revolute", "a", "b", upper=1), "joint 'j' has lower=-inf and upper=1; without limits both"),
        (lambda: Joint("j", "planar", "a", "b"), "joint 'j' is planar and its axis is not z"),
        (lambda: Joint("j", "planar", "a", "b", axis=(0, 0, 1), mimic=Mimic("k")), "joint 'j' is planar and cannot mimic"),
        (lambda: Joint("j", "revolute", "a", "b", mimic=Mimic("k", 0)), "multiplier=0 of <mimic> in joint 'j' must be of a size"),
        (lambda: Loop("l", "floating", "a", "b"), "loop 'l' has the type 'floating'"),
        (lambda: Loop("l", "spherical", "a", "b", axis=(0, 0, 1)), "loop 'l' is spherical and has no <axis>"),
        (lambda: Loop("l", "spherical", "a", "b", effort=1), "loop 'l' is spherical, and <limit> is for revolute, continuous"),
        (lambda: Loop("l", "revolute", "a", "b", cone=Cone(1)), "loop 'l' is revolute, and <cone> is for universal and"),
        (lambda: Loop("l", "universal", "a", "b", axis2=(1, 0, 0)), "the two axes of loop 'l' are parallel"),
        (lambda: Loop("l", "universal", "a", "b", cone=Cone(4)), "angle=4 of <cone> in loop 'l' is above π"),
        (lambda: Spring("s", "soft", "a", "b"), "stiffness='soft' of spring 's' is not a number"),
        (lambda: JointStiffness("j", (1, 2, -3)), "linear=(1, 2, -3) of stiffness of joint 'j' must be three numbers that are"),
        (lambda: JointStiffness("j", drive=0), "drive=0 of stiffness of joint 'j' must be greater than zero"),
        (lambda: Beam("rod", Tube.of(0.1), Material("210 GPa", 0.3)), "material.youngs_modulus='210 GPa' of beam 'rod' is not a"),
        (lambda: Beam("rod", Tube.of(0.1), STEEL, BeamEnd(3)), "start.joint=3 of beam 'rod' is not a text"),
    ],
)  # fmt: skip
def test_parts_refuse_wrong_values_when_they_are_made(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(ks.RobotFileError, match="^" + re.escape(f"<python>: {words}")):
        make()


@pytest.mark.parametrize(("value", "words"), [(5e-31, "too small"), (2e-30, ""), (9e29, ""), (1.1e30, "too large")])
def test_numbers_may_have_thirty_digits_before_and_after_the_point(value: float, words: str) -> None:
    """Their squares and reciprocals can be computed with."""
    if words:
        with pytest.raises(ks.RobotFileError, match=f"drive=.* of stiffness of joint 'j' is {words} to compute with"):
            JointStiffness("j", drive=value)
    else:
        assert JointStiffness("j", drive=value).drive == value


def test_values_are_stored_as_floats_and_unit_vectors() -> None:
    joint = Joint("j", "revolute", "a", "b", Origin(np.array([1, 2, 3])), [0, 5, 0], np.float32(-1), 1)  # type: ignore[arg-type]
    assert joint == Joint("j", "revolute", "a", "b", Origin((1.0, 2.0, 3.0)), (0.0, 1.0, 0.0), -1.0, 1.0)
    assert type(joint.lower) is float and type(joint.origin.xyz) is tuple
    assert Joint("j", "fixed", "a", "b", axis=(0, 0, 1)).axis == (1.0, 0.0, 0.0)  # it has none
    assert Loop("l", "spherical", "a", "b", cone=Cone(3.1415926536)).cone == Cone(math.pi)
    beam = Beam("rod", Tube.of(0.1), STEEL)
    assert replace(beam, start=BeamEnd("j")).material is STEEL  # what is right already stays the same object


@pytest.mark.parametrize(("tilt", "normal"), [(1e-11, True), (1e-7, False)])
def test_axis_of_planar_joint_is_z_but_for_rounding(tilt: float, normal: bool) -> None:
    """As of an axis that was computed from angles."""
    axis = (math.sin(tilt) * math.cos(0.3), math.sin(tilt) * math.sin(0.3), math.cos(tilt))
    if normal:
        assert Joint("j", "planar", "a", "b", axis=axis).axis == pytest.approx((0, 0, 1), abs=1e-10)
    else:
        with pytest.raises(ks.RobotFileError, match="joint 'j' is planar and its axis is not z"):
            Joint("j", "planar", "a", "b", axis=axis)


def test_joint_that_mimics_without_numbers_turns_as_its_leader_does() -> None:
    """The multiplier that is left out is 1 and the offset 0, as in URDF's specification: two turns add up to twice the angle."""
    machine = ks.Robot(plate(loops=[], springs=[], joint_stiffness=[]).changed("hinge", mimic=Mimic("motor")))
    pose = machine.assemble(actuators={"motor": 0.3})
    R = machine.mechanism.platform_pose(pose.frames)[0][:, :, 0]
    assert math.atan2(R[0, 2], R[2, 2]) == pytest.approx(0.6, abs=1e-12)


def plate(**values: Any) -> RobotDescription:
    """A plate on a motor and a rod, with a spring."""
    given: dict[str, Any] = {
        "links": [Link("ground"), Link("rod", 1), Link("plate", 2, (0.1, 0, 0))],
        "joints": [
            Joint("motor", "revolute", "ground", "rod", axis=(0, 1, 0), lower=-1, upper=1),
            Joint("hinge", "continuous", "rod", "plate", Origin((0, 0, 0.5)), (0, 1, 0)),
        ],
        "loops": [Loop("slide", "planar", "ground", "plate", axis=(0, 0, 1))],
        "beams": [Beam("rod", Tube.of(0.02), STEEL)],
        "joint_stiffness": [JointStiffness("motor", drive=1e4), JointStiffness("slide", (0, 0, 1e6))],
        "springs": [Spring("coil", 100, "ground", "plate", free_length=0.3)],
        "platform": "plate",
        "actuated": ("motor",),
        **values,
    }
    return RobotDescription.of("r", **given)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda d: replace(d, platform="plat"),
            "<platform> refers to the link 'plat', which does not exist; did you mean 'plate'?",
        ),
        (lambda d: replace(d, base=["ground"]), "<base> refers to the link ['ground'], which does not exist"),
        (lambda d: replace(d, base="plate"), "the link 'plate' is both base and platform"),
        (
            lambda d: replace(d, actuated=("hing",)),
            "<transmission> refers to the joint 'hing', which does not exist; did you mean",
        ),
        (lambda d: replace(d, actuated=("slide",)), "'slide' is planar and cannot be actuated"),
        (lambda d: d.changed("coil", successor="ground"), "spring 'coil' joins the link 'ground' to itself"),
        (lambda d: d.changed("slide", predecessor="g"), "<predecessor> of loop 'slide' refers to the link 'g'"),
        (lambda d: d.changed("hinge", mimic=Mimic("hinge")), "joint 'hinge' mimics itself"),
        (
            lambda d: d.with_part(JointStiffness("hinge", drive=1)),
            "stiffness of joint 'hinge' has the attribute drive, but 'hinge'",
        ),
        (lambda d: d.with_part(JointStiffness("hinge", (1, 0, 1))), "linear of stiffness of joint 'hinge' is 0 along y, which"),
        (lambda d: d.changed("rod", section=Rectangle.of(0.01, 0.02)), "beam 'rod' has a section that bends differently"),
        (lambda d: d.changed("rod", section=Section(1, 1, 1, 1, 1)), "section of beam 'rod': it has shear_area_y alone"),
        (lambda d: d.changed("rod", section=Section(-1, 1, 1, 1)), "section of beam 'rod': area=-1 must be greater than zero"),
        (lambda d: d.changed("rod", shear_modulus=1e9), "beam 'rod' has both poisson_ratio and shear_modulus; give one of them"),
        (lambda d: d.changed("rod", poisson_ratio=0.6), "poisson_ratio=0.6 of beam 'rod' must be above -1 and at most 0.5"),
        (lambda d: d.changed("rod", start=BeamEnd("hinge", "left")), "from='hinge:left' of beam 'rod' must end in ':parent'"),
        (lambda d: d.changed("rod", link="plate"), "the link 'plate' is the platform, which is rigid"),
        (lambda d: replace(d, attributes=(("version", "2"),)), "version='2' of <robot> is unknown; URDF has version 1.0"),
        (lambda d: replace(d, links={**d.links, "x": 3}), "the entry 'x' of links is 3; it must be a Link of this name"),
    ],
)
def test_rules_between_parts_hold_without_xml(change: Callable[[Any], Any], words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Writing a robot file is an error here."""
    monkeypatch.setattr(hooks, "robot_text", None)
    assert validate(plate()).is_valid
    with pytest.raises(ks.RobotFileError, match="^" + re.escape(f"<python>: {words}")):
        validate(change(plate()))


@pytest.mark.parametrize(("apart", "same"), [(1e-14, True), (3e-13, True), (3e-12, False), (0.1, False)])
def test_section_of_equal_shear_areas_but_for_rounding_needs_no_y_axis(apart: float, same: bool) -> None:
    description = plate().changed("rod", section=Section(1e-3, 1e-7, 1e-7, 2e-7, 9e-4, 9e-4 * (1 + apart)))
    if same:
        assert validate(description).is_valid
    else:
        with pytest.raises(ks.RobotFileError, match="beam 'rod' has a section that bends differently about y and z"):
            validate(description)


@pytest.mark.parametrize(
    ("extra", "words"),
    [("<inertial/>", "a <inertial>, for which the description has fields"), ("<a/>b", "text outside of elements")],
)
def test_extra_xml_is_for_other_programs(extra: str, words: str) -> None:
    with pytest.raises(ks.RobotFileError, match=f"extra of link 'rod' has {words}"):
        ks.Robot(plate(links=[Link("ground"), Link("rod", 1, extra=extra), Link("plate", 2)]))


def test_sentences_of_files_and_of_python_agree() -> None:
    """But for name and place of the element."""
    text = validate(plate()).urdf
    for old, new, change in [
        ('lower="-1"', 'lower="3"', lambda d: d.changed("motor", lower=3)),
        ('child link="plate"', 'child link="plat"', lambda d: d.changed("hinge", child="plat")),
        ('poisson_ratio="0.3"', 'poisson_ratio="0.7"', lambda d: d.changed("rod", poisson_ratio=0.7)),
        ('successor link="plate"', 'successor link="ground"', lambda d: d.changed("slide", successor="ground")),
        ('stiffness joint="slide" linear="0 0 1000000"', 'stiffness joint="slide" linear="0 0 0"',
         lambda d: d.changed("slide", linear=(0, 0, 0))),
    ]:  # fmt: skip
        assert old in text
        with pytest.raises(ks.RobotFileError) as of_file:
            parse_robot_text(text.replace(old, new), "r.urdf")
        with pytest.raises(ks.RobotFileError) as in_python:
            validate(change(plate()))
        assert of_file.value.line is not None
        plain = re.sub(r"<joint_(stiffness)>|<(joint|loop|beam)>", r"\1\2", of_file.value.reason)
        assert plain == in_python.value.reason


WRONG = st.sampled_from(
    [math.nan, INF, -1.0, 0.0, 1e31, "", "x", None, (1, 2, 3), (0, 0, 0), "fixed", "planar", "hinge", "motor"]
)


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_what_is_accepted_is_read_back_equal(data: st.DataObject) -> None:
    """Robots with a random value in a random field: refused by one sentence, or written to a file that the reader accepts."""
    name = data.draw(st.sampled_from(["3rps", "plate"]))
    description = plate() if name == "plate" else ks.files.read_robot_file(ROBOTS / "3rps.urdf.xacro")
    table = data.draw(st.sampled_from(["links", "joints", "loops", "beams", "joint_stiffness", "springs"]))
    parts = dict(getattr(description, table))
    if not parts:
        return
    key = data.draw(st.sampled_from(sorted(parts)))
    field = data.draw(st.sampled_from([item for item in vars(parts[key]) if item not in ("place", "extra", "has_inertial")]))
    try:
        parts[key] = replace(parts[key], **{field: data.draw(WRONG)})
        valid = validate(replace(description, **{table: parts}))
    except ks.RobotFileError as error:
        assert "\n" not in str(error)
    else:
        read = replace(parse_robot_text(valid.urdf), parameters={})
        if valid.actuated != description.actuated:  # the ignored transmission of a joint that is now fixed is not written
            valid = replace(valid, extra=read.extra)
        assert read == valid
