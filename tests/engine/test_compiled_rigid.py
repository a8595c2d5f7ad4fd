"""Rigid and partly rigid limbs in compiled code; elimination against singular values and eigenvectors."""

from functools import cache

import hybrid_robots
import numpy as np
import package_robots
import pytest
import simple_machines
from places import CASES
from tapes import assert_recorded, assert_same_results, close, differences, evaluated, record_of, solved, some_poses

import kinetostatics as ks
from kinetostatics.description import JointStiffness, Spring
from kinetostatics.engine.engine_report import engine_report
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.limbs import compliance
from kinetostatics.limbs import statics as limb_statics
from kinetostatics.limbs.compliance import soft_wrenches, split_by_eigenvectors, split_rigid
from kinetostatics.statics import platform_equilibrium
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.springs import solve_with_springs as solve


@cache
def stiffened(name, beams=0, drives=True):
    """Return a robot of the package of whose beams only the first ones are left, and whose actuators are elastic, or not."""
    description = package_robots.robot(name).description
    for beam in list(description.beams)[beams:]:
        description = description.without_beam(beam)
    for joint in description.actuated if drives else ():
        description = description.with_part(JointStiffness(joint, drive=2e6))
    return ks.Robot(description)


SPRING = Spring("pull", 1e4, "base", "platform", (0.1, 0.3, -0.2), (0.05, 0.0, 0.1), free_length=0.2, preload=10.0)
#: Limbs elastic along one wrench of two, or of three in rings; all rigid; two rigid ones beside an elastic one;
#: these with a spring.
ROBOTS = {
    "drives": lambda: stiffened("3rps"),
    "rings": lambda: stiffened("delta"),
    "rigid": lambda: stiffened("3rps", drives=False),
    "one beam": lambda: stiffened("3rps", beams=1, drives=False),
    "spring": lambda: ks.Robot(stiffened("3rps", beams=1).description.with_part(SPRING)),
    "arm": lambda: simple_machines.arm(elastic=False),
}


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", ROBOTS)
def test_record_of_rigid_limbs_equals_numpy(kind):
    robot = ROBOTS[kind]()
    assert any(group.rigid_directions for group in robot.statics.groups)
    _, wanted = assert_recorded(robot)
    assert not wanted["singular"].any() and not wanted["indeterminate"].any()


def test_record_of_ring_with_stiff_self_stress_equals_numpy(monkeypatch):
    """A random network, with frames without joints, whose compliances along self-stresses differ by 10⁴."""
    mechanism = hybrid_robots.random_hybrid(202)
    robot = ks.Robot(parse_robot_text(hybrid_robots.write_randomly(mechanism, 202)[1].text))
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot), *poses)
    poses = robot.equations.place(poses[0]).frames, *poses[1:]
    wanted = solve(robot.statics, LoadedPoses(*poses))
    assert np.all(holds) and not wanted.singular.any()
    close(found["contributions"].sum(axis=0), wanted.twists.sum(axis=1))
    close(found["compliance"], wanted.compliance)
    monkeypatch.setattr(limb_statics, "_WELL_CONDITIONED", np.inf)
    careful = solve(robot.statics, LoadedPoses(*poses))
    close(wanted.twists, careful.twists)
    for mine, other in zip(wanted.statics, careful.statics, strict=True):
        close(mine.cut_wrenches, other.cut_wrenches)
        assert not mine.undetermined.any()


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", [kind for kind in ROBOTS if kind != "arm"])
def test_elimination_equals_singular_values_and_eigenvectors(kind, monkeypatch):
    robot = ROBOTS[kind]()
    x, *loads = some_poses(robot)
    poses = robot.equations.place(x).frames, *loads
    found, outputs = solve(robot.statics, LoadedPoses(*poses)), solved(robot, x, *loads)
    calls = []
    right = platform_equilibrium._RigidPart._by_singular_values
    monkeypatch.setattr(platform_equilibrium._RigidPart, "_by_singular_values", lambda *given: (calls.append(1), right(*given)))
    assert max(differences(solved(robot, x, *loads), outputs).values()) == 0 and not calls
    for module, name in ((platform_equilibrium, "_INDEPENDENT"), (compliance, "_RESIDUE")):
        monkeypatch.setattr(module, name, np.inf if name == "_INDEPENDENT" else -1.0)
    careful = solve(robot.statics, LoadedPoses(*poses))
    assert calls
    for name in ("twists", "compliance"):
        close(getattr(found, name), getattr(careful, name))
    for mine, other in zip(found.intensities, careful.intensities, strict=True):
        close(mine, other)
    np.testing.assert_array_equal(found.singular, careful.singular)


