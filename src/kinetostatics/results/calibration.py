"""Results of calibrations and of plans of measurements: which unknowns the readings of gauges determine, and how well."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.loads import Gauge, Payload
from kinetostatics.files.writer import cells, save_robot, write_table
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.robot import Robot

#: Quantities that cannot be negative, by SI unit.
_NEVER_NEGATIVE = {"kg": "mass", "kg/m³": "density", "Pa": "modulus", "N/m": "stiffness", "N·m/rad": "stiffness"}


@dataclass(frozen=True)
class Estimate:
    """Estimate of one unknown.

    Attributes:
        name: name of the unknown.
        kind: "stiffness", "argument" (an argument of the file, or a dimension of a part), "error" (of assembly), "payload" or
            "offset" (of a gauge).
        value: estimate, SI; for a stiffness, its ratio to the stiffness in the file.
        unit: unit of the value; empty for a ratio or an unknown unit.
        start: initial value of the search, from the file.
        interval: lower and upper end of the confidence interval, infinite where there is no bound. The value of a stiffness is
            not at its centre, because the interval is the inverse of that of the compliance.
        standard_error: standard error of the value; infinite if the readings do not determine it.
        identified: whether the readings determine the value; if not, ``value`` is the nearest to ``start`` that fits them.
    """

    name: str
    kind: str
    value: float
    unit: str
    start: float
    interval: tuple[float, float]
    standard_error: float
    identified: bool

    @property
    def impossible(self) -> str:
        """The reason why the value is physically impossible, such as "no mass is negative"; "" for a possible value."""
        what = _NEVER_NEGATIVE.get(self.unit)
        if what is None or self.value >= 0 or self.start < 0:
            return ""
        return f"no {what} is negative"


@dataclass(frozen=True)
class Unidentifiable:
    """A combined change of unknowns that affects no reading.

    Attributes:
        direction: change of each unknown (of a stiffness: change of its compliance), relative to its value; but relative to the
            characteristic length for a centre of mass; to this length, 1 rad or 100 K for an assembly error; to the magnitude of
            the gauge's readings for an offset.
        words: text with the names of the unknowns; for two unknowns, also with their combination that the readings determine.
    """

    direction: Mapping[str, float]
    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Outlier:
    """A reading that is inconsistent with the other readings.

    Attributes:
        row: line of the file of measurements; without a file, index of the row.
        gauge: name of the gauge.
        measured, computed: the reading, and its value computed with the estimates [m, rad].
        studentized: externally studentized residual.
    """

    row: int
    gauge: str
    measured: float
    computed: float
    studentized: float


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Reported):
    """Result of :func:`kinetostatics.calibrate`.

    Attributes:
        estimates: estimates by name of the unknown.
        unidentifiable: combined changes of unknowns that affect no reading; empty if all unknowns are determined.
        level: confidence level of the intervals.
        covariance: (p, p) covariance of the variables of the fit, in the order of ``estimates``. For a stiffness, the variable
            is its compliance relative to that in the file; for a centre of mass, if the mass is unknown too, the first moment.
        gauges: gauges with readings, by name.
        rows: (n,) row of each reading: line of the file of measurements; without a file, index of the row.
        gauge_of: (n,) name of the gauge of each reading.
        measured, computed: (n,) readings, and their values computed with the estimates [m, rad].
        used: (n,) False where a reading was left out as an outlier, True elsewhere.
        studentized: (n,) externally studentized residuals.
        leave_one_out: (n,) readings less their predictions from the other rows [m, rad]; NaN where there is no prediction.
        outliers: readings that are inconsistent with the other readings.
        sigma: (n,) standard deviation of each reading [m, rad], given or estimated from the residuals.
        sigma_known: whether the standard deviations were given.
        reduced_chi_square: Σ (residual/sigma)² per degree of freedom, about 1 if model and sigma are right; NaN without given
            sigma or without degrees of freedom.
        degrees_of_freedom: number of readings minus number of identified unknowns.
        converged: whether the fit converged.
        payload: the payload with its estimates; None if its mass is zero.
        robot: the robot with the estimates.
    """

    estimates: Mapping[str, Estimate]
    unidentifiable: tuple[Unidentifiable, ...]
    level: float
    covariance: Array
    gauges: Mapping[str, Gauge]
    rows: Index
    gauge_of: tuple[str, ...]
    measured: Array
    computed: Array
    used: Mask
    studentized: Array
    leave_one_out: Array
    outliers: tuple[Outlier, ...]
    sigma: Array
    sigma_known: bool
    reduced_chi_square: float
    degrees_of_freedom: int
    converged: bool
    payload: Payload | None
    robot: Robot

    @property
    def residuals(self) -> Array:
        """(n,) measured less computed [m, rad]."""
        return np.asarray(self.measured - self.computed)

    def root_mean_square(self, errors: Array, kind: str = "length") -> float:
        """Return the root mean square of errors, over the used readings of lengths or of angles; NaN if there are none.

        Args:
            errors: (n,) errors of all readings, such as ``residuals`` or ``leave_one_out``.
            kind: "length" or "angle".
        """
        used_readings = np.array([self.gauges[name].kind == kind for name in self.gauge_of]) & self.used & np.isfinite(errors)
        return float(np.sqrt(np.mean(errors[used_readings] ** 2))) if np.any(used_readings) else float("nan")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot with the estimates to a plain URDF file, see :func:`kinetostatics.save_robot`."""
        save_robot(self.robot, path)


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(Reported):
    """Result of :func:`kinetostatics.plan_measurements`.

    Attributes:
        coordinates: (n,) coordinates of the poses of the n measurements, by name [m, rad].
        load: (n, 6) loads on the platform in the measurements [N, N·m].
        gauges: names of the gauges to be read in each measurement.
        standard_errors: expected standard error of each identified unknown, SI; of a stiffness, relative to its value. The
            readings have the standard deviation ``sigma`` of their gauge (default: 1 µm, 1 µrad).
        random_standard_errors: geometric mean of the standard errors of random plans.
        gain: factor by which the standard errors are smaller than those of random plans, geometric mean over all independent
            combinations of unknowns that the readings determine; NaN if no random plan determines them.
        unidentifiable: combined changes of unknowns that affect no reading at any of the given poses and loads.
        candidates: number of combinations of pose and load from which the measurements were chosen.
        left_out: number of other combinations, whose poses are unreachable, singular or beyond a joint limit.
        chosen: (n,) indices of the measurements among all combinations of pose and load.
        robot: the robot to be measured.
    """

    coordinates: Mapping[str, Array]
    load: Array
    gauges: tuple[str, ...]
    standard_errors: Mapping[str, float]
    random_standard_errors: Mapping[str, float]
    gain: float
    unidentifiable: tuple[Unidentifiable, ...]
    candidates: int
    left_out: int
    chosen: Index
    robot: Robot

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the plan as a table of measurements (CSV) with empty readings; an existing file is replaced.

        Raises:
            ArgumentError: the file cannot be written.
        """
        columns = {name: cells(values) for name, values in self.coordinates.items()}
        columns |= dict(zip(WRENCH_COMPONENTS, map(cells, self.load.T), strict=True))
        write_table(path, columns | {gauge: [""] * len(self.load) for gauge in self.gauges})
