"""Report of sensitivities: parameters and elastic parts, ranked by their effect on the displacement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinetostatics.layout.blocks import Block, Column, ReportSection, Table, Text
from kinetostatics.layout.numbers import LENGTHS, in_unit, quantity
from kinetostatics.layout.report import Report, as_json
from kinetostatics.reports.result import units_at
from kinetostatics.results.pose_arrays import point_name
from kinetostatics.results.sensitivities import Sensitivities, is_location, is_part

_MASSES = (("g", 1e-3), ("kg", 1.0))

#: Units and meaning of the numbers.
UNITS = {
    "general": "SI; derivatives per unit of the parameter, whose unit is `unit`; null: not a number",
    "twist": "of the twist at o [m, rad]",
    "stiffness": "of the tangent stiffness at o, actuators locked; compliance likewise",
    "actuator_forces": "of the actuators' forces [N, N·m]; actuators: of their coordinates [m, rad]",
    "mass": "of the robot's mass [kg]",
    "sources": "-d twist / d ln(stiffness) of each beam, elastic joint and actuator [m, rad]",
}

#: Largest number of rows of a table.
MOST = 24


def sensitivities_report(sensitivities: Sensitivities) -> Report:
    size, who = float(np.linalg.norm(sensitivities.seen.twist[sensitivities.worst][:3])), point_name(sensitivities.tool)
    where = f" at element {list(sensitivities.worst)} of the batch, where it moves most" if sensitivities.result.shape else ""
    title = f"Sensitivities of {sensitivities.result.robot.name!r}: {who} moves by {quantity(size, LENGTHS)}{where}"
    return Report(title, lambda: _sections(sensitivities, size, who), lambda: _data(sensitivities))


def _sections(sensitivities: Sensitivities, size: float, who: str) -> Iterator[ReportSection]:
    def moved_by(moves: Sequence[float]) -> list[Column]:
        parts = [f"{round(100 * move / size, 3) + 0.0:+.3f}" if size else "" for move in moves]
        return [Column.of(f"moves {who} by", moves, LENGTHS), Column("of it [%]", parts, "r")]

    moved, sizes = "twist" in sensitivities.outputs, [name for name in sensitivities if not is_location(name)]
    effects = {name: sensitivities.effect(name) for name in sizes[:MOST]}
    if effects:
        moves, masses = ([effect[k] for effect in effects.values()] for k in (0, 1))
        columns = [
            Column("parameter", list(effects)),
            Column("value", [in_unit(sensitivities[name].value, sensitivities[name].unit) for name in effects], "r"),
            *(moved_by(moves) if moved else []),
        ]
        if "mass" in sensitivities.outputs:
            columns.append(Column.of("adds", masses, _MASSES))
        if moved and "mass" in sensitivities.outputs:
            per_mass = [move / mass if abs(mass) > 1e-12 else None for move, mass in effects.values()]
            columns.append(Column.of(f"{who} per kg", per_mass, LENGTHS))
        kinds = {is_part(name) for name in sizes}
        what = "parameter" if len(kinds) > 1 else "dimension of a part" if kinds == {True} else "parameter of the file"
        yield ReportSection(f"Effect of increasing each {what} by 1 %", [Table(columns), *_more(sizes)], "parameters")
    shifts = [name for name in sensitivities if is_location(name)]
    if shifts and moved:
        by = Column("by", [{"m": "1 mm", "rad": "1 mrad"}[sensitivities[name].unit] for name in shifts[:MOST]], "r")
        columns = [Column("what", shifts[:MOST]), by, *moved_by([sensitivities.shift_effect(name) for name in shifts[:MOST]])]
        title = "Effect of moving each placement or centre of mass by 1 mm or 1 mrad, along and about its own axes"
        yield ReportSection(title, [Table(columns), *_more(shifts)], "placements")
    if sensitivities.sources:
        names = sorted(sensitivities.sources, key=sensitivities.source_effect)
        columns = [Column("what", names), *moved_by([sensitivities.source_effect(name) for name in names])]
        yield ReportSection(
            "Effect of increasing the stiffness of each part by 1 %: stiffen the first", [Table(columns)], "sources"
        )
    yield ReportSection("", _sentences(sensitivities, sizes))


def _sentences(sensitivities: Sensitivities, sizes: Sequence[str]) -> list[Block]:
    others = [name for name in sensitivities.outputs if name not in ("twist", "mass")]
    if not len(sensitivities) and not sensitivities.sources:
        note = "No part is elastic, and the file has no numbers to vary: no arguments, no masses, no beams."
    elif "twist" in sensitivities.outputs:
        note = "Changes along the present displacement: negative is less sag."
    else:
        note = f"Derivatives of {', '.join(others or sensitivities.outputs)}: s[name], --json."
    texts: list[Block] = [Text(note)]
    for name in sizes:
        if sensitivities[name].value == 0:
            zero = f"{name} is zero, so that 1 % of it changes nothing: see its derivatives (--json)"
            texts.append(Text(zero, "warning"))
    reasons: dict[str, list[str]] = {}
    for name, why in sensitivities.skipped.items():
        reasons.setdefault(why.removeprefix(f"{name}: "), []).append(name)
    for why, names in reasons.items():
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        were = "were" if len(names) > 1 else "was"
        texts.append(Text(f"{', '.join(names[:3])}{more} {were} left out: {why}", "warning"))
    return texts


def _more(names: Sequence[str]) -> list[Text]:
    """Return a line on the rows beyond ``MOST``, which are omitted."""
    return [Text(f"and {len(names) - MOST} more of less effect: see --json")] if len(names) > MOST else []


def _data(sensitivities: Sensitivities) -> dict[str, object]:
    return {
        "robot": sensitivities.result.robot.name,
        **units_at(sensitivities.tool, UNITS),
        "twist": sensitivities.seen.twist,
        "parameters": {
            name: {
                "name": name,
                "value": parameter.value,
                "unit": parameter.unit,
                **as_json(parameter.derivatives),
                "exact": parameter.exact,
            }
            for name, parameter in sensitivities.parameters.items()
        },
        "sources": sensitivities.sources,
        "skipped": sensitivities.skipped,
    }
