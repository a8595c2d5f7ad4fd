"""What a person reads of an analysis: ``print(result)`` and ``kinetostatics analyze``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import free_twists
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import EQUAL, first_largest
from kinetostatics.math.screws import describe_twist
from kinetostatics.printing.dispatch import text_of
from kinetostatics.printing.text import (
    ANGLES,
    CLOSED,
    ENERGIES,
    FORCES,
    LENGTHS,
    MASSES,
    MISSING,
    MOMENTS,
    NOISE,
    STIFFNESSES,
    STRESSES,
    TURNING_STIFFNESSES,
    Magnitudes,
    Scale,
    listing,
    quantity,
    section,
    table,
    vector,
    warning_lines,
    wide_table,
    wrapped,
)
from kinetostatics.reports.batch import batch_report, magnitudes
from kinetostatics.reports.gravity import drive_parts, gravity_twists
from kinetostatics.reports.json import drive_unit, wrench_units
from kinetostatics.reports.limb_axes import checked, named
from kinetostatics.reports.sources import source_lines
from kinetostatics.results.result import Result
from kinetostatics.sections.kinds import Section
from kinetostatics.statics.joint_table import passive_joints
from kinetostatics.statics.solution import UNBALANCED
from kinetostatics.status import FACTS, STATUS_WORDS, WITHOUT_NUMBERS, Status

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


@text_of.register(Result)
def result_report(result: Result, hinge_axes: Mapping[str, str] | None = None) -> str:
    """Return what an analysis found: tables with units for one pose, a summary for a batch of poses.

    Args:
        result: of :func:`kinetostatics.analyze`.
        hinge_axes: as in :meth:`kinetostatics.Result.report`.
    """
    hinge_axes = checked(hinge_axes or {}, result.limbs)
    if result.shape != ():
        return batch_report(result)
    status = Status(int(result.status))
    lines = [f"Analysis of {result.robot.name!r}: {_status_words(result)}"]
    lines += section("Pose", _pose(result))
    if status == Status.SINGULAR:
        lines += section("What can still move", _free_motions(result))
    if status not in WITHOUT_NUMBERS:
        noise = magnitudes(result)
        lines += section("Twist of the platform at o, world axes", _twist(result, noise))
        if result.robot.topology.limbs:
            lines += section("What gravity does, by the ways in which it acts", _twist_table(gravity_twists(result), noise))
        if any(kind in result.source_contributions for kind in ("joints", "drives", "misfits")):
            lines += section(
                "What gives way: the same twist by beams, elastic joints, drives and misfits", _sources(result, noise)
            )
        ranking = source_lines(result, noise)
        if ranking:
            lines += section("Where the sag comes from: parts along the whole displacement and rotation", ranking)
        if result.part_contributions:
            lines += section("What gives way in the parts of the limbs", _parts(result, noise))
        lines += section("Stiffness of the platform at o, world axes, drives locked", _stiffness(result))
        if result.actuator_forces:
            lines += section("Drives, positive along the joint's positive direction", _drives(result, noise))
        lines += section("Limbs: what the platform puts on the limb", _limbs(result, noise, hinge_axes))
        networks = _networks(result, noise)
        if networks:
            lines += section("Limbs that are networks: what their beams and their joints to the platform carry", networks)
        lines += section(
            "Joints: what the base side puts on the platform side, magnitudes about the joint's centre",
            _joints(result, noise),
        )
        lines += section("Ground: what it puts on the robot, about the base link's origin", _base(result, noise))
        if result.beams:
            lines += section("Beams", _beams(result, noise))
            what = "beams and elastic joints" if result.robot.description.joint_stiffness else "beams"
            lines += ["", f"Strain energy of the {what}  {quantity(result.strain_energy, ENERGIES)}"]
    lines += warning_lines(result.warnings)
    return "\n".join(lines)


# ---- the pose ------------------------------------------------------------------------------------------------------


def _status_words(result: Result) -> str:
    """Return everything that is true of a pose, the worst first."""
    status = Status(int(result.status))
    found = [f"{status.name}, {STATUS_WORDS[status]}"] if status in WITHOUT_NUMBERS else []
    found += [f"{fact.title}, {fact.words}" for fact in reversed(list(FACTS.values())) if result.facts[fact.name]]
    return "\n  also ".join(found) or f"{status.name}, {STATUS_WORDS[status]}"


def _pose(result: Result) -> list[str]:
    configuration = result.configuration
    rows = [
        ("o", position_words(configuration)),
        ("orientation", angles_words(configuration)),
        ("actuators", drives_words(configuration)),
    ]
    gravity, load = result.gravity, result.load
    rows.append(("gravity", vector(gravity, Scale.of(gravity, (("m/s²", 1.0),), digits=4))))
    force, moment = Scale.of(load[:3], FORCES), Scale.of(load[3:], MOMENTS)
    rows.append(("load at o", f"force {vector(load[:3], force)}, moment {vector(load[3:], moment)}"))
    if configuration.openings and np.isfinite(configuration.residual):
        open_by = float(configuration.residual)
        rows.append(("loops", "closed" if open_by <= CLOSED else f"open by at most {open_by:.1e} (m or rad)"))
    return [line for name, text in rows for line in wrapped(text, f"{name:13}")]


def position_words(configuration: Configuration) -> str:
    """Return the platform's position in mm."""
    values = [configuration.platform[name] for name in "xyz"]
    scale = Scale("mm", 1e-3, 4, NOISE * configuration.robot.length)
    return "  ".join(f"{name} {scale(value)}" for name, value in zip("xyz", values, strict=True)) + f" {scale.unit}"


