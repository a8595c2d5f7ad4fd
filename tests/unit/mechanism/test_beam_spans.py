"""Where beams begin and end: over slides that are welded, and without being told."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
import small_robots as sr
from mechanisms import Joint, Link, unit
from places import CASES

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
def test_a_beam_over_a_welded_slide_is_the_beam_on_one_link(carrier, cut, density):
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


def test_finite_elements_agree_about_a_welded_slide():
    pytest.importorskip("openseespy")
    robot = sr.robot_of(welded(0.4, "rod"), cuts=[0, 1], twirl=3)
    assert max(ks.verify(robot.assemble(), LOAD, GRAVITY).differences.values()) < 1e-6


@pytest.mark.parametrize("cut", [1, 2])
def test_what_is_wrong_with_a_beam_over_a_welded_slide_is_said(cut):
    spec = welded(0.4, "rod", None)
    along = replace(spec, beams=(spec.beams[0], replace(spec.beams[1], y_axis=tuple(HEAD - FOOT))))
    with pytest.raises(ks.RobotFileError, match="y_axis is parallel"):
        sr.robot_of(along, cuts=[0, cut], twirl=1)
    foot, weld, head = spec.limbs[1].joints
    short = replace(spec.limbs[1], joints=(foot, weld, replace(head, centre=foot.centre)))
    short = replace(spec, limbs=(spec.limbs[0], short))
    with pytest.raises(ks.RobotFileError, match="same point"):
        sr.robot_of(short, cuts=[0, cut], twirl=1)


def test_a_telescope_held_by_a_fixed_loop_is_read():
    robot = ks.load_robot(CASES / "telescope_held_by_weld.urdf")
    result = ks.analyze(robot.assemble())
    assert result.status == ks.Status.OK
    assert float(result.beams["l3_link1_rod"].length) == pytest.approx(0.128802, rel=1e-4)


# ---- beams without from and to -------------------------------------------------------------------------------------------

BEAM = 'youngs_modulus="2e11" poisson_ratio="0.3" density="7850"><circle diameter="0.02"/></beam>'


LADDER = """<robot name="ladder"><link name="base"/><link name="left"/><link name="right"/><link name="rung"/>
<link name="platform"/>LEFT_FOOT<platform link="platform"/>
<joint name="foot_2" type="continuous"><parent link="base"/><child link="right"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="head_1" type="continuous"><parent link="left"/><child link="platform"/><origin xyz="0 0 1"/>
<axis xyz="0 1 0"/></joint>RUNG<loop name="head_2" type="continuous"><predecessor link="right"><origin xyz="0 0 1"/></predecessor>
<successor link="platform"><origin xyz="1 0 0"/></successor><axis xyz="0 1 0"/></loop></robot>"""
LEFT_FOOT = '<joint name="foot_1" type="continuous"><parent link="FROM"/><child link="left"/><axis xyz="0 1 0"/></joint>'
JOINT = '<joint name="{}" type="fixed"><parent link="{}"/><child link="rung"/><origin xyz="0 0 1"/></joint>'
LOOP = """<loop name="{}" type="spherical"><predecessor link="{}"><origin xyz="0 0 1"/></predecessor>
<successor link="rung"><origin xyz="{} 0 0"/></successor></loop>"""
#: the tree reaches the rung from the left or from the right; its frame is there
FROM_LEFT, FROM_RIGHT = (
    JOINT.format("b", "left") + LOOP.format("a", "right", 1),
    JOINT.format("b", "right") + LOOP.format("a", "left", -1),
)


def ladder(foot, rung):
    """Two upright rods 1 m apart, hinged on base and platform, and a rung between their heads, whose beam names no ends."""
    ends = {"left": 'from="foot_1" to="head_1"', "right": 'from="foot_2" to="head_2"'}
    rods = "".join(f'<beam link="{rod}" {ends[rod]} {BEAM}' for rod in ends)
    beams = f'{rods}<beam link="rung" {BEAM}</robot>'
    return ks.Robot(parse_robot_text(LADDER.replace("LEFT_FOOT", foot).replace("RUNG", rung).replace("</robot>", beams)))


def direction(robot, name):
    """Return which way a beam runs in the world."""
    span, frames = SpanFinder(robot.mechanism).spans()[name], robot.zero_frames
    start = frames.points(np.array([span.start_body]), span.start[:, None])
    end = frames.points(np.array([span.end_body]), span.end[:, None])
    return unit((end - start)[:, 0, 0])


@pytest.mark.parametrize(("rung", "wanted"), [(FROM_LEFT, 1), (FROM_RIGHT, -1)])
def test_a_tie_is_decided_by_the_order_of_the_file(rung, wanted):
    """Both ends of the rung are two joints from the base; joints of the tree come before loops."""
    robot = ladder(LEFT_FOOT.replace("FROM", "base"), rung)
    np.testing.assert_allclose(direction(robot, "rung"), (wanted, 0, 0), atol=1e-12)
    for rod in ("left", "right"):
        np.testing.assert_allclose(direction(robot, rod), (0, 0, 1), atol=1e-12)


HINGE, SLIDE = (
    '<link name="block"/><joint name="below" type="continuous">'
    '<parent link="base"/><child link="block"/><axis xyz="AXIS"/></joint>',
    '<link name="block"/><joint name="below" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="AXIS"/>'
    '<limit lower="-1" upper="1" effort="0" velocity="0"/></joint>',
)  # fmt: skip
HEAVY = (
    '<link name="block"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
)


@pytest.mark.parametrize("rung", [FROM_LEFT, FROM_RIGHT])
@pytest.mark.parametrize(
    ("below", "one"),
    [
        (HINGE.replace("AXIS", "1 0 0"), True),  # a universal joint
        (HINGE.replace("AXIS", "1 0 0").replace("/><axis", '/><origin xyz="0 0 -0.3"/><axis'), False),  # its axes do not meet
        (HINGE.replace("AXIS", "1 0 0").replace('<link name="block"/>', HEAVY), False),
        (SLIDE.replace("AXIS", "0 1 0"), True),  # a cylindrical joint
        (SLIDE.replace("AXIS", "1 0 0"), False),
        (SLIDE.replace("AXIS", "0 1 0") + '<transmission name="t"><joint name="below"/></transmission>', False),
    ],
)
def test_fewer_joints_from_the_base_is_the_beginning(below, one, rung):
    """One joint more below the left rod, unless it is one joint with the hinge there: universal or cylindrical."""
    foot = LEFT_FOOT.replace("FROM", "block")
    if "-0.3" in below:
        foot = foot.replace("<axis", '<origin xyz="0 0 0.3"/><axis')
    robot = ladder(below + foot, rung)
    wanted = (1 if rung is FROM_LEFT else -1) if one else -1
    np.testing.assert_allclose(direction(robot, "rung"), (wanted, 0, 0), atol=1e-12)


@pytest.mark.parametrize("on", ["base", "platform"])
def test_a_part_that_hangs_begins_where_it_hangs(on):
    """A bracket on base or platform alone: its beam runs outwards."""
    text = f"""<robot name="bracket"><link name="base"/><link name="rod"/><link name="platform"/><platform link="platform"/>
    <link name="end"/><link name="arm"/>
    <joint name="foot" type="fixed"><parent link="base"/><child link="rod"/></joint>
    <joint name="head" type="fixed"><parent link="rod"/><child link="platform"/><origin xyz="0 0 0.5"/></joint>
    <joint name="outer" type="fixed"><parent link="arm"/><child link="end"/><origin xyz="0.4 0 0"/></joint>
    <joint name="inner" type="fixed"><parent link="{on}"/><child link="arm"/></joint>
    <beam link="rod" {BEAM}<beam link="arm" {BEAM}</robot>"""
    robot = ks.Robot(parse_robot_text(text))
    np.testing.assert_allclose(direction(robot, "arm"), (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(direction(robot, "rod"), (0, 0, 1), atol=1e-12)
    assert robot.topology.warnings == ()


@pytest.mark.parametrize("given", ['from="foot"', 'to="head"'])
def test_one_end_of_a_telescope_is_enough(given):
    """The other is the rod's joint that the beam does not cross, or that is not named."""
    text = f"""<robot name="mast"><link name="base"/><link name="cylinder"/><link name="rod"/><link name="platform"/>
    <platform link="platform"/><joint name="foot" type="fixed"><parent link="base"/><child link="cylinder"/></joint>
    <joint name="slide" type="prismatic"><parent link="cylinder"/><child link="rod"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint><transmission name="t"><joint name="slide"/></transmission>
    <joint name="head" type="fixed"><parent link="rod"/><child link="platform"/><origin xyz="0 0 0.3"/></joint>
    <beam link="rod" {given} {BEAM}</robot>"""
    robot = ks.Robot(parse_robot_text(text))
    length = float(robot.beams["rod"].length(robot.zero_frames)[0])
    assert length == pytest.approx(0.7 if "from" in given else 0.3)


