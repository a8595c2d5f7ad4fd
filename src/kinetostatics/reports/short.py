"""Robots, poses and results in one line, and as small tables for notebooks: what ``repr`` and ``_repr_html_`` return.

Nothing here computes what is not known or quickly found, and nothing fails: poses that could not be reached show dashes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.robot import RobotDescription
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.printing.dispatch import html_of, line_of
from kinetostatics.printing.html_tables import html_table
from kinetostatics.printing.text import (
    ANGLES,
    FORCES,
    LENGTHS,
    MASSES,
    MISSING,
    MOMENTS,
    NOISE,
    STRESSES,
    Magnitudes,
    Scale,
    Units,
    largest,
    listing,
)
from kinetostatics.reports.json import drive_unit, wrench_units
from kinetostatics.reports.tolerances import amount_words
from kinetostatics.results.beam import BeamResult
from kinetostatics.results.limb import LimbResult
from kinetostatics.results.result import Result
from kinetostatics.results.tolerances import Tolerances
from kinetostatics.robot import Robot
from kinetostatics.status import FACTS, WITHOUT_NUMBERS, Status

_MILLIMETRES: Units = (("mm", 1e-3),)
_DEGREES: Units = (("°", np.pi / 180),)
_PER_CENT: Units = (("%", 0.01),)
#: Rows of a table of tolerances in a notebook.
_WORST = 10


def values_words(values: ArrayLike, units: Units, noise: float = 0.0) -> str:
    """Write one number with its unit, or of several the smallest and the largest that are finite; ``noise`` counts as 0."""
    known = np.asarray(values, dtype=float).ravel()
    known = known[np.isfinite(known)]
    if not known.size:
        return MISSING
    scale = Scale.of(known, units, noise, digits=4)
    low, high = scale(known.min()), scale(known.max())
    unit = scale.unit if scale.unit == "°" else f" {scale.unit}"
    return low + unit if low == high else f"{low} to {high}{unit}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _statuses(poses: Configuration | Result) -> str:
    """Name all that is true of a pose; of a batch say its shape, and of how many poses it is true."""
    status = poses.status
    true = {item.name: status == item for item in (Status.OK, *WITHOUT_NUMBERS)}
    true |= {fact.title: getattr(poses, name) for name, fact in FACTS.items() if hasattr(poses, name)}
    if status.shape == ():
        return ", ".join(name for name, where in true.items() if where)
    counts = [f"{int(np.sum(where))} {name}" for name, where in true.items() if np.any(where)]
    return f"{_count(status.size, 'pose')}, batch shape {status.shape}" + (f": {', '.join(counts)}" if counts else "")


# ---- robots ----------------------------------------------------------------------------------------------------------


@line_of.register(Robot)
def robot_line(robot: Robot) -> str:
    """Return what ``repr`` shows of a robot."""
    description = robot.description
    counts = ((robot.topology.limbs, "limb"), (description.driven, "drive"), (description.beams, "beam"))
    return f"<Robot {robot.name!r} from {description.path!r}: {', '.join(_count(len(some), noun) for some, noun in counts)}>"


@html_of.register(Robot)
def robot_html(robot: Robot) -> str:
    """Return a table of a robot's limbs."""
    driven = set(robot.description.driven)
    rows = []
    for limb in robot.topology.limbs:
        joints = [edge.joint for edge in limb.edges if edge.joint is not None]
        beams = [edge.beam for edge in limb.edges if edge.beam is not None]
        drives = [joint for joint in joints if joint in driven]
        rows.append((limb.name, listing(joints), listing(drives) or MISSING, listing(beams) or MISSING))
    return html_table(robot_line(robot)[1:-1], ("limb", "joints", "drives", "beams"), rows)


@line_of.register(RobotDescription)
def description_line(description: RobotDescription) -> str:
    """Return what ``repr`` shows of a description."""
    counts = ", ".join(_count(len(some), noun) for some, noun in _tables(description) if some or noun in ("link", "joint"))
    return f"<RobotDescription {description.name!r} from {description.path!r}: {counts}>"


