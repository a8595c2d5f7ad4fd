"""What a person reads of an analysis: ``print(result)`` and ``kinetostatics analyze``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.analysis import free_twists
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import EQUAL, first_largest
from kinetostatics.math.screws import COMPONENTS, describe_twist
from kinetostatics.printing.dispatch import text_of
from kinetostatics.printing.text import (
    CLOSED,
    ENERGIES,
    FORCES,
    MASSES,
    MILLIMETRES,
    MOMENTS,
    STIFFNESSES,
    TURNING_STIFFNESSES,
    Magnitudes,
    Scale,
    quantity,
    section,
    table,
    vector,
    warning_lines,
    wide_table,
    wrapped,
)
from kinetostatics.reports.batch import batch_report, magnitudes
from kinetostatics.reports.forces import checked_axes, force_sections
from kinetostatics.reports.pose import facts_of, pose_lines, statuses_of
from kinetostatics.reports.sources import gravity_twists, source_lines
from kinetostatics.results.result import Result
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.statics.singularity import UNBALANCED
from kinetostatics.status import WITHOUT_NUMBERS, Status


@text_of.register(Result)
def result_report(result: Result, hinge_axes: Mapping[str, str] | None = None) -> str:
    """Return what an analysis found: tables with units for one pose, a summary for a batch of poses.

    Args:
        result: of :func:`kinetostatics.analyze`.
        hinge_axes: as in :meth:`kinetostatics.Result.report`.
    """
    hinge_axes = checked_axes(hinge_axes or {}, result.limbs)
    if result.shape != ():
        return batch_report(result)
    sections = {"Pose": _pose(result)}
    if result.status == Status.SINGULAR:
        sections["What can still move"] = _free_motions(result)
    closing = warning_lines(result.warnings)
    if result.status not in WITHOUT_NUMBERS:
        noise = magnitudes(result)
        sections |= {**_motion_sections(result, noise), **force_sections(result, noise, hinge_axes)}
        if result.beams:
            what = "beams and elastic joints" if result.robot.description.joint_stiffness else "beams"
            closing = ["", f"Strain energy of the {what}  {quantity(result.strain_energy, ENERGIES)}", *closing]
    lines = [f"Analysis of {result.robot.name!r}: {_status_words(result)}"]
    lines += [line for title, part in sections.items() if part for line in section(title, part)]
    return "\n".join([*lines, *closing])


# ---- the pose ------------------------------------------------------------------------------------------------------


def _status_words(result: Result) -> str:
    """Return everything that is true of a pose, the worst first."""
    ok, *without_numbers = statuses_of(result)
    found = [*without_numbers, *reversed(facts_of(result))]
    return "\n  also ".join(f"{title}, {words}" for title, where, words in found if where) or f"{ok[0]}, {ok[2]}"


def _pose(result: Result) -> list[str]:
    configuration, more = result.configuration, _acting(result)
    if configuration.loop_gaps and np.isfinite(configuration.residual):
        open_by = float(configuration.residual)
        more.append(("loops", "closed" if open_by <= CLOSED else f"open by at most {open_by:.1e} (m or rad)"))
    return pose_lines(configuration, result.gravity, result.load, *more)


def _acting(result: Result) -> list[tuple[str, str]]:
    """Return names and texts of the payload and the loads on links."""
    found = []
    if result.payload is not None:
        frame = "o-xyz" if result.payload.link is None else result.payload.link
        center = np.broadcast_to(np.asarray(result.payload.center, dtype=float), (3,))
        place = vector(center, Scale.of(center, MILLIMETRES, digits=4))
        found.append(("payload", f"{quantity(result.payload.mass, MASSES)} at {place} of {frame}"))
    for name, wrench in result.link_loads.items():
        if name != PAYLOAD:
            noise = 1e-12 * float(np.linalg.norm(wrench[:3]))
            force, moment = Scale.of(wrench[:3], FORCES), Scale.of(wrench[3:], MOMENTS, noise * result.robot.length)
            text = f"{name.removeprefix('load ')}: force {vector(wrench[:3], force)}, moment about o {vector(wrench[3:], moment)}"
            found.append(("load", text))
    if result.spring_forces:
        text = ", ".join(f"{name} {quantity(force, FORCES)}" for name, force in result.spring_forces.items())
        found.append(("springs", f"{text} (tension)"))
    return found


def _free_motions(result: Result) -> list[str]:
    robot, solution = result.robot, result.solutions[0]
    found = [
        f"{owner}: its passive joints {', '.join(robot.statics.passive_joints(owner))} do not carry all of its weight"
        for owner, part in solution.unbalanced.items()
        if part[0] > UNBALANCED
    ]
    found += [f"the platform: {describe_twist(twist, robot.length)}" for twist in free_twists(robot, solution, 0).T]
    return [line for text in found or ["the pose is too close to a singular one"] for line in wrapped(text, "- ")]


# ---- the platform --------------------------------------------------------------------------------------------------


def _motion_sections(result: Result, noise: Magnitudes) -> dict[str, list[str]]:
    """Return titles and lines of what the platform does; without lines where there is nothing to be told."""
    kinds = {kind: np.sum(list(named.values()), axis=0) for kind, named in result.source_contributions.items()}
    parts = {
        f"{limb.name}: {part.start} → {part.end}": twist
        for limb in result.robot.topology.limbs
        for part, twist in zip(limb.parts, result.part_contributions.get(limb.name, ()), strict=False)
    }
    gravity = gravity_twists(result) if result.robot.topology.limbs else {}
    total = {"total": result.twist}
    return {
        "Twist of the platform at o, world axes": _twists({**result.contributions, **total}, noise),
        "What gravity does, by the ways in which it acts": _twists(gravity, noise),
        "Elastic displacement by source: the same twist by beams, elastic joints, actuators and assembly errors": _twists(
            {**kinds, **total} if {"joints", "actuators", "assembly_errors"} & {*kinds} else {}, noise
        ),
        "Where the sag comes from: parts along the whole displacement and rotation": source_lines(result, noise),
        "Elastic displacement of the parts of the limbs": _twists(parts, noise),
        "Stiffness of the platform at o, world axes, actuators locked": _stiffness(result),
    }


def component_rows(linear: Scale, angular: Scale, *columns: Array) -> list[list[str]]:
    """Return the rows of a table of the six components, with their units, of all columns (6,)."""
    scales = [linear] * 3 + [angular] * 3
    return [
        [f"{name} [{scale.unit}]", *(scale(column[k]) for column in columns)]
        for k, (name, scale) in enumerate(zip(COMPONENTS, scales, strict=True))
    ]


def _twists(twists: Mapping[str, Array], noise: Magnitudes) -> list[str]:
    """Return a table of twists (6,), a column for each; nothing if there is none."""
    shift = noise.scale("displacement", [twist[:3] for twist in twists.values()], digits=6)
    turn = noise.scale("rotation", [twist[3:] for twist in twists.values()], digits=6)
    return wide_table(["", *twists], component_rows(shift, turn, *twists.values())) if twists else []


def _stiffness(result: Result) -> list[str]:
    held, free = np.diag(result.stiffness), _reciprocal(np.diag(result.compliance), result)
    linear = Scale.of([held[:3], free[:3]], STIFFNESSES, digits=6)
    angular = Scale.of([held[3:], free[3:]], TURNING_STIFFNESSES, digits=6)
    lines = table(("", "constrained", "free"), component_rows(linear, angular, held, free))
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
