"""Robots with springs: compiled code against NumPy, derivatives against central differences."""

from dataclasses import replace
from functools import cache

import numpy as np
import package_robots
import pytest
from tapes import assert_recorded, assert_same_results, close, solved, some_poses
from telescopes import mast

import kinetostatics as ks
from kinetostatics.description import Joint, JointStiffness, Link, Spring
from kinetostatics.engine.engine_report import engine_report


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
}


@cache
def sprung(name):
    description = package_robots.robot(name).description
    for spring in SPRINGS[name]:
        description = description.with_part(spring)
    return ks.Robot(description)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPRINGS)
def test_record_of_robots_with_springs_equals_numpy(name):
    robot = sprung(name)
    found, _ = assert_recorded(robot)
    without = solved(package_robots.robot(name), *some_poses(robot))
    twists = [item["contributions"].sum(axis=0) for item in (found, without)]
    for changed in (twists[0] - twists[1], found["compliance"] - without["compliance"]):
        assert np.max(np.abs(changed)) > 1e-6 * np.max(np.abs(without["compliance"]))


@pytest.mark.few(1)
@pytest.mark.parametrize("stiffness", [JointStiffness("hook", drive=2e3), JointStiffness("hook", angular=(1e3, np.inf, 2e3))])
def test_record_of_springs_and_elastic_open_branch_equals_numpy(stiffness):
    """A hook on the crank of a five-bar with elastic actuators, actuated too or elastic across its axis."""
    description = package_robots.soft_five_bar().description.with_part(Link("hook", mass=2.0, center_of_mass=(0.1, 0, 0.05)))
    hook = Joint("hook", "revolute", "proximal_1", "hook", axis=(0, 1, 0), lower=-1, upper=1)
    description = replace(description.with_part(hook), actuated=(*description.actuated, "hook")).with_part(stiffness)
    for name, link in (("pull", "tool"), ("balance", "hook")):
        description = description.with_part(Spring(name, 300.0, "base", link, (0.1, 0.6, 0.0), (0.1, 0.0, 0.0), free_length=0.1))
    assert_recorded(ks.Robot(description))


def test_both_engines_agree_on_springs():
    """A mast with a spring from the ground to its top: at some poses, at many, and where the spring has no length."""
    robot = ks.Robot(
        mast(names="a").description.with_part(Spring("arm", 2000.0, "ground", "end_a", (0.3, 0.1, 0.2), free_length=0.1))
    )
    for slide in (np.linspace(-0.4, 2.5, 12), np.full(700, 0.1)):
        poses = robot.assemble(actuators={"slide_a": slide})
        found, expected = (ks.analyze(poses, load=[10, 20, -30, 1, 2, 3], engine=engine) for engine in ("compiled", "numpy"))
        assert found.twist.shape == (slide.size, 6) and "solutions" not in vars(found.chunks[0])
        assert_same_results(found, expected)
        close(found.by_mechanism.contributions["spring arm"], expected.by_mechanism.contributions["spring arm"], 1e-10)
        assert found.warnings == expected.warnings
    assert engine_report(robot).is_compiled
    short = ks.Robot(mast(names="a").description.with_part(Spring("short", 100.0, "ground", "end_a", (0, 0, 0.5), preload=5.0)))
    for engine in ("numpy", "compiled"):
        with pytest.raises(ks.StaticsError, match="the spring 'short' has no length at this pose"):
            ks.analyze(short.assemble(), engine=engine)


@pytest.mark.slow
def test_jacobian_with_springs_equals_central_differences():
    """By a coordinate and by the free length of a spring."""
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