def test_split_rigid_equals_split_by_eigenvectors():
    """A compliance of rank 2 of 4, in units that differ: C give C = C, and C rigid = 0, as by eigenvectors."""
    rng = np.random.default_rng(4)
    units = np.array([1.0, 1e3, 1e-2, 10.0])
    half = rng.standard_normal((4, 2, 1, 5)) * units[:, None, None, None]
    half[:, :, 0, 3] = half[:, :1, 0, 3]  # of rank 1 there
    half[:, 1, 0, 4] *= 1e-5
    C = 1e-7 * np.einsum("ikgn,jkgn->ijgn", half, half)
    soft = soft_wrenches(C[:, :, 0, :3], 2)
    rigid_parts, gives, sure = split_rigid(C, soft)
    assert sure[0].tolist() == [True, True, True, False, False]
    first = np.moveaxis(C, (0, 1), (-2, -1))[0, :3]
    for rigid, give in ((rigid_parts[0, :3], gives[0, :3]), split_by_eigenvectors(first, 2)):
        close(first @ give @ first, first, 1e-9)
        assert rigid.shape == (3, 4, 2) and np.max(np.abs(first @ rigid)) < 1e-12 * np.max(first) * np.max(np.abs(rigid))
        assert np.linalg.matrix_rank(rigid[0] / units[:, None], 1e-6) == 2
    assert split_rigid(np.zeros((2, 2, 1, 1)), ())[2].all()


def test_engines_agree_on_elastic_drives_of_rigid_limbs():
    """In reach and out of it; the stiffness is NaN, as the limbs are rigid across their actuators."""
    robot = stiffened("3rps")
    ry = np.linspace(-1.5, 1.5, 15)
    poses = robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": ry}, on_failure="nan")
    found, wanted = (ks.analyze(poses, load=[10, 20, -300, 1, 2, 3], engine=engine) for engine in ("compiled", "numpy"))
    assert_same_results(found, wanted)
    assert len(set(wanted.status.tolist())) > 1 and np.isfinite(wanted.twist).all(axis=-1).sum() > 5
    assert engine_report(robot).is_compiled


def test_stretched_rigid_arm_falls_back_to_numpy():
    """An arm of rigid links on elastic actuators, bent and stretched: stretched, it is rigid in one more direction."""
    robot = stiffened("ur10")
    drives = robot.description.actuated
    q = np.repeat([[0.2], [-0.8], [0.9], [0.3], [0.5], [0.1]], 4, axis=1)
    q[2, 1], q[2, 2] = 0.0, 1e-7
    poses = robot.assemble(actuators=dict(zip(drives, q, strict=True)))
    found, wanted = (ks.analyze(poses, load=[10, 20, -300, 1, 2, 3], engine=engine) for engine in ("compiled", "numpy"))
    assert wanted.solutions[0].statics[0].may_stiffen[0, 0] == False  # noqa: E712
    assert len(wanted.solutions) > 1  # the stretched one by itself
    np.testing.assert_array_equal(found.status, wanted.status)
    close(found.twist, wanted.twist, 1e-10)
    close(found.compliance, wanted.compliance, 1e-10)
    f = ks.compile(robot, engine="compiled")
    values = f(**dict(zip(drives, q, strict=True)), load=[10, 20, -300, 1, 2, 3])
    close(values["twist"], wanted.twist, 1e-10)


def test_jacobian_with_elastic_drives_equals_central_differences():
    robot = stiffened("3rps")
    at = {"z": 0.52, "rx": 0.1, "ry": -0.15}
    f = ks.compile(robot, at, outputs=("twist", "actuator_forces"), engine="numpy")
    rates = f.jacobian(("twist", "actuator_forces"), ("ry", "load"))(**at)
    step = 1e-4
    before, after = (f(**{**at, "ry": at["ry"] + by}) for by in (-step, step))
    unit = f(**at, load=[0, 0, 1, 0, 0, 0])
    for output, derivatives in rates.items():
        wanted = (after[output] - before[output]) / (2 * step)
        np.testing.assert_allclose(derivatives["ry"], wanted, rtol=0, atol=1e-6 * np.max(np.abs(wanted)))
        wanted = unit[output] - f(**at)[output]
        np.testing.assert_allclose(derivatives["load"][:, 2], wanted, rtol=0, atol=1e-8 * np.max(np.abs(wanted)))


def test_overconstrained_rigid_limbs_are_left_to_numpy():
    robot = ks.load_robot(CASES / "two_rigid.urdf")
    report = engine_report(robot)
    assert not report.is_compiled and report.reason.startswith("rigid limbs or rings overconstrain one another")
    pose = robot.assemble()
    found, wanted = (ks.analyze(pose, engine=engine) for engine in ("compiled", "numpy"))
    assert found.status == wanted.status == ks.Status.INDETERMINATE
    np.testing.assert_array_equal(found.twist, wanted.twist)
