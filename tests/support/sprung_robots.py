"""Random robots with springs: those of the package and serial ones, rigid or elastic, with stiff drives."""

from dataclasses import replace

import hybrid_robots
import numpy as np
import package_robots
import pinocchio as pin
import small_robots as sr

import kinetostatics as ks
from kinetostatics.description import JointStiffness, Spring
from kinetostatics.statics.link_loads import _joint_around


def may_be_loaded(configuration):
    """Return the links on which a force may act."""
    robot = configuration.robot
    elastic = {beam.link for beam in robot.description.beams.values()}
    return [link for link in robot.description.links if link not in elastic and not _joint_around(robot.statics, link)]


def with_stiff_drives(description, rng, times=1.0):
    """Return a robot whose actuators have random stiffnesses, of 1e5 to 1e7 N/m or 1e4 to 1e6 N·m/rad."""
    for name in description.actuated:
        turns = (description.joints.get(name) or description.loops[name]).type != "prismatic"
        description = description.with_part(
            JointStiffness(name, drive=times * float(10 ** (rng.uniform(4, 6) if turns else rng.uniform(5, 7))))
        )
    return description


def with_random_springs(description, rng, links, count, size=0.1):
    """Return a robot with springs between two of some links, every second one from the base."""
    for k in range(count):
        a, b = rng.choice(len(links), 2, replace=False)
        spring = Spring(
            f"spring_{k}", float(10 ** rng.uniform(2, 4)), links[a], links[b],
            tuple(map(float, size * rng.normal(size=3))), tuple(map(float, size * rng.normal(size=3))),
            free_length=float(rng.choice([0.0, 0.3 * rng.random()])), preload=float(rng.choice([0.0, 50 * rng.normal()])),
        )  # fmt: skip
        description = description.with_part(spring)
    return description


def _stiffer(material, times):
    modulus = material.shear_modulus
    return replace(
        material, youngs_modulus=times * material.youngs_modulus, shear_modulus=None if modulus is None else times * modulus
    )


def bundled(name, seed, springs=None, rigid=True, stiffer=1.0):
    """Return a pose of a robot of the package with stiff drives, without its beams, with one to three springs.

    With ``stiffer`` beams and drives are that many times as stiff.
    """
    rng = np.random.default_rng(seed)
    one = package_robots.robot(name)
    beams = {key: replace(beam, material=_stiffer(beam.material, stiffer)) for key, beam in one.description.beams.items()}
    description = with_stiff_drives(replace(one.description, beams={} if rigid else beams, joint_stiffness={}), rng, stiffer)
    poses = one.model_q(one.generic_poses)
    q = poses[:, int(rng.integers(poses.shape[1]))]
    at = ks.Robot(description).configuration(q, closure_tolerance=1e-9)
    count = int(rng.integers(1, 4)) if springs is None else springs
    return ks.Robot(with_random_springs(description, rng, may_be_loaded(at), count)).configuration(q, closure_tolerance=1e-9)


def serial(kinds, seed, springs=None, rigid=True):
    """Return a robot of :func:`small_robots.random_spec` at its zero pose, the same way."""
    rng = np.random.default_rng(seed)
    spec = sr.random_spec(kinds, seed)
    if rigid:
        spec = replace(spec, beams=())
    file = sr.write_randomly(spec, rng, seed)
    description = with_stiff_drives(file.description(), rng)
    robot = ks.Robot(description)
    at = robot.configuration(pin.neutral(robot.model))
    count = int(rng.integers(1, 4)) if springs is None else springs
    robot = ks.Robot(with_random_springs(description, rng, may_be_loaded(at), count))
    return robot.configuration(pin.neutral(robot.model))


def hybrid(seed, springs=3):
    """Return a robot of :func:`hybrid_robots.random_hybrid` at its zero pose, with springs."""
    _, file = hybrid_robots.write_randomly(hybrid_robots.random_hybrid(seed), seed)
    robot = file.robot()
    at = robot.configuration(pin.neutral(robot.model))
    description = with_random_springs(robot.description, np.random.default_rng(seed), may_be_loaded(at), springs)
    return ks.Robot(description).configuration(at.q, closure_tolerance=1e-9)
