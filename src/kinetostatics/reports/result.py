"""Report of an analysis: summary and tables of one pose, or extremes over a batch; all quantities as data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kinetostatics.analysis import free_twists
from kinetostatics.kinematics.loop_gaps import CLOSED
from kinetostatics.layout.blocks import Block, Facts, Number, ReportSection, Table, Text, warning_section
from kinetostatics.layout.numbers import (
    ENERGIES,
    FORCE_KINDS,
    FORCES,
    KINDS,
    MASSES,
    MILLIMETRES,
    MOMENTS,
    NOISE,
    PER_CENT,
    STIFFNESSES,
    STRESSES,
    NoiseFloor,
    NumberFormat,
    Units,
    quantity,
    vector,
)
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import describe_twist
from kinetostatics.quantities import QUANTITIES, reported_names
from kinetostatics.reports.dynamics import BUCKLING_TITLE, buckling_blocks
from kinetostatics.reports.parts import BEAM_DATA, beam_data, checked_axes, force_sections, limb_data
from kinetostatics.reports.pose import (
    actuator_coordinates,
    actuator_unit,
    configuration_data,
    facts_of,
    platform_coordinates,
    pose_facts,
    state_title,
    status_names,
    statuses_of,
)
from kinetostatics.reports.sources import contribution_table, gravity_twists, part_table, source_table
from kinetostatics.reports.summary import component_table, stiffness_blocks, summary_facts
from kinetostatics.results.result import Result
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.statics.singularity import UNBALANCED
from kinetostatics.status import WITHOUT_NUMBERS, Status

#: Units and meaning of the numbers; batch axes come first.
UNITS = {
    "general": "SI: m, rad, kg, s, N, N·m, Pa; world axes; null: not a number, infinite or not determined",
    "batch": "arrays have the axes of `shape` first, those of `configuration` the axes of `configuration.shape`",
    "payload": "mass [kg] at center [m] in the frame of link, null: o-xyz; coefficients: twist, actuator_forces and "
    "joint_wrenches per kg of the mass and per kg·m of its first moments, in the order of `parameters`, along the last axis",
    "limbs": "wrenches acting on the limb: unit wrenches [force; moment] about o, intensities in `units`; where "
    "`is_network`, intensities are coordinates in a basis: the forces are `joint_wrenches` of its `platform_joints` and "
    "`section_wrenches` of its `beams`",
    "stations": "0 at the base end, 1 at the platform end of a beam; deflections in m, rotations in rad, stress in Pa",
    **{name: QUANTITIES[name].description for name in reported_names("")},
    **{name: QUANTITIES[f"beams.{name}"].description for name in reported_names("beams") if name in BEAM_DATA},
}


def result_data(tip: Result) -> dict[str, object]:
    """Return all results at o; if the reference point of ``tip`` is a tool's tip, also twist, stiffness and compliance there."""
    result = tip.seen_from(None)
    payload = result.payload and {
        **attributes(result.payload, ("mass", "center", "link")),
        "coefficients": result.payload_coefficients,
    }
    data: dict[str, object] = {
        "robot": result.robot.name,
        "file": result.robot.description.path,
        "units": UNITS,
        "shape": result.shape,
        "status": status_names(result.status),
        **result.facts,
        "warnings": result.warnings,
        "configuration": configuration_data(result.configuration),
        "payload": payload,
        **attributes(result, reported_names("")),
        "actuator_units": {name: actuator_unit(result.robot, name) for name in result.actuator_forces},
        "margins": attributes(result.margins, ("safety_factors", "smallest", "limited_by")),
        "limbs": {name: limb_data(limb) for name, limb in result.limbs.items()},
        "beams": {name: beam_data(beam) for name, beam in result.beams.items()},
    }
    if tip.point is not None:
        data["tool"] = {"point": tip.point, **attributes(tip, ("twist", "stiffness", "compliance"))}
    return data


def units_at(tool: Array | None, units: Mapping[str, str]) -> dict[str, object]:
    """Return ``units``, texts about numbers at o; with a tool, changed to texts about its tip, and the tip's position (3,)."""
    if tool is None:
        return {"units": units}
    texts = {name: text.replace("at o", "at the tool's tip") for name, text in units.items()}
    return {"units": {**texts, "tool": "the tip, from o in the platform's axes [m]"}, "tool": tool}


