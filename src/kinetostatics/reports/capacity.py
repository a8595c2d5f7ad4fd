"""Report of a capacity: the largest load, the limit that it reaches, and safety factors against the other limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.layout.blocks import Column, Facts, Number, ReportSection, Table, warning_section
from kinetostatics.layout.numbers import FORCES, MASSES, NumberFormat, vector
from kinetostatics.layout.report import Report, attributes
from kinetostatics.reports.pose import pose_facts, status_names
from kinetostatics.results.capacity import Capacity

UNITS = {
    "load": "N, kg, or a factor of the given wrench, see `unit`",
    "direction": "wrench of load 1 about o, world axes [N, N·m]",
}

#: Words without a limit: for loads that are not all infinite, and for loads that are.
NOTHING = {False: "unknown", True: "nothing limits the load"}


def capacity_report(capacity: Capacity) -> Report:
    units = {"N": FORCES, "kg": MASSES, "1": (("times", 1.0),)}[capacity.unit]
    what = {"N": "a force at o in any direction, up to", "kg": "a mass of up to", "1": "up to"}[capacity.unit]
    limits = ", ".join(dict.fromkeys(str(name) for name in np.ravel(capacity.limited_by) if name))
    wrench = " the given wrench" if capacity.unit == "1" else ""
    words = (
        f"{what} {Number.range_of(capacity.load, units)}{wrench}, limited by {limits}"
        if limits
        else NOTHING[bool(np.all(np.isinf(capacity.load)))]
    )
    title = f"Capacity of {capacity.configuration.robot.name!r}: {words}"
    return Report(title, lambda: _sections(capacity), lambda: _data(capacity))


def _sections(capacity: Capacity) -> Iterator[ReportSection]:
    if capacity.shape == ():
        yield ReportSection("Pose", [pose_facts(capacity.configuration, capacity.result.gravity, capacity.result.load)], "pose")
        if capacity.direction is not None and capacity.unit == "N":
            direction = vector(capacity.direction[:3], NumberFormat.of(capacity.direction[:3], (("", 1.0),), 1e-6))
            yield ReportSection("Worst direction", [Facts([("force along", direction)])], "direction")
        factors = capacity.result.margins.safety_factors
        table = Table(
            [Column("limit", list(factors)), Column("safety factor", [f"{value:.4g}" for value in factors.values()], "r")]
        )
        yield ReportSection("Safety factors under the largest load", [table], "margins")
    yield warning_section(capacity.warnings if capacity.load.size else ())


def _data(capacity: Capacity) -> dict[str, object]:
    return {
        "robot": capacity.configuration.robot.name,
        "units": UNITS,
        "status": status_names(capacity.result.status),
        **attributes(capacity, ("load", "unit", "limited_by", "direction", "warnings")),
        "safety_factors": capacity.result.margins.safety_factors,
    }