def angles_words(configuration: Configuration) -> str:
    """Return the platform's orientation in degrees, and what the angles mean."""
    orientation = configuration.orientation
    values = [np.degrees(configuration.platform[name]) for name in orientation.names]
    scale = Scale("°", 1.0, 4, 1e-7)
    words = {"rotation_vector": "rotation vector", "tilt_torsion": "tilt and torsion"}
    meaning = words.get(orientation.name, f"angles {orientation.name!r}")
    angles = "  ".join(f"{name} {scale(value)}°" for name, value in zip(orientation.names, values, strict=True))
    return f"{angles}  ({meaning})"


def drives_words(configuration: Configuration) -> str:
    """Return the coordinates of the driven joints."""
    found = [f"{name} {coordinate_words(configuration, name)}" for name in configuration.actuators]
    return ", ".join(found) or "none"


def coordinate_words(configuration: Configuration, name: str) -> str:
    """Return the coordinate of one driven joint in mm or degrees."""
    value = configuration.actuators[name]
    if configuration.robot.mechanism.connections[name].type.is_slide:
        return Scale("mm", 1e-3, 4, 1e-11).with_unit(value)
    return Scale("°", 1.0, 4, 1e-8)(np.degrees(value)) + "°"


def _free_motions(result: Result) -> list[str]:
    robot, solution = result.robot, result.solutions[0]
    found = [
        f"{owner}: its passive joints {', '.join(passive_joints(robot.statics, owner))} do not carry all of its weight"
        for owner, part in solution.unbalanced.items()
        if part[0] > UNBALANCED
    ]
    found += [f"the platform: {describe_twist(twist, robot.length)}" for twist in free_twists(robot, solution, 0).T]
    return [line for text in found or ["the pose is too close to a singular one"] for line in wrapped(text, "- ")]


# ---- the platform --------------------------------------------------------------------------------------------------


def _twist(result: Result, noise: Magnitudes) -> list[str]:
    return _twist_table({**result.contributions, "total": result.twist}, noise)


def _sources(result: Result, noise: Magnitudes) -> list[str]:
    sums = {kind: np.sum(list(named.values()), axis=0) for kind, named in result.source_contributions.items()}
    return _twist_table({**sums, "total": result.twist}, noise)


def _parts(result: Result, noise: Magnitudes) -> list[str]:
    found = {}
    for limb in result.robot.topology.limbs:
        for part, twist in zip(limb.parts, result.part_contributions.get(limb.name, ()), strict=False):
            found[f"{limb.name}: {part.start} → {part.end}"] = twist
    return _twist_table(found, noise)


def _twist_table(contributions: Mapping[str, Array], noise: Magnitudes) -> list[str]:
    shift = Scale.of([t[:3] for t in contributions.values()], LENGTHS, noise.displacement, digits=6)
    turn = Scale.of([t[3:] for t in contributions.values()], ANGLES, noise.rotation, digits=6)
    rows = []
    for k, name in enumerate(COMPONENTS):
        scale = shift if k < 3 else turn
        rows.append([f"{name} [{scale.unit}]", *(scale(twist[k]) for twist in contributions.values())])
    return wide_table(["", *contributions], rows)


