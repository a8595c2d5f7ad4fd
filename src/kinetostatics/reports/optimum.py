"""Reports of optimizations: parameters, requirements, active constraints; Pareto fronts of two quantities."""

from __future__ import annotations

import math

from kinetostatics.layout.blocks import Number, ReportSection, Table, Text, Word
from kinetostatics.layout.numbers import DEGREES, MILLIMETRES, MISSING, NOISE, UNITS_OF, in_unit
from kinetostatics.layout.report import Report, attributes
from kinetostatics.reports.pose import count
from kinetostatics.results.optimum import BROKEN, CheckedRequirement, Optimum, ParetoFront


def optimum_report(found: Optimum) -> Report:
    verdict = Word("feasible", "good") if found.feasible else Word("NOT feasible", "bad")
    more = f", {found.minimized} {_written(found.objective, found.unit)}"
    if not found.feasible:
        more = ": no parameters within the bounds meet all requirements; closest design found"
    elif not math.isnan(found.before):
        more += f" ({_written(found.before, found.unit)} with the file's own parameters)"
    title = [f"Optimum of {found.robot.name!r}: ", verdict, more]
    return Report(title, lambda: _sections(found), lambda: _data(found))


def _sections(found: Optimum) -> list[ReportSection]:
    parameters = [(name, _value(value, found.units.get(name, ""))) for name, value in found.parameters.items()]
    rows = []
    for item in found.requirements:
        worst, where = _written(item.worst, item.unit, item.limit), _place(found, item) or "the only pose"
        rows.append((item.text, worst, _margin(item.margin), where))
    requirements = Table.of_rows(("requirement", "worst", "margin", "at"), rows, "lrrl")
    return [
        ReportSection("Parameters", [Table.of_rows(("parameter", "value"), parameters)], "parameters"),
        ReportSection(
            f"Requirements, at the worst of {count(found.poses, 'pose')}", [requirements] if rows else [], "requirements"
        ),
        ReportSection("", [Text(text) for text in _sentences(found)]),
    ]


def _sentences(found: Optimum) -> list[str]:
    notes = []
    for item in found.active:
        where = f", at {words}" if (words := _place(found, item)) else ""
        if item.margin < -BROKEN:
            notes.append(f"{item.text} is violated{where}.")
        else:
            saves = f": relaxing it by 1 % would save {_written(item.saving, found.unit)}" if item.saving > 0 else ""
            notes.append(f"{item.text} is active{where}{saves}.")
    notes += [f"{text}." for text in found.at_bounds]
    notes += [f"{name} has no influence on objective or requirements." for name in found.no_influence]
    if found.feasible and not found.active and not found.at_bounds:
        notes.append("No requirement is active: this is the unconstrained minimum, or the best of the listed values.")
    if found.beyond_limits:
        notes.append(f"{found.beyond_limits} of the {found.poses} poses are beyond a joint's limit.")
    notes.append(f"How: {found.searched}; {found.evaluations} robots were analysed.")
    if found.alike is not None and len(found.starts) > 1 and found.feasible:
        notes.append(f"{found.alike} of {len(found.starts)} searches end here.")
    return notes


def _margin(margin: float) -> str:
    """Write a margin relative to the limit: in per cent, or, from ten times the limit on, as a multiple."""
    if abs(margin) <= 1e-5:
        return "0"
    return f"{100 * margin:.3g} %" if abs(margin) < 10 else f"{margin:+.0f} ×"


def _written(value: float, unit: str, beside: float = 0.0) -> str:
    """Write a number with its unit, or 0 if it is a rounding error compared with ``beside``."""
    noise = NOISE * abs(beside)
    return MISSING if math.isnan(value) else str(Number.of(value, UNITS_OF.get(unit, UNITS_OF[""]), noise)).rstrip()


def _value(value: float, unit: str) -> str | Number:
    units = {"m": MILLIMETRES, "rad": DEGREES}
    return Number.of(value, units[unit]) if unit in units else in_unit(value, unit)


def _place(found: Optimum, item: CheckedRequirement) -> str:
    """Write the pose at which a requirement is worst, if there are several poses, and its load, if there are several loads."""
    numbers = {name: 0.0 if abs(value) < 1e-12 else value for name, value in item.pose.items()}
    words = [f"{name} = {value:.4g}" for name, value in numbers.items()] if found.poses > 1 else []
    return ", ".join([*words, *([f"load[{', '.join(map(str, item.case))}]"] if item.case else [])])


def _data(found: Optimum) -> dict[str, object]:
    of_each = ("text", "name", "worst", "limit", "unit", "margin", "pose", "case", "active", "saving")
    names = ("feasible", "objective", "minimized", "unit", "before", "searched", "evaluations", "poses", "beyond_limits")
    return {
        "robot": found.robot.name,
        **attributes(found, (*names, "parameters", "units", "allowed")),
        "requirements": [attributes(item, of_each) for item in found.requirements],
        **attributes(found, ("at_bounds", "no_influence", "starts")),
    }


def pareto_report(found: ParetoFront) -> Report:
    first, second = found.minimized
    title = f"Pareto front of {found[0].robot.name!r}: {first} against {second}, {count(len(found), 'design')}"
    names = ("minimized", "units", "objectives", "parameters", "searched", "evaluations")

    def sections() -> list[ReportSection]:
        rows = []
        for optimum, both in zip(found, found.objectives.tolist(), strict=True):
            values = [_value(value, optimum.units.get(name, "")) for name, value in optimum.parameters.items()]
            decides = [item.text for item in optimum.active if item is not optimum.requirements[-1]]
            cells = (_written(value, unit) for value, unit in zip(both, found.units, strict=True))
            rows.append((*cells, *values, "; ".join([*decides, *optimum.at_bounds])))
        header = (first, second, *found.parameters, "other active constraints")
        table = Table.of_rows(header, rows, "r" * (len(header) - 1) + "l")
        notes = f"How: {found.searched}; {found.evaluations} robots were analysed."
        return [ReportSection("Pareto-optimal designs", [table], "designs"), ReportSection("", [Text(notes)])]

    return Report(title, sections, lambda: {**attributes(found, names), "points": [_data(item) for item in found]})
