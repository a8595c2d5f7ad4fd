"""Summary of one pose: displacement and its sources, stiffness, actuator forces, stress and buckling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.layout.blocks import Facts
from kinetostatics.layout.numbers import ANGLES, FORCE_KINDS, LENGTHS, NOISE, PER_CENT, STRESSES, NoiseFloor, quantity
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import first_largest
from kinetostatics.reports.forces import force_formats
from kinetostatics.reports.pose import actuator_unit
from kinetostatics.reports.sources import parts_along, ranked, share, sources
from kinetostatics.reports.stiffness import stiffness_extremes
from kinetostatics.results.result import Result

#: Largest number of actuators listed one by one; of more, only the extremes are given.
MOST_ACTUATORS = 6
#: Cosines above which a direction is described as along an axis, and as mostly along it.
ALONG, MOSTLY = 0.995, 0.7
_NAMES = {"load": "the load", "platform_weight": "the platform's weight", "payload": "the payload"}


def summary_facts(result: Result, noise: NoiseFloor) -> Facts:
    """Return displacement, rotation, extremes of the stiffness, actuator forces, largest stress and nearest buckling."""
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
    return Facts(rows)


def _worst(values: Mapping[str, float]) -> str:
    """Return the name of the largest value; of values equal within rounding, the first."""
    return list(values)[first_largest(np.array(list(values.values())))]


def _displacement(result: Result, noise: NoiseFloor) -> str:
    """Return the direction of the displacement, and its largest contributions."""
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
    """Return, as text, the largest parts of the displacement [%] with the names of their sources.

    Args:
        names: names of the sources.
        twists: (n, 6) their twists.
        result: the analysis.
        noise: limits below which a motion counts as zero.
        word: preposition before the names.
        number: largest number of parts.
    """
    found = parts_along(twists, result.twist, noise)
    if found is None:
        return ""
    parts, sizes, _ = found
    shares = [share(part, float(sizes[0])) for part in parts[:, 0].tolist()]
    some = [k for k in ranked(np.abs(parts[:, 0]))[:number] if abs(shares[k]) > 0.5]
    return "".join(f"{', ' if k else '; '}{shares[i]:.0f} % {word}{names[i]}" for k, i in enumerate(some))


def _direction(unit: Array, gravity: Array) -> str:
    """Return a direction as text: down or up along gravity, along an axis, or its components."""
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
    """Return the actuator forces; of many, the smallest and the largest."""
    forces = {name: float(force) for name, force in result.actuator_forces.items()}
    units = [actuator_unit(result.robot, name) for name in forces]
    formats = dict(zip(forces, force_formats(forces.values(), units, noise), strict=True))
    if len(forces) <= MOST_ACTUATORS:
        return [("actuators", ", ".join(f"{name} {formats[name].with_unit(force)}" for name, force in forces.items()))]
    rows = []
    for unit, kind in FORCE_KINDS.items():
        some = [name for name, own in zip(forces, units, strict=True) if own == unit and np.isfinite(forces[name])]
        if some:
            ends = [pick(some, key=lambda name: forces[name]) for pick in (min, max)]
            words = " to ".join(f"{formats[name].with_unit(forces[name])} ({name})" for name in ends)
            rows.append((f"actuator {kind}s", words))
    return rows
