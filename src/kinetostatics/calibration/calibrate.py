"""Stiffnesses, payload and offsets from measured deflections, by weighted nonlinear least squares."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import finite_numbers, need, warn
from kinetostatics.calibration.fit import Fit, NoDerivativeError, fit, leave_one_out, outliers
from kinetostatics.calibration.measurements import Measurements, read_gauges, read_measurements
from kinetostatics.calibration.readings import Model, Readings
from kinetostatics.calibration.unknowns import Unknowns, identifiable_ones, unidentifiable
from kinetostatics.description.loads import Gauge, Payload
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.kinematics.configuration import taken
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import CalibrationLoads, load_case_of
from kinetostatics.math.arrays import Array, Mask, frozen
from kinetostatics.results.calibration import Calibration, Estimate, Outlier
from kinetostatics.robot import Robot

#: Advice in messages about impossible estimates.
ADVICE = "check the signs of readings, loads and gravity, reference=, and whether unknowns are missing"


def calibrate(
    robot: Robot,
    measurements: object,
    unknowns: Sequence[str],
    *,
    gauges: str | os.PathLike[str] | Mapping[str, Gauge] | None = None,
    reference: str | Mapping[str, float] = "undeformed",
    orientation: str | None = None,
    payload: Payload | None = None,
    point: ArrayLike | None = None,
    frame: str = "world",
    level: float = 0.95,
    leave_out_outliers: bool = False,
    closure_tolerance: float = 1e-10,
    **analysis: Unpack[CalibrationLoads],
) -> Calibration:
    """Estimate stiffnesses, payload and offsets from measured deflections, with confidence intervals.

    Args:
        robot: the nominal robot, which gives the initial values.
        measurements: the path of a CSV file, columns by title, rows, or an xarray Dataset. Columns are coordinates of the
            platform or of all actuators; the load Fx … Mz; and readings: components of the twist at o in world axes, dx dy dz drx
            dry drz, or gauges by name. Titles may contain units, "z [mm]"; the default is SI. Empty cells are missing readings.
        unknowns: names of the unknowns. The name of a beam, an elastic joint or an actuator stands for a factor of its stiffness;
            "rod_1+rod_2" is a common factor, and "actuators:slide" the actuator of a joint that is elastic too. Further unknowns
            are arguments of the file; dimensions of parts (see :func:`kinetostatics.tolerances`), such as
            "slide.actuator_stiffness" or "rod_1.outer_diameter"; and assembly errors, such as "hinge.error.rx" or
            "rod_1.error.length", which the returned robot does not have. "payload.mass" is the mass of the payload; "payload.x",
            "payload.y" and "payload.z" are the coordinates of its centre from o in platform axes. "offset.NAME" is the zero
            reading of the gauge NAME; "offsets" stands for the zero readings of all gauges.
        gauges: a :class:`Gauge` by name, or the path of a CSV file of gauges.
        reference: state of zero readings: "undeformed", the robot without weight; "unloaded", the same pose with weight and
            payload, but without load; or coordinates of a single pose without load.
        orientation: convention of the orientation coordinates, see :meth:`Robot.assemble`.
        payload: payload on the platform, with the initial values of unknowns of the payload.
        point, frame: point of application and axes of the load, see :func:`kinetostatics.analyze`; the same for all rows.
        level: confidence level of the intervals.
        leave_out_outliers: whether to repeat the fit without outliers.
        closure_tolerance: largest gap of a closed loop [m, rad], see :meth:`Robot.assemble`.
        analysis: further arguments of :func:`kinetostatics.analyze`: ``gravity``, ``loads``, ….

    Returns:
        Estimates with intervals, unidentifiable unknowns, residuals, outliers, and the robot with the estimates. The fit divides
        each residual by the sigma of its gauge. If no sigma is given, all residuals have equal weights, and sigma is estimated.

    Raises:
        ArgumentError: measurements or unknowns are invalid; messages name file and line.
        KinetostaticsError: SciPy is missing; the message says how to install it.
        AssemblyError: a pose cannot be reached.
        StaticsError: a pose is singular.

    Examples:
        Three poses identify a factor of 0.8 for the stiffness of one rod:

        >>> import kinetostatics as ks
        >>> robot = ks.load_robot("3rps")
        >>> rows = {"z": [0.5, 0.6, 0.5], "rx": [0.0, 0.1, -0.1], "ry": [0.0, 0.0, 0.2], "Fz [kN]": [-2.0, -2.0, -2.0]}
        >>> soft = robot.description.changed("rod_1", youngs_modulus=0.8 * robot.description.beams["rod_1"].youngs_modulus)
        >>> pose = ks.Robot(soft).assemble(platform={name: rows[name] for name in ("z", "rx", "ry")})
        >>> rows["dz"] = ks.analyze(pose, [0, 0, -2000, 0, 0, 0]).twist[:, 2]
        >>> found = ks.calibrate(robot, rows, ["rod_1"])
        >>> round(found.estimates["rod_1"].value, 6)
        0.8
    """
    case = load_case_of(calibrate, CalibrationLoads, analysis, point=point, frame=frame)
    need("calibrate", "optimize", "scipy")
    if not isinstance(level, (int, float)) or not 0 < level < 1:
        raise ArgumentError(f"level is {level!r}; it must be between 0 and 1, such as 0.95")
    check_robot("calibrate", robot, payload)
    all_gauges = read_gauges(gauges)
    table = read_measurements(robot, measurements, all_gauges)
    readings, measured = _readings(table, all_gauges)
    for hint in (*robot.unit_hints(table.coordinates), *table.repeated):
        warn(hint)
    used_gauges = list(readings.gauges.values())
    sigmas = [gauge.sigma for gauge in used_gauges]
    if None in sigmas and (len(set(sigmas)) > 1 or len({gauge.kind for gauge in used_gauges}) > 1):
        name = next(name for name, gauge in readings.gauges.items() if gauge.sigma is None)
        raise ArgumentError(
            f"the gauge {name!r} has no sigma: readings of lengths and of angles, or of better and worse gauges, are "
            "weighted by their standard deviations: gauges={" + repr(name) + ": ks.Gauge(…, sigma=1e-6)}"
        )
    sigma_known = None not in sigmas
    sizes = {name: float(np.sqrt(np.mean(measured[readings.which == k] ** 2))) or 1.0 for k, name in enumerate(readings.gauges)}
    looked_for = Unknowns(robot, unknowns, readings.gauges, payload, sizes)
    model = Model(
        looked_for,
        table.coordinates,
        table.load,
        readings,
        reference,
        orientation,
        case,
        table.places,
        closure_tolerance,
    )
    scale = looked_for.scale
    start = looked_for.start / scale
    sigma = np.array([1.0 if value is None else value for value in sigmas])[readings.which]
    check_predicted(model, start * scale, table.places)

    def solved(used: Mask, start: Array) -> Fit:
        try:
            return fit(
                lambda x: model.predict(x * scale)[used],
                lambda x: model.jacobian(x * scale)[used] * scale,
                start,
                measured[used],
                sigma[used],
                sigma_known,
            )
        except NoDerivativeError as error:
            unknown, value = looked_for.items[error.k], float((error.x * scale)[error.k])
            raise ArgumentError(
                f"the fit of {unknown.name} reached {value:.6g} {unknown.unit}".rstrip()
                + f", and a further change yields no robot: {model.refused or 'it is another mechanism'}; {ADVICE}"
            ) from error

    used = np.full(len(measured), True)
    fitted = solved(used, start)
    size = float(np.sqrt(np.mean((measured / sigma) ** 2)))
    studentized, bad = outliers(fitted, size)
    if leave_out_outliers and np.any(bad):
        used = ~bad
        fitted = solved(used, fitted.x)
        studentized = np.where(bad, studentized, 0.0)
        studentized[used] = outliers(fitted, size)[0]
    values, covariance = fitted.x * scale, fitted.covariance * np.outer(scale, scale)
    computed = model.predict(values)
    of = [list(readings.gauges)[k] for k in readings.which]
    flagged = tuple(
        Outlier(int(table.rows[readings.rows[k]]), of[k], float(measured[k]), float(computed[k]), float(studentized[k]))
        for k in np.flatnonzero(bad)
    )
    errors = np.full(len(measured), np.nan)
    errors[used] = leave_one_out(fitted, readings.rows[used]) * sigma[used]
    estimates = _estimates(looked_for, fitted, values, covariance, level)
    for estimate in estimates:
        if estimate.impossible:
            warn(f"{estimate.name} is estimated as {estimate.value:.6g} {estimate.unit}, and {estimate.impossible}; {ADVICE}")
    mass, moment, _ = looked_for.payload_of(values)
    robot_found = Robot(replace(looked_for.described(values), path=robot.description.path))
    scatter = 1.0 if sigma_known else float(np.sqrt(fitted.variance))
    free = fitted.degrees_of_freedom
    return Calibration(
        ResultMapping({estimate.name: estimate for estimate in estimates}),
        unidentifiable(looked_for.items, fitted.null),
        level,
        frozen(covariance),
        ResultMapping(readings.gauges),
        table.rows[readings.rows],
        tuple(of),
        frozen(measured),
        frozen(computed),
        used,
        frozen(studentized),
        frozen(errors),
        flagged,
        frozen(sigma * scatter),
        sigma_known,
        float(fitted.residuals @ fitted.residuals / free) if sigma_known and free else float("nan"),
        free,
        fitted.converged,
        Payload(mass, tuple((moment / mass).tolist())) if mass else None,
        robot_found,
    )


def check_robot(what: str, robot: object, payload: object) -> None:
    """Raise an ArgumentError unless ``robot`` is a Robot, and ``payload`` is None or one payload on the platform."""
    if not isinstance(robot, Robot):
        raise ArgumentError(f"{what} needs a Robot, got {robot!r}; load one with ks.load_robot(…)")
    if payload is not None and not isinstance(payload, Payload):
        raise ArgumentError(f"payload is {payload!r}; it must be a ks.Payload(mass, center=(x, y, z))")
    if payload is not None and (
        payload.link not in (None, robot.description.platform)
        or finite_numbers("payload: mass", payload.mass).shape
        or finite_numbers("payload: center", payload.center).shape != (3,)
    ):
        raise ArgumentError(
            "the payload of a calibration must be on the platform; give other payloads by loads={link: ks.LinkLoad(…)}"
        )


def check_predicted(model: Model, values: Array, rows: Sequence[str]) -> None:
    """Raise a StaticsError, with the reason, if a reading cannot be computed with the initial values (p,) of the unknowns.

    ``rows``: names of the rows in messages.
    """
    bad = np.flatnonzero(~np.isfinite(model.predict(values)))
    if bad.size:
        result, row = model.result(values), int(model.readings.rows[bad[0]])
        where, pose = (rows[row], row) if np.isnan(result.twist[row, 0]) else ("reference: ", -1)
        try:
            only = taken(result.configuration, np.array([pose]), ())
            analyzed(only, model.case)
        except StaticsError as error:
            raise StaticsError(f"{where}readings cannot be computed: {error}") from error


def _readings(table: Measurements, gauges: Mapping[str, Gauge]) -> tuple[Readings, Array]:
    """Return the readings of all cells that are not empty, row by row, and their values (n,) [m, rad]."""
    names = [name for name, column in table.readings.items() if np.any(np.isfinite(column))]
    every = np.stack([table.readings[name] for name in names], axis=-1)
    rows, which = np.nonzero(np.isfinite(every))
    return Readings(rows, which, {name: gauges[name] for name in names}), every[rows, which]


def _estimates(unknowns: Unknowns, fitted: Fit, values: Array, covariance: Array, level: float) -> list[Estimate]:
    from scipy import stats

    tail, free = (1 - level) / 2, fitted.degrees_of_freedom
    if fitted.sigma_known:
        wide = float(stats.norm.isf(tail))
    else:
        wide = float(stats.t.isf(tail, free)) if free > 0 else np.inf
    estimates = []
    reported, factors = unknowns.reported(values)
    starts, _ = unknowns.reported(unknowns.start)
    errors = np.sqrt(np.diag(factors @ covariance @ factors.T))
    determined = identifiable_ones(fitted.null).tolist()
    for k, unknown in enumerate(unknowns.items):
        is_determined = determined[k]
        error = float(errors[k]) if is_determined and np.isfinite(errors[k]) else np.inf
        value, start = float(reported[k]), float(starts[k])
        ends = [value + sign * (wide * error if error > 0 else 0.0) for sign in (-1, 1)]
        if unknown.kind == "stiffness":
            reach = wide * error * values[k] ** 2 if error > 0 else 0.0
            ends = [1 / (values[k] + reach), 1 / (values[k] - reach) if values[k] > reach else np.inf]
        interval = float(ends[0]), float(ends[1])
        estimates.append(Estimate(unknown.name, unknown.kind, value, unknown.unit, start, interval, error, is_determined))
    return estimates
