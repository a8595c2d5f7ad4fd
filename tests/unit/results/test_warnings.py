"""Warnings: one list for robot and results; masses, rigid bearings, nearly singular poses, buckling, indeterminate forces."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import package_robots
import pytest
from odd_robots import beyond_limits
from places import TESTS
from simple_machines import arm, joint, link, robot, springs, truss
from swinging_plate import STEEL, Y, parallelogram

import kinetostatics as ks
from kinetostatics.checks import check
from kinetostatics.cli.main import main
from kinetostatics.description import Beam, Joint, JointStiffness, Link, Loop, Origin, RobotDescription
from kinetostatics.results import warnings
from kinetostatics.results.warnings import (
    LEAST_CONSTRAINT,
    NearSingularity,
    _bases,
    _joint_forces,
    _large_motions,
    _motions,
    _open_loops,
    are_regular,
    generic_forces,
    indeterminate_parts,
    near_singularity,
)
from kinetostatics.sections import Tube
from kinetostatics.viewer.scene import describe_scene

RIGID = "bearings and actuators count as rigid"
SHAPE = '<visual><geometry><sphere radius="0.1"/></geometry></visual>'


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def warnings_of(description):
    return check.diagnose(ks.Robot(description)).warnings


# ---- bearings --------------------------------------------------------------------------------------------------------


def test_check_states_the_assumption_of_rigid_bearings():
    plain = parallelogram()
    assert RIGID in str(ks.Robot(plain)) and warnings_of(plain) == []
    assert RIGID not in str(ks.Robot(plain.with_part(JointStiffness("a", drive=1e5))))


def test_rigid_limbs_beside_elastic_ones_are_named():
    """A planar joint between base and platform takes the sag across its plane; with a stiffness there is a number again."""
    bare = package_robots.robot("planar_3rrr").description
    guided = bare.with_part(Loop("guide", "planar", "base", "platform", axis=(0, 0, 1)))
    elastic = guided.with_part(JointStiffness("guide", linear=(0, 0, 1e7), angular=(1e6, 1e6, 0)))
    results = [ks.analyze(ks.Robot(item).assemble(), load=[0, 0, -5, 0, 0, 0]) for item in (bare, guided, elastic)]
    assert [result.warnings for result in results] == [
        (),
        (
            "limb_4 (guide) has no elastic part and counts as rigid: it holds the platform by force along limb axis at guide, "
            "couple along limb x and couple along limb y without sag there; for a number, give a joint a <joint_stiffness> "
            "or a link a <beam>",
        ),
        (),
    ]
    free, none, soft = (float(result.twist[2]) for result in results)
    K = results[0].stiffness[2, 2]
    assert none == 0 and soft == pytest.approx(free * K / (K + 1e7), rel=1e-9) and soft > free
    every = robot(
        link("base"),
        link("platform", 1.0),
        joint("slide", "prismatic", "base", "platform"),
        '<transmission name="t"><joint name="slide"/></transmission>',
    )
    assert "limb_1 has no elastic parts and counts as rigid" in every.warnings


def test_check_warns_of_robots_held_by_springs_alone():
    words = "the robot has no actuators: springs alone hold its platform; mark actuated joints by <transmission>"
    held = [springs(name, angular="50 50 50") for name in ("shoulder", "elbow")]
    assert words in arm(*held, actuated=False).warnings
    assert words not in arm(*held).warnings and words not in truss().warnings
    assert any("'r' has no actuators, so that its platform can move" in text for text in arm(actuated=False).warnings)


def test_welded_frame_needs_no_bearing_assumption():
    welded = RobotDescription.of(
        "mast",
        links=[Link("ground"), Link("mast"), Link("top", 2.0)],
        joints=[Joint("foot", "fixed", "ground", "mast"), Joint("head", "fixed", "mast", "top", Origin((0, 0, 1.0)))],
        platform="top",
        beams=[Beam("mast", Tube.of(0.05), STEEL)],
    )
    assert RIGID not in str(ks.Robot(welded))


# ---- masses ----------------------------------------------------------------------------------------------------------


def test_platform_without_mass_causes_one_warning():
    text = "the platform has no mass: give its link an <inertial>"
    assert text not in warnings_of(parallelogram()) and text in warnings_of(parallelogram(plate=0.0))
    meant = parallelogram(plate=0.0)
    meant = meant.with_part(replace(meant.links["plate"], has_inertial=True))
    assert text not in warnings_of(meant)
    assert text not in warnings_of(parallelogram(plate=0.0).with_payload("tool", "plate", 1.0))
    drawn = parallelogram(plate=0.0).changed("plate", extra=SHAPE)
    assert sum("mass" in warning for warning in warnings_of(drawn)) == 1  # one warning only


def test_limbs_without_mass_cause_a_warning():
    bare = parallelogram().without_beam("right")
    assert "limb_2 weighs nothing: its links have no <inertial>" in warnings_of(bare)
    both = bare.without_beam("left")
    assert "limb_1 and limb_2 weigh nothing: their links have no <inertial>" in warnings_of(both)
    assert not any("no <inertial>" in text for text in warnings_of(bare.changed("right", mass=1.0)))
    assert not any("no <inertial>" in text for text in warnings_of(bare.changed("right", has_inertial=True)))
    drawn = warnings_of(both.changed("left", extra=SHAPE))
    assert sum("no <inertial>" in text or "a shape" in text for text in drawn) == 1
    nothing = warnings_of(parallelogram(plate=0.0).without_beam("right").without_beam("left"))
    assert "nothing in the file has a mass" in nothing and not any("<inertial>" in text for text in nothing)


def test_drawn_links_without_mass_cause_a_warning():
    """A motor on a beam's joint has a shape only; no warning where it is welded to a mass, or given the mass 0."""
    text = "motor has a shape but no mass: add an <inertial>, with the mass 0 if it is massless"
    plain = parallelogram()

    def slid(motor):
        """The left rod stands on a slider that is drawn."""
        moved = plain.with_part(motor).with_part(Joint("s", "prismatic", "ground", "motor", axis=(1.0, 0, 0), lower=-1, upper=1))
        return replace(moved.with_part(replace(moved.joints["a"], parent="motor")), actuated=("a", "s"))

    assert text in warnings_of(slid(Link("motor", extra=SHAPE)))
    assert text in warnings_of(slid(Link("motor", extra=SHAPE.replace("visual", "collision"))))
    for motor in (Link("motor"), Link("motor", 2.0, extra=SHAPE), Link("motor", extra=SHAPE, has_inertial=True)):
        assert text not in warnings_of(slid(motor))
    welded = slid(Link("motor", extra=SHAPE)).with_payload("rotor", "motor", 1.0)
    assert text not in warnings_of(welded)
    two = slid(Link("motor", extra=SHAPE)).with_part(Link("flag", extra=SHAPE)).with_part(Joint("f", "fixed", "motor", "flag"))
    assert any(warning.startswith("motor and flag have shapes but no mass") for warning in warnings_of(two))


