"""Report of a compensation: corrections of the actuators, forces to feed forward, and pose errors without and with correction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.layout.blocks import Block, Cell, Column, Number, ReportSection, Table, Text, warning_section
from kinetostatics.layout.numbers import (
    ANGLES,
    DEGREES,
    LENGTHS,
    MILLIMETRES,
    NOISE,
    UNITS_OF,
    NumberFormat,
    join_words,
    largest,
    quantity,
)
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.reports.pose import actuator_unit, pose_facts, state_title, status_names, status_word
from kinetostatics.reports.result import units_at
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.pose_arrays import point_name
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

#: Pose errors [m, rad] that count as rounding.
ROUNDING = 1e-12

#: Units and meaning of the numbers.
UNITS = {
    "general": "SI: m, rad, N, N·m; world axes; null: no correction was found",
    "actuators": "corrected coordinates of the actuators [m, rad]; corrections: less those at the target pose",
    "actuator_forces": "N, of turning joints N·m, positive along the joint's positive direction, at the corrected pose",
    "uncorrected_error": "pose error of the loaded platform without correction: displacement at o [m], rotation [rad]",
    "residual_error": "pose error at the corrected actuators",
    "residual_error_coordinates": "residual_error in coordinates of the platform [m, rad]; uncorrected_error_coordinates alike",
    "uncorrectable_directions": "columns: twists that the actuators cannot produce, at o, orthonormal with lengths by "
    "characteristic_length [m, rad]; uncorrectable_parts: component of residual_error along each",
    "commanded": "coordinates of the unloaded platform at the corrected actuators [m, rad]",
}


def compensation_report(compensation: Compensation) -> Report:
    sizes = [np.linalg.norm(error[..., :3], axis=-1) for error in (compensation.uncorrected_error, compensation.residual_error)]
    before, after = (Number.range_of(size, LENGTHS, ROUNDING) for size in sizes)
    title = [f"Compensation of {compensation.target.robot.name!r}: "]
    if compensation.shape == ():
        title.append(status_word(Status(int(compensation.status))))
    else:
        title += state_title(compensation.result)
    if not np.all(np.isin(compensation.status, WITHOUT_NUMBERS)):
        title.append(f"; {point_name(compensation.tool)} is off by {before} uncorrected, by {after} corrected")
    sections = _one if compensation.shape == () else _batch
    return Report(title, lambda: [*sections(compensation), warning_section(compensation.warnings)], lambda: _data(compensation))


def _one(compensation: Compensation) -> Iterator[ReportSection]:
    status = Status(int(compensation.status))
    if status == Status.UNREACHABLE:
        yield ReportSection(
            None, [Text(", no actuator positions bring the loaded platform to the target pose", lead=status_word(status))]
        )
    elif status != Status.OK:
        words = {**STATUS_WORDS, **{fact.status: fact.words for fact in FACTS.values() if fact.status is not None}}
        yield ReportSection(None, [Text(f", {words[status]}", lead=status_word(status))])
    pose = pose_facts(compensation.target, compensation.uncorrected.gravity, compensation.uncorrected.load)
    yield ReportSection("Target pose of the loaded platform", [pose], "pose")
    if status in WITHOUT_NUMBERS:
        return
    yield ReportSection("Actuators", [_actuators(compensation)], "actuators")
    of, what = "", "the loaded platform"
    if compensation.tool is not None:
        of, what = " of the tool's tip", point_name(compensation.tool)
    yield ReportSection(f"Pose error of {what}, world axes", [_errors(compensation)], "errors")
    remaining = [name for name in compensation.residual_error_coordinates if name not in compensation.controlled]
    left = f"Not corrected (too few actuators): {join_words(remaining)}." if remaining else "No error remains."
    yield ReportSection("", [Text(f"Corrected: {join_words(compensation.controlled)}{of}. {left}")])
    yield from _uncorrectable(compensation)
    if compensation.tool is not None and {"x", "y", "z"} & set(remaining) and len(compensation.controlled) >= 3:
        yield ReportSection("", [Text("With controlled x, y and z the tip reaches its target, as far as the actuators allow.")])


def _actuators(compensation: Compensation) -> Table:
    connections = compensation.target.robot.mechanism.connections
    noise = NOISE * largest(compensation.actuator_forces.values())
    rows: list[tuple[Cell, ...]] = []
    for name in compensation.actuators:
        kind = connections[name].type
        form = NumberFormat(*(MILLIMETRES if kind.is_slide else DEGREES)[0], 6, 0.0)
        places = (compensation.target.actuators[name], compensation.actuators[name])
        shift = Number.of(compensation.corrections[name], UNITS_OF[kind.unit], ROUNDING)
        force = Number.of(compensation.actuator_forces[name], UNITS_OF[kind.force_unit], noise)
        rows.append((name, *(Number(float(place), form) for place in places), shift, force))
    return Table.of_rows(("actuator", "at the target pose", "corrected", "correction", "force to feed forward"), rows)


def _errors(compensation: Compensation) -> Table:
    columns = [Column("", ["uncorrected", "corrected"])]
    for k, name in enumerate(COMPONENTS):
        some = compensation.uncorrected_error[3 * (k // 3) : 3 * (k // 3) + 3]
        form = NumberFormat.of(some, LENGTHS if k < 3 else ANGLES, ROUNDING)
        columns.append(Column.of(name, [compensation.uncorrected_error[k], compensation.residual_error[k]], form))
    return Table(columns)


def _uncorrectable(compensation: Compensation) -> Iterator[ReportSection]:
    length = compensation.target.robot.length
    directions = compensation.uncorrectable_directions / np.repeat([length, 1.0], 3)[:, None]
    if not directions.size or not np.all(np.isfinite(directions)):
        return
    cosines = NumberFormat("", 1.0, 3, 5e-4)
    columns = [Column("", [str(k + 1) for k in range(directions.shape[1])])]
    columns += [Column.of(name, list(row), cosines, with_unit=False) for name, row in zip(COMPONENTS, directions, strict=True)]
    parts = NumberFormat.of(compensation.uncorrectable_parts, ANGLES, ROUNDING)
    columns.append(Column.of("residual error", list(compensation.uncorrectable_parts), parts))
    place = f"at {point_name(compensation.tool)}, world axes, displacements in units of {quantity(length, MILLIMETRES)}"
    notes = "No choice of controlled coordinates changes these residual errors. Times that length, they are displacements."
    title = f"Twists that the actuators cannot produce, {place}"
    yield ReportSection(title, [Table(columns), Text(notes)], "directions")


def _batch(compensation: Compensation) -> Iterator[ReportSection]:
    counts = [(status, int(np.sum(compensation.status == status))) for status in Status]
    states = [(status_word(status), f"{number}") for status, number in counts if number]
    yield ReportSection("Status", [Table.of_rows(("status", "poses"), states)], "status")
    if np.all(np.isin(compensation.status, WITHOUT_NUMBERS)):
        return
    connections = compensation.target.robot.mechanism.connections
    rows = [
        (f"correction of {name}", values, UNITS_OF[connections[name].type.unit])
        for name, values in compensation.corrections.items()
    ]
    for name, values in compensation.actuator_forces.items():
        rows.append((f"force of {name}", values, UNITS_OF[actuator_unit(compensation.result.robot, name)]))
    same = np.where(np.isnan(compensation.residual_error), np.nan, compensation.uncorrected_error)  # at the same poses
    who = point_name(compensation.tool)
    for title, part, units in ((f"displacement of {who}", slice(3), LENGTHS), ("rotation", slice(3, 6), ANGLES)):
        for which, twists in (("uncorrected", same), ("corrected", compensation.residual_error)):
            rows.append((f"{title}, {which}", np.linalg.norm(twists[..., part], axis=-1), units))
    table: list[tuple[str | Number, ...]] = []
    for name, values, units in rows:
        form = NumberFormat.of(values, units)
        ends = (Number(float(end), form, with_unit=False) for end in (np.nanmin(values), np.nanmax(values)))
        table.append((name, form.unit, *ends))
    header = ("quantity", "unit", "smallest", "largest")
    yield ReportSection("Extremes over the poses with results", [Table.of_rows(header, table, "llrr")], "extremes")
    of = "" if compensation.tool is None else f" of {who}"
    notes: list[Block] = [Text(f"Corrected: {join_words(compensation.controlled)}{of}.")]
    if left := 6 - compensation.target.robot.mobility.platform:
        some = "one twist" if left == 1 else f"{left} twists"
        notes.append(Text(f"The actuators cannot produce {some}: see uncorrectable_directions and uncorrectable_parts."))
    yield ReportSection("", notes)


def _data(compensation: Compensation) -> dict[str, object]:
    return {
        "robot": compensation.target.robot.name,
        **units_at(compensation.tool, UNITS),
        "shape": compensation.shape,
        "characteristic_length": compensation.target.robot.length,
        "status": status_names(compensation.status),
        "limit_exceeded": compensation.configuration.limit_exceeded,
        "warnings": compensation.warnings,
        "controlled": compensation.controlled,
        "orientation": compensation.target.orientation.name,
        "target": compensation.target.platform,
        "commanded": compensation.configuration.platform,
        **attributes(compensation, ("actuators", "corrections", "actuator_forces", "uncorrected_error", "residual_error")),
        **attributes(compensation, ("uncorrectable_directions", "uncorrectable_parts")),
        **attributes(compensation, ("uncorrected_error_coordinates", "residual_error_coordinates")),
    }
