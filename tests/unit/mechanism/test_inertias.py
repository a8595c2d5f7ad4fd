"""Moments of inertia that no body has are refused where modes and motions need them; rounded ones are not, nor by statics."""

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics.description import Inertia
from kinetostatics.math.linalg import semidefinite

#: Uses of inertia.
USES = {
    "modes": lambda pose, **more: ks.modes(pose, 2, **more).frequencies,
    "response": lambda pose, **more: ks.frequency_response(pose, [10.0], **more).compliance,
    "motion": lambda pose, **more: ks.analyze(pose, motion=ks.Motion({"a": 1.0}, {"b": 2.0}), **more).twist,
}


def moments(xx, xy=0.0, xz=0.0, yy=0.1, yz=0.0, zz=0.1):
    return f'<inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>'


SOUND = moments(0.1)


def arm(tmp_path, upper=SOUND, base=""):
    """Two links in a row, on elastic joints about y and z; the first link is in line 3."""

    def joint(name, parent, child, axis):
        return f"""<joint name="{name}" type="revolute"><origin xyz="0.4 0 0"/><parent link="{parent}"/><child link="{child}"/>
        <axis xyz="{axis}"/><limit lower="-9" upper="9" effort="1000" velocity="1"/></joint>
        <transmission name="{name}"><joint name="{name}"/></transmission>
        <joint_stiffness joint="{name}" drive="4000" angular="2e4 2e4 2e4"/>"""

    file = tmp_path / "two.urdf"
    file.write_text(
        f"""<robot name="two">
        <link name="base">{base}</link>
        <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>{upper}</inertial></link>
        <link name="fore"><inertial><mass value="1"/>{SOUND}</inertial></link>
        {joint("a", "base", "upper", "0 1 0")}{joint("b", "upper", "fore", "0 0 1")}<platform link="fore"/></robot>"""
    )
    return ks.load_robot(file)


def pose_of(robot):
    return robot.assemble(actuators={"a": 0.0, "b": 0.9})


IMPOSSIBLE = {
    "product above the moments": (moments(0.1, xy=0.9), "-0.8, 0.1 and 1 kg·m²: none may be negative"),
    "negative": (moments(-0.1), "-0.1, 0.1 and 0.1 kg·m²: none may be negative"),
    "triangle": (moments(0.1, zz=0.3), "0.1, 0.1 and 0.3 kg·m²: none may exceed the sum of the others"),
    "a thousandth": (moments(0.1, zz=0.2005), "0.1, 0.1 and 0.2005 kg·m²"),
    "small": (moments(1e-5, yy=1e-5, zz=3e-5), "1e-05, 1e-05 and 3e-05 kg·m²"),
    "turned": (moments(0.2, xy=0.3, yy=0.2, zz=0.3), "-0.1, 0.3 and 0.5 kg·m²"),
}


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_impossible_inertias_are_refused_with_file_and_line(use, case, tmp_path):
    text, reason = IMPOSSIBLE[case]
    pose = pose_of(arm(tmp_path, text))
    with pytest.raises(ks.RobotFileError) as error:
        USES[use](pose)
    assert str(error.value).startswith(f"{tmp_path}/two.urdf:3: the <inertia> of link 'upper' is impossible: no body has ")
    assert reason in str(error.value)


def test_statics_does_not_mention_inertias_and_check_does(tmp_path):
    sound = ks.analyze(pose_of(arm(tmp_path)), load=[0, 0, -9, 0, 0, 0])
    for text, words in (
        (moments(-0.1), "modes and motions are refused"),
        ("", "has no <inertia>"),
        ('<inertia ixx="0"/>', "lacks ixy"),
    ):
        pose = pose_of(arm(tmp_path, text))
        result = ks.analyze(pose, load=[0, 0, -9, 0, 0, 0])
        assert np.array_equal(result.twist, sound.twist) and result.warnings == sound.warnings == ()
        assert [words in warning for warning in pose.robot.report().to_dict()["warnings"]] == [True]
    assert arm(tmp_path).report().to_dict()["warnings"] == []


def test_results_with_a_motion_mention_missing_inertias(tmp_path):
    pose = pose_of(arm(tmp_path, ""))
    (warning,) = ks.analyze(pose, motion=ks.Motion({"a": 1.0})).warnings
    assert (
        warning == f"{tmp_path}/two.urdf:3: <inertial> of <link> 'upper' has no <inertia>, which modes and motions take as zero."
    )


@pytest.mark.parametrize("use", USES)
def test_inertias_of_bases_do_not_matter(use, tmp_path):
    base = f'<inertial><mass value="9"/>{moments(0.1, xy=0.9)}</inertial>'
    assert np.array_equal(USES[use](pose_of(arm(tmp_path, base=base))), USES[use](pose_of(arm(tmp_path))))


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize(
    "text",
    [
        "",
        moments(0, yy=0, zz=0),
        moments(0),
        moments(0.1, zz=0.2),
        moments(0.1, zz=0.20019),
        moments(0.1234, xy=-0.1234, yy=0.1234, zz=0.2468),
        moments(0.1234, xy=-0.12345, yy=0.1234, zz=0.2468),
        moments(1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6),
    ],
)
def test_point_masses_rods_plates_and_rounded_inertias_are_accepted(use, text, tmp_path):
    assert np.all(np.isfinite(USES[use](pose_of(arm(tmp_path, text)))))


def test_rounding_to_four_digits_is_accepted():
    """Tensors of rods and plates in any direction, whose conditions are equalities."""
    rng = np.random.default_rng(0)
    for k in range(500):
        R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        one, two = rng.uniform(0.1, 1, 2)
        J = R @ np.diag((0.0, one, one) if k % 2 else (one, two, one + two)) @ R.T * 10.0 ** rng.uniform(-4, 4)
        assert not Inertia(tuple(float(f"{J[i, j]:.4g}") for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))).flaw
        small = J / J.max() * 1e-4
        assert not Inertia(tuple(round(small[i, j], 6) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))).flaw


def test_slightly_negative_moments_become_zero():
    J = np.array([[1.0, 1.0 + 1e-4, 0], [1.0 + 1e-4, 1.0, 0], [0, 0, 2.0]])
    assert np.linalg.eigvalsh(semidefinite(J))[0] == pytest.approx(0, abs=1e-15) and np.allclose(semidefinite(J), J, atol=1e-4)
    sound = np.diag([1.0, 2.0, 2.5])
    assert semidefinite(sound) is sound


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (ks.Payload(1.0, inertia=Inertia((1, 0, 0, 1, 0, 3))), "1, 1 and 3 kg·m²: none may exceed the sum of the others"),
        (ks.Payload(1.0, inertia=Inertia((-1, 0, 0, 1, 0, 1))), "none may be negative"),
        (ks.Payload(1.0, inertia=Inertia((np.nan, 0, 0, 1, 0, 1))), "not finite"),
        (ks.Payload(1.0, inertia=Inertia((1, 1, 1))), "must have 6 entries"),
        (ks.Payload(1.0, inertia=(1, 0, 0, 1, 0, 1)), "must be a kinetostatics.description.Inertia"),
        (ks.Payload(-1.0), "the payload's mass is -1.0"),
    ],
)
def test_impossible_payloads_are_refused(use, payload, words, tmp_path):
    with pytest.raises(ks.ArgumentError, match=words):
        USES[use](pose_of(arm(tmp_path)), payload=payload)
