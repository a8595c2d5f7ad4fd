"""Zero poses that do not close: legal ones, rounded ones, and mistakes, for which corrections are proposed."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
import small_robots as sr
from package_robots import robot
from places import TESTS

import kinetostatics as ks
from kinetostatics.checks.check import diagnose
from kinetostatics.cli.main import main
from kinetostatics.description import Origin
from kinetostatics.kinematics.loop_gaps import are_within, frame_corrections, gaps_text, other_links
from kinetostatics.math import rotations

FRAME_OFF = TESTS / "cases" / "frame_off_by_100mm.urdf.xacro"


def moved(description, joint, link, shift, turn=(0.0, 0.0, 0.0)):
    """Return a description with the origin of a joint or of one side of a loop displaced, in the axes of the link it is in."""

    def elsewhere(origin):
        R = rotations.exponential(np.asarray(turn, dtype=float)) @ origin.matrix[:3, :3]
        pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
        rpy = (np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0]))
        return Origin(tuple(np.array(origin.xyz) + shift), tuple(map(float, rpy)))

    if joint in description.joints:
        item = description.joints[joint]
        assert item.parent == link
        return replace(description, joints={**description.joints, joint: replace(item, origin=elsewhere(item.origin))})
    item = description.loops[joint]
    side = "predecessor_origin" if item.predecessor == link else "successor_origin"
    return replace(description, loops={**description.loops, joint: replace(item, **{side: elsewhere(getattr(item, side))})})


def largest_gap(robot):
    return max(max(pair) for pair in robot.zero_loop_gaps.values())


# ---- the machine with one frame 100 mm off -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def frame_off():
    return ks.load_robot(FRAME_OFF)


def test_check_reports_gaps_and_wrong_frame_and_fails(capsys):
    assert main(["check", str(FRAME_OFF)]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "where all joints are at zero they are open by 100.0 mm at tip_2, tip_3 and tip_4" in out
    assert "loops 'tip_2', 'tip_3', 'tip_4' are 0.1 m open" in out
    for origin in ("joint 'rail_1' on link 'base'", "joint 'pin_1' on link 'slider_1'"):
        assert f"moving the origin of {origin} by (-0.1, 0, 0) m" in out
    assert "tolerance" not in out and "rounded" not in out


@pytest.mark.parametrize("tolerance", [1e-4, 0.2])
def test_robot_with_a_wrong_frame_has_no_valid_pose(frame_off, tolerance):
    zero = dict.fromkeys(frame_off.description.actuated, 0.0)
    with pytest.raises(ks.AssemblyError, match="moving the origin of joint 'rail_1'"):
        frame_off.assemble(closure_tolerance=tolerance)
    batch = frame_off.assemble(actuators={**zero, "rail_1": [0.0, 0.01]}, closure_tolerance=tolerance)
    assert batch.status.tolist() == [ks.Status.UNREACHABLE] * 2
    q = frame_off.model_q(frame_off.zero_poses)[:, 0]
    assert frame_off.configuration(q, closure_tolerance=tolerance, on_failure="nan").status == ks.Status.UNREACHABLE


def test_proposed_frame_corrections_close_all_loops(frame_off):
    corrections = frame_corrections(frame_off.mechanism, frame_off.size)
    assert [item.joint for item in corrections] == ["rail_1", "pin_1", "tip_1"]
    for item in corrections:
        assert np.linalg.norm(item.shift) == pytest.approx(0.1, rel=1e-9) and not np.any(item.turn)
        mended = ks.Robot(moved(frame_off.description, item.joint, item.link, item.shift))
        assert largest_gap(mended) < 1e-12
    assert ks.analyze(mended.assemble()).status == ks.Status.OK


# ---- one frame of other machines displaced -------------------------------------------------------------------------------

OVERCONSTRAINED = ("2pru_upr", "five_bar", "orthoglide", "planar_3rrr", "spherical_3rrr", "tripteron", "exechon")


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [pytest.param(seed, marks=pytest.mark.slow) if seed == 4 else seed for seed in range(7)])
def test_a_displaced_frame_is_found(seed):
    """Any joint or side of a loop, shifted or turned: the proposals correct this frame by no more than that, and all of them
    close the loops."""
    rng = np.random.default_rng(seed)
    exact = robot(OVERCONSTRAINED[seed % len(OVERCONSTRAINED)]).description
    frames = [(joint.name, joint.parent) for joint in exact.joints.values()]
    frames += [(loop.name, link) for loop in exact.loops.values() for link in (loop.predecessor, loop.successor)]
    joint, link = frames[rng.integers(len(frames))]
    size = 10 ** rng.uniform(-3, -1)
    change = rng.standard_normal(3) * size
    wrong = moved(exact, joint, link, *((change, (0, 0, 0)) if seed % 3 else ((0, 0, 0), change)))
    displaced = ks.Robot(wrong)
    if largest_gap(displaced) < 1e-9:  # along a freedom of the loops, or outside all loops
        assert not displaced.has_wrong_zero and displaced.closing_error < 1e-12
        return
    corrections = frame_corrections(displaced.mechanism, displaced.size)
    [mine] = [item for item in corrections if (item.joint, item.link) == (joint, link)]
    assert np.linalg.norm(mine.shift) / displaced.size + np.linalg.norm(mine.turn) < 1.05 * np.linalg.norm(change) * max(
        1, 1 / displaced.size
    )
    for item in corrections:
        assert largest_gap(ks.Robot(moved(wrong, item.joint, item.link, item.shift, item.turn))) < 2e-5
    if displaced.has_wrong_zero:
        with pytest.raises(ks.AssemblyError, match="A frame in the file is wrong"):
            displaced.assemble(closure_tolerance=1e-3)
    else:  # the joints close it: another machine, but one that exists
        assert displaced.closing_error < 1e-9 or displaced.closing_error < 1e-5


def test_wrong_frame_that_nearly_closes_elsewhere_is_detected():
    """A frame is 2 mm off, but with other joint positions the loops close to micrometres."""
    exact = package_robots.robot("2pru_upr").description
    shift = (6.15076679e-06, 1.49372769e-03, -1.37068928e-03)
    robot = ks.Robot(moved(exact, "universal_2", exact.loops["universal_2"].successor, shift))
    assert 1e-5 < robot.closing_error < 1e-4 and robot.has_wrong_zero
    with pytest.raises(ks.AssemblyError, match=r"universal_2.*moving"):
        robot.assemble(closure_tolerance=1e-3)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_a_wrong_axis_of_a_loop_is_named(axis):
    """A five-bar whose loop has unturned frames on both links: it is closed at zero only with the axis z."""
    exact = package_robots.robot("five_bar").description
    loop = exact.loops["wrist"]
    turned = exact.changed("wrist", predecessor_origin=Origin(loop.predecessor_origin.xyz))
    assert not ks.Robot(turned).has_wrong_zero and largest_gap(ks.Robot(turned)) < 1e-12
    wrong = ks.Robot(turned.changed("wrist", axis=axis))
    words = "All loops would be closed at zero with the <axis> (0, 0, 1) of 'wrist'"
    assert any(words in text for text in diagnose(wrong).warnings + diagnose(wrong).problems)


# ---- a joint on a wrong link ---------------------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("name", "joint", "wrong", "also"),
    [
        ("planar_3rrr", "elbow_2", "crank_1", []),
        ("delta", "upper_2a_y", "elbow_1", []),
        ("five_bar", "elbow_2", "proximal_1", ["joint 'clamp' on link 'distal_2'", "loop 'wrist' on link 'distal_1'"]),
    ],
)
def test_a_wrong_parent_is_named(name, joint, wrong, also):
    """The joint's numbers are right: on the right link they close all loops at zero."""
    right = replace(package_robots.robot(name).description, beams={}, joint_stiffness={})
    parent = right.joints[joint].parent
    robot = ks.Robot(replace(right, joints={**right.joints, joint: replace(right.joints[joint], parent=wrong)}))
    found = [str(item) for item in other_links(robot.mechanism, robot.size)]
    assert found[0] == f"joint {joint!r} on link {parent!r} instead of {wrong!r}"
    assert [item.partition(" instead")[0] for item in found[1:]] == also
    [hint] = [text for text in diagnose(robot).warnings if "a frame in the file is wrong" in text]
    assert f"Or a link is wrong: all loops would close with {', or '.join(found)}, with unchanged numbers" in hint


