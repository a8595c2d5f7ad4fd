"""The largest load or mass that a robot may carry, and the limit that it reaches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array
from kinetostatics.results.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class Capacity(Reported):
    """The largest load at poses (…), see :func:`kinetostatics.capacity`; arrays are read-only.

    Attributes:
        configuration: the pose or poses.
        load: (…) the largest factor of the given wrench, largest force in any direction [N], or largest mass [kg]; 0 where a
            limit is exceeded without it, infinite where nothing limits it, NaN without result or with undetermined forces.
        unit: "N", "kg", or "1" for a factor.
        limited_by: (…) name of the limit that is reached: "effort of prismatic_1", "yield of rod_1", "buckling of rod_1", "sag";
            "" without one.
        direction: (…, 6) the wrench of load 1 on the platform about o, world axes: the given one, or a force of 1 N in the worst
            direction [N, N·m]; None for a mass.
        result: the analysis under the largest load; without any load where it is infinite.
    """

    configuration: Configuration
    load: Array
    unit: str
    limited_by: NDArray[np.object_]
    direction: Array | None
    result: Result

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of all arrays."""
        return self.load.shape

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the result under the largest load, in full sentences."""
        return self.result.warnings
