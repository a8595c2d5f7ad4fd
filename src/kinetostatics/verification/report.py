"""What a person reads of a verification, and the same as plain numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinetostatics.printing.dispatch import dict_of, text_of
from kinetostatics.printing.text import (
    ANGLES,
    FORCES,
    LENGTHS,
    MOMENTS,
    STIFFNESSES,
    TURNING_STIFFNESSES,
    Magnitudes,
    Scale,
    section,
    table,
    vector,
    wrapped,
)
from kinetostatics.reports.json import plain
from kinetostatics.reports.result import COMPONENTS, angles_words, drives_words, position_words
from kinetostatics.verification.compare import Verification

UNITS = {
    "general": "SI: m, rad, N, N·m; world axes; null: not a number or infinite",
    "twist": "[displacement m; rotation rad] of the platform at o",
    "compliance": "m/N, m/(N·m) = rad/N, rad/(N·m), at o, drives locked",
    "stiffness": "N/m, N/rad = N·m/m, N·m/rad, at o, drives locked",
    "joint_wrenches": "[force N; moment N·m] what the base side puts on the platform side, about the joint's centre",
    "beam_wrenches": "[force N; moment N·m] what the outer part of a beam puts on its inner, at its inner and its outer end",
    "actuator_forces": "N, of turning joints N·m, positive along the joint's positive direction",
    "differences": "relative, of whole twists, wrenches and matrices, rotations and moments made comparable by `length` m; of "
    "forces relative to the largest joint wrench",
    "scatter": "how far the finite elements' own numbers are sure, as `differences`",
}

WORDS = {
    "twist": "twist of the platform",
    "compliance": "compliance",
    "stiffness": "stiffness",
    "joint_wrenches": "joint wrenches",
    "beam_wrenches": "wrenches in beams",
    "actuator_forces": "actuator forces",
}

#: Digits of the largest number of a table.
DIGITS = 8


@dict_of.register(Verification)
def verification_to_dict(found: Verification) -> dict[str, Any]:
    """Return a verification as plain values."""
    arrays = ("twist", "compliance", "stiffness", "joint_wrenches", "beam_wrenches", "actuator_forces")
    robot = found.configuration.robot
    return {
        "robot": robot.name,
        "file": robot.description.path,
        "verified": found.verified,
        "conclusive": found.conclusive,
        "verdict": found.verdict,
        "tolerance": found.tolerance,
        "length": found.length,
        "platform": plain(found.configuration.platform),
        "actuators": plain(found.configuration.actuators),
        "load": plain(found.result.load),
        "gravity": plain(found.result.gravity),
        "differences": plain(found.differences),
        "scatter": plain(found.scatter),
        "joint_differences": plain(found.joint_differences),
        "not_compared": plain(found.not_compared),
        "ours": {name: plain(getattr(found.ours, name)) for name in arrays},
        "finite_elements": {name: plain(getattr(found.finite_elements, name)) for name in arrays},
        "units": dict(UNITS),
    }


@text_of.register(Verification)
def verification_report(found: Verification) -> str:
    """Return both sides' numbers next to each other, and the verdict."""
    robot, pose = found.configuration.robot, found.configuration
    lines = [f"Check of {robot.name!r} by finite elements (OpenSees)"]
    load, gravity = found.result.load, found.result.gravity
    force, moment = Scale.of(load[:3], FORCES), Scale.of(load[3:], MOMENTS)
    rows = [
        ("o", position_words(pose)),
        ("orientation", angles_words(pose)),
        ("actuators", drives_words(pose)),
        ("gravity", vector(gravity, Scale.of(gravity, (("m/s²", 1.0),), digits=4))),
        ("load at o", f"force {vector(load[:3], force)}, moment {vector(load[3:], moment)}"),
    ]
    lines += section("Pose", [line for name, text in rows for line in wrapped(text, f"{name:13}")])
    noise = _noise(found)
    lines += section("Twist of the platform at o, world axes", _twist(found, noise))
    lines += section("Stiffness of the platform at o, world axes, drives locked: the diagonal", _stiffness(found))
    if found.finite_elements.actuator_forces:
        lines += section("Drives, positive along the joint's positive direction", _drives(found, noise))
    lines += section(
        "Joints: what the base side puts on the platform side, magnitudes about the joint's centre", _joints(found, noise)
    )
    lines += section("Differences, relative", _differences(found))
    for name, why in found.not_compared.items():
        lines += [f"  {line}" for line in wrapped(f"{name}: not compared: {why}")]
    lines += ["", *wrapped(found.verdict[0].upper() + found.verdict[1:])]
    return "\n".join(lines)


