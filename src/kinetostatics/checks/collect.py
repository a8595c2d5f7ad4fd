"""Properties of a robot, gathered so that an error in one part does not hide the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from kinetostatics.checks import part_facts
from kinetostatics.checks.chains import Graph
from kinetostatics.checks.facts import AttachedBodiesFacts, MobilityFacts, RobotFacts, ZeroFacts
from kinetostatics.checks.input_warnings import warnings_of_file, warnings_of_zero
from kinetostatics.checks.limb_graph import GraphReader
from kinetostatics.checks.local_freedoms import Motions, actuators_of, coordinates_of, local_freedoms
from kinetostatics.checks.redundancy import redundancies
from kinetostatics.checks.warnings_of_statics import warnings_of_statics
from kinetostatics.exceptions import AssemblyError, KinetostaticsError
from kinetostatics.limbs.geometry import Basis
from kinetostatics.mechanism.limbs import AttachedBodies
from kinetostatics.robot import Robot

T = TypeVar("T")


def robot_facts(robot: Robot) -> RobotFacts:
    """Return the properties of a robot; errors become problems."""
    description = robot.description
    facts = RobotFacts(robot.name, description.path, description.base, description.platform, drives=description.driven)
    facts.warnings += [*description.warnings, *robot.topology.warnings]

    open_loops = False

    def attempt(compute: Callable[[], T]) -> T | None:
        nonlocal open_loops
        if open_loops:  # the other properties need a closed pose, and every attempt takes a second
            return None
        try:
            return compute()
        except KinetostaticsError as error:
            open_loops = isinstance(error, AssemblyError)
            if str(error) not in facts.problems:
                facts.problems.append(str(error))
            return None

    facts.zero = ZeroFacts({name: {"m": metres, "rad": radians} for name, (metres, radians) in robot.zero_loop_gaps.items()})
    if robot.wrong_zero is not None:
        facts.problems.append(str(robot.wrong_zero))
        open_loops = True
    facts.zero.closing_error = attempt(lambda: robot.closing_error)
    groups = attempt(lambda: robot.statics.groups)
    if groups is not None:
        facts.mobility = attempt(lambda: _mobility(robot, facts.zero))
    masses = attempt(lambda: robot.weights.masses(robot.zero_frames)[:, 0])
    if masses is not None:
        facts.mass = float(masses.sum())

    def mass_of(owner: str) -> float | None:
        return None if masses is None else float(masses[robot.weights.of(owner)].sum())

    reader = GraphReader(robot.mechanism)
    facts.limbs = [part_facts.limb_facts(robot, reader, limb, mass_of(limb.name)) for limb in robot.topology.limbs]
    labels = {joint: step.name for limb in facts.limbs for step in limb.joints for joint in step.joints}
    facts.beams = part_facts.beam_facts(robot, labels, attempt(lambda: robot.beams), attempt(lambda: robot.zero_frames))
    facts.mass_follows_pose = any(beam.telescopic and beam.density for beam in facts.beams)
    bases: dict[str, Basis] = {}
    for group in groups or ():
        for position, which in enumerate(group.numbers):
            if which < len(facts.limbs):
                facts.limbs[which].constraint_wrenches = group.labels[position]
                facts.limbs[which].attached_wrenches = group.attached_labels[position]
                bases[facts.limbs[which].name] = group.basis
    alike: dict[tuple[object, ...], str] = {}
    for limb in facts.limbs if groups is not None else ():
        limb.like = part_facts.first_like(limb, bases[limb.name], facts.beams, alike)
    facts.massless = part_facts.massless_links(robot, facts.limbs)
    facts.elastic_joints = part_facts.elastic_joints(robot)
    facts.springs = list(description.springs.values())
    facts.followers = part_facts.followers(robot)
    facts.on_base = _attached_bodies(robot.topology.base, mass_of("base"), reader.dead_weight(robot.topology, "base"))
    held = reader.dead_weight(robot.topology, "platform")
    facts.on_platform = _attached_bodies(robot.topology.platform, mass_of("platform"), held)
    facts.zero.warnings += warnings_of_zero(robot, facts)
    facts.warnings += warnings_of_file(robot, facts)
    if groups is not None and facts.mobility is not None:
        warnings, at_zero, problems = warnings_of_statics(robot, facts)
        facts.warnings += warnings
        facts.zero.warnings += at_zero
        facts.problems += problems
    facts.warnings += facts.zero.warnings
    return facts


def robot_warnings(robot: Robot) -> tuple[str, ...]:
    """Return the errors that prevent analyses at most poses, and the warnings that apply to all poses."""
    facts = robot_facts(robot)
    return (*facts.problems, *(text for text in facts.warnings if text not in facts.zero.warnings))


# ---- parts -----------------------------------------------------------------------------------------------------------


def _mobility(robot: Robot, zero: ZeroFacts) -> MobilityFacts:
    found, motions = robot.mobility, Motions(robot)
    values = robot.solver.values(robot.actuator_coordinates, robot.zero_poses)[:, 0]
    zero.drives = {name: float(value) for name, value in zip(motions.actuator_names, values, strict=True)}
    counts = found.platform, found.local, found.redundant_constraints, found.gap
    held = coordinates_of(motions), *actuators_of(motions)
    return MobilityFacts(*counts, *held, local_freedoms(motions), redundancies(motions))


def _attached_bodies(weight: AttachedBodies, mass: float | None, graph: Graph) -> AttachedBodiesFacts:
    return AttachedBodiesFacts(weight.links, tuple(edge.joint for edge in weight.edges if edge.joint), mass, graph)
