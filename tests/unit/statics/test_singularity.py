"""Special poses: degenerate wrench bases, limbs with dependent joints, stretched arms, telescopes of no or negative length."""

from dataclasses import replace

import finite_elements
import numpy as np
import pinocchio as pin
import pytest
from degenerate_limbs import DEPENDENT, FOOT, HEAD, KNEE, X, Y, Z, cuts_of, joints, serial
from mechanisms import write_mechanism
from places import CASES
from telescopes import mast

import kinetostatics as ks
from kinetostatics.description import Joint, JointStiffness, Link, Origin, RobotDescription
from kinetostatics.files.bundled import robot_path
from kinetostatics.limbs import basis_choice as wrench_bases


@pytest.mark.usefixtures("by_numpy")
def test_results_do_not_depend_on_nearly_coinciding_wrenches(monkeypatch):
    """Chosen at generic poses only, a force of J_ic and one of J_ig would lie on the same line but for 1e-5."""
    robot = ks.load_robot(CASES / "basis_degenerates_to_nan.urdf")
    found = ks.analyze(robot.assemble())
    assert found.status == ks.Status.OK
    same_but_intensities(found, monkeypatch)


def same_but_intensities(found, monkeypatch):
    """Compare a result with that of orthonormal bases in all limbs: only intensities depend on the basis."""
    monkeypatch.setattr(wrench_bases, "DEGENERATE", 2.0)
    other = ks.analyze(found.configuration)
    assert other.basis_degenerate
    for name in ("twist", "stiffness", "compliance", "base_wrench", "strain_energy"):
        close(getattr(found, name), getattr(other, name))
    for name in ("joint_wrenches", "actuator_forces"):
        close(*(list(getattr(result, name).values()) for result in (found, other)))
    close(*([limb.wrench for limb in result.limbs.values()] for result in (found, other)))
    for name, beam in found.beams.items():
        close(beam.deflections, other.beams[name].deflections)
        close(beam.section_wrenches, other.beams[name].section_wrenches)


def close(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.usefixtures("by_numpy")
@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["2pru_upr", "delta", "tricept", "orthoglide"])
def test_results_do_not_depend_on_the_wrench_basis(name, monkeypatch):
    same_but_intensities(ks.analyze(ks.load_robot(robot_path(name)).assemble()), monkeypatch)


# ---- limbs whose joints are dependent at a pose: they resist one wrench more there -------------------------------------------


def compared(mechanism):
    """Return the result at the zero pose after comparison with finite elements."""
    file = write_mechanism(mechanism, cuts=cuts_of(mechanism))
    robot = file.robot()
    pose = robot.configuration(pin.neutral(robot.model))
    found, answer = ks.analyze(pose), finite_elements.solve(mechanism, file, pose)
    assert answer.unbalanced < 1e-9 and not answer.free and answer.gap > 1e8
    close(found.twist, answer.twist)
    close(found.compliance, answer.compliance)
    sure = {joint for joint in answer.joint_wrenches if answer.sure[joint]}
    assert len(sure) > 6
    for joint in sure:
        sign = -1 if joint in answer.inward and not mechanism.joints[joint].kind == "F" else 1
        wanted = answer.joint_wrenches[joint]
        np.testing.assert_allclose(
            found.joint_wrenches[file.runs[joint][-1]], sign * wanted, rtol=0, atol=1e-8 * np.abs(wanted).max() + 1e-6
        )
    return found


@pytest.mark.few(2)
@pytest.mark.parametrize("name", DEPENDENT)
def test_limb_with_dependent_joints_carries_one_more_wrench(name):
    found = compared(DEPENDENT[name])
    assert found.status == ks.Status.BASIS_DEGENERATE
    limb = found.limbs["limb_2"]
    assert np.all(np.isnan(limb.intensities)) and limb.intensities.shape == (len(limb.labels),)
    assert np.all(np.isfinite(limb.wrench)) and limb.compliance.shape == (len(limb.labels),) * 2
    assert limb.constraint_wrenches.shape == (6, len(limb.labels)) and limb.sag.shape == (len(limb.labels),)
    assert limb.attached_wrenches.shape == (6, len(limb.attached_labels))
    assert limb.attached_intensities.shape == (len(limb.attached_labels),) and limb.stiffness.shape == limb.compliance.shape
    assert np.all(np.isfinite(found.limbs["limb_1"].intensities))
    assert np.all(np.isfinite(next(iter(found.joint_contributions.values()))["load"]))
    close(sum(found.contributions.values()), found.twist)
    parts = [twist for kind in found.source_contributions.values() for twist in kind.values()]
    close(sum(parts), found.twist)