def test_shipped_robots_cause_no_false_warnings():
    texts = [(Path("tests/golden") / f"{name}.txt").read_text(encoding="utf-8") for name in ks.robots()]
    assert len(texts) == 16
    for text in texts:
        warned = text[text.index("\nWarnings") :]
        assert "mass" not in warned and "weigh" not in warned and "singular" not in warned


# ---- nearly singular poses -------------------------------------------------------------------------------------------


def gough_at(degrees):
    """The hexapod turned about the vertical: at a quarter turn it is singular (Fichter, 1986)."""
    robot = package_robots.robot("gough_stewart")
    z = float(robot.assemble().platform["z"])
    return ks.analyze(robot.assemble(platform={"x": 0, "y": 0, "z": z, "rx": 0, "ry": 0, "rz": np.radians(degrees)}))


def test_constraint_index_is_smallest_singular_value_of_leg_lines():
    """Each leg can only push and pull along itself; moments are divided by the robot's length. All poses in one batch."""
    result = gough_at(np.array([0, 40, 88.5]))
    indices = near_singularity(result).constraint_index
    for k in range(3):
        o, rods = result.configuration.platform_frame[k, :3, 3], [b for name, b in result.beams.items() if name.startswith("rod")]
        lines = np.array(
            [[*b.axes[k, :, 0], *np.cross(b.points[k, -1] - o, b.axes[k, :, 0]) / result.robot.length] for b in rods]
        )
        lines /= np.linalg.norm(lines, axis=1)[:, None]
        assert indices[k] == pytest.approx(np.linalg.svd(lines, compute_uv=False)[-1], rel=1e-9)


