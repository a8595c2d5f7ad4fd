"""What a person reads of a verification, and the same as plain numbers."""

from __future__ import annotations

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.printing.dispatch import dict_of, html_of, text_of
from kinetostatics.printing.html import html_table
from kinetostatics.printing.text import (
    STIFFNESSES,
    TURNING_STIFFNESSES,
    Column,
    Magnitudes,
    Scale,
    column_table,
    section,
    table,
    wrapped,
)
from kinetostatics.quantities import QUANTITIES
from kinetostatics.reports.forces import sizes
from kinetostatics.reports.json import named
from kinetostatics.reports.pose import pose_lines
from kinetostatics.verification.compare import Verification

UNITS = {
    "general": "SI: m, rad, N, N·m; world axes; null: not a number or infinite",
    **{name: QUANTITIES[name].said for name in ("twist", "compliance", "stiffness", "joint_wrenches", "actuator_forces")},
    "beam_wrenches": "[force N; moment N·m] what the outer part of a beam puts on its inner, at its base and its platform end",
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
def verification_to_dict(found: Verification) -> dict[str, object]:
    """Return a verification as plain values."""
    arrays = ("twist", "compliance", "stiffness", "joint_wrenches", "beam_wrenches", "actuator_forces")
    robot = found.configuration.robot
    return {
        "robot": robot.name,
        "file": robot.description.path,
        **named(found, ("verified", "conclusive", "verdict", "within", "length")),
        **named(found.configuration, ("platform", "actuators")),
        **named(found.result, ("load", "gravity")),
        **named(found, ("differences", "scatter", "joint_differences", "not_compared")),
        "ours": named(found.ours, arrays),
        "finite_elements": named(found.finite_elements, arrays),
        "units": dict(UNITS),
    }


@text_of.register(Verification)
def verification_report(found: Verification) -> str:
    """Return both sides' numbers next to each other, and the verdict."""
    robot, pose = found.configuration.robot, found.configuration
    lines = [f"Check of {robot.name!r} by finite elements (OpenSees)"]
    lines += section("Pose", pose_lines(pose, found.result.gravity, found.result.load))
    noise = Magnitudes.of([found.finite_elements.twist], found.finite_elements.joint_wrenches.values(), found.length)
    lines += section("Twist of the platform at o, world axes", _twist(found, noise))
    lines += section("Stiffness of the platform at o, world axes, actuators locked: the diagonal", _stiffness(found))
    if found.finite_elements.actuator_forces:
        lines += section("Actuators, positive along the joint's positive direction", _actuators(found, noise))
    lines += section(
        "Joints: wrench of the base side acting on the platform side, magnitudes about the joint's centre", _joints(found, noise)
    )
    lines += section("Differences, relative", table(DIFFERENCES, _difference_rows(found), "lrrl"))
    for name, why in found.not_compared.items():
        lines += [f"  {line}" for line in wrapped(f"{name}: not compared: {why}")]
    lines += ["", *wrapped(found.verdict[0].upper() + found.verdict[1:])]
    return "\n".join(lines)


@html_of.register(Verification)
def verification_table(found: Verification) -> str:
    """Return the verdict with the differences, as notebooks show them."""
    title = f"Check of {found.configuration.robot.name!r} by finite elements: {found.verdict}"
    return html_table(title, DIFFERENCES, _difference_rows(found), "lrrl")


def _row(name: str, ours: float, theirs: float, scale: Scale) -> tuple[str, str, str, str]:
    gap = (ours - theirs) / scale.factor
    return f"{name} [{scale.unit}]", scale(ours), scale(theirs), f"{gap:.0e}" if np.isfinite(gap) else "–"


HEADER = ("", "kinetostatics", "finite elements", "difference")


def _components(ours: Array, theirs: Array, linear: Scale, angular: Scale) -> list[str]:
    scales = [linear] * 3 + [angular] * 3
    return table(HEADER, [_row(*item) for item in zip(COMPONENTS, ours, theirs, scales, strict=True)])


def _twist(found: Verification, noise: Magnitudes) -> list[str]:
    theirs = found.finite_elements.twist
    scales = noise.scale("displacement", theirs[:3], DIGITS), noise.scale("rotation", theirs[3:], DIGITS)
    return _components(found.ours.twist, theirs, *scales)


def _stiffness(found: Verification) -> list[str]:
    ours, theirs = np.diag(found.ours.stiffness), np.diag(found.finite_elements.stiffness)
    if np.any(np.isnan(ours)):
        return ["infinite: rigid limbs"]
    scales = Scale.of(theirs[:3], STIFFNESSES, digits=DIGITS), Scale.of(theirs[3:], TURNING_STIFFNESSES, digits=DIGITS)
    return _components(ours, theirs, *scales)


def _actuators(found: Verification, noise: Magnitudes) -> list[str]:
    ours, theirs, torques = found.ours.actuator_forces, found.finite_elements.actuator_forces, found.finite_elements.torques
    force = noise.scale("force", [value for name, value in theirs.items() if name not in torques], DIGITS)
    torque = noise.scale("moment", [theirs[name] for name in torques], DIGITS)
    return table(HEADER, [_row(name, ours[name], value, torque if name in torques else force) for name, value in theirs.items()])


def _joints(found: Verification, noise: Magnitudes) -> list[str]:
    ours, theirs = found.ours.joint_wrenches, found.finite_elements.joint_wrenches
    names = [name for name in theirs if name in ours]
    (force, moment), (force_fe, moment_fe) = (sizes(side[name] for name in names) for side in (ours, theirs))
    forces, moments = noise.scale("force", force_fe), noise.scale("moment", moment_fe)
    gaps = [f"{found.joint_differences.get(name, np.nan):.0e}" for name in names]
    return column_table(
        [
            Column("joint", names),
            Column.of("force", force, forces),
            Column.of("finite el.", force_fe, forces, with_unit=False),
            Column.of("moment", moment, moments),
            Column.of("finite el.", moment_fe, moments, with_unit=False),
            Column("difference, rel.", gaps, "r"),
        ]
    )


DIFFERENCES = ("", "difference", "finite elements' own scatter", "")


def _difference_rows(found: Verification) -> list[tuple[str, str, str, str]]:
    return [
        (WORDS[name], f"{value:.1e}", f"{found.scatter.get(name, np.nan):.1e}", "ok" if value <= found.within else "DIFFERS")
        for name, value in found.differences.items()
    ]
