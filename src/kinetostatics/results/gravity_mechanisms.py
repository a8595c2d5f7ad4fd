"""Sag and actuator forces by mechanism of gravity, Eq. (12): platform weight, attached wrenches, deformation of the limbs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.math.arrays import Array

if TYPE_CHECKING:
    from kinetostatics.results.result import Result


#: The names of the mechanisms.
MECHANISMS = ("platform_weight", "attached", "deformation")


def gravity_mechanisms(result: Result) -> dict[str, Array]:
    """Return the twist (…, 6) due to gravity by mechanism."""
    return _sums(result.contributions["platform_weight"], result.mechanism_contributions)


def actuator_gravity_mechanisms(result: Result) -> dict[str, dict[str, Array]]:
    """Return the force (…) of each actuator due to gravity, by actuator and mechanism."""
    limbs = result.actuator_mechanism_contributions
    return {actuator: _sums(result.actuator_contributions[actuator]["platform_weight"], limbs[actuator]) for actuator in limbs}


def _sums(platform: Array, limbs: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    sums = {name: sum((parts[name] for parts in limbs.values()), np.zeros_like(platform)) for name in MECHANISMS[1:]}
    return {MECHANISMS[0]: platform, **sums}