def test_nearly_singular_poses_cause_a_warning():
    """The index falls with the angle to the quarter turn; the warning begins where it is 1/50."""
    low, high = 85.0, 89.0
    for _ in range(2):  # the index is nearly linear in the angle
        (a, b), span = near_singularity(gough_at(np.array([low, high]))).constraint_index, high - low
        limit = low + span * (a - LEAST_CONSTRAINT) / (a - b)
        low, high = limit - span / 1e3, limit + span / 1e3
    before, after = gough_at(low), gough_at(high)
    assert near_singularity(before).constraint_index[0] == pytest.approx(LEAST_CONSTRAINT, rel=1e-4)
    assert not any("singular" in text for text in before.warnings) and after.status == before.status
    (text,) = [text for text in after.warnings if "singular" in text]
    motion = "a rotation about the axis (0, 0, 1) through o + (0, 0, 0) m with a pitch of -0.066"
    assert text.startswith(f"the pose is nearly singular: the platform is almost free in {motion}")
    assert text.endswith("; a load along this motion causes limb wrenches of about 50 times its size")
    value = text.split(" N·m/rad)")[0].rsplit(" (", 1)[1]
    assert float(value) == pytest.approx(1 / after.compliance[5, 5], rel=0.01)  # of a moment about the vertical alone


def test_nearly_singular_poses_of_a_batch_are_counted():
    (text,) = [text for text in gough_at(np.array([0.0, 60.0, 88.5, 89.5])).warnings if "singular" in text]
    assert text.startswith("2 of 4 poses are nearly singular, at the worst: the platform is almost free in a rotation about")
    drives = {"prismatic_1": [50.0], "prismatic_2": 0.0, "prismatic_3": 0.0}
    lost = ks.analyze(package_robots.robot("3rps").assemble(actuators=drives))
    for none in (lost, gough_at(np.zeros(0))):
        assert not np.any(near_singularity(none).where) and not any("singular" in text for text in none.warnings)


def test_check_reports_a_nearly_singular_zero_pose():
    """Rods that lie nearly along the plate let it turn about the left rod's end."""
    for lean, near in ((0.0, False), (1.45, False), (1.56, True)):
        found = [text for text in warnings_of(parallelogram(lean)) if "nearly singular" in text]
        assert bool(found) == near, found
    assert found[0].startswith("the zero pose is nearly singular: the platform is almost free in a rotation about")


def test_rigid_robots_get_singularity_warnings_without_stiffness():
    rigid = parallelogram(1.56).without_beam("left").without_beam("right")
    robot = ks.Robot(rigid.changed("left", mass=1.0).changed("right", mass=1.0))
    (text,) = [text for text in ks.analyze(robot.assemble()).warnings if "singular" in text]
    assert "N·m/rad" not in text and "N/m" not in text


def tilting(lean):
    """The parallelogram carries an actuated hinge with the platform: one limb, a network, which always holds all six motions."""
    base = parallelogram(0.0)
    carried = base.with_part(Link("top", 1.0)).with_part(
        Joint("t", "revolute", "plate", "top", Origin((0.2, 0, 0)), axis=Y, lower=-1, upper=1)
    )
    robot = ks.Robot(replace(carried, platform="top", platform_origin=Origin(), actuated=("a", "t")))
    return ks.analyze(robot.assemble(actuators={"a": lean, "t": 0.0}))


