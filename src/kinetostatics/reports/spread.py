"""What a person reads of a spread: ``print(ks.spread(…))`` and ``kinetostatics spread``."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.math.screws import COMPONENTS
from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import (
    ANGLES,
    LENGTHS,
    STIFFNESSES,
    TURNING_STIFFNESSES,
    UNITS_OF,
    Column,
    Units,
    as_told,
    column_table,
    largest,
    quantity,
    section,
    table,
    wrapped,
)
from kinetostatics.reports.json import named, plain
from kinetostatics.reports.tool_point import said_of
from kinetostatics.results.spread import Spread
from kinetostatics.results.tool_point import named_point

#: What the numbers of a spread mean.
UNITS = {
    "general": "SI; null: not a number",
    "twist": "at o [m, rad]; displacement and rotation: distances from the nominal robot, the nominal ones lengths",
    "stiffness": "at o, actuators locked [N/m, N, N·m]",
    "actuator_forces": "[N, N·m]",
    "effects": "what each parameter does alone when it is off by its tolerance, to first order",
    "random": "[mean, standard deviation, 2.5 %, 97.5 %] of the robots made at random; second of distances: root mean square",
}


@text_of.register(Spread)
def spread_report(found: Spread) -> str:
    """Return two tables: what does how much, and by how much robots differ."""
    size, who = float(found.nominal.displacement), named_point(found.tool)
    lines = [f"Spread of {found.result.robot.name!r}: {who} moves by {quantity(size, LENGTHS)}, nominally"]
    names = sorted(found.parameters, key=lambda name: -float(found.effects[name].displacement))
    moves = [float(found.effects[name].displacement) for name in names]
    columns = [
        Column("parameter", names),
        Column("value", [as_told(found.parameters[name].value, found.parameters[name].unit) for name in names], "r"),
        Column("off by ±", [as_told(found.parameters[name].tolerance, found.parameters[name].unit, 4) for name in names], "r"),
        Column.of(f"moves {who} by", moves, LENGTHS),
        Column("of variance [%]", [f"{100 * found.share(name):.1f}" for name in names], "r"),
    ]
    lines += section("What each does alone, to first order", column_table(columns))
    three = found.nominal, found.worst_case, found.standard_deviation
    rows = [
        _row(title, [item.named(name) for item in three], found.sampled(name), units) for title, name, units in _quantities(found)
    ]
    for k, name in enumerate(COMPONENTS):
        values, units = found.samples.stiffness[:, k, k], STIFFNESSES if k < 3 else TURNING_STIFFNESSES
        sampled = np.nanmean(values), np.nanstd(values, ddof=1), *np.nanpercentile(values, [2.5, 97.5])
        rows.append(_row(f"stiffness {name}", [item.stiffness[k, k] for item in three], sampled, units))
    header = ("quantity", "nominal", "worst ±", "std. dev.", "random", "2.5 %", "97.5 %")
    title = f"How far robots differ: first order (worst case, standard deviation), and {len(found):,} robots made at random"
    lines += section(title, table(header, rows, "lrrrrrr"))
    lines += ["", *(line for text in _sentences(found) for line in wrapped(text))]
    return "\n".join(lines)


def _quantities(found: Spread) -> list[tuple[str, str, Units]]:
    connections = found.result.robot.mechanism.connections
    where = f"displacement of {named_point(found.tool)}"
    rows: list[tuple[str, str, Units]] = [(where, "displacement", LENGTHS), ("rotation", "rotation", ANGLES)]
    rows += [(f"twist {name}", name, LENGTHS if k < 3 else ANGLES) for k, name in enumerate(COMPONENTS)]
    actuators = found.nominal.actuator_forces
    return rows + [(name, name, UNITS_OF[connections[name].type.force_unit]) for name in actuators]


def _row(title: str, first_order: Sequence[ArrayLike], sampled: Sequence[float], units: Units) -> tuple[str, ...]:
    """Return nominal, worst and deviation of first order, and deviation and limits of what was sampled, in words."""
    noise = 1e-9 * largest([first_order[0], *sampled[2:]])
    return (title, *(quantity(value, units, noise, digits=4) for value in (*first_order, *sampled[1:])))


def _sentences(found: Spread) -> list[str]:
    by = "normal distribution, whose standard deviation is a third" if found.distribution == "normal" else "uniform distribution"
    by += " of its tolerance" if found.distribution == "normal" else " within its tolerance"
    said = [
        f"Each parameter scatters by itself, by a {by}; seed {found.seed}. The column random is the standard deviation of the "
        "robots made at random, of which 95 % lie between the last two. Displacement and rotation are distances from the nominal "
        "robot, in any direction; their standard deviation is the root mean square."
    ]
    lost = int(np.sum(np.isnan(found.samples.displacement)))
    if lost:
        said.append(f"{lost:,} robots made at random have no such pose and do not count.")
    if not found.at_once:
        said.append("Every robot was made by itself, as this analysis cannot be recorded.")
    elif not math.isnan(found.difference):
        said.append(f"The first ones, made by themselves, differ by {found.difference:.1g} standard deviations at most.")
    return said


@dict_of.register(Spread)
def spread_to_dict(found: Spread) -> dict[str, object]:
    """Return a spread as plain values: what ``spread --json`` prints."""
    numbers = ("twist", "displacement", "rotation", "stiffness", "actuator_forces")
    told = ("value", "unit", "tolerance", "standard_deviation")
    names = [name for _, name, _ in _quantities(found)]
    return {
        "robot": found.result.robot.name,
        **said_of(found.tool, UNITS),
        "parameters": {name: named(item, told) for name, item in found.parameters.items()},
        "nominal": named(found.nominal, numbers),
        "effects": {name: named(item, numbers) for name, item in found.effects.items()},
        "worst_case": named(found.worst_case, numbers),
        "standard_deviation": named(found.standard_deviation, numbers),
        "random": {name: [plain(value) for value in found.sampled(name)] for name in names},
        "robots": len(found),
        "distribution": found.distribution,
        "seed": found.seed,
    }
