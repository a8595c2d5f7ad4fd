"""Margins of safety: forces of actuators, stresses, and forces that buckle members, compared with their limits.

The limits are the efforts of the actuators and the yield strengths of the beams, where the file states them, and the forces at
which members buckle. The ratio of a value to its limit is its utilization, its reciprocal the safety factor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.linalg import EQUAL
from kinetostatics.results.pose_arrays import Batch
from kinetostatics.robot import Robot
from kinetostatics.statics.solution import Solution


@dataclass(frozen=True, eq=False, repr=False)
class Margins:
    """Safety factors (…) of a result, batch axes first; NaN at poses without results, or if an actuator's force is undetermined.

    A limit is named after its kind and part: "effort of prismatic_1", "yield of rod_1", "buckling of rod_1". Collinear beams that
    buckle together have one limit, with the name of the first.

    Attributes:
        shape: batch shape.
        stated: utilizations (…) of the efforts and yield strengths in the file, by name of the limit.
        buckling: function that returns the utilizations (…) of the buckling loads; they may be 0 if they are below its argument.
    """

    shape: tuple[int, ...]
    stated: Mapping[str, Array]
    buckling: Callable[[float], Mapping[str, Array]]

    def __repr__(self) -> str:
        return f"<Margins: {len(self.limits)} limits>"

    @cached_property
    def safety_factors(self) -> Mapping[str, Array]:
        """(…) ratio of each limit to its value; infinite without force."""
        utilizations = {**self.stated, **self.buckling(0.0)}
        return ResultMapping({name: _reciprocal(utilization) for name, utilization in utilizations.items()})

    @property
    def limits(self) -> tuple[str, ...]:
        """Names of all limits."""
        return self._largest[0]

    @property
    def utilization(self) -> Array:
        """(…) the largest utilization."""
        return self._largest[1]

    @property
    def smallest(self) -> Array:
        """(…) the smallest safety factor."""
        return _reciprocal(self.utilization)

    @cached_property
    def limited_by(self) -> NDArray[np.object_]:
        """(…) name of the limit with the smallest safety factor; "" without one."""
        return np.asarray(np.array([*self.limits, ""], dtype=object)[self.limit_index])

    @property
    def limit_index(self) -> NDArray[np.int16]:
        """(…) index of :attr:`limited_by` among :attr:`limits`; −1 without one."""
        return self._largest[2]

    @cached_property
    def _largest(self) -> tuple[tuple[str, ...], Array, NDArray[np.int16]]:
        least = np.min(np.max([*self.stated.values()], axis=0), initial=np.inf) if self.stated else 0.0
        utilizations = {**self.stated, **self.buckling(float(least) if np.isfinite(least) else 0.0)}
        if not utilizations:
            return (), frozen(np.full(self.shape, np.nan)), frozen(np.full(self.shape, -1, dtype=np.int16))
        values = np.stack([*utilizations.values()])
        largest = np.asarray(values.max(axis=0))
        index = np.where(np.isnan(largest), -1, (values >= (1 - EQUAL) * largest).argmax(axis=0)).astype(np.int16)
        return tuple(utilizations), frozen(largest), frozen(index)


def margins_of(
    robot: Robot, batch: Batch, solutions: Sequence[Solution], utilization: Mapping[str, Array], stress: Callable[[str], Array]
) -> Margins:
    """Return the margins of a result.

    Args:
        utilization: (…) utilization of each actuator.
        stress: function that returns the largest stress (…) of a beam [Pa], by name.
    """
    strengths = {name: beam.material.yield_strength for name, beam in robot.description.beams.items()}
    stated = {f"effort of {name}": utilization[name] for name in robot.description.actuator_limits("effort")}
    stated |= {f"yield of {name}": np.asarray(stress(name) / strength) for name, strength in strengths.items() if strength}

    def buckling(least: float) -> dict[str, Array]:
        ratios = [robot.members.ratios(solution, least) for solution in solutions]
        return {f"buckling of {first}": batch.public([ratio[first] for ratio in ratios]) for first, *_ in robot.members.names}

    return Margins(batch.shape, stated, buckling)


def _reciprocal(utilization: Array) -> Array:
    with np.errstate(divide="ignore"):
        return frozen(np.asarray(1 / np.asarray(utilization)))
