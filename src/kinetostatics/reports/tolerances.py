"""What a person reads of tolerances: ``print(ks.tolerances(…))`` and ``kinetostatics tolerances``."""

from __future__ import annotations

from kinetostatics.printing.dispatch import text_of
from kinetostatics.printing.text import (
    ANGLES,
    FORCES,
    LENGTHS,
    MISSING,
    MOMENTS,
    UNITS_OF,
    Column,
    column_table,
    quantity,
    section,
)
from kinetostatics.results.tolerances import Tolerance, Tolerances
from kinetostatics.results.tool_point import named_point

_AMOUNTS = {"temperature": UNITS_OF["K"], "length": LENGTHS, **dict.fromkeys("xyz", LENGTHS)}
_RANKED = {"force": "by the force that they lock in", "displacement": "by what they move {}", "rotation": "by what they turn"}


@text_of.register(Tolerances)
def tolerances_report(found: Tolerances) -> str:
    """Return a ranked table of what small errors do."""
    robot, who = found.configuration.robot, named_point(found.tool)
    lines = [f"Tolerances of {robot.name!r}: what each error does alone, ranked {_RANKED[found.ranked_by].format(who)}"]
    if not found.rows:
        return "\n".join([*lines, "", "No error has an effect."])

    columns = [
        Column("what", [row.name for row in found.rows]),
        Column("error", [row.error for row in found.rows]),
        Column("by", [amount_words(row) for row in found.rows]),
        Column.of(f"moves {who}", [row.displacement for row in found.rows], LENGTHS),
        Column.of("turns", [row.rotation for row in found.rows], ANGLES),
        Column.of("force", [row.force for row in found.rows], FORCES),
        Column("at", [row.at or MISSING for row in found.rows]),
        Column.of("moment", [row.moment for row in found.rows], MOMENTS),
    ]
    title = "Errors of joints along (x y z) and about (rx ry rz) the axes of their frames, and of beams"
    lines += section(title, column_table(columns))
    if all(row.force == row.moment == 0 for row in found.rows):
        lines += ["", "The robot is not overconstrained: errors move the platform but lock in no force."]
    return "\n".join(lines)


def amount_words(row: Tolerance) -> str:
    """Write how large an error is."""
    return quantity(row.amount, _AMOUNTS.get(row.error, ANGLES), digits=3)
