"""How gravity acts, Eq. (12): by the platform's weight, by the attached wrenches of all limbs, by their deformation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.math.arrays import Array

if TYPE_CHECKING:
    from kinetostatics.results.result import Result


#: The names of the ways.
WAYS = ("platform_weight", "attached", "deformation")


def twist_ways(result: Result) -> dict[str, Array]:
    """Return the twist (…, 6) that gravity makes in each way."""
    return _ways(result.contributions["platform_weight"], result.mechanism_contributions)


def force_ways(result: Result) -> dict[str, dict[str, Array]]:
    """Return what gravity adds to each actuator's force (…) in each way, by actuator."""
    limbs = result.actuator_mechanism_contributions
    return {actuator: _ways(result.actuator_contributions[actuator]["platform_weight"], limbs[actuator]) for actuator in limbs}


def _ways(platform: Array, limbs: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    sums = {way: sum((ways[way] for ways in limbs.values()), np.zeros_like(platform)) for way in WAYS[1:]}
    return {WAYS[0]: platform, **sums}