@pytest.mark.parametrize("kinds", [("S", "R", "S"), ("P", "R", "R", "R")])
def test_nearly_stretched_limb_is_not_degenerate(kinds):
    """The knee of a leg is 40 µm off its line: its joints are checked for dependence, and are independent."""
    points, axes = [FOOT] * (len(kinds) - 2) + [(KNEE[0] + 4e-5, *KNEE[1:]), HEAD], {"S": Z, "R": Y, "P": X}
    mechanism = serial(*joints(kinds, points, [axes[kind] for kind in kinds], actuated=[k for k in (0,) if kinds[k] == "P"]))
    robot = write_mechanism(mechanism, cuts=cuts_of(mechanism)).robot()
    found = ks.analyze(robot.configuration(pin.neutral(robot.model)))
    usual = next(item for item in found.solutions[0].statics if item.group.numbers == (1,))
    assert np.all(usual.doubtful) and not usual.group.at_one_pose
    assert found.status == ks.Status.OK and np.all(np.isfinite(found.limbs["limb_2"].intensities))


@pytest.mark.few(1)
@pytest.mark.parametrize("name", list(DEPENDENT)[1::3])
def test_degenerate_pose_in_a_batch_equals_the_pose_alone(name):
    mechanism = DEPENDENT[name]
    robot = write_mechanism(mechanism, cuts=cuts_of(mechanism)).robot()
    zero, others = pin.neutral(robot.model), robot.model_q(robot.generic_poses).T
    at = [others[0], zero, others[1], zero, zero]
    batch, reversed_batch = (ks.analyze(robot.configuration(poses, closure_tolerance=1e-8)) for poses in (at, at[::-1]))
    assert batch.basis_degenerate.tolist() == [False, True, False, True, True]
    np.testing.assert_allclose(reversed_batch.twist[::-1], batch.twist, rtol=0, atol=1e-9 * np.nanmax(np.abs(batch.twist)))
    for k in range(5):
        alone = ks.analyze(robot.configuration(batch.configuration.q[k], closure_tolerance=1e-8), on_failure="nan")
        assert alone.status == batch.status[k]
        close(batch.twist[k], alone.twist)
        close(batch.base_wrench[k], alone.base_wrench)
        close([w[k] for w in batch.joint_wrenches.values()], list(alone.joint_wrenches.values()))
        for limb, mine in batch.limbs.items():
            np.testing.assert_allclose(mine.intensities[k], alone.limbs[limb].intensities, rtol=1e-6, atol=1e-7)
        for beam, mine in batch.beams.items():
            close(mine.deflections[k], alone.beams[beam].deflections)


def test_level_stretched_leg_cannot_hold_its_weight():
    level = serial(*joints("PRRR", ((0.9, 0, 0.8), (0.9, 0, 0.8), (0.5, 0, 0.8), (0.1, 0, 0.8)), (X, Y, Y, Y), actuated=[0]))
    robot = write_mechanism(level, cuts=cuts_of(level)).robot()
    with pytest.raises(ks.exceptions.LimbEquilibriumError, match="limb_2 cannot hold its own weight"):
        ks.analyze(robot.configuration(pin.neutral(robot.model)))


AXES = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0))
PLACES = ((0, 0, 0.1), (0, 0.1, 0), (0.6, 0, 0), (0.5, 0, 0), (0, 0.1, 0), (0, 0, -0.1))
STIFFNESS = np.array([6e4, 6e4, 3e4, 1e4, 1e4, 1e4])
LOAD = np.array([30.0, -40.0, -100.0, 2.0, 5.0, -7.0])


@pytest.fixture(scope="module")
def arm():
    """Return an arm of six hinges; at zero it is stretched and its wrist straight."""
    links = [Link(f"l{k}", 1.0 + k, (0.1, 0.02, 0.01)) for k in range(7)]
    joints = [
        Joint(f"j{k}", "revolute", f"l{k}", f"l{k + 1}", Origin(place), axis, -3.0, 3.0)
        for k, (axis, place) in enumerate(zip(AXES, PLACES, strict=True))
    ]
    names = [joint.name for joint in joints]
    soft = [JointStiffness(name, drive=value) for name, value in zip(names, STIFFNESS, strict=True)]
    return ks.Robot(RobotDescription.of("arm", links=links, joints=joints, platform="l6", joint_stiffness=soft, actuated=names))


def expected(arm, q, gravity):
    """Return J and J k⁻¹ (Jᵀ W − g(q)) with Pinocchio's Jacobian and gravity torques."""
    model = pin.buildModelFromXML(arm.description.urdf)
    model.gravity = pin.Motion(np.array(gravity), np.zeros(3))
    data = model.createData()
    J = pin.computeFrameJacobian(model, data, q, model.getFrameId("l6"), pin.LOCAL_WORLD_ALIGNED)
    torques = pin.computeGeneralizedGravity(model, data, q)
    return J, J @ ((J.T @ LOAD - torques) / STIFFNESS)


