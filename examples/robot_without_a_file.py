"""A robot described in Python: a 3-RPS with telescopic legs, with a payload, with thicker legs, and saved as a file.

    python examples/robot_without_a_file.py [tripod.urdf]

Each leg has a hinge at the base, an actuated telescope, and a ball joint at the table. All dimensions are invented. See
``docs/how_to/robots_in_python.md`` for the classes.
"""

from __future__ import annotations

import math
import sys

import numpy as np

import kinetostatics as ks
from kinetostatics.description import Beam, BeamEnd, Joint, Link, Loop, Material, Origin, RobotDescription
from kinetostatics.sections import Tube

ALUMINIUM = Material(youngs_modulus=70e9, poisson_ratio=0.33, density=2700, thermal_expansion=23e-6)
FOOT, HEAD, HEIGHT = 0.45, 0.25, 0.8  # m: radii of the circles of hinges and balls, height of the table above the hinges
TABLE_MASS, CAMERA_MASS = 8.0, 6.0  # kg
CAMERA = (0.12, 0.0, 0.15)  # m, its centre of mass in the table's frame


def tripod(diameter: float = 0.03, wall: float = 0.002) -> RobotDescription:
    """Return the description of the tripod with tubes of some outer diameter [m] and wall thickness [m]."""
    links, joints = [Link("ground"), Link("table", mass=TABLE_MASS)], []
    loops, beams = [], []
    lean = math.atan2(HEAD - FOOT, HEIGHT)  # of the legs' z axes out of the vertical
    for leg in (1, 2, 3):
        angle = 2 * math.pi * (leg - 1) / 3
        cosine, sine = math.cos(angle), math.sin(angle)
        hinge, slide, ball = f"hinge_{leg}", f"slide_{leg}", f"ball_{leg}"
        links += [Link(f"cylinder_{leg}", mass=0.5, center_of_mass=(0, 0, 0.15)), Link(f"rod_{leg}")]
        foot = Origin((FOOT * cosine, FOOT * sine, 0), (0, lean, angle))
        joints += [
            Joint(hinge, "revolute", "ground", f"cylinder_{leg}", foot, axis=(0, 1, 0), lower=-0.5, upper=0.5),
            Joint(slide, "prismatic", f"cylinder_{leg}", f"rod_{leg}", axis=(0, 0, 1), lower=-0.1, upper=0.1),
        ]
        tip, socket = Origin((0, 0, math.hypot(HEAD - FOOT, HEIGHT))), Origin((HEAD * cosine, HEAD * sine, 0))
        loops.append(Loop(ball, "spherical", f"rod_{leg}", "table", tip, socket))
        # one telescopic beam over the whole leg, from the hinge to the ball
        beams.append(Beam(f"rod_{leg}", Tube.of(diameter, diameter - 2 * wall), ALUMINIUM, BeamEnd(hinge), BeamEnd(ball)))
    # The tree has to reach the table, which three balls hold: by a joint that holds nothing.
    joints.append(Joint("free", "floating", "ground", "table", Origin((0, 0, HEIGHT))))
    return RobotDescription.of(
        "tripod",
        links=links,
        joints=joints,
        loops=loops,
        beams=beams,
        platform="table",
        actuated=["slide_1", "slide_2", "slide_3"],
    )


def with_camera(description: RobotDescription) -> RobotDescription:
    """Return the tripod with a camera on its table."""
    return description.with_payload("camera", "table", CAMERA_MASS, at=CAMERA)


def with_legs(description: RobotDescription, diameter: float, wall: float = 0.002) -> RobotDescription:
    """Return the tripod with tubes of another outer diameter [m]."""
    for leg in (1, 2, 3):
        description = description.changed(f"rod_{leg}", section=Tube.of(diameter, diameter - 2 * wall))
    return description


def main(path: str | None = None) -> None:
    """Print the effects of the camera and of thicker legs, and the whole result of the last tripod."""
    variants = {"bare": tripod(), "with a camera": with_camera(tripod())}
    variants["on thicker legs"] = with_legs(variants["with a camera"], diameter=0.05)
    print("                  table sags  and tilts     actuators push")
    for name, description in variants.items():
        result = ks.analyze(ks.Robot(description).assemble())
        forces = ", ".join(f"{float(force):6.1f}" for force in result.actuator_forces.values())
        tilt = float(np.linalg.norm(result.twist[3:5]))
        print(f"{name:16} {-1e6 * result.twist[2]:8.2f} µm {1e6 * tilt:6.1f} µrad  {forces} N")
    robot = ks.Robot(variants["on thicker legs"])
    print(f"\n{robot}\n\n{ks.analyze(robot.assemble(platform={'z': 0.82, 'rx': 0.05, 'ry': 0.0}))}")
    if path is not None:
        ks.save_robot(robot, path)
        same = ks.load_robot(path)
        print(f"\nwritten to {path}; what it loads as is the same: {same.description == robot.description}")


if __name__ == "__main__":
    main(*sys.argv[1:2])
