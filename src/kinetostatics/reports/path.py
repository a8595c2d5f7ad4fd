"""Report of the analysis of a trajectory: peaks with their times; force, velocity and power of the actuators."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.layout.blocks import Cell, Number, ReportSection, Table, warning_section
from kinetostatics.layout.numbers import UNITS_OF, NumberFormat, Units
from kinetostatics.layout.report import Report, attributes
from kinetostatics.reports.pose import state_title, status_names
from kinetostatics.results.path import OVER_TIME, PathResult
from kinetostatics.status import WITHOUT_NUMBERS

SECONDS: Units = (("s", 1.0),)
#: Units to choose from for quantities over time.
_UNITS: dict[str, Units] = {**UNITS_OF, **{unit: ((unit, 1.0),) for unit in ("m/s", "rad/s", "W")}}
UNITS = {
    "general": "SI: s, m, rad, N, N·m, Pa, W; world axes; arrays over time, last axes as in Result; null: no number",
    "actuator_velocities": "m/s, of turning joints rad/s; actuator_forces: N, of turning joints N·m",
    "peaks": "the value of the largest magnitude and its time, by quantity and name",
}


def path_report(path: PathResult) -> Report:
    """Return the report of the analysis of a trajectory."""
    title = [f"Path of {path.result.robot.name!r} in {np.ptp(path.times):.4g} s: ", *state_title(path.result)]
    return Report(title, lambda: list(_sections(path)), lambda: _data(path))


def _sections(path: PathResult) -> Iterator[ReportSection]:
    result = path.result
    if not np.all(np.isin(result.status, WITHOUT_NUMBERS)):
        shown = ("displacement", "rotation", "stress", "joint_force", "joint_moment")
        rows = [row for what in shown for row in _largest(path, what)]
        yield ReportSection("Peaks", [Table.of_rows(("quantity", "largest", "of", "at"), rows, "lrlr")], "peaks")
        if result.actuator_forces:
            yield ReportSection("Actuators", [_actuators(path)], "actuators")
        for what in ("stress", "joint_force", "joint_moment"):
            if rows := _largest(path, what, every=True):
                table = Table.of_rows(("", "largest", "at"), [(of, value, at) for _, value, of, at in rows], "lrr")
                yield ReportSection(f"Peaks of the {OVER_TIME[what].words}", [table], what, detail=True)
    yield warning_section(result.warnings)


def _largest(path: PathResult, what: str, every: bool = False) -> list[tuple[str, Number, str, Number]]:
    """Return description, value, name and time of the largest peak of a quantity, or of ``every`` peak above noise."""
    peaks, entry = path.peaks(what), OVER_TIME[what]
    form = NumberFormat.of([peak.value for peak in peaks.values()], _UNITS[entry.unit])
    names = [name for name in peaks if every and abs(peaks[name].value) > form.noise]
    names = names if every else sorted(peaks, key=lambda name: -abs(peaks[name].value))[:1]
    words = entry.words.format(point=path.result.point_name)
    return [
        (words, Number(peaks[name].value, form), "" if name == path.result.point_name else name, _time(path, peaks[name].time))
        for name in names
    ]


def _time(path: PathResult, time: float) -> Number:
    return Number(time, NumberFormat.of(path.times, SECONDS, digits=4))


def _actuators(path: PathResult) -> Table:
    """Return force, velocity and power of each actuator."""
    rows: list[tuple[Cell, ...]] = []
    for force, speed in (("actuator_force", "actuator_speed"), ("actuator_torque", "actuator_rate")):
        powers, speeds, rms = path.peaks("actuator_power"), path.peaks(speed), path.root_mean_square(force)
        for name, peak in path.peaks(force).items():
            form = NumberFormat.of(peak.value, _UNITS[OVER_TIME[force].unit])
            others = ((speeds[name].value, OVER_TIME[speed].unit), (powers[name].value, "W"))
            found = (Number.of(value, _UNITS[unit]) for value, unit in others)
            rows.append((name, Number(peak.value, form), _time(path, peak.time), Number(rms[name], form), *found))
    header = ("actuator", "largest force", "at", "root mean square", "largest velocity", "largest power")
    return Table.of_rows(header, rows, "lrrrrr")


def _data(path: PathResult) -> dict[str, object]:
    result = path.result
    return {
        "robot": result.robot.name,
        "units": UNITS,
        "status": status_names(result.status),
        "warnings": result.warnings,
        "orientation": result.configuration.orientation.name,
        **attributes(path, ("times", "actuator_velocities")),
        **attributes(result.configuration, ("platform", "actuators")),
        **attributes(result, ("twist", "contributions", "actuator_forces", "joint_wrenches")),
        "stress": path.over_time("stress"),
        "peaks": {what: {n: {"value": p.value, "time": p.time} for n, p in path.peaks(what).items()} for what in OVER_TIME},
    }
