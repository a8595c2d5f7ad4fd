"""Warnings of probable input errors (sizes, materials, masses, stiffnesses), and of beams too stubby for beam theory."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from math import isinf

import numpy as np

from kinetostatics.checks.diagnosis import BeamDiagnosis, Diagnosis, ElasticJointDiagnosis
from kinetostatics.description.joint_types import JOINT_TYPES, Axes
from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.kinematics.loop_gaps import CLOSED
from kinetostatics.kinematics.zero_pose import corrections_hint
from kinetostatics.layout.numbers import LENGTHS, join_words, quantity
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import EQUAL
from kinetostatics.mechanism.beam_geometry import ends_nowhere
from kinetostatics.mechanism.body_graph import BodyGraph, RigidBody
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.robot import Robot
from kinetostatics.unit_hints import length_hint, limit_hints

#: Ratio of length to depth below which beam theory is doubtful, because end effects dominate.
STUBBY = 5.0
#: Ratio of length to depth above which the units of a section are probably wrong.
WIRE = 2000.0
#: Smallest large gap of loops with all joints at zero: ratio to the characteristic length, or angle [rad].
FAR = 0.1
#: Ratio of a beam's mass by density to the mass in its link's <inertial> above which they are inconsistent.
OTHER_MASS = 1.3
#: Plausible thermal expansion of solids [1/K].
EXPANSIONS = (-2e-5, 1e-3)
#: Largest dimensions of robots [m].
SIZES = (1e-3, 100.0)
#: Largest plausible displacement of an elastic joint under the robot's weight [m, rad]; largest plausible stiffness [N/m,
#: N·m/rad].
GIVES, RIGID = (0.01, 0.2), 1e12
#: Radius of a joint with a stiffness matrix, by the robot's length, above which the units of its entries are doubted.
LEVER = 3


def warnings_of_file(robot: Robot, diagnosis: Diagnosis) -> list[str]:
    """Return warnings of a robot that do not require statics."""
    warnings = [*_closing(robot, diagnosis), *_sizes(robot, diagnosis), *_stubby(robot, diagnosis)]
    warnings += [*_materials(diagnosis), *_masses(robot, diagnosis)]
    warnings += [*_without_mass(robot, diagnosis), *_elastic_joints(robot, diagnosis)]
    warnings += [
        f"link {link!r} ends nowhere: {joint!r} is its only joint and connects it to the base; if it is part of a limb, a "
        "<loop> is missing or a <parent> is wrong"
        for link, joint in ends_nowhere(robot.mechanism)
        if link in robot.topology.base.links
    ]
    rigid = [limb for limb in diagnosis.limbs if limb.rigid]
    if len(rigid) < len(diagnosis.limbs):
        for limb in rigid:
            joints, held = (join_words(names) for names in ([step.name for step in limb.joints], limb.constraint_wrenches or ()))
            why = (
                f": it holds the platform by {held} without sag there; for a number, give a joint a <joint_stiffness> or a link "
            )
            warnings.append(f"{limb.name} ({joints}) has no elastic part and counts as rigid{f'{why}a <beam>' if held else ''}")
    elif rigid:
        verb = "have no elastic parts and count" if rigid[1:] else "has no elastic parts and counts"
        warnings.append(f"{join_words([limb.name for limb in rigid])} {verb} as rigid")
    if not diagnosis.limbs:
        warnings.append("no limb joins base and platform")
    return warnings


def warnings_of_zero(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    """Yield warnings of the zero pose that do not require statics."""
    zero = diagnosis.zero
    if zero.closing_error is None:
        return
    if zero.closing_error > CLOSED:
        yield (
            f"the loops stay open by {zero.closing_error:.2g} (m or rad) at the zero pose: the file's angles or lengths are "
            "probably rounded; write them with full precision, as ${pi/2} in xacro"
            + (", or assemble with a larger closure_tolerance" if robot.zero_is_near else "")
        )
    moved = [f"{name} at {_coordinate(robot, name, v)}" for name, v in (zero.actuators or {}).items() if abs(v) > 1e-9]
    if moved:
        yield (
            "the loops do not close with the actuators at zero; the zero pose, the start of all searches, has "
            f"{join_words(moved)}"
        )
    yield from _limits(robot, diagnosis)


def _closing(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    zero = diagnosis.zero
    if zero.closing_error is None:
        return
    metres, radians = zero.widest("m"), zero.widest("rad")
    if metres[0] > FAR * robot.length or radians[0] > FAR:
        yield (
            f"where all joints are at zero the loops are far from closed: {zero_loop_gaps(diagnosis)}. "
            + (
                "Angles in degrees would explain this: see the other warnings"
                if robot.description.angle_hints()
                else "The search from there may find the wrong assembly mode: then move the zero of the joints so that the loops "
                "nearly close there"
            )
        )
    hint = None if robot.zero_is_near else corrections_hint(robot.mechanism, robot.size)
    if hint:
        yield hint


def _coordinate(robot: Robot, joint: str, value: float) -> str:
    """Return a joint's coordinate [m, rad] as text in mm or degrees."""
    slides = robot.mechanism.connections[joint].type.is_slide
    return f"{1e3 * value:.4g} mm" if slides else f"{np.degrees(value):.4g}°"


