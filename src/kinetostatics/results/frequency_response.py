"""Frequency response of the platform."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import path_name
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, WRENCH_COMPONENTS, WRENCH_UNITS
from kinetostatics.results.tables import cells, write_table
from kinetostatics.robot import Robot, robot_of


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(Reported, builder="reports.frequency_response:frequency_response_report"):
    """Response of the platform at o, or at a tool, world axes; see :func:`kinetostatics.frequency_response`.

    Arrays are read-only, batch axes first; NaN where a pose has no numbers. The time factor is exp(iωt).

    Attributes:
        configuration: the pose or poses.
        frequencies: (F,) frequencies [Hz].
        compliance: (…, F, 6, 6) complex twist per wrench on the platform [m/N, rad/(N·m)].
        transmissibility: (…, F, 6, 6) complex twist of the platform per twist of the floor about o.
        damping: the given damping.
        drives: whether the actuators are "locked" or "free".
        payload: the payload, or None.
        tool: (3,) reference point, from o in platform axes [m]; None: o.
    """

    configuration: Configuration
    frequencies: Array
    compliance: NDArray[Any]
    transmissibility: NDArray[Any]
    damping: float | Mapping[str, float]
    drives: str
    payload: Payload | None
    tool: Array | None

    def __post_init__(self) -> None:
        for array in (self.frequencies, self.compliance, self.transmissibility):
            array.setflags(write=False)

    @property
    def robot(self) -> Robot:
        """The robot."""
        return robot_of(self.configuration)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        return self.configuration.shape

    @cached_property
    def stiffness(self) -> NDArray[Any]:
        """(…, F, 6, 6) complex dynamic stiffness at the point, the inverse of the compliance [N/m, N·m/rad]."""
        return np.linalg.inv(self.compliance)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write magnitudes and phases of one pose as a table.

        Args:
            path: name ending in ``.csv``; an existing file is replaced.

        Raises:
            ArgumentError: the name has another ending, or this is a batch.
        """
        name = path_name("path", path)
        if not name.endswith(".csv") or self.shape:
            raise ArgumentError(f"{name} cannot be written: the frequency response of one pose goes into a .csv file")
        columns = {"frequency [Hz]": self.frequencies}
        for what, array, per in (("compliance", self.compliance, True), ("transmissibility", self.transmissibility, False)):
            for i, row in enumerate(COMPONENTS):
                for j, column in enumerate(WRENCH_COMPONENTS if per else COMPONENTS):
                    unit = f"{TWIST_UNITS[i]}/({WRENCH_UNITS[j]})" if per else f"{TWIST_UNITS[i]}/{TWIST_UNITS[j]}"
                    columns[f"|{what} {row} {column}| [{unit}]"] = np.abs(array[:, i, j])
                    columns[f"phase of {what} {row} {column} [rad]"] = np.angle(array[:, i, j])
        write_table(name, {title: cells(column) for title, column in columns.items()})
