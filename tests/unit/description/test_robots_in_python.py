"""Robots without a file: made of dataclasses, changed after loading, and checked by the rules of robot files."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.description import (
    Beam,
    BeamEnd,
    Inertia,
    Joint,
    JointStiffness,
    Link,
    Loop,
    Material,
    Origin,
    RobotDescription,
)
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.sections import Rectangle, RectangularTube, Section, Tube

STEEL = Material(210e9, 0.3, density=7850)
Y = (0, 1, 0)


def parallelogram() -> RobotDescription:
    """The example of ``docs/reference/robot_format.md``."""
    return RobotDescription.of(
        "parallelogram",
        links=[Link("ground"), Link("left"), Link("right"), Link("plate", 3, (0.2, 0, 0), Inertia((0.01, 0, 0, 0.04, 0, 0.04)))],
        joints=[
            Joint("a", "revolute", "ground", "left", axis=Y, lower=-1, upper=1, effort=100, velocity=1),
            Joint("b", "continuous", "left", "plate", Origin((0, 0, 0.3)), Y),
            Joint("d", "continuous", "ground", "right", Origin((0.4, 0, 0)), Y),
        ],
        loops=[Loop("c", "continuous", "right", "plate", Origin((0, 0, 0.3)), Origin((0.4, 0, 0)), Y)],
        platform="plate",
        platform_origin=Origin((0.2, 0, 0)),
        beams=[
            Beam("left", Tube.of(0.02), STEEL, BeamEnd("a"), BeamEnd("b")),
            Beam("right", Tube.of(0.03, 0.02), STEEL, BeamEnd("d"), BeamEnd("c")),
        ],
        actuated=["a"],
    )


def from_docs() -> RobotDescription:
    text = (ROOT / "docs" / "reference" / "robot_format.md").read_text()
    found = re.search(r"```xml\n(<\?xml.*?)```", text, re.DOTALL)
    assert found is not None
    return parse_robot_text(found[1].replace('<transmission name="motor">', '<transmission name="drive_a">'), "docs.urdf")


def test_documentation_example_in_python_equals_its_file() -> None:
    description = parallelogram()
    assert not description.is_valid and description.path == "<python>"
    assert ks.description.validate(description) == from_docs()
    robot = ks.Robot(description)
    assert robot.description == from_docs() and "right" in repr(robot.description.beams)
    expected = ks.analyze(ks.Robot(from_docs()).assemble(actuators={"a": 0.2}), (0, 0, -100, 0, 0, 0))
    found = ks.analyze(robot.assemble(actuators={"a": 0.2}), (0, 0, -100, 0, 0, 0))
    np.testing.assert_array_equal(found.twist, expected.twist)
    assert str(found) == str(expected) and "<python>" in str(robot)


def test_numpy_numbers_and_unnormalized_axes_are_accepted() -> None:
    description = parallelogram()
    joints: dict[str, Any] = {
        name: replace(
            joint, axis=np.array([0, 5, 0]), origin=Origin(np.array(joint.origin.xyz), [0, 0, 0]), lower=np.float32(joint.lower)
        )  # type: ignore[arg-type]
        for name, joint in description.joints.items()
    }
    assert ks.description.validate(replace(description, joints=joints, actuated=("a",))) == from_docs()


def test_links_with_given_inertial_values_have_an_inertial() -> None:
    for link, expected in [
        (Link("a"), False),
        (Link("a", mass=1), True),
        (Link("a", center_of_mass=np.array([0, 0, 1])), True),  # type: ignore[arg-type]
        (Link("a", inertia=Inertia(np.array([0, 0, 0, 0, 0, 1]))), True),  # type: ignore[arg-type]
        (Link("a", has_inertial=True), True),
        (replace(Link("a", mass=1), mass=2), True),
    ]:
        assert link.has_inertial is expected


def test_descriptions_are_read_only() -> None:
    description = from_docs()
    for change in (
        lambda: description.beams.__setitem__("left", description.beams["right"]),  # type: ignore[attr-defined]
        lambda: description.links.pop("left"),  # type: ignore[attr-defined]
        lambda: description.joints.update(a=1),  # type: ignore[attr-defined]
        lambda: description.loops.clear(),  # type: ignore[attr-defined]
    ):
        with pytest.raises(TypeError, match="descriptions are read-only"):
            change()


def test_urdf_text_follows_changes_of_the_description() -> None:
    """After a change the text, Pinocchio's model and the results are those of the changed robot."""
    description = from_docs()
    assert '<circle diameter="0.02"/>' in description.urdf
    thick = description.changed("left", section=Tube.of(0.025))
    assert not thick.is_valid and '<circle diameter="0.025"/>' in thick.urdf and '<circle diameter="0.02"/>' not in thick.urdf
    assert '<circle diameter="0.02"/>' in description.urdf
    longer = thick.changed("b", origin=Origin((0, 0, 0.35))).changed("c", predecessor_origin=Origin((0, 0, 0.35)))
    robot = ks.Robot(longer)
    assert robot.assemble().platform["z"] == pytest.approx(0.35, abs=1e-12)
    assert max(placement.translation[2] for placement in robot.model.jointPlacements) == 0.35


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["3rps", "2pru_upr"])
def test_changed_section_equals_the_parameter_of_the_file(name: str) -> None:
    path = ROOT / "robots" / f"{name}.urdf.xacro"
    wanted = ks.load_robot(path, {"rod_diameter": 0.083})
    description = ks.files.read_robot_file(path)
    for beam in description.beams.values():
        assert beam.shear_areas[0] == beam.section.area  # κ = 1 in both files
        description = description.changed(beam.name, section=Tube.of(0.083))
    robot = ks.Robot(description)
    found, expected = (ks.analyze(item.assemble(), (1, 2, 3, 4, 5, 6)) for item in (robot, wanted))
    np.testing.assert_array_equal(found.twist, expected.twist)
    assert found.actuator_forces == expected.actuator_forces


