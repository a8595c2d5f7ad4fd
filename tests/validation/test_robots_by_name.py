"""Robots built from architecture, dimensions, sections and masses against the same robots of the package."""

from math import acos, asin, cos, pi, radians, sin, sqrt

import numpy as np
import package_robots
import pytest

import kinetostatics as ks

STEEL = {"youngs_modulus": 210e9, "poisson_ratio": 0.3, "density": 7850}


def disc(mass, offset=0.0):
    """A platform whose centre of mass is so far above o."""
    return {"platform_mass": mass, "platform_center": (0, 0, offset)}


def rps():
    lean = asin(0.1 / 0.55)
    return (
        "3-R[P]S",
        dict(base_radius=0.3, platform_radius=0.2, height=0.55 * cos(lean), azimuths=[0, -2 * pi / 3, 2 * pi / 3]),
        dict(sections={"rod": "circle 100mm"}, youngs_modulus=200e9, poisson_ratio=0.3, density=7820, shear_coefficient=1),
        dict(platform_mass=pi * 0.2**2 * 0.02 * 7820),
    )


def pru_upr():
    slider = 0.25 + 0.7 * sin(acos(0.6 / 0.7))
    limbs = [
        {"base": (0, slider, 0), "platform": (0, 0.25, 0), "guide": (0, 1, 0), "axis": (1, 0, 0)},
        {"base": (0, -slider, 0), "platform": (0, -0.25, 0), "guide": (0, -1, 0), "axis": (1, 0, 0)},
        {"base": (0.5, 0, 0), "platform": (0.25, 0, 0)},
    ]
    return (
        "2-[P]RU+U[P]R",
        dict(placements=limbs, height=0.6),
        dict(sections={"rod": "circle 60mm"}, youngs_modulus=200e9, poisson_ratio=0.3, density=7850, shear_coefficient=1),
        dict(platform_mass=0.25**2 * 0.05 * 7850, platform_center=(0.25 / 3, 0, 0), carriage_mass=0),
    )


def rus():
    base, platform, crank, rod = 0.4064, 0.40005, 0.18415, 0.7239
    thirds = [radians(angle) for angle in (30, 150, 270)]
    at_platform = [angle + side * radians(10) for angle in thirds for side in (-1, 1)]
    reach = (platform * cos(at_platform[0]) - base, platform * sin(at_platform[0]) + crank)
    limbs = []
    for k, angle in enumerate(at_platform):
        at, side = k * pi / 3, (-1) ** k
        limbs.append(
            {
                "base": (base * cos(at), base * sin(at), 0),
                "platform": (platform * cos(angle), platform * sin(angle), 0),
                "axis": (-side * cos(at), -side * sin(at), 0),
            }
        )
    return (
        "6-[R]US",
        dict(placements=limbs, height=sqrt(rod**2 - reach[0] ** 2 - reach[1] ** 2), crank_length=crank, crank_angle=pi),
        dict(sections={"crank": "rectangle 20mm 60mm", "rod": "tube 30mm 22mm"}, **STEEL),
        disc(160, 0.3),
    )


def delta():
    lean = asin((0.15 + 0.3 - 0.05) / 0.8)
    carbon = {"density": 1550, "shear_coefficient": 0.5}
    crank = {"youngs_modulus": 70e9, "shear_modulus": 20e9, **carbon}
    rod = {"youngs_modulus": 110e9, "shear_modulus": 6e9, **carbon}
    return (
        "3-[R](4S)",
        dict(base_radius=0.15, platform_radius=0.05, height=-0.8 * cos(lean), crank_length=0.3, crank_angle=0, pair_width=0.1),
        dict(sections={"crank": "tube 50mm 44mm carbon", "rod": "tube 14mm 11mm carbon"}),
        {f"crank_{key}": value for key, value in crank.items()},
        {f"rod_{key}": value for key, value in rod.items()},
        dict(elbow_mass=0.15, **disc(1.2, -0.05 / 1.2)),
    )


def tricept():
    return (
        "3-U[P]S+UP",
        dict(base_radius=0.45, platform_radius=0.2, height=-1.0, azimuths=None),
        dict(sections={"rod": "circle 50mm", "rod_4": "tube 200mm 160mm"}),
        disc(150, -0.2),
    )


#: Robots of the package that an architecture describes, with actuator values of a pose beside the zero pose.
ROBOTS = {
    "3rps": (rps, 0.03),
    "2pru_upr": (pru_upr, 0.03),
    "6rus": (rus, 0.1),
    "delta": (delta, 0.1),
    "tricept": (tricept, 0.05),
}


def numbers(result):
    """Twist, actuators and stiffness, the actuators in their order."""
    return {
        "twist": result.twist,
        "actuator forces": np.array(list(result.actuator_forces.values())),
        "stiffness": result.stiffness,
        "contributions of limbs": np.array([twist for name, twist in result.contributions.items() if name.startswith("limb")]),
    }


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_robot_from_architecture_equals_package_robot(name):
    make, step = ROBOTS[name]
    architecture, *parts = make()
    robot = ks.new_robot(architecture, **{key: value for part in parts for key, value in part.items()})
    shipped = package_robots.robot(name)
    found = []
    for one in (shipped, robot):
        drives = {joint: step * (1 + 0.3 * k) * (-1) ** k for k, joint in enumerate(one.description.actuated)}
        found.append(numbers(ks.analyze(one.assemble(actuators=drives), load=[10, -20, 30, 1, 2, -3])))
    for what, expected in found[0].items():
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found[1][what] / scale, expected / scale, atol=1e-9, rtol=0, err_msg=f"{name}, {what}")
