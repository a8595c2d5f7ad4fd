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


def _estimate(item: Estimate, value: float) -> str:
    """Write ``value``, a value of the unknown or an end of its confidence interval, with its unit."""
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if item.kind == "stiffness":
        return f"× {value:.5g}" if value < RIGID else "rigid"
    if item.kind != "argument" and item.unit in ("m", "rad"):
        return quantity(value, UNITS_OF[item.unit], digits=4)
    return in_unit(value, item.unit)


def calibration_report(found: Calibration) -> Report:
    title = f"Calibration of {found.robot.name!r} from {count(len(found.measured), 'reading')} of "
    title += count(len(set(found.rows.tolist())), "row")
    title += f"; {len(found.unidentifiable)} not determined" if found.unidentifiable else ""
    title += f"; {count(len(found.outliers), 'outlier')}" if found.outliers else ""
    names = "estimates unidentifiable level sigma_known reduced_chi_square degrees_of_freedom converged outliers rows gauge_of "
    names += "measured computed used"
    data = {"general": "SI: m, rad, kg; a stiffness is a factor of the file's; null: infinite or unknown"}
    return Report(
        title,
        lambda: _sections(found),
        lambda: {
            "robot": found.robot.name,
            "units": data,
            **attributes(found, (*names.split(), "studentized", "leave_one_out", "sigma", "covariance", "gauges")),
        },
    )


def _sections(found: Calibration) -> list[ReportSection]:
    rows = []
    for item in found.estimates.values():
        low, high = item.interval
        interval = f"{_estimate(item, low)} to {_estimate(item, high)}" if item.identified else MISSING
        rows.append((item.name, _estimate(item, item.start), _estimate(item, item.value), interval))
    fits = []
    for kind, units in UNITS_BY_KIND.items():
        residual, predicted = (found.root_mean_square(errors, kind) for errors in (found.residuals, found.leave_one_out))
        if math.isfinite(residual):
            size = found.root_mean_square(found.measured, kind)
            values = (size, residual, predicted)
            cells = [Number.of(value, units, NOISE * size, digits=4) if math.isfinite(value) else MISSING for value in values]
            fits.append((f"readings of {kind}s", *cells))
    header = ("root mean square", "readings", "residuals", "predicted from the other rows")
    outliers = [Text(_outlier(found, k), "warning") for k in range(min(len(found.outliers), MOST))]
    if len(found.outliers) > MOST:
        outliers.append(Text(f"and {len(found.outliers) - MOST} more outliers", "warning"))
    title = f"Estimates; a stiffness as a factor of the file's (intervals: {100 * found.level:.4g} %)"
    return [
        ReportSection(title, [Table.of_rows(("unknown", "file", "estimate", "interval"), rows, "lrrl")], "estimates"),
        _not_determined(found.unidentifiable, "other values of these unknowns fit equally well"),
        ReportSection("Measured less computed", [Table.of_rows(header, fits)], "residuals"),
        ReportSection("", [*map(Text, _sentences(found)), *outliers]),
    ]


def _outlier(found: Calibration, k: int) -> str:
    item = found.outliers[k]
    units = UNITS_BY_KIND[found.gauges[item.gauge].kind]
    measured, computed = quantity(item.measured, units), quantity(item.computed, units)
    left = "" if not np.all(found.used) else "; check it or leave it out"
    off = f"{abs(item.studentized):.3g} times its standard deviation off{left}"
    return f"outlier: row {item.row}, {item.gauge}: measured {measured}, computed {computed}, {off}"


def _not_determined(items: Sequence[Unidentifiable], end: str) -> ReportSection:
    texts = [Text(f"{item.words}.", "warning") for item in items]
    return ReportSection(
        "Unidentifiable from these readings", [*texts, Text(f"({end})", indent=2)] if items else [], "unidentifiable"
    )


