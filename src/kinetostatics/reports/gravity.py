"""How gravity acts, for reports: by the platform's weight, by the limbs' attached wrenches, by their deformation (Eq. (12))."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.results.gravity_ways import force_ways, twist_ways
from kinetostatics.results.result import Result
from kinetostatics.statics.solution import of_deformation

#: What the ways of the limbs' weights are called in tables.
WORDS = {"attached": "attached wrenches"}


def gravity_twists(result: Result) -> dict[str, Array]:
    """Return the twists (6,) that gravity makes, by the ways in which it acts, and their sum."""
    found = {WORDS.get(way, way): twist for way, twist in twist_ways(result).items()}
    return {**found, "all of gravity": np.sum(list(found.values()), axis=0)}


def drive_parts(result: Result) -> dict[str, list[Array]]:
    """Return what each drive's force is made of: for each contribution and way of gravity the parts of all drives."""
    names = [limb.name for limb in result.robot.topology.limbs]
    limbs = {*names, *map(of_deformation, names)}
    parts: dict[str, list[Array]] = {}
    for drive, ways in force_ways(result).items():
        whole = {name: part for name, part in result.actuator_contributions[drive].items() if name not in limbs}
        if limbs:
            whole |= {WORDS.get(way, way): part for way, part in ways.items()}
        for name, part in whole.items():
            parts.setdefault(name, []).append(part)
    return parts
