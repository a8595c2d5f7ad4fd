"""What a person reads of a compensation: ``print(ks.compensate(…))`` and ``kinetostatics compensate``."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import (
    ANGLES,
    DEGREES,
    LENGTHS,
    MILLIMETRES,
    UNITS_OF,
    Column,
    Scale,
    Units,
    column_table,
    largest,
    listing,
    quantity,
    section,
    table,
    warning_lines,
    wrapped,
)
from kinetostatics.reports.json import actuator_unit, named, plain, status_names
from kinetostatics.reports.pose import pose_lines
from kinetostatics.reports.tool_point import said_of
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.tool_point import named_point
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

#: What is no deviation [m, rad] but rounding.
ROUNDING = 1e-12

#: What the numbers of a compensation mean.
UNITS = {
    "general": "SI: m, rad, N, N·m; world axes; null: there is no correction",
    "actuators": "corrected coordinates of the actuators [m, rad]; corrections: less those at the wanted pose",
    "actuator_forces": "N, of turning joints N·m, positive along the joint's positive direction, at the corrected pose",
    "uncorrected_error": "pose error of the loaded platform without correction: displacement at o [m], rotation [rad]",
    "residual_error": "the same at the corrected actuators",
    "residual_error_coordinates": "the same in the platform's coordinates [m, rad]; uncorrected_error_coordinates: uncorrected",
    "uncorrectable_directions": "columns: twists that no actuator moves the platform along, at o, orthonormal with lengths by "
    "characteristic_length [m, rad]; uncorrectable_parts: how much of residual_error lies along each",
    "commanded": "coordinates of the platform at which the unloaded robot is commanded [m, rad]",
}


@text_of.register(Compensation)
def compensation_report(found: Compensation) -> str:
    """Return what the actuators are to do: tables for one pose, a summary for a batch."""
    robot = found.target.robot
    controlled = listing(found.controlled)
    if found.shape != ():
        return _batch(found)
    lines = [f"Compensation of {robot.name!r}: {_status_words(Status(int(found.status)))}"]
    lines += section("Wanted of the loaded platform", pose_lines(found.target, found.uncorrected.gravity, found.uncorrected.load))
    if found.status in WITHOUT_NUMBERS:
        return "\n".join([*lines, *warning_lines(found.warnings)])
    lines += section("Actuators", _actuators(found))
    if found.tool is None:
        title, of = "By how much the loaded platform misses the target pose, world axes", ""
    else:
        title, of = f"By how much {named_point(found.tool)} misses where it is wanted, world axes", " of the tool's tip"
    lines += section(title, _misses(found))
    rest = [name for name in found.residual_error_coordinates if name not in found.controlled]
    left = f"Left as it is, for want of actuators: {listing(rest)}." if rest else "Nothing is left."
    lines += ["", *wrapped(f"Corrected: {controlled}{of}. {left}")]
    lines += _uncorrectable(found)
    if found.tool is not None and {"x", "y", "z"} & set(rest) and len(found.controlled) >= 3:
        lines += wrapped(
            "With the coordinates x, y and z the tip itself comes where it is wanted, if the actuators can do that; angles are "
            "left."
        )
    return "\n".join([*lines, *warning_lines(found.warnings)])


def _status_words(status: Status) -> str:
    words = {**STATUS_WORDS, **{fact.status: fact.words for fact in FACTS.values() if fact.status is not None}}
    if status == Status.UNREACHABLE:
        return f"{status.name}, no actuator positions bring the loaded platform there"
    return f"{status.name}, {words[status]}"


def _actuators(found: Compensation) -> list[str]:
    connections = found.target.robot.mechanism.connections
    rows = []
    for name in found.actuators:
        kind = connections[name].type
        scale = Scale(*(MILLIMETRES if kind.is_slide else DEGREES)[0], 6, 0.0)
        rows.append(
            (
                name,
                scale.with_unit(found.target.actuators[name]),
                scale.with_unit(found.actuators[name]),
                quantity(found.corrections[name], UNITS_OF[kind.unit]),
                quantity(found.actuator_forces[name], UNITS_OF[kind.force_unit]),
            )
        )
    return table(("actuator", "at the wanted pose", "corrected", "correction", "force to feed forward"), rows)


def _misses(found: Compensation) -> list[str]:
    columns = [Column("", ["uncorrected", "corrected"])]
    for k, name in enumerate(COMPONENTS):
        scale = Scale.of(found.uncorrected_error[3 * (k // 3) : 3 * (k // 3) + 3], LENGTHS if k < 3 else ANGLES, ROUNDING)
        columns.append(Column.of(name, [found.uncorrected_error[k], found.residual_error[k]], scale))
    return column_table(columns)


def _uncorrectable(found: Compensation) -> list[str]:
    """Return the directions in which no actuator moves the platform, scaled, and how much remains along each."""
    length = found.target.robot.length
    directions = found.uncorrectable_directions / np.repeat([length, 1.0], 3)[:, None]
    if not directions.size or not np.all(np.isfinite(directions)):
        return []
    cosines = Scale("", 1.0, 3, 5e-4)
    columns = [Column("", [str(k + 1) for k in range(directions.shape[1])])]
    columns += [Column.of(name, list(row), cosines, with_unit=False) for name, row in zip(COMPONENTS, directions, strict=True)]
    parts = Scale.of(found.uncorrectable_parts, ANGLES, ROUNDING)
    columns.append(Column.of("remains along it", list(found.uncorrectable_parts), parts))
    place = f"at {named_point(found.tool)}, world axes, displacements in units of {quantity(length, MILLIMETRES)}"
    title = f"Directions in which no actuator moves the platform, {place}"
    said = "No choice of coordinates changes what remains along these; times that length it is a displacement."
    return [*section(title, column_table(columns)), *wrapped(said)]


def _batch(found: Compensation) -> str:
    lines = [f"Compensation of {found.target.robot.name!r}: {found.status.size} poses, batch shape {found.shape}"]
    counts = [(item, int(np.sum(found.status == item))) for item in Status]
    lines += section("Status", table(("status", "poses"), [(item.name, f"{count}") for item, count in counts if count]))
    if np.all(np.isin(found.status, WITHOUT_NUMBERS)):
        return "\n".join([*lines, *warning_lines(found.warnings)])
    rows = []
    connections = found.target.robot.mechanism.connections
    for name, values in found.corrections.items():
        rows.append(_range(f"correction of {name}", values, UNITS_OF[connections[name].type.unit]))
    for name, values in found.actuator_forces.items():
        rows.append(_range(f"force of {name}", values, UNITS_OF[actuator_unit(found.result.robot, name)]))
    same = np.where(np.isnan(found.residual_error), np.nan, found.uncorrected_error)  # at the same poses
    sizes = {"uncorrected": same, "corrected": found.residual_error}
    who = named_point(found.tool)
    for title, part, units in ((f"displacement of {who}", slice(3), LENGTHS), ("rotation", slice(3, 6), ANGLES)):
        for which, values in sizes.items():
            rows.append(_range(f"{title}, {which}", np.linalg.norm(values[..., part], axis=-1), units))
    lines += section(
        "Extremes over the poses that have numbers", table(("quantity", "unit", "smallest", "largest"), rows, "llrr")
    )
    lines += ["", *wrapped(f"Corrected: {listing(found.controlled)}{'' if found.tool is None else f' of {who}'}.")]
    if left := 6 - found.target.robot.mobility.platform:
        some = "one direction" if left == 1 else f"{left} directions"
        lines += wrapped(f"In {some} no actuator moves the platform: uncorrectable_directions and uncorrectable_parts tell more.")
    return "\n".join([*lines, *warning_lines(found.warnings)])


def _range(name: str, values: Array, units: Units) -> tuple[str, str, str, str]:
    scale = Scale.of(largest([values]), units)
    return name, scale.unit, scale(np.nanmin(values)), scale(np.nanmax(values))


@dict_of.register(Compensation)
def compensation_to_dict(found: Compensation) -> dict[str, object]:
    """Return a compensation as plain values: what ``compensate --json`` prints."""
    names = ["actuators", "corrections", "actuator_forces", "uncorrected_error", "residual_error", "uncorrectable_directions"]
    names += ["uncorrectable_parts", "uncorrected_error_coordinates", "residual_error_coordinates"]
    return {
        "robot": found.target.robot.name,
        **said_of(found.tool, UNITS),
        "shape": list(found.shape),
        "characteristic_length": found.target.robot.length,
        "status": status_names(found.status),
        "limit_exceeded": plain(found.configuration.limit_exceeded),
        "warnings": list(found.warnings),
        "controlled": list(found.controlled),
        "orientation": found.target.orientation.name,
        "target": plain(found.target.platform),
        "commanded": plain(found.configuration.platform),
        **named(found, names),
    }