def test_shear_areas_follow_the_section() -> None:
    beam = from_docs().beams["right"]
    for section in (Tube.of(0.05), Rectangle.of(0.02, 0.03), Section(1e-3, 1e-7, 1e-7, 2e-7, 5e-4, 6e-4)):
        other = replace(beam, section=section)
        factors = section.shear_coefficients(0.3)
        expected = [5e-4, 6e-4] if factors is None else np.array(factors) * section.area
        np.testing.assert_allclose(other.shear_areas, expected, rtol=1e-15)
    assert replace(beam, shear_coefficient=math.inf).shear_areas == (math.inf, math.inf)
    assert replace(beam, material=replace(STEEL, youngs_modulus=100e9)).shear_modulus == 100e9 / 2.6
    with pytest.raises(ks.ArgumentError, match="shear_coefficient"):
        _ = replace(beam, section=Section(1, 1, 1, 1)).shear_areas
    with pytest.raises(ks.ArgumentError, match="Poisson"):
        _ = replace(beam, material=Material(1e9)).shear_modulus


def test_payload_acts_like_its_weight_as_a_load() -> None:
    description = ks.files.read_robot_file(ROOT / "robots" / "3rps.urdf.xacro")
    at, mass = (0.05, -0.02, 0.1), 3.0
    robot = ks.Robot(description.with_payload("box", "platform", mass, at))
    bare = ks.Robot(description)
    poses = [item.assemble(platform={"z": 0.55, "rx": 0.1, "ry": -0.05}) for item in (robot, bare)]
    found, empty = (ks.analyze(pose) for pose in poses)
    arm = poses[0].frame("box")[:3, 3] - poses[0].platform_frame[:3, 3]
    np.testing.assert_allclose(arm, poses[0].frame("platform")[:3, :3] @ at, atol=1e-12)
    weight = np.array([0, 0, -9.81 * mass])
    loaded = ks.analyze(poses[1], np.concatenate([weight, np.cross(arm, weight)]))
    np.testing.assert_allclose(found.twist, loaded.twist, rtol=1e-9, atol=1e-20)
    assert np.abs(found.twist - empty.twist).max() > 1e-9
    with pytest.raises(ks.ArgumentError, match="the link 'rod_1' is there already"):
        description.with_payload("rod_1", "platform", 1.0)
    with pytest.raises(ks.ArgumentError, match="the joint 'box_mount' is there already"):
        description.with_part(Joint("box_mount", "fixed", "platform", "rod_1")).with_payload("box", "platform", 1.0)


