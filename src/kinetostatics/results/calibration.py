"""Results of calibrations, with confidence intervals and unidentifiable parameters, and plans of measurements."""

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
_NEVER_NEGATIVE = {"kg": "mass", "kg/m³": "density", "Pa": "modulus", "N/m": "stiffness", "N m/rad": "stiffness"}


@dataclass(frozen=True)
class Estimate:
    """Estimate of one unknown.

    Attributes:
        name: name of the unknown.
        kind: "stiffness" (``value`` is a factor of the stiffness in the file), "argument" (of the file, or a dimension of a
            part), "error" (of assembly), "payload" or "offset".
        value: estimate, SI.
        unit: unit of the value; empty for a factor or an unknown unit.
        start: initial value of the search, from the file.
        interval: confidence interval; an infinite end means no bound. For a stiffness, the inverse of the compliance's interval,
            so that the value is not at its centre.
        standard_error: standard error of the value; infinite if the readings do not determine it.
        identified: whether the readings determine the value; if not, ``value`` is the fitting value nearest to the start.
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
        """The reason why the value is physically impossible; empty if the value is possible."""
        what = _NEVER_NEGATIVE.get(self.unit)
        if what is None or self.value >= 0 or self.start < 0:
            return ""
        return f"no {what} is negative"


@dataclass(frozen=True)
class Unidentifiable:
    """A combined change of unknowns that affects no reading.

    Attributes:
        direction: relative change of each unknown involved. A stiffness stands for its compliance; changes of a centre of mass
            are relative to the characteristic length; those of an assembly error to this length, 1 rad or 100 K; those of an
            offset to the gauge's readings; all others to the unknown's value.
        words: text that names the unknowns and, if there are two, the combination of them that the readings do determine.
    """

    direction: Mapping[str, float]
    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Outlier:
    """A reading inconsistent with the others.

    Attributes:
        row: line of the file, or index of the row.
        gauge: name of the gauge.
        measured, computed: the reading and its computed value, SI.
        studentized: externally studentized residual.
    """

    row: int
    gauge: str
    measured: float
    computed: float
    studentized: float


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Reported, builder="reports.calibration:calibration_report"):
    """Result of :func:`kinetostatics.calibrate`.

    Attributes:
        estimates: estimates by name of the unknown.
        unidentifiable: combined changes of unknowns that affect no reading; empty if all unknowns are determined.
        level: confidence level of the intervals.
        covariance: (p, p) covariance of the variables of the fit, in the order of ``estimates``. The variable is the compliance
            factor for a stiffness, and the first moment for a centre of mass if the mass is unknown too.
        gauges: gauges with readings, by name.
        rows: (n,) row of each reading: line of the file, or index of the row.
        gauge_of: (n,) gauge of each reading.
        measured, computed: (n,) readings [m, rad].
        used: (n,) bool, False where a reading was left out as an outlier.
        studentized: (n,) externally studentized residuals.
        leave_one_out: (n,) measured readings less those predicted from the other rows; NaN where there is no prediction.
        outliers: readings inconsistent with the others.
        sigma: (n,) standard deviation of each reading, given or estimated from the residuals.
        sigma_known: whether the standard deviations were given.
        reduced_chi_square: Σ (residual/sigma)² per degree of freedom, about 1 if model and sigma are right; NaN without given
            sigma.
        degrees_of_freedom: number of readings minus number of identified unknowns.
        converged: whether the fit converged.
        payload: the payload, or None.
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
        """Return the root mean square of errors of the used readings of one kind.

        Args:
            errors: (n,) errors of all readings, such as ``residuals`` or ``leave_one_out``.
            kind: "length" or "angle".
        """
        mine = np.array([self.gauges[name].kind == kind for name in self.gauge_of]) & self.used & np.isfinite(errors)
        return float(np.sqrt(np.mean(errors[mine] ** 2))) if np.any(mine) else float("nan")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot with the estimates to a plain URDF file, see :func:`kinetostatics.save_robot`."""
        save_robot(self.robot, path)


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(Reported, builder="reports.calibration:plan_report"):
    """Result of :func:`kinetostatics.plan_measurements`.

    Attributes:
        coordinates: (n,) coordinates of the poses, by name [m, rad].
        load: (n, 6) loads [N, N·m].
        gauges: names of the gauges to be read.
        standard_errors: expected standard errors of the identified unknowns, for the gauges' sigma (default: 1 µm, 1 µrad);
            relative for a stiffness.
        random_standard_errors: standard errors of random plans, geometric mean.
        gain: ratio of the standard errors of random plans to those of this plan, geometric mean over all directions.
        unidentifiable: combined changes of unknowns that affect no reading at any candidate.
        candidates: number of candidates (poses times loads).
        left_out: number of candidates that are unreachable, singular or beyond a joint limit.
        chosen: (n,) indices of the chosen candidates.
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
