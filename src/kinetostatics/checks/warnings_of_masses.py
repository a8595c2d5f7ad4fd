"""Moving parts without mass: what a designer has drawn, or what holds the platform, and forgotten to weigh."""

from __future__ import annotations

from collections.abc import Iterable

from kinetostatics.checks.facts import RobotFacts
from kinetostatics.layout.numbers import join_words
from kinetostatics.math.graphs import joined
from kinetostatics.robot import Robot


def without_mass(robot: Robot, facts: RobotFacts) -> Iterable[str]:
    """Yield warnings of limbs, of the platform and of drawn bodies that weigh nothing, where anything else does.

    Links without shape may be massless: crosses of universal joints, frames, neglected sliders. So may those that say so, by an
    ``<inertial>`` with the mass 0 or a beam's density 0; beams that say nothing have a warning of their own.
    """
    if not facts.mass:  # said elsewhere, or not known
        return
    links = robot.description.links
    found = []
    platform = facts.on_platform
    if platform is not None and platform.mass == 0 and not any(links[name].has_inertial for name in platform.links):
        found += list(platform.links)
        yield "the platform has no mass: give its link an <inertial>"
    light = [
        limb
        for limb in facts.limbs
        if limb.mass == 0 and limb.links and not limb.beams and not any(links[name].has_inertial for name in limb.links)
    ]
    if light:
        weigh, have = ("weigh", "their links have") if light[1:] else ("weighs", "its links have")
        found += [name for limb in light for name in limb.links]
        yield f"{join_words([limb.name for limb in light])} {weigh} nothing: {have} no <inertial>"
    drawn = [name for name in _drawn_without_mass(robot, facts) if name not in found]
    if drawn:
        shape = "have shapes" if drawn[1:] else "has a shape"
        yield f"{join_words(drawn)} {shape} but no mass: an <inertial> is missing, with the mass 0 if that is meant"


def _drawn_without_mass(robot: Robot, facts: RobotFacts) -> list[str]:
    """Return the moving links with <visual> or <collision> whose body, all that is welded together, has no inertia given."""
    description, connections = robot.description, robot.mechanism.connections
    fixed = [joint for joint in connections.values() if joint.type.is_fixed]
    body = joined(description.links, ((joint.predecessor, joint.successor) for joint in fixed))
    elastic = {beam.link for beam in description.beams.values()}
    inside = {
        link
        for span in robot.topology.beams.values()
        for name in span.spanned
        for link in (connections[name].predecessor, connections[name].successor)
    }
    in_limbs = {name for limb in facts.limbs for name in limb.links}
    crosses = {name for name in in_limbs if not body[name] & set(facts.massless)}  # of compound joints; and what weighs
    weighs = elastic | inside | {description.base} | {name for name, link in description.links.items() if link.has_inertial}
    return [
        name
        for name, link in description.links.items()
        if ("<visual" in link.extra or "<collision" in link.extra) and name not in crosses and not body[name] & weighs
    ]
