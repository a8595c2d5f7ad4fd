"""Reports of a robot (mobility, limbs, wrenches, beams, warnings) and of the contents of its file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence, Sized
from dataclasses import replace
from functools import cache
from math import degrees, isinf

from kinetostatics.checks.chains import Body, Branches, Graph, JointStep, chain_lines
from kinetostatics.checks.check import SMALL_GAP, diagnose
from kinetostatics.checks.diagnosis import (
    AttachedBodiesDiagnosis,
    Diagnosis,
    ElasticJointDiagnosis,
    FlexibleDiagnosis,
    FollowerDiagnosis,
    LimbDiagnosis,
    MobilityDiagnosis,
)
from kinetostatics.checks.input_warnings import zero_loop_gaps
from kinetostatics.checks.local_freedoms import LocalFreedom
from kinetostatics.checks.redundancy import Redundancy
from kinetostatics.description.elements import Spring
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.files.bundled import shown_path
from kinetostatics.kinematics.loop_gaps import CLOSED
from kinetostatics.layout.blocks import Block, Column, Facts, Lines, ReportSection, Table, Text, warning_section
from kinetostatics.layout.numbers import MASSES, MILLIMETRES, join_words, quantity
from kinetostatics.layout.report import Report, as_json, attributes
from kinetostatics.reports.pose import count
from kinetostatics.robot import Robot

UNKNOWN = "not known"
#: Units and meaning of the numbers.
UNITS = {
    "general": "SI: m, rad, kg, Pa; null: infinite, not known or not given",
    "mobility": "numbers of freedoms and constraints at generic poses; redundancies: locations of the redundant constraints",
    "zero": "loop_gaps with all joints at zero; actuators [m, rad] and closing_error [scaled m or rad] at the closed zero pose",
    "mass": "kg at the zero pose",
    "graph": "chain from base to platform: bodies, joints, branches (parallel runs, or a network); hanging: branches on a body",
    "depth": "m, the section's larger side or diameter",
    "shear_areas": "m², null: no shear deformation",
    "thermal_expansion": "1/K",
    "elastic_joints": "linear [N/m] along, angular [N·m/rad] about axes of the joint's frame; drive: its actuator; null: rigid; "
    "coupled: inverse compliances of a matrix",
    "springs": "between links: stiffness N/m, free_length m, preload N: the tension at the free length",
    "followers": "multiplier times the leader's coordinate plus offset [m, rad]",
}
#: Data of springs between links, without the positions of their ends.
_SPRING = ("name", "predecessor", "successor", "stiffness", "free_length", "preload")
#: Types of the parts of a limb's graph.
_TYPES = {Body: "body", JointStep: "joint", Branches: "branches"}


def robot_report(robot: Robot) -> Report:
    """Return the report of a robot; its loops need not close."""
    facts_of = cache(diagnose)
    parts: dict[str, Sized] = {
        "limb": robot.topology.limbs,
        "actuator": robot.description.actuated,
        "beam": robot.description.beams,
        **({"flexible link": robot.description.flexible} if robot.description.flexible else {}),
    }
    title = f"Robot {robot.name!r}: " + ", ".join(count(len(some), noun) for noun, some in parts.items())
    return Report(title, lambda: _sections(facts_of(robot)), lambda: _data(facts_of(robot)))


def _sections(diagnosis: Diagnosis) -> Iterator[ReportSection]:
    yield ReportSection(None, [_summary(diagnosis)])
    yield ReportSection("Limbs, from base to platform", _limbs(diagnosis), "limbs")
    yield ReportSection("Beams, at the zero pose", _beams(diagnosis) if diagnosis.beams else [], "beams")
    yield ReportSection("Links by matrices", _flexible(diagnosis.flexible) if diagnosis.flexible else [], "flexible")
    title = "Elastic joints, along and about the axes of their frames"
    yield ReportSection(title, _elastic_joints(diagnosis.elastic_joints) if diagnosis.elastic_joints else [], "joints")
    yield ReportSection("Springs between links", _springs(diagnosis.springs) if diagnosis.springs else [], "springs")
    yield ReportSection("Joints that follow others", [Text(_follower(follower)) for follower in diagnosis.followers], "followers")
    for role, weight in (("base", diagnosis.on_base), ("platform", diagnosis.on_platform)):
        if weight is not None and (role == "platform" or weight.mass or weight.graph.hanging):
            yield ReportSection(f"On the {role}", _attached_bodies(weight), "attached")
    yield ReportSection("Cannot be analysed", [Text(problem, "warning") for problem in diagnosis.problems], "problems")
    yield warning_section(diagnosis.warnings)


def _data(diagnosis: Diagnosis) -> dict[str, object]:
    """Return the facts as data; each element of a chain gets the entry ``type``: "body", "joint" or "branches"."""
    data: dict[str, object] = as_json(diagnosis)
    data["springs"] = [attributes(spring, _SPRING) for spring in diagnosis.springs]
    data["limbs"] = [{**as_json(limb), "graph": _graph(limb.graph)} for limb in diagnosis.limbs]
    for role, weight in (("on_base", diagnosis.on_base), ("on_platform", diagnosis.on_platform)):
        if weight is not None:
            data[role] = {**as_json(weight), "graph": _graph(weight.graph)}
    return {**data, "units": UNITS}


def _graph(part: object) -> object:
    if isinstance(part, tuple):
        return [_graph(element) for element in part]
    if not dataclasses.is_dataclass(part):
        return part
    kind = {"type": _TYPES[type(part)]} if type(part) in _TYPES else {}
    return {**kind, **{field.name: _graph(getattr(part, field.name)) for field in dataclasses.fields(part)}}


def description_report(description: RobotDescription) -> Report:
    names = ("links", "joints", "loops", "beams", "flexible", "joint_stiffness", "actuated")
    nouns = ("link", "joint", "loop", "beam", "flexible link", "elastic joint", "actuator")
    elements = [(list(getattr(description, name)), noun) for name, noun in zip(names, nouns, strict=True)]
    counts = ", ".join(count(len(some), noun) for some, noun in elements if some or noun in ("link", "joint"))
    rows = [(f"{noun}s", f"{len(some)}", join_words(some, 12)) for some, noun in elements if some]
    rows.append(("platform", "1", description.platform))
    table = Table.of_rows(("", "number", "names"), rows)
    return Report(
        f"RobotDescription {description.name!r} from {shown_path(description.path)!r}: {counts}",
        lambda: [ReportSection("", [table])],
        lambda: {"name": description.name, "platform": description.platform, **{f"{noun}s": some for some, noun in elements}},
    )


# ---- the summary -----------------------------------------------------------------------------------------------------


def _summary(diagnosis: Diagnosis) -> Facts:
    rows: list[tuple[str, list[str]]] = [
        ("file", [shown_path(diagnosis.file)]),
        ("base", [diagnosis.base]),
        ("platform", [diagnosis.platform]),
    ]
    mobility = diagnosis.mobility
    if mobility is None:
        rows += [("mobility", [UNKNOWN]), ("redundant constraints", [UNKNOWN])]
    else:
        rows.append(("mobility", [_mobility(mobility)]))
        if mobility.local_freedoms:
            rows.append(("local freedoms", _local_freedoms(mobility.local_freedoms)))
        rows.append(("redundant constraints", _redundancy(diagnosis, mobility)))
    rows.append(
        ("actuators", [f"{len(diagnosis.actuators)}: {', '.join(diagnosis.actuators)}" if diagnosis.actuators else "none"])
    )
    kinds = {step.kind for limb in diagnosis.limbs for step in limb.joints}
    if not diagnosis.elastic_joints and not all(JOINT_TYPES[kind].is_fixed for kind in kinds):
        rows.append(("elastic joints", ["none: bearings and actuators count as rigid"]))
    rows.append(("mass", [_mass(diagnosis)]))
    if diagnosis.massless:
        rows.append(("without mass", [join_words(diagnosis.massless, 8)]))
    rows.append(("zero pose", [_zero(diagnosis)]))
    return Facts(rows)


def _mobility(mobility: MobilityDiagnosis) -> str:
    text = f"{mobility.platform}" + (f" (+{mobility.local} local)" if mobility.local else "")
    if mobility.coordinates:
        text += f"; {', '.join(mobility.coordinates)} place{'s' * (len(mobility.coordinates) == 1)} the platform"
    return text


def _local_freedoms(freedoms: list[LocalFreedom]) -> list[str]:
    spinning = [freedom for freedom in freedoms if freedom.kind == "spin" and not freedom.actuators]
    lines = []
    if spinning:
        names = join_words([" with ".join(freedom.links) for freedom in spinning], 12)
        several = len(spinning) > 1 or len(spinning[0].links) > 1
        axes = "their own axes" if len(spinning) > 1 else "their common axis" if several else "its own axis"
        lines.append(f"{names} spin{'s' * (not several)} about {axes}")
    for freedom in freedoms:
        if freedom in spinning:
            continue
        several = len(freedom.links) > 1
        text = join_words(freedom.links, 8)
        if freedom.kind == "move":
            text += f" can move in {freedom.count} way{'s' * (freedom.count > 1)}"
        elif freedom.kind == "slide":
            text += f" slide{'s' * (not several)}" + (f" along {freedom.joint}" if freedom.joint else "")
        else:
            axis = freedom.joint or f"{'their' if several else 'its'} own axis"
            text += f" turn{'s' * (not several)} about {axis}"
        lines.append(text + (f", with the actuators {join_words(freedom.actuators)}" if freedom.actuators else ""))
    return lines


def _redundancy(diagnosis: Diagnosis, mobility: MobilityDiagnosis) -> list[str]:
    count = mobility.redundant_constraints
    text = f"{count}" + (" (overconstrained)" if count else " (not overconstrained)")
    if mobility.gap < SMALL_GAP:
        text += f", doubtful: gap of singular values only {mobility.gap:.2g}"
    lines = [text, *_places(diagnosis.limbs, mobility.redundancies)]
    if mobility.redundant_actuators:
        actuators, more = len(diagnosis.actuators), "more " * bool(count)
        locked = actuators - mobility.redundant_actuators
        freedoms = f"{locked} freedom{'s' * (locked != 1)}"
        lines.append(f"{mobility.redundant_actuators} {more}with the actuators locked: {actuators} actuators hold {freedoms}")
    if count or mobility.redundant_actuators:
        lines.append("errors of lengths, angles and temperature cause self-stress: see kinetostatics tolerances")
    return lines


def _places(limbs: list[LimbDiagnosis], redundancies: list[Redundancy]) -> list[str]:
    """Return lines on the locations of redundant constraints; equal limbs share a line."""
    like = {limb.name: limb.like or limb.name for limb in limbs}
    inside: dict[tuple[int, str, int], list[Redundancy]] = {}
    lines: list[str] = []
    for constraint in redundancies:
        if len(constraint.limbs) == 1:
            name = constraint.limbs[0]
            inside.setdefault((constraint.count, like.get(name, name), len(constraint.joints)), []).append(constraint)
    for (number, _, _), alike in inside.items():
        names = [constraint.limbs[0] for constraint in alike]
        where = f"{number} inside {'each of ' * (len(alike) > 1)}{join_words(names)}"
        where = where.replace("inside base", "in rings on the base").replace("inside platform", "in rings on the platform")
        rings = [join_words(constraint.beams or constraint.joints) for constraint in alike]
        lines.append(f"{where}: in the ring{'s' * (len(alike) > 1)} of {'; '.join(rings)}")
    for constraint in redundancies:
        if len(constraint.limbs) > 1:
            text = f"{constraint.count} between {join_words(constraint.limbs)}"
            lines.append(text + (f", with self-stress by {join_words(constraint.wrenches)}" if constraint.wrenches else ""))
        elif not constraint.limbs and constraint.joints:
            loops = join_words(constraint.joints)
            lines.append(f"{constraint.count} in the loops {loops}, which join links that are welded to one another")
        elif not constraint.limbs:
            lines.append(f"{constraint.count} through joints that follow others")
    return lines


def _mass(diagnosis: Diagnosis) -> str:
    if diagnosis.mass is None:
        return UNKNOWN
    text = f"{quantity(diagnosis.mass, MASSES)} at the zero pose"
    return text + (", telescopic beams' masses follow the pose" if diagnosis.mass_follows_pose else "")


def _zero(diagnosis: Diagnosis) -> str:
    zero = diagnosis.zero
    if zero.closing_error is None:
        return f"the loops do not close; where all joints are at zero they are {zero_loop_gaps(diagnosis)}"
    if not zero.loop_gaps:
        return "there are no loops"
    text = "the loops close" if zero.closing_error <= CLOSED else f"the loops stay open by {zero.closing_error:.2g} (m or rad)"
    if max(zero.widest("m")[0], zero.widest("rad")[0]) > 1e-9:
        text += f"; where all joints are at zero they are {zero_loop_gaps(diagnosis)}"
    elif zero.closing_error <= CLOSED:
        text += " where all joints are at zero"
    return text


# ---- limbs -----------------------------------------------------------------------------------------------------------


def _limbs(diagnosis: Diagnosis) -> list[Block]:
    if not diagnosis.limbs:
        return [Text("none")]
    blocks: list[Block] = []
    for number, limb in enumerate(diagnosis.limbs):
        gap = [""] * bool(number and not (limb.like and diagnosis.limbs[number - 1].like))
        lines = [*gap, f"{limb.name}: {limb.word}" + (f", like {limb.like}" if limb.like else "")]
        lines += chain_lines(diagnosis.base, limb.graph.chain, diagnosis.platform, "  ")
        blocks.append(Lines([*lines, *_hanging(limb.graph, "  ")]))
        if limb.like:
            continue
        rows: list[tuple[str, str | list[str]]] = []
        rows.append(("beams", "; ".join(_spans(diagnosis, limb)) or ("none: rigid" if limb.rigid else "none")))
        if limb.flexible:
            rows.append(("by matrices", join_words(limb.flexible)))
        if limb.parts:
            rows.append(("parts", ", ".join(f"{start} to {end}" for start, end in limb.parts)))
        rows.append(("mass", UNKNOWN if limb.mass is None else quantity(limb.mass, MASSES)))
        for kind, labels in (("constraint", limb.constraint_wrenches), ("attached", limb.attached_wrenches)):
            rows.append((kind, UNKNOWN if labels is None else list(labels) or "none"))
        blocks.append(Facts(rows, indent=2))
    return [*blocks, *_legend(diagnosis.limbs)]


def _spans(diagnosis: Diagnosis, limb: LimbDiagnosis) -> list[str]:
    """Return "BEAM from END to END" for each beam of a limb; beams welded end to end are listed as one."""
    joints = {joint.name for joint in limb.joints}
    spans = [([beam.name], beam.start, beam.end) for beam in diagnosis.beams if beam.name in limb.beams]
    ends = [end for _, *both in spans for end in both]
    welds = {end for end in ends if end not in joints and ends.count(end) == 2}
    for weld in welds:
        before = next((span for span in spans if span[2] == weld), None)
        after = next((span for span in spans if span[1] == weld), None)
        if before and after and before is not after:
            spans[spans.index(before)] = ([*before[0], *after[0]], before[1], after[2])
            spans.remove(after)
    return [f"{join_words(names)} from {start} to {end}" for names, start, end in spans]


#: Explanations of wrench labels, by a part of the labels.
_LEGEND = {
    "": "Constraint wrenches hold the platform; attached wrenches transmit the limb's weight to it.",
    "limb ": "Limb axes: z is along the last beam (without beams, from the first joint to the last). y is perpendicular to z, in "
    "the plane of z and the first passive axis of rotation (without one, a world axis). x = y × z.",
    "component": "Components are coordinates, in a basis, of the wrench of a limb that is a network; the forces in its beams "
    "and joints differ.",
    "complementary": "Complementary wrenches complete the basis; they have no simple geometric meaning.",
}


def _legend(limbs: list[LimbDiagnosis]) -> list[Block]:
    labels = " ".join(label for limb in limbs for label in (*(limb.constraint_wrenches or ()), *(limb.attached_wrenches or ())))
    explanations = [Text(text) for word, text in _LEGEND.items() if labels and word in labels]
    return [Lines([""]), *explanations] if explanations else []


def _hanging(graph: Graph, indent: str) -> list[str]:
    lines: list[str] = []
    for branch in graph.hanging:
        if branch.chain:
            lines.append(f"{indent}{'ring on' if branch.is_ring else 'hanging on'} {branch.at}:")
            lines += chain_lines("", branch.chain, branch.at if branch.is_ring else "", indent + "  ")
    return lines


# ---- tables ----------------------------------------------------------------------------------------------------------


def _beams(diagnosis: Diagnosis) -> list[Block]:
    """Return a table in which equal beams share a row."""
    beams = diagnosis.beams
    columns = [
        Column("section", [beam.section for beam in beams]),
        Column.of("length", [math.nan if beam.length is None else beam.length for beam in beams], MILLIMETRES, digits=5),
        Column("", ["telescopic" if beam.telescopic else "" for beam in beams]),
        Column("E [GPa]", [f"{beam.youngs_modulus / 1e9:.5g}" for beam in beams], "r"),
        Column("G [GPa]", [f"{beam.shear_modulus / 1e9:.5g}" for beam in beams], "r"),
        Column("ρ [kg/m³]", ["link's mass" if beam.density is None else f"{beam.density:.6g}" for beam in beams], "r"),
        Column.of("mass", [math.nan if beam.mass is None else beam.mass for beam in beams], MASSES, digits=5),
    ]
    if any(beam.thermal_expansion for beam in beams):
        columns.append(Column("α [10⁻⁶/K]", [f"{1e6 * beam.thermal_expansion:.4g}" for beam in beams], "r"))
    alike: dict[tuple[str, ...], list[int]] = {}
    for k, row in enumerate(zip(*(column.texts for column in columns), strict=True)):
        alike.setdefault(row, []).append(k)
    names = Column("beam", [join_words([beams[k].name for k in some], 3) for some in alike.values()])
    return [Table([names, *(replace(column, cells=[column.cells[some[0]] for some in alike.values()]) for column in columns)])]


def _flexible(links: Sequence[FlexibleDiagnosis]) -> list[Block]:
    numbers = sorted({name for link in links for name in link.numbers})
    columns = [
        Column("link", [link.name for link in links]),
        Column("interfaces", [join_words(link.interfaces) for link in links]),
        *(Column(name.replace("_", " "), [f"{link.numbers.get(name, math.nan):.6g}" for link in links], "r") for name in numbers),
        Column.of("mass", [math.nan if link.mass is None else link.mass for link in links], MASSES, digits=5),
    ]
    return [Table(columns)]


def _springs(springs: Sequence[Spring]) -> list[Block]:
    header = ("spring", "from", "to", "stiffness [N/m]", "free length [mm]", "preload [N]")
    numbers = [[f"{value:.6g}" for value in (spring.stiffness, 1e3 * spring.free_length, spring.preload)] for spring in springs]
    rows = [(spring.name, spring.predecessor, spring.successor, *row) for spring, row in zip(springs, numbers, strict=True)]
    return [Table.of_rows(header, rows, "lllrrr")]


def _elastic_joints(joints: Sequence[ElasticJointDiagnosis]) -> list[Block]:
    has_linear = not all(isinf(v) for joint in joints for v in joint.linear)
    has_angular = not all(isinf(v) for joint in joints for v in joint.angular)
    header = ["joint", *["x [N/µm]", "y", "z"] * has_linear, *["rx [N·m/mrad]", "ry", "rz"] * has_angular, "actuator"]
    rows: dict[tuple[str, ...], list[str]] = {}
    for joint in joints:
        row = [_stiffness(value, 1e6) for value in joint.linear] if has_linear else []
        row += [_stiffness(value, 1e3) for value in joint.angular] if has_angular else []
        slides = JOINT_TYPES[joint.kind].is_slide
        unit = "N/µm" if slides else "N·m/mrad"
        row.append("" if joint.drive is None else f"{_stiffness(joint.drive, 1e6 if slides else 1e3)} {unit}")
        rows.setdefault(tuple(row), []).append(joint.joint + " (coupled)" * joint.coupled)
    return [Table.of_rows(header, [(join_words(names, 4), *row) for row, names in rows.items()])]


def _stiffness(value: float, unit: float) -> str:
    return "rigid" if isinf(value) else f"{value / unit:.4g}"


def _follower(follower: FollowerDiagnosis) -> str:
    text = f"{follower.joint} = {follower.multiplier:.6g} · {follower.leader}"
    if follower.offset:
        slides = JOINT_TYPES[follower.kind].is_slide
        offset = f"{1e3 * abs(follower.offset):.6g} mm" if slides else f"{degrees(abs(follower.offset)):.6g}°"
        text += f" {'−' if follower.offset < 0 else '+'} {offset}"
    return text


def _attached_bodies(weight: AttachedBodiesDiagnosis) -> list[Block]:
    mass = UNKNOWN if weight.mass is None else quantity(weight.mass, MASSES)
    facts = Facts([("links", ", ".join(weight.links)), ("mass", mass)])
    return [facts, *([Lines(hanging)] if (hanging := _hanging(weight.graph, "")) else [])]
