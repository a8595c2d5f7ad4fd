"""What a person reads of sensitivities: ``print(ks.sensitivities(…))`` and ``kinetostatics sensitivities``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import LENGTHS, Column, as_told, column_table, quantity, section, wrapped
from kinetostatics.reports.json import plain
from kinetostatics.reports.tool_point import said_of
from kinetostatics.results.sensitivities import Sensitivities, Sensitivity, is_location, is_part
from kinetostatics.results.tool_point import named_point

_MASSES = (("g", 1e-3), ("kg", 1.0))

#: What the numbers of sensitivities mean.
UNITS = {
    "general": "SI; derivatives per unit of the parameter, whose unit is `unit`; null: not a number",
    "twist": "of the twist at o [m, rad]",
    "stiffness": "of the tangent stiffness at o, actuators locked; compliance likewise",
    "actuator_forces": "of the actuators' forces [N, N·m]; actuators: of their coordinates [m, rad]",
    "mass": "of the robot's mass [kg]",
    "sources": "-d twist / d ln(stiffness) of each beam, elastic joint and actuator [m, rad]",
}


#: Rows of a table, at most.
MOST = 24


@text_of.register(Sensitivities)
def sensitivities_report(found: Sensitivities) -> str:
    """Return what to change first: parameters and sources, ranked by what one per cent of them does to o or the tool's tip."""
    robot = found.result.robot
    size, who = float(np.linalg.norm(found.seen.twist[found.worst][:3])), named_point(found.tool)
    where = f" at element {list(found.worst)} of the batch, where it moves most" if found.result.shape else ""
    lines = [f"Sensitivities of {robot.name!r}: {who} moves by {quantity(size, LENGTHS)}{where}"]

    def moved_by(moves: Sequence[float]) -> list[Column]:
        parts = [f"{100 * move / size:+.3f}" if size else "" for move in moves]
        return [Column.of(f"moves {who} by", moves, LENGTHS), Column("of it [%]", parts, "r")]

    moved, sizes = "twist" in found.of, [name for name in found if not is_location(name)]
    effects = {name: found.effect(name) for name in sizes[:MOST]}
    if effects:
        moves, masses = ([effect[k] for effect in effects.values()] for k in (0, 1))
        per_mass = [move / mass if abs(mass) > 1e-12 else None for move, mass in effects.values()]
        columns = [
            Column("parameter", list(effects)),
            Column("value", [as_told(found[name].value, found[name].unit) for name in effects], "r"),
        ]
        columns += moved_by(moves) if moved else []
        if "mass" in found.of:
            columns.append(Column.of("adds", masses, _MASSES))
        if moved and "mass" in found.of:
            columns.append(Column.of(f"{who} per kg", per_mass, LENGTHS))
        kinds = {is_part(name) for name in sizes}
        what = "parameter" if len(kinds) > 1 else "number of a part" if kinds == {True} else "parameter of the file"
        lines += section(f"What one per cent more of each {what} does", [*column_table(columns), *_more(sizes)])
    shifts = [name for name in found if is_location(name)]
    if shifts and moved:
        moves = [found.shift_effect(name) for name in shifts[:MOST]]
        by = Column("by", [{"m": "1 mm", "rad": "1 mrad"}[found[name].unit] for name in shifts[:MOST]], "r")
        columns = [Column("what", shifts[:MOST]), by, *moved_by(moves)]
        title = "What a millimetre or milliradian of each placement or centre of mass does, along and about its own axes"
        lines += section(title, [*column_table(columns), *_more(shifts)])
    if found.sources:
        names = sorted(found.sources, key=found.source_effect)
        columns = [Column("what", names), *moved_by([found.source_effect(name) for name in names])]
        lines += section("What one per cent more stiffness of each part does: stiffen the first", column_table(columns))
    rest = [name for name in found.of if name not in ("twist", "mass")]
    if not len(found) and not found.sources:
        said = "Nothing is elastic, and the file has no numbers that could be changed: no arguments, no masses, no beams."
    elif moved:
        said = "Moves along the present displacement: negative is less sag."
    else:
        said = f"Derivatives of {', '.join(rest or found.of)}: s[name], --json."
    lines += ["", *wrapped(said)]
    for name in (name for name in sizes if found[name].value == 0):
        lines += wrapped(
            f"{name} is zero, and so is one per cent of it: its derivatives tell what more of it does (--json)", "! "
        )
    reasons: dict[str, list[str]] = {}
    for name, why in found.skipped.items():
        reasons.setdefault(why.removeprefix(f"{name}: "), []).append(name)
    for why, names in reasons.items():
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        lines += wrapped(f"{', '.join(names[:3])}{more} {'were' if len(names) > 1 else 'was'} left out: {why}", "! ")
    return "\n".join(lines)


def _more(names: Sequence[str]) -> list[str]:
    """Return a line that tells how many rows a table leaves out."""
    return [f"and {len(names) - MOST} more of less effect: see --json"] if len(names) > MOST else []


@dict_of.register(Sensitivities)
def sensitivities_to_dict(found: Sensitivities) -> dict[str, object]:
    """Return sensitivities as plain values: what ``sensitivities --json`` prints."""
    return {
        "robot": found.result.robot.name,
        **said_of(found.tool, UNITS),
        "twist": plain(found.seen.twist),
        "parameters": {name: _item(item) for name, item in found.parameters.items()},
        "sources": plain(found.sources),
        "skipped": dict(found.skipped),
    }


def _item(item: Sensitivity) -> dict[str, object]:
    derivatives = {name: plain(part) for name, part in item.derivatives.items()}
    return {"name": item.name, "value": plain(item.value), "unit": item.unit, **derivatives, "exact": item.exact}
