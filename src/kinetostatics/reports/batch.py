"""What a person reads of a batch of poses: how many succeeded, and where the extremes lie."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.printing.text import (
    ENERGIES,
    FORCE_KINDS,
    KINDS,
    PER_CENT,
    STIFFNESSES,
    STRESSES,
    Magnitudes,
    Scale,
    Units,
    section,
    table,
    warning_lines,
)
from kinetostatics.reports.json import actuator_unit
from kinetostatics.reports.pose import actuator_coordinates, facts_of, platform_coordinates, statuses_of
from kinetostatics.results.result import Result
from kinetostatics.status import WITHOUT_NUMBERS


def batch_report(result: Result) -> str:
    """Return of how many poses what is true, and the extremes of what was found."""
    status = result.status
    lines = [f"Analysis of {result.robot.name!r}: {status.size} poses, batch shape {result.shape}"]
    lines += section("Status", _statuses(result) if status.size else ["no poses"])
    if not np.all(np.isin(status, WITHOUT_NUMBERS)):
        rows = [_row(result, *item) for item in _quantities(result)]
        lines += section(
            "Extremes over the valid poses, and at which element of the batch",
            table(("quantity", "unit", "smallest", "at", "largest", "at"), rows, "llrlrl"),
        )
    lines += warning_lines(result.warnings if status.size else ())
    return "\n".join(lines)


def _statuses(result: Result) -> list[str]:
    """Return what is true of how many poses; a pose counts in every row that is true of it."""
    ok, *without_numbers = statuses_of(result)
    found = [ok, *facts_of(result), *without_numbers]
    rows = [(title, f"{int(np.sum(where))}", words) for title, where, words in found if np.any(where)]
    several = int(np.sum(np.sum([where for _, where, _ in found], axis=0) > 1))
    return table(("status", "poses", ""), rows, "lrl") + ([f"{several} of them counted more than once"] if several else [])


def magnitudes(result: Result) -> Magnitudes:
    """Return which numbers of a result are rounding noise."""
    wrenches = [*result.joint_wrenches.values(), result.platform_wrench]
    return Magnitudes.of(result.contributions.values(), wrenches, result.robot.length)


def _quantities(result: Result) -> list[tuple[str, Array, Units, float]]:
    """Return name, values, units and noise of everything that is worth its extremes."""
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
        found += [(f"stress in {name}", beam.stress, STRESSES, 0.0), (f"N/N_Euler of {name}", beam.euler_ratio, PER_CENT, 0.0)]
    if result.beams:
        found.append(("strain energy", result.strain_energy, ENERGIES, 0.0))
    return found


def _row(result: Result, name: str, values: Array, units: Units, noise: float) -> tuple[str, ...]:
    flat = np.broadcast_to(values, result.shape).ravel()
    scale = Scale.of(flat, units, noise)
    if np.all(np.isnan(flat)):
        return (name, scale.unit, scale(np.nan), "", scale(np.nan), "")
    cells = [name, scale.unit]
    for number in (int(np.nanargmin(flat)), int(np.nanargmax(flat))):
        where = np.unravel_index(number, result.shape)
        cells += [scale(flat[number]), "[" + ", ".join(str(int(k)) for k in where) + "]"]
    return tuple(cells)