def _noise(found: Verification) -> Magnitudes:
    theirs = found.finite_elements
    return Magnitudes.of([theirs.twist], theirs.joint_wrenches.values(), found.length)


def _row(name: str, ours: float, theirs: float, scale: Scale) -> tuple[str, str, str, str]:
    gap = (ours - theirs) / scale.factor
    return f"{name} [{scale.unit}]", scale(ours), scale(theirs), f"{gap:.0e}" if np.isfinite(gap) else "–"


HEADER = ("", "kinetostatics", "finite elements", "difference")


def _twist(found: Verification, noise: Magnitudes) -> list[str]:
    ours, theirs = found.ours.twist, found.finite_elements.twist
    shift = Scale.of(theirs[:3], LENGTHS, noise.displacement, DIGITS)
    turn = Scale.of(theirs[3:], ANGLES, noise.rotation, DIGITS)
    return table(HEADER, [_row(name, ours[k], theirs[k], shift if k < 3 else turn) for k, name in enumerate(COMPONENTS)])


def _stiffness(found: Verification) -> list[str]:
    ours, theirs = np.diag(found.ours.stiffness), np.diag(found.finite_elements.stiffness)
    if np.any(np.isnan(ours)):
        return ["infinite: rigid limbs"]
    rows = []
    for part, units in ((range(3), STIFFNESSES), (range(3, 6), TURNING_STIFFNESSES)):
        scale = Scale.of(theirs[list(part)], units, digits=DIGITS)
        rows += [_row(COMPONENTS[k], ours[k], theirs[k], scale) for k in part]
    return table(HEADER, rows)


def _drives(found: Verification, noise: Magnitudes) -> list[str]:
    theirs = found.finite_elements.actuator_forces
    torques = found.finite_elements.torques
    force = Scale.of([value for name, value in theirs.items() if name not in torques], FORCES, noise.force, DIGITS)
    torque = Scale.of([theirs[name] for name in torques], MOMENTS, noise.moment, DIGITS)
    ours = found.ours.actuator_forces
    return table(HEADER, [_row(name, ours[name], value, torque if name in torques else force) for name, value in theirs.items()])


def _joints(found: Verification, noise: Magnitudes) -> list[str]:
    ours, theirs = found.ours.joint_wrenches, found.finite_elements.joint_wrenches
    names = [name for name in theirs if name in ours]
    sizes = np.array([[np.linalg.norm(w[part]) for w in (ours[n], theirs[n])] for n in names for part in (slice(3), slice(3, 6))])
    sizes = sizes.reshape(-1, 4)
    force = Scale.of(sizes[:, 1], FORCES, noise.force)
    moment = Scale.of(sizes[:, 3], MOMENTS, noise.moment)
    rows = [
        (name, force(a), force(b), moment(c), moment(d), f"{found.joint_differences.get(name, np.nan):.0e}")
        for name, (a, b, c, d) in zip(names, sizes, strict=True)
    ]
    header = ("joint", f"force [{force.unit}]", "finite el.", f"moment [{moment.unit}]", "finite el.", "difference, rel.")
    return table(header, rows)


def _differences(found: Verification) -> list[str]:
    rows = [
        (WORDS[name], f"{value:.1e}", f"{found.scatter.get(name, np.nan):.1e}", "ok" if value <= found.tolerance else "DIFFERS")
        for name, value in found.differences.items()
    ]
    return table(("", "difference", "finite elements' own scatter", ""), rows, "lrrl")