@html_of.register(RobotDescription)
def description_html(description: RobotDescription) -> str:
    """Return a table of what a description has."""
    rows = [(f"{noun}s", f"{len(some)}", listing(list(some), 12)) for some, noun in _tables(description) if some]
    title = f"RobotDescription {description.name!r} from {description.path!r}"
    return html_table(title, ("", "number", "names"), [*rows, ("platform", "1", description.platform)])


def _tables(description: RobotDescription) -> list[tuple[list[str], str]]:
    names = ("links", "joints", "loops", "beams", "joint_stiffness", "driven")
    nouns = ("link", "joint", "loop", "beam", "elastic joint", "drive")
    return [(list(getattr(description, name)), noun) for name, noun in zip(names, nouns, strict=True)]


# ---- poses -----------------------------------------------------------------------------------------------------------


@line_of.register(Configuration)
def configuration_line(configuration: Configuration) -> str:
    """Return what ``repr`` shows of a pose or a batch."""
    values = ", ".join(f"{name} {words}" for name, words in _coordinates(configuration)[:6])
    return f"<Configuration of {configuration.robot.name!r}: {_statuses(configuration)}; {values}>"


@html_of.register(Configuration)
def configuration_html(configuration: Configuration) -> str:
    """Return a table of a pose's coordinates; of a batch their ranges."""
    title = f"Configuration of {configuration.robot.name!r}: {_statuses(configuration)}"
    return html_table(title, ("coordinate", "value" if configuration.shape == () else "range"), _coordinates(configuration))


def _coordinates(configuration: Configuration) -> list[tuple[str, str]]:
    """Return the coordinates of platform and drives in words."""
    connections = configuration.robot.mechanism.connections
    slides = {"x", "y", "z", *(name for name in configuration.actuators if connections[name].type.is_slide)}
    both = (*configuration.platform.items(), *configuration.actuators.items())
    small = NOISE * configuration.robot.length
    return [
        (name, values_words(value, _MILLIMETRES, small) if name in slides else values_words(value, _DEGREES, NOISE))
        for name, value in both
    ]


# ---- results ---------------------------------------------------------------------------------------------------------


@line_of.register(Result)
def result_line(result: Result) -> str:
    """Return what ``repr`` shows of a result."""
    line = f"Result of {result.robot.name!r}: {_statuses(result)}"
    motions = dict(_motions(result))
    if MISSING not in motions.values():
        line += f"; o moves by {motions['displacement of o']}, the platform turns by {motions['rotation']}"
    return f"<{line}>"


@html_of.register(Result)
def result_html(result: Result) -> str:
    """Return a table of the platform's motion and of the drives' forces; of a batch their ranges."""
    rows = _motions(result)
    if result.shape == ():
        for k, name in enumerate(("x", "y", "z", "rx", "ry", "rz")):
            noise = _noise(result)[k >= 3]
            rows.append((f"twist {name}", values_words(result.twist[k], LENGTHS if k < 3 else ANGLES, noise)))
    for name, force in result.actuator_forces.items():
        rows.append((f"force of {name}", values_words(force, FORCES if drive_unit(result.robot, name) == "N" else MOMENTS)))
    title = f"Result of {result.robot.name!r}: {_statuses(result)}"
    return html_table(title, ("quantity", "value" if result.shape == () else "range"), rows)


def _motions(result: Result) -> list[tuple[str, str]]:
    shift, turn = (np.linalg.norm(result.twist[..., part], axis=-1) for part in (slice(0, 3), slice(3, 6)))
    noise = _noise(result)
    return [("displacement of o", values_words(shift, LENGTHS, noise[0])), ("rotation", values_words(turn, ANGLES, noise[1]))]


