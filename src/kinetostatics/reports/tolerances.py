"""What a person reads of tolerances: ``print(ks.tolerances(…))`` and ``kinetostatics tolerances``."""

from __future__ import annotations

from kinetostatics.printing.dispatch import text_of
from kinetostatics.printing.text import ANGLES, FORCES, LENGTHS, MOMENTS, Scale, quantity, section, table
from kinetostatics.results.tolerances import Tolerance, Tolerances

_AMOUNTS = {"temperature": (("K", 1.0),), "length": LENGTHS, **dict.fromkeys("xyz", LENGTHS)}
_RANKED = {"force": "by the force that they lock in", "displacement": "by what they move o", "rotation": "by what they turn"}


@text_of.register(Tolerances)
def tolerances_report(found: Tolerances) -> str:
    """Return a ranked table of what small errors do."""
    robot = found.configuration.robot
    lines = [f"Tolerances of {robot.name!r}: what each error does alone, ranked {_RANKED[found.ranked_by]}"]
    if not found.rows:
        return "\n".join([*lines, "", "No error has an effect."])
    shift = Scale.of([row.displacement for row in found.rows], LENGTHS, digits=4)
    turn = Scale.of([row.rotation for row in found.rows], ANGLES, digits=4)
    force = Scale.of([row.force for row in found.rows], FORCES, digits=4)
    moment = Scale.of([row.moment for row in found.rows], MOMENTS, digits=4)
    header = ["what", "error", "by", f"moves o [{shift.unit}]", f"turns [{turn.unit}]", "force [N]", "at", "moment [N·m]"]
    rows = [
        (
            *(row.name, row.error, amount_words(row)),
            *(shift(row.displacement), turn(row.rotation)),
            *(force(row.force), row.at or "–", moment(row.moment)),
        )
        for row in found.rows
    ]
    lines += section("Errors of joints along (x y z) and about (rx ry rz) the axes of their frames, and of beams", [])
    lines += [f"  {line}" for line in table(header, rows, "lllrrrlr")]
    if all(row.force == row.moment == 0 for row in found.rows):
        lines += ["", "The robot is not overconstrained: errors move the platform but lock in no force."]
    return "\n".join(lines)


def amount_words(row: Tolerance) -> str:
    """Write how large an error is."""
    return quantity(row.amount, _AMOUNTS.get(row.error, ANGLES), digits=3)
