"""What a person reads of a calibration and of a plan of measurements: ``print`` and ``kinetostatics calibrate``."""

from __future__ import annotations

import math

import numpy as np

from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import ANGLES, LENGTHS, MISSING, UNITS_OF, as_told, quantity, section, table, wrapped
from kinetostatics.reports.json import named
from kinetostatics.results.calibration import Calibration, Estimate, MeasurementPlan, Unidentifiable

#: Units of readings.
UNITS_BY_KIND = {"length": LENGTHS, "angle": ANGLES}
#: Factor of a stiffness from which on a part is called rigid.
RIGID = 1e5
#: Part of the readings from which on residuals are nearly all of them, and a factor of stiffness that is hardly one.
UNEXPLAINED, ODD = 0.9, 100.0
#: Outliers and measurements that are listed, at most.
MOST = 12


def estimate_words(item: Estimate, value: float) -> str:
    """Write a value of an unknown, or an end of its interval."""
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if item.kind == "stiffness":
        return f"× {value:.5g}" if value < RIGID else "rigid"
    if item.kind != "argument" and item.unit in ("m", "rad"):
        return quantity(value, UNITS_OF[item.unit], digits=4)
    return as_told(value, item.unit)


def interval_words(item: Estimate) -> str:
    """Write the interval of an unknown; a dash where the readings do not determine it."""
    return f"{estimate_words(item, item.interval[0])} to {estimate_words(item, item.interval[1])}" if item.identified else MISSING


@text_of.register(Calibration)
def calibration_report(found: Calibration) -> str:
    """Return estimates with intervals, what cannot be told, how well readings fit, and which do not."""
    count = len(found.measured)
    lines = [f"Calibration of {found.robot.name!r} from {count} readings of {len(set(found.rows.tolist()))} rows"]
    rows = [
        (item.name, estimate_words(item, item.start), estimate_words(item, item.value), interval_words(item))
        for item in found.estimates.values()
    ]
    title = f"Estimates; a stiffness as a factor of the file's (intervals: {100 * found.level:.4g} %)"
    lines += section(title, table(("unknown", "file", "estimate", "interval"), rows, "lrrl"))
    lines += _not_told(found.unidentifiable, "what stands above for these is one of many values that fit equally well")
    fits = []
    for kind, units in UNITS_BY_KIND.items():
        residual, foretold = (found.root_mean_square(errors, kind) for errors in (found.residuals, found.held_out))
        if math.isfinite(residual):
            size = quantity(found.root_mean_square(found.measured, kind), units, digits=4)
            ahead = quantity(foretold, units, digits=4) if math.isfinite(foretold) else MISSING
            fits.append((f"readings of {kind}s", size, quantity(residual, units, digits=4), ahead))
    header = ("root mean square", "readings", "residuals", "foretold from the other rows")
    lines += section("Measured less computed", table(header, fits))
    lines += ["", *(line for text in _sentences(found) for line in wrapped(text))]
    for item in found.outliers[:MOST]:
        units = UNITS_BY_KIND[found.gauges[item.gauge].kind]
        left = "" if not np.all(found.used) else "; look at it, or leave it out"
        said = f"outlier: row {item.row}, {item.gauge}: measured {quantity(item.measured, units)}, computed "
        lines += wrapped(
            f"{said}{quantity(item.computed, units)}, {abs(item.studentized):.3g} times its standard deviation off{left}", "! "
        )
    if len(found.outliers) > MOST:
        lines.append(f"! and {len(found.outliers) - MOST} more outliers")
    return "\n".join(lines)


def _not_told(items: tuple[Unidentifiable, ...], end: str) -> list[str]:
    if not items:
        return []
    lines = [line for item in items for line in wrapped(f"{item.words}.", "! ", 106)]
    return section("What these readings cannot tell", [*lines, *wrapped(f"({end})", "  ", 106)])


