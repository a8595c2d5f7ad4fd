"""Tables of the forces at one pose in actuators, limbs, joints, ground and beams; reports of single limbs and beams."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.blocks import Block, Column, Facts, Number, ReportSection, Table, Text, without_repetitions
from kinetostatics.layout.numbers import (
    FORCE_KINDS,
    FORCES,
    LENGTHS,
    MASSES,
    MILLIMETRES,
    MISSING,
    NOISE,
    PER_CENT,
    STRESSES,
    UNITS_OF,
    NoiseFloor,
    NumberFormat,
    join_words,
    largest,
    vector,
)
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.joints import compound_joints
from kinetostatics.quantities import reported_names
from kinetostatics.reports.pose import actuator_coordinates, actuator_unit, at_pose
from kinetostatics.reports.sources import actuator_parts
from kinetostatics.results.parts import BeamResult, LimbResult, wrench_units
from kinetostatics.results.result import Result
from kinetostatics.sections.kinds import Section as BeamSection


def force_sections(result: Result, noise: NoiseFloor, hinge_axes: Mapping[str, str]) -> list[ReportSection]:
    force, moment = result.base_wrench[:3], result.base_wrench[3:]
    ground = [("force", vector(force, noise.format("force", force))), ("moment", vector(moment, noise.format("moment", moment)))]
    magnitudes = "magnitudes about the joint's centre"
    sections: dict[tuple[str, str], list[Block]] = {
        ("forces", "Actuators, positive along the joint's positive direction"): _actuators(result, noise),
        ("limbs", "Limbs: wrenches of the platform acting on the limb"): _limbs(result, noise, hinge_axes),
        ("limbs", "Limbs that are networks: forces in their beams and in their joints to the platform"): _networks(result, noise),
        ("joints", f"Joints: wrench of the base side acting on the platform side, {magnitudes}"): _joints(result, noise),
        ("ground", "Ground: reaction on the robot, about the base link's origin"): [Facts(ground)],
        ("beams", "Beams"): _beams(result, noise),
    }
    return [ReportSection(title, blocks, key, detail=True) for (key, title), blocks in sections.items()]


def sizes(wrenches: Iterable[Array]) -> Array:
    """Return (f, m), the magnitudes (n,) of the forces and (n,) of the moments of n wrenches (6,)."""
    return np.linalg.norm(np.reshape([*wrenches], (-1, 2, 3)), axis=2).T


def force_formats(values: Iterable[ArrayLike], units: Iterable[str], noise: NoiseFloor) -> list[NumberFormat]:
    """Return the format of each value: one for all values in N, and one for all in N·m."""
    pairs = [(float(np.asarray(value)), unit) for value, unit in zip(values, units, strict=True)]
    formats = {unit: noise.format(kind, [v for v, u in pairs if u == unit]) for unit, kind in FORCE_KINDS.items()}
    return [formats[unit] for _, unit in pairs]


def _actuators(result: Result, noise: NoiseFloor) -> list[Block]:
    forces = result.actuator_forces
    if not forces:
        return []
    units = [actuator_unit(result.robot, name) for name in forces]
    formats = force_formats(forces.values(), units, noise)
    places = [at_pose(coordinate) for coordinate in actuator_coordinates(result.configuration).values()]
    first = [Column("joint", list(forces)), Column("position", places, "r")]
    first += [Column.in_formats("force", forces.values(), formats), Column("", units)]
    return [Table([*first, *(Column.in_formats(name, part, formats) for name, part in actuator_parts(result).items())])]


# ---- limbs and joints ----------------------------------------------------------------------------------------------


def checked_axes(hinge_axes: Mapping[str, str], limbs: Iterable[str]) -> Mapping[str, str]:
    """Return ``hinge_axes`` after a check: by limb, the axis of the limb frame along the first hinge.

    Raises:
        ArgumentError: there is no such limb, or an axis is neither x nor y.
    """
    names = list(limbs)
    for limb, axis in hinge_axes.items():
        if limb not in names:
            raise ArgumentError(f"there is no limb {limb!r}: {near_names(limb, names)}")
        if axis not in ("x", "y"):
            raise ArgumentError(f"the axis of {limb} along its first hinge is {axis!r}; it must be 'x' or 'y'")
    return hinge_axes


def _named(label: str, intensity: Array, axis: str) -> tuple[str, Array]:
    """Transform label and intensity of a wrench from the limb frame with y along the first hinge to that with ``axis`` along it.

    The y axis of the frame with x along the hinge is opposite to the x axis of the frame with y along the hinge.
    """
    if axis == "y":
        return label, intensity
    if "limb x" in label:
        return label.replace("limb x", "limb y"), -intensity
    return label.replace("limb y", "limb x"), intensity


def _limbs(result: Result, noise: NoiseFloor, hinge_axes: Mapping[str, str]) -> list[Block]:
    entries: list[tuple[str, str, str, Array, str]] = []
    for limb in result.limbs.values():
        for kind, labels, wrenches, intensities in (
            ("constraint", limb.labels, limb.constraint_wrenches, limb.intensities),
            ("attached", limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
        ):
            for label, value, unit in zip(labels, intensities, wrench_units(labels, wrenches), strict=True):
                words, number = _named(label, value, hinge_axes.get(limb.name, "y"))
                entries.append((limb.name, words, kind, number, unit))
    names, labels, kinds, values, units = zip(*entries, strict=True) if entries else ((),) * 5
    columns = [Column("limb", without_repetitions(names)), Column("wrench", labels), Column("", kinds)]
    columns += [Column.in_formats("intensity", values, force_formats(values, units, noise)), Column("", units)]
    blocks: list[Block] = [Table(columns)]
    networks = [limb.name for limb in result.limbs.values() if limb.is_network]
    if networks:
        verb = "are networks: their" if networks[1:] else "is a network: its"
        blocks.append(Text(f"{join_words(networks)} {verb} components are coordinates in a basis, not forces in beams or joints"))
    return blocks


def _networks(result: Result, noise: NoiseFloor) -> list[Block]:
    entries: list[tuple[str, str, str, ArrayLike, ArrayLike | None]] = []
    for limb in result.limbs.values():
        if limb.is_network:
            for name in limb.beams:
                axial = result.beams[name].section_wrenches[-1, 0]
                entries.append((limb.name, name, "axial force at the platform end", axial, None))
            both = sizes(result.joint_wrenches[name] for name in limb.platform_joints).T
            for name, (force, moment) in zip(limb.platform_joints, both, strict=True):
                entries.append((limb.name, name, "joint to the platform", force, moment))
    if not entries:
        return []
    names, parts, kinds, forces, moments = zip(*entries, strict=True)
    columns = [Column("limb", without_repetitions(names)), Column("part", parts), Column("", kinds)]
    columns.append(Column.of("force", forces, noise.format("force", forces)))
    columns.append(Column.of("moment", moments, noise.format("moment", np.array([m for m in moments if m is not None]))))
    return [Table(columns)]


def _joints(result: Result, noise: NoiseFloor) -> list[Block]:
    """Return a table in which concentric revolutes share a row if they carry the same wrench."""
    mechanism, wrenches = result.robot.mechanism, result.joint_wrenches
    compounds = [joint for limb in result.robot.topology.all_limbs for joint in compound_joints(mechanism, limb)]
    whole = {
        joint.joints[0]: joint for joint in compounds if len(joint.joints) > 1 and _carry_alike(joint.joints, wrenches, noise)
    }
    inner = {name for joint in whole.values() for name in joint.joints[1:]}
    names = [name for name in wrenches if name not in inner]
    forces, moments = sizes(wrenches[name] for name in names)
    kinds = [
        f"{whole[name].type.name}, {len(whole[name].joints)} revolutes"
        if name in whole
        else mechanism.connections[name].type.name + ", actuated" * mechanism.connections[name].actuated
        for name in names
    ]
    return [
        Table(
            [
                Column("joint", [whole[name].label if name in whole else name for name in names]),
                Column("kind", kinds),
                Column.of("force", forces, noise.format("force", forces)),
                Column.of("moment", moments, noise.format("moment", moments)),
            ]
        )
    ]


def _carry_alike(joints: Sequence[str], wrenches: Mapping[str, Array], noise: NoiseFloor) -> bool:
    """Whether concentric joints carry the same wrench, as they do if no weight acts between them."""
    if not all(name in wrenches for name in joints):
        return False
    gaps = np.abs(np.array([wrenches[name] - wrenches[joints[0]] for name in joints]))
    return bool(np.all(gaps[:, :3] <= noise.force) and np.all(gaps[:, 3:] <= noise.moment))


# ---- beams ---------------------------------------------------------------------------------------------------------


def _per_cent(ratio: float) -> str:
    return MISSING if not np.isfinite(ratio) else "0" if abs(ratio) <= NOISE else f"{100 * ratio:.3g}"


def _beams(result: Result, noise: NoiseFloor) -> list[Block]:
    beams = list(result.beams.values())
    if not beams:
        return []
    axial = [beam.section_wrenches[..., 0] for beam in beams]
    ends: list[ArrayLike] = [np.linalg.norm(beam.deflections[-1]) for beam in beams]
    most: list[ArrayLike] = [beam.deflection for beam in beams]
    force, shift = noise.format("force", axial), noise.format("displacement", np.array([*ends, *most]))
    ratios = [_per_cent(float(beam.euler_ratio)) for beam in beams]
    columns = [
        Column("beam", list(result.beams)),
        Column.of("length", [beam.length for beam in beams], MILLIMETRES, digits=5),
        Column.of("mass", [beam.mass for beam in beams], MASSES, digits=5),
        Column.of("N base end", [forces[0] for forces in axial], force),
        Column.of("N platform end", [forces[-1] for forces in axial], force),
        Column.of("stress", [beam.stress for beam in beams], STRESSES),
        Column("N/N_Euler [%]", ratios, "r"),
        Column.of("end displacement", ends, shift),
        Column.of("largest", most, shift),
    ]
    notes = ["N: axial force, tension positive; stress: largest von Mises stress"]
    if any(type(beam.description.section) is BeamSection for beam in beams):
        notes.append(f"stress {MISSING}: the outline of <section> is unknown; give a circle, tube, rectangle or rectangular_tube")
    notes.append("N/N_Euler: ratio of the forces to the buckling load of the beam, alone or with others")
    return [Table(columns), *map(Text, notes)]


#: Results of a beam in reports.
BEAM_DATA = [field.name.lstrip("_") for field in dataclasses.fields(BeamResult) if field.name not in ("name", "description")]


def limb_report(limb: LimbResult) -> Report:
    rows = []
    noise = {"N": NOISE * largest([limb.wrench[..., :3]]), "N·m": NOISE * largest([limb.wrench[..., 3:]])}
    for labels, wrenches, values in (
        (limb.labels, limb.constraint_wrenches, limb.intensities),
        (limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
    ):
        for k, (label, unit) in enumerate(zip(labels, wrench_units(labels, wrenches), strict=True)):
            rows.append((label, Number.range_of(values[..., k], UNITS_OF[unit], noise[unit])))
    words = ", ".join(f"{label} {number}" for label, number in rows) or "no constraint wrench"
    table = Table.of_rows(("wrench acting on the limb", "intensity"), rows)
    return Report(f"LimbResult {limb.name!r}: {words}", lambda: [ReportSection("", [table])], lambda: limb_data(limb))


def beam_report(beam: BeamResult) -> Report:
    rows = [
        ("length", Number.range_of(beam.length, MILLIMETRES)),
        ("axial force", Number.range_of(beam.section_wrenches[..., 0], FORCES)),
        ("stress", Number.range_of(beam.stress, STRESSES)),
        ("N/N_Euler", Number.range_of(beam.euler_ratio, PER_CENT, NOISE)),
        ("mass", Number.range_of(beam.mass, MASSES)),
        ("largest deflection", Number.range_of(np.linalg.norm(beam.deflections, axis=-1).max(axis=-1), LENGTHS)),
    ]
    words = ", ".join(f"{name} {number}" for name, number in rows[:4])
    return Report(f"BeamResult {beam.name!r}: {words}", lambda: [ReportSection("", [Facts(rows)])], lambda: beam_data(beam))


def limb_data(limb: LimbResult) -> dict[str, object]:
    return {
        **attributes(limb, ("is_network", "beams", "platform_joints", "labels")),
        "units": wrench_units(limb.labels, limb.constraint_wrenches),
        "attached_labels": limb.attached_labels,
        "attached_units": wrench_units(limb.attached_labels, limb.attached_wrenches),
        **attributes(limb, reported_names("limbs")),
    }


def beam_data(beam: BeamResult) -> dict[str, object]:
    return attributes(beam, BEAM_DATA)
