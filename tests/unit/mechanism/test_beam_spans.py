"""Ends of beams: over welded slides, and without given ends; mistakes in them, and masses of their links."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
import small_robots as sr
from mechanisms import Joint, Link, unit
from places import CASES
from simple_machines import BEAM, CIRCLE, RHO, joint, link, loop, robot

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.mechanism.beam_geometry import SpanFinder

LOAD, GRAVITY = (10.0, -20.0, -300.0, 4.0, 5.0, 6.0), (0.5, 0.7, -9.81)

# ---- telescopes whose slide is welded ------------------------------------------------------------------------------------

FOOT, HEAD = np.array([0.8, 0, 0]), np.array([0.9, 0, 0.7])
SECTION = replace(sr.tube(0.03, 0.02), I_y=2e-8, xml="")


def welded(at, carrier, density=7850.0):
    """A four-bar linkage; the second crank is a cylinder and a rod, welded ``at`` a part of the way (0: at its foot).

    With the weld at the foot the beam lies on the rod alone; else it runs over the weld.
    """
    spec = sr.four_bar(density=density)
    first, second = spec.limbs
    foot, head = second.joints
    weld = Joint("weld", "F", tuple(FOOT + at * (HEAD - FOOT) + (at > 0) * np.array([0.01, 0.02, 0.0])))
    cylinder = Link("cylinder", 0.0 if density is None and carrier == "cylinder" else 2.0, (0.7, 0.1, 0.2))
    rod = Link("rod", 3.0 if density is None and carrier == "rod" else 0.0, tuple((FOOT + HEAD) / 2))
    if carrier == "cylinder":
        cylinder = replace(cylinder, mass=3.0 if density is None else 0.0, com=rod.com)
    beam = replace(
        spec.beams[1],
        name="strut",
        link=carrier,
        start="foot_2" if at else "weld",
        section=SECTION,
        y_axis=tuple(unit((1, 2, 0))),
    )
    limb = replace(second, joints=(foot, weld, head), links=(cylinder, rod))
    return replace(spec, limbs=(first, limb), beams=(replace(spec.beams[0], density=7850.0), beam))


def numbers_of(robot):
    result = ks.analyze(robot.assemble(actuators={"foot_1": 0.1}), load=LOAD, gravity=GRAVITY)
    assert result.status == ks.Status.OK
    beam = result.beams["strut"]
    return {
        "twist": result.twist,
        "compliance": result.compliance,
        "base": result.base_wrench,
        "drive": result.actuator_forces["foot_1"],
        "head": result.joint_wrenches["head_2"],
        "beam": beam.section_wrenches,
        "line": beam.deflections,
        "mass": np.asarray(beam.mass),
    }


@pytest.mark.few(2)
@pytest.mark.parametrize("density", [7850.0, None])
@pytest.mark.parametrize("cut", [0, 1, 2])
@pytest.mark.parametrize("carrier", ["cylinder", "rod"])
def test_beam_over_welded_slide_equals_beam_on_one_link(carrier, cut, density):
    """Whether the weld is a joint (cuts 0 and 2) or a loop (cut 1), and whichever link carries the beam."""
    spec = welded(0.4, carrier, density)
    single = welded(0.0, "rod", density)
    if carrier == "cylinder":  # nothing is left on the cylinder, whose mass is the beam's
        single = replace(
            single, limbs=(single.limbs[0], replace(single.limbs[1], links=(Link("cylinder"), single.limbs[1].links[1])))
        )
    wanted = numbers_of(sr.robot_of(single))
    robot = sr.robot_of(spec, cuts=[0, cut], twirl=cut + 1)
    assert ("weld" in robot.description.loops) == (cut == 1)
    assert not robot.description.warnings
    for name, value in numbers_of(robot).items():
        scale = np.abs(wanted[name]).max()
        np.testing.assert_allclose(value, wanted[name], rtol=0, atol=1e-9 * scale, err_msg=name)


def test_welded_slide_agrees_with_finite_elements():
    robot = sr.robot_of(welded(0.4, "rod"), cuts=[0, 1], twirl=3)
    assert max(ks.verify(robot.assemble(), LOAD, GRAVITY).differences.values()) < 1e-6


@pytest.mark.parametrize("cut", [1, 2])
def test_invalid_beam_over_welded_slide_is_an_error(cut):
    spec = welded(0.4, "rod", None)
    along = replace(spec, beams=(spec.beams[0], replace(spec.beams[1], y_axis=tuple(HEAD - FOOT))))
    with pytest.raises(ks.RobotFileError, match="y_axis is parallel"):
        sr.robot_of(along, cuts=[0, cut], twirl=1)
    foot, weld, head = spec.limbs[1].joints
    short = replace(spec.limbs[1], joints=(foot, weld, replace(head, centre=foot.centre)))
    short = replace(spec, limbs=(spec.limbs[0], short))
    with pytest.raises(ks.RobotFileError, match="same point"):
        sr.robot_of(short, cuts=[0, cut], twirl=1)


def test_beam_length_of_telescope_held_by_fixed_loop():
    robot = ks.load_robot(CASES / "telescope_held_by_weld.urdf")
    result = ks.analyze(robot.assemble())
    assert result.status == ks.Status.OK
    assert float(result.beams["l3_link1_rod"].length) == pytest.approx(0.128802, rel=1e-4)


# ---- beams without from and to -------------------------------------------------------------------------------------------


def beam(link_name, ends=""):
    return f'<beam link="{link_name}" {ends} density="{RHO}" {BEAM}>{CIRCLE}</beam>'


def ladder(side, *foot):
    """Two upright rods 1 m apart, hinged on base and platform, and a rung between their heads, whose beam names no ends.

    The tree reaches the rung from the rod on this ``side``, where the rung's frame is; ``foot``: elements below the left rod.
    """
    other, x = ("right", 1) if side == "left" else ("left", -1)
    return robot(
        *(link(name) for name in ("base", "left", "right", "rung", "platform")), *foot,
        joint("foot_2", "continuous", "base", "right", "1 0 0"), joint("head_1", "continuous", "left", "platform", "0 0 1"),
        joint("b", "fixed", side, "rung", "0 0 1"), loop("a", "spherical", other, "rung", "0 0 1", f"{x} 0 0"),
        loop("head_2", "continuous", "right", "platform", "0 0 1", "1 0 0", "0 1 0"),
        beam("left", 'from="foot_1" to="head_1"'), beam("right", 'from="foot_2" to="head_2"'), beam("rung"),
    )  # fmt: skip


def direction(machine, name):
    """Return which way a beam runs in the world."""
    span, frames = SpanFinder(machine.mechanism).spans()[name], machine.zero_frames
    return unit((frames.point(span.end_body, span.end) - frames.point(span.start_body, span.start))[:, 0])


def foot(parent, xyz="0 0 0"):
    return joint("foot_1", "continuous", parent, "left", xyz)


def below(kind, axis, xyz="0 0 0", mass=0.0):
    return link("block", mass) + joint("below", kind, "base", "block", xyz, axis)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("elements", "one"),
    [
        ((foot("base"),), True),  # both ends are two joints from the base: joints of the tree come before loops
        ((below("continuous", "1 0 0"), foot("block")), True),  # a universal joint
        ((below("continuous", "1 0 0", "0 0 -0.3"), foot("block", "0 0 0.3")), False),  # its axes do not meet
        ((below("continuous", "1 0 0", mass=1.0), foot("block")), False),
        ((below("prismatic", "0 1 0"), foot("block")), True),  # a cylindrical joint
        ((below("prismatic", "1 0 0"), foot("block")), False),
        ((below("prismatic", "0 1 0"), foot("block"), '<transmission name="t"><joint name="below"/></transmission>'), False),
    ],
)
def test_beam_begins_at_the_end_with_fewer_joints_to_base(elements, one, side):
    """An additional joint below the left rod counts, unless it forms a universal or cylindrical joint with the hinge there."""
    machine = ladder(side, *elements)
    np.testing.assert_allclose(direction(machine, "rung"), (1 if one and side == "left" else -1, 0, 0), atol=1e-12)
    for rod in ("left", "right"):
        np.testing.assert_allclose(direction(machine, rod), (0, 0, 1), atol=1e-12)


@pytest.mark.parametrize("on", ["base", "platform"])
def test_beam_of_hanging_part_begins_at_its_attachment(on):
    """A bracket on base or platform alone: its beam runs outwards."""
    machine = robot(
        *(link(name) for name in ("base", "rod", "platform", "end", "arm")), joint("foot", "fixed", "base", "rod"),
        joint("head", "fixed", "rod", "platform", "0 0 0.5"), joint("outer", "fixed", "arm", "end", "0.4 0 0"),
        joint("inner", "fixed", on, "arm"), beam("rod"), beam("arm"),
    )  # fmt: skip
    np.testing.assert_allclose(direction(machine, "arm"), (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(direction(machine, "rod"), (0, 0, 1), atol=1e-12)
    assert machine.topology.warnings == ()


def mast(*beams, mass=0.0):
    """A rod that slides upwards in a cylinder on the base, 0.4 at zero, with the platform 0.3 above."""
    return robot(
        link("base"), link("cylinder"), link("rod", mass, "0 0 0.2"), link("platform"),
        joint("foot", "fixed", "base", "cylinder"),
        joint("slide", "prismatic", "cylinder", "rod", "0 0 0.4", "0 0 1"), joint("head", "fixed", "rod", "platform", "0 0 0.3"),
        '<transmission name="t"><joint name="slide"/></transmission>', *beams,
    )  # fmt: skip


@pytest.mark.parametrize(("given", "length"), [('from="foot"', 0.7), ('to="head"', 0.3)])
def test_telescope_beam_with_one_given_end_finds_the_other(given, length):
    """The other end is the joint of the rod that the beam does not cross, or the one that is not named."""
    machine = mast(beam("rod", given))
    assert float(machine.beams["rod"].length(machine.zero_frames)[0]) == pytest.approx(length)


# ---- mistakes, and masses ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["2pru_upr", "delta", "five_bar"])
def test_error_suggests_a_missing_loop(name):
    """For beams that name the loop as an end, and for beams without given ends."""
    description = package_robots.robot(name).description
    loop = list(description.loops)[-1]
    left = replace(description, loops={key: item for key, item in description.loops.items() if key != loop})
    with pytest.raises(ks.RobotFileError, match=rf"'{loop}', which does not exist;.*is its <joint> or <loop> missing"):
        ks.Robot(left)
    beams = {
        key: replace(beam, **{end: None for end in ("start", "end") if getattr(beam, end).joint == loop})
        for key, beam in left.beams.items()
    }
    with pytest.raises(ks.RobotFileError, match=r"ends nowhere, as .* is its only joint: .* or a <loop> missing"):
        ks.Robot(replace(left, beams=beams))


def test_error_of_a_wrong_parent_names_the_dangling_link():
    description = package_robots.robot("3rps").description
    joint = replace(description.joints["prismatic_2"], parent="cylinder_1")
    with pytest.raises(
        ks.RobotFileError, match="link 'cylinder_2' ends nowhere, as 'revolute_2' is its only joint: is a <parent>"
    ):
        ks.Robot(replace(description, joints={**description.joints, "prismatic_2": joint}))


def test_beams_of_one_link_share_its_mass_by_length():
    """The weight acts at the link's centre of mass."""
    text = (CASES / "dog.urdf").read_text()
    lengths, middles = np.array([0.4, 0.2]), np.array([[0.2, 0, 0], [0.4, 0, 0.1]])
    right = lengths @ middles / lengths.sum()
    for centre in ((0.2, 0.03, 0.1), right):
        numbers = " ".join(str(float(x)) for x in centre)
        machine = ks.Robot(parse_robot_text(text.replace('xyz="0.2 0 0.1"', f'xyz="{numbers}"')))
        result = ks.analyze(machine.assemble(), gravity=(3, -2, -10))
        np.testing.assert_allclose(result.base_wrench[3:], -np.cross(centre, [18, -12, -60]), atol=1e-12)
        assert [float(beam.mass) for beam in result.beams.values()] == pytest.approx([4, 2])


