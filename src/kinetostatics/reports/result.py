"""Report of an analysis: a summary of one pose with tables in detail, or the extremes over a batch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kinetostatics.analysis import free_twists
from kinetostatics.layout.blocks import Block, Facts, Number, ReportSection, Text, warning_section
from kinetostatics.layout.numbers import (
    CLOSED,
    ENERGIES,
    FORCES,
    KINDS,
    MASSES,
    MILLIMETRES,
    MOMENTS,
    NoiseFloor,
    NumberFormat,
    quantity,
    vector,
)
from kinetostatics.layout.report import Report
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import describe_twist
from kinetostatics.reports.batch import batch_sections, magnitudes
from kinetostatics.reports.buckling import TITLE, buckling_blocks
from kinetostatics.reports.forces import checked_axes, force_sections
from kinetostatics.reports.pose import facts_of, pose_facts, state_title, statuses_of
from kinetostatics.reports.result_data import result_data
from kinetostatics.reports.sources import gravity_twists, source_table
from kinetostatics.reports.stiffness import component_table, stiffness_blocks
from kinetostatics.reports.summary import summary_facts
from kinetostatics.results.result import Result
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.statics.singularity import UNBALANCED
from kinetostatics.status import WITHOUT_NUMBERS, Status


def result_report(result: Result, hinge_axes: Mapping[str, str] | None = None) -> Report:
    """Return the report of an analysis.

    Args:
        result: the analysis.
        hinge_axes: as in :meth:`kinetostatics.Result.report`.
    """
    hinge_axes = checked_axes(hinge_axes or {}, result.limbs)
    title = [f"Analysis of {result.robot.name!r}: ", *state_title(result), *_motion(result)]
    if result.shape != ():
        return Report(title, lambda: batch_sections(result), lambda: result_data(result))
    return Report(title, lambda: _sections(result, hinge_axes), lambda: result_data(result))


def _motion(result: Result) -> Iterator[str]:
    """Yield displacement and rotation of the platform, unless both are zero."""
    noise = NoiseFloor.of([*result.contributions.values(), result.twist], [], result.robot.length)
    if np.any(np.isfinite(result.twist)):
        moves, turns = (
            Number.range_of(np.linalg.norm(result.twist[..., part], axis=-1), KINDS[kind], getattr(noise, kind))
            for kind, part in (("displacement", slice(3)), ("rotation", slice(3, 6)))
        )
        yield f"; {result.point_name} moves by {moves}, the platform turns by {turns}"


def _sections(result: Result, hinge_axes: Mapping[str, str]) -> Iterator[ReportSection]:
    states = [*statuses_of(result)[1:], *reversed(facts_of(result))]
    yield ReportSection(None, [Text(f", {words}", lead=word) for word, where, words in states if where])
    yield ReportSection("Pose", [_pose(result)], "pose")
    if result.status == Status.SINGULAR:
        yield ReportSection("What can still move", _free_motions(result), "motions")
    if result.status not in WITHOUT_NUMBERS:
        noise = magnitudes(result)
        yield ReportSection("Summary", [summary_facts(result, noise)], "summary")
        yield from _motion_sections(result, noise)
        yield from force_sections(result, noise, hinge_axes)
        yield ReportSection(TITLE, buckling_blocks(result.buckling(3)), "buckling", detail=True)
        if result.beams:
            what = "beams and elastic joints" if result.robot.description.joint_stiffness else "beams"
            energy = (f"Strain energy of the {what}", Number.of(result.strain_energy, ENERGIES))
            yield ReportSection("", [Facts([energy])], "energy", detail=True)
    yield warning_section(result.warnings)


# ---- the pose ------------------------------------------------------------------------------------------------------


def _pose(result: Result) -> Facts:
    configuration, more = result.configuration, _acting(result)
    if configuration.loop_gaps and np.isfinite(configuration.residual):
        open_by = float(configuration.residual)
        more.append(("loops", "closed" if open_by <= CLOSED else f"open by at most {open_by:.1e} (m or rad)"))
    return pose_facts(configuration, result.gravity, result.load, *more)


def _acting(result: Result) -> list[tuple[str, str]]:
    """Return names and texts of the payload, the loads on links and the springs."""
    found = []
    if result.payload is not None:
        frame = "o-xyz" if result.payload.link is None else result.payload.link
        center = np.broadcast_to(np.asarray(result.payload.center, dtype=float), (3,))
        place = vector(center, NumberFormat.of(center, MILLIMETRES, digits=4))
        found.append(("payload", f"{quantity(result.payload.mass, MASSES)} at {place} of {frame}"))
    for name, wrench in result.link_loads.items():
        if name != PAYLOAD:
            noise = 1e-12 * float(np.linalg.norm(wrench[:3])) * result.robot.length
            force, moment = NumberFormat.of(wrench[:3], FORCES), NumberFormat.of(wrench[3:], MOMENTS, noise)
            text = f"{name.removeprefix('load ')}: force {vector(wrench[:3], force)}, moment about o {vector(wrench[3:], moment)}"
            found.append(("load", text))
    if result.spring_forces:
        text = ", ".join(f"{name} {quantity(force, FORCES)}" for name, force in result.spring_forces.items())
        found.append(("springs", f"{text} (tension)"))
    return found


def _free_motions(result: Result) -> list[Block]:
    robot, solution = result.robot, result.solutions[0]
    found = [
        f"{owner}: its passive joints {', '.join(robot.statics.passive_joints(owner))} do not carry all of its weight"
        for owner, part in solution.unbalanced.items()
        if part[0] > UNBALANCED
    ]
    found += [f"the platform: {describe_twist(twist, robot.length)}" for twist in free_twists(robot, solution, 0).T]
    return [Text(text, "item") for text in found or ["the pose is too close to a singular one"]]


# ---- the platform --------------------------------------------------------------------------------------------------


def _motion_sections(result: Result, noise: NoiseFloor) -> list[ReportSection]:
    """Return the tables of the platform's twist and stiffness."""
    kinds = {kind: np.sum(list(named.values()), axis=0) for kind, named in result.source_contributions.items()}
    parts = {
        f"{limb.name}: {part.start} → {part.end}": twist
        for limb in result.robot.topology.limbs
        for part, twist in zip(limb.parts, result.part_contributions.get(limb.name, ()), strict=False)
    }
    gravity = gravity_twists(result) if result.robot.topology.limbs else {}
    total, at = {"total": result.twist}, f"at {result.point_name}, world axes"
    by_kind = {**kinds, **total} if {"joints", "actuators", "assembly_errors"} & {*kinds} else {}
    found: dict[tuple[str, str], list[Block]] = {
        ("twist", f"Twist of the platform {at}"): _twists({**result.contributions, **total}, noise),
        ("gravity", "Effect of gravity, by mechanism"): _twists(gravity, noise),
        (
            "sag",
            "Twist by source: beams, elastic joints, actuators and assembly errors",
        ): _twists(by_kind, noise),
        ("sag", "Sources of the sag: parts along the total displacement and rotation"): source_table(result, noise),
        ("parts", "Elastic displacement of the parts of the limbs"): _twists(parts, noise),
        ("stiffness", f"Stiffness of the platform {at}, actuators locked"): stiffness_blocks(result),
    }
    return [ReportSection(title, blocks, key, detail=True) for (key, title), blocks in found.items()]


def _twists(twists: Mapping[str, Array], noise: NoiseFloor) -> list[Block]:
    """Return a table of twists (6,), a column for each; nothing if there is none."""
    shift = noise.format("displacement", [twist[:3] for twist in twists.values()], digits=6)
    turn = noise.format("rotation", [twist[3:] for twist in twists.values()], digits=6)
    return [component_table(shift, turn, twists)] if twists else []