# ---- what beginners forget -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["2pru_upr", "delta", "five_bar"])
def test_a_missing_loop_is_told_as_one(name):
    """Whether the beam names it or leaves its ends out."""
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


def test_a_wrong_parent_is_told_by_the_link_that_is_left_alone():
    description = package_robots.robot("3rps").description
    joint = replace(description.joints["prismatic_2"], parent="cylinder_1")
    with pytest.raises(
        ks.RobotFileError, match="link 'cylinder_2' ends nowhere, as 'revolute_2' is its only joint: is a <parent>"
    ):
        ks.Robot(replace(description, joints={**description.joints, "prismatic_2": joint}))


def loaded(tmp_path, text):
    (tmp_path / "robot.urdf").write_text(text)
    return ks.load_robot(tmp_path / "robot.urdf")


def test_mass_of_a_link_with_several_beams(tmp_path):
    """The mass is spread by length, and weighs where the link's centre of mass is."""
    text = (CASES / "dog.urdf").read_text()
    lengths, middles = np.array([0.4, 0.2]), np.array([[0.2, 0, 0], [0.4, 0, 0.1]])
    right = lengths @ middles / lengths.sum()
    for centre in ((0.2, 0.03, 0.1), right):
        numbers = " ".join(str(float(x)) for x in centre)
        robot = loaded(tmp_path, text.replace('xyz="0.2 0 0.1"', f'xyz="{numbers}"'))
        result = ks.analyze(robot.assemble(), gravity=(3, -2, -10))
        np.testing.assert_allclose(result.base_wrench[3:], -np.cross(centre, [18, -12, -60]), atol=1e-12)
        assert [float(beam.mass) for beam in result.beams.values()] == pytest.approx([4, 2])


