"""Poses and loads at which stiffness under load is compared with the energy model (:mod:`energy_model`).

Loads of random robots, moments included, are scaled so that geometric stiffness changes the platform's compliance by some per
cent and nothing buckles: a comparison to 1e-6 then judges the geometric stiffness itself to 1e-4 or better.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import energy_model
import hybrid_robots
import numpy as np
import package_robots
import pinocchio as pin
import small_robots as sr
import sprung_robots
from energy_structure import structure_of

#: Factors of the loads, by robot or seed.
PACKAGE = {
    "2pru_upr": 640.0, "3prs": 1000.0, "3rps": 4500.0, "6rus": 130.0, "anymal_standing": 54.0, "delta": 4.0, "exechon": 190.0,
    "five_bar": 100.0, "gough_stewart": 400.0, "linear_delta": 0.035, "orthoglide": 210.0, "planar_3rrr": 0.21,
    "spherical_3rrr": 0.51, "tricept": 230.0, "tripteron": 560.0, "ur10": 460.0,
}  # fmt: skip
SERIAL = {
    0: 37.0, 1: 1.7, 2: 50.0, 5: 19.0, 6: 93.0, 8: 81.0, 11: 2.4, 12: 110.0, 19: 340.0, 20: 360.0, 21: 0.63, 24: 3.9, 26: 21.0,
    27: 0.93, 29: 120.0, 30: 60.0, 31: 13.0, 34: 28.0, 36: 11.0, 39: 38.0, 43: 4.4, 45: 210.0, 47: 5.5, 48: 3.1, 52: 7.4,
    53: 43.0, 54: 2.2, 56: 36.0,
}  # fmt: skip
HYBRID = {
    2: 2.7, 3: 9.0, 8: 23.0, 9: 0.77, 11: 2.6, 12: 1.5, 16: 67.0, 18: 130.0, 19: 12.0, 24: 4.2, 25: 130.0, 29: 6.7, 34: 140.0,
    36: 100.0, 38: 150.0, 48: 34.0, 57: 6.7, 58: 0.9,
}  # fmt: skip
#: Robots with springs; 3 and 12 are unstable.
SPRUNG = (2, 3, 7, 8, 10, 11, 12, 16, 18, 19, 24, 25, 29, 34, 36, 38, 48, 57)
SPRUNG_PACKAGE = tuple(sorted(set(PACKAGE) - {"delta", "linear_delta", "planar_3rrr", "spherical_3rrr"}))  # these are unstable


@dataclass(frozen=True, eq=False)
class Case:
    """A pose under a load on the platform, gravity, and loads on links, as arguments of :func:`kinetostatics.analyze`."""

    pose: object
    load: np.ndarray
    gravity: np.ndarray
    loads: dict = field(default_factory=dict)

    @property
    def arguments(self):
        return {"load": self.load, "gravity": self.gravity, "loads": self.loads}

    def times(self, factor):
        loads = {link: factor * wrench for link, wrench in self.loads.items()}
        return replace(self, load=factor * self.load, gravity=factor * self.gravity, loads=loads)

    @cached_property
    def structure(self):
        return structure_of(self.pose, self.load, self.gravity, self.loads)

    @cached_property
    def unloaded_geometry(self):
        """The tangent at the unloaded geometry; loads have no part in it in robots with springs."""
        return energy_model.at_the_pose(self.structure, stiffening_loads=not self.pose.robot.description.springs)

    @cached_property
    def equilibrium(self):
        """Motion and tangent in the nonlinear equilibrium."""
        return energy_model.in_equilibrium(self.structure)

    @property
    def with_small_motions(self):
        """The same under loads so small that nothing turns by more than 0.02 rad in linear theory."""
        return self.times(min(1.0, 0.02 / self.unloaded_geometry.turn))

    def difference(self, found, wanted):
        """Return the relative difference of two twists (6,) or compliances (6, 6), a rotation times the robot's length."""
        unit = np.repeat([1.0, self.pose.robot.length], 3)
        unit = unit if wanted.ndim == 1 else np.outer(unit, unit)
        return float(np.linalg.norm((found - wanted) * unit) / np.linalg.norm(wanted * unit))


def loaded(pose, seed, times=1.0, on_links=True):
    """Return a pose under random loads, on one of its links too."""
    rng = np.random.default_rng(seed)
    load, gravity = rng.standard_normal(6) * [50, 50, 50, 10, 10, 10], rng.standard_normal(3) * 5
    links = sprung_robots.may_be_loaded(pose) if on_links else []
    loads = {str(rng.choice(links)): rng.standard_normal(6) * [20, 20, 20, 4, 4, 4]} if links else {}
    return Case(pose, load, gravity, loads).times(times)


def package(name):
    return loaded(package_robots.generic_pose(name), 1, PACKAGE[name], on_links=False)


def serial(seed):
    """Return a robot of serial limbs in a random spelling."""
    rng = np.random.default_rng(seed)
    while True:
        kinds = [str(rng.choice(sr.LIMBS)) for _ in range(rng.integers(2, 7))]
        if sum(map(sr.wrenches, kinds)) >= 6:
            break
    robot = sr.write_randomly(sr.random_spec(kinds, seed), rng, seed).robot()
    return loaded(robot.configuration(pin.neutral(robot.model)), seed, SERIAL[seed])


def hybrid(seed):
    """Return a robot with limbs of any shape: rings, telescopes, elastic joints."""
    _, file = hybrid_robots.write_randomly(hybrid_robots.random_hybrid(seed), seed)
    robot = file.robot()
    return loaded(robot.configuration(pin.neutral(robot.model)), seed, HYBRID[seed])


def sprung(seed):
    """Return such a robot with springs between points."""
    return loaded(sprung_robots.hybrid(seed), seed)


def sprung_package(name):
    """Return a robot of the package with elastic beams and drives and with springs."""
    return loaded(sprung_robots.bundled(name, 1, rigid=False), 1, on_links=False)


#: All cases, by name.
CASES = {
    **{name: partial(package, name) for name in PACKAGE},
    **{f"serial {seed}": partial(serial, seed) for seed in SERIAL},
    **{f"hybrid {seed}": partial(hybrid, seed) for seed in HYBRID},
}
SPRUNG_CASES = {
    **{f"sprung {name}": partial(sprung_package, name) for name in SPRUNG_PACKAGE},
    **{f"sprung {seed}": partial(sprung, seed) for seed in SPRUNG},
}
