"""Numbers of a description that look as if they were in other units than SI: angles, limits, moduli, densities."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from kinetostatics.description.elements import Beam, Joint, Loop
from kinetostatics.description.joint_types import names_of
from kinetostatics.printing.text import listing

#: A turn, but for rounding [rad].
TURN = 2 * math.pi * (1 + 1e-9)
#: Plausible numbers of solids: Young's modulus [Pa] and density [kg/m³].
MODULI, DENSITIES = (1e8, 2e12), (10.0, 25e3)
#: Wider limits [rad] than this stand for none at all.
WIDE = 720.0


def looks_like_degrees(*angles: float) -> bool:
    """Whether angles make more than two turns in radians, or more than one and are round numbers of degrees: 90, 10, -180.

    Sums of angles, as xacro makes them, go a little beyond a turn.
    """
    largest = max(map(abs, angles))
    return largest > 2 * TURN or (largest > TURN and all(angle % 5 == 0 for angle in angles))


def odd_angles(joints: Mapping[str, Joint], loops: Mapping[str, Loop]) -> list[str]:
    """Say which angles and limits of a robot file look like degrees."""
    found = [
        f"{item.place}: rpy={_written(rpy)!r} of {what} looks like degrees: angles are in rad; 90 degrees are ${{pi/2}} in xacro"
        for what, item, rpy in _origins(joints, loops)
        if looks_like_degrees(*rpy)
    ]
    followed = {joint.mimic.joint for joint in joints.values() if joint.mimic is not None}
    all_joints: list[Joint | Loop] = [*joints.values(), *loops.values()]
    turning = [joint for joint in all_joints if joint.type in names_of("is_hinge") and joint.name not in followed]
    for joint in turning:
        limits = [limit for limit in (joint.lower, joint.upper) if math.isfinite(limit)]
        if limits and 2 * TURN < max(map(abs, limits)) <= WIDE:
            found.append(
                f"{joint.place}: the limits {_written((joint.lower, joint.upper))} of {joint.name!r} look like degrees: angles "
                "are in rad; 90 degrees are ${pi/2} in xacro"
            )
    return found


def _origins(
    joints: Mapping[str, Joint], loops: Mapping[str, Loop]
) -> Iterable[tuple[str, Joint | Loop, tuple[float, float, float]]]:
    for joint in joints.values():
        yield f"the joint {joint.name!r}", joint, joint.origin.rpy
    for loop in loops.values():
        yield f"the loop {loop.name!r}", loop, loop.predecessor_origin.rpy
        yield f"the loop {loop.name!r}", loop, loop.successor_origin.rpy


def _written(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)


def odd_materials(beams: Mapping[str, Beam]) -> list[str]:
    """Say which moduli and densities of beams are not those of solids, and in which unit they would be."""
    found: dict[str, list[str]] = {}
    for name, beam in beams.items():
        modulus, density = beam.material.youngs_modulus, beam.material.density
        if not MODULI[0] <= modulus <= MODULI[1]:
            meant = _meant(modulus, MODULI, {"GPa": 1e9, "MPa": 1e6})
            found.setdefault(f"a Young's modulus of {modulus:.4g} Pa; moduli are in Pa (steel: 2.1e11){meant}", []).append(name)
        if density and not DENSITIES[0] <= density <= DENSITIES[1]:
            meant = _meant(density, DENSITIES, {"g/cm³": 1e3, "kg/mm³": 1e9, "t/mm³": 1e12})
            found.setdefault(f"a density of {density:.4g} kg/m³; densities are in kg/m³ (steel: 7850){meant}", []).append(name)
    return [
        f"beam{'s' * (len(names) > 1)} {listing(names, 8)} {'have' if names[1:] else 'has'} {words}"
        for words, names in found.items()
    ]


def _meant(value: float, usual: tuple[float, float], units: Mapping[str, float]) -> str:
    """Say in which unit a value would be a usual one."""
    for unit, size in units.items():
        if usual[0] <= value * size <= usual[1]:
            return f": {value:.4g} {unit} is {value * size:.4g}"
    return ""
