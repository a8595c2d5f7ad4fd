"""What a person reads of a robot: ``print(robot)`` and ``kinetostatics check``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinetostatics.report_facts import (
    CLOSED,
    SMALL_GAP,
    BeamFacts,
    DeadWeightFacts,
    LimbFacts,
    RobotFacts,
    robot_facts,
)
from kinetostatics.report_text import (
    MASSES,
    MISSING,
    Scale,
    quantity,
    section,
    table,
    warning_lines,
    wrapped,
)

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

UNKNOWN = "not known"


def robot_report(robot: Robot) -> str:
    """Return what there is to know about a robot: mobility, masses, limbs, beams and warnings.

    A robot whose loops cannot be closed still gets a report, which says so.
    """
    return facts_report(robot_facts(robot))


def facts_report(facts: RobotFacts) -> str:
    """Write the facts about a robot down."""
    lines = [f"Robot {facts.name!r}", *(f"  {line}" for line in _summary(facts))]
    lines += section("Limbs, from base to platform", _limbs(facts.limbs))
    if facts.beams:
        lines += section("Beams, at the zero pose", _beams(facts))
    for where, weight in (("base", facts.on_base), ("platform", facts.on_platform)):
        if weight is not None:
            lines += section(f"On the {where}", _dead_weight(weight))
    if facts.problems:
        lines += section("Cannot be analysed", [line for item in facts.problems for line in wrapped(item, "! ")])
    lines += warning_lines(facts.warnings)
    return "\n".join(lines)


def _summary(facts: RobotFacts) -> list[str]:
    rows = [
        ("file", facts.file),
        ("base", facts.base),
        ("platform", facts.platform),
        ("mobility", facts.mobility or UNKNOWN),
        ("redundant constraints", _redundancy(facts)),
        ("drives", _drives(facts)),
        ("mass", _mass(facts)),
        ("zero pose", _closing(facts)),
    ]
    width = max(len(name) for name, _ in rows)
    return [line for name, text in rows for line in wrapped(text, f"{name:{width}}  ")]


def _redundancy(facts: RobotFacts) -> str:
    if facts.redundant_constraints is None:
        return UNKNOWN
    text = f"{facts.redundant_constraints}"
    text += " (overconstrained)" if facts.redundant_constraints else " (not overconstrained)"
    gap = facts.singular_value_gap
    if gap is not None and gap < SMALL_GAP:
        text += f", doubtful: gap of singular values only {gap:.2g}"
    return text


def _drives(facts: RobotFacts) -> str:
    return f"{len(facts.drives)}: {', '.join(facts.drives)}" if facts.drives else "none"


def _mass(facts: RobotFacts) -> str:
    if facts.mass is None:
        return UNKNOWN
    text = f"{quantity(facts.mass, MASSES)} at the zero pose"
    return text + (", telescopic beams' masses follow the pose" if facts.mass_follows_pose else "")


def _closing(facts: RobotFacts) -> str:
    if facts.closing_error is None:
        return "the loops do not close"
    if facts.closing_error <= CLOSED:
        return "the loops close"
    return f"the loops stay open by {facts.closing_error:.2g} (m or rad)"


def _limbs(limbs: list[LimbFacts]) -> list[str]:
    if not limbs:
        return ["none"]
    lines: list[str] = []
    for limb in limbs:
        lines += [""] * bool(lines)
        mass = UNKNOWN if limb.mass is None else quantity(limb.mass, MASSES)
        lines.append(f"{limb.name}: {limb.word}")
        rows = [
            ("links", ", ".join(limb.links) or "none"),
            ("joints", ", ".join(_joint(joint.name, joint.joints) for joint in limb.joints) or "none"),
            ("beams", ", ".join(limb.beams) or "none: rigid"),
            ("mass", mass),
        ]
        if limb.branches:
            rows.append(("dangling", ", ".join(limb.branches)))
        rows += _wrenches("constraint", limb.constraint_wrenches)
        rows += _wrenches("attached", limb.attached_wrenches)
        lines += [line for name, text in rows for line in wrapped(text, f"  {name:11}")]
    return lines


def _joint(name: str, joints: tuple[str, ...]) -> str:
    return name if joints == (name,) else f"{name} ({' '.join(joints)})"


def _wrenches(kind: str, labels: tuple[str, ...] | None) -> list[tuple[str, str]]:
    if labels is None:
        return [(kind, UNKNOWN)]
    return [(kind if k == 0 else "", label) for k, label in enumerate(labels or ("none",))]


def _beams(facts: RobotFacts) -> list[str]:
    beams = facts.beams
    length = Scale.of([beam.length or 0.0 for beam in beams], (("mm", 1e-3),))
    mass = Scale.of([beam.mass or 0.0 for beam in beams], MASSES)
    rows = [
        (
            beam.name,
            beam.section,
            MISSING if beam.length is None else length(beam.length),
            "telescopic" if beam.telescopic else "",
            f"{beam.youngs_modulus / 1e9:.5g}",
            f"{beam.shear_modulus / 1e9:.5g}",
            _density(beam),
            MISSING if beam.mass is None else mass(beam.mass),
        )
        for beam in beams
    ]
    header = (
        "beam",
        "section",
        f"length [{length.unit}]",
        "",
        "E [GPa]",
        "G [GPa]",
        "ρ [kg/m³]",
        f"mass [{mass.unit}]",
    )
    return table(header, rows, "llrlrrrr")


def _density(beam: BeamFacts) -> str:
    return "link's mass" if beam.density is None else f"{beam.density:.6g}"


def _dead_weight(weight: DeadWeightFacts) -> list[str]:
    mass = UNKNOWN if weight.mass is None else quantity(weight.mass, MASSES)
    rows = [("links", ", ".join(weight.links)), ("mass", mass)]
    if weight.joints:
        rows.append(("joints", ", ".join(weight.joints)))
    return [line for name, text in rows for line in wrapped(text, f"{name:8}")]
