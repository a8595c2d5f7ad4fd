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


def compensation_report(found: Compensation) -> Report:
    sizes = [np.linalg.norm(error[..., :3], axis=-1) for error in (found.uncorrected_error, found.residual_error)]
    before, after = (Number.range_of(size, LENGTHS, ROUNDING) for size in sizes)
    title = [f"Compensation of {found.target.robot.name!r}: "]
    if found.shape == ():
        title.append(status_word(Status(int(found.status))))
    else:
        title += state_title(found.result)
    if not np.all(np.isin(found.status, WITHOUT_NUMBERS)):
        title.append(f"; {point_name(found.tool)} is off by {before} uncorrected, by {after} corrected")
    sections = _one if found.shape == () else _batch
    return Report(title, lambda: [*sections(found), warning_section(found.warnings)], lambda: _data(found))


def _one(found: Compensation) -> Iterator[ReportSection]:
    status = Status(int(found.status))
    if status == Status.UNREACHABLE:
        yield ReportSection(
            None, [Text(", no actuator positions bring the loaded platform to the target pose", lead=status_word(status))]
        )
    elif status != Status.OK:
        words = {**STATUS_WORDS, **{fact.status: fact.words for fact in FACTS.values() if fact.status is not None}}
        yield ReportSection(None, [Text(f", {words[status]}", lead=status_word(status))])
    pose = pose_facts(found.target, found.uncorrected.gravity, found.uncorrected.load)
    yield ReportSection("Target pose of the loaded platform", [pose], "pose")
    if status in WITHOUT_NUMBERS:
        return
    yield ReportSection("Actuators", [_actuators(found)], "actuators")
    of, what = "", "the loaded platform"
    if found.tool is not None:
        of, what = " of the tool's tip", point_name(found.tool)
    yield ReportSection(f"Pose error of {what}, world axes", [_errors(found)], "errors")
    rest = [name for name in found.residual_error_coordinates if name not in found.controlled]
    left = f"Not corrected (too few actuators): {join_words(rest)}." if rest else "No error remains."
    yield ReportSection("", [Text(f"Corrected: {join_words(found.controlled)}{of}. {left}")])
    yield from _uncorrectable(found)
    if found.tool is not None and {"x", "y", "z"} & set(rest) and len(found.controlled) >= 3:
        yield ReportSection("", [Text("With controlled x, y and z the tip reaches its target, as far as the actuators allow.")])


def _actuators(found: Compensation) -> Table:
    connections = found.target.robot.mechanism.connections
    noise = NOISE * largest(found.actuator_forces.values())
    rows: list[tuple[Cell, ...]] = []
    for name in found.actuators:
        kind = connections[name].type
        form = NumberFormat(*(MILLIMETRES if kind.is_slide else DEGREES)[0], 6, 0.0)
        places = (found.target.actuators[name], found.actuators[name])
        shift = Number.of(found.corrections[name], UNITS_OF[kind.unit], ROUNDING)
        force = Number.of(found.actuator_forces[name], UNITS_OF[kind.force_unit], noise)
        rows.append((name, *(Number(float(place), form) for place in places), shift, force))
    return Table.of_rows(("actuator", "at the target pose", "corrected", "correction", "force to feed forward"), rows)


def _errors(found: Compensation) -> Table:
    columns = [Column("", ["uncorrected", "corrected"])]
    for k, name in enumerate(COMPONENTS):
        some = found.uncorrected_error[3 * (k // 3) : 3 * (k // 3) + 3]
        form = NumberFormat.of(some, LENGTHS if k < 3 else ANGLES, ROUNDING)
        columns.append(Column.of(name, [found.uncorrected_error[k], found.residual_error[k]], form))
    return Table(columns)


def _uncorrectable(found: Compensation) -> Iterator[ReportSection]:
    length = found.target.robot.length
    directions = found.uncorrectable_directions / np.repeat([length, 1.0], 3)[:, None]
    if not directions.size or not np.all(np.isfinite(directions)):
        return
    cosines = NumberFormat("", 1.0, 3, 5e-4)
    columns = [Column("", [str(k + 1) for k in range(directions.shape[1])])]
    columns += [Column.of(name, list(row), cosines, with_unit=False) for name, row in zip(COMPONENTS, directions, strict=True)]
    parts = NumberFormat.of(found.uncorrectable_parts, ANGLES, ROUNDING)
    columns.append(Column.of("residual error", list(found.uncorrectable_parts), parts))
    place = f"at {point_name(found.tool)}, world axes, displacements in units of {quantity(length, MILLIMETRES)}"
    notes = "No choice of controlled coordinates changes these residual errors. Times that length, they are displacements."
    title = f"Twists that the actuators cannot produce, {place}"
    yield ReportSection(title, [Table(columns), Text(notes)], "directions")


def _batch(found: Compensation) -> Iterator[ReportSection]:
    counts = [(item, int(np.sum(found.status == item))) for item in Status]
    states = [(status_word(item), f"{number}") for item, number in counts if number]
    yield ReportSection("Status", [Table.of_rows(("status", "poses"), states)], "status")
    if np.all(np.isin(found.status, WITHOUT_NUMBERS)):
        return
    connections = found.target.robot.mechanism.connections
    rows = [
        (f"correction of {name}", values, UNITS_OF[connections[name].type.unit]) for name, values in found.corrections.items()
    ]
    for name, values in found.actuator_forces.items():
        rows.append((f"force of {name}", values, UNITS_OF[actuator_unit(found.result.robot, name)]))
    same = np.where(np.isnan(found.residual_error), np.nan, found.uncorrected_error)  # at the same poses
    who = point_name(found.tool)
    for title, part, units in ((f"displacement of {who}", slice(3), LENGTHS), ("rotation", slice(3, 6), ANGLES)):
        for which, twists in (("uncorrected", same), ("corrected", found.residual_error)):
            rows.append((f"{title}, {which}", np.linalg.norm(twists[..., part], axis=-1), units))
    table: list[tuple[str | Number, ...]] = []
    for name, values, units in rows:
        form = NumberFormat.of(values, units)
        ends = (Number(float(end), form, with_unit=False) for end in (np.nanmin(values), np.nanmax(values)))
        table.append((name, form.unit, *ends))
    header = ("quantity", "unit", "smallest", "largest")
    yield ReportSection("Extremes over the poses with results", [Table.of_rows(header, table, "llrr")], "extremes")
    notes: list[Block] = [Text(f"Corrected: {join_words(found.controlled)}{'' if found.tool is None else f' of {who}'}.")]
    if left := 6 - found.target.robot.mobility.platform:
        some = "one twist" if left == 1 else f"{left} twists"
        notes.append(Text(f"The actuators cannot produce {some}: see uncorrectable_directions and uncorrectable_parts."))
    yield ReportSection("", notes)


def _data(found: Compensation) -> dict[str, object]:
    return {
        "robot": found.target.robot.name,
        **units_at(found.tool, UNITS),
        "shape": found.shape,
        "characteristic_length": found.target.robot.length,
        "status": status_names(found.status),
        "limit_exceeded": found.configuration.limit_exceeded,
        "warnings": found.warnings,
        "controlled": found.controlled,
        "orientation": found.target.orientation.name,
        "target": found.target.platform,
        "commanded": found.configuration.platform,
        **attributes(found, ("actuators", "corrections", "actuator_forces", "uncorrected_error", "residual_error")),
        **attributes(found, ("uncorrectable_directions", "uncorrectable_parts")),
        **attributes(found, ("uncorrected_error_coordinates", "residual_error_coordinates")),
    }
