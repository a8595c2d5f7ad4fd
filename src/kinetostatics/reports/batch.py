"""What a person reads of a batch of poses: how many succeeded, and where the extremes lie."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.printing.text import (
    ANGLES,
    ENERGIES,
    FORCES,
    LENGTHS,
    MOMENTS,
    NOISE,
    STIFFNESSES,
    STRESSES,
    Magnitudes,
    Scale,
    Units,
    section,
    table,
    warning_lines,
)
from kinetostatics.reports.json import drive_unit
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

if TYPE_CHECKING:
    from kinetostatics.results.result import Result


def batch_report(result: Result) -> str:
    """Return of how many poses what is true, and the extremes of what was found."""
    status = result.status
    lines = [f"Analysis of {result.robot.name!r}: {status.size} poses, batch shape {result.shape}"]
    lines += section("Status", _statuses(result) if status.size else ["no poses"])
    if not np.all(np.isin(status, WITHOUT_NUMBERS)):
        lines += section("Extremes over the valid poses, and at which element of the batch", _extremes(result))
    lines += warning_lines(result.warnings if status.size else ())
    return "\n".join(lines)


def _statuses(result: Result) -> list[str]:
    """Return what is true of how many poses; a pose counts in every row that is true of it."""
    where = {item: (result.status == item, item.name, words) for item, words in STATUS_WORDS.items()}
    found = [where[Status.OK]]
    found += [(result.facts[name], fact.title, fact.words) for name, fact in FACTS.items()]
    found += [where[item] for item in WITHOUT_NUMBERS]
    rows = [(title, f"{int(np.sum(true))}", words) for true, title, words in found if np.any(true)]
    several = int(np.sum(np.sum([true for true, _, _ in found], axis=0) > 1))
    return table(("status", "poses", ""), rows, "lrl") + ([f"{several} of them counted more than once"] if several else [])


def magnitudes(result: Result) -> Magnitudes:
    """Return which numbers of a result are rounding noise."""
    wrenches = [*result.joint_wrenches.values(), result.platform_wrench]
    return Magnitudes.of(result.contributions.values(), wrenches, result.robot.length)


def _extremes(result: Result) -> list[str]:
    rows = [_row(result, *item) for item in _quantities(result)]
    return table(("quantity", "unit", "smallest", "at", "largest", "at"), rows, "llrlrl")


def _quantities(result: Result) -> list[tuple[str, Array, Units, float]]:
    """Return name, values, units and noise of everything that is worth its extremes."""
    configuration, robot = result.configuration, result.robot
    found: list[tuple[str, Array, Units, float]] = []
    for name, value in configuration.platform.items():
        units: Units = (("mm", 1e-3),) if name in "xyz" else (("°", np.pi / 180),)
        found.append((f"platform {name}", value, units, NOISE * robot.length if name in "xyz" else 1e-9))
    for name, value in configuration.actuators.items():
        slides = robot.mechanism.connections[name].type.is_slide
        found.append((f"position of {name}", value, (("mm", 1e-3),) if slides else (("°", np.pi / 180),), 1e-11))
    twist, noise = result.twist, magnitudes(result)
    found.append(("displacement of o", np.linalg.norm(twist[..., :3], axis=-1), LENGTHS, noise.displacement))
    found.append(("rotation", np.linalg.norm(twist[..., 3:], axis=-1), ANGLES, noise.rotation))
    softest = np.linalg.eigvalsh(_finite(result.compliance[..., :3, :3]))[..., -1]
    with np.errstate(divide="ignore"):
        stiffness = np.where(np.isnan(twist[..., 0]), np.nan, 1 / softest)
    found.append(("softest stiffness at o", stiffness, STIFFNESSES, 0.0))
    for name, value in result.actuator_forces.items():
        slides = drive_unit(robot, name) == "N"
        found.append((f"force of {name}", value, FORCES if slides else MOMENTS, noise.force if slides else noise.moment))
    for name, beam in result.beams.items():
        found.append((f"stress in {name}", beam.stress, STRESSES, 0.0))
        found.append((f"N/N_Euler of {name}", beam.euler_ratio, (("%", 0.01),), 0.0))
    if result.beams:
        found.append(("strain energy", result.strain_energy, ENERGIES, 0.0))
    return found


def _finite(matrices: Array) -> Array:
    return np.where(np.isfinite(matrices), matrices, 0.0)


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
