"""Reports of calibrations and of measurement plans."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from kinetostatics.layout.blocks import Number, ReportSection, Table, Text
from kinetostatics.layout.numbers import ANGLES, LENGTHS, MISSING, NOISE, UNITS_OF, in_unit, quantity
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.reports.pose import count
from kinetostatics.results.calibration import Calibration, Estimate, MeasurementPlan, Unidentifiable

#: Units of readings.
UNITS_BY_KIND = {"length": LENGTHS, "angle": ANGLES}
#: Ratio of an estimated stiffness to that in the file, from which on the part is called rigid.
RIGID = 1e5
#: Ratio of residuals to readings, and factor between estimated stiffness and that in the file, beyond which there is a warning.
UNEXPLAINED, ODD = 0.9, 100.0
#: Largest number of outliers in a report.
MOST = 12


def _estimate(estimate: Estimate, value: float) -> str:
    """Write ``value``, a value of the unknown or an end of its confidence interval, with its unit."""
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if estimate.kind == "stiffness":
        return f"× {value:.5g}" if value < RIGID else "rigid"
    if estimate.kind != "argument" and estimate.unit in ("m", "rad"):
        return quantity(value, UNITS_OF[estimate.unit], digits=4)
    return in_unit(value, estimate.unit)


def calibration_report(calibration: Calibration) -> Report:
    title = f"Calibration of {calibration.robot.name!r} from {count(len(calibration.measured), 'reading')} of "
    title += count(len(set(calibration.rows.tolist())), "row")
    title += f"; {len(calibration.unidentifiable)} not determined" if calibration.unidentifiable else ""
    title += f"; {count(len(calibration.outliers), 'outlier')}" if calibration.outliers else ""
    names = "estimates unidentifiable level sigma_known reduced_chi_square degrees_of_freedom converged outliers rows gauge_of "
    names += "measured computed used"
    data = {"general": "SI: m, rad, kg; a stiffness is a factor of the file's; null: infinite or unknown"}
    return Report(
        title,
        lambda: _sections(calibration),
        lambda: {
            "robot": calibration.robot.name,
            "units": data,
            **attributes(calibration, (*names.split(), "studentized", "leave_one_out", "sigma", "covariance", "gauges")),
        },
    )


def _sections(fit: Calibration) -> list[ReportSection]:
    rows = []
    for estimate in fit.estimates.values():
        low, high = estimate.interval
        interval = f"{_estimate(estimate, low)} to {_estimate(estimate, high)}" if estimate.identified else MISSING
        rows.append((estimate.name, _estimate(estimate, estimate.start), _estimate(estimate, estimate.value), interval))
    fits = []
    for kind, units in UNITS_BY_KIND.items():
        residual, predicted = (fit.root_mean_square(errors, kind) for errors in (fit.residuals, fit.leave_one_out))
        if math.isfinite(residual):
            size = fit.root_mean_square(fit.measured, kind)
            values = (size, residual, predicted)
            cells = [Number.of(value, units, NOISE * size, digits=4) if math.isfinite(value) else MISSING for value in values]
            fits.append((f"readings of {kind}s", *cells))
    header = ("root mean square", "readings", "residuals", "predicted from the other rows")
    outliers = [Text(_outlier(fit, k), "warning") for k in range(min(len(fit.outliers), MOST))]
    if len(fit.outliers) > MOST:
        outliers.append(Text(f"and {len(fit.outliers) - MOST} more outliers", "warning"))
    title = f"Estimates; a stiffness as a factor of the file's (intervals: {100 * fit.level:.4g} %)"
    return [
        ReportSection(title, [Table.of_rows(("unknown", "file", "estimate", "interval"), rows, "lrrl")], "estimates"),
        _not_determined(fit.unidentifiable, "other values of these unknowns fit equally well"),
        ReportSection("Measured less computed", [Table.of_rows(header, fits)], "residuals"),
        ReportSection("", [*map(Text, _sentences(fit)), *outliers]),
    ]


def _outlier(fit: Calibration, k: int) -> str:
    outlier = fit.outliers[k]
    units = UNITS_BY_KIND[fit.gauges[outlier.gauge].kind]
    measured, computed = quantity(outlier.measured, units), quantity(outlier.computed, units)
    left = "" if not np.all(fit.used) else "; check it or leave it out"
    off = f"{abs(outlier.studentized):.3g} times its standard deviation off{left}"
    return f"outlier: row {outlier.row}, {outlier.gauge}: measured {measured}, computed {computed}, {off}"


def _not_determined(combinations: Sequence[Unidentifiable], end: str) -> ReportSection:
    texts = [Text(f"{combination.words}.", "warning") for combination in combinations]
    return ReportSection(
        "Unidentifiable from these readings", [*texts, Text(f"({end})", indent=2)] if combinations else [], "unidentifiable"
    )


def _sentences(fit: Calibration) -> list[str]:
    sentences = []
    freedom = f"{fit.degrees_of_freedom} degrees of freedom"
    if fit.sigma_known:
        sentences.append(f"Reduced chi-square: {fit.reduced_chi_square:.3g} ({freedom}); about 1 if model and sigma are right.")
    elif fit.degrees_of_freedom > 0:
        kind = next(iter(fit.gauges.values())).kind
        words = quantity(fit.sigma[0], UNITS_BY_KIND[kind], digits=3)
        sentences.append(f"Standard deviation of a reading, from the residuals: {words} ({freedom}).")
    else:
        sentences.append("There are no more readings than unknowns: the standard errors are unknown; measure more.")
    sentences += [
        f"{estimate.name} is not possible: {estimate.impossible}." for estimate in fit.estimates.values() if estimate.impossible
    ]
    left = int(np.sum(~fit.used))
    if left:
        sentences.append(f"{left} outlier{'s were' if left > 1 else ' was'} left out.")
    if not fit.converged:
        sentences.append("The fit did not converge: the estimates are those of its last step.")
    sentences += [f"{estimate.name}: at this level the readings are consistent with a rigid part." for estimate in _rigid(fit)]
    sizes = [[fit.root_mean_square(of, kind) for of in (fit.residuals, fit.measured)] for kind in ("length", "angle")]
    if not any(residual <= UNEXPLAINED * size for residual, size in sizes):
        sentences.append(
            "The residuals are almost as large as the readings: check the signs of readings, and points and frames of gauges."
        )
    for estimate in fit.estimates.values():
        if estimate.kind == "stiffness" and estimate.identified and (estimate.value < 1 / ODD or ODD < estimate.value < RIGID):
            sentences.append(
                f"{estimate.name}: differs from the file by a factor of more than {ODD:.0f}: "
                "check the units of readings and loads."
            )
    return sentences


def _rigid(fit: Calibration) -> list[Estimate]:
    return [
        estimate
        for estimate in fit.estimates.values()
        if estimate.kind == "stiffness" and math.isfinite(estimate.standard_error) and math.isinf(estimate.interval[1])
    ]


def plan_report(plan: MeasurementPlan) -> Report:
    title = f"Plan of {count(len(plan.chosen), 'measurement')} of {plan.robot.name!r} out of {plan.candidates} poses with loads"
    names = "coordinates load gauges standard_errors random_standard_errors gain candidates left_out chosen unidentifiable"
    return Report(title, lambda: _plan_sections(plan), lambda: {"robot": plan.robot.name, **attributes(plan, names.split())})


def _plan_sections(plan: MeasurementPlan) -> list[ReportSection]:
    left = Text(f"({plan.left_out} more are out of reach, singular or beyond a joint's limit)")
    numbers = np.flatnonzero(np.any(plan.load, axis=0)).tolist()
    columns = dict(plan.coordinates.items())
    columns |= {WRENCH_COMPONENTS[k]: plan.load[:, k] for k in numbers}
    rows = [(str(k + 1), *(f"{values[k]:.5g}" for values in columns.values())) for k in range(len(plan.chosen))]
    cells = [(name, f"{error:.3g}", f"{plan.random_standard_errors[name]:.3g}") for name, error in plan.standard_errors.items()]
    gain = (
        f"Standard errors {plan.gain:.3g} times smaller than those of random plans, on average."
        if math.isfinite(plan.gain)
        else "No random plan determines the unknowns."
    )
    title = f"Measurements [m, rad, N, N·m]; read {', '.join(plan.gauges)} at each"
    errors = "Expected standard errors (SI; relative for a stiffness)"
    return [
        ReportSection(None, [left] if plan.left_out else []),
        ReportSection(title, [Table.of_rows(("", *columns), rows, "r" * (1 + len(columns)))], "measurements"),
        ReportSection(errors, [Table.of_rows(("unknown", "this plan", "random plans"), cells)], "errors"),
        _not_determined(plan.unidentifiable, "no reading at any candidate depends on it"),
        ReportSection("", [Text(gain)]),
    ]