def test_joint_forces_of_networks_are_compared_with_those_near_the_zero_pose():
    upright = near_singularity(tilting(0.0))
    assert upright.constraint_index == pytest.approx([1.0], rel=1e-9)
    assert upright.force_amplification == pytest.approx([1.0], abs=0.1)
    (text,) = [text for text in tilting(1.565).warnings if "singular" in text]
    assert "almost free in a rotation about the axis (0, 1, 0)" in text and text.endswith("as large as near the zero pose")


@pytest.mark.slow
def test_nearly_singular_networks_cause_a_warning():
    """The rods' forces under a moment grow with the inverse of the sine of the angle between rods and plate."""
    angles = np.array([1.50, 1.54, 1.565])
    gains = np.array([near_singularity(tilting(angle)).force_amplification[0] for angle in angles])
    np.testing.assert_allclose(gains * np.cos(angles), gains[-1] * np.cos(angles[-1]), rtol=0.02)
    for angle, value in zip(angles, gains, strict=True):
        found = [text for text in tilting(angle).warnings if "singular" in text]
        assert bool(found) == (value > 1 / LEAST_CONSTRAINT), (angle, value, found)
        assert not found or "times as large as near the zero pose" in found[0]
    assert gains[0] < 1 / LEAST_CONSTRAINT < gains[-1]


def warned(residual=0.0, twist=(0.0,) * 6, length=2.0):
    return SimpleNamespace(
        configuration=SimpleNamespace(residual=np.array(residual)), twist=np.array(twist), robot=SimpleNamespace(length=length)
    )


def test_open_loops_and_large_motions_cause_warnings():
    assert _open_loops(warned(0.9e-9)) == [] and _open_loops(warned([0, np.nan])) == []
    assert "open by up to 1.1e-09" in _open_loops(warned([1.1e-9, 0]))[0]
    assert _large_motions(warned(twist=[0.11, 0.16, 0, 0.09, 0, 0])) == []
    assert "moves by 0.21 m" in _large_motions(warned(twist=[0.21, 0, 0, 0, 0, 0]))[0]
    assert "0.11 rad" in _large_motions(warned(twist=[0, 0, 0, 0, 0.11, 0]))[0]


def test_motions_with_equal_stiffness_are_named_together():
    """Up to a millionth; a plane of motions has no directions of its own."""
    vectors = np.eye(6)
    vectors[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
    for apart, words in ((5e-7, "x and a displacement"), (2e-6, "")):
        text = _motions(np.array([3.0, 3.0 * (1 + apart), 4, 5, 6, 7]), vectors, 0, np.repeat([1.0, 2.0], 3))
        assert text.count(" and ") == bool(words), text


def test_warning_states_the_change_of_second_order():
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.2})
    result = ks.analyze(pose, [3e5, 0, -8e5, 0, 0, 0])
    (text,) = [text for text in result.warnings if "the forces change the stiffness" in text]
    assert f" by {100 * float(result.second_order.change):+.2g} %" in text and result.second_order.change < -0.01


@pytest.mark.parametrize("name", ["planar_3rrr", "five_bar", "3rps", "delta"])
def test_definite_matrices_tell_nearly_singular_poses_as_eigenvalues_do(name):
    """At random poses, some of them nearly singular; in the Delta by the forces of its networks, with small limits."""
    rng, robot = np.random.default_rng(0), package_robots.robot(name)
    zero, count = robot.assemble(), 60 if name == "delta" else 300
    names = {"3rps": "z rx ry", "delta": "x y z", "five_bar": "x rz", "planar_3rrr": "x y rz"}[name].split()
    spans = {c: 0.9 * robot.length if c in "xyz" else 1.2 for c in names}
    at = {c: float(zero.platform[c]) + span * rng.uniform(-1, 1, count) for c, span in spans.items()}
    result = ks.analyze(robot.assemble(platform=at, on_failure="nan"))
    singularity = near_singularity(result)
    valid = np.isfinite(singularity.constraint_index)
    regular = np.concatenate([are_regular(robot, solution, generic_forces(robot)) for solution in result.solutions])
    np.testing.assert_array_equal(regular[valid], ~singularity.where[valid])
    assert singularity.where[valid].any() or name == "delta"