def test_telescope_without_density_has_the_mass_of_its_link():
    """The weight acts at the link's centre of mass, 0.2 m above the slide; with a density it is proportional to the length."""
    stroke = np.array([0.0, 0.3])
    for density, mass, centre in (
        ("", 2.0, stroke + 0.6),
        (f'density="{RHO}"', RHO * np.pi * 0.025**2 * (stroke + 0.7), (stroke + 0.7) / 2),
    ):
        machine = mast(f'<beam link="rod" from="foot" to="head" {density} {BEAM}>{CIRCLE}</beam>', mass=2.0)
        result = ks.analyze(machine.assemble(actuators={"slide": stroke}), gravity=(-10, 0, 0))
        np.testing.assert_allclose(result.base_wrench[:, 4], 10 * mass * centre, rtol=1e-12)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (
            [link("bob", 1.0), joint("hook", "fixed", "rod", "bob", "0 0 0.2")],
            "'hook' carries load at a point of link 'rod' that is",
        ),
        (
            [
                *(link("strut"), link("end", 1.0), joint("side", "prismatic", "rod", "strut", "0 0 0.2", "1 0 0")),
                *(joint("tip", "fixed", "strut", "end", "0.3 0 0"), beam("strut", 'from="side:parent" to="tip"')),
            ],
            "<beam 'strut'>: it ends in the middle of another beam",
        ),
        (
            [
                *(
                    link("inner"),
                    link("strut", 1.0),
                    joint("foot_2", "fixed", "base", "inner"),
                    beam("strut", 'from="foot_2" to="tip"'),
                ),
                *(
                    joint("slide", "prismatic", "inner", "strut", "0 0 0.1", "1 0 0"),
                    link("end"),
                    joint("tip", "fixed", "strut", "end", "0 0 1"),
                ),
            ],
            "the axis of the prismatic joint 'slide' inside its span does not lie along the beam",
        ),
    ],
)
def test_loads_inside_spans_and_oblique_slides_are_errors(parts, words):
    column = link("base"), link("rod"), link("platform"), joint("foot", "fixed", "base", "rod")
    head = joint("head", "fixed", "rod", "platform", "0 0 0.5"), beam("rod", 'from="foot" to="head"')
    with pytest.raises(ks.RobotFileError, match=words):
        robot(*column, *head, *parts).beams  # noqa: B018


