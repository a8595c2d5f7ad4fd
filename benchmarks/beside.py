"""Robots and the poses around which they are measured, given by coordinates of the platform that determine them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import kinetostatics as ks
from kinetostatics.kinematics.alternatives import choices
from kinetostatics.math.rotations import orientation_named

#: Poses of a map, and half its width along lengths, in characteristic lengths, and angles [rad].
MANY, WIDE = 20_000, (0.05, 0.1)
#: Where poses lie of robots whose zero pose is singular or has stretched legs, so that hardly a pose around it can be reached:
#: coordinates of the platform, or of the actuators in their order.
MIDDLES = {
    "anymal_standing": {"x": 0.0, "y": 0.0, "z": 0.45, "rx": 0.0, "ry": 0.0, "rz": 0.0},
    "ur10": (0.3, -1.0, 1.2, -0.9, -1.2, 0.4),
}
#: Robots of the tables on pages: from the simplest to the most expensive.
ROBOTS = ("2pru_upr", "3rps", "anymal_standing", "delta", "gough_stewart", "orthoglide", "spherical_3rrr", "ur10")
#: What angles of the platform mean.
ORIENTATION = "XYZ"


def middle_of(name: str) -> tuple[ks.Robot, ks.Configuration]:
    """Return a robot, and the pose around which it is measured."""
    robot, middle = ks.load_robot(name), MIDDLES.get(name)
    if isinstance(middle, dict):
        return robot, robot.assemble(platform=middle, orientation=ORIENTATION, engine="numpy")
    actuators = None if middle is None else dict(zip(robot.description.actuated, middle, strict=True))
    return robot, robot.assemble(actuators=actuators, engine="numpy")


@dataclass(frozen=True)
class Around:
    """A robot and poses around one.

    Attributes:
        robot: the robot.
        middle: the pose in the middle.
        near: where lines to the others begin; None: at the zero pose.
        names: of the coordinates that are given.
        many: (MANY,) the coordinates of poses anywhere around.
    """

    robot: ks.Robot
    middle: ks.Configuration
    near: ks.Configuration | None
    names: tuple[str, ...]
    many: dict[str, np.ndarray]

    @classmethod
    def of(cls, name: str) -> Around:
        """Return those of a robot, the same at every call."""
        robot, middle = middle_of(name)
        names = determining(robot, middle, ORIENTATION)
        zero, random = middle.platform_coordinates(ORIENTATION), np.random.default_rng(0)
        wide = {key: WIDE[0] * robot.length if key in "xyz" else WIDE[1] for key in names}
        many = {key: float(zero[key]) + wide[key] * random.uniform(-1, 1, MANY) for key in names}
        return cls(robot, middle, middle if name in MIDDLES else None, names, many)

    @property
    def one(self) -> dict[str, float]:
        """The coordinates of one of the poses."""
        return {key: float(values[0]) for key, values in self.many.items()}


def determining(robot: ks.Robot, pose: ks.Configuration, orientation: str, turned: bool = False) -> tuple[str, ...]:
    """Return coordinates of the platform that determine a pose; if ``turned`` those with most angles."""
    found = choices(robot, orientation_named(orientation), (), pose.poses)
    return max(found, key=lambda names: sum(name not in "xyz" for name in names)) if turned else found[0]