# ---- buckling, indeterminate forces and measures, of parts made by hand ----------------------------------------------


@pytest.mark.parametrize(("ratio", "words"), [(0.049, ""), (0.051, "linear theory"), (0.999, "linear theory"), (1, "no result")])
def test_buckling_warnings_begin_at_a_twentieth_of_the_load(ratio, words, monkeypatch):
    """Beams with equal ratios to their buckling loads share a warning."""
    monkeypatch.setattr(warnings, "_changed_stiffness", lambda result: "")
    chunks = [{"a": [0.2, 1.5], "b": [0.2], "c": [0.01], "d": [np.nan]}, {"a": [], "b": [1.5], "c": [ratio], "d": [0.0]}]
    members = SimpleNamespace(ratios=lambda chunk, least: {name: np.array(values) for name, values in chunk.items()})
    robot = SimpleNamespace(beams=dict.fromkeys("abcd"), members=members)
    both, *one = warnings._buckling(SimpleNamespace(robot=robot, solutions=chunks))
    assert both == "the forces are 150 % of the buckling load of beams a, b: no result applies"
    assert len(one) == bool(words) and all("beam c" in text and words in text for text in one)


@pytest.mark.parametrize(("part", "joints"), [(0.9e-9, "a, c"), (1.1e-9, "a, b, c"), (-1.1e-9, "a, b, c")])
def test_joints_loaded_only_by_rounding_have_no_self_stress(part, joints):
    """Two cut joints that carry opposite forces of 2 N but for ``part`` of them: b carries their sum, a and c one each."""
    self_stress = np.zeros((2, 6, 1, 1, 1))
    self_stress[0, 0], self_stress[1, 0] = 2.0, -2.0 * (1 + part)
    edges = [
        SimpleNamespace(joint=name, cut_joints=signs)
        for name, signs in (("a", ((0, 1),)), ("b", ((0, 1), (1, 1))), (None, ((0, 1),)), ("c", ((1, -1),)), ("d", ((0, 0),)))
    ]
    item = SimpleNamespace(group=SimpleNamespace(limbs=[SimpleNamespace(name="limb_1", edges=edges)]), undetermined=self_stress)
    undetermined = np.zeros((2, 1, 1), dtype=bool)
    found = SimpleNamespace(solutions=[SimpleNamespace(statics=[item], undetermined=[undetermined])])
    rest = "their forces are statically indeterminate, returned as NaN"
    assert indeterminate_parts(found) == f"the rigid rings in limb_1 ({joints}) are overconstrained in themselves: {rest}"
    undetermined[1] = True
    assert indeterminate_parts(found).startswith("the rigid limbs limb_1 overconstrain one another and the rigid rings in limb_1")
    self_stress[:] = 0
    undetermined[:] = False
    assert indeterminate_parts(found) == f"rigid parts are overconstrained: {rest}"


def network(**changes):
    """Two chords that share a force along x and a moment about z of 2 m · N: 3 and 4 times the force, and large moments."""
    J_c, cut_wrenches = np.zeros((6, 2, 1, 1)), np.zeros((2, 6, 2, 1, 1))
    J_c[0, 0], J_c[5, 1] = 1.0, 2.0
    cut_wrenches[0, 0, 0], cut_wrenches[1, 1, 0], cut_wrenches[:, 3:] = 3.0, 4.0, 1e3
    return SimpleNamespace(J_c=J_c, cut_wrenches=cut_wrenches, **changes)


