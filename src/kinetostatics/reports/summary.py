"""Summary of one pose: displacement and its sources, stiffness, actuator forces, stress and buckling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.layout.blocks import Block, Column, Facts, Table, Text
from kinetostatics.layout.numbers import (
    ANGLES,
    FORCE_KINDS,
    LENGTHS,
    NOISE,
    PER_CENT,
    STIFFNESSES,
    STRESSES,
    TURNING_STIFFNESSES,
    NoiseFloor,
    NumberFormat,
    quantity,
)
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import EQUAL, first_largest
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.reports.parts import force_formats
from kinetostatics.reports.pose import actuator_unit
from kinetostatics.reports.sources import parts_along, ranked, share, sources
from kinetostatics.results.result import Result


def component_table(linear: NumberFormat, angular: NumberFormat, columns: Mapping[str, ArrayLike]) -> Table:
    """Return a table with a row for each component; ``columns``: arrays (6,) by title."""
    formats = [linear] * 3 + [angular] * 3
    names = [f"{name} [{form.unit}]" for name, form in zip(COMPONENTS, formats, strict=True)]
    numbers = [Column.in_formats(title, np.asarray(values), formats) for title, values in columns.items()]
    return Table([Column("", names), *numbers], wide=True)


def stiffness_blocks(result: Result) -> list[Block]:
    """Return a table of the stiffness along each axis, with all other motions held or free, and texts on the extremes."""
    constrained, free = np.diag(result.stiffness), _reciprocal(np.diag(result.compliance), result)
    linear = NumberFormat.of([constrained[:3], free[:3]], STIFFNESSES, digits=6)
    angular = NumberFormat.of([constrained[3:], free[3:]], TURNING_STIFFNESSES, digits=6)
    lines = [Text(f"{word} against a force at {result.point_name}: {text}") for word, text in stiffness_extremes(result)]
    return [component_table(linear, angular, {"constrained": constrained, "free": free}), *lines]


def stiffness_extremes(result: Result) -> list[tuple[str, str]]:
    """Return "softest" and "stiffest", each with a text: stiffness against a force, and direction of this force."""
    values, axes = np.linalg.eigh(result.compliance[:3, :3])
    sizes = _reciprocal(values, result)
    form = NumberFormat.of(sizes, STIFFNESSES)
    extremes = []
    for word, k in (("softest", 2), ("stiffest", 0)):
        alike = axes[:, np.abs(values - values[k]) <= EQUAL * abs(values[k])]
        size = quantity(sizes[k], ((form.unit, form.factor),))
        extremes.append((word, "rigid" if np.isinf(sizes[k]) else f"{size} {_directions(alike)}"))
    return extremes


def _reciprocal(compliances: Array, result: Result) -> Array:
    """Return 1/c for each compliance c; infinite where c is a rounding error, as with rigid limbs."""
    C, length = np.abs(result.compliance), result.robot.length
    small = 1e-12 * max(float(C[:3, :3].max()), length**2 * float(C[3:, 3:].max()))
    return np.where(np.abs(compliances) > small, 1 / np.where(compliances == 0, 1.0, compliances), np.inf)


def _directions(axes: Array) -> str:
    """Write the space spanned by k orthonormal axes (3, k): a direction, a plane or every direction."""
    if axes.shape[1] == 3:
        return "in every direction"
    if axes.shape[1] == 1:
        return f"along {_axis(axes[:, 0])}"
    normal = np.cross(axes[:, 0], axes[:, 1])
    planes = [plane for plane, part in zip(("yz", "xz", "xy"), np.abs(normal), strict=True) if part > 1 - EQUAL**2]
    return f"in every direction of the {planes[0]} plane" if planes else f"in every direction across {_axis(normal)}"


def _axis(axis: Array) -> str:
    axis = axis * np.sign(axis[first_largest(np.abs(axis))])
    return "(" + ", ".join("0" if abs(value) < 5e-4 else f"{value:.3f}" for value in axis) + ")"


#: Largest number of actuators listed one by one; for more, only the smallest and the largest force are given.
MOST_ACTUATORS = 6
#: Ratio of the sum of magnitudes of parts to their sum, above which parts cancel.
CANCELLING = 2.0
#: Cosines above which a direction is described as along an axis, and as mostly along it.
ALONG, MOSTLY = 0.995, 0.7
_NAMES = {
    "load": "the load",
    "platform_weight": "the platform's weight",
    "base_weight": "the base's weight",
    "payload": "the payload",
}


def summary_facts(result: Result, noise: NoiseFloor) -> Facts:
    moves, turns = (np.linalg.norm(part) for part in (result.twist[:3], result.twist[3:]))
    rows = [("displacement", f"{quantity(moves, LENGTHS, noise.displacement)}{_displacement(result, noise)}")]
    rows.append(("rotation", quantity(turns, ANGLES, noise.rotation)))
    rows += stiffness_extremes(result)
    if result.actuator_forces:
        rows += _actuators(result, noise)
    stress = {name: float(beam.stress) for name, beam in result.beams.items() if np.isfinite(beam.stress)}
    if stress:
        worst = _worst(stress)
        rows.append(("largest stress", f"{quantity(stress[worst], STRESSES, digits=4)} in {worst}"))
    ratios = {name: float(beam.euler_ratio) for name, beam in result.beams.items() if np.isfinite(beam.euler_ratio)}
    if ratios and max(ratios.values()) > NOISE:
        worst = _worst(ratios)
        share = quantity(float(f"{ratios[worst]:.3g}"), PER_CENT, digits=3)
        rows.append(("buckling", f"{worst} carries {share} of its buckling load"))
    if result.margins.stated and np.isfinite(result.margins.smallest):
        rows.append(("safety factor", f"{result.margins.smallest:.3g}, {result.margins.limited_by[()]}"))
    return Facts(rows)


def _worst(values: Mapping[str, float]) -> str:
    """Return the name of the largest value; among values equal within rounding errors, the first."""
    return list(values)[first_largest(np.array(list(values.values())))]


def _displacement(result: Result, noise: NoiseFloor) -> str:
    """Write the direction of the displacement, the largest contributions to it, and the part that deforms most."""
    twist = result.twist
    size = float(np.linalg.norm(twist[:3]))
    if size <= noise.displacement or not np.isfinite(size):
        return "" if result.source_contributions else ": nothing is elastic"
    text = f", {_direction(twist[:3] / size, result.gravity)}"
    names, twists = list(result.contributions), np.reshape([*result.contributions.values()], (-1, 6))
    shares = _largest([_NAMES.get(name, _contribution(result, name)) for name in names], twists, result, noise, "from ", 2)
    elastic, parts = sources(result)
    return text + shares + _largest([name for name, _ in elastic], parts, result, noise, "by deformation of ", 1)


def _contribution(result: Result, name: str) -> str:
    is_limb = any(limb.name == name for limb in result.robot.topology.limbs)
    return f"{name}'s weight" if is_limb else name.replace("_", " ").replace("load ", "the load on ")


def _largest(names: list[str], twists: Array, result: Result, noise: NoiseFloor, word: str, number: int) -> str:
    """Write up to ``number`` of the largest parts of the displacement, in per cent or, where parts cancel, in length.

    ``word`` precedes the name of each source.
    """
    projection = parts_along(twists, result.twist, noise)
    if projection is None:
        return ""
    parts, sizes, _ = projection
    shares = [share(part, float(sizes[0])) for part in parts[:, 0].tolist()]
    some = [k for k in ranked(np.abs(parts[:, 0]))[:number] if abs(shares[k]) > 0.5]
    if np.abs(parts[:, 0]).sum() > CANCELLING * sizes[0]:
        texts = [quantity(part, LENGTHS, noise.displacement, digits=3) for part in parts[:, 0].tolist()]
    else:
        texts = [f"{part:.0f} %" for part in shares]
    return "".join(f"{', ' if k else '; '}{texts[i]} {word}{names[i]}" for k, i in enumerate(some))


def _direction(unit: Array, gravity: Array) -> str:
    """Write the direction of a unit vector: down or up along gravity, along an axis, or its components."""
    size = float(np.linalg.norm(gravity))
    vertical = float(unit @ gravity) / size if size > 0 else 0.0
    axis = int(np.argmax(np.abs(unit)))
    words, cosine = f"along {'+' if unit[axis] > 0 else '−'}{'xyz'[axis]}", abs(float(unit[axis]))
    if abs(vertical) >= MOSTLY:
        words, cosine = "down" if vertical > 0 else "up", abs(vertical)
    if cosine < MOSTLY:
        return f"along ({', '.join(f'{value + 0.0:.2f}' for value in np.round(unit, 2))})"
    return words if cosine >= ALONG else f"mostly {words}"


def _actuators(result: Result, noise: NoiseFloor) -> list[tuple[str, str]]:
    """Return lines (name, text) on the actuator forces; for many actuators, on the smallest and the largest force."""
    forces = {name: float(force) for name, force in result.actuator_forces.items()}
    units = [actuator_unit(result.robot, name) for name in forces]
    formats = dict(zip(forces, force_formats(forces.values(), units, noise), strict=True))
    if len(forces) <= MOST_ACTUATORS:
        return [("actuators", ", ".join(f"{name} {formats[name].with_unit(force)}" for name, force in forces.items()))]
    rows = []
    for unit, kind in FORCE_KINDS.items():
        some = [name for name, force_unit in zip(forces, units, strict=True) if force_unit == unit and np.isfinite(forces[name])]
        if some:
            ends = [pick(some, key=lambda name: forces[name]) for pick in (min, max)]
            words = " to ".join(f"{formats[name].with_unit(forces[name])} ({name})" for name in ends)
            rows.append((f"actuator {kind}s", words))
    return rows
