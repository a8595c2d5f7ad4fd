"""What a person reads of sensitivities: ``print(ks.sensitivities(…))`` and ``kinetostatics sensitivities``."""

from __future__ import annotations

import numpy as np

from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import LENGTHS, Column, column_table, quantity, section, wrapped
from kinetostatics.reports.json import plain
from kinetostatics.reports.tool_point import said_of
from kinetostatics.results.sensitivities import Sensitivities
from kinetostatics.results.tool_point import named_point

_MASSES = (("g", 1e-3), ("kg", 1.0))

#: What the numbers of sensitivities mean.
UNITS = {
    "general": "SI; derivatives per unit of the parameter, whose unit is `unit`; null: not a number",
    "twist": "of the twist at o [m, rad]",
    "stiffness": "of the tangent stiffness at o, drives locked; compliance likewise",
    "actuator_forces": "of the drives' forces [N, N·m]; actuators: of their coordinates [m, rad]",
    "mass": "of the robot's mass [kg]",
    "sources": "-d twist / d ln(stiffness) of each beam, elastic joint and drive [m, rad]",
}


@text_of.register(Sensitivities)
def sensitivities_report(found: Sensitivities) -> str:
    """Return what to change first: parameters and sources, ranked by what one per cent of them does to o or the tool's tip."""
    robot = found.result.robot
    size, who = float(np.linalg.norm(found.seen.twist[found.worst][:3])), named_point(found.tool)
    where = f" at element {list(found.worst)} of the batch, where it moves most" if found.result.shape else ""
    lines = [f"Sensitivities of {robot.name!r}: {who} moves by {quantity(size, LENGTHS)}{where}"]
    effects = {name: found.effect(name) for name in found}
    if effects:
        moves, masses = ([effect[k] for effect in effects.values()] for k in (0, 1))
        per_mass = [move / mass if abs(mass) > 1e-12 else None for move, mass in effects.values()]
        columns = [
            Column("parameter", list(effects)),
            Column("value", [f"{found[name].value:.6g} {found[name].unit.replace(' ', '·')}".rstrip() for name in effects], "r"),
            Column.of(f"moves {who} by", moves, LENGTHS),
            Column("of it [%]", [f"{100 * move / size:+.3f}" if size else "" for move in moves], "r"),
            Column.of("adds", masses, _MASSES),
            Column.of(f"{who} per kg", per_mass, LENGTHS),
        ]
        lines += section("What one per cent more of each parameter of the file does", column_table(columns))
    if found.sources:
        names = sorted(found.sources, key=found.source_effect)
        moves = [found.source_effect(name) for name in names]
        columns = [
            Column("what", names),
            Column.of(f"moves {who} by", moves, LENGTHS),
            Column("of it [%]", [f"{100 * move / size:+.3f}" if size else "" for move in moves], "r"),
        ]
        lines += section("What one per cent more stiffness of each part does: stiffen the first", column_table(columns))
    if effects or found.sources:
        said = "Moves along the present displacement: negative is less sag."
    else:
        said = "Nothing gives way, and the file has no numbers among its xacro arguments that could be changed."
    lines += ["", *wrapped(said)]
    for name in (name for name in found if found[name].value == 0):
        lines += wrapped(
            f"{name} is zero, and so is one per cent of it: its derivatives tell what more of it does (--json)", "! "
        )
    for name, why in found.skipped.items():
        lines += wrapped(f"{name} was left out: {why}", "! ")
    return "\n".join(lines)


@dict_of.register(Sensitivities)
def sensitivities_to_dict(found: Sensitivities) -> dict[str, object]:
    """Return sensitivities as plain values: what ``sensitivities --json`` prints."""
    return {
        "robot": found.result.robot.name,
        **said_of(found.tool, UNITS),
        "twist": plain(found.seen.twist),
        "parameters": {name: plain(item) for name, item in found.parameters.items()},
        "sources": plain(found.sources),
        "skipped": dict(found.skipped),
    }