def _stiffness(result: Result) -> list[str]:
    held, free = np.diag(result.stiffness), _reciprocal(np.diag(result.compliance), result)
    rows = []
    for part, units in ((slice(0, 3), STIFFNESSES), (slice(3, 6), TURNING_STIFFNESSES)):
        scale = Scale.of([held[part], free[part]], units, digits=6)
        for k in range(6)[part]:
            rows.append((f"{COMPONENTS[k]} [{scale.unit}]", scale(held[k]), scale(free[k])))
    lines = table(("", "others held", "others free"), rows)
    values, axes = np.linalg.eigh(result.compliance[:3, :3])
    sizes = _reciprocal(values, result)
    for word, k in (("softest", 2), ("stiffest", 0)):
        alike = axes[:, np.abs(values - values[k]) <= EQUAL * abs(values[k])]
        found = "rigid" if np.isinf(sizes[k]) else f"{quantity(sizes[k], STIFFNESSES)} {_directions(alike)}"
        lines.append(f"{word} against a force at o: {found}")
    return lines


def _reciprocal(compliances: Array, result: Result) -> Array:
    """Return 1/C; infinite where rigid limbs leave no more than rounding noise."""
    C = np.abs(result.compliance)
    length = result.robot.length
    small = 1e-12 * max(float(C[:3, :3].max()), length**2 * float(C[3:, 3:].max()))
    return np.where(np.abs(compliances) > small, 1 / np.where(compliances == 0, 1.0, compliances), np.inf)


def _directions(axes: Array) -> str:
    """Say along which directions something is that orthonormal axes (3, 1 … 3) span."""
    if axes.shape[1] == 3:
        return "in every direction"
    if axes.shape[1] == 1:
        return f"along {_direction(axes[:, 0])}"
    normal = np.cross(axes[:, 0], axes[:, 1])
    planes = [plane for plane, part in zip(("yz", "xz", "xy"), np.abs(normal), strict=True) if part > 1 - EQUAL**2]
    return f"in every direction of the {planes[0]} plane" if planes else f"in every direction across {_direction(normal)}"


def _direction(axis: Array) -> str:
    axis = axis * np.sign(axis[first_largest(np.abs(axis))])
    return "(" + ", ".join("0" if abs(value) < 5e-4 else f"{value:.3f}" for value in axis) + ")"


# ---- forces --------------------------------------------------------------------------------------------------------


def _drives(result: Result, noise: Magnitudes) -> list[str]:
    units = {name: drive_unit(result.robot, name) for name in result.actuator_forces}
    scales = _force_scales(result.actuator_forces.values(), units.values(), noise)
    parts = drive_parts(result)
    rows = []
    for k, (name, force) in enumerate(result.actuator_forces.items()):
        scale = scales[units[name]]
        made_of = (scale(part[k]) for part in parts.values())
        rows.append((name, coordinate_words(result.configuration, name), scale(force), units[name], *made_of))
    return table(("joint", "position", "force", "", *parts), rows, "lrrl" + "r" * len(parts))


def _force_scales(values: Iterable[ArrayLike], units: Iterable[str], noise: Magnitudes) -> dict[str, Scale]:
    """Return one scale for the forces and one for the moments among some values."""
    pairs = [(float(np.asarray(value)), unit) for value, unit in zip(values, units, strict=True)]
    return {
        "N": Scale.of([value for value, unit in pairs if unit == "N"], FORCES, noise.force),
        "N·m": Scale.of([value for value, unit in pairs if unit == "N·m"], MOMENTS, noise.moment),
    }


def _limbs(result: Result, noise: Magnitudes, hinge_axes: Mapping[str, str]) -> list[str]:
    entries: list[tuple[str, str, Any, str, str]] = []
    for limb in result.limbs.values():
        units = wrench_units(limb.labels, limb.constraint_wrenches)
        attached = wrench_units(limb.attached_labels, limb.attached_wrenches)
        for label, value, unit in zip(limb.labels, limb.intensities, units, strict=True):
            entries.append((limb.name, *named(label, value, hinge_axes.get(limb.name, "y")), unit, "constraint"))
        for label, value, unit in zip(limb.attached_labels, limb.attached_intensities, attached, strict=True):
            entries.append((limb.name, *named(label, value, hinge_axes.get(limb.name, "y")), unit, "attached"))
    scales = _force_scales([entry[2] for entry in entries], [entry[3] for entry in entries], noise)
    rows, before = [], ""
    for name, label, value, unit, kind in entries:
        rows.append((name if name != before else "", label, kind, scales[unit](value), unit))
        before = name
    lines = table(("limb", "wrench", "", "intensity", ""), rows, "lllrl")
    networks = [limb.name for limb in result.limbs.values() if limb.is_network]
    if networks:
        verb = "are networks: their" if networks[1:] else "is a network: its"
        lines += wrapped(f"{listing(networks)} {verb} components are coordinates in a basis, not forces in beams or joints")
    return lines