def test_changes_affect_only_the_named_part() -> None:
    description = from_docs()
    softer = description.changed("left", youngs_modulus=70e9, density=2700)
    assert softer.beams["left"].material == Material(70e9, 0.3, density=2700)
    assert softer.beams["left"].section == Tube.of(0.02) and softer.beams["right"] == description.beams["right"]
    assert description.changed("plate", mass=5).links["plate"].mass == 5
    assert description.changed("a", lower=-2).joints["a"].lower == -2
    assert description.changed("c", type="revolute").loops["c"].type == "revolute"
    assert list(softer.links) == list(description.links)  # the limbs keep their numbers
    stiff = description.with_part(JointStiffness("a", drive=1e4))
    assert stiff.changed("a", drive=2e4).joint_stiffness["a"].drive == 2e4
    assert list(description.without_beam("left").beams) == ["right"]
    again = description.without_beam("left").with_part(description.beams["left"])
    assert ks.description.validate(again) == replace(
        description, beams={name: description.beams[name] for name in ("right", "left")}
    )
    warned = description.changed("left", density=None)
    assert any("'left'" in text and "weighs nothing" in text for text in ks.Robot(warned).description.warnings)
    assert ks.Robot(warned.changed("left", density=0)).description.warnings == ()
    grown = (
        description.with_part(Link("pole", 0.1))
        .with_part(Joint("pole_foot", "fixed", "plate", "pole", Origin((0.2, 0, 0))))
        .with_part(Loop("brace", "spherical", "ground", "pole", Origin((0.2, 0, 0.3))))
    )
    assert list(ks.Robot(grown).description.loops) == ["c", "brace"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.changed("lift", mass=1), "nothing in 'parallelogram' is called 'lift': did you mean 'left'?"),
        (lambda d: d.changed("left", diameter=1), "'left' is a Link and a Beam, which cannot be given diameter: a Link has mass"),
        (lambda d: d.changed("a", mass=1), "'a' is a Joint, which cannot be given mass: a Joint has type, parent"),
        (lambda d: d.changed("a", name="b"), "cannot be given name"),
        (lambda d: d.changed("left"), "'left' is a Link and a Beam, and nothing may belong to either"),
        (lambda d: d.changed("left", mass=1, section=Tube.of(1)), "cannot be given mass, section"),
        (lambda d: d.without_beam("lef"), "no beam 'lef': did you mean 'left'?"),
        (lambda d: ks.Robot("robot.urdf"), "'robot.urdf' is no description of a robot; load_robot"),
    ],
)
def test_impossible_changes_are_errors(change: Callable[[RobotDescription], Any], words: str) -> None:
    with pytest.raises(ks.ArgumentError, match=re.escape(words)):
        change(parallelogram())


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Tube.of(-1), "outer_diameter=-1 of a section must be a finite number greater than zero; it is in metres"),
        (lambda: Tube.of(math.nan), "outer_diameter=nan"),
        (lambda: Tube.of("0.1"), "outer_diameter='0.1'"),  # type: ignore[arg-type]
        (lambda: Tube.of(1, -1), "inner_diameter=-1"),
        (lambda: Tube.of(0.02, 0.02), "inner_diameter=0.02 must be less than outer_diameter=0.02"),
        (lambda: Rectangle.of(1, 0), "height=0"),
        (lambda: RectangularTube.of(1, 2), "thickness=0.0"),
        (lambda: RectangularTube.of(1, 2, 0.5), "thickness=0.5 must be less than half the smaller side, 1"),
    ],
)
def test_impossible_sections_are_errors(make: Callable[[], Section], words: str) -> None:
    with pytest.raises(ks.ArgumentError, match=re.escape(words)):
        make()


def beam(**values: Any) -> Callable[[RobotDescription], RobotDescription]:
    return lambda description: description.changed("left", **values)


def joint(name: str = "a", **values: Any) -> Callable[[RobotDescription], RobotDescription]:
    return lambda description: description.changed(name, **values)


