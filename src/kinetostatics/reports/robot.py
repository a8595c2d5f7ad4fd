"""What a person reads of a robot: ``print(robot)`` and ``kinetostatics check``."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, isinf

from kinetostatics.checks.chains import Graph, chain_lines
from kinetostatics.checks.collect import robot_facts
from kinetostatics.checks.facts import AttachedBodiesFacts, ElasticJointFacts, FollowerFacts, LimbFacts, MobilityFacts, RobotFacts
from kinetostatics.checks.mobility import LocalFreedom
from kinetostatics.checks.redundancy import Redundancy
from kinetostatics.checks.warnings import SMALL_GAP, zero_loop_gaps
from kinetostatics.description.elements import Spring
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.files.bundled import shown_path
from kinetostatics.printing.dispatch import text_of
from kinetostatics.printing.text import CLOSED, MASSES, MISSING, Scale, listing, quantity, section, table, warning_lines, wrapped
from kinetostatics.robot import Robot

UNKNOWN = "not known"


@text_of.register(Robot)
def robot_report(robot: Robot) -> str:
    """Return what there is to know about a robot: mobility, masses, limbs, beams and warnings.

    A robot whose loops cannot be closed still gets a report, which says so.
    """
    return facts_report(robot_facts(robot))


def facts_report(facts: RobotFacts) -> str:
    """Write the facts about a robot down."""
    lines = [f"Robot {facts.name!r}", *(f"  {line}" for line in _summary(facts))]
    lines += section("Limbs, from base to platform", _limbs(facts))
    if facts.beams:
        lines += section("Beams, at the zero pose", _beams(facts))
    if facts.elastic_joints:
        lines += section("Elastic joints, along and about the axes of their frames", _elastic_joints(facts.elastic_joints))
    if facts.springs:
        lines += section("Springs between links", _springs(facts.springs))
    if facts.followers:
        lines += section("Joints that follow others", [_follower(item) for item in facts.followers])
    for role, weight in (("base", facts.on_base), ("platform", facts.on_platform)):
        if weight is not None and (role == "platform" or weight.mass or weight.graph.hanging):
            lines += section(f"On the {role}", _dead_weight(weight))
    if facts.problems:
        lines += section("Cannot be analysed", [line for item in facts.problems for line in wrapped(item, "! ")])
    lines += warning_lines(facts.warnings)
    return "\n".join(lines)


# ---- the summary -----------------------------------------------------------------------------------------------------


def _summary(facts: RobotFacts) -> list[str]:
    rows = [("file", [shown_path(facts.file)]), ("base", [facts.base]), ("platform", [facts.platform])]
    mobility = facts.mobility
    if mobility is None:
        rows += [("mobility", [UNKNOWN]), ("redundant constraints", [UNKNOWN])]
    else:
        rows.append(("mobility", [_mobility(mobility)]))
        if mobility.local_freedoms:
            rows.append(("local freedoms", _local_freedoms(mobility.local_freedoms)))
        rows.append(("redundant constraints", _redundancy(facts, mobility)))
    rows.append(("actuators", [f"{len(facts.drives)}: {', '.join(facts.drives)}" if facts.drives else "none"]))
    if not facts.elastic_joints and not all(JOINT_TYPES[step.kind].is_fixed for limb in facts.limbs for step in limb.joints):
        rows.append(("elastic joints", ["none: bearings and actuators count as rigid"]))
    rows.append(("mass", [_mass(facts)]))
    if facts.massless:
        rows.append(("without mass", [listing(facts.massless, 8)]))
    rows.append(("zero pose", [_zero(facts)]))
    width = max(len(name) for name, _ in rows)
    lines = []
    for name, texts in rows:
        for number, text in enumerate(texts):
            lines += wrapped(text, f"{'' if number else name:{width}}  ")
    return lines


def _mobility(mobility: MobilityFacts) -> str:
    text = f"{mobility.platform}" + (f" (+{mobility.local} local)" if mobility.local else "")
    if mobility.coordinates:
        text += f"; {', '.join(mobility.coordinates)} place{'s' * (len(mobility.coordinates) == 1)} the platform"
    return text


def _local_freedoms(freedoms: list[LocalFreedom]) -> list[str]:
    spinning = [item for item in freedoms if item.kind == "spin" and not item.drives]
    lines = []
    if spinning:
        names = listing([" with ".join(item.links) for item in spinning], 12)
        several = len(spinning) > 1 or len(spinning[0].links) > 1
        own = "their own axes" if len(spinning) > 1 else "their common axis" if several else "its own axis"
        lines.append(f"{names} spin{'s' * (not several)} about {own}")
    for item in freedoms:
        if item in spinning:
            continue
        several = len(item.links) > 1
        text = listing(item.links, 8)
        if item.kind == "move":
            text += f" can move in {item.count} way{'s' * (item.count > 1)}"
        elif item.kind == "slide":
            text += f" slide{'s' * (not several)}" + (f" along {item.joint}" if item.joint else "")
        else:
            axis = item.joint or f"{'their' if several else 'its'} own axis"
            text += f" turn{'s' * (not several)} about {axis}"
        lines.append(text + (f", with the actuators {listing(item.drives)}" if item.drives else ""))
    return lines


def _redundancy(facts: RobotFacts, mobility: MobilityFacts) -> list[str]:
    count = mobility.redundant_constraints
    text = f"{count}" + (" (overconstrained)" if count else " (not overconstrained)")
    if mobility.gap < SMALL_GAP:
        text += f", doubtful: gap of singular values only {mobility.gap:.2g}"
    lines = [text, *_places(facts.limbs, mobility.redundancies)]
    if mobility.redundant_actuators:
        actuators, more = len(facts.drives), "more " * bool(count)
        held = actuators - mobility.redundant_actuators
        freedoms = f"{held} freedom{'s' * (held != 1)}"
        lines.append(f"{mobility.redundant_actuators} {more}with the actuators locked: {actuators} actuators hold {freedoms}")
    if count or mobility.redundant_actuators:
        lines.append("errors of lengths, angles and temperature lock in forces: see kinetostatics tolerances")
    return lines


def _places(limbs: list[LimbFacts], redundancies: list[Redundancy]) -> list[str]:
    """Say where redundant constraints are, limbs that are built alike in one line."""
    like = {limb.name: limb.like or limb.name for limb in limbs}
    inside: dict[tuple[int, str, int], list[Redundancy]] = {}
    lines: list[str] = []
    for item in redundancies:
        if len(item.limbs) == 1:
            name = item.limbs[0]
            inside.setdefault((item.count, like.get(name, name), len(item.joints)), []).append(item)
    for (count, _, _), items in inside.items():
        names = [item.limbs[0] for item in items]
        where = f"{count} inside {'each of ' * (len(items) > 1)}{listing(names)}"
        where = where.replace("inside base", "in rings on the base").replace("inside platform", "in rings on the platform")
        rings = [listing(item.beams or item.joints) for item in items]
        lines.append(f"{where}: in the ring{'s' * (len(items) > 1)} of {'; '.join(rings)}")
    for item in redundancies:
        if len(item.limbs) > 1:
            text = f"{item.count} between {listing(item.limbs)}"
            lines.append(text + (f": they brace by {listing(item.wrenches)}" if item.wrenches else ""))
        elif not item.limbs and item.joints:
            lines.append(f"{item.count} in the loops {listing(item.joints)}, which join links that are welded to one another")
        elif not item.limbs:
            lines.append(f"{item.count} through joints that follow others")
    return lines


def _mass(facts: RobotFacts) -> str:
    if facts.mass is None:
        return UNKNOWN
    text = f"{quantity(facts.mass, MASSES)} at the zero pose"
    return text + (", telescopic beams' masses follow the pose" if facts.mass_follows_pose else "")


def _zero(facts: RobotFacts) -> str:
    zero = facts.zero
    if zero.closing_error is None:
        return f"the loops do not close; where all joints are at zero they are {zero_loop_gaps(facts)}"
    if not zero.loop_gaps:
        return "it has no loops that would have to close"
    text = "the loops close" if zero.closing_error <= CLOSED else f"the loops stay open by {zero.closing_error:.2g} (m or rad)"
    if max(zero.widest("m")[0], zero.widest("rad")[0]) > 1e-9:
        text += f"; where all joints are at zero they are {zero_loop_gaps(facts)}"
    elif zero.closing_error <= CLOSED:
        text += " where all joints are at zero"
    return text


# ---- limbs -----------------------------------------------------------------------------------------------------------


def _limbs(facts: RobotFacts) -> list[str]:
    if not facts.limbs:
        return ["none"]
    lines: list[str] = []
    for number, limb in enumerate(facts.limbs):
        lines += [""] * bool(number and not (limb.like and facts.limbs[number - 1].like))
        lines.append(f"{limb.name}: {limb.word}" + (f", like {limb.like}" if limb.like else ""))
        lines += chain_lines(facts.base, limb.graph.chain, facts.platform, "  ")
        lines += _hanging(limb.graph, "  ")
        if limb.like:
            continue
        rows = [("beams", "; ".join(_spans(facts, limb)) or ("none: rigid" if limb.rigid else "none"))]
        if limb.parts:
            rows.append(("parts", ", ".join(f"{start} to {end}" for start, end in limb.parts)))
        rows.append(("mass", UNKNOWN if limb.mass is None else quantity(limb.mass, MASSES)))
        rows += _wrenches("constraint", limb.constraint_wrenches)
        rows += _wrenches("attached", limb.attached_wrenches)
        lines += [line for name, text in rows for line in wrapped(text, f"  {name:11}")]
    return [*lines, *_legend(facts.limbs)]


def _spans(facts: RobotFacts, limb: LimbFacts) -> list[str]:
    """Say from where to where the beams of a limb go, those that are welded end to end in one."""
    joints = {joint.name for joint in limb.joints}
    spans = [([beam.name], beam.start, beam.end) for beam in facts.beams if beam.name in limb.beams]
    ends = [end for _, *both in spans for end in both]
    welds = {end for end in ends if end not in joints and ends.count(end) == 2}
    for weld in welds:
        before = next((span for span in spans if span[2] == weld), None)
        after = next((span for span in spans if span[1] == weld), None)
        if before and after and before is not after:
            spans[spans.index(before)] = ([*before[0], *after[0]], before[1], after[2])
            spans.remove(after)
    return [f"{listing(names)} from {start} to {end}" for names, start, end in spans]


def _wrenches(kind: str, labels: tuple[str, ...] | None) -> list[tuple[str, str]]:
    if labels is None:
        return [(kind, UNKNOWN)]
    return [(kind if k == 0 else "", label) for k, label in enumerate(labels or ("none",))]


#: What the words of wrenches mean, by what is in them.
_LEGEND = {
    "": "between limb and platform: constraint wrenches hold the platform, attached ones carry the limb's own weight",
    "limb ": "limb axes: z along the last beam (else from the first joint to the last), y the first passive axis that turns "
    "(else a world axis) made square to z, x = y × z",
    "component": "components: coordinates, in a basis, of what the platform puts on a limb that is a network; its beams "
    "and joints carry other forces",
    "complementary": "complementary wrenches: what is left where nothing plainer fits",
}


def _legend(limbs: list[LimbFacts]) -> list[str]:
    """Say what the words mean that are used."""
    labels = " ".join(label for limb in limbs for label in (*(limb.constraint_wrenches or ()), *(limb.attached_wrenches or ())))
    known = [text for word, text in _LEGEND.items() if labels and word in labels]
    return [""] * bool(known) + [line for text in known for line in wrapped(text)]


def _hanging(graph: Graph, indent: str) -> list[str]:
    lines: list[str] = []
    for item in graph.hanging:
        if item.chain:
            lines.append(f"{indent}{'ring on' if item.is_ring else 'hanging on'} {item.at}:")
            lines += chain_lines("", item.chain, item.at if item.is_ring else "", indent + "  ")
    return lines


# ---- tables ----------------------------------------------------------------------------------------------------------


def _beams(facts: RobotFacts) -> list[str]:
    beams = facts.beams
    length = Scale.of([beam.length or 0.0 for beam in beams], (("mm", 1e-3),))
    mass = Scale.of([beam.mass or 0.0 for beam in beams], MASSES)
    warm = any(beam.thermal_expansion for beam in beams)
    rows: dict[tuple[str, ...], list[str]] = {}
    for beam in beams:
        row = (
            beam.section,
            MISSING if beam.length is None else length(beam.length),
            "telescopic" if beam.telescopic else "",
            f"{beam.youngs_modulus / 1e9:.5g}",
            f"{beam.shear_modulus / 1e9:.5g}",
            "link's mass" if beam.density is None else f"{beam.density:.6g}",
            MISSING if beam.mass is None else mass(beam.mass),
            *([f"{1e6 * beam.thermal_expansion:.4g}"] if warm else []),
        )
        rows.setdefault(row, []).append(beam.name)
    header = ("beam", "section", f"length [{length.unit}]", "", "E [GPa]", "G [GPa]", "ρ [kg/m³]", f"mass [{mass.unit}]")
    return table(
        (*header, *(["α [10⁻⁶/K]"] if warm else [])),
        [(listing(names, 3), *row) for row, names in rows.items()],
        "llrlrrrr" + "r" * warm,
    )


def _springs(springs: Sequence[Spring]) -> list[str]:
    rows = []
    for item in springs:
        numbers = (f"{value:.6g}" for value in (item.stiffness, 1e3 * item.free_length, item.preload))
        rows.append((item.name, item.predecessor, item.successor, *numbers))
    return table(("spring", "from", "to", "stiffness [N/m]", "free length [mm]", "preload [N]"), rows, "lllrrr")


def _elastic_joints(joints: Sequence[ElasticJointFacts]) -> list[str]:
    has_linear = not all(isinf(v) for item in joints for v in item.linear)
    has_angular = not all(isinf(v) for item in joints for v in item.angular)
    header = ["joint"]
    header += ["x [N/µm]", "y", "z"] if has_linear else []
    header += ["rx [N·m/mrad]", "ry", "rz"] if has_angular else []
    rows: dict[tuple[str, ...], list[str]] = {}
    for item in joints:
        row = [_stiffness(value, 1e6) for value in item.linear] if has_linear else []
        row += [_stiffness(value, 1e3) for value in item.angular] if has_angular else []
        slides = JOINT_TYPES[item.kind].is_slide
        unit = "N/µm" if slides else "N·m/mrad"
        row.append("" if item.drive is None else f"{_stiffness(item.drive, 1e6 if slides else 1e3)} {unit}")
        rows.setdefault(tuple(row), []).append(item.joint)
    return table([*header, "actuator"], [(listing(names, 4), *row) for row, names in rows.items()])


def _stiffness(value: float, unit: float) -> str:
    return "rigid" if isinf(value) else f"{value / unit:.4g}"


def _follower(item: FollowerFacts) -> str:
    text = f"{item.joint} = {item.multiplier:.6g} · {item.leader}"
    if item.offset:
        slides = JOINT_TYPES[item.kind].is_slide
        offset = f"{1e3 * abs(item.offset):.6g} mm" if slides else f"{degrees(abs(item.offset)):.6g}°"
        text += f" {'−' if item.offset < 0 else '+'} {offset}"
    return text


def _dead_weight(weight: AttachedBodiesFacts) -> list[str]:
    mass = UNKNOWN if weight.mass is None else quantity(weight.mass, MASSES)
    rows = [("links", ", ".join(weight.links)), ("mass", mass)]
    lines = [line for name, text in rows for line in wrapped(text, f"{name:8}")]
    return [*lines, *_hanging(weight.graph, "")]