def _networks(result: Result, noise: Magnitudes) -> list[str]:
    """Return the axial forces of beams and the sizes of joint wrenches at the platform of limbs that are networks."""
    entries: list[tuple[str, str, str, Any, Any]] = []
    for limb in result.limbs.values():
        if limb.is_network:
            for name in limb.beams:
                force = result.beams[name].section_wrenches[-1, 0]
                entries.append((limb.name, name, "axial force at the outer end", force, None))
            for name in limb.platform_joints:
                wrench = result.joint_wrenches[name]
                f, m = np.linalg.norm(wrench[:3]), np.linalg.norm(wrench[3:])
                entries.append((limb.name, name, "joint to the platform", f, m))
    force = Scale.of([entry[3] for entry in entries], FORCES, noise.force)
    moment = Scale.of([entry[4] for entry in entries if entry[4] is not None], MOMENTS, noise.moment)
    rows, before = [], ""
    for owner, name, what, f, m in entries:
        rows.append((owner if owner != before else "", name, what, force(f), "" if m is None else moment(m)))
        before = owner
    header = ("limb", "part", "", f"force [{force.unit}]", f"moment [{moment.unit}]")
    return table(header, rows, "lllrr") if rows else []


def _joints(result: Result, noise: Magnitudes) -> list[str]:
    wrenches = result.joint_wrenches
    sizes = {name: (np.linalg.norm(w[:3]), np.linalg.norm(w[3:])) for name, w in wrenches.items()}
    force = Scale.of([size[0] for size in sizes.values()], FORCES, noise.force)
    moment = Scale.of([size[1] for size in sizes.values()], MOMENTS, noise.moment)
    connections = result.robot.mechanism.connections
    rows = [
        (name, connections[name].kind + (", driven" if connections[name].driven else ""), force(f), moment(m))
        for name, (f, m) in sizes.items()
    ]
    return table(("joint", "kind", f"force [{force.unit}]", f"moment [{moment.unit}]"), rows, "llrr")


def _base(result: Result, noise: Magnitudes) -> list[str]:
    wrench = result.base_wrench
    force = Scale.of(wrench[:3], FORCES, noise.force)
    moment = Scale.of(wrench[3:], MOMENTS, noise.moment)
    return [f"force   {vector(wrench[:3], force)}", f"moment  {vector(wrench[3:], moment)}"]


# ---- beams ---------------------------------------------------------------------------------------------------------


def _beams(result: Result, noise: Magnitudes) -> list[str]:
    beams = list(result.beams.values())
    length = Scale.of([beam.length for beam in beams], (("mm", 1e-3),))
    mass = Scale.of([beam.mass for beam in beams], MASSES)
    axial = Scale.of([beam.section_wrenches[..., 0] for beam in beams], FORCES, noise.force)
    stress = Scale.of([beam.stress for beam in beams], STRESSES, digits=4)
    ends = [np.linalg.norm(beam.deflections[-1]) for beam in beams]
    most = [np.linalg.norm(beam.deflections, axis=-1).max() for beam in beams]
    shift = Scale.of([ends, most], LENGTHS, noise.displacement)
    rows = [
        (
            beam.name,
            length(beam.length),
            mass(beam.mass),
            axial(beam.section_wrenches[0, 0]),
            axial(beam.section_wrenches[-1, 0]),
            stress(beam.stress),
            f"{100 * float(beam.euler_ratio):.3g}" if np.isfinite(beam.euler_ratio) else MISSING,
            shift(end),
            shift(middle),
        )
        for beam, end, middle in zip(beams, ends, most, strict=True)
    ]
    header = (
        "beam",
        f"length [{length.unit}]",
        f"mass [{mass.unit}]",
        f"N inner [{axial.unit}]",
        f"N outer [{axial.unit}]",
        f"stress [{stress.unit}]",
        "N/N_Euler [%]",
        f"end moves [{shift.unit}]",
        f"most [{shift.unit}]",
    )
    notes = ["N: axial force, tension positive; stress: largest von Mises stress"]
    if any(type(beam.description.section) is Section for beam in beams):
        notes.append(f"stress {MISSING}: <section> does not say the outline; give a circle, tube, rectangle or rectangular_tube")
    held: dict[str, list[str]] = {}
    for beam in beams:
        if beam.name == next(name for name in result.beams if name in beam.member):
            held.setdefault(beam.ends, []).append("+".join(beam.member))
    groups = "; ".join(f"{', '.join(names)}: {words}" for words, names in held.items())
    notes += wrapped(f"N/N_Euler: 100 % buckles; beams in one line count as one. Inner and outer ends of {groups}", "")
    return [*table(header, rows), *notes]