def _sentences(found: Calibration) -> list[str]:
    said = []
    freedom = f"{found.freedom} readings more than unknowns that they determine"
    if found.sigma_known:
        said.append(
            f"Weighted squares per degree of freedom: {found.misfit:.3g} ({freedom}); about 1 if model and sigma are right."
        )
    elif found.freedom > 0:
        kind = next(iter(found.gauges.values())).kind
        words = quantity(found.sigma[0], UNITS_BY_KIND[kind], digits=3)
        said.append(f"Standard deviation of a reading, from the residuals: {words} ({freedom}).")
    else:
        said.append("There are no more readings than unknowns, so that nothing tells how sure the estimates are: measure more.")
    said += [f"{item.name} is not possible: {item.impossible}." for item in found.estimates.values() if item.impossible]
    left = int(np.sum(~found.used))
    if left:
        said.append(f"{left} outlier{'s were' if left > 1 else ' was'} left out.")
    if not found.converged:
        said.append("The search did not come to an end: the estimates are where it stopped.")
    said += [f"{item.name}: at this level the readings do not tell it from a rigid part." for item in _rigid(found)]
    sizes = [[found.root_mean_square(of, kind) for of in (found.residuals, found.measured)] for kind in ("length", "angle")]
    if not any(residual <= UNEXPLAINED * size for residual, size in sizes):
        said.append(
            "What was found explains hardly anything of the readings: look at their signs, and at points and frames of gauges."
        )
    for item in found.estimates.values():
        if item.kind == "stiffness" and item.identified and (item.value < 1 / ODD or ODD < item.value < RIGID):
            said.append(
                f"{item.name}: more than {ODD:.0f} times off what the file says: look at the units of readings and loads."
            )
    return said


def _rigid(found: Calibration) -> list[Estimate]:
    return [
        item
        for item in found.estimates.values()
        if item.kind == "stiffness" and math.isfinite(item.standard_error) and math.isinf(item.interval[1])
    ]


@text_of.register(MeasurementPlan)
def plan_report(found: MeasurementPlan) -> str:
    """Return where to measure, and how sure the unknowns will be."""
    count = len(found.chosen)
    lines = [f"Plan of {count} measurements of {found.robot.name!r} out of {found.candidates} poses with loads"]
    if found.left_out:
        lines.append(f"({found.left_out} more are out of reach, singular or beyond a joint's limit)")
    numbers = np.flatnonzero(np.any(found.load, axis=0)).tolist()
    loads = [WRENCH_COMPONENTS[k] for k in numbers]
    rows = [
        (
            str(k + 1),
            *(f"{values[k]:.5g}" for values in found.coordinates.values()),
            *(f"{found.load[k, j]:.5g}" for j in numbers),
        )
        for k in range(count)
    ]
    title = f"Measurements [m, rad, N, N·m]; read {', '.join(found.gauges)} at each"
    lines += section(title, table(("", *found.coordinates, *loads), rows, "r" * (1 + len(found.coordinates) + len(loads))))
    cells = [(name, f"{error:.3g}", f"{found.random_standard_errors[name]:.3g}") for name, error in found.standard_errors.items()]
    lines += section(
        "Standard errors to be expected (SI; of a stiffness relative)", table(("unknown", "this plan", "random plans"), cells)
    )
    lines += _not_told(found.unidentifiable, "no pose and load among the candidates tells it")
    gain = (
        f"{found.gain:.3g} times as sure as random plans in the mean."
        if math.isfinite(found.gain)
        else "No random plan determines the unknowns."
    )
    return "\n".join([*lines, "", gain])


@dict_of.register(Calibration)
def calibration_to_dict(found: Calibration) -> dict[str, object]:
    """Return a calibration as plain values: what ``calibrate --json`` prints."""
    names = "estimates unidentifiable level sigma_known misfit freedom converged outliers rows gauge_of measured computed used"
    return {
        "robot": found.robot.name,
        "units": {"general": "SI: m, rad, kg; a stiffness is a factor of the file's; null: infinite, or not known"},
        **named(found, (*names.split(), "studentized", "held_out", "sigma", "covariance", "gauges")),
    }


@dict_of.register(MeasurementPlan)
def plan_to_dict(found: MeasurementPlan) -> dict[str, object]:
    """Return a plan as plain values: what ``calibrate --plan --json`` prints."""
    names = "coordinates load gauges standard_errors random_standard_errors gain candidates left_out chosen unidentifiable"
    return {"robot": found.robot.name, **named(found, names.split())}