def test_beam_from_platform_to_base_is_warned_of():
    column = link("base"), link("rod"), link("platform"), joint("foot", "fixed", "base", "rod")
    machine = robot(*column, joint("head", "fixed", "rod", "platform", "0 0 0.5"), beam("rod", 'from="head" to="foot"'))
    assert "'rod' runs from its end towards the platform to the one towards the base" in machine.topology.warnings[0]


def test_error_of_zero_length_telescope_suggests_its_start():
    text = f"""<robot name="r">{link("a")}{link("b")}{link("c")}{link("p", 1.0)}
{joint("foot", "continuous", "a", "b")}{joint("slide", "prismatic", "b", "c", "0 0 1", "0 0 1")}
{joint("tip", "fixed", "c", "p")}<platform link="p"/>
<transmission name="d"><joint name="slide"/></transmission><transmission name="e"><joint name="foot"/></transmission>
<beam link="c" youngs_modulus="210e9" poisson_ratio="0.3" density="0"><circle diameter="0.04"/></beam></robot>"""
    with pytest.raises(ks.RobotFileError, match="of a telescope that is one beam, from= is the joint behind 'slide'"):
        dict(ks.Robot(parse_robot_text(text)).beams)
    long = text.replace('<beam link="c"', '<beam link="c" from="foot"')
    assert ks.analyze(ks.Robot(parse_robot_text(long)).assemble()).beams["c"].length == pytest.approx(1.0)