@pytest.mark.parametrize("side", [0, 1])
def test_a_wrong_side_of_a_loop_is_named(side):
    """A loop's predecessor or successor is another link, with another frame."""
    right = replace(package_robots.robot("planar_3rrr").description, beams={}, joint_stiffness={})
    loop = right.loops["tip_2"]
    key, link, wrong = (("predecessor", loop.predecessor, "coupler_3"), ("successor", loop.successor, "crank_1"))[side]
    robot = ks.Robot(replace(right, loops={**right.loops, "tip_2": replace(loop, **{key: wrong})}))
    [found] = [item for item in other_links(robot.mechanism, robot.size) if item.joint == "tip_2"]
    assert found.is_loop and link in found.others and found.link == wrong


# ---- legal other zeros ---------------------------------------------------------------------------------------------------


def other_zero(description, joint, angle):
    """Return a description in which a hinge's coordinate is ``angle`` less than before."""
    item = description.joints[joint]
    axis = item.origin.matrix[:3, :3] @ np.array(item.axis)
    return moved(description, joint, item.parent, (0, 0, 0), angle * axis / np.linalg.norm(axis))


@pytest.mark.parametrize(("name", "joint"), [("planar_3rrr", "elbow_2"), ("2pru_upr", "revolute_1")])
def test_other_zero_of_a_joint_is_accepted(name, joint):
    """Loops far from closed where all joints are at zero, which the joints close."""
    robot = ks.Robot(other_zero(package_robots.robot(name).description, joint, 0.1))
    assert largest_gap(robot) > 1e-2 and not robot.has_wrong_zero
    assert robot.closing_error < 1e-9


