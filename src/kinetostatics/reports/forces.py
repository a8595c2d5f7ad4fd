"""What a person reads of forces: actuators, limbs, joints, ground and beams of one pose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.printing.text import (
    FORCE_KINDS,
    MASSES,
    MILLIMETRES,
    MISSING,
    STRESSES,
    Column,
    Magnitudes,
    Scale,
    column_table,
    listing,
    once,
    table,
    vector,
    wrapped,
)
from kinetostatics.reports.json import actuator_unit, wrench_units
from kinetostatics.reports.pose import actuator_coordinates, written
from kinetostatics.reports.sources import actuator_parts
from kinetostatics.results.result import Result
from kinetostatics.sections.kinds import Section


def force_sections(result: Result, noise: Magnitudes, hinge_axes: Mapping[str, str]) -> dict[str, list[str]]:
    """Return titles and lines of all forces; without lines where there is nothing to be told."""
    magnitudes = "magnitudes about the joint's centre"
    return {
        "Actuators, positive along the joint's positive direction": _actuators(result, noise),
        "Limbs: wrenches of the platform acting on the limb": _limbs(result, noise, hinge_axes),
        "Limbs that are networks: what their beams and their joints to the platform carry": _networks(result, noise),
        f"Joints: wrench of the base side acting on the platform side, {magnitudes}": _joints(result, noise),
        "Ground: its reaction, acting on the robot, about the base link's origin": [
            f"force   {vector(result.base_wrench[:3], noise.scale('force', result.base_wrench[:3]))}",
            f"moment  {vector(result.base_wrench[3:], noise.scale('moment', result.base_wrench[3:]))}",
        ],
        "Beams": _beams(result, noise),
    }


def sizes(wrenches: Iterable[Array]) -> Array:
    """Return the magnitudes (2, n) of the forces and of the moments of n wrenches (6,)."""
    return np.linalg.norm(np.reshape([*wrenches], (-1, 2, 3)), axis=2).T


def _force_scales(values: Iterable[ArrayLike], units: Iterable[str], noise: Magnitudes) -> dict[str, Scale]:
    """Return one scale for the forces and one for the moments among some values."""
    pairs = list(zip(values, units, strict=True))
    return {unit: noise.scale(kind, [float(np.asarray(v)) for v, u in pairs if u == unit]) for unit, kind in FORCE_KINDS.items()}


def _actuators(result: Result, noise: Magnitudes) -> list[str]:
    forces = result.actuator_forces
    if not forces:
        return []
    units = [actuator_unit(result.robot, name) for name in forces]
    found = _force_scales(forces.values(), units, noise)
    scales = [found[unit] for unit in units]

    def column(title: str, values: Iterable[Array]) -> Column:
        return Column(title, [scale(value) for scale, value in zip(scales, values, strict=True)], "r")

    places = [written(item) for item in actuator_coordinates(result.configuration).values()]
    parts = [column(name, part) for name, part in actuator_parts(result).items()]
    first = [Column("joint", list(forces)), Column("position", places, "r"), column("force", forces.values()), Column("", units)]
    return column_table([*first, *parts])


# ---- limbs and joints ----------------------------------------------------------------------------------------------


def checked_axes(hinge_axes: Mapping[str, str], limbs: Iterable[str]) -> Mapping[str, str]:
    """Return which axis of which limb lies along its first hinge, if that makes sense.

    Raises:
        ArgumentError: there is no such limb, or the axis is neither x nor y.
    """
    known = list(limbs)
    for limb, axis in hinge_axes.items():
        if limb not in known:
            raise ArgumentError(f"there is no limb {limb!r}: {near_names(limb, known)}")
        if axis not in ("x", "y"):
            raise ArgumentError(f"the axis of {limb} along its first hinge is {axis!r}; it must be 'x' or 'y'")
    return hinge_axes


def _named(label: str, intensity: Array, axis: str) -> tuple[str, Array]:
    """Return a wrench's label and intensity with the limb's ``axis`` along its first hinge.

    With x along the hinge, y = z × x points against our x.
    """
    if axis == "y":
        return label, intensity
    if "limb x" in label:
        return label.replace("limb x", "limb y"), -intensity
    return label.replace("limb y", "limb x"), intensity


def _limbs(result: Result, noise: Magnitudes, hinge_axes: Mapping[str, str]) -> list[str]:
    entries: list[tuple[str, str, str, Array, str]] = []
    for limb in result.limbs.values():
        axis = hinge_axes.get(limb.name, "y")
        for kind, labels, wrenches, intensities in (
            ("constraint", limb.labels, limb.constraint_wrenches, limb.intensities),
            ("attached", limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
        ):
            for label, value, unit in zip(labels, intensities, wrench_units(labels, wrenches), strict=True):
                words, number = _named(label, value, axis)
                entries.append((limb.name, words, kind, number, unit))
    scales = _force_scales([entry[3] for entry in entries], [entry[4] for entry in entries], noise)
    names = once(entry[0] for entry in entries)
    rows = [
        (name, label, kind, scales[unit](value), unit) for name, (_, label, kind, value, unit) in zip(names, entries, strict=True)
    ]
    lines = table(("limb", "wrench", "", "intensity", ""), rows, "lllrl")
    networks = [limb.name for limb in result.limbs.values() if limb.is_network]
    if networks:
        verb = "are networks: their" if networks[1:] else "is a network: its"
        lines += wrapped(f"{listing(networks)} {verb} components are coordinates in a basis, not forces in beams or joints")
    return lines


def _networks(result: Result, noise: Magnitudes) -> list[str]:
    """Return the axial forces of beams and the sizes of joint wrenches at the platform of limbs that are networks."""
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
    columns = [Column("limb", once(names)), Column("part", parts), Column("", kinds)]
    columns.append(Column.of("force", forces, noise.scale("force", forces)))
    return column_table([*columns, Column.of("moment", moments, noise.scale("moment", [m for m in moments if m is not None]))])


def _joints(result: Result, noise: Magnitudes) -> list[str]:
    forces, moments = sizes(result.joint_wrenches.values())
    joints = [result.robot.mechanism.connections[name] for name in result.joint_wrenches]
    return column_table(
        [
            Column("joint", [joint.name for joint in joints]),
            Column("kind", [joint.kind + ", driven" * joint.driven for joint in joints]),
            Column.of("force", forces, noise.scale("force", forces)),
            Column.of("moment", moments, noise.scale("moment", moments)),
        ]
    )


# ---- beams ---------------------------------------------------------------------------------------------------------


def _beams(result: Result, noise: Magnitudes) -> list[str]:
    beams = list(result.beams.values())
    if not beams:
        return []
    axial = [beam.section_wrenches[..., 0] for beam in beams]
    ends = [np.linalg.norm(beam.deflections[-1]) for beam in beams]
    most = [np.linalg.norm(beam.deflections, axis=-1).max() for beam in beams]
    force, shift = noise.scale("force", axial), noise.scale("displacement", [ends, most])
    ratios = [f"{100 * float(beam.euler_ratio):.3g}" if np.isfinite(beam.euler_ratio) else MISSING for beam in beams]
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
    if any(type(beam.description.section) is Section for beam in beams):
        notes.append(f"stress {MISSING}: <section> does not say the outline; give a circle, tube, rectangle or rectangular_tube")
    notes.append("N/N_Euler: forces over those at which the beam buckles, by itself or with others: 100 % buckles")
    return [*column_table(columns), *notes]