def _noise(result: Result) -> tuple[float, float]:
    """Return which displacements and rotations of the platform are rounding noise."""
    found = Magnitudes.of([*result.contributions.values(), result.twist], [], result.robot.length)
    return found.displacement, found.rotation


@line_of.register(LimbResult)
def limb_line(limb: LimbResult) -> str:
    """Return what ``repr`` shows of a limb of a result."""
    values = ", ".join(f"{label} {words}" for label, words in _intensities(limb))
    return f"<LimbResult {limb.name!r}: {values or 'no constraint wrench'}>"


@html_of.register(LimbResult)
def limb_html(limb: LimbResult) -> str:
    """Return a table of a limb's intensities."""
    return html_table(f"LimbResult {limb.name!r}", ("what the platform puts on the limb", "intensity"), _intensities(limb))


def _intensities(limb: LimbResult) -> list[tuple[str, str]]:
    found = []
    noise = {unit: NOISE * largest([limb.wrench[..., part]]) for unit, part in (("N", slice(0, 3)), ("N·m", slice(3, 6)))}
    for labels, wrenches, values in (
        (limb.labels, limb.constraint_wrenches, limb.intensities),
        (limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
    ):
        for k, (label, unit) in enumerate(zip(labels, wrench_units(labels, wrenches), strict=True)):
            found.append((label, values_words(values[..., k], FORCES if unit == "N" else MOMENTS, noise[unit])))
    return found


@line_of.register(BeamResult)
def beam_line(beam: BeamResult) -> str:
    """Return what ``repr`` shows of a beam of a result."""
    values = ", ".join(f"{name} {words}" for name, words in _beam(beam)[:4])
    return f"<BeamResult {beam.name!r}: {values}>"


@html_of.register(BeamResult)
def beam_html(beam: BeamResult) -> str:
    """Return a table of a beam's main numbers."""
    return html_table(f"BeamResult {beam.name!r}", ("quantity", "value"), _beam(beam))


def _beam(beam: BeamResult) -> list[tuple[str, str]]:
    axial = beam.section_wrenches[..., 0]
    return [
        ("length", values_words(beam.length, _MILLIMETRES)),
        ("axial force", values_words(axial, FORCES)),
        ("stress", values_words(beam.stress, STRESSES)),
        ("N/N_Euler", values_words(beam.euler_ratio, _PER_CENT)),
        ("mass", values_words(beam.mass, MASSES)),
        ("largest deflection", values_words(np.linalg.norm(beam.deflections, axis=-1).max(axis=-1), LENGTHS)),
    ]


# ---- tolerances ------------------------------------------------------------------------------------------------------


@line_of.register(Tolerances)
def tolerances_line(found: Tolerances) -> str:
    """Return what ``repr`` shows of tolerances."""
    line = f"Tolerances of {found.configuration.robot.name!r}: {_count(len(found), 'error')}, ranked by {found.ranked_by}"
    if found.rows:
        worst = found.rows[0]
        shift, force = values_words(worst.displacement, LENGTHS), values_words(worst.force, FORCES)
        line += f"; the worst is {worst.error} of {worst.name} by {amount_words(worst)}: it moves o by {shift}"
        line += f" and locks in {force}" if worst.force > 0 else ""
    return f"<{line}>"


@html_of.register(Tolerances)
def tolerances_html(found: Tolerances) -> str:
    """Return a table of the worst errors."""
    rows = [
        (
            *(row.name, row.error, amount_words(row), values_words(row.displacement, LENGTHS)),
            *(values_words(row.rotation, ANGLES), values_words(row.force, FORCES), row.at or MISSING),
        )
        for row in found.rows[:_WORST]
    ]
    left = len(found) - len(rows)
    title = f"Tolerances of {found.configuration.robot.name!r}, ranked by {found.ranked_by}"
    title += f": the worst {len(rows)} of {len(found)}" if left else ""
    return html_table(title, ("what", "error", "by", "moves o", "turns", "force", "at"), rows)