def test_other_zero_with_rounded_angles_is_accepted():
    """A tolerance accepts the rounding, but no message proposes it, as the gap at zero might be a mistake too."""
    rounded = 1.5707963 - np.pi / 2
    description = other_zero(package_robots.robot("2pru_upr").description, "revolute_1", 0.05)
    loop = description.loops["universal_2"]
    robot = ks.Robot(moved(description, "universal_2", loop.predecessor, (0, 0, 0), (50 * rounded, 50 * rounded, 50 * rounded)))
    assert 1e-9 < robot.closing_error < 1e-5 and not robot.has_wrong_zero
    assert max(map(abs, robot.assemble(closure_tolerance=1e-5).actuators.values())) < 1e-12  # a motion would close no better
    pose = robot.configuration(robot.model_q(robot.zero_poses)[:, 0], closure_tolerance=1e-5)
    assert pose.status == ks.Status.OK
    with pytest.raises(ks.AssemblyError, match="rounded or wrong") as caught:
        robot.configuration(pose.q)
    assert "a tolerance of" not in str(caught.value)


@pytest.mark.parametrize(("gap", "accepted"), [(0.9e-4, True), (0.9e-3, True), (1.1e-3, False)])
def test_tolerance_accepts_gaps_up_to_a_thousandth_of_size(gap, accepted):
    """A four-bar linkage whose second crank stands out of the plane by part of its size."""
    exact = sr.write(sr.four_bar()).description()
    size = ks.Robot(exact).size
    loop = exact.loops["head_2"]
    robot = ks.Robot(moved(exact, "head_2", loop.predecessor, (0, gap * size, 0)))
    assert robot.has_wrong_zero == (gap > 1e-4)
    with pytest.raises(ks.AssemblyError) as caught:
        robot.assemble()
    assert ("accept the gap with a tolerance" in str(caught.value)) == (gap < 1e-4)
    assert ("moving the origin" in str(caught.value)) == (gap > 1e-4)
    assert ("rounded" in str(caught.value)) == (gap < 1e-3)
    result = robot.assemble(closure_tolerance=2e-3, on_failure="nan")
    assert result.status == (ks.Status.OK if accepted else ks.Status.UNREACHABLE)
    if 1e-4 < gap < 1e-3:  # a tolerance below the gap is not enough, even where the loops are open by less
        assert robot.assemble(closure_tolerance=0.8 * gap * size, on_failure="nan").status == ks.Status.UNREACHABLE


def test_two_wrong_frames_have_no_single_correction():
    exact = package_robots.robot("planar_3rrr").description
    links = {name: exact.loops[name].predecessor for name in exact.loops}
    wrong = exact
    for number, (name, link) in enumerate(links.items()):
        wrong = moved(wrong, name, link, (0.0, 0.0, 0.01 * (number + 1)))
    robot = ks.Robot(wrong)
    assert frame_corrections(robot.mechanism, robot.size) == ()
    with pytest.raises(ks.AssemblyError, match="No correction of a single frame would close all loops at zero"):
        robot.assemble()


def test_loop_gaps_are_described_in_words():
    gaps = {"a": (0.1, 0.0), "b": (0.0, 2e-9), "c": (0.1, 0.0), "d": (1e-10, 1e-10), "e": (0.2, 0.3)}
    words = "loops 'a', 'c' are 0.1 m open, loop 'b' is 2e-09 rad open, loop 'e' is 0.2 m and 0.3 rad open"
    assert gaps_text(gaps) == f"{words} (1 other closed)"
    assert gaps_text({**gaps, "f": (0.0, 0.0)}) == f"{words} (2 others closed)"
    assert gaps_text({"a": (0.1, 0.0)}) == "loop 'a' is 0.1 m open" and gaps_text({"d": (0.0, 0.0)}) == ""
    assert are_within(gaps, 0.2, 0.3) and not are_within(gaps, 0.19, 0.3) and not are_within(gaps, 0.2, 0.29)
