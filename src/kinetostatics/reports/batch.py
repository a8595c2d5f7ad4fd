"""Report of a batch of poses: number of poses with valid results, and extremes of the quantities."""

from __future__ import annotations

import numpy as np

from kinetostatics.layout.blocks import Number, ReportSection, Table, Text, warning_section
from kinetostatics.layout.numbers import (
    ENERGIES,
    FORCE_KINDS,
    KINDS,
    NOISE,
    PER_CENT,
    STIFFNESSES,
    STRESSES,
    NoiseFloor,
    NumberFormat,
    Units,
)
from kinetostatics.math.arrays import Array
from kinetostatics.reports.pose import actuator_coordinates, actuator_unit, facts_of, platform_coordinates, statuses_of
from kinetostatics.results.result import Result
from kinetostatics.status import WITHOUT_NUMBERS


def batch_sections(result: Result) -> list[ReportSection]:
    """Return the sections of the report: number of poses in each state, extremes of the quantities, and warnings."""
    known = not np.all(np.isin(result.status, WITHOUT_NUMBERS))
    header = ("quantity", "unit", "smallest", "at", "largest", "at")
    rows = [_row(result, *item) for item in _quantities(result)] if known else []
    title = "Extremes over the valid poses, and their batch indices"
    return [
        ReportSection("Status", _states(result) if result.status.size else [Text("no poses")], "status"),
        ReportSection(title, [Table.of_rows(header, rows, "llrlrl")] if known else [], "extremes"),
        warning_section(result.warnings if result.status.size else ()),
    ]


def _states(result: Result) -> list[Table | Text]:
    """Return the number of poses in each state; a pose can be in several states."""
    ok, *without_numbers = statuses_of(result)
    found = [ok, *facts_of(result), *without_numbers]
    rows = [(word, f"{int(np.sum(where))}", words) for word, where, words in found if np.any(where)]
    several = int(np.sum(np.sum([where for _, where, _ in found], axis=0) > 1))
    table = Table.of_rows(("status", "poses", ""), rows, "lrl")
    return [table, Text(f"{several} of them counted more than once")] if several else [table]


def magnitudes(result: Result) -> NoiseFloor:
    """Return the limits of rounding noise for a result."""
    wrenches = [*result.joint_wrenches.values(), result.platform_wrench]
    return NoiseFloor.of(result.contributions.values(), wrenches, result.robot.length)


def _quantities(result: Result) -> list[tuple[str, Array, Units, float]]:
    """Return name, values, units and noise of the quantities of the table of extremes."""
    twist, noise = result.twist, magnitudes(result)
    found = [(f"platform {name}", *item) for name, item in platform_coordinates(result.configuration).items()]
    found += [(f"position of {name}", *item) for name, item in actuator_coordinates(result.configuration).items()]
    for name, part, kind in (("displacement of o", slice(3), "displacement"), ("rotation", slice(3, 6), "rotation")):
        found.append((name, np.linalg.norm(twist[..., part], axis=-1), KINDS[kind], getattr(noise, kind)))
    known = np.where(np.isfinite(result.compliance), result.compliance, 0.0)
    with np.errstate(divide="ignore"):
        stiffness = np.where(np.isnan(twist[..., 0]), np.nan, 1 / np.linalg.eigvalsh(known[..., :3, :3])[..., -1])
    found.append(("softest stiffness at o", stiffness, STIFFNESSES, 0.0))
    for name, value in result.actuator_forces.items():
        kind = FORCE_KINDS[actuator_unit(result.robot, name)]
        found.append((f"force of {name}", value, KINDS[kind], getattr(noise, kind)))
    for name, beam in result.beams.items():
        found += [(f"stress in {name}", beam.stress, STRESSES, 0.0), (f"N/N_Euler of {name}", beam.euler_ratio, PER_CENT, NOISE)]
    if result.beams:
        found.append(("strain energy", result.strain_energy, ENERGIES, 0.0))
    return found


def _row(result: Result, name: str, values: Array, units: Units, noise: float) -> tuple[str | Number, ...]:
    flat = np.broadcast_to(values, result.shape).ravel()
    form = NumberFormat.of(flat, units, noise)
    missing = np.all(np.isnan(flat))
    cells: list[str | Number] = [name, form.unit]
    for number in (0, 0) if missing else (int(np.nanargmin(flat)), int(np.nanargmax(flat))):
        where = np.unravel_index(number, result.shape)
        cells += [Number(float(flat[number]), form, with_unit=False), "" if missing else f"[{', '.join(map(str, where))}]"]
    return tuple(cells)