@pytest.mark.parametrize(
    ("q", "rank"),
    [
        ((0, 0, 0, 0, 0, 0), 5),
        ((0, 0.4, 0, 0, 0, 0), 5),
        ((0.2, -0.3, 0.8, 0.1, 0, 0.3), 5),
        ((0.2, -0.3, 0.8, 0.1, 0.5, 0.3), 6),
    ],
)
def test_arm_at_singular_poses_sags_by_its_drives(arm, q, rank) -> None:
    result = ks.analyze(arm.assemble(actuators=dict(zip(arm.description.actuated, q, strict=True))), load=LOAD)
    J, twist = expected(arm, np.array(q, dtype=float), (0, 0, -9.81))
    assert np.sum(np.linalg.svd(J)[1] > 1e-9) <= rank
    np.testing.assert_allclose(result.twist, twist, atol=1e-10 * np.abs(twist).max())
    np.testing.assert_allclose(result.compliance, J / STIFFNESS @ J.T, atol=1e-10 * np.abs(J / STIFFNESS @ J.T).max())
    assert result.status == ks.Status.OK


def test_batch_around_stretched_pose_matches_jacobian_formula(arm) -> None:
    elbow = np.array([-1e-2, -1e-4, 0.0, 1e-4, 1e-2])
    zero = dict.fromkeys(arm.description.actuated, 0.0)
    batch = ks.analyze(arm.assemble(actuators={**zero, "j2": elbow}), load=LOAD)
    assert np.all(batch.status == ks.Status.OK)
    for twist, value in zip(batch.twist, elbow, strict=True):
        right = expected(arm, np.array([0, 0, value, 0, 0, 0]), (0, 0, -9.81))[1]
        np.testing.assert_allclose(twist, right, atol=1e-7 * np.abs(right).max())


def posed(robot: ks.Robot, *slides: float | list[float]) -> ks.Configuration:
    return robot.assemble(actuators=dict(zip(("slide_a", "slide_b"), slides, strict=True)))


def test_error_names_telescope_of_negative_length() -> None:
    pose = posed(mast(), -0.6, 0.3)
    with pytest.raises(ks.StaticsError, match=r"'beam_a' \(-0.1 m from start to end\)") as caught:
        ks.analyze(pose, load=[1, 2, -3, 0, 0, 0])
    assert "beam_b" not in str(caught.value)
    with pytest.raises(ks.StaticsError, match=r"'beam_a' \(-0.1 m from start to end\)"):
        pose.model  # noqa: B018


def test_batch_marks_poses_with_negative_telescope_length_singular() -> None:
    """The mast's compliance alone does not show it: the longer second telescope keeps it positive."""
    poses = posed(mast(), [-0.4, -0.49, -0.6, -0.7], [0.3] * 4)
    result = ks.analyze(poses)
    assert result.status.tolist() == [ks.Status.OK, ks.Status.OK, ks.Status.SINGULAR, ks.Status.SINGULAR]
    assert np.isfinite(result.twist[:2]).all()
    assert np.isnan(result.twist[2:]).all()


def test_open_branch_may_have_a_telescope_of_zero_length() -> None:
    """A branch on the platform by a telescope of zero length does not bend."""
    whole = mast().description
    branch = ks.Robot(replace(whole, platform="end_a"))
    with np.errstate(all="raise"):
        found = ks.analyze(posed(branch, 0.0, -0.5), [10, 0, 0, 0, 0, 0])
        motion = sum(found.link_contributions["end_b"].values())
        assert not found.buckles
    np.testing.assert_allclose(motion, found.twist, rtol=1e-12)  # their origins are one point


def test_poses_within_some_microradians_of_a_singular_one_are_singular():
    """A hexapod turned by nearly a quarter turn (Fichter, 1986): its stiffness is definite longer than its wrenches are."""
    robot = ks.load_robot("gough_stewart")
    height = float(robot.assemble().platform["z"])
    turned = {"x": 0.0, "y": 0.0, "z": height, "rx": 0.0, "ry": 0.0, "rz": np.pi / 2 - np.array([1e-8, 1e-6, 1e-5])}
    found = ks.analyze(robot.assemble(platform=turned), on_failure="nan")
    assert (found.status == ks.Status.SINGULAR).tolist() == [True, True, False]


def test_nothing_is_out_of_balance_where_nothing_weighs():
    result = ks.analyze(ks.load_robot("3rps").assemble(), gravity=(0, 0, 0))
    assert {name: part.tolist() for name, part in result.solutions[0].unbalanced.items()} == {
        name: [0.0] for name in result.limbs
    }


def test_nothing_is_out_of_balance_in_a_branch_without_weight():
    """A pointer without mass, on a passive hinge that is free to turn: no share of any weight is left."""
    description = ks.load_robot("3rps").description
    pointer = Joint("pivot", "continuous", "platform", "pointer", Origin((0.1, 0, 0)), axis=(0, 1, 0))
    robot = ks.Robot(description.with_part(Link("pointer")).with_part(pointer))
    found = ks.analyze(robot.assemble(), load=[1, 2, -30, 0, 0, 0])
    assert found.solutions[0].unbalanced["platform"].tolist() == [0.0] and found.status == ks.Status.OK
