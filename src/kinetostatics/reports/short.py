"""Robots, poses and results in one line, and as small tables for notebooks: what ``repr`` and ``_repr_html_`` return.

Nothing here computes what is not known or quickly found, and nothing fails: poses that could not be reached show dashes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.robot import RobotDescription
from kinetostatics.files.bundled import shown_path
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.printing.dispatch import html_of, line_of
from kinetostatics.printing.html import html_table
from kinetostatics.printing.text import (
    ANGLES,
    FORCES,
    KINDS,
    LENGTHS,
    MASSES,
    MILLIMETRES,
    MISSING,
    NOISE,
    PER_CENT,
    STRESSES,
    UNITS_OF,
    Magnitudes,
    Scale,
    Units,
    largest,
    listing,
)
from kinetostatics.reports.calibration import estimate_words, interval_words
from kinetostatics.reports.json import actuator_unit, wrench_units
from kinetostatics.reports.pose import actuator_coordinates, facts_of, platform_coordinates, statuses_of
from kinetostatics.results.beam import BeamResult
from kinetostatics.results.calibration import Calibration, MeasurementPlan
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.limb import LimbResult
from kinetostatics.results.optimum import Optimum
from kinetostatics.results.pareto import ParetoFront
from kinetostatics.results.result import Result
from kinetostatics.results.sensitivities import Sensitivities, is_location
from kinetostatics.results.tolerances import Tolerances
from kinetostatics.results.tool_point import named_point
from kinetostatics.robot import Robot

#: Rows of a table of tolerances in a notebook.
_WORST = 10


@dataclass(frozen=True)
class Short:
    """What there is to say in short.

    Attributes:
        line: what ``repr`` shows, in angle brackets.
        title: of the table.
        header: titles of the table's columns.
        rows: of the table; what takes time is worked out when they are asked for.
    """

    line: str
    title: str
    header: Sequence[str]
    rows: Iterable[Sequence[str]]


@singledispatch
def _short(item: object) -> Short:
    raise NotImplementedError(f"nothing is registered that writes a {type(item).__name__} in short")


def _line(item: object) -> str:
    return f"<{_short(item).line}>"


def _html(item: object) -> str:
    found = _short(item)
    return html_table(found.title, found.header, found.rows)


# ---- words -----------------------------------------------------------------------------------------------------------


def values_words(values: ArrayLike, units: Units, noise: float = 0.0) -> str:
    """Write one number with its unit, or of several the smallest and the largest that are finite; ``noise`` counts as 0."""
    known = np.asarray(values, dtype=float).ravel()
    known = known[np.isfinite(known)]
    if not known.size:
        return MISSING
    scale = Scale.of(known, units, noise, digits=4)
    low, high = scale(known.min()), scale(known.max())
    return scale.with_unit(known.max()) if low == high else f"{low} to {scale.with_unit(known.max())}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _listed(rows: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{name} {words}" for name, words in rows)


def _statuses(poses: Configuration | Result) -> str:
    """Name all that is true of a pose; of a batch say its shape, and of how many poses it is true."""
    true = [(title, where) for title, where, _ in (*statuses_of(poses), *facts_of(poses))]
    if poses.shape == ():
        return ", ".join(title for title, where in true if where)
    counts = [f"{int(np.sum(where))} {title}" for title, where in true if np.any(where)]
    size = poses.status.size
    return f"{_count(size, 'pose')}, batch shape {poses.shape}" + (f": {', '.join(counts)}" if counts else "")


# ---- robots and poses ------------------------------------------------------------------------------------------------


@_short.register
def _robot(robot: Robot) -> Short:
    description, rows = robot.description, []
    for limb in robot.topology.limbs:
        joints = [edge.joint for edge in limb.edges if edge.joint is not None]
        beams = [edge.beam for edge in limb.edges if edge.beam is not None]
        actuators = [joint for joint in joints if joint in description.driven]
        rows.append((limb.name, listing(joints), listing(actuators) or MISSING, listing(beams) or MISSING))
    counts = ((robot.topology.limbs, "limb"), (description.driven, "actuator"), (description.beams, "beam"))
    has = ", ".join(_count(len(some), noun) for some, noun in counts)
    title = f"Robot {robot.name!r} from {shown_path(description.path)!r}: {has}"
    return Short(title, title, ("limb", "joints", "actuators", "beams"), rows)


@_short.register
def _description(description: RobotDescription) -> Short:
    names = ("links", "joints", "loops", "beams", "joint_stiffness", "driven")
    nouns = ("link", "joint", "loop", "beam", "elastic joint", "actuator")
    found = [(list(getattr(description, name)), noun) for name, noun in zip(names, nouns, strict=True)]
    counts = ", ".join(_count(len(some), noun) for some, noun in found if some or noun in ("link", "joint"))
    rows = [(f"{noun}s", f"{len(some)}", listing(some, 12)) for some, noun in found if some]
    title = f"RobotDescription {description.name!r} from {shown_path(description.path)!r}"
    return Short(f"{title}: {counts}", title, ("", "number", "names"), [*rows, ("platform", "1", description.platform)])


@_short.register
def _configuration(configuration: Configuration) -> Short:
    both = {**platform_coordinates(configuration), **actuator_coordinates(configuration)}
    rows = [(name, values_words(*item)) for name, item in both.items()]
    title = f"Configuration of {configuration.robot.name!r}: {_statuses(configuration)}"
    header = ("coordinate", "value" if configuration.shape == () else "range")
    return Short(f"{title}; {_listed(rows[:6])}", title, header, rows)


# ---- results ---------------------------------------------------------------------------------------------------------


@_short.register
def _result(result: Result) -> Short:
    noise = Magnitudes.of([*result.contributions.values(), result.twist], [], result.robot.length)
    shift, turn = (np.linalg.norm(result.twist[..., part], axis=-1) for part in (slice(3), slice(3, 6)))
    moves, turns = values_words(shift, LENGTHS, noise.displacement), values_words(turn, ANGLES, noise.rotation)

    def rows() -> Iterator[tuple[str, str]]:
        yield from (("displacement of o", moves), ("rotation", turns))
        for k, name in enumerate(("x", "y", "z", "rx", "ry", "rz") if result.shape == () else ()):
            kind = "displacement" if k < 3 else "rotation"
            yield f"twist {name}", values_words(result.twist[k], KINDS[kind], getattr(noise, kind))
        for name, force in result.actuator_forces.items():
            yield f"force of {name}", values_words(force, UNITS_OF[actuator_unit(result.robot, name)])

    more = "" if MISSING in (moves, turns) else f"; o moves by {moves}, the platform turns by {turns}"
    title = f"Result of {result.robot.name!r}: {_statuses(result)}"
    return Short(title + more, title, ("quantity", "value" if result.shape == () else "range"), rows())


@_short.register
def _limb(limb: LimbResult) -> Short:
    rows = []
    noise = {"N": NOISE * largest([limb.wrench[..., :3]]), "N·m": NOISE * largest([limb.wrench[..., 3:]])}
    for labels, wrenches, values in (
        (limb.labels, limb.constraint_wrenches, limb.intensities),
        (limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
    ):
        for k, (label, unit) in enumerate(zip(labels, wrench_units(labels, wrenches), strict=True)):
            rows.append((label, values_words(values[..., k], UNITS_OF[unit], noise[unit])))
    title, words = f"LimbResult {limb.name!r}", _listed(rows) or "no constraint wrench"
    return Short(f"{title}: {words}", title, ("wrench acting on the limb", "intensity"), rows)


@_short.register
def _beam(beam: BeamResult) -> Short:
    rows = [
        ("length", values_words(beam.length, MILLIMETRES)),
        ("axial force", values_words(beam.section_wrenches[..., 0], FORCES)),
        ("stress", values_words(beam.stress, STRESSES)),
        ("N/N_Euler", values_words(beam.euler_ratio, PER_CENT)),
        ("mass", values_words(beam.mass, MASSES)),
        ("largest deflection", values_words(np.linalg.norm(beam.deflections, axis=-1).max(axis=-1), LENGTHS)),
    ]
    title = f"BeamResult {beam.name!r}"
    return Short(f"{title}: {_listed(rows[:4])}", title, ("quantity", "value"), rows)


@_short.register
def _compensation(found: Compensation) -> Short:
    connections = found.target.robot.mechanism.connections
    rows = [
        (
            name,
            values_words(shift, UNITS_OF[connections[name].type.unit]),
            values_words(found.actuator_forces[name], UNITS_OF[connections[name].type.force_unit]),
        )
        for name, shift in found.corrections.items()
    ]
    before, after = (
        values_words(np.linalg.norm(t[..., :3], axis=-1), LENGTHS) for t in (found.uncorrected_error, found.residual_error)
    )
    title = f"Compensation of {found.target.robot.name!r}: {_statuses(found.result)}"
    line = f"{title}; {named_point(found.tool)} misses its place by {before} uncorrected, by {after} corrected"
    return Short(line, title, ("actuator", "correction", "force"), rows)


@_short.register
def _optimum(found: Optimum) -> Short:
    rows = [(name, f"{value:.6g} {found.units.get(name, '')}".rstrip()) for name, value in found.parameters.items()]
    rows += [(item.text, f"{item.worst:.6g} {item.unit}".rstrip()) for item in found.requirements]
    title = f"Optimum of {found.robot.name!r}: {'feasible' if found.feasible else 'NOT feasible'}"
    line = f"{title}, {found.minimized} {found.objective:.6g} {found.unit} at {_listed(rows[: len(found.parameters)])}"
    return Short(line, title, ("parameter or requirement", "value or worst"), rows)


@_short.register
def _calibration(found: Calibration) -> Short:
    rows = [(item.name, estimate_words(item, item.value), interval_words(item)) for item in found.estimates.values()]
    title = f"Calibration of {found.robot.name!r} from {_count(len(found.measured), 'reading')}"
    line = f"{title}: {_listed(row[:2] for row in rows[:6])}"
    line += f"; {len(found.unidentifiable)} not told" if found.unidentifiable else ""
    line += f"; {_count(len(found.outliers), 'outlier')}" if found.outliers else ""
    return Short(line, title, ("unknown", "estimate", f"{100 * found.level:.4g} % interval"), rows)


@_short.register
def _plan(found: MeasurementPlan) -> Short:
    title = f"MeasurementPlan of {found.robot.name!r}: {_count(len(found.chosen), 'measurement')} out of {found.candidates}"
    errors = found.random_standard_errors
    rows = [(name, f"{error:.3g}", f"{errors[name]:.3g}") for name, error in found.standard_errors.items()]
    line = f"{title}, {found.gain:.3g} times as sure as random ones"
    return Short(line, title, ("unknown", "standard error", "of random plans"), rows)


@_short.register
def _pareto(found: ParetoFront) -> Short:
    names, units = list(found.parameters), found.points[0].units
    rows = []
    for optimum, both in zip(found, found.objectives.tolist(), strict=True):
        cells = [f"{value:.6g} {unit}".rstrip() for value, unit in zip(both, found.units, strict=True)]
        cells += [f"{optimum.parameters[name]:.6g} {units.get(name, '')}".rstrip() for name in names]
        rows.append(tuple(cells))
    title = f"Pareto front of {found[0].robot.name!r}"
    line = f"{title}: {_count(len(found), 'design')}, {found.minimized[0]} {rows[0][0]} to {rows[-1][0]}, "
    line += f"{found.minimized[1]} {rows[0][1]} to {rows[-1][1]}"
    return Short(line, title, (*found.minimized, *names), rows)


@_short.register
def _sensitivities(found: Sensitivities) -> Short:
    rows, sizes = [], [name for name in found if not is_location(name)]
    title, who = f"Sensitivities of {found.result.robot.name!r}", named_point(found.tool)
    line = f"{title}: {_count(len(found), 'parameter')}, {_count(len(found.sources), 'elastic part')}"
    shown = [("twist", f"1 % more moves {who} by", LENGTHS), ("mass", "adds", MASSES)]
    kept = [k for k, (name, *_) in enumerate(shown) if name in found.of]
    for name in sizes[:_WORST]:
        value = f"{found[name].value:.6g} {found[name].unit}".rstrip()
        rows.append((name, value, *(values_words(found.effect(name)[k], shown[k][2]) for k in kept)))
    if rows and "twist" in found.of:
        line += f"; one per cent more of {rows[0][0]} moves {who} by {rows[0][2]}"
    return Short(line, title, ("parameter", "value", *(shown[k][1] for k in kept)), rows)


@_short.register
def _tolerances(found: Tolerances) -> Short:
    who, rows = named_point(found.tool), []
    for name in ("displacement", "rotation"):
        units = LENGTHS if name == "displacement" else ANGLES
        several = [float(item.named(name)) for item in (found.nominal, found.worst_case, found.standard_deviation)]
        rows.append((name, *(values_words(value, units) for value in (*several, found.sampled(name)[1]))))
    title = f"Tolerances of {found.result.robot.name!r}"
    line = f"{title}, {_count(len(found.parameters), 'parameter')}: {who} is {rows[0][2]} off at worst, standard deviation "
    line += rows[0][3]
    for name, effect in [*found.effects.items()][:1]:
        line += f"; the largest effect is of {name}: it moves {who} by {values_words(effect.displacement, LENGTHS)}"
        line += f" and locks in {values_words(effect.force, FORCES)}" if effect.force > 0 else ""
    return Short(line, title, ("quantity", "nominal", "worst case ±", "standard deviation", "of random samples"), rows)


for _shown in {*_short.registry} - {object}:
    line_of.register(_shown, _line)
    html_of.register(_shown, _html)
