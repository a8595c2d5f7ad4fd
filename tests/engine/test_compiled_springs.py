"""Robots with springs by compiled code: what is recorded is what NumPy computes, and functions and derivatives follow."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import package_robots
import pytest
import tapes
from tapes import computed, differences, evaluated, record_of, solved, some_poses

import kinetostatics as ks
from kinetostatics.description import Joint, JointStiffness, Link, Spring
from kinetostatics.engine.engine_report import engine_report
from kinetostatics.engine.pose_code import ANALYSIS, PoseCode
from kinetostatics.math.linalg import solve_by_elimination

close = partial(tapes.close, tolerance=1e-10)


def corner(angle):
    return 0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.0


#: The springs under the platform of the page on balancing, and springs between any two links: within and between limbs.
SPRINGS = {
    "3rps": [
        Spring(f"spring_{k}", 500.0, "base", "platform", corner(angle), corner(angle), free_length=0.95)
        for k, angle in enumerate(np.radians([0, -120, 120]))
    ],
    "2pru_upr": [
        Spring("pull", 1e5, "base", "slider_1", (0.01, 0, 0.02), (0, 0.03, 0), free_length=0.1, preload=5.0),
        Spring("between", 2e5, "slider_1", "slider_2", (0.1, 0.0, 0.0), (0.0, 0.0, 0.1), free_length=0.3),
        Spring("up", 3e5, "slider_1", "platform", free_length=0.2),
    ],
    "linear_delta": [Spring("arm", 2000.0, "base", "platform", (0.3, 0.1, 0.2), (0, 0, 0.05))],
}


@cache
def sprung(name):
    description = package_robots.robot(name).description
    for spring in SPRINGS[name]:
        description = description.with_part(spring)
    return ks.Robot(description)


@pytest.mark.parametrize("name", ["2pru_upr", pytest.param("3rps", marks=pytest.mark.slow)])
def test_what_is_recorded_of_springs_is_what_numpy_computes(name):
    robot = sprung(name)
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot), *poses)
    wanted, without = solved(robot, *poses), solved(package_robots.robot(name), *poses)
    assert np.all(holds)
    worst = differences(found, wanted)
    assert max(worst.values()) < 1e-11, max(worst, key=worst.get)
    twists = [item["contributions"].sum(axis=0) for item in (found, without)]
    for changed in (twists[0] - twists[1], found["compliance"] - without["compliance"]):
        assert np.max(np.abs(changed)) > 1e-6 * np.max(np.abs(without["compliance"]))


@pytest.mark.parametrize("stiffness", [JointStiffness("hook", drive=2e3), JointStiffness("hook", angular=(1e3, np.inf, 2e3))])
def test_elastic_actuators_and_elastic_joints_of_open_branches_are_recorded_with_springs(stiffness):
    """A hook on the crank of a five-bar with elastic actuators, driven too or elastic across its axis."""
    description = package_robots.soft_five_bar().description.with_part(Link("hook", mass=2.0, center_of_mass=(0.1, 0, 0.05)))
    hook = Joint("hook", "revolute", "proximal_1", "hook", axis=(0, 1, 0), lower=-1, upper=1)
    description = replace(description.with_part(hook), driven=(*description.driven, "hook")).with_part(stiffness)
    for name, link in (("pull", "tool"), ("balance", "hook")):
        description = description.with_part(Spring(name, 300.0, "base", link, (0.1, 0.6, 0.0), (0.1, 0.0, 0.0), free_length=0.1))
    robot = ks.Robot(description)
    poses = some_poses(robot)
    found, holds = evaluated(robot, record_of(robot), *poses)
    assert np.all(holds) and max(differences(found, solved(robot, *poses)).values()) < 1e-11


def test_both_engines_say_the_same_of_springs():
    """Twist, stiffness, forces of actuators, joints and springs, at poses in reach and out of it."""
    robot = sprung("linear_delta")
    x = np.append([-0.6, -0.5, -0.4], np.linspace(-0.02, 0.1, 21))
    poses = robot.assemble(platform={"x": x, "y": 0.1, "z": float(robot.assemble().platform["z"])}, on_failure="nan")
    found, wanted = (ks.analyze(poses, load=[10, 20, -30, 1, 2, 3], engine=engine) for engine in ("compiled", "numpy"))
    np.testing.assert_array_equal(found.status, wanted.status)
    assert 2 in wanted.status and (wanted.status < 2).sum() > 3
    for name in ("twist", "stiffness", "base_wrench", "strain_energy"):
        close(getattr(found, name), getattr(wanted, name))
    for name in ("contributions", "actuator_forces", "joint_wrenches", "spring_forces"):
        mine, other = getattr(found, name), getattr(wanted, name)
        assert list(mine) == list(other)
        close(np.stack([mine[key] for key in other]), np.stack([other[key] for key in other]))
    report = engine_report(robot)
    assert report.is_compiled and report.operations > 1000
    # of many poses most is computed when it is asked for, and the springs too
    many = robot.configuration(np.repeat(robot.assemble().q[None], 700, axis=0))
    found, wanted = (ks.analyze(many, engine=engine) for engine in ("compiled", "numpy"))
    assert found.twist.shape == (700, 6) and "solutions" not in vars(found.chunks[0])
    close(found.spring_forces["arm"], wanted.spring_forces["arm"])
    close(found.by_mechanism.contributions["spring arm"], wanted.by_mechanism.contributions["spring arm"])
    assert found.warnings == wanted.warnings


def test_where_a_limb_of_a_sprung_robot_is_special_numpy_computes():
    """A limb whose canonical wrenches degenerate, and one whose passive joints become dependent."""
    robot = sprung("linear_delta")
    q = np.repeat(robot.assemble().model_q, 3, axis=1)
    q[1, 1] += np.pi / 2
    q[7, 2] += np.pi / 2
    given = robot.equations.from_model(q), np.ones((6, 3)), np.ones((3, 3))
    wanted = solved(robot, *given)
    _, holds = computed(PoseCode(robot, robot.statics, ANALYSIS), *given)
    assert holds.tolist() == [True, False, False] and wanted["basis_degenerate"][1] and wanted["doubtful"][2]
    one, two = (
        ks.analyze(robot.configuration(q.T, closure_tolerance=np.inf), engine=engine, on_failure="nan")
        for engine in ("compiled", "numpy")
    )
    np.testing.assert_array_equal(one.status, two.status)
    close(one.twist[:2], two.twist[:2])  # the third is singular
    close(one.limbs["limb_1"].intensities, two.limbs["limb_1"].intensities)


def test_functions_and_derivatives_of_sprung_robots():
    """The free length of a spring is a parameter; derivatives are those of central differences."""
    robot = sprung("3rps")
    at = {"z": 0.52, "rx": 0.1, "ry": -0.15}
    f = ks.compile(robot, at, outputs=("twist", "contributions", "actuator_forces"), engine="numpy")
    assert next(iter(f.outputs["contributions"].axes.values()))[-3:] == ("spring spring_0", "spring spring_1", "spring spring_2")
    rates = f.jacobian(("twist", "actuator_forces"), ("z", "gravity", "spring_1.free_length"))(**at)
    for name, step in (("z", 1e-4), ("spring_1.free_length", 1e-3)):

        def moved(by, name=name):
            if name == "z":
                return f(**{**at, "z": at["z"] + by})
            spring, number = name.split(".")
            own = robot.description.springs[spring]
            other = ks.Robot(robot.description.changed(spring, **{number: getattr(own, number) + by}))
            return ks.compile(other, at, outputs=("twist", "actuator_forces"), engine="numpy")(**at)

        before, after = moved(-step), moved(step)
        for output, derivatives in rates.items():
            wanted = (after[output] - before[output]) / (2 * step)
            np.testing.assert_allclose(derivatives[name], wanted, rtol=0, atol=2e-6 * np.max(np.abs(wanted)))
    assert rates["twist"]["gravity"].shape == (6, 3)


def test_a_spring_without_length_is_told_by_both_engines():
    """At the zero pose its ends fall together; beside it they do not."""
    bare = package_robots.robot("five_bar")
    place = bare.assemble().frame("tool")[:3, 3]
    robot = ks.Robot(bare.description.with_part(Spring("short", 100.0, "base", "tool", tuple(place), preload=5.0)))
    for engine in ("numpy", "compiled"):
        with pytest.raises(ks.StaticsError, match="the spring 'short' has no length at this pose"):
            ks.analyze(robot.assemble(), engine=engine)


def test_elimination_solves_what_has_pivots_and_leaves_the_rest_to_lapack():
    rng = np.random.default_rng(2)
    a, b = rng.standard_normal((5, 5, 40)) + 4 * np.eye(5)[:, :, None], rng.standard_normal((5, 3, 40))
    a[0, 0, 7], a[:2, :2, 9] = 0.0, 1.0  # no pivot at once, and none then
    found = solve_by_elimination(a, b)
    np.testing.assert_allclose(np.einsum("ijn,jkn->ikn", a, found), b, rtol=0, atol=1e-11)