def zero_loop_gaps(diagnosis: Diagnosis) -> str:
    """Return the gaps of the loops, with all joints at zero, as text; loops with equal gaps are grouped."""
    alike: dict[str, list[str]] = {}
    for name, gap in diagnosis.zero.loop_gaps.items():
        sizes = [quantity(float(f"{gap['m']:.6g}"), LENGTHS, digits=4)] if gap["m"] > 1e-9 else []
        sizes += [f"{np.degrees(gap['rad']):.4g}°"] if gap["rad"] > 1e-9 else []
        if sizes:
            alike.setdefault(" and ".join(sizes), []).append(name)
    return "open by " + ", ".join(f"{size} at {join_words(names, len(names))}" for size, names in alike.items())


def _limits(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    if diagnosis.zero.actuators is None or not robot.mechanism.tree.nq:
        return
    try:
        pose = robot.configuration(robot.model_q(robot.zero_poses)[:, 0], closure_tolerance=1e-9 + 1e3 * robot.closing_error)
    except KinetostaticsError:  # reported elsewhere
        return
    beyond = [f"{name} ({_coordinate(robot, name, float(exceeded.value))})" for name, exceeded in pose.limits_exceeded.items()]
    if beyond:
        yield f"at the zero pose {join_words(beyond)} {'are beyond their' if beyond[1:] else 'is beyond its'} limits"


def _sizes(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    if diagnosis.zero.closing_error is None:
        return
    size = robot.zero_size
    if size and not SIZES[0] < size < SIZES[1]:
        yield f"the robot is {size:.4g} m large; write lengths in m, moduli in Pa and densities in kg/m³, not in units of mm"
    slides = [slide for slide in robot.mechanism.connections.values() if slide.type.is_slide]
    limits = {slide.name: [abs(limit) for limit in (slide.lower, slide.upper) if math.isfinite(limit)] for slide in slides}
    yield from limit_hints({name: max(sizes) for name, sizes in limits.items() if sizes}, size)
    for name, spring in robot.description.springs.items():
        what = f"the free length of spring {name!r} is {spring.free_length:.6g} m,"
        yield from length_hint(what, spring.free_length, robot.size)


# ---- beams -----------------------------------------------------------------------------------------------------------


def _warnings_of_beams(beams: Iterable[BeamDiagnosis], text_of: Callable[[BeamDiagnosis], str | None]) -> Iterable[str]:
    """Yield warnings of beams; beams with equal texts share one warning."""
    same: dict[str, list[str]] = {}
    for beam in beams:
        text = text_of(beam)
        if text is not None:
            same.setdefault(text, []).append(beam.name)
    for text, names in same.items():
        yield f"beam{'s' * (len(names) > 1)} {join_words(names, 8)}: {text}"


def _stubby(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    members = _members(robot, diagnosis)

    def text_of(beam: BeamDiagnosis) -> str | None:
        if beam.length is None:
            return None
        length, depth = members[beam.name]
        long, thick = (quantity(size, LENGTHS, digits=4) for size in (length, depth))
        if depth > 20 * length:
            return f"thicker ({thick}) than long ({long}); sizes are in m"
        if length < STUBBY * depth * (1 - 1e-9):
            times = float(f"{length / depth:.6g}")  # rounded, so that equal beams have equal texts
            return f"the length of {long} is only {times:.2g} times the depth; beam theory is doubtful below {STUBBY:g}"
        if length > WIRE * depth:
            return f"{length / depth:.2g} times as long as thick ({thick}); sizes are in m"
        return None

    return _warnings_of_beams(diagnosis.beams, text_of)


def _members(robot: Robot, diagnosis: Diagnosis) -> dict[str, tuple[float, float]]:
    """Return for each beam the length and depth [m] of its member.

    A member is a row of beams of about the same direction, welded or connected by actuated prismatic joints.
    """
    graph, frames = BodyGraph(robot.mechanism), robot.zero_frames if diagnosis.zero.closing_error is not None else None
    beams = {beam.name: beam for beam in diagnosis.beams}
    if frames is None:
        return {name: (beam.length or 0.0, beam.depth) for name, beam in beams.items()}
    locked = [edge.ends for edge in graph.edges if edge.connection is not None and _is_locked(edge.connection)]
    together = joined(graph.bodies, locked)
    ends: dict[frozenset[RigidBody], list[tuple[str, np.ndarray]]] = {}
    for edge in graph.edges:
        if edge.span is not None and edge.span.part.name in beams:
            name, span = edge.span.part.name, edge.span
            along = (frames.point(span.end_body, span.end) - frames.point(span.start_body, span.start))[:, 0]
            along /= max(float(np.linalg.norm(along)), 1e-300)
            ends.setdefault(together[edge.ends[0]], []).append((name, along))
            ends.setdefault(together[edge.ends[1]], []).append((name, -along))
    pairs = [here for here in ends.values() if len(here) == 2 and float(here[0][1] @ here[1][1]) < -np.sqrt(0.5)]
    members = joined(beams, ((first, second) for (first, _), (second, _) in pairs))
    return {
        name: (sum(beams[k].length or 0.0 for k in beams if k in names), max(beams[k].depth for k in names))
        for name, names in members.items()
    }


def _is_locked(joint: Connection) -> bool:
    """Whether a joint is fixed, or prismatic and actuated, and so transmits bending."""
    return joint.type.is_fixed or (joint.type.is_slide and joint.actuated)


def _materials(diagnosis: Diagnosis) -> Iterable[str]:
    def modulus(beam: BeamDiagnosis) -> str | None:
        young, shear = beam.youngs_modulus, beam.shear_modulus
        if 1 <= young / shear <= 1000:
            return None
        return f"the shear modulus of {shear:.4g} Pa and the Young's modulus of {young:.4g} Pa are inconsistent"

    def expansion(beam: BeamDiagnosis) -> str | None:
        if not EXPANSIONS[0] <= beam.thermal_expansion <= EXPANSIONS[1]:
            return f"the thermal expansion of {beam.thermal_expansion:.4g} 1/K is improbable; steel has 1.2e-5 1/K"
        return None

    for text_of in (modulus, expansion):
        yield from _warnings_of_beams(diagnosis.beams, text_of)


# ---- masses and joints -----------------------------------------------------------------------------------------------


def _masses(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    links = robot.description.links
    by_link: dict[str, list[BeamDiagnosis]] = {}
    for beam in diagnosis.beams:
        by_link.setdefault(beam.link, []).append(beam)

    def text_of(beam: BeamDiagnosis) -> str | None:
        beams, given = by_link[beam.link], links[beam.link].mass
        if beam is not beams[0] or beam.density is None or beam.mass is None or not given:
            return None
        weight = sum(other.mass or 0.0 for other in beams)
        if max(weight, given) <= OTHER_MASS * min(weight, given) * (1 + EQUAL):
            return None
        if weight == 0:
            return f"no mass, because the density is 0, but the <inertial> of the link has {given:.4g} kg"
        return (
            f"the mass of {weight:.4g} kg by the density replaces the {given:.4g} kg of the link's <inertial>; to distribute the "
            "latter along the beam, leave the density out; give additional bodies a link of their own"
        )

    yield from _warnings_of_beams(diagnosis.beams, text_of)
    if diagnosis.mass == 0:
        yield "nothing in the file has a mass"


def _without_mass(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    """Yield warnings of limbs, platform and drawn bodies without mass, if other parts have mass.

    There is no warning for links without a shape (crosses of universal joints, frames, tools of arms, light sliders), for links
    with the mass 0 in ``<inertial>``, and for beams of density 0. Beams without data on their mass have a warning of their own.
    """
    if not diagnosis.mass:  # reported elsewhere, or unknown
        return
    links = robot.description.links
    named = []
    platform = diagnosis.on_platform
    is_tool = not robot.description.loops
    if (
        platform is not None
        and platform.mass == 0
        and not is_tool
        and not any(links[name].has_inertial for name in platform.links)
    ):
        named += list(platform.links)
        yield "the platform has no mass: give its link an <inertial>"
    light = [
        limb
        for limb in diagnosis.limbs
        if limb.mass == 0 and limb.links and not limb.beams and not any(links[name].has_inertial for name in limb.links)
    ]
    if light:
        weigh, have = ("weigh", "their links have") if light[1:] else ("weighs", "its links have")
        named += [name for limb in light for name in limb.links]
        yield f"{join_words([limb.name for limb in light])} {weigh} nothing: {have} no <inertial>"
    drawn = [name for name in _drawn_without_mass(robot, diagnosis) if name not in named]
    if drawn:
        shape = "have shapes" if drawn[1:] else "has a shape"
        yield f"{join_words(drawn)} {shape} but no mass: add an <inertial>, with the mass 0 if it is massless"


def _drawn_without_mass(robot: Robot, diagnosis: Diagnosis) -> list[str]:
    """Return the moving links with <visual> or <collision> in rigid bodies (welded links) without any <inertial>."""
    description, connections = robot.description, robot.mechanism.connections
    fixed = [joint for joint in connections.values() if joint.type.is_fixed]
    body = joined(description.links, ((joint.predecessor, joint.successor) for joint in fixed))
    elastic = {link.link for link in description.elastic_links.values()}
    inside = {
        link
        for span in robot.topology.spans.values()
        for name in span.spanned
        for link in (connections[name].predecessor, connections[name].successor)
    }
    in_limbs = {name for limb in diagnosis.limbs for name in limb.links}
    crosses = {name for name in in_limbs if not body[name] & set(diagnosis.massless)}  # of compound joints; and what weighs
    weighs = elastic | inside | {description.base} | {name for name, link in description.links.items() if link.has_inertial}
    return [
        name
        for name, link in description.links.items()
        if ("<visual" in link.extra or "<collision" in link.extra) and name not in crosses and not body[name] & weighs
    ]


def _elastic_joints(robot: Robot, diagnosis: Diagnosis) -> Iterable[str]:
    weight = 9.81 * (diagnosis.mass or 0.0)
    for joint in diagnosis.elastic_joints:
        for words, value, unit, turns in _constrained_stiffnesses(robot, joint):
            force = weight * robot.length if turns else weight
            if value > RIGID:
                yield f"{words} is {value:.3g} {unit}, more than that of any real joint; write inf for rigid"
            elif force / value > GIVES[turns]:
                gives = f"{np.degrees(force / value):.3g}°" if turns else quantity(force / value, LENGTHS, digits=3)
                lever = f" at a distance of {quantity(robot.length, LENGTHS, digits=3)}" if turns else ""
                yield (
                    f"{words} is {value:.3g} {unit}: the robot's own weight of {weight:.4g} N{lever} would move it by {gives}; "
                    f"stiffnesses are in {unit}"
                )
        along, about = ([value for value in values if not isinf(value)] for values in (joint.linear, joint.angular))
        if robot.description.joint_stiffness[joint.joint].matrix and along and about:
            radius = float(np.sqrt(min(about) / max(along)))
            if radius > LEVER * robot.length:
                at = f"as at a radius of {quantity(radius, LENGTHS, digits=3)}"
                yield (
                    f"the matrix of {joint.joint} has {max(along):.3g} N/m in Fx Fy Fz and {min(about):.3g} N·m/rad in Mx My Mz, "
                    f"{at}; in N/mm and N·mm/rad, each is wrong by a factor of 1e3"
                )


def _constrained_stiffnesses(robot: Robot, joint: ElasticJointDiagnosis) -> Iterable[tuple[str, float, str, int]]:
    """Yield a joint's stiffnesses in its constrained directions: name, value, unit, and whether the direction is a rotation."""
    passive = robot.mechanism.connections[joint.joint]
    free = _free_axes(passive)
    for turns, (values, unit) in enumerate(((joint.linear, "N/m"), (joint.angular, "N·m/rad"))):
        for axis, value in zip("xyz", values, strict=True):
            if not isinf(value) and (turns, axis) not in free:
                yield f"the stiffness of {joint.joint} {'about' if turns else 'along'} {axis}", value, unit, turns
    if joint.drive is not None:
        slides = JOINT_TYPES[joint.kind].is_slide
        yield f"the stiffness of the actuator of {joint.joint}", joint.drive, "N/m" if slides else "N·m/rad", int(not slides)


def _free_axes(joint: Connection) -> set[tuple[int, str]]:
    """Return the free axes of a joint's frame: (0, axis) for translations, (1, axis) for rotations."""
    near = {axis for axis, part in zip("xyz", joint.axis, strict=True) if abs(float(part)) > 0.1}
    axes = {Axes.NONE: set(), Axes.AXIS: near}
    return {(0, axis) for axis in axes.get(joint.type.slides, "xyz")} | {(1, axis) for axis in axes.get(joint.type.turns, "xyz")}
