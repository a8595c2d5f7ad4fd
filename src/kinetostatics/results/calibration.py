"""Results of calibrations, with confidence intervals and unidentifiable parameters, and plans of measurements."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.gauges import Gauge
from kinetostatics.description.loads import Payload
from kinetostatics.files.writer import save_robot, write_text
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.robot import Robot

#: What is never negative, by its SI unit.
_NEVER_NEGATIVE = {"kg": "mass", "kg/m³": "density", "Pa": "modulus", "N/m": "stiffness", "N m/rad": "stiffness"}


@dataclass(frozen=True)
class Estimate:
    """One unknown.

    Attributes:
        name: as it was asked for.
        kind: "stiffness" (``value`` is a factor of the file's), "argument" of the file, "payload" or "offset".
        value: SI.
        unit: of the value; empty for a factor, and where it is not known.
        start: where the search began: the file's value.
        interval: confidence interval. Of a stiffness its ends are those of its compliance, so that it lies unevenly about the
            value; infinite ends: nothing is known on that side.
        standard_error: of the value; infinite if the readings do not determine it.
        identified: whether they determine it. If not, the value is that of all that fit which is nearest to the start.
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
        """Why nothing has such a value, in words; empty if something may."""
        what = _NEVER_NEGATIVE.get(self.unit)
        if what is None or self.value >= 0 or self.start < 0:
            return ""
        return f"no {what} is negative"


@dataclass(frozen=True)
class Unidentifiable:
    """A change of unknowns together that no reading sees.

    Attributes:
        direction: change of each unknown that takes part: of a stiffness in parts of its compliance, of an argument or a mass in
            parts of its value, of a centre in parts of the robot's length, of an offset in parts of its gauge's readings.
        words: what cannot be told, and what is seen instead.
    """

    direction: Mapping[str, float]
    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Outlier:
    """A reading that does not fit the others.

    Attributes:
        row: line of the file, or number of the row from 0.
        gauge: that was read.
        measured, computed: SI.
        studentized: its residual over what it should be like.
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
        estimates: by the unknowns' names.
        unidentifiable: changes that no reading sees, in words; empty if everything is determined.
        level: of the confidence intervals.
        covariance: (p, p) of the unknowns in the order of ``estimates``, as they are varied: of a stiffness its compliance
            factor, of a centre of mass the first moment if the mass is unknown, too.
        gauges: that were read, by name.
        rows: (n,) where each reading stands: line of the file, or number of the row from 0.
        gauge_of: (n,) name of the gauge of each.
        measured, computed: (n,) readings [m, rad].
        used: (n,) bool, False where a reading was left out as an outlier.
        studentized: (n,) residuals over what they should be like.
        leave_one_out: (n,) errors of each reading as predicted from the other rows; NaN where it cannot be.
        outliers: readings that do not fit the others.
        sigma: (n,) standard deviation of each reading: as given, or found from the residuals.
        sigma_known: whether it was given.
        reduced_chi_square: Σ (residual/sigma)² per degree of freedom, about 1 if model and sigma are right; NaN where
            no sigma was given.
        degrees_of_freedom: readings less unknowns that they determine.
        converged: whether the search ended by itself.
        payload: what the robot carries, None if nothing.
        robot: with the estimates.
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
        """Return the root mean square of errors (n,), such as ``residuals`` or ``leave_one_out``, of used readings of a kind.

        Args:
            errors: of all readings.
            kind: "length" or "angle".
        """
        mine = np.array([self.gauges[name].kind == kind for name in self.gauge_of]) & self.used & np.isfinite(errors)
        return float(np.sqrt(np.mean(errors[mine] ** 2))) if np.any(mine) else float("nan")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot with the estimates to a plain URDF file that loads, see :func:`kinetostatics.save_robot`."""
        save_robot(self.robot, path)


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(Reported, builder="reports.calibration:plan_report"):
    """Result of :func:`kinetostatics.plan_measurements`.

    Attributes:
        coordinates: (n,) of each pose, by name [m, rad].
        load: (n, 6) [N, N·m].
        gauges: names of the gauges to be read.
        standard_errors: of each unknown that these measurements determine, for the gauges' sigma, or for 1 µm and 1 µrad; of a
            stiffness relative.
        random_standard_errors: the same of random plans, in the mean.
        gain: by which factor standard errors are smaller than of random plans, geometric mean of all directions.
        unidentifiable: what no pose and load of the candidates tells.
        candidates: poses times loads out of which they were chosen.
        left_out: poses times loads that are out of reach, singular or beyond a joint's limit.
        chosen: (n,) their numbers.
        robot: that is to be measured.
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
        """Write the plan as a table of measurements (CSV), whose readings are still empty; a file of that name is replaced.

        Raises:
            ArgumentError: the file cannot be written.
        """
        names = [*self.coordinates, *WRENCH_COMPONENTS, *self.gauges]
        lines = [",".join(names)]
        for k, load in enumerate(self.load):
            cells = [*(values[k] for values in self.coordinates.values()), *load]
            lines.append(",".join([*(f"{float(cell):.12g}" for cell in cells), *("" for _ in self.gauges)]))
        write_text(path, "\n".join(lines) + "\n")