def whole(**values: Any) -> Callable[[RobotDescription], RobotDescription]:
    return lambda description: replace(description, **values)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (joint(parent="grund"), ["'grund'", "did you mean 'ground'"]),
        (joint("d", child="left"), ["two parents"]),
        (beam(start=BeamEnd("x")), ["'x'", "does not exist"]),
        (whole(actuated=("a", "a")), ["two <transmission>"]),
        (lambda d: d.with_part(replace(d.loops["c"], name="a")), ["joint or loop name 'a' is taken"]),
        (joint("c", lower=-1, upper=1), ["continuous", "unlimited"]),
        (joint(lower=2), ["lower=2", "upper=1"]),
        (whole(name="two\nlines"), ["line breaks"]),
        # mistakes that are impossible in files
        (whole(name=5), ["name=5 of robot", "text"]),
        (whole(links={"a": Link("b")}), ["the entry 'a' of links", "'b'", "a Link of this name"]),
        (joint(axis=(0, "up", 0)), ["axis=(0, 'up', 0) of", "'a' is wrong: 'up' is not a number"]),
        (joint(axis=(0, math.nan, 1)), ["axis=(0, nan, 1) of", "'a' is not finite"]),
        (lambda d: d.changed("plate", mass="3 kg"), ["mass='3 kg' of", "'plate' is not a number"]),
        (lambda d: d.changed("plate", inertia=Inertia((1, 1))), ["inertia.moments=(1, 1) of", "six moments ixx", "not 2"]),  # type: ignore[arg-type]
        (beam(section=Tube(1, 1, 1, 1, outer_diameter=1, inner_diameter=2)), ["inner_diameter=2", "less than outer_diameter=1"]),
        (beam(section=replace(Tube.of(0.02), outer_diameter=0.03)), ["do not agree with its sizes", "Tube.of(…)"]),
        (beam(section="thick"), ["'thick'", "kinetostatics.sections"]),
        # XML that is kept
        (lambda d: d.changed("plate", extra="<visual>"), ["extra of ", "'plate'", "well-formed"]),
        (lambda d: d.changed("plate", extra="<visual><origin xyz='1 2'/></visual>"), ["three numbers"]),
        (whole(extra="<platfrom/>"), ["did you mean <platform>"]),
        (whole(attributes=(("a b", "c"),)), ["'a b'", "attribute"]),
        (whole(attributes=(("a", "\x00"),)), ["'\\x00'", "attribute"]),
        (
            lambda d: (
                d.with_part(Link("x"))
                .with_part(Joint("a:child", "fixed", "left", "x"))
                .changed("left", start=BeamEnd("a", "child"))
            ),
            ["child side of 'a'", "called 'a:child'"],
        ),
    ],
)
def test_every_rule_of_files_holds_in_python(change: Callable[[RobotDescription], RobotDescription], words: list[str]) -> None:
    """For a description made in Python, and for one that was read and changed; the error is one line."""
    for before in (parallelogram(), from_docs()):
        with pytest.raises(ks.RobotFileError) as caught:
            ks.Robot(change(before))
        for word in words:
            assert word in str(caught.value)
        assert "\n" not in str(caught.value)
        assert caught.value.file in {before.path, "<python>"}


@pytest.mark.parametrize(
    ("limit", "is_odd"), [(12.56, False), (12.57, True), (90.0, True), (720.0, True), (721.0, False), (1e9, False)]
)
def test_limits_beyond_two_turns_look_like_degrees(limit: float, is_odd: bool) -> None:
    """Very wide limits stand for none."""
    assert len(parallelogram().changed("a", upper=limit).angle_hints()) == is_odd


@pytest.mark.parametrize(("angle", "is_odd"), [(6.29, False), (90, True), (12, False), (13, True), (-180, True)])
def test_large_angles_of_frames_look_like_degrees(angle: float, is_odd: bool) -> None:
    assert len(parallelogram().changed("b", origin=Origin(rpy=(0, angle, 0))).angle_hints()) == is_odd


def test_duplicate_names_are_errors() -> None:
    links = [Link("a"), Link("b")]
    joints = [Joint("j", "fixed", "a", "b")]
    for values, words in [
        ({"links": [*links, Link("a")]}, "the link name 'a' is taken already"),
        ({"joints": [*joints, *joints]}, "the joint name 'j' is taken already"),
        ({"loops": [Loop("j", "fixed", "a", "b")]}, "the joint or loop name 'j' is taken already"),
        ({"beams": [Beam("a", Tube.of(1), STEEL)] * 2}, "the beam name 'a' is taken already"),
        ({"joint_stiffness": [JointStiffness("j")] * 2}, "the joint 'j' has two stiffnesses"),
    ]:
        given: dict[str, Any] = {"links": links, "joints": joints, "platform": "b", **values}
        with pytest.raises(ks.RobotFileError, match=f"<python>: {words}"):
            RobotDescription.of("r", **given)


