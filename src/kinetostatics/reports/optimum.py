"""Reports of optimizations: parameters, requirements, active constraints; Pareto fronts of two quantities."""

from __future__ import annotations

import math

from kinetostatics.layout.blocks import Number, ReportSection, Table, Text, Word
from kinetostatics.layout.numbers import DEGREES, MILLIMETRES, MISSING, NOISE, UNITS_OF, in_unit
from kinetostatics.layout.report import Report, attributes
from kinetostatics.reports.pose import count
from kinetostatics.results.optimum import BROKEN, CheckedRequirement, Optimum, ParetoFront


def optimum_report(optimum: Optimum) -> Report:
    verdict = Word("feasible", "good") if optimum.feasible else Word("NOT feasible", "bad")
    more = f", {optimum.minimized} {_written(optimum.objective, optimum.unit)}"
    if not optimum.feasible:
        more = ": no parameters within the bounds meet all requirements; closest design found"
    elif not math.isnan(optimum.before):
        more += f" ({_written(optimum.before, optimum.unit)} with the file's own parameters)"
    title = [f"Optimum of {optimum.robot.name!r}: ", verdict, more]
    return Report(title, lambda: _sections(optimum), lambda: _data(optimum))


def _sections(optimum: Optimum) -> list[ReportSection]:
    parameters = [(name, _value(value, optimum.units.get(name, ""))) for name, value in optimum.parameters.items()]
    rows = []
    for check in optimum.requirements:
        worst, where = _written(check.worst, check.unit, check.limit), _place(optimum, check) or "the only pose"
        rows.append((check.text, worst, _margin(check.margin), where))
    requirements = Table.of_rows(("requirement", "worst", "margin", "at"), rows, "lrrl")
    return [
        ReportSection("Parameters", [Table.of_rows(("parameter", "value"), parameters)], "parameters"),
        ReportSection(
            f"Requirements, at the worst of {count(optimum.poses, 'pose')}", [requirements] if rows else [], "requirements"
        ),
        ReportSection("", [Text(text) for text in _sentences(optimum)]),
    ]


def _sentences(optimum: Optimum) -> list[str]:
    notes = []
    for check in optimum.active:
        where = f", at {words}" if (words := _place(optimum, check)) else ""
        if check.margin < -BROKEN:
            notes.append(f"{check.text} is violated{where}.")
        else:
            saves = f": relaxing it by 1 % would save {_written(check.saving, optimum.unit)}" if check.saving > 0 else ""
            notes.append(f"{check.text} is active{where}{saves}.")
    notes += [f"{text}." for text in optimum.at_bounds]
    notes += [f"{name} has no influence on objective or requirements." for name in optimum.no_influence]
    if optimum.feasible and not optimum.active and not optimum.at_bounds:
        notes.append("No requirement is active: this is the unconstrained minimum, or the best of the listed values.")
    if optimum.beyond_limits:
        notes.append(f"{optimum.beyond_limits} of the {optimum.poses} poses are beyond a joint's limit.")
    notes.append(f"How: {optimum.searched}; {optimum.evaluations} robots were analysed.")
    if optimum.alike is not None and len(optimum.starts) > 1 and optimum.feasible:
        notes.append(f"{optimum.alike} of {len(optimum.starts)} searches end here.")
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


def _place(optimum: Optimum, check: CheckedRequirement) -> str:
    """Write the pose at which a requirement is worst, if there are several poses, and its load, if there are several loads."""
    numbers = {name: 0.0 if abs(value) < 1e-12 else value for name, value in check.pose.items()}
    words = [f"{name} = {value:.4g}" for name, value in numbers.items()] if optimum.poses > 1 else []
    return ", ".join([*words, *([f"load[{', '.join(map(str, check.case))}]"] if check.case else [])])


def _data(optimum: Optimum) -> dict[str, object]:
    of_each = ("text", "name", "worst", "limit", "unit", "margin", "pose", "case", "active", "saving")
    names = ("feasible", "objective", "minimized", "unit", "before", "searched", "evaluations", "poses", "beyond_limits")
    return {
        "robot": optimum.robot.name,
        **attributes(optimum, (*names, "parameters", "units", "allowed")),
        "requirements": [attributes(check, of_each) for check in optimum.requirements],
        **attributes(optimum, ("at_bounds", "no_influence", "starts")),
    }


def pareto_report(front: ParetoFront) -> Report:
    first, second = front.minimized
    title = f"Pareto front of {front[0].robot.name!r}: {first} against {second}, {count(len(front), 'design')}"
    names = ("minimized", "units", "objectives", "parameters", "searched", "evaluations")

    def sections() -> list[ReportSection]:
        rows = []
        for optimum, both in zip(front, front.objectives.tolist(), strict=True):
            values = [_value(value, optimum.units.get(name, "")) for name, value in optimum.parameters.items()]
            decides = [check.text for check in optimum.active if check is not optimum.requirements[-1]]
            cells = (_written(value, unit) for value, unit in zip(both, front.units, strict=True))
            rows.append((*cells, *values, "; ".join([*decides, *optimum.at_bounds])))
        header = (first, second, *front.parameters, "other active constraints")
        table = Table.of_rows(header, rows, "r" * (len(header) - 1) + "l")
        notes = f"How: {front.searched}; {front.evaluations} robots were analysed."
        return [ReportSection("Pareto-optimal designs", [table], "designs"), ReportSection("", [Text(notes)])]

    return Report(title, sections, lambda: {**attributes(front, names), "points": [_data(optimum) for optimum in front]})
