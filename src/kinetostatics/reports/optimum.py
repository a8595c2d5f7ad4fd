"""What a person reads of an optimization: ``print(ks.optimize(…))`` and ``kinetostatics optimize``."""

from __future__ import annotations

import math
from collections.abc import Mapping

from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import DEGREES, MILLIMETRES, MISSING, UNITS_OF, as_told, quantity, section, table, wrapped
from kinetostatics.reports.json import named
from kinetostatics.results.optimum import BROKEN, CheckedRequirement, Optimum
from kinetostatics.results.pareto import ParetoFront


@text_of.register(Optimum)
def optimum_report(found: Optimum) -> str:
    """Return parameters, requirements and a verdict in words."""
    lines = [f"Optimum of {found.robot.name!r}: {_verdict(found)}"]
    rows = [(name, _value(value, found.units.get(name, ""))) for name, value in found.parameters.items()]
    lines += section("Parameters", table(("parameter", "value"), rows))
    if found.requirements:
        cells = [
            (
                item.text,
                _written(item.worst, item.unit),
                f"{100 * item.margin:.3g} %" if abs(item.margin) > 1e-5 else "0",
                place_words(found, item) or "the only pose",
            )
            for item in found.requirements
        ]
        title = f"Requirements, at the worst of {found.poses} pose{'s' * (found.poses > 1)}"
        lines += section(title, table(("requirement", "worst", "margin", "at"), cells, "lrrl"))
    lines += ["", *(line for text in _sentences(found) for line in wrapped(text))]
    return "\n".join(lines)


def _verdict(found: Optimum) -> str:
    if not found.feasible:
        return "NOT feasible: no parameters within the bounds were found that meet all requirements; these come nearest"
    before = "" if math.isnan(found.before) else f" ({_written(found.before, found.unit)} with the file's own parameters)"
    return f"feasible, {found.minimized} {_written(found.objective, found.unit)}{before}"


def _sentences(found: Optimum) -> list[str]:
    """Return what decides, and how sure it is."""
    said = []
    for item in found.active:
        where = f", at {words}" if (words := place_words(found, item)) else ""
        if item.margin < -BROKEN:
            said.append(f"{item.text} is broken{where}.")
        else:
            saves = f": one per cent looser would save {_written(item.saving, found.unit)}" if item.saving > 0 else ""
            said.append(f"{item.text} decides{where}{saves}.")
    said += [f"{text}." for text in found.at_bounds]
    said += [f"{name} changes nothing of what is asked: any value from its range does as well." for name in found.idle]
    if found.feasible and not found.active and not found.at_bounds:
        said.append("No requirement decides: this is the least of all, or the best of the listed values.")
    if found.beyond_limits:
        said.append(f"{found.beyond_limits} of the {found.poses} poses are beyond a joint's limit.")
    said.append(f"How: {found.searched}; {found.evaluations} robots were analysed.")
    if found.alike is not None and len(found.starts) > 1 and found.feasible:
        said.append(f"{found.alike} of {len(found.starts)} searches end here.")
    return said


def _written(value: float, unit: str) -> str:
    return MISSING if math.isnan(value) else quantity(value, UNITS_OF.get(unit, UNITS_OF[""])).rstrip()


def _value(value: float, unit: str) -> str:
    if unit == "m":
        return quantity(value, MILLIMETRES)
    if unit == "rad":
        return quantity(value, DEGREES)
    return as_told(value, unit)


def pose_words(pose: Mapping[str, float]) -> str:
    """Return a pose in words, SI."""
    return ", ".join(f"{name} = {value:.4g}" for name, value in pose.items())


def place_words(found: Optimum, item: CheckedRequirement) -> str:
    """Return pose and load at which a requirement is worst, if there are several."""
    words = [pose_words(item.pose)] if found.poses > 1 else []
    return ", ".join([*words, *([f"load[{', '.join(map(str, item.case))}]"] if item.case else [])])


@dict_of.register(Optimum)
def optimum_to_dict(found: Optimum) -> dict[str, object]:
    """Return an optimum as plain values: what ``optimize --json`` prints."""
    of_each = ("text", "name", "worst", "limit", "unit", "margin", "pose", "case", "active", "saving")
    names = ("feasible", "objective", "minimized", "unit", "before", "searched", "evaluations", "poses", "beyond_limits")
    return {
        "robot": found.robot.name,
        **named(found, (*names, "parameters", "units", "allowed")),
        "requirements": [named(item, of_each) for item in found.requirements],
        "at_bounds": list(found.at_bounds),
        "idle": list(found.idle),
        "starts": [named(item, ("parameters", "objective", "feasible")) for item in found.starts],
    }


@text_of.register(ParetoFront)
def pareto_report(found: ParetoFront) -> str:
    """Return a table of designs, from the least of the first quantity to the least of the second."""
    first, second = found.minimized
    title = f"Pareto front of {found[0].robot.name!r}: {first} against {second}, {len(found)} designs"
    rows = []
    for optimum, row in zip(found, found.objectives.tolist(), strict=True):
        values = [_value(value, optimum.units.get(name, "")) for name, value in optimum.parameters.items()]
        decides = [item.text for item in optimum.active if item is not optimum.requirements[-1]]
        cells = (_written(value, unit) for value, unit in zip(row, found.units, strict=True))
        rows.append((*cells, *values, "; ".join([*decides, *optimum.at_bounds])))
    header = (first, second, *found.parameters, "what decides besides")
    lines = section("Designs of which none is better in both", table(header, rows, "r" * (len(header) - 1) + "l"))
    said = f"How: {found.searched}; {found.evaluations} robots were analysed."
    return "\n".join([title, *lines, "", *wrapped(said)])


@dict_of.register(ParetoFront)
def pareto_to_dict(found: ParetoFront) -> dict[str, object]:
    """Return a front as plain values: what ``optimize --pareto … --json`` prints."""
    names = ("minimized", "units", "objectives", "parameters", "searched", "evaluations")
    return {**named(found, names), "points": [optimum_to_dict(item) for item in found]}
