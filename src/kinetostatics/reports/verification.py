"""Report of a verification: both solutions side by side, their differences, and the verdict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from kinetostatics.layout.blocks import Block, Cell, Column, Number, ReportSection, Table, Text, Word
from kinetostatics.layout.numbers import STIFFNESSES, TURNING_STIFFNESSES, NoiseFloor, NumberFormat
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.quantities import QUANTITIES
from kinetostatics.reports.dynamics import HERTZ
from kinetostatics.reports.parts import sizes
from kinetostatics.reports.pose import pose_facts
from kinetostatics.verification.compare import Verification

UNITS = {
    "general": "SI: m, rad, N, N·m; world axes; null: not a number or infinite",
    **{name: QUANTITIES[name].description for name in ("twist", "compliance", "stiffness", "joint_wrenches", "actuator_forces")},
    "beam_wrenches": "[force N; moment N·m] of the outer part of a beam on the inner part, at its base and its platform end",
    "frequencies": "natural frequencies [Hz]: ours, finite elements",
    "differences": "relative, of whole twists, wrenches and matrices; angles and moments are made comparable with lengths and "
    "forces by `length` [m]; differences of forces are relative to the largest joint wrench",
    "scatter": "accuracy of the finite-element solution, in the same form as `differences`",
}

WORDS = {
    "twist": "twist of the platform",
    "compliance": "compliance",
    "stiffness": "stiffness",
    "joint_wrenches": "joint wrenches",
    "beam_wrenches": "wrenches in beams",
    "actuator_forces": "actuator forces",
    "frequencies": "natural frequencies",
}

#: Significant digits of the largest number of a table.
DIGITS = 8
HEADER = ("", "kinetostatics", "finite elements", "difference")


def verification_report(check: Verification) -> Report:
    robot = check.configuration.robot
    verdict, _, more = (check.verdict[0].upper() + check.verdict[1:]).partition(":")
    lead = Word(verdict, "good" if check.verified else "bad" if check.conclusive else "doubtful")
    title = [f"Check of {robot.name!r} by finite elements (OpenSees): ", Word(check.verdict.partition(":")[0], lead.tone)]
    return Report(title, lambda: [*_sections(check), ReportSection("", [Text(f":{more}", lead=lead)])], lambda: _data(check))


def _sections(check: Verification) -> Iterator[ReportSection]:
    theirs, result = check.finite_elements, check.result
    yield ReportSection("Pose", [pose_facts(check.configuration, result.gravity, result.load)], "pose")
    noise = NoiseFloor.of([theirs.twist], theirs.joint_wrenches.values(), check.length)
    formats = noise.format("displacement", theirs.twist[:3], DIGITS), noise.format("rotation", theirs.twist[3:], DIGITS)
    twist = _components(check.ours.twist, theirs.twist, *formats)
    yield ReportSection("Twist of the platform at o, world axes", [twist], "twist")
    title = "Stiffness of the platform at o, world axes, actuators locked: the diagonal"
    yield ReportSection(title, [_stiffness(check)], "stiffness")
    title = "Actuators, positive along the joint's positive direction"
    yield ReportSection(title, _actuators(check, noise) if theirs.actuator_forces else [], "forces")
    title = "Joints: wrench of the base side acting on the platform side, magnitudes about the joint's centre"
    yield ReportSection(title, [_joints(check, noise)], "joints")
    if check.frequencies[0].size:
        computed, reference = check.frequencies
        form = NumberFormat.of(reference, HERTZ, digits=DIGITS)
        table = _rows([f"mode {k + 1}" for k in range(len(computed))], computed, reference, [form] * len(computed))
        yield ReportSection("Natural frequencies", [table], "modes")
    rows = [
        (
            WORDS[name],
            f"{value:.1e}",
            f"{check.scatter.get(name, np.nan):.1e}",
            Word("ok", "good") if value <= check.allowed(name) else Word("DIFFERS", "bad"),
        )
        for name, value in check.differences.items()
    ]
    table = Table.of_rows(("", "difference", "accuracy of finite elements", ""), rows, "lrrl")
    missing = [Text(f"{name}: not compared: {why}") for name, why in check.not_compared.items()]
    yield ReportSection("Differences, relative", [table, *missing], "differences")


def _rows(names: Iterable[str], ours: Iterable[float], theirs: Iterable[float], formats: Iterable[NumberFormat]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for name, computed, reference, form in zip(names, ours, theirs, formats, strict=True):
        gap = (computed - reference) / form.factor if np.isfinite(reference) else np.nan
        numbers = (Number(float(value), form, with_unit=False) for value in (computed, reference))
        difference = "0" if max(abs(computed), abs(reference)) <= form.noise else f"{gap:.0e}" if np.isfinite(gap) else "–"
        rows.append((f"{name} [{form.unit}]", *numbers, difference))
    return Table.of_rows(HEADER, rows)


def _components(ours: Array, theirs: Array, linear: NumberFormat, angular: NumberFormat) -> Table:
    return _rows(COMPONENTS, ours, theirs, [linear] * 3 + [angular] * 3)


def _stiffness(check: Verification) -> Block:
    ours, theirs = np.diag(check.ours.stiffness), np.diag(check.finite_elements.stiffness)
    if np.any(np.isnan(ours)):
        return Text("infinite: rigid limbs")
    linear = NumberFormat.of(theirs[:3], STIFFNESSES, digits=DIGITS)
    return _components(ours, theirs, linear, NumberFormat.of(theirs[3:], TURNING_STIFFNESSES, digits=DIGITS))


def _actuators(check: Verification, noise: NoiseFloor) -> list[Block]:
    ours, theirs = check.ours.actuator_forces, check.finite_elements.actuator_forces
    rotating = check.finite_elements.rotating_actuators
    force = noise.format("force", [value for name, value in theirs.items() if name not in rotating], DIGITS)
    torque = noise.format("moment", [theirs[name] for name in rotating], DIGITS)
    formats = [torque if name in rotating else force for name in theirs]
    return [_rows(theirs, [ours[name] for name in theirs], theirs.values(), formats)]


def _joints(check: Verification, noise: NoiseFloor) -> Table:
    ours, theirs = check.ours.joint_wrenches, check.finite_elements.joint_wrenches
    names = [name for name in theirs if name in ours]
    (force, moment), (force_fe, moment_fe) = (sizes(side[name] for name in names) for side in (ours, theirs))
    forces, moments = noise.format("force", force_fe), noise.format("moment", moment_fe)
    gaps = [f"{check.joint_differences.get(name, np.nan):.0e}" for name in names]
    return Table(
        [
            Column("joint", names),
            Column.of("force", force, forces),
            Column.of("finite el.", force_fe, forces, with_unit=False),
            Column.of("moment", moment, moments),
            Column.of("finite el.", moment_fe, moments, with_unit=False),
            Column("difference, rel.", gaps, "r"),
        ]
    )


def _data(check: Verification) -> dict[str, object]:
    arrays = ("twist", "compliance", "stiffness", "joint_wrenches", "beam_wrenches", "actuator_forces")
    robot = check.configuration.robot
    return {
        "robot": robot.name,
        "file": robot.description.path,
        **attributes(check, ("verified", "conclusive", "verdict", "within", "length")),
        **attributes(check.configuration, ("platform", "actuators")),
        **attributes(check.result, ("load", "gravity")),
        **attributes(check, ("differences", "scatter", "joint_differences", "not_compared")),
        "ours": attributes(check.ours, arrays),
        "finite_elements": attributes(check.finite_elements, arrays),
        **({"frequencies": list(check.frequencies)} if check.frequencies[0].size else {}),
        "units": UNITS,
    }
