"""Check of a robot: its properties, its warnings, and the errors that prevent an analysis."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.checks.chains import Graph, GraphReader
from kinetostatics.checks.diagnosis import (
    AttachedBodiesDiagnosis,
    Diagnosis,
    MobilityDiagnosis,
    ZeroDiagnosis,
    beam_diagnosis,
    elastic_joints,
    first_like,
    flexible_diagnosis,
    followers,
    limb_diagnosis,
    massless_links,
)
from kinetostatics.checks.input_warnings import warnings_of_file, warnings_of_zero
from kinetostatics.checks.local_freedoms import Motions, actuators_of, coordinates_of, local_freedoms
from kinetostatics.checks.redundancy import redundancies
from kinetostatics.exceptions import AssemblyError, KinetostaticsError, StaticsError
from kinetostatics.files.writer import kept_warnings
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.numbers import join_words
from kinetostatics.limbs.geometry import Basis
from kinetostatics.mechanism.limbs import AttachedBodies
from kinetostatics.results.result import Result
from kinetostatics.results.warnings import indeterminate_parts, near_singular_warnings, overload_warnings
from kinetostatics.robot import Robot

T = TypeVar("T")


def diagnose(robot: Robot) -> Diagnosis:
    """Return the properties of a robot; a property that cannot be computed is None, and ``problems`` lists the errors."""
    description = robot.description
    diagnosis = Diagnosis(robot.name, description.path, description.base, description.platform, actuators=description.actuated)
    diagnosis.warnings += [*description.warnings, *kept_warnings(description), *robot.topology.warnings]

    open_loops = False

    def attempt(compute: Callable[[], T]) -> T | None:
        nonlocal open_loops
        if open_loops:  # the other properties require closed loops, and each attempt to close them takes a second
            return None
        try:
            return compute()
        except KinetostaticsError as error:
            open_loops = isinstance(error, AssemblyError)
            if str(error) not in diagnosis.problems:
                diagnosis.problems.append(str(error))
            return None

    diagnosis.zero = ZeroDiagnosis({name: {"m": gap, "rad": angle} for name, (gap, angle) in robot.zero_loop_gaps.items()})
    if robot.wrong_zero is not None:
        diagnosis.problems.append(str(robot.wrong_zero))
        open_loops = True
    diagnosis.zero.closing_error = attempt(lambda: robot.closing_error)
    groups = attempt(lambda: robot.statics.groups)
    if groups is not None:
        diagnosis.mobility = attempt(lambda: _mobility(robot, diagnosis.zero))
    masses = attempt(lambda: robot.weights.masses(robot.zero_frames)[:, 0])
    diagnosis.inertia_warnings += description.inertia_warnings
    if masses is not None:
        diagnosis.mass = float(masses.sum())
        diagnosis.inertia_warnings += [f"{error}; modes and motions are refused" for error in robot.weights.impossible_inertias]

    def mass_of(owner: str) -> float | None:
        return None if masses is None else float(masses[robot.weights.of(owner)].sum())

    reader = GraphReader(robot.mechanism)
    diagnosis.limbs = [limb_diagnosis(robot, reader, limb, mass_of(limb.name)) for limb in robot.topology.limbs]
    labels = {joint: step.name for limb in diagnosis.limbs for step in limb.joints for joint in step.joints}
    diagnosis.beams = beam_diagnosis(robot, labels, attempt(lambda: robot.beams), attempt(lambda: robot.zero_frames))
    diagnosis.flexible = flexible_diagnosis(robot, attempt(lambda: robot.elastic_links), attempt(lambda: robot.zero_frames))
    diagnosis.mass_follows_pose = any(beam.telescopic and beam.density for beam in diagnosis.beams)
    bases: dict[str, Basis] = {}
    for group in groups or ():
        for position, which in enumerate(group.numbers):
            if which < len(diagnosis.limbs):
                diagnosis.limbs[which].constraint_wrenches = group.labels[position]
                diagnosis.limbs[which].attached_wrenches = group.attached_labels[position]
                bases[diagnosis.limbs[which].name] = group.basis
    alike: dict[tuple[object, ...], str] = {}
    for limb in diagnosis.limbs if groups is not None else ():
        limb.like = first_like(limb, bases[limb.name], diagnosis.beams, alike)
    diagnosis.massless = massless_links(robot, diagnosis.limbs)
    diagnosis.elastic_joints = elastic_joints(robot)
    diagnosis.springs = list(description.springs.values())
    diagnosis.followers = followers(robot)
    diagnosis.on_base = _attached_bodies(robot.topology.base, mass_of("base"), reader.attached(robot.topology, "base"))
    held = reader.attached(robot.topology, "platform")
    diagnosis.on_platform = _attached_bodies(robot.topology.platform, mass_of("platform"), held)
    diagnosis.zero.warnings += warnings_of_zero(robot, diagnosis)
    diagnosis.warnings += warnings_of_file(robot, diagnosis)
    if groups is not None and diagnosis.mobility is not None:
        warnings, at_zero, problems = warnings_of_statics(robot, diagnosis)
        diagnosis.warnings += warnings
        diagnosis.zero.warnings += at_zero
        diagnosis.problems += problems
    diagnosis.warnings += diagnosis.zero.warnings + diagnosis.inertia_warnings
    return diagnosis


def robot_warnings(robot: Robot) -> tuple[str, ...]:
    """Return the problems and warnings of a robot, without warnings that concern only the zero pose, or modes and motions."""
    diagnosis = diagnose(robot)
    others = {*diagnosis.zero.warnings, *diagnosis.inertia_warnings}
    return (*diagnosis.problems, *(text for text in diagnosis.warnings if text not in others))


# ---- parts -----------------------------------------------------------------------------------------------------------


def _mobility(robot: Robot, zero: ZeroDiagnosis) -> MobilityDiagnosis:
    mobility, motions = robot.mobility, Motions(robot)
    values = robot.solver.values(robot.actuator_coordinates, robot.zero_poses)[:, 0]
    zero.actuators = {name: float(value) for name, value in zip(motions.actuator_names, values, strict=True)}
    redundant_actuators, uncontrolled = actuators_of(motions)
    return MobilityDiagnosis(
        mobility.platform,
        mobility.local,
        mobility.redundant_constraints,
        mobility.gap,
        coordinates_of(motions),
        redundant_actuators,
        uncontrolled,
        local_freedoms(motions),
        redundancies(motions),
    )


def _attached_bodies(weight: AttachedBodies, mass: float | None, graph: Graph) -> AttachedBodiesDiagnosis:
    return AttachedBodiesDiagnosis(weight.links, tuple(edge.joint for edge in weight.edges if edge.joint), mass, graph)


#: Ratio of the smallest nonzero to the largest zero singular value below which a count is doubtful.
SMALL_GAP = 1e4
#: Beginning of warnings that concern only the zero pose.
AT_ZERO = "at the zero pose"


def warnings_of_statics(robot: Robot, diagnosis: Diagnosis) -> tuple[list[str], list[str], list[str]]:
    """Return (warnings, warnings of the zero pose, errors that prevent an analysis).

    The warnings concern doubtful ranks, redundant actuation, actuated joints outside limbs, and missing results.
    """
    warnings: list[str] = []
    at_zero: list[str] = []
    problems: list[str] = []
    if robot.mobility.gap < SMALL_GAP:
        warnings.append(
            f"the mobility is doubtful: the smallest singular value taken as nonzero is only {robot.mobility.gap:.2g} times the "
            "largest taken as zero"
        )
    for group in robot.statics.groups:
        if group.basis.gap < SMALL_GAP:
            warnings.append(
                f"the number of constraint wrenches of {group.limbs[0].name} is doubtful: the smallest singular value taken as "
                f"nonzero is only {group.basis.gap:.2g} times the largest taken as zero"
            )
    mobility = diagnosis.mobility
    if mobility is not None and mobility.redundant_actuators:
        count = len(diagnosis.actuators)
        held = count - mobility.redundant_actuators
        warnings.append(
            f"{count} actuators for {held} freedom{'s' * (held != 1)}: the actuation is redundant; actuators are "
            "locked in position and share the load according to the elasticity of their limbs (if the robot should have more "
            "freedoms, look for a wrong <axis>)"
        )
    for name in robot.actuators_outside_limbs:
        warnings.append(f"the actuated joint {name} is in no limb: it carries only bodies attached to {_owner(robot, name)}")
    generic = analyze(poses_of(robot, robot.generic_poses))
    zero = analyze(poses_of(robot, robot.zero_poses, first_only=True), on_failure="nan")
    problem = _statics_problem(robot, generic, zero)
    if problem is None and not diagnosis.actuators and robot.mobility.platform:
        warnings.append("the robot has no actuators: springs alone hold its platform; mark actuated joints by <transmission>")
    if problem is not None:
        (at_zero if problem.startswith(AT_ZERO) else problems).append(problem)
    else:
        at_zero += [text.replace("the pose is", "the zero pose is", 1) for text in near_singular_warnings(zero)]
        at_zero += [f"{AT_ZERO} {text}" for text in overload_warnings(zero)]
    warnings += missing_results(generic)
    at_zero += [text for text in missing_results(zero, f"{AT_ZERO} ") if text.removeprefix(f"{AT_ZERO} ") not in warnings]
    return warnings, at_zero, problems


def _owner(robot: Robot, joint: str) -> str:
    for limb in robot.topology.limbs:
        if any(edge.joint == joint for edge in limb.branches):
            return limb.name
    return "the platform" if any(edge.joint == joint for edge in robot.topology.platform.edges) else "the base"


def _statics_problem(robot: Robot, generic: Result, zero: Result) -> str | None:
    """Return the reason why the statics fails at all generic poses or at the zero pose; None if it does not fail.

    If it fails only at the zero pose, the reason begins with :data:`AT_ZERO`.
    """
    if not robot.mechanism.tree.nq:  # nothing moves: there is one pose only
        return _complaint(zero)
    if np.all(np.isnan(generic.twist)):
        problem = _complaint(analyze(poses_of(robot, robot.generic_poses, first_only=True), on_failure="nan"))
        return problem or "no pose could be analysed: the loops do not close at any of the poses tried"
    problem = _complaint(zero)
    return None if problem is None else f"{AT_ZERO} {problem}"


def _complaint(result: Result) -> str | None:
    """Return the reason why the statics fails at a reached pose; None if it does not fail."""
    if result.configuration.reached.all() and np.any(np.isnan(result.twist)):
        try:
            analyze(result.configuration)
        except StaticsError as error:
            return str(error)
    return None


def missing_results(result: Result, where: str = "") -> list[str]:
    """Return warnings of missing results; ``where`` names the pose, or is empty for generic poses."""
    texts = [where + indeterminate_parts(result)] if np.any(result.indeterminate) else []
    bad = {
        limb.name
        for solution in result.solutions
        for statics in solution.statics
        for position, limb in enumerate(statics.group.limbs)
        if np.any(statics.degenerate[position])
    }
    limbs = [limb.name for limb in result.robot.topology.limbs if limb.name in bad]
    if limbs and np.any(result.basis_degenerate):
        at = where or "at some poses "
        texts.append(f"{at}the wrench basis of {join_words(limbs)} is not unique: intensities are NaN there, all else is valid")
    return texts


def poses_of(robot: Robot, poses: SolverState, first_only: bool = False) -> Configuration:
    """Return solver poses as a configuration, or the first pose only if ``first_only``.

    Loop gaps due to rounded numbers in the file are tolerated.
    """
    q = robot.model_q(poses).T
    return robot.configuration(q[0] if first_only else q, closure_tolerance=1e-9 + 1e3 * robot.closing_error, on_failure="nan")
