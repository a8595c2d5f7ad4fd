"""The robots of the package, each read once in a process."""

from functools import cache

from places import ROBOTS

import kinetostatics as ks
from kinetostatics.description import JointStiffness

NAMES = sorted(path.name.partition(".")[0] for path in ROBOTS.glob("*.xacro"))


@cache
def robot(name, **parameters):
    return ks.load_robot(ROBOTS / f"{name}.urdf.xacro", parameters)


@cache
def soft_five_bar():
    """Return the five-bar with drives so soft that 100 N lead it beyond singular poses."""
    description = robot("five_bar").description
    for drive in description.driven:
        description = description.with_part(JointStiffness(drive, drive=1e3))
    return ks.Robot(description)