def test_mass_of_a_telescope_without_density(tmp_path):
    beam = '<beam link="rod" from="a" to="b" youngs_modulus="2e11" poisson_ratio="0.3"{}><circle diameter="0.02"/></beam>'
    text = """<robot name="r"><link name="g"/><link name="rod"><inertial><mass value="2"/><origin xyz="0.2 0 0"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="tube"/><link name="p"/>
    <joint name="a" type="fixed"><parent link="g"/><child link="tube"/></joint>
    <joint name="s" type="prismatic"><parent link="tube"/><child link="rod"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
    <joint name="b" type="fixed"><parent link="rod"/><child link="p"/><origin xyz="0.4 0 0"/></joint>
    <transmission name="t"><joint name="s"/></transmission><platform link="p"/>BEAM</robot>"""
    stroke = np.array([0.0, 0.3])
    by_density = 7800 * np.pi * 1e-4 * (stroke + 0.4), (stroke + 0.4) / 2
    for density, mass, centre in (("", 2, stroke + 0.2), (' density="7800"', *by_density)):
        robot = loaded(tmp_path, text.replace("BEAM", beam.format(density)))
        result = ks.analyze(robot.assemble(actuators={"s": stroke}), gravity=(0, 0, -10))
        np.testing.assert_allclose(result.base_wrench[:, 4], -10 * mass * centre, rtol=1e-12)
