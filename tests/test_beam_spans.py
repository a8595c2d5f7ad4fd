"""Where beams begin and end: over slides that are welded, and without being told."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_robots as sr
from mechanisms import Joint, Link, unit

import kinetostatics as ks
from kinetostatics.robot_file import parse_robot_text

CASES = Path(__file__).parent / "cases"
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
        spec.beams[1], name="strut", link=carrier, start="foot_2" if at else "weld", section=SECTION, y_axis=tuple(unit((1, 2, 0)))
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


@pytest.mark.parametrize("density", [7850.0, None])
@pytest.mark.parametrize("cut", [0, 1, 2])
@pytest.mark.parametrize("carrier", ["cylinder", "rod"])
def test_a_beam_over_a_welded_slide_is_the_beam_on_one_link(carrier, cut, density):
    """Whether the weld is a joint (cuts 0 and 2) or a loop (cut 1), and whichever link carries the beam."""
    spec = welded(0.4, carrier, density)
    single = welded(0.0, "rod", density)
    if carrier == "cylinder":  # nothing is left on the cylinder, whose mass is the beam's
        single = replace(single, limbs=(single.limbs[0], replace(single.limbs[1], links=(Link("cylinder"), single.limbs[1].links[1]))))
    wanted = numbers_of(sr.robot_of(single))
    robot = sr.robot_of(spec, cuts=[0, cut], twirl=cut + 1)
    assert ("weld" in robot.description.loops) == (cut == 1)
    assert not robot.description.warnings and not any("centre of mass" in text for text in robot.topology.warnings)
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
    rod = replace(spec.limbs[1].links[1], com=tuple(FOOT + 0.75 * (HEAD - FOOT)))
    beside = replace(spec, limbs=(spec.limbs[0], replace(spec.limbs[1], links=(spec.limbs[1].links[0], rod))))
    [warning] = sr.robot_of(beside, cuts=[0, cut], twirl=1).topology.warnings
    gap = 0.25 * float(np.linalg.norm(HEAD - FOOT))
    assert f"the centre of mass of link 'rod' lies {gap:.4g} m from the middle of its beam 'strut'" in warning
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
