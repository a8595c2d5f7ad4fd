"""How gravity acts, for reports: by the platform's weight, by the limbs' attached wrenches, by their deformation (Eq. (12))."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kinetostatics.result import Result

Array = NDArray[np.float64]

#: What the two ways of the limbs' weights are called in tables.
WAYS = {"attached": "attached wrenches", "deformation": "deformation"}


def gravity_twists(result: Result) -> dict[str, Array]:
    """Return the twists (6,) that gravity makes, by the ways in which it acts, and their sum."""
    found = {"platform_weight": result.contributions["platform_weight"]}
    found |= _sums(result.mechanism_contributions)
    return {**found, "all of gravity": np.sum(list(found.values()), axis=0)}


def drive_parts(result: Result) -> dict[str, list[Array]]:
    """Return what each drive's force is made of: for each contribution and way of gravity the parts of all drives."""
    limbs = {limb.name for limb in result.robot.topology.limbs}
    parts: dict[str, list[Array]] = {}
    for drive in result.actuator_forces:
        whole = {name: part for name, part in result.actuator_contributions[drive].items() if name not in limbs}
        whole |= _sums(result.actuator_mechanism_contributions[drive])
        for name, part in whole.items():
            parts.setdefault(name, []).append(part)
    return parts


def _sums(limbs: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    """Return the sums over all limbs."""
    return {words: np.sum([ways[way] for ways in limbs.values()], axis=0) for way, words in WAYS.items()} if limbs else {}