def batch_sections(result: Result) -> list[ReportSection]:
    has_numbers = not np.all(np.isin(result.status, WITHOUT_NUMBERS))
    header = ("quantity", "unit", "smallest", "at", "largest", "at")
    rows = [_row(result, *row) for row in _quantities(result)] if has_numbers else []
    title = "Extremes over the valid poses, and their batch indices"
    return [
        ReportSection("Status", _states(result) if result.status.size else [Text("no poses")], "status"),
        ReportSection(title, [Table.of_rows(header, rows, "llrlrl")] if has_numbers else [], "extremes"),
        warning_section(result.warnings if result.status.size else ()),
    ]


def _states(result: Result) -> list[Table | Text]:
    """Return a table of the number of poses in each state; a pose can be in several states."""
    ok, *without_numbers = statuses_of(result)
    states = [ok, *facts_of(result), *without_numbers]
    rows = [(word, f"{int(np.sum(where))}", words) for word, where, words in states if np.any(where)]
    several = int(np.sum(np.sum([where for _, where, _ in states], axis=0) > 1))
    table = Table.of_rows(("status", "poses", ""), rows, "lrl")
    return [table, Text(f"{several} of them counted more than once")] if several else [table]


def noise_floor(result: Result) -> NoiseFloor:
    wrenches = [*result.joint_wrenches.values(), result.platform_wrench]
    return NoiseFloor.of(result.contributions.values(), wrenches, float(result.robot.length))


def _quantities(result: Result) -> list[tuple[str, Array, Units, float]]:
    """Return (name, values (…), units, magnitude of rounding errors) for each row of the table of extremes."""
    twist, noise = result.twist, noise_floor(result)
    rows = [(f"platform {name}", *coordinate) for name, coordinate in platform_coordinates(result.configuration).items()]
    rows += [(f"position of {name}", *coordinate) for name, coordinate in actuator_coordinates(result.configuration).items()]
    for name, part, kind in (("displacement of o", slice(3), "displacement"), ("rotation", slice(3, 6), "rotation")):
        rows.append((name, np.linalg.norm(twist[..., part], axis=-1), KINDS[kind], getattr(noise, kind)))
    compliance = np.where(np.isfinite(result.compliance), result.compliance, 0.0)
    with np.errstate(divide="ignore"):
        stiffness = np.where(np.isnan(twist[..., 0]), np.nan, 1 / np.linalg.eigvalsh(compliance[..., :3, :3])[..., -1])
    rows.append(("softest stiffness at o", stiffness, STIFFNESSES, 0.0))
    for name, value in result.actuator_forces.items():
        kind = FORCE_KINDS[actuator_unit(result.robot, name)]
        rows.append((f"force of {name}", value, KINDS[kind], getattr(noise, kind)))
    for name, beam in result.beams.items():
        rows += [(f"stress in {name}", beam.stress, STRESSES, 0.0), (f"N/N_Euler of {name}", beam.euler_ratio, PER_CENT, NOISE)]
    if result.beams:
        rows.append(("strain energy", result.strain_energy, ENERGIES, 0.0))
    return rows


def _row(result: Result, name: str, values: Array, units: Units, noise: float) -> tuple[str | Number, ...]:
    flat = np.broadcast_to(values, result.shape).ravel()
    form = NumberFormat.of(flat, units, noise)
    missing = np.all(np.isnan(flat))
    cells: list[str | Number] = [name, form.unit]
    for number in (0, 0) if missing else (int(np.nanargmin(flat)), int(np.nanargmax(flat))):
        where = np.unravel_index(number, result.shape)
        cells += [Number(float(flat[number]), form, with_unit=False), "" if missing else f"[{', '.join(map(str, where))}]"]
    return tuple(cells)


def result_report(result: Result, hinge_axes: Mapping[str, str] | None = None) -> Report:
    """See :meth:`kinetostatics.Result.report`."""
    hinge_axes = checked_axes(hinge_axes or {}, result.limbs)
    title = [f"Analysis of {result.robot.name!r}: ", *state_title(result), *_motion(result)]
    tables = {"contributions": lambda: contribution_table(result), "parts": lambda: part_table(result)}
    sections = (lambda: batch_sections(result)) if result.shape else (lambda: [*_sections(result, hinge_axes)])
    return Report(title, sections, lambda: result_data(result), tables)


