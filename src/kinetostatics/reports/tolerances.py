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


def tolerances_report(tolerances: Tolerances) -> Report:
    size, who = quantity(float(tolerances.nominal.displacement), LENGTHS), point_name(tolerances.tool)
    title = f"Tolerances of {tolerances.result.robot.name!r}: {who} moves by {size}, nominally"
    return Report(title, lambda: _sections(tolerances, who), lambda: _data(tolerances))


def _sections(tolerances: Tolerances, who: str) -> list[ReportSection]:
    names, effects = list(tolerances.effects), list(tolerances.effects.values())
    parameters = [tolerances.parameters[name] for name in names]
    columns = [Column("parameter", names)]
    if any(parameter.value for parameter in parameters):
        nominal = [in_unit(parameter.value, parameter.unit) if parameter.value else MISSING for parameter in parameters]
        columns.append(Column("value", nominal, "r"))
    columns += [
        Column("±", [_amount(parameter) for parameter in parameters], "r"),
        Column.of(f"moves {who}", [float(effect.displacement) for effect in effects], LENGTHS),
        Column.of("turns", [float(effect.rotation) for effect in effects], ANGLES),
    ]
    has_self_stress = any(effect.force > 0 or effect.moment > 0 for effect in effects)
    if has_self_stress:
        columns += [
            Column.of("force", [effect.force for effect in effects], FORCES),
            Column("at", [effect.at or MISSING for effect in effects]),
            Column.of("moment", [effect.moment for effect in effects], MOMENTS),
        ]
    columns.append(Column("of variance [%]", [f"{100 * tolerances.share(name):.1f}" for name in names], "r"))
    title = f"Effect of each alone, to first order, ranked by {tolerances.ranked_by}"
    more = [Text(f"and {len(tolerances.parameters) - len(names)} more")] if len(names) < len(tolerances.parameters) else []
    ranked = ReportSection(title, [Table(columns), *more], "effects")
    three = tolerances.nominal, tolerances.worst_case, tolerances.standard_deviation
    rows: list[tuple[str, list[ArrayLike], Sequence[float], Units]] = [
        (title, [quantities.named(name) for quantities in three], tolerances.sampled(name), units)
        for title, name, units in _quantities(tolerances)
    ]
    if np.any(tolerances.worst_case.stiffness):
        for k, name in enumerate(COMPONENTS):
            values, units = tolerances.samples.stiffness[:, k, k], STIFFNESSES if k < 3 else TURNING_STIFFNESSES
            varied = [np.nanmean(values), np.nanstd(values, ddof=1), *np.nanpercentile(values, [2.5, 97.5])]
            rows.append((f"stiffness {name}", [quantities.stiffness[k, k] for quantities in three], varied, units))
    floor = noise_floor(tolerances.result)
    noise = {LENGTHS: floor.displacement, ANGLES: floor.rotation, FORCES: floor.force, MOMENTS: floor.moment}
    for _, first_order, sampled, units in rows:
        noise[units] = max(noise.get(units, 0.0), 1e-9 * largest([first_order[0], *sampled[2:]]))
    cells: list[tuple[str | Number, ...]] = [
        (title, *(Number.of(value, units, noise[units], digits=4) for value in (*first_order, *sampled[1:])))
        for title, first_order, sampled, units in rows
    ]
    header = ("quantity", "nominal", "worst ±", "std. dev.", "random", "2.5 %", "97.5 %")
    number = len(tolerances.samples.displacement)
    title = f"Variation: first order (worst case, standard deviation), and {number:,} random samples"
    variation = ReportSection(title, [Table.of_rows(header, cells)], "variation")
    return [ranked, variation, ReportSection("", [Text(text) for text in _sentences(tolerances, has_self_stress)])]


def _amount(parameter: Tolerance) -> str:
    if parameter.unit in ("m", "rad", "K") and not parameter.value:
        return quantity(parameter.tolerance, UNITS_OF[parameter.unit], digits=3)
    return in_unit(parameter.tolerance, parameter.unit, 4)


def _quantities(tolerances: Tolerances) -> list[tuple[str, str, Units]]:
    connections = tolerances.result.robot.mechanism.connections
    where = f"displacement of {point_name(tolerances.tool)}"
    rows: list[tuple[str, str, Units]] = [(where, "displacement", LENGTHS), ("rotation", "rotation", ANGLES)]
    rows += [(f"twist {name}", name, LENGTHS if k < 3 else ANGLES) for k, name in enumerate(COMPONENTS)]
    actuators = tolerances.nominal.actuator_forces
    return rows + [(name, name, UNITS_OF[connections[name].type.force_unit]) for name in actuators]


def _sentences(tolerances: Tolerances, has_self_stress: bool) -> list[str]:
    normal = tolerances.distribution == "normal"
    by = "normally, with a standard deviation of a third of its tolerance" if normal else "uniformly within its tolerance"
    sentences = [
        f"Each parameter varies independently, {by}; seed {tolerances.seed}. The column random is the standard deviation of the "
        "samples, of which 95 % lie between the last two columns. Displacement and rotation are distances from the nominal "
        "robot; their standard deviation is the root mean square."
    ]
    if not has_self_stress and any(".error." in name for name in tolerances.parameters):
        sentences.append("The assembly errors cause no self-stress.")
    lost = int(np.sum(np.isnan(tolerances.samples.displacement)))
    if lost:
        sentences.append(f"{lost:,} samples cannot reach this pose and do not count.")
    if not tolerances.at_once:
        sentences.append("The samples were analysed one by one, because this analysis cannot be recorded.")
    elif not math.isnan(tolerances.difference):
        sentences.append(f"Samples analysed one by one differ by {tolerances.difference:.1g} standard deviations at most.")
    return sentences


def _data(tolerances: Tolerances) -> dict[str, object]:
    numbers = ("twist", "displacement", "rotation", "stiffness", "actuator_forces")
    names = [name for _, name, _ in _quantities(tolerances)]
    return {
        "robot": tolerances.result.robot.name,
        **units_at(tolerances.tool, UNITS),
        "ranked_by": tolerances.ranked_by,
        "parameters": {
            name: attributes(parameter, ("value", "unit", "tolerance", "standard_deviation"))
            for name, parameter in tolerances.parameters.items()
        },
        "nominal": attributes(tolerances.nominal, numbers),
        "effects": {name: attributes(effect, (*numbers, "force", "at", "moment")) for name, effect in tolerances.effects.items()},
        "worst_case": attributes(tolerances.worst_case, numbers),
        "standard_deviation": attributes(tolerances.standard_deviation, numbers),
        "random": {name: tolerances.sampled(name) for name in names},
        "samples": len(tolerances.samples.displacement),
        "distribution": tolerances.distribution,
        "seed": tolerances.seed,
    }