def _sentences(found: Calibration) -> list[str]:
    sentences = []
    freedom = f"{found.degrees_of_freedom} degrees of freedom"
    if found.sigma_known:
        sentences.append(f"Reduced chi-square: {found.reduced_chi_square:.3g} ({freedom}); about 1 if model and sigma are right.")
    elif found.degrees_of_freedom > 0:
        kind = next(iter(found.gauges.values())).kind
        words = quantity(found.sigma[0], UNITS_BY_KIND[kind], digits=3)
        sentences.append(f"Standard deviation of a reading, from the residuals: {words} ({freedom}).")
    else:
        sentences.append("There are no more readings than unknowns: the standard errors are unknown; measure more.")
    sentences += [f"{item.name} is not possible: {item.impossible}." for item in found.estimates.values() if item.impossible]
    left = int(np.sum(~found.used))
    if left:
        sentences.append(f"{left} outlier{'s were' if left > 1 else ' was'} left out.")
    if not found.converged:
        sentences.append("The fit did not converge: the estimates are those of its last step.")
    sentences += [f"{item.name}: at this level the readings are consistent with a rigid part." for item in _rigid(found)]
    sizes = [[found.root_mean_square(of, kind) for of in (found.residuals, found.measured)] for kind in ("length", "angle")]
    if not any(residual <= UNEXPLAINED * size for residual, size in sizes):
        sentences.append(
            "The residuals are almost as large as the readings: check the signs of readings, and points and frames of gauges."
        )
    for item in found.estimates.values():
        if item.kind == "stiffness" and item.identified and (item.value < 1 / ODD or ODD < item.value < RIGID):
            sentences.append(
                f"{item.name}: differs from the file by a factor of more than {ODD:.0f}: check the units of readings and loads."
            )
    return sentences


def _rigid(found: Calibration) -> list[Estimate]:
    return [
        item
        for item in found.estimates.values()
        if item.kind == "stiffness" and math.isfinite(item.standard_error) and math.isinf(item.interval[1])
    ]


def plan_report(found: MeasurementPlan) -> Report:
    title = (
        f"Plan of {count(len(found.chosen), 'measurement')} of {found.robot.name!r} out of {found.candidates} poses with loads"
    )
    names = "coordinates load gauges standard_errors random_standard_errors gain candidates left_out chosen unidentifiable"
    return Report(title, lambda: _plan_sections(found), lambda: {"robot": found.robot.name, **attributes(found, names.split())})


def _plan_sections(found: MeasurementPlan) -> list[ReportSection]:
    left = Text(f"({found.left_out} more are out of reach, singular or beyond a joint's limit)")
    numbers = np.flatnonzero(np.any(found.load, axis=0)).tolist()
    columns = {name: values for name, values in found.coordinates.items()}
    columns |= {WRENCH_COMPONENTS[k]: found.load[:, k] for k in numbers}
    rows = [(str(k + 1), *(f"{values[k]:.5g}" for values in columns.values())) for k in range(len(found.chosen))]
    cells = [(name, f"{error:.3g}", f"{found.random_standard_errors[name]:.3g}") for name, error in found.standard_errors.items()]
    gain = (
        f"Standard errors {found.gain:.3g} times smaller than those of random plans, on average."
        if math.isfinite(found.gain)
        else "No random plan determines the unknowns."
    )
    title = f"Measurements [m, rad, N, N·m]; read {', '.join(found.gauges)} at each"
    errors = "Expected standard errors (SI; relative for a stiffness)"
    return [
        ReportSection(None, [left] if found.left_out else []),
        ReportSection(title, [Table.of_rows(("", *columns), rows, "r" * (1 + len(columns)))], "measurements"),
        ReportSection(errors, [Table.of_rows(("unknown", "this plan", "random plans"), cells)], "errors"),
        _not_determined(found.unidentifiable, "no reading at any candidate depends on it"),
        ReportSection("", [Text(gain)]),
    ]
