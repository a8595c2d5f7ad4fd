"""Report of tolerances: ranked effects of the parameters, and the variation between robots of one design."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.layout.blocks import Column, Number, ReportSection, Table, Text
from kinetostatics.layout.numbers import (
    ANGLES,
    FORCES,
    LENGTHS,
    MISSING,
    MOMENTS,
    STIFFNESSES,
    TURNING_STIFFNESSES,
    UNITS_OF,
    Units,
    in_unit,
    largest,
    quantity,
)
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.reports.result import noise_floor, units_at
from kinetostatics.results.pose_arrays import point_name
from kinetostatics.results.tolerances import Tolerance, Tolerances

#: Units and meaning of the numbers.
UNITS = {
    "general": "SI; null: not a number",
    "twist": "at o [m, rad]; displacement and rotation: distances from the nominal robot; nominal ones: magnitudes",
    "stiffness": "at o, actuators locked [N/m, N, N·m]",
    "actuator_forces": "[N, N·m]",
    "effects": "of the tolerance of each parameter alone, to first order; force, at and moment: largest joint force, its joint "
    "and the largest joint moment, by self-stress due to an assembly error",
    "random": "[mean, standard deviation, 2.5 %, 97.5 %] of the samples; for distances, the root mean square in "
    "place of the standard deviation",
}


def tolerances_report(found: Tolerances) -> Report:
    size, who = quantity(float(found.nominal.displacement), LENGTHS), point_name(found.tool)
    title = f"Tolerances of {found.result.robot.name!r}: {who} moves by {size}, nominally"
    return Report(title, lambda: _sections(found, who), lambda: _data(found))


def _sections(found: Tolerances, who: str) -> list[ReportSection]:
    names, effects = list(found.effects), list(found.effects.values())
    items = [found.parameters[name] for name in names]
    columns = [Column("parameter", names)]
    if any(item.value for item in items):
        columns.append(Column("value", [in_unit(item.value, item.unit) if item.value else MISSING for item in items], "r"))
    columns += [
        Column("±", [_amount(item) for item in items], "r"),
        Column.of(f"moves {who}", [float(item.displacement) for item in effects], LENGTHS),
        Column.of("turns", [float(item.rotation) for item in effects], ANGLES),
    ]
    has_self_stress = any(item.force > 0 or item.moment > 0 for item in effects)
    if has_self_stress:
        columns += [
            Column.of("force", [item.force for item in effects], FORCES),
            Column("at", [item.at or MISSING for item in effects]),
            Column.of("moment", [item.moment for item in effects], MOMENTS),
        ]
    columns.append(Column("of variance [%]", [f"{100 * found.share(name):.1f}" for name in names], "r"))
    title = f"Effect of each alone, to first order, ranked by {found.ranked_by}"
    more = [Text(f"and {len(found.parameters) - len(names)} more")] if len(names) < len(found.parameters) else []
    ranked = ReportSection(title, [Table(columns), *more], "effects")
    three = found.nominal, found.worst_case, found.standard_deviation
    rows: list[tuple[str, list[ArrayLike], Sequence[float], Units]] = [
        (title, [item.named(name) for item in three], found.sampled(name), units) for title, name, units in _quantities(found)
    ]
    if np.any(found.worst_case.stiffness):
        for k, name in enumerate(COMPONENTS):
            values, units = found.samples.stiffness[:, k, k], STIFFNESSES if k < 3 else TURNING_STIFFNESSES
            varied = [np.nanmean(values), np.nanstd(values, ddof=1), *np.nanpercentile(values, [2.5, 97.5])]
            rows.append((f"stiffness {name}", [item.stiffness[k, k] for item in three], varied, units))
    floor = noise_floor(found.result)
    noise = {LENGTHS: floor.displacement, ANGLES: floor.rotation, FORCES: floor.force, MOMENTS: floor.moment}
    for _, first_order, sampled, units in rows:
        noise[units] = max(noise.get(units, 0.0), 1e-9 * largest([first_order[0], *sampled[2:]]))
    cells: list[tuple[str | Number, ...]] = [
        (title, *(Number.of(value, units, noise[units], digits=4) for value in (*first_order, *sampled[1:])))
        for title, first_order, sampled, units in rows
    ]
    header = ("quantity", "nominal", "worst ±", "std. dev.", "random", "2.5 %", "97.5 %")
    title = f"Variation: first order (worst case, standard deviation), and {len(found.samples.displacement):,} random samples"
    variation = ReportSection(title, [Table.of_rows(header, cells)], "variation")
    return [ranked, variation, ReportSection("", [Text(text) for text in _sentences(found, has_self_stress)])]


def _amount(item: Tolerance) -> str:
    known = item.unit in ("m", "rad", "K") and not item.value
    return quantity(item.tolerance, UNITS_OF[item.unit], digits=3) if known else in_unit(item.tolerance, item.unit, 4)


def _quantities(found: Tolerances) -> list[tuple[str, str, Units]]:
    connections = found.result.robot.mechanism.connections
    where = f"displacement of {point_name(found.tool)}"
    rows: list[tuple[str, str, Units]] = [(where, "displacement", LENGTHS), ("rotation", "rotation", ANGLES)]
    rows += [(f"twist {name}", name, LENGTHS if k < 3 else ANGLES) for k, name in enumerate(COMPONENTS)]
    actuators = found.nominal.actuator_forces
    return rows + [(name, name, UNITS_OF[connections[name].type.force_unit]) for name in actuators]


def _sentences(found: Tolerances, has_self_stress: bool) -> list[str]:
    normal = found.distribution == "normal"
    by = "normally, with a standard deviation of a third of its tolerance" if normal else "uniformly within its tolerance"
    sentences = [
        f"Each parameter varies independently, {by}; seed {found.seed}. The column random is the standard deviation of the "
        "samples, of which 95 % lie between the last two columns. Displacement and rotation are distances from the nominal "
        "robot; their standard deviation is the root mean square."
    ]
    if not has_self_stress and any(".error." in name for name in found.parameters):
        sentences.append("The assembly errors cause no self-stress.")
    lost = int(np.sum(np.isnan(found.samples.displacement)))
    if lost:
        sentences.append(f"{lost:,} samples cannot reach this pose and do not count.")
    if not found.at_once:
        sentences.append("The samples were analysed one by one, because this analysis cannot be recorded.")
    elif not math.isnan(found.difference):
        sentences.append(f"Samples analysed one by one differ by {found.difference:.1g} standard deviations at most.")
    return sentences


def _data(found: Tolerances) -> dict[str, object]:
    numbers = ("twist", "displacement", "rotation", "stiffness", "actuator_forces")
    names = [name for _, name, _ in _quantities(found)]
    return {
        "robot": found.result.robot.name,
        **units_at(found.tool, UNITS),
        "ranked_by": found.ranked_by,
        "parameters": {
            name: attributes(item, ("value", "unit", "tolerance", "standard_deviation"))
            for name, item in found.parameters.items()
        },
        "nominal": attributes(found.nominal, numbers),
        "effects": {name: attributes(item, (*numbers, "force", "at", "moment")) for name, item in found.effects.items()},
        "worst_case": attributes(found.worst_case, numbers),
        "standard_deviation": attributes(found.standard_deviation, numbers),
        "random": {name: found.sampled(name) for name in names},
        "samples": len(found.samples.displacement),
        "distribution": found.distribution,
        "seed": found.seed,
    }