def test_errors_name_the_line_of_elements_from_files() -> None:
    description = from_docs()
    place = description.beams["left"].place
    assert place.line is not None and str(place) == f"docs.urdf:{place.line}"
    with pytest.raises(ks.RobotFileError, match=f"docs.urdf:{place.line}: .*youngs_modulus"):
        ks.Robot(description.changed("left", youngs_modulus=-1))
    with pytest.raises(ks.RobotFileError, match=r"<python>: <parent> of joint 'new' refers to the link 'leftt'.*'left'"):
        ks.Robot(description.with_part(Joint("new", "fixed", "leftt", "plate")))


def test_file_warnings_are_given_once() -> None:
    text = (ROOT / "docs" / "reference" / "robot_format.md").read_text()
    text = text[text.index("<?xml") : text.index("</robot>") + len("</robot>")]
    text = text.replace('<link name="left"/>', '<link name="left"><visul/></link>').replace(
        'type="revolute"', 'type="continuous"', 1
    )
    description = parse_robot_text(text, "docs.urdf")
    assert [re.sub(r":\d+: .*", "", line) for line in description.warnings] == ["docs.urdf"] * 2
    changed = ks.description.validate(description.changed("plate", mass=5))
    assert changed.warnings == description.warnings
    made = parallelogram().changed("left", extra="<visul/>")
    assert [line for line in ks.Robot(made).warnings if "<visul>" in line and line.startswith("<python>: ")]


@pytest.mark.parametrize(("ratio", "expected"), [(0.3, 0.3), (0.0, 0.0), (-0.9, -0.9), (0.5, 0.5), (0.51, 0.0), (2.0, 0.0)])
def test_poisson_ratio_follows_from_both_moduli_of_isotropic_materials(ratio: float, expected: float) -> None:
    """E / 2G − 1; moduli that no isotropic material has, as of wood or fibres, give none."""
    material = Material(1.0, shear_modulus=1 / (2 * (1 + ratio)))
    beam = Beam("rod", Tube.of(0.02), material)
    assert beam.poisson_ratio == pytest.approx(expected, abs=1e-15)
    assert Beam("rod", Tube.of(0.02), Material(1.0, poisson_ratio=0.4)).poisson_ratio == 0.4


@pytest.mark.parametrize(
    ("moments", "why"),
    [
        ((2.0, 3.0, 5.0), ""), ((2.0, 3.0, 5.004), ""), ((2.0, 3.0, 5.007), "exceed"), ((2.0, 3.0, 6.0), "exceed"),
        ((0.0, 3.0, 3.0), ""), ((-0.002, 3.0, 3.0), ""), ((-0.004, 3.0, 3.0), "negative"), ((0.0, 0.0, 0.0), ""),
        ((0.0, 0.0, 4e-6), ""), ((0.0, 0.0, 5e-6), "none may"), ((-4e-6, 0.0, 0.0), ""), ((-5e-6, 0.0, 0.0), "negative"),
    ],
)  # fmt: skip
def test_moments_of_inertia_that_no_body_has(moments: tuple[float, float, float], why: str) -> None:
    """Principal moments are none negative and none larger than the sum of the others, but for rounded decimals: a thousandth of
    the largest, or 4.5e-6 kg·m². A rod and a point mass are at the limit."""
    x, y, z = moments
    flaw = Inertia((x, 0.0, 0.0, y, 0.0, z), (0.3, -0.2, 0.7)).flaw
    assert (why in flaw) if why else not flaw


def test_points_left_out_are_the_origin() -> None:
    """Of loads on links and of payloads as links of their own."""
    load = {"rod_1": ks.LinkLoad((1.0, 2.0, 3.0, 0.1, 0.2, 0.3))}
    pose = ks.load_robot("3rps").assemble()
    given = {"rod_1": replace(load["rod_1"], point=(0.0, 0.0, 0.0))}
    np.testing.assert_array_equal(ks.analyze(pose, loads=load).twist, ks.analyze(pose, loads=given).twist)
    description = pose.robot.description
    link = next(iter(description.links))
    plain, there = description.with_payload("tool", link, 2.0), description.with_payload("tool", link, 2.0, (0.0, 0.0, 0.0))
    assert plain.joints["tool_mount"].origin == there.joints["tool_mount"].origin == Origin((0.0, 0.0, 0.0))
