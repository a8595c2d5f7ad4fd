"""The robots of the package, each read once in a process."""

from functools import cache

from places import ROBOTS

import kinetostatics as ks

NAMES = sorted(path.name.partition(".")[0] for path in ROBOTS.glob("*.xacro"))


@cache
def robot(name, **parameters):
    return ks.load_robot(ROBOTS / f"{name}.urdf.xacro", parameters)