def test_joint_forces_of_a_network_exclude_moments():
    sizes, wrenches = _joint_forces(network(), 2.0)
    assert sizes == pytest.approx(5.0, rel=1e-12)
    np.testing.assert_allclose(np.abs(wrenches[0, 0]), [1, 0, 0, 0, 0, 0], atol=1e-12)


def test_moments_are_scaled_by_the_characteristic_length():
    Q, R = _bases(network(), 4.0)
    np.testing.assert_allclose(np.abs(R[0, 0]), [[1, 0], [0, 0.5]], atol=1e-15)
    np.testing.assert_allclose(np.abs(Q[0, 0]), np.eye(6)[:, [0, 5]], atol=1e-15)


def test_thresholds_and_worst_pose_of_near_singularity():
    found = NearSingularity(np.array([0.021, 0.019, 1.0, 1.0, np.nan]), np.array([0.0, 0, 49, 51, np.nan]))
    assert found.where.tolist() == [False, True, False, True, False]
    assert NearSingularity(np.array([0.5, 0.1, 0.3]), np.array([1.0, 2, 11])).worst == 2
    assert NearSingularity(np.array([0.5, 0.05, 0.3]), np.array([1.0, 2, 11])).worst == 1


@pytest.mark.parametrize("name", ["3rps", "2pru_upr", "delta"])
def test_joint_dependence_is_not_doubtful_at_ordinary_poses(name):
    """Doubtful poses are decided one by one, which is slow."""
    found = ks.analyze(package_robots.robot(name).assemble())
    assert not any(item.doubtful.any() for item in found.solutions[0].statics)


# ---- one list, computed only on request ------------------------------------------------------------------------------


CASE = TESTS / "cases" / "wrong_motor_axis.urdf.xacro"
WORDS = "3 actuators for 0 freedoms"


def told(text):
    """Return a text without its line ends and signs of warnings."""
    return " ".join(text.replace("! ", " ").split())


def test_warnings_of_check_are_in_every_result():
    robot = ks.load_robot(CASE)
    result, batch = ks.analyze(robot.assemble()), ks.analyze(robot.configuration([robot.assemble().q] * 2))
    (warning,) = robot.warnings
    assert WORDS in warning
    assert check.diagnose(robot).warnings[0] == warning
    assert result.warnings[0] == result.to_dict()["warnings"][0] == batch.warnings[0] == warning
    assert warning in describe_scene(result).plain()["notes"]
    for text in (str(robot), str(result), str(batch)):  # a report page has the first two as chapters
        assert told(text).count(WORDS) == 1
    assert told(str(result)).endswith(f"Warnings {warning}")


def test_command_prints_warnings_once_in_the_result(capsys):
    assert main(["analyze", "3rps", "--set", "rod_diameter=80"]) == 0
    out, err = capsys.readouterr()
    warning = "beams rod_1, rod_2 and rod_3: thicker (80.00 m) than long (550.0 mm); sizes are in m"
    assert told(out).partition(" Warnings ")[2].count(warning) == 1
    assert "thicker" not in err


def test_warnings_are_computed_only_when_read(monkeypatch):
    monkeypatch.setattr(check, "diagnose", lambda robot: pytest.fail("asked for before anybody reads it"))
    result = ks.analyze(ks.load_robot("3rps").assemble())
    assert result.twist.shape == (6,) and result.beams and result.status == ks.Status.OK


def test_zero_pose_warnings_are_not_repeated_at_other_poses():
    robot = beyond_limits()
    (warning,) = check.diagnose(robot).warnings
    assert warning == "at the zero pose foot (0°) is beyond its limits" and robot.warnings == ()
    assert ks.analyze(robot.assemble(actuators={"foot": 0.3})).warnings == ()
    (warning,) = ks.analyze(robot.assemble()).warnings
    assert warning.startswith("foot is beyond its limits of ") and warning.endswith("°: 0°")