def _motion(result: Result) -> Iterator[str]:
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
        yield ReportSection("Free motions", _free_motions(result), "motions")
    if result.status not in WITHOUT_NUMBERS:
        noise = noise_floor(result)
        yield ReportSection("Summary", [summary_facts(result, noise)], "summary")
        yield from _motion_sections(result, noise)
        yield from force_sections(result, noise, hinge_axes)
        yield ReportSection(BUCKLING_TITLE, buckling_blocks(result.buckling(3)), "buckling", detail=True)
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
    """Return lines (name, text) on the payload, the loads on links and the springs."""
    lines = []
    if result.payload is not None:
        frame = "o-xyz" if result.payload.link is None else result.payload.link
        center = np.broadcast_to(np.asarray(result.payload.center, dtype=float), (3,))
        place = vector(center, NumberFormat.of(center, MILLIMETRES, digits=4))
        lines.append(("payload", f"{quantity(result.payload.mass, MASSES)} at {place} of {frame}"))
    for name, wrench in result.link_loads.items():
        if name != PAYLOAD:
            noise = 1e-12 * float(np.linalg.norm(wrench[:3])) * result.robot.length
            force, moment = NumberFormat.of(wrench[:3], FORCES), NumberFormat.of(wrench[3:], MOMENTS, noise)
            text = f"{name.removeprefix('load ')}: force {vector(wrench[:3], force)}, moment about o {vector(wrench[3:], moment)}"
            lines.append(("load", text))
    if result.spring_forces:
        text = ", ".join(f"{name} {quantity(force, FORCES)}" for name, force in result.spring_forces.items())
        lines.append(("springs", f"{text} (tension)"))
    return lines


def _free_motions(result: Result) -> list[Block]:
    robot, solution = result.robot, result.solutions[0]
    motions = [
        f"{owner}: its passive joints {', '.join(robot.statics.passive_joints(owner))} do not carry all of its weight"
        for owner, part in solution.unbalanced.items()
        if part[0] > UNBALANCED
    ]
    motions += [f"the platform: {describe_twist(twist, robot.length)}" for twist in free_twists(robot, solution, 0).T]
    return [Text(text, "item") for text in motions or ["the pose is too close to a singular one"]]


# ---- the platform --------------------------------------------------------------------------------------------------


def _motion_sections(result: Result, noise: NoiseFloor) -> list[ReportSection]:
    kinds = {kind: np.sum(list(named.values()), axis=0) for kind, named in result.source_contributions.items()}
    parts = {
        f"{limb.name}: {part.start} → {part.end}": twist
        for limb in result.robot.topology.limbs
        for part, twist in zip(limb.parts, result.part_contributions.get(limb.name, ()), strict=False)
    }
    gravity = gravity_twists(result) if result.robot.topology.limbs else {}
    total, at = {"total": result.twist}, f"at {result.point_name}, world axes"
    by_kind = {**kinds, **total} if {"joints", "actuators", "assembly_errors"} & {*kinds} else {}
    sections: dict[tuple[str, str], list[Block]] = {
        ("twist", f"Twist of the platform {at}"): _twists({**result.contributions, **total}, noise),
        ("gravity", "Effect of gravity, by mechanism"): _twists(gravity, noise),
        ("sag", "Twist by source: beams, elastic joints, actuators and assembly errors"): _twists(by_kind, noise),
        ("sag", "Sources of the sag: parts along the total displacement and rotation"): source_table(result, noise),
        ("parts", "Elastic displacement of the parts of the limbs"): _twists(parts, noise),
        ("stiffness", f"Stiffness of the platform {at}, actuators locked"): stiffness_blocks(result),
    }
    return [ReportSection(title, blocks, key, detail=True) for (key, title), blocks in sections.items()]


def _twists(twists: Mapping[str, Array], noise: NoiseFloor) -> list[Block]:
    shift = noise.format("displacement", [twist[:3] for twist in twists.values()], digits=6)
    turn = noise.format("rotation", [twist[3:] for twist in twists.values()], digits=6)
    return [component_table(shift, turn, twists)] if twists else []
